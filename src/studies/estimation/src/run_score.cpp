// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/run_score.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "innovation.hpp"
#include "pipescout/estimation_study/sensor_loss.hpp"
#include "pipescout/simulation/uav.hpp"
#include "pipescout/statistics/chi_square.hpp"

namespace pipescout::estimation_study {
namespace {

using Eigen::Vector3d;
using estimation::StateMatrix;
using estimation::StateVector;

double nees_of(const StateVector& error, const StateMatrix& covariance, Eigen::Index first,
               Eigen::Index count) {
  const Eigen::MatrixXd block = covariance.block(first, first, count, count);
  const Eigen::VectorXd part = error.segment(first, count);
  return part.dot(block.ldlt().solve(part));
}

template <class Take>
double root_mean_square(const std::vector<EstimateScore>& estimates, Take&& take) {
  double sum = 0;
  for (const EstimateScore& estimate : estimates) {
    sum += take(estimate).squaredNorm();
  }
  return estimates.empty() ? std::numeric_limits<double>::quiet_NaN()
                           : std::sqrt(sum / static_cast<double>(estimates.size()));
}

/// Feeds one run and takes down what comes of it.
class Scorer {
 public:
  Scorer(const VehicleRun& run, const RunOptions& options,
         const estimation::StateEstimatorParameters& parameters, const ScoreOptions& score)
      : run_(run),
        options_(options),
        score_(score),
        estimator_(parameters),
        innovations_(run.R_body_imu, parameters.smoother.gravity, parameters.smoother.imu_noise) {}

  RunScore score() {
    for (const Event& event : run_.events) {
      if (!event.wrong && std::isfinite(result_.started)) {
        judge_innovation(event);
      }
      if (const auto* reading = std::get_if<estimation::ImuReading>(&event.reading)) {
        innovations_.add(*reading);
      }
      const estimation::Outcome outcome =
          std::visit([&](const auto& reading) { return estimator_.add(reading); }, event.reading);
      judge_refusal(event, outcome);
      judge_lockout(event);
      if (estimator_.updates() != updates_) {
        updates_ = estimator_.updates();
        take_down();
      }
    }
    score_silences();
    score_traps();
    result_.status = estimator_.status();
    std::erase_if(result_.estimates, [&](const EstimateScore& estimate) {
      return estimate.time < result_.started + score_.settling;
    });
    return result_;
  }

 private:
  void judge_refusal(const Event& event, estimation::Outcome outcome) {
    const auto sensor = sensor_of(event.reading);
    const double time = time_of(event.reading);
    if (!sensor || !(time >= result_.started + score_.settling)) {
      return;
    }
    const auto index = static_cast<std::size_t>(*sensor);
    if (outcome == estimation::Outcome::kWaiting) {
      refused_since_[index].reset();
      return;
    }
    RefusalScore& refusal = result_.refusals[index];
    ++refusal.count;
    const double since = refused_since_[index].value_or(time);
    refused_since_[index] = since;
    refusal.longest = std::max(refusal.longest, time - since);
  }

  /// One fix that is gated is the gate's work, several in a row are a lockout.
  void judge_lockout(const Event& event) {
    constexpr double kLongest = 2;  // s
    if (!std::holds_alternative<estimation::GpsMeasurement>(event.reading) || event.wrong ||
        !std::isfinite(result_.started)) {
      return;
    }
    const double time = time_of(event.reading);
    const estimation::EstimatorStatus status = estimator_.status();
    const estimation::SourceStatus& gps = status.of(estimation::Source::kGps);
    const bool said = gps.state == estimation::SourceState::kCandidate ||
                      gps.state == estimation::SourceState::kDoubted;
    if (!(locked_out_since_ <= time) || gps.accepted != gps_accepted_ || said ||
        gps.held + gps.gated == gps_out_) {
      locked_out_since_ = time;
    }
    gps_accepted_ = gps.accepted;
    gps_out_ = gps.held + gps.gated;
    if (time - locked_out_since_ > kLongest) {
      result_.lockout += time - locked_out_since_;
      locked_out_since_ = time;
    }
  }

  void judge_innovation(const Event& event) {
    if (time_of(event.reading) < result_.started + score_.settling) {
      return;
    }
    const auto nis = innovations_.nis(estimator_.smoother(), event.reading);
    if (nis) {
      result_.innovations.push_back({.time = time_of(event.reading), .nis = *nis});
    }
  }

