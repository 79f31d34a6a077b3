// SPDX-License-Identifier: Apache-2.0
// node read_mcap.cjs FILE: a line for each message, by @mcap/core.
"use strict";
const { open } = require("fs/promises");
const { McapIndexedReader } = require("@mcap/core");
const { FileHandleReadable } = require("@mcap/nodejs");
const { loadDecompressHandlers } = require("@mcap/support");
const { line } = require("./checksum.cjs");

async function main() {
  const file = await open(process.argv[2], "r");
  const reader = await McapIndexedReader.Initialize({
    readable: new FileHandleReadable(file),
    decompressHandlers: await loadDecompressHandlers(),
  });
  if (reader.header.profile !== "ros2") {
    throw new Error(`profile ${reader.header.profile}`);
  }
  let count = 0n;
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    if (schema.encoding !== "ros2msg" || channel.messageEncoding !== "cdr") {
      throw new Error(`encodings ${schema.encoding}, ${channel.messageEncoding}`);
    }
    console.log(line(channel.topic, schema.name, message.logTime, message.data));
    count++;
  }
  if (reader.statistics.messageCount !== count) {
    throw new Error(`statistics say ${reader.statistics.messageCount}, read ${count}`);
  }
  await file.close();
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
