// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/pipe_weave.hpp"

#include <cmath>
#include <numbers>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using geometry::SO3;

constexpr std::uint64_t kWeaveDraws = 7;

/// The direction in which an offset goes, and a crab angle beside it; derivatives by chainage.
struct Direction {
  Direction(const PipeWeave::Offset& off, Eigen::Index axis, Eigen::Index crab) {
    const double slope = off.first[axis];
    const double share = 1 / (1 + slope * slope);
    const double turning = share * off.second[axis];
    value = std::atan(slope) + off.value[crab];
    rate = turning + off.first[crab];
    change = share * off.third[axis] - 2 * slope * turning * turning + off.second[crab];
  }
  double value;
  double rate;
  double change;
};

}  // namespace

void PipeWeaveParameters::validate() const {
  validation::check_within("deviation", deviation, 0, 0.1);
  validation::check_within("crab_deviation", crab_deviation, 0, 0.2);
  validation::check_within("shortest_wavelength", shortest_wavelength, 0.1, 100);
}

PipeWeave::PipeWeave(const PipeWeaveParameters& parameters, std::uint64_t seed) {
  parameters.validate();
  auto engine = statistics::make_engine(seed, kWeaveDraws);
  const Vector4d deviations = Vector4d(parameters.deviation, parameters.deviation,
                                       parameters.crab_deviation, parameters.crab_deviation) /
                              std::sqrt(static_cast<double>(kWaves));
  const double largest = 2 * std::numbers::pi / parameters.shortest_wavelength;
  const double part = largest / static_cast<double>(kWaves);
  double begin = 0;  // of the part of the spectrum that the wave stands for
  for (Wave& wave : waves_) {
    wave.number = begin + part * statistics::uniform(engine);
    begin += part;
    for (Eigen::Index i = 0; i < deviations.size(); ++i) {
      wave.cosine[i] = deviations[i] * statistics::normal(engine);
      wave.sine[i] = deviations[i] * statistics::normal(engine);
    }
  }
}

PipeWeave::Offset PipeWeave::offset(double chainage) const noexcept {
  Offset sum;
  for (const Wave& wave : waves_) {
    const double k = wave.number;
    const double c = std::cos(k * chainage);
    const double s = std::sin(k * chainage);
    const Vector4d value = c * wave.cosine + s * wave.sine;
    const Vector4d slope = k * (c * wave.sine - s * wave.cosine);
    sum.value += value;
    sum.first += slope;
    sum.second -= k * k * value;
    sum.third -= k * k * slope;
  }
  return sum;
}

BodyMotion PipeWeave::motion(const PipeRoute& route, double chainage, double speed,
                             double acceleration) const {
  // The body in the frame of the line, whose motion carries it along.
  const BodyMotion line = route.motion(chainage, speed, acceleration);
  const Offset off = offset(chainage);
  const auto across = [](const Vector4d& v) { return Vector3d(0, v.x(), v.y()); };
  const Vector3d place = across(off.value);
  const Vector3d velocity = speed * across(off.first);
  const Vector3d gained = acceleration * across(off.first) + speed * speed * across(off.second);
  const Vector3d& rate = line.angular_rate;
  const SO3& R_map_line = line.T_map_body.rotation();

  const Direction yaw(off, 0, 2);
  const Direction pitch(off, 1, 3);
  const SO3 R_line_body = SO3::from_roll_pitch_yaw({0, -pitch.value, yaw.value});
  const double sin = std::sin(pitch.value);
  const double cos = std::cos(pitch.value);
  // Turn of the body in the line's frame per metre, in its own axes, and how it changes.
  const Vector3d turn(yaw.rate * sin, -pitch.rate, yaw.rate * cos);
  const double both = yaw.rate * pitch.rate;
  const Vector3d turn_change(yaw.change * sin + both * cos, -pitch.change,
                             yaw.change * cos - both * sin);
  const SO3 R_body_line = R_line_body.inverse();
  const Vector3d carried = R_body_line * rate;

  BodyMotion motion;
  motion.T_map_body =
      geometry::SE3(R_map_line * R_line_body, line.T_map_body.translation() + R_map_line * place);
  motion.velocity = line.velocity + R_map_line * (velocity + rate.cross(place));
  motion.acceleration =
      line.acceleration + R_map_line * (gained + line.angular_acceleration.cross(place) +
                                        2 * rate.cross(velocity) + rate.cross(rate.cross(place)));
  motion.angular_rate = carried + speed * turn;
  motion.angular_acceleration = R_body_line * line.angular_acceleration +
                                carried.cross(Vector3d(speed * turn)) + acceleration * turn +
                                speed * speed * turn_change;
  return motion;
}

}  // namespace pipescout::simulation
