// SPDX-License-Identifier: Apache-2.0
// node read_db3.cjs FILE: a line for each message, by @foxglove/rosbag2 over sql.js.
"use strict";
const { readFileSync } = require("fs");
const { Rosbag2 } = require("@foxglove/rosbag2");
const { parseQosProfiles } = require("@foxglove/rosbag2/dist/metadata");
const initSqlJs = require("sql.js");
const { line } = require("./checksum.cjs");

const toTime = (ns) => ({ sec: Number(ns / 1000000000n), nsec: Number(ns % 1000000000n) });

/** What @foxglove/rosbag2 asks of a database. */
class Database {
  constructor(sql, path) {
    this.db = new sql.Database(readFileSync(path));
  }
  async open() {}
  async close() {
    this.db.close();
  }
  *rows(query) {
    const statement = this.db.prepare(query);
    while (statement.step()) {
      yield statement.get(null, { useBigInt: true });
    }
    statement.free();
  }
  async readTopics() {
    const topics = [];
    this.byId = new Map();
    for (const [id, name, type, serializationFormat, qos] of this.rows("SELECT * FROM topics")) {
      const topic = { name, type, serializationFormat, offeredQosProfiles: parseQosProfiles(qos) };
      topics.push(topic);
      this.byId.set(id, topic);
    }
    return topics;
  }
  async *readMessages() {
    await this.readTopics();
    for (const [topic, time, data] of this.rows(
      "SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id",
    )) {
      yield { topic: this.byId.get(topic), timestamp: toTime(time), data };
    }
  }
  async timeRange() {
    const [[first, last]] = [...this.rows("SELECT MIN(timestamp), MAX(timestamp) FROM messages")];
    return [toTime(first), toTime(last)];
  }
  async messageCounts() {
    return new Map(
      [...this.rows(
        "SELECT name, COUNT(*) FROM messages JOIN topics ON topics.id = topic_id GROUP BY name",
      )].map(([name, count]) => [name, Number(count)]),
    );
  }
}

async function main() {
  const bag = new Rosbag2([new Database(await initSqlJs(), process.argv[2])]);
  await bag.open();
  for (const topic of await bag.readTopics()) {
    if (topic.offeredQosProfiles[0].depth !== 10) {
      throw new Error(`QoS of ${topic.name}: ${JSON.stringify(topic.offeredQosProfiles)}`);
    }
  }
  for await (const { topic, timestamp, data, value } of bag.readMessages()) {
    if (typeof value.data !== "string") {
      throw new Error(`not decoded: ${JSON.stringify(value)}`);
    }
    const time = BigInt(timestamp.sec) * 1000000000n + BigInt(timestamp.nsec);
    console.log(line(topic.name, topic.type, time, data));
  }
  await bag.close();
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
