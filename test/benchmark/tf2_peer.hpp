// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

namespace pipescout::benchmarks {

/// The peer of the transform buffer: tf2's BufferCore, as Debian builds it. Its headers are those
/// of ROS 1, so none of them appears here.
class Tf2Peer {
 public:
  enum class Outcome { kFound, kUnknown, kDisconnected, kExtrapolation };
  struct Pose {
    std::array<double, 3> translation{};
    std::array<double, 4> rotation{0, 0, 0, 1};  // x y z w
  };

  /// `history`: ns.
  explicit Tf2Peer(std::int64_t history);
  Tf2Peer(const Tf2Peer&) = delete;
  Tf2Peer& operator=(const Tf2Peer&) = delete;
  ~Tf2Peer();

  /// `time`: ns. False when it is refused.
  bool insert(const std::string& parent, const std::string& child, std::int64_t time,
              const Pose& pose, bool is_static);
  /// `time` 0: the latest. `pose` is only written for kFound.
  [[nodiscard]] Outcome lookup(const std::string& target, const std::string& source,
                               std::int64_t time, Pose& pose) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pipescout::benchmarks
