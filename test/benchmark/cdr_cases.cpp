// SPDX-License-Identifier: Apache-2.0
#include "cdr_cases.hpp"

#include <benchmark/benchmark.h>
#include <dds/dds.h>
#include <dds/ddsi/ddsi_cdrstream.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <functional>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <stdexcept>
#include <string>
#include <vector>

extern "C" {
#include "all_messages.h"
}

#include "pipescout/idl/message_type.hpp"
#include "samples.hpp"

namespace pipescout::benchmarks {
namespace {

constexpr std::size_t kEncapsulation = 4;

sensor_msgs::msg::Image image() {
  sensor_msgs::msg::Image message;
  message.header.frame_id = "thermal_optical";
  message.width = 640;
  message.height = 480;
  message.encoding = "mono16";
  message.step = message.width * 2;
  message.data.resize(std::size_t{message.step} * message.height);
  for (std::size_t i = 0; i < message.data.size(); ++i) {
    message.data[i] = static_cast<std::uint8_t>(i * 31);
  }
  return message;
}

nav_msgs::msg::Odometry odometry() {
  nav_msgs::msg::Odometry message;
  message.header.frame_id = "odom";
  message.child_frame_id = "base_link";
  message.pose.pose.position.x = 1.0;
  message.pose.covariance.fill(0.01);
  return message;
}

diagnostic_msgs::msg::DiagnosticArray diagnostics() {
  diagnostic_msgs::msg::DiagnosticArray message;
  for (int i = 0; i < 50; ++i) {
    auto& status = message.status.emplace_back();
    status.level = diagnostic_msgs::msg::DiagnosticStatus::WARN;
    status.name = "component_" + std::to_string(i) + ": status";
    status.message = "fewer messages than expected";
    status.hardware_id = "robot";
    for (int k = 0; k < 5; ++k) {
      auto& value = status.values.emplace_back();
      value.key = "messages received on topic " + std::to_string(k);
      value.value = std::to_string(12345 * k);
    }
  }
  return message;
}

/// One message in both forms.
class CdrCase {
 public:
  template <class T>
  CdrCase(std::string name, T message, const dds_topic_descriptor_t& descriptor)
      : name_(std::move(name)),
        type_(message_type<T>()),
        message_(std::make_shared<T>(std::move(message))),
        received_(type_.create()),
        bytes_(type_.serialized_size(message_.get())),
        descriptor_(descriptor),
        sample_(std::calloc(1, descriptor.m_size), &std::free) {
    type_.serialize(message_.get(), bytes_);
    buffer_.resize(bytes_.size());
    read_by_cyclone();
    dds_ostreamLE_init(&out_, 64, 1);
    write_by_cyclone();
    if (out_.x.m_index != bytes_.size() - kEncapsulation ||
        std::memcmp(out_.x.m_buffer, bytes_.data() + kEncapsulation, out_.x.m_index) != 0) {
      throw std::runtime_error(name_ + ": Cyclone writes other bytes");
    }
  }
  CdrCase(const CdrCase&) = delete;
  CdrCase& operator=(const CdrCase&) = delete;
  ~CdrCase() {
    dds_ostreamLE_fini(&out_);
    dds_stream_free_sample(sample_.get(), descriptor_.m_ops);
  }

  [[nodiscard]] const std::string& name() const { return name_; }

  void write() {
    benchmark::DoNotOptimize(type_.serialized_size(message_.get()));
    benchmark::DoNotOptimize(type_.serialize(message_.get(), buffer_));
  }
  void read() { benchmark::DoNotOptimize(type_.deserialize(bytes_, received_.get())); }

  void write_by_cyclone() {
    out_.x.m_index = 0;
    dds_stream_writeLE(&out_, static_cast<const char*>(sample_.get()), descriptor_.m_ops);
  }
  void read_by_cyclone() {
    dds_istream_t in;
    dds_istream_init(&in, payload_size(), bytes_.data() + kEncapsulation, 1);
    dds_stream_read(&in, static_cast<char*>(sample_.get()), descriptor_.m_ops);
  }
  void check_and_read_by_cyclone() {
    std::uint32_t offset = 0;
    benchmark::DoNotOptimize(
        dds_stream_normalize_data(reinterpret_cast<char*>(bytes_.data() + kEncapsulation), &offset,
                                  payload_size(), false, 1, descriptor_.m_ops));
    read_by_cyclone();
  }

