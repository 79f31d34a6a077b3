// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout_msgs/msg/estimator_state.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <stdexcept>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <utility>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/map_origin.hpp"
#include "pipescout/mission_tables/pose_csv.hpp"
#include "pipescout/mission_tables/thinning.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/validation/number_text.hpp"
#include "tables/estimator_lines.hpp"
#include "tables/estimator_report.hpp"
#include "tables/makers.hpp"
#include "tables/values.hpp"

namespace pipescout::summary {

namespace {

/// In one message; more than any estimator has.
constexpr std::size_t kMaximumSources = 32;
constexpr std::size_t kMaximumFactors = 4096;
constexpr std::size_t kLongestName = 40;

/// Names of sources become names of figures.
bool is_name(const std::string& text) {
  return !text.empty() && text.size() <= kLongestName &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
         });
}

void require_lists(const pipescout_msgs::msg::EstimatorState& message) {
  const std::size_t sources = message.source.size();
  const std::size_t factors = message.factor.size();
  require(sources <= kMaximumSources && message.source_state.size() == sources &&
              message.source_accepted.size() == sources && message.source_gated.size() == sources &&
              message.source_held.size() == sources && message.source_refused.size() == sources,
          "the lists of its sources have different lengths, or more than 32 entries");
  require(factors <= kMaximumFactors && message.factor_stamp.size() == factors &&
              message.factor_outcome.size() == factors &&
              message.factor_chi_square.size() == factors &&
              message.factor_degrees.size() == factors && message.factor_weight.size() == factors,
          "the lists of its factors have different lengths, or more than 4096 entries");
  require(std::all_of(message.source.begin(), message.source.end(), is_name),
          "the name of a source has characters other than a-z, 0-9 and _");
}

void require_finite(const geometry_msgs::msg::Twist& twist) {
  for (const auto& vector : {twist.linear, twist.angular}) {
    require(std::isfinite(vector.x) && std::isfinite(vector.y) && std::isfinite(vector.z),
            "a velocity is not finite");
  }
}

/// An unknown altitude is taken as 0.
geometry::GeodeticPosition on_the_ellipsoid(geometry::GeodeticPosition place) {
  place.altitude = std::isnan(place.altitude) ? 0.0 : place.altitude;
  return place;
}

class EstimatorTables final : public TableMaker {
 public:
  EstimatorTables(const Robot& robot, const TableOptions::Estimator& options);

 protected:
  MissionSection section(const std::string& figure_prefix) const override;
  std::string counts() const override {
    return std::to_string(report_.estimates()) + " estimates and " +
           std::to_string(report_.keyframes()) + " keyframes received";
  }
  bool has_data() const override { return report_.estimates() > 0; }
  /// An estimator that never got to run says why not.
  bool has_section() const override { return report_.estimates() > 0 || has_states_; }
  std::string file_names() const override {
    return "estimate.csv, state.csv, factors.csv, sources.csv, truth.csv, errors.csv, gps.csv";
  }

 private:
  using Odometry = nav_msgs::msg::Odometry;
  using State = pipescout_msgs::msg::EstimatorState;
  using Fix = sensor_msgs::msg::NavSatFix;
  using Transforms = tf2_msgs::msg::TFMessage;

  void on_estimate(const Odometry& message);
  void on_truth(const Odometry& message);
  void on_state(const State& message);
  void on_fix(const Fix& message);
  void on_transforms(const Transforms& message);
  void begin_map(const std::vector<double>& datum);
  void write_fix(const GpsPlace& fix);
  void write_waiting();
  void write_last() override;

  EstimatorReport report_;
  bool has_states_ = false;
  Thinning estimate_thinning_;
  Thinning truth_thinning_;
  std::optional<geometry::LocalFrame> map_;  // once its origin is known
  std::string origin_source_;                // of the map
  bool is_given_ = false;                    // the origin, by an option
  std::vector<GpsPlace> waiting_;            // fixes from before it was known
};

EstimatorTables::EstimatorTables(const Robot& robot, const TableOptions::Estimator& options)
    : TableMaker(robot, "estimator"),
      report_(
          [this](const EstimatorReport::Estimate& estimate, const EstimatorReport::Error& error) {
            if (estimate.recorded) {
              file("errors.csv", error_csv_header).write(error_csv_line(estimate.stamp, error));
            }
          }),
      estimate_thinning_(from_seconds(options.period)),
      truth_thinning_(estimate_thinning_) {
  begin_map(options.datum);
  record(topics::kOdometryFiltered, "estimates", [this](const Odometry& m) { on_estimate(m); });
  record(topics::kTrueOdometry, "truth", [this](const Odometry& m) { on_truth(m); });
  record(topics::kEstimatorState, "states", [this](const State& m) { on_state(m); });
  record(topics::kGpsFix, "fixes", [this](const Fix& m) { on_fix(m); });
  record(topics::kTf, "transforms", [this](const Transforms& m) { on_transforms(m); });
}