  void take_down() {
    const auto estimate = estimator_.estimate();
    if (!estimate || !estimate->in_map) {
      return;
    }
    if (!std::isfinite(result_.started)) {
      result_.started = estimate->time;
    }
    EstimateScore taken;
    taken.time = estimate->time;
    taken.error = truth_at(run_, estimate->time).local(estimate->state);
    taken.way = way_at(run_, estimate->time);
    if (estimate->time >= next_nees_) {
      next_nees_ = estimate->time + score_.nees_spacing;
      const StateMatrix covariance = estimator_.covariance();
      taken.nees = nees_of(taken.error, covariance, 0, 9);
      for (Eigen::Index part = 0; part < 3; ++part) {
        taken.nees_parts[part] = nees_of(taken.error, covariance, 3 * part, 3);
      }
    }
    result_.estimates.push_back(taken);
  }

  /// The newest estimate before a time.
  [[nodiscard]] const EstimateScore* before(double time) const {
    const auto after = std::ranges::upper_bound(result_.estimates, time, {}, &EstimateScore::time);
    return after == result_.estimates.begin() ? nullptr : &*std::prev(after);
  }

  void score_silences() {
    for (const Silence& silence : options_.silences) {
      const EstimateScore* begin = before(silence.begin);
      const EstimateScore* end = before(silence.begin + silence.duration);
      if (begin == nullptr || end == nullptr) {
        result_.silences.push_back({0, std::numeric_limits<double>::quiet_NaN()});
      } else {
        result_.silences.push_back(
            {.way = end->way - begin->way, .drift = (end->error - begin->error).head<3>().norm()});
      }
    }
  }

  void score_traps() {
    constexpr double kAfter = 30;  // s
    for (const simulation::GpsTrap& trap : options_.traps) {
      const bool captured =
          std::ranges::any_of(result_.estimates, [&](const EstimateScore& estimate) {
            return estimate.time >= trap.begin &&
                   estimate.time < trap.begin + trap.duration + kAfter &&
                   estimate.error.head<3>().norm() > (1 - score_.captured_at) * trap.offset.norm();
          });
      result_.false_reacquisitions += captured ? 1 : 0;
    }
  }

