// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <cmath>
#include <pipescout_msgs/msg/leak_detections.hpp>
#include <pipescout_msgs/msg/leak_event.hpp>
#include <stdexcept>
#include <string>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/csv/csv_line.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "tables/leak_tally.hpp"
#include "tables/makers.hpp"
#include "tables/values.hpp"

namespace pipescout::summary {

namespace {

using pipescout_msgs::msg::LeakEvent;
using pipescout_msgs::msg::LeakFinding;

/// In one message; more than any camera sees.
constexpr std::size_t kMaximumPipes = 1000;
constexpr std::size_t kMaximumLeaks = 10000;

const char* kind_name(std::uint8_t kind) {
  switch (kind) {
    case LeakEvent::RAISED:
      return "raised";
    case LeakEvent::UPDATED:
      return "updated";
    case LeakEvent::CLEARED:
      return "cleared";
    default:
      throw std::invalid_argument("kind is not one of RAISED, UPDATED, CLEARED");
  }
}

void require_finding(const LeakFinding& finding) {
  require(finding.id > 0, "the id of the finding is 0");
  require(finding.probability >= 0 && finding.probability <= 1,
          "the probability of the finding is not in [0, 1]");
  require(!finding.position_known ||
              (std::isfinite(finding.position.x) && std::isfinite(finding.position.y) &&
               std::isfinite(finding.position.z)),
          "the position of the finding is not finite");
}

std::string detections_header() {
  return "stamp,fault,pipes,leaks,threshold,longest_pipe,reference_temperature,largest_delta";
}

std::string events_header() {
  return "stamp,event,leak,state,severity,probability,x,y,z,x_standard_deviation,"
         "y_standard_deviation,z_standard_deviation,length,length_standard_deviation,delta,"
         "delta_low,delta_high,peak_delta,peak_delta_low,peak_delta_high,delta_growth,"
         "length_growth,first_seen,last_seen,pictures,passes";
}

std::string truth_header() {
  return "stamp,leak,x,y,z,length,delta";
}

double seconds(const builtin_interfaces::msg::Time& stamp) {
  return to_seconds(from_message(stamp).time_since_epoch());
}

class LeakTables final : public TableMaker {
 public:
  explicit LeakTables(const Robot& robot);

 protected:
  MissionSection section(const std::string& figure_prefix) const override {
    return tally_.section(figure_prefix);
  }
  std::string counts() const override {
    return std::to_string(tally_.pictures()) + " pictures and " + std::to_string(tally_.events()) +
           " events received";
  }
  bool has_data() const override { return tally_.pictures() > 0; }
  bool has_section() const override { return tally_.pictures() > 0 || tally_.events() > 0; }
  std::string file_names() const override { return "detections.csv, events.csv, truth.csv"; }

 private:
  using Detections = pipescout_msgs::msg::LeakDetections;
  using Event = pipescout_msgs::msg::LeakEvent;

  void on_detections(const Detections& message);
  void on_event(const Event& message);
  void on_truth(const Event& message);

  LeakTally tally_;
};

LeakTables::LeakTables(const Robot& robot) : TableMaker(robot, "leaks") {
  record(topics::kLeakDetections, "detections", [this](const Detections& m) { on_detections(m); });
  record(topics::kLeakEvents, "events", [this](const Event& m) { on_event(m); });
  record(topics::kTrueLeaks, "truth", [this](const Event& m) { on_truth(m); });
}

void LeakTables::on_detections(const Detections& message) {
  require(message.pipes.size() <= kMaximumPipes && message.leaks.size() <= kMaximumLeaks,
          "more than 1000 pipes or 10000 leaks");
  CsvLine line(from_message(message.header.stamp));
  line.add(message.fault)
      .add(std::uint64_t{message.pipes.size()})
      .add(std::uint64_t{message.leaks.size()});
  add_or_empty(line, message.threshold);
  if (message.pipes.empty()) {
    line.add_empty(2);
  } else {
    const auto& pipe = message.pipes.front();
    add_or_empty(line, std::hypot(pipe.end_u - pipe.start_u, pipe.end_v - pipe.start_v));
    add_or_empty(line, pipe.reference_temperature);
  }
  double largest = std::nan("");
  for (const auto& leak : message.leaks) {
    largest = std::fmax(largest, leak.delta);
  }
  add_or_empty(line, largest);
  file("detections.csv", detections_header).write(line.text());
  tally_.add(message);
}

void LeakTables::on_event(const Event& message) {
  const LeakFinding& finding = message.finding;
  require_finding(finding);
  CsvLine line(from_message(message.header.stamp));
  line.add(kind_name(message.kind))
      .add(finding.id)
      .add(finding.state)
      .add(finding.severity)
      .add(finding.probability);
  if (finding.position_known) {
    line.add(finding.position.x).add(finding.position.y).add(finding.position.z);
    for (const std::size_t variance : {0U, 4U, 8U}) {
      add_or_empty(line, std::sqrt(finding.position_covariance[variance]));
    }
  } else {
    line.add_empty(6);
  }
  for (const double value :
       {finding.length, finding.length_deviation, finding.delta, finding.delta_low,
        finding.delta_high, finding.peak_delta, finding.peak_delta_low, finding.peak_delta_high,
        finding.delta_growth, finding.length_growth}) {
    add_or_empty(line, value);
  }
  line.add(seconds(finding.first_seen))
      .add(seconds(finding.last_seen))
      .add(finding.frames)
      .add(finding.passes);
  file("events.csv", events_header).write(line.text());
  tally_.add(message);
}

void LeakTables::on_truth(const Event& message) {
  const LeakFinding& leak = message.finding;
  require_finding(leak);
  CsvLine line(from_message(message.header.stamp));
  line.add(leak.id).add(leak.position.x).add(leak.position.y).add(leak.position.z);
  add_or_empty(line, leak.length);
  add_or_empty(line, leak.delta);
  file("truth.csv", truth_header).write(line.text());
  tally_.add_truth(leak);
}

}  // namespace

std::unique_ptr<TableMaker> leak_tables(const Robot& robot) {
  return std::make_unique<LeakTables>(robot);
}

}  // namespace pipescout::summary