void EstimatorTables::begin_map(const std::vector<double>& datum) {
  if (datum.empty()) {
    return;
  }
  if (datum.size() != 3) {
    throw std::invalid_argument("summary.estimator.datum has " + std::to_string(datum.size()) +
                                " values; it must have 3 or none");
  }
  try {
    map_.emplace(geometry::GeodeticPosition{datum[0], datum[1], datum[2]});
    is_given_ = true;
    origin_source_ = "as summary.estimator.datum gives it";
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("summary.estimator.datum: ") + error.what());
  }
}

void EstimatorTables::on_estimate(const Odometry& message) {
  require_finite(message.twist.twist);
  EstimatorReport::Estimate estimate{
      .stamp = from_message(message.header.stamp),
      .T_map_base = from_message(message.pose.pose),
      .covariance = covariance_from_message(message.pose.covariance),
  };
  estimate.recorded = estimate_thinning_.due(estimate.stamp);
  if (estimate.recorded) {
    file("estimate.csv", estimate_csv_header)
        .write(estimate_csv_line(message, estimate.T_map_base, estimate.covariance));
    estimate_thinning_.keep(estimate.stamp);
  }
  report_.add_estimate(estimate);
}

void EstimatorTables::on_truth(const Odometry& message) {
  const Time stamp = from_message(message.header.stamp);
  const geometry::SE3 T_map_base = from_message(message.pose.pose);
  if (truth_thinning_.due(stamp)) {
    file("truth.csv", pose_csv_header).write(pose_csv_line(stamp, T_map_base).text());
    truth_thinning_.keep(stamp);
  }
  report_.add_truth(stamp, T_map_base);
}

void EstimatorTables::on_state(const State& message) {
  require_lists(message);
  has_states_ = true;
  file("state.csv", estimator_state_csv_header).write(estimator_state_csv_line(message));
  for (std::size_t factor = 0; factor < message.factor.size(); ++factor) {
    file("factors.csv", factor_csv_header).write(factor_csv_line(message, factor));
  }
  for (const std::size_t source : report_.add_state(message)) {
    file("sources.csv", source_csv_header).write(source_csv_line(message, source));
  }
}

void EstimatorTables::on_fix(const Fix& message) {
  if (message.status.status < sensor_msgs::msg::NavSatStatus::STATUS_FIX) {
    return;
  }
  const GpsPlace fix{from_message(message.header.stamp),
                     {message.latitude, message.longitude, message.altitude}};
  on_the_ellipsoid(fix.place).validate();
  if (map_) {
    write_fix(fix);
  } else {
    waiting_.push_back(fix);
  }
}

/// What the estimator tells: once it has its datum, and again where it starts anew with another.
void EstimatorTables::on_transforms(const Transforms& message) {
  if (is_given_) {
    return;
  }
  if (const auto origin = map_origin(message)) {
    map_.emplace(*origin);
    origin_source_ = "as the estimator tells it";
    write_waiting();
  }
}

void EstimatorTables::write_fix(const GpsPlace& fix) {
  file("gps.csv", gps_csv_header)
      .write(gps_csv_line(fix, map_->position(on_the_ellipsoid(fix.place))));
}

void EstimatorTables::write_waiting() {
  for (const GpsPlace& fix : waiting_) {
    write_fix(fix);
  }
  waiting_.clear();
}

void EstimatorTables::write_last() {
  if (!map_ && !waiting_.empty()) {
    map_.emplace(on_the_ellipsoid(waiting_.front().place));
    origin_source_ =
        "which is the first fix: the bag does not tell the estimator's (option estimator.datum "
        "does), "
        "so that gps.csv may be shifted against the estimate";
    write_waiting();
  }
}

MissionSection EstimatorTables::section(const std::string& figure_prefix) const {
  MissionSection section = report_.section(figure_prefix);
  if (map_ && !origin_source_.empty()) {
    const geometry::GeodeticPosition& datum = map_->datum();
    section.notes.push_back("Origin of the map: " + validation::fixed_text(datum.latitude, 7) +
                            ", " + validation::fixed_text(datum.longitude, 7) + ", " +
                            validation::fixed_text(datum.altitude, 2) + " m, " + origin_source_ +
                            ".");
  }
  return section;
}

}  // namespace

std::unique_ptr<TableMaker> estimator_tables(const Robot& robot,
                                             const TableOptions::Estimator& options) {
  return std::make_unique<EstimatorTables>(robot, options);
}

}  // namespace pipescout::summary
