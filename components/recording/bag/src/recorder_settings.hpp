// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/parameters.hpp"
#include "pipescout/runtime/qos.hpp"
#include "pipescout/runtime/time.hpp"
#include "recording_queue.hpp"
#include "topic_selection.hpp"

namespace pipescout {

/// The recorder's parameters (docs/components/bag_recorder.md), and what they said when it was
/// configured.
class RecorderSettings {
 public:
  /// Declares them.
  explicit RecorderSettings(Parameters& parameters);

  /// Names of topics and of the source are relative to `node`. Throws std::invalid_argument,
  /// QosProfileError.
  void read(const NodeName& node);

  /// Where a recording that begins now goes.
  [[nodiscard]] std::filesystem::path folder() const;
  /// What is to be recorded, in words: "topics /a, /b".
  [[nodiscard]] std::string asked() const;
  [[nodiscard]] bool simulated_time() const { return use_sim_time_.get(); }

  bags::BagWriterOptions writer;
  RecordingQueue::Options queue;
  TopicSelection selection;
  std::map<std::string, QoS> qos_overrides;
  std::map<std::string, Duration> thinning;  // period by topic
  std::string source;                        // fully qualified, or empty
  Duration settle{};
  Duration silence{};  // zero: no limit

 private:
  void read_thinning(const NodeName& node);

  Parameter<std::string> output_;
  Parameter<std::string> storage_;
  Parameter<bool> all_;
  Parameter<std::vector<std::string>> topics_;
  Parameter<std::string> regex_;
  Parameter<std::string> exclude_;
  Parameter<bool> include_hidden_;
  Parameter<std::int64_t> max_bag_size_;
  Parameter<std::int64_t> max_bag_duration_;
  Parameter<std::int64_t> max_cache_size_;
  Parameter<std::string> compression_mode_;
  Parameter<std::string> chunk_compression_;
  Parameter<std::string> qos_overrides_;
  Parameter<bool> snapshot_mode_;
  Parameter<bool> repeatable_;
  Parameter<bool> next_free_name_;
  Parameter<std::vector<std::string>> thinned_topics_;
  Parameter<std::vector<double>> thinned_periods_;
  Parameter<std::string> source_;
  Parameter<double> settle_time_;
  Parameter<double> silent_after_;
  Parameter<bool> use_sim_time_;
};

}  // namespace pipescout
