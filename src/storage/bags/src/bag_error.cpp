// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bags/bag_error.hpp"

#include <utility>

namespace pipescout::bags {

BagError::BagError(BagFault fault, std::filesystem::path file, const std::string& message)
    : std::runtime_error(file.string() + ": " + message), fault_(fault), file_(std::move(file)) {}

BagError::BagError(BagFault fault, std::filesystem::path file, std::uint64_t offset,
                   const std::string& field, const std::string& message)
    : std::runtime_error(file.string() + ": offset " + std::to_string(offset) + ": " + field +
                         ": " + message),
      fault_(fault),
      file_(std::move(file)),
      offset_(offset) {}

}  // namespace pipescout::bags
