// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/runtime/node.hpp"

namespace pipescout {

/// Sends what a node logs to `/rosout` too, as long as it exists.
class Rosout {
 public:
  explicit Rosout(Node& node);
  Rosout(const Rosout&) = delete;
  Rosout& operator=(const Rosout&) = delete;
  ~Rosout();

 private:
  Logger logger_;
};

}  // namespace pipescout
