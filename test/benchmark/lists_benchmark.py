#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether lists of nodes, topics and services are complete, and how long they take.

Beside 1 to 20 processes of several kinds, which come and go between the lists: compositions, compositions with an isolated component,
compositions with the transports and the discovery that Fast DDS has by itself (as a node of ROS 2 has them), and a command line that
listens. Half of the lists are made on a machine that does nothing else, half beside busy loops, one for each core and one more.

lists_wrong_silently         lists that miss a name, or have one too many, without a warning
lists_wrong                  the same with those that warned
lists_warned_percent         of the lists without busy loops
lists_median_s               time of a list without busy loops
lists_p95_s
daemon_lists_wrong_silently  the same answered by the daemon
daemon_lists_median_s
super_client_records         messages that recorders outside of the publishing process record behind a discovery server, in % of
                             those of a recorder inside

Builds what it runs. Seeds are those of the random order of processes and commands.
"""
import argparse
import json
import os
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile
import threading
import time

import yaml

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "test" / "fleet"))
import fleet  # noqa: E402  (its folder is known only now)

COMPOSITION = fleet.HERE / "robot.yaml"
MOST_PROCESSES = 20
COMMANDS = (("node", "list"), ("topic", "list"), ("service", "list"))
TARGETS = {"lists_wrong_silently": 0, "lists_warned_percent": 1.0, "lists_median_s": 1.5,
           "daemon_lists_wrong_silently": 0, "super_client_records": 100.0}
# What rmw_fastrtps makes of ROS_LOCALHOST_ONLY=1, which a profile replaces.
STOCK_PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<profiles xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
  <transport_descriptors>
    <transport_descriptor>
      <transport_id>udp</transport_id><type>UDPv4</type>
      <interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>
    </transport_descriptor>
    <transport_descriptor><transport_id>memory</transport_id><type>SHM</type></transport_descriptor>
  </transport_descriptors>
  <participant profile_name="stock" is_default_profile="true">
    <rtps>
      <userTransports><transport_id>udp</transport_id><transport_id>memory</transport_id></userTransports>
      <useBuiltinTransports>false</useBuiltinTransports>
    </rtps>
  </participant>
</profiles>
"""


class Line:
    """Waits for a text on the stderr of a process, and reads on."""

    def __init__(self, process, text):
        self.found = threading.Event()
        self.said = []
        self._thread = threading.Thread(target=self._read, args=(process, text), daemon=True)
        self._thread.start()

    def _read(self, process, text):
        for line in process.stderr:
            self.said.append(line)
            if text in line:
                self.found.set()
        self.found.set()


class World:
    """The processes beside which lists are made."""

    def __init__(self, env, scratch, chance):
        self.env, self.scratch, self.chance = env, scratch, chance
        self.running = {}  # process and kind, by number
        self.started = 0
        profile = scratch / "stock.xml"
        profile.write_text(STOCK_PROFILE)
        isolated = yaml.safe_load(COMPOSITION.read_text())
        isolated["components"][-1]["isolate"] = True
        (scratch / "isolated.yaml").write_text(yaml.safe_dump(isolated))
        self.kinds = {
            "composition": (COMPOSITION, {}),
            "isolated": (scratch / "isolated.yaml", {}),
            "stock": (COMPOSITION, {"FASTRTPS_DEFAULT_PROFILES_FILE": str(profile)}),
            "listener": (None, {}),
        }
        self.names = {kind: self._names_alone(kind) for kind in self.kinds}

    def _names_alone(self, kind):
        """The names that a process of the kind brings, with {} for its number."""
        number = self.start(kind)
        names = {}
        for command in COMMANDS:
            out, err, _ = self.list(command)
            if err:
                sys.exit(f"a list beside one process warned: {err}")
            names[command] = {name.replace(f"/p{number}/", "/p{}/") for name in out}
        self.stop(number)
        return names

    def start(self, kind):
        self.started += 1
        number = self.started
        composition, more = self.kinds[kind]
        words = (["pipescout", "topic", "echo", f"/p{number}/heard", "std_msgs/msg/String"]
                 if composition is None else
                 ["pipescout", "run", str(composition), "--namespace", f"/p{number}", "--out",
                  str(self.scratch / f"mission_{number}")])
        process = subprocess.Popen(words, env=self.env | more, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True)
        self.running[number] = (process, kind)
        if composition is None:
            # It says nothing. What it subscribes to tells that it is there.
            deadline = time.monotonic() + 60
            while time.monotonic() < deadline:
                if f"/p{number}/heard" in self.list(("topic", "list"))[0]:
                    return number
            sys.exit("a listener did not come up within 60 s")
        line = Line(process, " active")
        if not line.found.wait(120) or process.poll() is not None:
            sys.exit(f"a {kind} did not come up: {''.join(line.said)}")
        return number

    def stop(self, number):
        process, _ = self.running.pop(number)
        process.terminate()
        process.wait(60)

    def step(self):
        """One more process, or one less; between 1 and the most."""
        if len(self.running) <= 1 or (len(self.running) < MOST_PROCESSES and self.chance.random() < 0.55):
            self.start(self.chance.choice(list(self.kinds)))
        else:
            self.stop(self.chance.choice(list(self.running)))

    def truth(self, command):
        return {name.format(number) for number, (_, kind) in self.running.items()
                for name in self.names[kind][command]}

    def list(self, command, *options):
        begin = time.monotonic()
        done = subprocess.run(["pipescout", *command, *options], env=self.env, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        return set(done.stdout.split()), done.stderr, time.monotonic() - begin

    def end(self):
        for number in list(self.running):
            self.stop(number)


def measure_lists(world, count, busy, *options):
    """Rows of that many lists, `busy` loops beside them."""
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(busy)]
    rows = []
    try:
        for number in range(count):
            world.step()
            command = world.chance.choice(COMMANDS)
            out, err, seconds = world.list(command, *options)
            truth = world.truth(command)
            rows.append({"command": " ".join(command), "processes": len(world.running), "busy": busy,
                         "seconds": round(seconds, 3), "warned": bool(err), "wrong": out != truth,
                         "missing": sorted(truth - out), "too_many": sorted(out - truth)})
            if out != truth:
                print(json.dumps(rows[-1]), file=sys.stderr)
            if (number + 1) % 50 == 0:
                print(f"{number + 1} of {count} lists, {busy} busy loops", file=sys.stderr)
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()
    return rows


