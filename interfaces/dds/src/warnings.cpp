// SPDX-License-Identifier: Apache-2.0
#include "warnings.hpp"

#include <algorithm>

#include "pipescout/runtime/logger.hpp"

namespace pipescout::dds {

void Warnings::add(const std::string& sentence) {
  {
    const std::lock_guard lock(mutex_);
    if (std::find(sentences_.begin(), sentences_.end(), sentence) != sentences_.end()) {
      return;
    }
    sentences_.push_back(sentence);
  }
  Logger("pipescout.transport").warn(sentence);
}

std::vector<std::string> Warnings::all() const {
  const std::lock_guard lock(mutex_);
  return sentences_;
}

}  // namespace pipescout::dds
