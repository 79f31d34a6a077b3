// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nav_msgs/msg/occupancy_grid.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <nav_msgs/msg/path.hpp>
#include <optional>
#include <pipescout_msgs/msg/navigator_state.hpp>
#include <pipescout_msgs/msg/pipe_coverage.hpp>
#include <string>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/csv/csv_line.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "tables/makers.hpp"
#include "tables/values.hpp"

namespace pipescout::summary {
namespace {

using pipescout_msgs::msg::NavigatorState;
using pipescout_msgs::msg::PipeCoverage;
using CostmapMessage = nav_msgs::msg::OccupancyGrid;
using PathMessage = nav_msgs::msg::Path;
using OdometryMessage = nav_msgs::msg::Odometry;

constexpr double kStands = 0.02;  // m/s
constexpr double kThousandths = 1e3;
constexpr std::size_t kMostPoses = 1'000'000;  // of one path; more than any plant has

std::string navigation_header() {
  return "stamp,state,drive,reason,inspection,failure,speed,curvature,travelled,remaining,"
         "lateral_error,heading_error,offset,free_distance,replans,passed";
}

std::string way_header() {
  return "stamp,x,y,yaw,speed";
}

std::string plan_header() {
  return "stamp,plan,x,y,yaw";
}

std::string obstacles_header() {
  return "stamp,x,y,times";
}

std::string coverage_header() {
  return "stamp,row,from,to,sharp,blur,temperature";
}

double yaw_of(const geometry_msgs::msg::Quaternion& q) {
  return std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
}

class NavigationTables final : public TableMaker {
 public:
  explicit NavigationTables(const Robot& robot) : TableMaker(robot, "navigation") {
    record(topics::kNavigatorState, "states", [this](const NavigatorState& m) { on_state(m); });
    record(topics::kPlan, "plans", [this](const PathMessage& m) { on_plan(m); });
    record(topics::kOdometryFiltered, "odometry",
           [this](const OdometryMessage& m) { on_pose(m, "localisation.csv"); });
    record(topics::kTrueOdometry, "truth",
           [this](const OdometryMessage& m) { on_pose(m, "truth.csv"); });
    record(topics::kNavigatorCostmap, "costmaps",
           [this](const CostmapMessage& m) { on_costmap(m); });
    record(topics::kPipeCoverage, "coverages", [this](const PipeCoverage& m) {
      require(m.sharp.size() == m.blur.size() && m.sharp.size() == m.temperature.size(),
              "sharp, blur and temperature have different lengths");
      coverage_.insert_or_assign(m.row, m);
    });
  }

 protected:
  MissionSection section(const std::string& prefix) const override {
    MissionSection result;
    result.title = "Navigation";
    result.columns = {"what", "value"};
    const auto add = [&](const char* name, const char* figure, double value) {
      result.rows.push_back({std::string(name), rounded_cell(value, kThousandths)});
      result.figures[prefix + figure] = rounded(value, kThousandths);
    };
    add("driven [m]", "navigation_driven_m", driven_);
    add("driving or waiting [s]", "navigation_time_s", under_way_);
    add("of it, standing [s]", "navigation_standing_s", standing_);
    add("paths planned", "navigation_plans", static_cast<double>(plans_));
    add("rows and nodes passed", "navigation_passed", passed_);
    add("largest lateral error [m]", "navigation_lateral_error_worst_m", lateral_);
    add("longest gap between commands [s]", "navigation_command_gap_s", gap_);
    return result;
  }
  std::string counts() const override {
    return std::to_string(cycles_) + " cycles of the navigator received";
  }
  bool has_data() const override { return cycles_ > 0; }
  bool has_section() const override { return cycles_ > 0; }
  void write_last() override;
  std::string file_names() const override {
    return "state.csv, plan.csv, localisation.csv, truth.csv";
  }

