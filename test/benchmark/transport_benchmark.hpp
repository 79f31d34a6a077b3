// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <sensor_msgs/msg/image.hpp>

/// Latency from publish to callback, and processor time, of our transport and of plain Fast DDS.
namespace pipescout::benchmarks {

struct ImageSize {
  std::uint32_t width;
  std::uint32_t height;
};

inline constexpr ImageSize kThermalImage{640, 512};  ///< 16 bit: 655 kB
inline constexpr ImageSize kSmallImage{64, 64};
inline constexpr ImageSize kLargeImage{1920, 1080};
inline constexpr ImageSize kOneKilobyte{32, 16};
inline constexpr ImageSize kSixMegabytes{2000, 1500};

/// A mono16 image of that size.
[[nodiscard]] std::unique_ptr<sensor_msgs::msg::Image> make_image(ImageSize size);
/// Writes CLOCK_MONOTONIC into the header, and the microseconds since then.
void stamp(sensor_msgs::msg::Image& image);
[[nodiscard]] double microseconds_since_stamp(const sensor_msgs::msg::Image& image);

/// DDS domains that another run on this machine is unlikely to use. What is measured within a
/// process has a domain of its own: it must not reach the process at the other end of a
/// measurement.
[[nodiscard]] std::uint32_t benchmark_domain();
[[nodiscard]] std::uint32_t in_process_domain();

void register_in_process();
void register_cross_process();

/// Processor time of the whole process over wall time, in percent, measured in a process of its
/// own.
struct LoadFigures {
  double idle_percent;
  double busy_percent;
  double busy_plain_percent;
};
[[nodiscard]] LoadFigures measure_load();

/// Images of 6 MB at 10 Hz to a process with ten subscriptions, compared with one.
struct FanoutFigures {
  double delivered_percent;
  double cpu_ms_per_image_one;
  double cpu_ms_per_image_ten;
};
[[nodiscard]] FanoutFigures measure_fanout();

/// What a process with 50 components of 4 topics each publishes on ros_discovery_info.
struct DiscoveryFigures {
  double announcements;
  double kilobytes;
  double last_kilobytes;
};
[[nodiscard]] DiscoveryFigures measure_discovery();

/// The processes at the other end of these two, as `run_as_child`.
[[nodiscard]] int run_as_peer(int argc, char** argv);
/// The receiving end of the measurements across processes, as `run_as_child`.
[[nodiscard]] int run_as_receiver(int argc, char** argv);
/// Runs what a child process of the benchmark is for, and returns its exit code; -1 when the
/// arguments are not those of a child.
[[nodiscard]] int run_as_child(int argc, char** argv);

}  // namespace pipescout::benchmarks