def silent(rows):
    return sum(row["wrong"] and not row["warned"] for row in rows)


def messages_of(bag):
    metadata = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    return {each["topic_metadata"]["name"]: each["message_count"]
            for each in metadata["topics_with_message_count"]
            # How many there are of these depends on the time that the processes take.
            if each["topic_metadata"]["name"] not in ("/rosout", "/diagnostics", "/parameter_events")}


def measure_recorders(env, scratch):
    """The percentage, and a row for each recorder."""
    launch_scripts = ROOT / "launch_scripts"
    port = 20000 + os.getpid() % 10000
    server = subprocess.Popen(["pipescout", "discovery", "start", "-l", "127.0.0.1", "-p", str(port)],
                              env=env, stdout=subprocess.PIPE, text=True)
    assert "listens" in server.stdout.readline()
    behind = env | {"ROS_DISCOVERY_SERVER": f"127.0.0.1:{port}"}
    mission = yaml.safe_load((launch_scripts / "odometry.yaml").read_text())

    def run(name, change, environment):
        composition = json.loads(json.dumps(mission))
        change({each["name"]: each for each in composition["components"]})
        file = scratch / f"{name}.yaml"
        file.write_text(yaml.safe_dump(composition, sort_keys=False))
        subprocess.run(["pipescout", "run", str(file), "--out", str(scratch / name)], env=environment,
                       stdout=sys.stderr, check=True)
        return messages_of(scratch / name / "bag")

    inside = run("inside", lambda components: None, env)
    isolated = run("isolated", lambda components: components["bag_recorder"].update(isolate=True), behind)
    outside_bag = scratch / "outside"
    recorder = subprocess.Popen(["pipescout", "bag", "record", "-a", "-o", str(outside_bag)], env=behind,
                                stdout=sys.stderr)

    def wait_for_the_command(components):
        for name in ("odometer_replay", "odometry_fusion"):
            components[name]["parameters"]["wait_for_subscribers"].append("rosbag2_recorder")

    run("beside", wait_for_the_command, behind)
    recorder.terminate()
    recorder.wait(60)
    outside = messages_of(outside_bag)
    server.terminate()
    server.wait(60)
    rows = [{"recorder": name, "topic": topic, "messages": found.get(topic, 0), "inside": count}
            for name, found in (("isolated", isolated), ("pipescout bag record -a", outside))
            for topic, count in inside.items()]
    percent = min(100.0 * min(1.0, row["messages"] / row["inside"]) for row in rows if row["inside"])
    return percent, rows


def main():
    parser = argparse.ArgumentParser(prog="test/benchmark/run.sh lists", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", metavar="FILE", help="writes figures and rows to FILE")
    parser.add_argument("--lists", type=int, default=1000, help="without the daemon (default: 1000)")
    parser.add_argument("--daemon-lists", type=int, default=200, help="(default: 200)")
    parser.add_argument("--seed", type=int, default=1, help="of processes and commands (default: 1)")
    parser.add_argument("--prefix", type=pathlib.Path,
                        help="run the components built there, in the present environment")
    options = parser.parse_args()
    env = fleet.built_environment(options.prefix) | {"ROS_LOCALHOST_ONLY": "1"}
    env.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        percent, recorders = measure_recorders(env, scratch)
        world = World(env, scratch, random.Random(options.seed))
        try:
            idle = measure_lists(world, options.lists // 2, 0, "--no-daemon")
            busy = measure_lists(world, options.lists - len(idle), 1 + (os.cpu_count() or 1), "--no-daemon")
            subprocess.run(["pipescout", "daemon", "start"], env=env, check=True, stdout=sys.stderr)
            by_daemon = measure_lists(world, options.daemon_lists, 0)
        finally:
            subprocess.run(["pipescout", "daemon", "stop"], env=env, stdout=sys.stderr)
            world.end()
    seconds = sorted(row["seconds"] for row in idle)
    figures = {
        "lists_wrong_silently": silent(idle + busy),
        "lists_wrong": sum(row["wrong"] for row in idle + busy),
        "lists_warned_percent": 100.0 * sum(row["warned"] for row in idle) / max(1, len(idle)),
        "lists_median_s": statistics.median(seconds),
        "lists_p95_s": seconds[int(0.95 * (len(seconds) - 1))],
        "daemon_lists_wrong_silently": silent(by_daemon),
        "daemon_lists_median_s": statistics.median(row["seconds"] for row in by_daemon),
        "super_client_records": percent,
    }
    for name, value in figures.items():
        target = f"   ({TARGETS[name]:g} asked)" if name in TARGETS else ""
        print(f"{name:28} {value:10.3f}{target}")
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps(
            {"figures": figures, "rows": idle + busy + by_daemon + recorders, "seeds": [options.seed]}))


if __name__ == "__main__":
    main()