 private:
  [[nodiscard]] std::uint32_t payload_size() const {
    return static_cast<std::uint32_t>(bytes_.size() - kEncapsulation);
  }

  std::string name_;
  const MessageType& type_;
  std::shared_ptr<const void> message_;
  std::shared_ptr<void> received_;
  std::vector<std::byte> bytes_;
  std::vector<std::byte> buffer_;
  const dds_topic_descriptor_t& descriptor_;
  std::unique_ptr<void, decltype(&std::free)> sample_;
  dds_ostreamLE_t out_{};
};

std::vector<std::unique_ptr<CdrCase>>& cases() {
  static auto all = [] {
    std::vector<std::unique_ptr<CdrCase>> made;
    made.push_back(std::make_unique<CdrCase>("Image", image(), sensor_msgs_msg_Image_desc));
    made.push_back(std::make_unique<CdrCase>("Odometry", odometry(), nav_msgs_msg_Odometry_desc));
    made.push_back(std::make_unique<CdrCase>("DiagnosticArray of 50", diagnostics(),
                                             diagnostic_msgs_msg_DiagnosticArray_desc));
    return made;
  }();
  return all;
}

void add_case(const std::string& name, const std::function<void()>& body) {
  // So many that the clock's own time is nothing beside theirs.
  constexpr int kBatch = 50;
  benchmark::RegisterBenchmark(
      name.c_str(),
      [name, body](benchmark::State& state) {
        for (auto _ : state) {
          const auto begin = thread_cpu_nanoseconds();
          for (int i = 0; i < kBatch; ++i) {
            body();
          }
          const auto each = static_cast<double>(thread_cpu_nanoseconds() - begin) / kBatch;
          all_samples()[name].add(each / 1e3);
          state.SetIterationTime(each / 1e9);
        }
      })
      ->UseManualTime()
      ->Iterations(50)
      ->Unit(benchmark::kMicrosecond);
}

double median(const std::string& name) {
  return all_samples()[name].median();
}

}  // namespace

void register_cdr() {
  for (const auto& one : cases()) {
    auto* const c = one.get();
    add_case("cdr, " + c->name() + ", write, ours", [c] { c->write(); });
    add_case("cdr, " + c->name() + ", write, Cyclone", [c] { c->write_by_cyclone(); });
    add_case("cdr, " + c->name() + ", read, ours", [c] { c->read(); });
    add_case("cdr, " + c->name() + ", read, Cyclone", [c] { c->check_and_read_by_cyclone(); });
    add_case("cdr, " + c->name() + ", read without check, Cyclone", [c] { c->read_by_cyclone(); });
  }
}

void add_cdr_figures(Figures& figures) {
  const auto ratio = [](const std::string& name, const char* direction) {
    return median("cdr, " + name + ", " + direction + ", ours") /
           median("cdr, " + name + ", " + direction + ", Cyclone");
  };
  // The worst message counts: a mean would let a fast one make up for a slow one.
  double encode = 0.0;
  double decode = 0.0;
  for (const auto& one : cases()) {
    encode = std::max(encode, ratio(one->name(), "write"));
    decode = std::max(decode, ratio(one->name(), "read"));
    figures.add_row({{"case", "cdr, " + one->name()},
                     {"encode_ratio", ratio(one->name(), "write")},
                     {"decode_ratio", ratio(one->name(), "read")}});
  }
  figures.add("cdr_encode_ratio", encode, Figures::Bound::kAtMost, 1.0);
  figures.add("cdr_decode_ratio", decode, Figures::Bound::kAtMost, 1.0);
}

}  // namespace pipescout::benchmarks
