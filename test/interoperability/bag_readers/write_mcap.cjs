// SPDX-License-Identifier: Apache-2.0
// node write_mcap.cjs FILE: 300 messages by @mcap/core, and a line for each on stdout.
"use strict";
const { open } = require("fs/promises");
const { McapWriter } = require("@mcap/core");
const { FileHandleWritable } = require("@mcap/nodejs");
const { line } = require("./checksum.cjs");

async function main() {
  const file = await open(process.argv[2], "w");
  const writer = new McapWriter({ writable: new FileHandleWritable(file), chunkSize: 5000 });
  await writer.start({ profile: "ros2", library: "test" });
  const type = "std_msgs/msg/String";
  const schemaId = await writer.registerSchema({
    name: type,
    encoding: "ros2msg",
    data: Buffer.from("string data\n"),
  });
  const channels = [];
  for (const topic of ["/a", "/b"]) {
    channels.push(
      await writer.registerChannel({
        schemaId,
        topic,
        messageEncoding: "cdr",
        metadata: new Map([["offered_qos_profiles", ""]]),
      }),
    );
  }
  await writer.addAttachment({
    name: "notes.txt", logTime: 5n, createTime: 0n, mediaType: "text/plain",
    data: Buffer.from("skipped by readers of messages"),
  });
  await writer.addMetadata({ name: "mission", metadata: new Map([["robot", "crawler"]]) });
  for (let k = 0; k < 300; k++) {
    const data = Buffer.alloc(4 + (k * 37) % 400, k);
    const logTime = 1000n + BigInt(k);
    await writer.addMessage({
      channelId: channels[k % 2], sequence: k, logTime, publishTime: logTime, data,
    });
    console.log(line(k % 2 === 0 ? "/a" : "/b", type, logTime, data));
  }
  await writer.end();
  await file.close();
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
