// SPDX-License-Identifier: Apache-2.0
#include "tables/rack_report.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipescout/statistics/normal.hpp"
#include "tables/values.hpp"

namespace pipescout::summary {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace

void RackReport::add_pose(const Pose& pose) {
  ++poses_;
  pairing_.add_estimate(
      pose, [this](const Pose& known, const geometry::SE3& truth) { compare(known, truth); });
}

void RackReport::add_truth(Time stamp, const geometry::SE3& T_rack_camera) {
  pairing_.add_truth(stamp, T_rack_camera, [this](const Pose& known, const geometry::SE3& truth) {
    compare(known, truth);
  });
}

void RackReport::compare(const Pose& pose, const geometry::SE3& truth) {
  geometry::Vector6d error;
  error.head<3>() = pose.T_rack_camera.translation() - truth.translation();
  error.tail<3>() = (pose.T_rack_camera.rotation() * truth.rotation().inverse()).log();
  const geometry::Vector6d& deviation = pose.standard_deviation;
  for (int k = 0; k < 6; ++k) {
    Measure& axis = axes_.at(static_cast<std::size_t>(k));
    axis.errors.add(error[k]);
    axis.covered += std::abs(error[k]) <= statistics::kNormal95 * deviation[k] ? 1 : 0;
    axis.sum_of_variances += deviation[k] * deviation[k];
  }
  position_.errors.add(error.head<3>().norm());
  position_.sum_of_variances += deviation.head<3>().squaredNorm();
  orientation_.errors.add(error.tail<3>().norm());
  orientation_.sum_of_variances += deviation.tail<3>().squaredNorm();
}

void RackReport::add_state(Time stamp, bool tracking, std::uint64_t losses) {
  ++states_;
  // A localizer that was started again counts from 0.
  losses_ += losses >= losses_said_ ? losses - losses_said_ : losses;
  losses_said_ = losses;
  states_since_tracked_ += tracking ? 0 : 1;
  if (last_tracked_ && states_since_tracked_ > 0) {
    longest_without_ = std::max(longest_without_, stamp - *last_tracked_);
  }
  if (tracking) {
    ++tracked_;
    last_tracked_ = stamp;
    states_since_tracked_ = 0;
  }
}

void RackReport::set_way_points(std::uint64_t done, std::uint64_t of, const std::string& text) {
  way_points_done_ = done;
  way_points_ = of;
  way_points_text_ = text;
}

MissionSection RackReport::section(const std::string& figure_prefix) const {
  MissionSection section;
  section.title = "Flight over the rack";
  const auto set = [&](const char* name, double value) {
    section.figures[figure_prefix + "rack_" + name] = value;
  };
  set("poses", static_cast<double>(poses_));
  set("images", static_cast<double>(states_));
  set("losses", static_cast<double>(losses_));
  if (states_ > 0) {
    set("tracked_percent",
        std::round(1e4 * static_cast<double>(tracked_) / static_cast<double>(states_)) / 1e2);
  }
  if (tracked_ > 0) {
    set("longest_loss_s", std::round(to_seconds(longest_without_) * 1e3) / 1e3);
  }
  if (way_points_ > 0) {
    set("way_points", static_cast<double>(way_points_));
    set("way_points_done", static_cast<double>(way_points_done_));
  }
  if (position_.errors.count() > 0) {
    add_table(section);
    const auto set_error = [&](const std::string& name, const ErrorHistogram& errors, double unit,
                               const char* suffix) {
      set((name + "_median_" + suffix).c_str(), errors.quantile(0.5) / unit);
      set((name + "_p95_" + suffix).c_str(), errors.quantile(0.95) / unit);
    };
    set_error("position", position_.errors, 1.0, "m");
    set_error("across", axes_[0].errors, 1.0, "m");
    set_error("along", axes_[1].errors, 1.0, "m");
    set_error("up", axes_[2].errors, 1.0, "m");
    set_error("orientation", orientation_.errors, kDegree, "deg");
  }
  add_notes(section);
  return section;
}

void RackReport::add_table(MissionSection& section) const {
  section.columns = {
      "error",           "unit", "median", "95 %", "largest", "estimated standard deviation",
      "within 1.96 [%]",
  };
  const auto row = [&](const char* name, const char* unit_name, const Measure& measure, double unit,
                       bool of_one_axis) {
    const auto count = static_cast<double>(measure.errors.count());
    constexpr double kParts = 1e5;
    section.rows.push_back(
        {std::string(name), std::string(unit_name),
         rounded_cell(measure.errors.quantile(0.5) / unit, kParts),
         rounded_cell(measure.errors.quantile(0.95) / unit, kParts),
         rounded_cell(measure.errors.largest() / unit, kParts),
         rounded_cell(std::sqrt(measure.sum_of_variances / count) / unit, kParts),
         of_one_axis ? rounded_cell(100.0 * static_cast<double>(measure.covered) / count, 10.0)
                     : MissionCell()});
  };
  row("position", "m", position_, 1.0, false);
  row("across the pipes", "m", axes_[0], 1.0, true);
  row("along the pipes", "m", axes_[1], 1.0, true);
  row("up", "m", axes_[2], 1.0, true);
  row("orientation", "deg", orientation_, kDegree, false);
  row("about the axis across", "deg", axes_[3], kDegree, true);
  row("about the axis along", "deg", axes_[4], kDegree, true);
  row("about the vertical", "deg", axes_[5], kDegree, true);
}

void RackReport::add_notes(MissionSection& section) const {
  if (poses_ > 0) {
    section.notes.push_back(position_.errors.count() > 0
                                ? "Errors of " + std::to_string(position_.errors.count()) +
                                      " poses compared with the truth of the simulation; the "
                                      "standard deviation is the root of the mean variance."
                                : "No ground truth is available at the times of the poses.");
  }
  if (!way_points_text_.empty()) {
    section.notes.push_back("The source: " + way_points_text_ + ".");
  }
  if (losses_ > 0) {
    section.notes.push_back("The pose was lost " + std::to_string(losses_) +
                            (losses_ == 1 ? " time." : " times."));
  }
}

}  // namespace pipescout::summary
