// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/lawnmower_recording.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "pipescout/csv/number_table.hpp"
#include "pipescout/estimation/state_estimator.hpp"
#include "pipescout/statistics/chi_square.hpp"

namespace pipescout::estimation_study {
namespace {

using Eigen::Vector2d;

constexpr double kOdometerVariance = 1e-3;  // m^2 per m, over grass

estimation::StateEstimatorParameters parameters() {
  auto result = estimation::StateEstimatorParameters::ground_robot();
  result.keyframe_period = 0.2;
  // Ten steps a second take the place of the IMU.
  result.largest_imu_gap = 0.5;
  result.imu_silence = 1;
  result.smoother.max_held_imu = 0.5;
  // Steps of the standing mower scatter by 5e-5 rad.
  result.smoother.imu_noise.gyro = 5e-4;
  result.smoother.imu_noise.gyro_bias = 1e-4;  // warms up, on a shaking machine
  // There is none: nothing is to follow from it. At 0.5 the odometer's scale went to 0.8, against
  // the centripetal force that it does not feel.
  result.smoother.imu_noise.accelerometer = 20;
  result.odometer.largest_gap = 1;
  result.start.levelling = 5;
  result.standstill.still_distance = 0.02;  // the wheels of the standing mower creep
  return result;
}

void add(const Vector2d& error, DeadReckoningScore& score) {
  score.end = error.norm();
  score.largest = std::max(score.largest, score.end);
  score.rms += error.squaredNorm();
}

using Rows = std::vector<std::vector<double>>;

/// rad, of the vehicle at the beginning.
double first_heading(const Rows& reference, ReferenceHeading heading) {
  return reference[0][3] + (heading == ReferenceHeading::kBackwards ? M_PI : 0.0);
}

/// Without an estimator: the sum of the steps, less a bias of the gyro, rad/s.
DeadReckoningScore sum_up(const Rows& steps, const Rows& reference, double heading, double bias) {
  Vector2d position(reference[0][1], reference[0][2]);
  double time = reference[0][0];
  double count = 0;
  std::size_t next = 0;
  DeadReckoningScore score;
  for (const auto& row : steps) {
    const double dt = row[0] - time;
    if (dt <= 0) {
      continue;
    }
    time = row[0];
    const double turn = row[2] - bias * dt;
    position += row[1] * Vector2d(std::cos(heading + turn / 2), std::sin(heading + turn / 2));
    heading += turn;
    while (next + 1 < reference.size() && reference[next + 1][0] <= time) {
      ++next;
    }
    add(position - Vector2d(reference[next][1], reference[next][2]), score);
    count += 1;
  }
  score.rms = std::sqrt(score.rms / count);
  return score;
}

/// rad/s, of the mower that stands at the beginning.
double standing_rate(const Rows& steps) {
  constexpr double kCreeping = 0.02;  // m/s
  double turned = 0;
  std::size_t last = 0;
  while (last + 1 < steps.size() &&
         std::abs(steps[last + 1][1]) < kCreeping * (steps[last + 1][0] - steps[last][0])) {
    turned += steps[++last][2];
  }
  return last > 0 ? turned / (steps[last][0] - steps[0][0]) : 0;
}

/// rad/s, the constant bias with which the sum of the steps is nearest to the reference.
double best_rate(const Rows& steps, const Rows& reference, double heading, double around) {
  constexpr int kEachSide = 10;
  double best = around;
  for (const double step : {3e-4, 3e-5, 3e-6}) {  // rad/s
    const double middle = best;
    double least = std::numeric_limits<double>::infinity();
    for (int i = -kEachSide; i <= kEachSide; ++i) {
      const double rms = sum_up(steps, reference, heading, middle + i * step).rms;
      if (rms < least) {
        least = rms;
        best = middle + i * step;
      }
    }
  }
  return best;
}

}  // namespace

LawnmowerScore score_lawnmower(std::string_view steps_text, std::string_view reference_text,
                               ReferenceHeading reference_heading) {
  const auto steps = number_table(steps_text, "the steps", false, 3);
  const auto reference = number_table(reference_text, "the reference", true, 4);
  const estimation::StateEstimatorParameters used = parameters();
  estimation::StateEstimator estimator(used);
  const double heading = first_heading(reference, reference_heading);
  (void)estimator.add(
      estimation::GivenPose{.time = steps[0][0],
                            .position = Eigen::Vector3d(reference[0][1], reference[0][2], 0),
                            .position_deviation = 0.05,
                            .heading = heading,
                            .heading_deviation = 0.02});
  const double ellipse_95 = statistics::chi_square_quantile(0.95, 2);
  LawnmowerScore score;
  score.summed = sum_up(steps, reference, heading, 0);
  score.standing_rate = standing_rate(steps);
  score.less_standing = sum_up(steps, reference, heading, score.standing_rate);
  score.best_rate = best_rate(steps, reference, heading, score.standing_rate);
  score.less_best = sum_up(steps, reference, heading, score.best_rate);
  double distance = 0;
  double time = reference[0][0];
  double estimated = 0;
  std::size_t next = 0;
  for (const auto& row : steps) {
    const double dt = row[0] - time;
    if (dt <= 0) {
      continue;
    }
    time = row[0];
    distance += row[1];
    (void)estimator.add(estimation::ImuReading{.time = time,
                                               .specific_force = {0, 0, used.smoother.gravity},
                                               .angular_rate = {0, 0, row[2] / dt}});
    score.way += std::abs(row[1]);
    (void)estimator.add(estimation::OdometerReading{
        .time = time, .distance = distance, .variance = kOdometerVariance * score.way});
    while (next + 1 < reference.size() && reference[next + 1][0] <= time) {
      ++next;
    }
    const Vector2d truth(reference[next][1], reference[next][2]);
    if (const auto estimate = estimator.estimate(); estimate && estimate->in_map) {
      const Vector2d error = estimate->state.position.head<2>() - truth;
      const Eigen::Matrix2d covariance = estimator.covariance().topLeftCorner<2, 2>();
      add(error, score.estimator);
      score.covered_share += error.dot(covariance.ldlt().solve(error)) <= ellipse_95 ? 1 : 0;
      estimated += 1;
    }
  }
  score.estimator.rms = std::sqrt(score.estimator.rms / estimated);
  score.covered_share /= estimated;
  return score;
}

}  // namespace pipescout::estimation_study
