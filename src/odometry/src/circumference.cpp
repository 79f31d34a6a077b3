// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "pipe_bends.hpp"

namespace pipescout::odometry::internal {
namespace {

using std::numbers::pi;

// Shares of the windows of a pipe, of the order of magnitude only: events are certain or ambiguous
// by far more than these.
constexpr double kStraightShare = 0.9;
constexpr double kBendShare = 0.05;
constexpr double kFaultShare = 0.05;  // of all wheels

// Of a wheel that is at fault, densities of the share of the distance that it loses: it slips or is
// stuck, or, seldom, shows up to a tenth too much.
constexpr double kLosesDensity = 0.95;  // in [0, 1]
constexpr double kGainsDensity = 0.5;   // in [-0.1, 0]
constexpr double kLargestGain = 0.1;

// Angles of standard elbows (ASME B16.9: 90, 45; field cuts and induction bends: 60, 30).
struct StandardAngle {
  double angle;
  double share;
};
constexpr std::array<StandardAngle, 4> kStandardAngles{
    {{pi / 2, 0.3}, {pi / 4, 0.15}, {pi / 3, 0.075}, {pi / 6, 0.075}}};
constexpr double kStandardShare = 0.6;
constexpr double kAngleTolerance =
    0.02;  // rad, of a standard elbow: ASME B16.9 allows about 1 degree

constexpr double kGoesOnShare = 0.5;         // of windows that follow those of a bend
constexpr double kLeastSpreadOfBend = 1e-4;  // m

// Of complete events. Radius of a bend: elbows and induction bends have 1.5 to 5 diameters, field
// bends more.
constexpr double kElbowShare = 0.8;
constexpr double kWidestElbow = 5.0;      // diameters
constexpr double kFieldBendRange = 40.0;  // diameters
constexpr double kWindowsSlack = 1.3;     // of the length, which ends with a window
constexpr double kSlipLength = 3.0;       // m, mean, exponential

// Change of the logarithm of the speed where a bend or a slip begins or ends.
constexpr double kSlowsShare = 0.5;        // of the bends
constexpr double kSlowsInSlipShare = 0.1;  // of the slips: what makes a wheel slip may slow it
constexpr double kSlowsRange = 0.5;
// It may also change for any reason, by any amount.
constexpr double kAnyChangeShare = 0.05;
constexpr double kAnyChangeRange = 1.0;

constexpr double kImpossible = -60.0;    // logarithm of a probability
constexpr double kSlack = 1.1;           // of the tightest bend: its radius is not exact
constexpr double kNegligible = 0.01;     // probability of an explanation that is dropped
constexpr double kLargestMisfit = 30.0;  // chi-square of the best explanation
constexpr double kPlainMisfit = 2.0;  // chi-square per degree of freedom that needs no explanation

double square_of(double value) {
  return value * value;
}

double log_slip_length(double length) {
  return -std::log(kSlipLength) - std::abs(length) / kSlipLength;
}

template <class Function>
void each(const OdometerSet& wheels, std::size_t count, Function function) {
  for (std::size_t i = 0; i < count; ++i) {
    if (wheels[i]) {
      function(i);
    }
  }
}

}  // namespace

void WheelSums::add(const WheelSums& other) {
  wheels &= other.wheels;
  for (std::size_t i = 0; i < kMaxOdometers; ++i) {
    increment[i] += other.increment[i];
    random[i] += other.random[i];
  }
  travelled += other.travelled;
  duration += other.duration;
}

Circumference::Circumference(const OdometerStreamParameters& parameters)
    : count_(parameters.odometers.size()),
      radius_(parameters.circumference.radius),
      largest_ratio_(0.5 / parameters.circumference.tightest_bend),
      clock_sigma_(parameters.circumference.clock_sigma) {
  for (std::size_t i = 0; i < count_; ++i) {
    const OdometerParameters& odometer = parameters.odometers[i];
    rows_[i] = {1.0, -std::cos(odometer.clock), -std::sin(odometer.clock)};
    counting_[i] = square_of(odometer.resolution) / 6.0;  // at both ends
    scale_variance_[i] =
        odometer.correction.covariance(0, 0) / square_of(odometer.correction.scale);
  }
}

std::array<double, kMaxOdometers> Circumference::precisions(const WheelSums& sums) const {
  std::array<double, kMaxOdometers> precision{};
  each(sums.wheels, count_, [&](std::size_t i) {
    precision[i] =
        1.0 / (sums.random[i] + counting_[i] + square_of(sums.travelled) * scale_variance_[i]);
  });
  return precision;
}

Eigen::Matrix3d Circumference::information(
    const OdometerSet& wheels, const std::array<double, kMaxOdometers>& precision) const {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  each(wheels, count_,
       [&](std::size_t i) { sum += precision[i] * rows_[i] * rows_[i].transpose(); });
  return sum;
}

Circumference::Vector Circumference::bend_vector(const WheelSums& sums) const {
  const auto precision = precisions(sums);
  const Eigen::Matrix3d covariance = information(sums.wheels, precision).inverse();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  each(sums.wheels, count_,
       [&](std::size_t i) { right += precision[i] * sums.increment[i] * rows_[i]; });
  return {.value = (covariance * right).tail<2>(),
          .deviation = std::sqrt(0.5 * (covariance(1, 1) + covariance(2, 2)))};
}

Circumference::Model Circumference::straight(
    const WheelSums& sums, const std::array<double, kMaxOdometers>& precision) const {
  Model model;
  double total = 0.0;
  double distance = 0.0;
  each(sums.wheels, count_, [&](std::size_t i) {
    total += precision[i];
    distance += precision[i] * sums.increment[i];
  });
  distance /= total;
  each(sums.wheels, count_, [&](std::size_t i) {
    model.weight[i] = precision[i] / total;
    model.misfit += precision[i] * square_of(sums.increment[i] - distance);
  });
  model.evidence =
      -0.5 * model.misfit + 0.5 * std::log(2.0 * pi / total) + std::log(kStraightShare);
  return model;
}

Circumference::Model Circumference::fault(const WheelSums& sums,
                                          const std::array<double, kMaxOdometers>& precision,
                                          std::size_t wheel, bool complete) const {
  WheelSums others = sums;
  others.wheels.reset(wheel);
  Model model = straight(others, precision);
  model.slows_share = kSlowsInSlipShare;
  double distance = 0.0;
  double total = 0.0;
  each(others.wheels, count_, [&](std::size_t i) {
    distance += model.weight[i] * sums.increment[i];
    total += precision[i];
  });
  const double wheels = static_cast<double>(sums.wheels.count());
  model.evidence =
      -0.5 * model.misfit + std::log(2.0 * pi) - 0.5 * std::log(precision[wheel] * total) +
      std::log(kFaultShare / wheels) +
      log_loss(distance, distance - sums.increment[wheel], 1.0 / std::sqrt(precision[wheel])) +
      (complete ? log_slip_length(distance) : 0.0);
  return model;
}

/// Of the distance that a faulty wheel lost, 1/m.
double Circumference::log_loss(double distance, double lost, double deviation) {
  const double travelled = std::abs(distance);
  const double share = distance < 0.0 ? -lost : lost;
  const double margin = 3.0 * deviation;
  double density = 0.0;
  if (share > -margin && share < travelled + margin) {
    density = kLosesDensity;
  } else if (share <= 0.0 && share > -kLargestGain * travelled - margin) {
    density = kGainsDensity;
  }
  return density > 0.0 ? std::log(density / std::max(travelled, margin)) : kImpossible;
}

/// m, of a component of a bend vector that goes on.
double Circumference::spread_of(const BendBefore& before, const WheelSums& sums) {
  return std::max(std::abs(sums.travelled) * before.deviation, kLeastSpreadOfBend);
}

Circumference::Vector Circumference::bend_vector(const WheelSums& sums,
                                                 const Explanation& explanation) const {
  const auto worst = std::ranges::max_element(explanation.both);
  if (*worst <= explanation.bend) {
    return bend_vector(sums);
  }
  const Model model = bend_and_fault(sums, precisions(sums),
                                     static_cast<std::size_t>(worst - explanation.both.begin()),
                                     explanation.before, false);
  return {.value = model.turn * radius_, .deviation = model.deviation};
}

Circumference::Model Circumference::bend_and_fault(
    const WheelSums& sums, const std::array<double, kMaxOdometers>& precision, std::size_t wheel,
    const BendBefore& before, bool complete) const {
  Model model{.evidence = 2.0 * kImpossible, .slows_share = kSlowsShare};
  WheelSums others = sums;
  others.wheels.reset(wheel);
  if (!before.known && others.wheels.count() < 3) {
    return model;
  }
  Eigen::Matrix3d normal = information(others.wheels, precision);
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  // The bend goes on: k is the distance times the ratio.
  const std::array<Eigen::Vector3d, 2> goes_on{Eigen::Vector3d(-before.ratio[0], 1, 0),
                                               Eigen::Vector3d(-before.ratio[1], 0, 1)};
  const double spread = before.known ? spread_of(before, sums) : 0.0;
  if (before.known) {
    for (const Eigen::Vector3d& row : goes_on) {
      normal += row * row.transpose() / square_of(spread);
    }
  }
  const Eigen::Matrix3d covariance = normal.inverse();
  each(others.wheels, count_, [&](std::size_t i) {
    right += precision[i] * sums.increment[i] * rows_[i];
    model.weight[i] = precision[i] * covariance.row(0).dot(rows_[i]);
  });
  const Eigen::Vector3d solution = covariance * right;
  each(others.wheels, count_, [&](std::size_t i) {
    model.misfit += precision[i] * square_of(sums.increment[i] - rows_[i].dot(solution));
  });
  const double deviation = std::sqrt(0.5 * (covariance(1, 1) + covariance(2, 2)));
  double prior = std::log(kBendShare);
  if (before.known) {
    for (const Eigen::Vector3d& row : goes_on) {
      model.misfit += square_of(row.dot(solution) / spread);
    }
    prior = std::log(kGoesOnShare) - std::log(2.0 * pi * square_of(spread));
  } else {
    prior += log_prior(solution.tail<2>().norm(), deviation, std::abs(solution[0]), complete);
  }
  model.distance = solution[0];
  model.deviation = deviation;
  model.turn = solution.tail<2>() / radius_;
  const double lost = rows_[wheel].dot(solution) - sums.increment[wheel];
  const double wheels = static_cast<double>(sums.wheels.count());
  model.evidence = -0.5 * model.misfit + 2.0 * std::log(2.0 * pi) +
                   0.5 * std::log(covariance.determinant() / precision[wheel]) + prior +
                   std::log(kFaultShare / wheels) +
                   log_loss(solution[0], lost, 1.0 / std::sqrt(precision[wheel])) +
                   (complete ? log_slip_length(solution[0]) : 0.0);
  return model;
}

double Circumference::log_prior(double bend, double deviation, double travelled,
                                bool complete) const {
  if (bend > kSlack * largest_ratio_ * travelled + 3.0 * deviation || bend > pi * radius_) {
    return kImpossible;
  }
  const double angle = bend / radius_;
  double density = 1.0 / pi;
  if (complete) {
    density *= 1.0 - kStandardShare;
    const double spread = std::hypot(kAngleTolerance, deviation / radius_);
    for (const StandardAngle& standard : kStandardAngles) {
      density += standard.share / (std::sqrt(2.0 * pi) * spread) *
                 std::exp(-0.5 * square_of((angle - standard.angle) / spread));
    }
  }
  double length_density = 1.0;
  if (complete) {
    const double diameters = travelled / std::max(angle, 1e-3) / (2.0 * radius_);
    const double shape = diameters <= kWindowsSlack * kWidestElbow
                             ? kElbowShare / (kWidestElbow - 0.5 / largest_ratio_)
                             : (1.0 - kElbowShare) / kFieldBendRange;
    length_density = shape / (2.0 * radius_ * std::max(angle, 1e-3));
  }
  // Of the vector: uniform over its directions.
  return std::log(length_density * density / (2.0 * pi * radius_ * std::max(bend, deviation)));
}

Circumference::Model Circumference::bend(const WheelSums& sums,
                                         const std::array<double, kMaxOdometers>& precision,
                                         const BendBefore& before, bool complete) const {
  Model model{.slows_share = kSlowsShare};
  const Eigen::Matrix3d covariance = information(sums.wheels, precision).inverse();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  each(sums.wheels, count_, [&](std::size_t i) {
    right += precision[i] * sums.increment[i] * rows_[i];
    model.weight[i] = precision[i] * covariance.row(0).dot(rows_[i]);
  });
  const Eigen::Vector3d solution = covariance * right;
  each(sums.wheels, count_, [&](std::size_t i) {
    model.misfit += precision[i] * square_of(sums.increment[i] - rows_[i].dot(solution));
  });
  const double deviation = std::sqrt(0.5 * (covariance(1, 1) + covariance(2, 2)));
  model.turn = solution.tail<2>() / radius_;
  double prior = std::log(kBendShare) +
                 log_prior(solution.tail<2>().norm(), deviation, std::abs(solution[0]), complete);
  if (before.known) {
    const double spread = std::hypot(spread_of(before, sums), deviation);
    const Eigen::Vector2d change = solution.tail<2>() - before.ratio * solution[0];
    prior = std::max(prior, std::log(kGoesOnShare) - std::log(2.0 * pi * square_of(spread)) -
                                0.5 * change.squaredNorm() / square_of(spread));
  }
  model.evidence = -0.5 * model.misfit + 1.5 * std::log(2.0 * pi) +
                   0.5 * std::log(covariance.determinant()) + prior;
  return model;
}

/// Of the logarithm of the speed, from beside the stretch to its end; nothing where one is not
/// known.
std::optional<double> Circumference::speed_change(const Model& model, const WheelSums& sums,
                                                  double beside) const {
  if (beside <= 0.0 || sums.duration <= 0.0) {
    return std::nullopt;
  }
  double distance = 0.0;
  each(sums.wheels, count_,
       [&](std::size_t i) { distance += model.weight[i] * sums.increment[i]; });
  const double speed = std::abs(distance) / sums.duration;
  return std::log(std::max(speed, 1e-3 * beside) / beside);
}

/// Speeds that differ more than usual speak against what they follow from. Densities are relative
/// to the peak of the Cauchy of usual changes, 1 / (pi spread). In a bend or a slip a crawler may
/// be slower, at both of its ends by as much: the difference of two usual changes is Cauchy with
/// twice the spread.
double Circumference::speed_evidence(const Model& model, const Speeds& speeds) const {
  const auto first = speed_change(model, speeds.first, speeds.before);
  const auto last = speed_change(model, speeds.last, speeds.after);
  const double any = kAnyChangeShare * pi * speeds.spread / kAnyChangeRange;
  const auto usual = [&](double change) {
    return std::max(1.0 / (1.0 + square_of(change / speeds.spread)), any);
  };
  const double steady = (first ? usual(*first) : 1.0) * (last ? usual(*last) : 1.0);
  if (!first && !last) {
    return 0.0;
  }
  double change = first ? *first : *last;
  double slows = pi * speeds.spread / kSlowsRange;
  if (first && last) {
    change = 0.5 * (*first + *last);
    slows *= std::max(0.5 / (1.0 + square_of(0.5 * (*first - *last) / speeds.spread)), any);
  }
  const bool slower = change < speeds.spread && change > -kSlowsRange;
  return std::log((1.0 - model.slows_share) * steady + (slower ? model.slows_share * slows : 0.0));
}

Explanation Circumference::explain(const WheelSums& sums, const Speeds& speeds,
                                   const BendBefore& before, bool complete) const {
  Explanation result;
  result.before = before;
  if (sums.wheels.count() < 3) {
    return result;
  }
  const auto precision = precisions(sums);
  const Model plain = straight(sums, precision);
  if (plain.misfit <= kPlainMisfit * static_cast<double>(sums.wheels.count() - 1)) {
    return result;
  }
  const Model curved = bend(sums, precision, before, complete);
  std::array<double, kMaxOdometers> faults{};
  const auto evidence_of = [&](const Model& model) {
    return model.evidence + speed_evidence(model, speeds);
  };
  result.straight = evidence_of(plain);
  result.bend = evidence_of(curved);
  double best = std::max(result.straight, result.bend);
  double misfit = result.bend > result.straight ? curved.misfit : plain.misfit;
  std::array<double, kMaxOdometers> both{};
  const bool overlay = before.known || sums.wheels.count() > 3;
  each(sums.wheels, count_, [&](std::size_t i) {
    const auto weigh_in = [&](const Model& model, double& evidence) {
      evidence = evidence_of(model);
      if (evidence > best) {
        best = evidence;
        misfit = model.misfit;
      }
    };
    weigh_in(fault(sums, precision, i, complete), faults[i]);
    if (overlay) {
      weigh_in(bend_and_fault(sums, precision, i, before, complete), both[i]);
    }
  });
  const auto probability = [&](double evidence) {
    const double ratio = std::exp(evidence - best);
    return ratio < kNegligible ? 0.0 : ratio;
  };
  result.straight = probability(result.straight);
  result.bend = probability(result.bend);
  double total = result.straight + result.bend;
  each(sums.wheels, count_, [&](std::size_t i) {
    result.fault[i] = probability(faults[i]);
    result.both[i] = overlay ? probability(both[i]) : 0.0;
    total += result.fault[i] + result.both[i];
  });
  result.straight /= total;
  result.bend /= total;
  for (std::size_t i = 0; i < count_; ++i) {
    result.fault[i] /= total;
    result.both[i] /= total;
  }
  result.consistent = misfit <= kLargestMisfit && best > kImpossible;
  return result;
}

BendWeights Circumference::weigh(const Explanation& explanation, const WheelSums& sums,
                                 const std::array<double, kMaxOdometers>& deviations) const {
  std::array<double, kMaxOdometers> precision{};
  each(sums.wheels, count_, [&](std::size_t i) { precision[i] = 1.0 / square_of(deviations[i]); });
  BendWeights result;
  double square = 0.0;  // mean of the squared distances
  const auto mix = [&](double probability, const std::array<double, kMaxOdometers>& weight) {
    double distance = 0.0;
    each(sums.wheels, count_, [&](std::size_t i) {
      result.weight[i] += probability * weight[i];
      distance += weight[i] * sums.increment[i];
    });
    result.distance += probability * distance;
    square += probability * square_of(distance);
  };
  if (explanation.straight > 0.0) {
    mix(explanation.straight, straight(sums, precision).weight);
  }
  double clocks = 0.0;  // variance by clock positions and the ratio
  if (explanation.bend > 0.0) {
    const Eigen::Matrix3d covariance = information(sums.wheels, precision).inverse();
    std::array<double, kMaxOdometers> weight{};
    Eigen::Vector3d solution = Eigen::Vector3d::Zero();
    each(sums.wheels, count_, [&](std::size_t i) {
      const Eigen::Vector3d gain = precision[i] * covariance * rows_[i];
      weight[i] = gain[0];
      solution += gain * sums.increment[i];
    });
    mix(explanation.bend, weight);
    each(sums.wheels, count_, [&](std::size_t i) {
      const double slope = rows_[i][1] * solution[2] - rows_[i][2] * solution[1];
      clocks += explanation.bend * square_of(weight[i] * slope * clock_sigma_);
    });
  }
  each(sums.wheels, count_, [&](std::size_t i) {
    if (explanation.fault[i] > 0.0) {
      WheelSums others = sums;
      others.wheels.reset(i);
      mix(explanation.fault[i], straight(others, precision).weight);
    }
    if (explanation.both[i] > 0.0) {
      const Model model = bend_and_fault(sums, precision, i, explanation.before, false);
      mix(explanation.both[i], model.weight);
      Eigen::Vector2d slope = Eigen::Vector2d::Zero();
      each(sums.wheels, count_,
           [&](std::size_t k) { slope += model.weight[k] * rows_[k].tail<2>(); });
      if (explanation.before.known) {
        clocks += explanation.both[i] * slope.squaredNorm() *
                  square_of(explanation.before.deviation * sums.travelled);
      }
    }
  });
  result.bias = std::sqrt(std::max(0.0, square - square_of(result.distance)) + clocks);
  return result;
}

}  // namespace pipescout::odometry::internal
