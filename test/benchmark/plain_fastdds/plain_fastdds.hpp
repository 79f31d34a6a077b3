// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <sensor_msgs/msg/image.hpp>

/// The peer of the transport benchmarks: Fast DDS as its own examples use it, with default QoS and
/// default transports, except that it stays on this machine (UDP on loopback, shared memory).
namespace pipescout::benchmarks {

class PlainParticipant;

/// A DataWriter with default QoS (reliable, keep last 1).
class PlainWriter {
 public:
  PlainWriter(const std::shared_ptr<PlainParticipant>& participant, const std::string& topic);
  ~PlainWriter();
  void write(sensor_msgs::msg::Image& image);
  [[nodiscard]] int matched() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Where a PlainReader calls back.
enum class PlainCallback {
  /// In the listener, where Fast DDS holds the reader: the callback may neither block nor write.
  kInListener,
  /// In a thread of its own that waits for the reader with a WaitSet, free to do anything, as the
  /// callbacks of our components are.
  kInThread
};

/// A DataReader with default QoS (keep last 1), but reliable like its writer: a best-effort one
/// loses every other image on the default transports.
class PlainReader {
 public:
  PlainReader(const std::shared_ptr<PlainParticipant>& participant, const std::string& topic,
              std::function<void(sensor_msgs::msg::Image&)> callback,
              PlainCallback where = PlainCallback::kInListener);
  ~PlainReader();
  [[nodiscard]] int matched() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

[[nodiscard]] std::shared_ptr<PlainParticipant> create_plain_participant(std::uint32_t domain);

}  // namespace pipescout::benchmarks
