// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/fusion_stream.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include <Eigen/Cholesky>

#include "pipescout/csv/number_table.hpp"

namespace pipescout::estimation_study {
namespace {

using Eigen::Vector3d;
using estimation::FixedLagSmoother;
using estimation::FixedLagSmootherParameters;
using estimation::kPosition;
using estimation::kRotation;
using estimation::kVelocity;
using estimation::NavState;
using estimation::StateMatrix;
using estimation::StateVector;
using geometry::SE3;
using geometry::SO3;

struct Columns {
  std::string_view kind;
  std::size_t numbers;  // after it
};
constexpr std::array kColumns{Columns{"gt", 17}, Columns{"imu", 8}, Columns{"gps", 5},
                              Columns{"vis", 10}, Columns{"odom", 11}};

std::vector<double> numbers(std::string_view cells, std::size_t line, std::size_t count) {
  return number_table(cells, "stream.csv, line " + std::to_string(line), false, count).front();
}

Vector3d vector_at(const std::vector<double>& n, std::size_t i) {
  return {n[i], n[i + 1], n[i + 2]};
}

/// Order w, x, y, z; written with ten digits.
SO3 rotation_at(const std::vector<double>& n, std::size_t i) {
  return SO3::from_quaternion(Eigen::Quaterniond(n[i], n[i + 1], n[i + 2], n[i + 3]).normalized());
}

geometry::Matrix6d covariance(double translation, double rotation) {
  geometry::Vector6d d;
  d << Vector3d::Constant(translation * translation), Vector3d::Constant(rotation * rotation);
  return d.asDiagonal();
}

}  // namespace

FusionStream parse_fusion_stream(std::string_view text) {
  FusionStream stream;
  std::size_t line = 0;
  while (!text.empty()) {
    ++line;
    const std::string_view row = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(row.size() + 1, text.size()));
    const std::string_view kind = row.substr(0, row.find(','));
    if (row.empty() || row.starts_with('#')) {
      continue;
    }
    const auto columns = std::ranges::find(kColumns, kind, &Columns::kind);
    if (columns == kColumns.end()) {
      throw std::runtime_error("stream.csv:" + std::to_string(line) + ": rows of '" +
                               std::string(kind) + "' are not known");
    }
    const auto n =
        numbers(row.substr(std::min(kind.size() + 1, row.size())), line, columns->numbers);
    if (kind == "gt") {
      stream.truth.push_back({n[0],
                              {.R_map_body = rotation_at(n, 4),
                               .position = vector_at(n, 1),
                               .velocity = vector_at(n, 8),
                               .gyro_bias = vector_at(n, 14),
                               .accelerometer_bias = vector_at(n, 11)}});
    } else if (kind == "imu") {
      stream.imu.push_back({n[0], n[1], vector_at(n, 5), vector_at(n, 2)});
    } else if (kind == "gps") {
      stream.gps.push_back({n[0], vector_at(n, 1), n[4] * n[4] * Eigen::Matrix3d::Identity()});
    } else if (kind == "vis") {
      stream.vision.push_back(
          {n[0], SE3(rotation_at(n, 4), vector_at(n, 1)), covariance(n[8], n[9])});
    } else {
      stream.odometry.push_back(
          {n[0], n[1], SE3(rotation_at(n, 5), vector_at(n, 2)), covariance(n[9], n[10])});
    }
  }
  return stream;
}

FixedLagSmootherParameters fusion_stream_parameters() {
  FixedLagSmootherParameters parameters;
  parameters.imu_noise.gyro = 0.00016968;
  parameters.imu_noise.accelerometer = 0.002;
  parameters.imu_noise.gyro_bias = 1.9393e-05;
  parameters.imu_noise.accelerometer_bias = 0.003;
  parameters.robustness.fill({});
  return parameters;
}

StreamScore run_fusion_stream(const FusionStream& stream, const StreamSensors& use,
                              FixedLagSmoother& smoother) {
  constexpr double kSame = 1e-6;
  constexpr double kScoredFrom = 5 - kSame;
  // The first state is given as it is; without vision its deviations still count at the end. Those
  // of the figures that SOURCE.txt quotes are not known.
  StateVector deviations;
  deviations << Vector3d::Constant(0.01), Vector3d::Constant(0.02), Vector3d::Constant(0.1),
      Vector3d::Constant(0.01), Vector3d::Constant(0.1);
  smoother.initialise(stream.truth[0].time, stream.truth[0].state,
                      deviations.cwiseAbs2().asDiagonal());
  const auto feed = [&](const auto& list, std::size_t& next, double until, bool used) {
    for (; next < list.size(); ++next) {
      if constexpr (requires { list[next].to_time; }) {
        if (list[next].to_time > until) {
          return;
        }
      } else if (list[next].time > until) {
        return;
      }
      if (used) {
        smoother.add(list[next]);
      }
    }
  };
  StreamScore score;
  std::size_t imu = 0;
  std::size_t gps = 0;
  std::size_t vision = 0;
  std::size_t odometry = 0;
  double count = 0;
  for (const TrueState& truth : stream.truth) {
    const double now = truth.time;
    feed(stream.imu, imu, now - 5e-3, true);
    feed(stream.odometry, odometry, now + kSame, use.odometry);
    feed(stream.gps, gps, now + kSame, use.gps);
    feed(stream.vision, vision, now + kSame, use.vision);
    smoother.update(now);
    const NavState& newest = smoother.state(smoother.keyframes() - 1);
    if (now >= kScoredFrom) {
      const StateVector error = newest.local(truth.state);
      score.position += error.segment<3>(kPosition).squaredNorm();
      score.rotation += error.segment<3>(kRotation).squaredNorm();
      score.velocity += error.segment<3>(kVelocity).squaredNorm();
      const StateMatrix covariance = smoother.covariance(smoother.keyframes() - 1);
      score.nees += error.dot(covariance.llt().solve(error));
      count += 1;
    }
  }
  score.position = std::sqrt(score.position / count);
  score.rotation = std::sqrt(score.rotation / count);
  score.velocity = std::sqrt(score.velocity / count);
  score.nees /= count;
  return score;
}

}  // namespace pipescout::estimation_study
