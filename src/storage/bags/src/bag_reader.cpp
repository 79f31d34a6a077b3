// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bags/bag_reader.hpp"

#include <string>
#include <utility>

#include "bag_source.hpp"

namespace pipescout::bags {

class BagReader::Implementation {
 public:
  explicit Implementation(std::filesystem::path bag) : source(std::move(bag)) {}

  BagSource source;
  bool told = false;  ///< what could not be read
};

BagReader::BagReader(std::filesystem::path bag)
    : implementation_(std::make_unique<Implementation>(std::move(bag))) {}

BagReader::~BagReader() = default;

const BagMetadata& BagReader::metadata() const noexcept {
  return implementation_->source.metadata();
}

const std::vector<BagTopic>& BagReader::topics() const noexcept {
  return implementation_->source.topics();
}

void BagReader::set_filter(BagFilter filter) {
  implementation_->source.set_filter(std::move(filter));
  implementation_->told = false;
}

void BagReader::seek(std::int64_t time) {
  implementation_->source.seek(time);
  implementation_->told = false;
}

std::optional<BagMessage> BagReader::next() {
  BagMessage message;
  if (implementation_->source.next(message)) {
    return message;
  }
  const auto& faults = implementation_->source.faults();
  if (!faults.empty() && !std::exchange(implementation_->told, true)) {
    throw faults.front();
  }
  return std::nullopt;
}

std::optional<BagMessage> BagReader::next_before_damage(std::string& damage) {
  try {
    return next();
  } catch (const BagError& error) {
    damage = error.what();
    return std::nullopt;
  }
}

}  // namespace pipescout::bags
