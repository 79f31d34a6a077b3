// SPDX-License-Identifier: Apache-2.0
// thin_out BAG NEW_BAG N: keeps every Nth message of each topic, in an MCAP bag with zstd.
#include <cstdlib>
#include <iostream>
#include <map>

#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/bags/bag_writer.hpp"

namespace bags = pipescout::bags;

int main(int argc, char** argv) {
  const unsigned long step = argc == 4 ? std::strtoul(argv[3], nullptr, 10) : 0;
  if (step == 0) {
    std::cerr << "usage: thin_out BAG NEW_BAG N\n";
    return 2;
  }
  try {
    bags::BagReader reader(argv[1]);
    bags::BagWriter writer(argv[2], {.storage = bags::Storage::kMcap,
                                     .chunk_compression = bags::ChunkCompression::kZstd});
    std::map<bags::TopicIndex, unsigned long> seen;
    while (auto message = reader.next()) {
      if (seen[message->topic]++ % step == 0) {
        message->topic = writer.add_topic(reader.topics()[message->topic]);
        writer.write(*message);
      }
    }
    writer.close();
    std::cout << writer.metadata().messages << " of " << reader.metadata().messages
              << " messages\n";
  } catch (const bags::BagError& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
