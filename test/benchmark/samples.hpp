// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace pipescout::benchmarks {

/// Nanoseconds on CLOCK_MONOTONIC, which all processes of a machine share.
[[nodiscard]] std::int64_t monotonic_nanoseconds();
/// What this thread has used of its processor: other work on the machine makes nothing slower.
[[nodiscard]] std::int64_t thread_cpu_nanoseconds();

/// Values of one kind.
class Samples {
 public:
  void add(double value) { values_.push_back(value); }
  [[nodiscard]] std::size_t size() const { return values_.size(); }
  /// `fraction` in [0, 1]; NaN without samples.
  [[nodiscard]] double quantile(double fraction) const;
  [[nodiscard]] double median() const { return quantile(0.5); }

 private:
  std::vector<double> values_;
};

/// Latencies of this run by case, in microseconds; cases are measured in several interleaved
/// repetitions.
[[nodiscard]] std::map<std::string, Samples>& all_samples();

}  // namespace pipescout::benchmarks
