// SPDX-License-Identifier: Apache-2.0
"use strict";

/** FNV-1a, 32 bits. */
function hash(data) {
  let value = 0x811c9dc5;
  for (const byte of data) {
    value = Math.imul(value ^ byte, 0x01000193) >>> 0;
  }
  return value;
}

/** One line for a message, as the test in C++ writes it. */
exports.line = (topic, type, logTime, data) =>
  `${topic} ${type} ${logTime} ${data.byteLength} ${hash(data)}`;