 private:
  void on_state(const NavigatorState& message);
  void on_plan(const PathMessage& message);
  void on_pose(const OdometryMessage& message, const char* name);
  void on_costmap(const CostmapMessage& message);
  std::uint64_t cycles_ = 0;
  std::uint64_t plans_ = 0;
  std::optional<double> last_;  // s
  double driven_ = 0;
  double under_way_ = 0;
  double standing_ = 0;
  double passed_ = 0;
  double lateral_ = 0;
  double gap_ = 0;
  struct Occupied {
    Time first{};
    std::uint64_t times = 0;
  };
  std::map<std::pair<double, double>, Occupied> occupied_;  // by centre of the cell, m
  std::map<std::int64_t, PipeCoverage> coverage_;           // by row, the last
};

void NavigationTables::on_costmap(const CostmapMessage& message) {
  const auto& info = message.info;
  require(info.resolution > 0 && message.data.size() == std::size_t{info.width} * info.height,
          "a costmap is not as large as it says");
  constexpr std::int8_t kOccupied = 65;  // %
  constexpr double kCentimetres = 100;   // cells of successive costmaps meet
  for (std::size_t i = 0; i < message.data.size(); ++i) {
    if (message.data[i] < kOccupied) {
      continue;
    }
    const auto step = static_cast<double>(info.resolution);
    const double x = info.origin.position.x + (static_cast<double>(i % info.width) + 0.5) * step;
    const double y = info.origin.position.y + (static_cast<double>(i / info.width) + 0.5) * step;
    Occupied& cell = occupied_[{rounded(x, kCentimetres), rounded(y, kCentimetres)}];
    if (cell.times++ == 0) {
      cell.first = from_message(message.header.stamp);
    }
  }
}

void NavigationTables::write_last() {
  for (const auto& [place, cell] : occupied_) {
    CsvLine line(cell.first);
    line.add(place.first).add(place.second).add(cell.times);
    file("obstacles.csv", obstacles_header).write(line.text());
  }
  for (const auto& [row, coverage] : coverage_) {
    for (std::size_t i = 0; i < coverage.sharp.size(); ++i) {
      CsvLine line(from_message(coverage.header.stamp));
      line.add(static_cast<double>(row))
          .add(static_cast<double>(i) * coverage.cell)
          .add(static_cast<double>(i + 1) * coverage.cell)
          .add(static_cast<bool>(coverage.sharp[i]));
      add_or_empty(line, static_cast<double>(coverage.blur[i]));
      add_or_empty(line, static_cast<double>(coverage.temperature[i]));
      file("coverage.csv", coverage_header).write(line.text());
    }
  }
}

void NavigationTables::on_state(const NavigatorState& message) {
  require(std::isfinite(message.speed + message.travelled + message.lateral_error),
          "a value is not finite");
  const Time stamp = from_message(message.header.stamp);
  const double time = to_seconds(stamp.time_since_epoch());
  const double step = last_ ? time - *last_ : 0;
  last_ = time;
  ++cycles_;
  gap_ = std::max(gap_, step);
  driven_ += std::abs(message.speed) * step;
  if (message.state == "driving") {
    under_way_ += step;
    standing_ += std::abs(message.speed) < kStands ? step : 0;
    lateral_ = std::max(lateral_, std::abs(message.lateral_error));
  }
  passed_ = std::max(passed_, static_cast<double>(message.passed));
  CsvLine line(stamp);
  line.add(message.state)
      .add(message.drive)
      .add(message.reason)
      .add(message.inspection)
      .add(message.failure);
  for (const double value :
       {message.speed, message.curvature, message.travelled, message.remaining,
        message.lateral_error, message.heading_error, message.offset, message.free_distance}) {
    add_or_empty(line, value);
  }
  line.add(std::uint64_t{message.replans}).add(std::uint64_t{message.passed});
  file("state.csv", navigation_header).write(line.text());
}

void NavigationTables::on_plan(const PathMessage& message) {
  require(message.poses.size() <= kMostPoses, "a path has more than 1000000 poses");
  ++plans_;
  for (const auto& each : message.poses) {
    CsvLine line(from_message(message.header.stamp));
    line.add(plans_);
    add_or_empty(line, each.pose.position.x);
    add_or_empty(line, each.pose.position.y);
    add_or_empty(line, yaw_of(each.pose.orientation));
    file("plan.csv", plan_header).write(line.text());
  }
}

void NavigationTables::on_pose(const OdometryMessage& message, const char* name) {
  // Of a robot that has no navigator they are others' business.
  if (cycles_ == 0) {
    return;
  }
  CsvLine line(from_message(message.header.stamp));
  add_or_empty(line, message.pose.pose.position.x);
  add_or_empty(line, message.pose.pose.position.y);
  add_or_empty(line, yaw_of(message.pose.pose.orientation));
  add_or_empty(line, message.twist.twist.linear.x);
  file(name, way_header).write(line.text());
}

}  // namespace

std::unique_ptr<TableMaker> navigation_tables(const Robot& robot) {
  return std::make_unique<NavigationTables>(robot);
}

}  // namespace pipescout::summary
