// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/jointed_pipe.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using statistics::make_engine;
using statistics::normal;
using statistics::uniform;
using validation::check_above;
using validation::check_within;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double sign_of(std::mt19937_64& engine) {
  return uniform(engine) < 0.5 ? -1.0 : 1.0;
}

/// Integral of cos(angle + rate * s) over s in [0, distance].
double cosine_integral(double angle, double rate, double distance) {
  if (std::abs(rate * distance) < 1e-9) {
    return distance * std::cos(angle + 0.5 * rate * distance);
  }
  return (std::sin(angle + rate * distance) - std::sin(angle)) / rate;
}

/// The same of the sine.
double sine_integral(double angle, double rate, double distance) {
  if (std::abs(rate * distance) < 1e-9) {
    return distance * std::sin(angle + 0.5 * rate * distance);
  }
  return (std::cos(angle) - std::cos(angle + rate * distance)) / rate;
}

std::array<double, 3> position_in(const Joint& joint, double distance) {
  const double level = cosine_integral(joint.pitch, joint.pitch_rate, distance);
  const double up = sine_integral(joint.pitch, joint.pitch_rate, distance);
  auto [x, y, z] = joint.position;
  if (joint.heading_rate != 0.0) {  // the pitch is constant
    const double share = std::cos(joint.pitch);
    x += share * cosine_integral(joint.heading, joint.heading_rate, distance);
    y += share * sine_integral(joint.heading, joint.heading_rate, distance);
  } else {
    x += level * std::cos(joint.heading);
    y += level * std::sin(joint.heading);
  }
  return {x, y, z + up};
}

/// Normal, cut off at 3 standard deviations.
std::vector<double> draw_lengths(const JointedPipeParameters& parameters, std::uint64_t seed) {
  auto engine = make_engine(seed, 1);
  std::vector<double> lengths;
  for (std::size_t i = 0; i < parameters.joints; ++i) {
    double deviation = normal(engine);
    while (std::abs(deviation) > 3.0) {
      deviation = normal(engine);
    }
    lengths.push_back(parameters.joint_length * (1.0 + parameters.length_spread * deviation));
  }
  return lengths;
}

}  // namespace

void JointedPipeParameters::validate() const {
  check_within("joints", static_cast<double>(joints), 1, 1e6);
  check_above("joint_length", joint_length, 0.0, kInfinity);
  check_within("length_spread", length_spread, 0.0, 0.3);
  check_within("tally_sigma", tally_sigma, 0.0, 0.1 * joint_length);
  check_within("tally_wrong", tally_wrong, 0.0, 1.0);
  check_above("tally_wrong_by", tally_wrong_by, 0.0, 0.3 * joint_length);
  check_within("tally_missing", tally_missing, 0.0, 1.0);
  check_within("tally_extra", tally_extra, 0.0, 1.0);
  check_within("bend_share", bend_share, 0.0, 1.0);
  check_above("largest_bend", largest_bend, 0.0, std::numbers::pi);
  check_within("slope_share", slope_share, 0.0, 1.0);
  check_within("largest_slope", largest_slope, 0.0, 1.5);
}

JointedPipe::JointedPipe(const JointedPipeParameters& parameters, std::uint64_t seed) {
  parameters.validate();
  lay(parameters, draw_lengths(parameters, seed), seed);
  write_tally(parameters, seed);
}

JointedPipe::JointedPipe(const JointedPipeParameters& parameters, std::span<const double> tally,
                         std::uint64_t seed) {
  parameters.validate();
  if (tally.empty()) {
    throw std::invalid_argument("tally: there are no joints");
  }
  auto errors = make_engine(seed, 1);
  std::vector<double> lengths;
  for (std::size_t i = 0; i < tally.size(); ++i) {
    check_above("tally[" + std::to_string(i) + "]", tally[i], 10.0 * parameters.tally_sigma,
                kInfinity);
    lengths.push_back(tally[i] + parameters.tally_sigma * normal(errors));
    tally_.push_back({.length = tally[i], .joint = i});
  }
  lay(parameters, lengths, seed);
}

void JointedPipe::lay(const JointedPipeParameters& parameters, std::span<const double> lengths,
                      std::uint64_t seed) {
  auto turns = make_engine(seed, 2);
  Joint joint;
  for (const double length : lengths) {
    joint.begin = length_;
    joint.length = length;
    joint.heading_rate = joint.pitch_rate = 0.0;
    const double kind = uniform(turns);
    if (kind < parameters.bend_share) {
      const double angle = parameters.largest_bend * uniform(turns, 0.1, 1.0) * sign_of(turns);
      joint.heading_rate = angle / joint.length;
    } else if (kind < parameters.bend_share + parameters.slope_share) {
      const double pitch = parameters.largest_slope * uniform(turns, -1.0, 1.0);
      joint.pitch_rate = (pitch - joint.pitch) / joint.length;
    }
    joints_.push_back(joint);
    length_ += joint.length;
    joint.position = position_in(joint, joint.length);
    joint.heading += joint.heading_rate * joint.length;
    joint.pitch += joint.pitch_rate * joint.length;
  }
}

void JointedPipe::write_tally(const JointedPipeParameters& parameters, std::uint64_t seed) {
  auto engine = make_engine(seed, 3);
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    if (uniform(engine) < parameters.tally_extra) {
      const double length =
          parameters.joint_length * (1.0 + parameters.length_spread * normal(engine));
      tally_.push_back({.length = length, .error = TallyError::kExtra, .joint = i});
    }
    joints_[i].in_tally = uniform(engine) >= parameters.tally_missing;
    if (!joints_[i].in_tally) {
      continue;
    }
    TallyEntry entry{.length = joints_[i].length + parameters.tally_sigma * normal(engine),
                     .joint = i};
    if (uniform(engine) < parameters.tally_wrong) {
      entry.error = TallyError::kWrongLength;
      entry.length += parameters.tally_wrong_by * uniform(engine, 0.5, 1.0) * sign_of(engine);
    }
    tally_.push_back(entry);
  }
}

std::size_t JointedPipe::joint_at(double chainage) const noexcept {
  const auto after =
      std::upper_bound(joints_.begin(), joints_.end(), chainage,
                       [](double value, const Joint& joint) { return value < joint.begin; });
  return after == joints_.begin() ? 0 : static_cast<std::size_t>(after - joints_.begin()) - 1;
}

std::array<double, 3> JointedPipe::position(double chainage) const noexcept {
  const Joint& joint = joints_[joint_at(chainage)];
  const double inside = std::clamp(chainage - joint.begin, 0.0, joint.length);
  auto position = position_in(joint, inside);
  const double beyond = chainage - joint.begin - inside;
  const double level = std::cos(pitch(chainage));
  position[0] += beyond * level * std::cos(heading(chainage));
  position[1] += beyond * level * std::sin(heading(chainage));
  position[2] += beyond * std::sin(pitch(chainage));
  return position;
}

double JointedPipe::heading(double chainage) const noexcept {
  const Joint& joint = joints_[joint_at(chainage)];
  return joint.heading + joint.heading_rate * std::clamp(chainage - joint.begin, 0.0, joint.length);
}

double JointedPipe::pitch(double chainage) const noexcept {
  const Joint& joint = joints_[joint_at(chainage)];
  return joint.pitch + joint.pitch_rate * std::clamp(chainage - joint.begin, 0.0, joint.length);
}

}  // namespace pipescout::simulation
