// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <string>
#include <vector>

namespace pipescout::dds {

/// What a participant cannot do as it was meant to, see `Transport::warnings`. Thread-safe.
class Warnings {
 public:
  /// Logs the sentence and keeps it, the first time only.
  void add(const std::string& sentence);
  [[nodiscard]] std::vector<std::string> all() const;

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> sentences_;
};

}  // namespace pipescout::dds
