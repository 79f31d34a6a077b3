// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace pipescout::benchmarks {

/// Nanoseconds on CLOCK_MONOTONIC, which all processes of a machine share.
[[nodiscard]] std::int64_t monotonic_nanoseconds();

/// Latencies of one case, in microseconds.
class Samples {
 public:
  void add(double microseconds) { values_.push_back(microseconds); }
  [[nodiscard]] std::size_t size() const { return values_.size(); }
  /// `fraction` in [0, 1]; NaN without samples.
  [[nodiscard]] double quantile(double fraction) const;
  [[nodiscard]] double median() const { return quantile(0.5); }

 private:
  std::vector<double> values_;
};

/// All samples of this run by case; cases are measured in several interleaved repetitions.
[[nodiscard]] std::map<std::string, Samples>& all_samples();

}  // namespace pipescout::benchmarks