  const VehicleRun& run_;
  const RunOptions& options_;
  const ScoreOptions& score_;
  estimation::StateEstimator estimator_;
  internal::Innovations innovations_;
  RunScore result_;
  std::uint64_t updates_ = 0;
  double next_nees_ = 0;
  std::size_t gps_accepted_ = 0;
  std::size_t gps_out_ = 0;
  double locked_out_since_ = std::numeric_limits<double>::quiet_NaN();  // s
  std::array<std::optional<double>, kSensors> refused_since_{};         // s
};

struct Share {
  double within = 0;
  double below = 0;
  double mean = 0;
};

/// Values by time, averaged over runs where there are several; of `degrees` each.
Share within_bounds(const std::map<long, std::pair<double, int>>& sums, double degrees) {
  constexpr double kOutside = 0.05;
  Share share;
  double total = 0;
  int count = 0;
  for (const auto& [time, sum] : sums) {
    const double all = degrees * sum.second;
    const double low = statistics::chi_square_quantile(0.5 * kOutside, all);
    const double high = statistics::chi_square_quantile(1 - 0.5 * kOutside, all);
    share.below += sum.first < low ? 1 : 0;
    share.within += sum.first >= low && sum.first <= high ? 1 : 0;
    total += sum.first;
    count += sum.second;
  }
  const auto times = static_cast<double>(sums.size());
  share.within /= times;
  share.below /= times;
  share.mean = total / count;
  return share;
}

}  // namespace

estimation::ImuNoise imu_noise(const simulation::ImuParameters& imu) {
  // Of flicker noise of floor B the bias changes over 10 s by 2.3 B (the sum over its processes);
  // a walk of density K by K sqrt(10).
  constexpr double kWalkPerFloor = 0.72;
  constexpr double kLeast = 1e-7;
  const auto white = [&](const simulation::InertialTriadParameters& triad) {
    return std::max(std::hypot(triad.noise_density, triad.resolution * std::sqrt(imu.period / 12)),
                    kLeast);
  };
  const auto walk = [&](const simulation::InertialTriadParameters& triad) {
    return std::max(std::hypot(triad.bias_random_walk, kWalkPerFloor * triad.bias_instability),
                    kLeast);
  };
  return {.gyro = white(imu.gyro),
          .accelerometer = white(imu.accelerometer),
          .gyro_bias = walk(imu.gyro),
          .accelerometer_bias = walk(imu.accelerometer)};
}

estimation::StateEstimatorParameters estimator_parameters(const VehicleRun& run,
                                                          const RunOptions& options) {
  using estimation::StateEstimatorParameters;
  StateEstimatorParameters p = run.vehicle == Vehicle::kGroundRobot
                                   ? StateEstimatorParameters::ground_robot()
                               : run.vehicle == Vehicle::kUav ? StateEstimatorParameters::uav()
                                                              : StateEstimatorParameters::crawler();
  p.gps.correlation_time = 0;  // as told: fixes are independent
  p.gps.height_correlation_time = 0;
  p.R_body_imu = run.R_body_imu;
  p.smoother.gravity = simulation::kGravity;
  p.smoother.imu_noise = imu_noise(options.imu);
  estimation::GlobalDeviations& deviations = p.smoother.global_deviations;
  deviations.gyro_scale = options.imu.gyro.scale_error;
  deviations.gyro_misalignment = options.imu.gyro.misalignment;
  deviations.accelerometer_scale = options.imu.accelerometer.scale_error;
  deviations.accelerometer_misalignment = options.imu.accelerometer.misalignment;
  p.smoother.globals.gps_lever_arm = run.antenna;
  p.odometer.sensor = run.odometer_point;
  // Wheels of a resolution of 1 mm, whose noise their fusion states itself.
  p.odometer.deviation = 0.001;
  p.odometer.share = 0.002;
  if (run.vehicle == Vehicle::kUav) {
    p.visual_pose.correlation_time = 0;  // each of its poses has an error of its own
    p.smoother.globals.rack_position = run.T_map_rack_surveyed.translation();
    p.smoother.globals.R_map_rack = run.T_map_rack_surveyed.rotation();
    deviations.rack_position = run.rack_position_deviation;
    deviations.rack_rotation = run.rack_rotation_deviation;
  }
  if (!run.route.empty()) {
    p.centre_line = estimation::PipeCentreLine(run.route);
    p.centre_line_deviation = run.route_deviation;
    p.centre_line_correlation = run.route_correlation;
    p.tally = run.tally;
    constexpr double kSpeed = 0.35;  // m/s, about which it drives
    p.lateral_deviation = p.vertical_deviation = kSpeed * run.crab_deviation;
    p.lateral_correlation = run.route_correlation;
    // Errors of counting telescope: no more than that of one end is new in each increment.
    p.odometer.deviation = 0.0003;
    deviations.odometer_scale = run.odometer_scale_deviation;
  }
  return p;
}

double RunScore::position_coverage() const {
  static const double kQuantile = statistics::chi_square_quantile(0.95, 3);
  std::size_t all = 0;
  std::size_t within = 0;
  for (const EstimateScore& estimate : estimates) {
    if (std::isfinite(estimate.nees_parts[0])) {
      ++all;
      within += estimate.nees_parts[0] <= kQuantile ? 1U : 0U;
    }
  }
  return static_cast<double>(within) / static_cast<double>(all);
}

double RunScore::position_rmse() const {
  return root_mean_square(estimates, [](const EstimateScore& e) { return e.error.head<3>(); });
}

double RunScore::rotation_rmse() const {
  return root_mean_square(estimates, [](const EstimateScore& e) { return e.error.segment<3>(3); });
}

double RunScore::velocity_rmse() const {
  return root_mean_square(estimates, [](const EstimateScore& e) { return e.error.segment<3>(6); });
}

double RunScore::largest_position_error() const {
  double largest = 0;
  for (const EstimateScore& estimate : estimates) {
    largest = std::max(largest, estimate.error.head<3>().norm());
  }
  return largest;
}

RunScore score_run(const VehicleRun& run, const RunOptions& options,
                   const estimation::StateEstimatorParameters& parameters,
                   const ScoreOptions& score) {
  return Scorer(run, options, parameters, score).score();
}

Consistency consistency(std::span<const RunScore> runs) {
  std::map<long, std::pair<double, int>> nees;  // by whole seconds
  std::map<long, std::pair<double, int>> nis;
  const auto add = [](auto& sums, double time, double value) {
    auto& [sum, count] = sums[std::lround(time)];
    sum += value;
    ++count;
  };
  for (const RunScore& run : runs) {
    for (const EstimateScore& estimate : run.estimates) {
      if (std::isfinite(estimate.nees)) {
        add(nees, estimate.time, estimate.nees);
      }
    }
    for (const InnovationScore& innovation : run.innovations) {
      add(nis, innovation.time, innovation.nis);
    }
  }
  const Share of_nees = within_bounds(nees, 9);
  const Share of_nis = within_bounds(nis, 3);
  return {.nees = of_nees.mean,
          .nis = of_nis.mean,
          .nees_share = of_nees.within,
          .nees_below = of_nees.below,
          .nis_share = of_nis.within};
}

}  // namespace pipescout::estimation_study
