// SPDX-License-Identifier: Apache-2.0
#include "transport_benchmark.hpp"

#include <unistd.h>

#include <cstring>
#include <iostream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "figures.hpp"
#include "program.hpp"
#include "samples.hpp"

namespace pipescout::benchmarks {

namespace {

sensor_msgs::msg::Image pattern(ImageSize size) {
  sensor_msgs::msg::Image image;
  image.header.frame_id = "thermal_optical";
  image.width = size.width;
  image.height = size.height;
  image.encoding = "mono16";
  image.step = size.width * 2;
  std::vector<std::uint8_t> data(std::size_t{size.width} * size.height * 2);
  for (std::size_t i = 0; i < data.size(); ++i) {
    data[i] = static_cast<std::uint8_t>(i * 31);
  }
  image.data = std::move(data);
  return image;
}

}  // namespace

std::unique_ptr<sensor_msgs::msg::Image> make_image(ImageSize size) {
  // One copy of a pattern each time: about what a driver does with a frame.
  static std::map<std::pair<std::uint32_t, std::uint32_t>, sensor_msgs::msg::Image> patterns;
  auto found = patterns.find({size.width, size.height});
  if (found == patterns.end()) {
    found = patterns.emplace(std::pair{size.width, size.height}, pattern(size)).first;
  }
  return std::make_unique<sensor_msgs::msg::Image>(found->second);
}

void stamp(sensor_msgs::msg::Image& image) {
  const std::int64_t now = monotonic_nanoseconds();
  image.header.stamp.sec = static_cast<std::int32_t>(now / 1'000'000'000);
  image.header.stamp.nanosec = static_cast<std::uint32_t>(now % 1'000'000'000);
}

double microseconds_since_stamp(const sensor_msgs::msg::Image& image) {
  const auto& stamped = image.header.stamp;
  const std::int64_t then = std::int64_t{stamped.sec} * 1'000'000'000 + stamped.nanosec;
  return static_cast<double>(monotonic_nanoseconds() - then) / 1e3;
}

std::uint32_t benchmark_domain() {
  static const auto domain = static_cast<std::uint32_t>(1 + getpid() % 100);
  return domain;
}

std::uint32_t in_process_domain() {
  return benchmark_domain() + 100;
}

}  // namespace pipescout::benchmarks

namespace {

using pipescout::benchmarks::all_samples;
using pipescout::benchmarks::Figures;

double median(const std::string& name) {
  return all_samples()[name].median();
}

Figures evaluate(const pipescout::benchmarks::LoadFigures& load) {
  using Bound = Figures::Bound;
  Figures figures;
  for (const auto& [name, samples] : all_samples()) {
    figures.add_row({{"case", name},
                     {"median_us", samples.median()},
                     {"p99_us", samples.quantile(0.99)},
                     {"samples", samples.size()}});
  }
  figures.add_row({{"case", "20 idle components"}, {"cpu_percent", load.idle_percent}});
  figures.add_row({{"case", "chain of 20 at 50 Hz, ours"}, {"cpu_percent", load.busy_percent}});
  figures.add_row(
      {{"case", "chain of 20 at 50 Hz, plain Fast DDS"}, {"cpu_percent", load.busy_plain_percent}});

  figures.add("inprocess_image_speedup",
              median("in process, image, plain Fast DDS") / median("in process, image, ours"),
              Bound::kAtLeast, 20.0);
  figures.add("inprocess_image_us", median("in process, image, ours"), Bound::kAtMost, 17.0);
  figures.add("inprocess_two_thread_ratio",
              median("two threads, image, ours") / median("two threads, image, bare hand-over"),
              Bound::kAtMost, 1.5);
  figures.add("inprocess_size_ratio",
              median("in process, 1920x1080, ours") / median("in process, 64x64, ours"),
              Bound::kAtMost, 1.5);
  figures.add(
      "crossprocess_image_speedup",
      median("across processes, image, plain Fast DDS") / median("across processes, image, ours"),
      Bound::kAtLeast, 12.0);
  figures.add(
      "crossprocess_1k_ratio",
      median("across processes, 1 kB, ours") / median("across processes, 1 kB, plain Fast DDS"),
      Bound::kAtMost, 1.15);
  figures.add("idle_cpu_percent", load.idle_percent, Bound::kAtMost, 1.0);
  figures.add("busy_cpu_ratio", load.busy_percent / load.busy_plain_percent, Bound::kAtMost, 0.5);
  return figures;
}

}  // namespace

int main(int argc, char** argv) {
  namespace pb = pipescout::benchmarks;
  if (const int code = pb::run_as_child(argc, argv); code >= 0) {
    return code;
  }
  return pb::run_program(
      argc, argv,
      [] {
        pb::register_in_process();
        pb::register_cross_process();
      },
      [] {
        std::cerr << "measuring processor load, 30 s\n";
        return evaluate(pb::measure_load());
      });
}
