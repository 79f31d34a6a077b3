#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What fills the links of the robots of a fleet: kbit/s by kind of RTPS submessage and topic.

    traffic.py record FILE          all frames, until SIGTERM; where the bridge is (fleet.start_recording)
    traffic.py count FILE [SINCE]   a table, of what came SINCE seconds after the first frame

A frame counts once for each robot's link that it passes, as on a shared channel. The submessages of a
datagram share its bytes by their lengths. Topics are known from the discovery that was recorded before.
"""

import collections
import signal
import socket
import struct
import sys
import time

LINKS = "to_robot_"
ALL_PROTOCOLS = 3  # ETH_P_ALL
RECEIVE_BUFFER_FORCE = 33  # SO_RCVBUFFORCE
HEAD = struct.Struct("<dII")  # of a frame in the file: time, its bytes, those that follow
LONGEST = 2048  # bytes of a frame that are kept
SHOWN = 40  # lines

# RTPS 2.2, 9.4.5, and DDS Security 1.1, 7.3.6
KINDS = {0x15: "data", 0x16: "data", 0x07: "heartbeat", 0x13: "heartbeat", 0x06: "acknack",
         0x12: "acknack", 0x08: "gap", 0x31: "secured"}
DATA, DATA_FRAG, INFO_DESTINATION = 0x15, 0x16, 0x0E
PUBLICATIONS, SUBSCRIPTIONS = 0x000003C2, 0x000004C2
BUILT_IN = {0x000100C2: "participants", PUBLICATIONS: "publications",
            SUBSCRIPTIONS: "subscriptions", 0x000200C2: "liveliness"}
TOPIC_NAME, ENDPOINT_GUID, SENTINEL = 0x0005, 0x005A, 0x0001


def record(path):
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ALL_PROTOCOLS)) as listener, \
            open(path, "wb") as out:
        listener.setsockopt(socket.SOL_SOCKET, RECEIVE_BUFFER_FORCE, 64 * 1024 * 1024)
        while True:
            frame, (name, *_) = listener.recvfrom(65536)
            if name.startswith(LINKS):
                kept = frame[:LONGEST]
                out.write(HEAD.pack(time.monotonic(), len(frame), len(kept)) + kept)


def frames(path):
    """(time, bytes, the first of them) of each frame."""
    with open(path, "rb") as stream:
        while len(head := stream.read(HEAD.size)) == HEAD.size:
            moment, size, kept = HEAD.unpack(head)
            yield moment, size, stream.read(kept)


def rtps_message(frame):
    """In a frame of Ethernet, IPv4 and UDP; None where there is none."""
    if len(frame) < 34 or frame[12:14] != b"\x08\x00" or frame[23] != socket.IPPROTO_UDP:
        return None
    message = frame[14 + 4 * (frame[14] & 15) + 8:]
    return message if message[:4] == b"RTPS" else None


def submessages(message):
    """(kind, content, destination) of each."""
    place, destination = 20, b""
    while place + 4 <= len(message):
        kind, flags, length = struct.unpack_from("<BBH", message, place)
        if not flags & 1:
            length = struct.unpack_from(">H", message, place + 2)[0]
        content = message[place + 4:place + 4 + length] if length else message[place + 4:]
        if kind == INFO_DESTINATION:
            destination = content[:12]
        yield kind, content, destination
        place += 4 + len(content)


def writer_of(kind, content):
    return struct.unpack_from(">I", content, 8 if kind in (DATA, DATA_FRAG) else 4)[0]


def discovered(content):
    """(GUID, topic) of the endpoint that a DATA of the discovery tells of; None where there is none."""
    found = {}
    place = 4 + struct.unpack_from("<H", content, 2)[0]
    if content[place:place + 2] == b"\x00\x03":  # PL_CDR_LE, without inline QoS before it
        place += 4
    while place + 4 <= len(content):
        parameter, length = struct.unpack_from("<HH", content, place)
        if parameter == SENTINEL:
            place += 8  # of the inline QoS, and the head of the payload behind it
            continue
        found[parameter] = content[place + 4:place + 4 + length]
        place += 4 + length
    name = found.get(TOPIC_NAME)
    guid = found.get(ENDPOINT_GUID)
    if not name or not guid:
        return None
    return guid, name[4:3 + struct.unpack_from("<I", name)[0]].decode(errors="replace")


def of_any_robot(topic):
    return "/".join("ROBOT" if part.startswith("robot_") else part for part in topic.split("/"))


def count(path, since):
    """{(kind, topic): [bytes, submessages]}, and the seconds that were looked at."""
    topics, counted = {}, collections.defaultdict(lambda: [0.0, 0])
    begin = last = None
    for moment, size, frame in frames(path):
        begin = moment + since if begin is None else begin
        last = moment
        message = rtps_message(frame)
        parts = []
        for kind, content, destination in submessages(message) if message else ():
            if kind not in KINDS or len(content) < 12:
                continue
            writer = writer_of(kind, content)
            if kind == DATA and writer in (PUBLICATIONS, SUBSCRIPTIONS):
                if endpoint := discovered(content):
                    topics[endpoint[0]] = of_any_robot(endpoint[1])
            # An answer names the writer of whom it goes to.
            owner = destination if KINDS[kind] == "acknack" else message[8:20]
            name = BUILT_IN.get(writer) or topics.get(owner + struct.pack(">I", writer), "?")
            parts.append((KINDS[kind], name, len(content)))
        if moment < begin:
            continue
        parts = parts or [("other", "", 1)]
        whole = sum(length for _, _, length in parts)
        for kind, name, length in parts:
            entry = counted[kind, name]
            entry[0] += size * length / whole
            entry[1] += 1
    if not counted or last <= begin:
        sys.exit(f"{path}: no frames {since:g} s after the first one")
    return counted, last - begin


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "record":
        record(sys.argv[2])
    elif len(sys.argv) in (3, 4) and sys.argv[1] == "count":
        counted, seconds = count(sys.argv[2], float(sys.argv[3]) if len(sys.argv) == 4 else 0.0)
        for (kind, name), (size, number) in sorted(counted.items(), key=lambda each: -each[1][0])[:SHOWN]:
            print(f"{8e-3 * size / seconds:10.1f} kbit/s {number / seconds:8.1f} /s  {kind:<10} {name}")
        whole = sum(size for size, _ in counted.values())
        print(f"{8e-3 * whole / seconds:10.1f} kbit/s in all, {seconds:.1f} s")
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
