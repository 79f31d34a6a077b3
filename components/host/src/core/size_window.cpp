// SPDX-License-Identifier: Apache-2.0
#include "core/size_window.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>

namespace pipescout::host {
namespace {

template <class... Values>
std::string formatted(const char* format, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

}  // namespace

SizeWindow::SizeWindow(std::size_t window) : window_(window) {
  if (window == 0) {
    throw std::invalid_argument("a window of no message");
  }
}

void SizeWindow::arrived(SteadyTime now, std::size_t bytes) {
  messages_.push_back({now, bytes});
  if (messages_.size() > window_) {
    messages_.pop_front();
  }
}

std::optional<SizeWindow::Statistics> SizeWindow::statistics(SteadyTime now) const {
  if (messages_.size() < 2 || now <= messages_.front().time) {
    return std::nullopt;
  }
  Statistics result;
  result.window = messages_.size();
  result.min = result.max = messages_.front().bytes;
  double total = 0.0;
  for (const auto& message : messages_) {
    total += static_cast<double>(message.bytes);
    result.min = std::min(result.min, message.bytes);
    result.max = std::max(result.max, message.bytes);
  }
  result.mean = total / static_cast<double>(result.window);
  result.bytes_per_second = total / to_seconds(now - messages_.front().time);
  return result;
}

std::string to_string(const SizeWindow::Statistics& statistics) {
  const double rate = statistics.bytes_per_second;
  const char* unit = rate < 1e3 ? "B" : rate < 1e6 ? "KB" : "MB";
  const double scale = rate < 1e3 ? 1.0 : rate < 1e6 ? 1e3 : 1e6;
  return formatted(
      "%.2f %s/s from %zu messages\n\tMessage size mean: %.2f %s min: %.2f %s max: %.2f %s",
      rate / scale, unit, statistics.window, statistics.mean / scale, unit,
      static_cast<double>(statistics.min) / scale, unit,
      static_cast<double>(statistics.max) / scale, unit);
}

DelayWindow::DelayWindow(std::size_t window) : window_(window) {
  if (window == 0) {
    throw std::invalid_argument("a window of no message");
  }
}

void DelayWindow::arrived(Duration delay) {
  delays_.push_back(to_seconds(delay));
  if (delays_.size() > window_) {
    delays_.pop_front();
  }
}

std::optional<DelayWindow::Statistics> DelayWindow::statistics() const {
  if (delays_.empty()) {
    return std::nullopt;
  }
  Statistics result;
  result.window = delays_.size();
  const auto [min, max] = std::minmax_element(delays_.begin(), delays_.end());
  result.min = *min;
  result.max = *max;
  const auto count = static_cast<double>(result.window);
  result.mean = std::accumulate(delays_.begin(), delays_.end(), 0.0) / count;
  double squares = 0.0;
  for (const double delay : delays_) {
    squares += (delay - result.mean) * (delay - result.mean);
  }
  result.standard_deviation = std::sqrt(squares / count);
  return result;
}

std::string to_string(const DelayWindow::Statistics& statistics) {
  return formatted("average delay: %.3f\n\tmin: %.3fs max: %.3fs std dev: %.5fs window: %zu",
                   statistics.mean, statistics.min, statistics.max, statistics.standard_deviation,
                   statistics.window);
}

}  // namespace pipescout::host
