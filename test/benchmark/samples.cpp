// SPDX-License-Identifier: Apache-2.0
#include "samples.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipescout::benchmarks {
namespace {

std::int64_t nanoseconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

std::int64_t monotonic_nanoseconds() {
  return nanoseconds(CLOCK_MONOTONIC);
}

std::int64_t thread_cpu_nanoseconds() {
  return nanoseconds(CLOCK_THREAD_CPUTIME_ID);
}

double Samples::quantile(double fraction) const {
  if (values_.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  std::vector<double> sorted = values_;
  const auto rank =
      static_cast<std::ptrdiff_t>(std::lround(fraction * static_cast<double>(sorted.size() - 1)));
  std::nth_element(sorted.begin(), sorted.begin() + rank, sorted.end());
  return sorted[static_cast<std::size_t>(rank)];
}

std::map<std::string, Samples>& all_samples() {
  static std::map<std::string, Samples> samples;
  return samples;
}

}  // namespace pipescout::benchmarks
