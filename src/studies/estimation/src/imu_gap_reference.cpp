// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/imu_gap_reference.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace pipescout::estimation_study {
namespace {

using Eigen::Vector3d;
using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Vector9d = Eigen::Matrix<double, 9, 1>;

constexpr double kStep = 0.01;        // s
constexpr double kShortestGap = 0.1;  // s: what is shorter costs nothing
/// s, of what arrives later than the time of an estimate: the newest keyframe waits that long.
constexpr double kWaits = 0.1;

struct Gap {
  double begin = 0;
  double end = 0;
};

/// Position of the body in the map, by one reading and the truth about all else.
struct Seen {
  double time = 0;
  double arrival = 0;
  Vector3d position = Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// How the robot steers.
struct Steering {
  double horizontal = 1;   // m/s^2, standard deviation of the acceleration per axis
  double vertical = 1;     // m/s^2
  double correlation = 1;  // s
};

std::vector<Gap> gaps_of(const VehicleRun& run) {
  std::vector<double> times;
  for (const Event& event : run.events) {
    if (const auto* reading = std::get_if<estimation::ImuReading>(&event.reading)) {
      times.push_back(reading->time);
    }
  }
  std::vector<Gap> gaps;
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] - times[i - 1] > kShortestGap) {
      gaps.push_back({times[i - 1], times[i]});
    }
  }
  return gaps;
}

std::vector<Seen> seen_in(const VehicleRun& run) {
  std::vector<Seen> all;
  for (const Event& event : run.events) {
    if (event.wrong) {
      continue;
    }
    if (const auto* fix = std::get_if<estimation::GpsMeasurement>(&event.reading)) {
      const auto there = truth_at(run, fix->time);
      all.push_back({fix->time, event.arrival, fix->position - there.R_map_body * run.antenna,
                     fix->covariance});
    } else if (const auto* pose = std::get_if<estimation::VisualPoseMeasurement>(&event.reading)) {
      const Eigen::Matrix3d R = run.T_map_rack.rotation().matrix();
      all.push_back({pose->time, event.arrival, run.T_map_rack * pose->T_rack_body.translation(),
                     R * pose->covariance.topLeftCorner<3, 3>() * R.transpose()});
    }
  }
  std::ranges::stable_sort(all, {}, &Seen::time);
  return all;
}

class GapFilter {
 public:
  GapFilter(const VehicleRun& run, const Steering& steering, double begin)
      : run_(run), time_(begin) {
    const auto there = truth_at(run, begin);
    const auto before = truth_at(run, begin - kStep);
    state_ << there.position, there.velocity, (there.velocity - before.velocity) / kStep;
    const double kept = std::exp(-kStep / steering.correlation);
    to_next_.block<3, 3>(0, 3).diagonal().setConstant(kStep);
    to_next_.block<3, 3>(0, 6).diagonal().setConstant(0.5 * kStep * kStep);
    to_next_.block<3, 3>(3, 6).diagonal().setConstant(kStep);
    to_next_.block<3, 3>(6, 6).diagonal().setConstant(kept);
    new_variance_ << steering.horizontal, steering.horizontal, steering.vertical;
    new_variance_ = (1 - kept * kept) * new_variance_.cwiseAbs2();
  }

  void advance(double until) {
    while (until > time_ + 0.5 * kStep) {
      time_ += kStep;
      state_ = to_next_ * state_;
      covariance_ = to_next_ * covariance_ * to_next_.transpose();
      covariance_.diagonal().tail<3>() += new_variance_;
      if (run_.vehicle != Vehicle::kUav) {
        see_speed();
      }
    }
  }
  void see(const Seen& seen) {
    advance(seen.time);
    const Eigen::Matrix<double, 9, 3> by = covariance_.leftCols<3>();
    const Eigen::Matrix3d s = covariance_.topLeftCorner<3, 3>() + seen.covariance;
    const Eigen::Matrix<double, 9, 3> gain = s.ldlt().solve(by.transpose()).transpose();
    state_ += gain * (seen.position - state_.head<3>());
    covariance_ -= gain * by.transpose();
  }
  [[nodiscard]] Vector3d position() const { return state_.head<3>(); }

 private:
  /// By wheels without errors.
  void see_speed() {
    constexpr double kDeviation = 1e-3;  // m/s
    constexpr double kLeast = 1e-3;      // m/s
    const Vector3d velocity = state_.segment<3>(3);
    const double speed = velocity.norm();
    if (speed < kLeast) {
      return;
    }
    const Vector9d by = covariance_.middleCols<3>(3) * velocity / speed;
    const double s = by.segment<3>(3).dot(velocity) / speed + kDeviation * kDeviation;
    state_ += by * (truth_at(run_, time_).velocity.norm() - speed) / s;
    covariance_ -= by * by.transpose() / s;
  }

  const VehicleRun& run_;
  double time_;
  Vector9d state_ = Vector9d::Zero();
  Matrix9d covariance_ = Matrix9d::Zero();
  Matrix9d to_next_ = Matrix9d::Identity();
  Vector3d new_variance_ = Vector3d::Zero();
};

/// m^2, sum of the squares over those of `estimates` that lie in the gap.
double sum_of_squares(const VehicleRun& run, const Gap& gap, const std::vector<Seen>& seen,
                      const std::vector<EstimateScore>& estimates, const Steering& steering) {
  GapFilter filter(run, steering, gap.begin);
  auto next = std::ranges::upper_bound(seen, gap.begin, {}, &Seen::time);
  double sum = 0;
  for (auto at = std::ranges::upper_bound(estimates, gap.begin, {}, &EstimateScore::time);
       at != estimates.end() && at->time < gap.end; ++at) {
    while (next != seen.end() && next->time <= at->time && next->arrival <= at->time + kWaits) {
      filter.see(*next++);
    }
    GapFilter ahead = filter;
    ahead.advance(at->time);
    sum += (ahead.position() - truth_at(run, at->time).position).squaredNorm();
  }
  return sum;
}

}  // namespace

double imu_gap_reference(const VehicleRun& run, const RunScore& lossy, const RunScore& whole) {
  const std::vector<EstimateScore>& estimates = lossy.estimates;
  if (estimates.empty() || whole.estimates.empty()) {
    return std::numeric_limits<double>::infinity();
  }
  const std::vector<Gap> gaps = gaps_of(run);
  const std::vector<Seen> seen = seen_in(run);
  double outside = 0;
  std::size_t gap = 0;
  for (const EstimateScore& estimate : estimates) {
    while (gap < gaps.size() && gaps[gap].end <= estimate.time) {
      ++gap;
    }
    if (gap == gaps.size() || estimate.time <= gaps[gap].begin) {
      const auto same =
          std::ranges::lower_bound(whole.estimates, estimate.time, {}, &EstimateScore::time);
      const EstimateScore& known = same == whole.estimates.end() ? whole.estimates.back() : *same;
      outside += known.error.head<3>().squaredNorm();
    }
  }
  double inside = std::numeric_limits<double>::infinity();
  for (const double horizontal : {0.1, 0.3, 1.0, 3.0}) {
    for (const double vertical : {0.1, 0.3, 1.0}) {
      for (const double correlation : {0.1, 0.3, 1.0, 3.0}) {
        double sum = 0;
        for (const Gap& one : gaps) {
          sum += sum_of_squares(run, one, seen, estimates,
                                {horizontal, vertical * horizontal, correlation});
        }
        inside = std::min(inside, sum);
      }
    }
  }
  return std::sqrt((outside + inside) / static_cast<double>(estimates.size()));
}

}  // namespace pipescout::estimation_study
