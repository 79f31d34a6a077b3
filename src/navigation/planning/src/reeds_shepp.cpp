// SPDX-License-Identifier: Apache-2.0
#include "pipescout/planning/reeds_shepp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

using std::numbers::pi;

/// The goal seen from the start, in turning radii.
struct Target {
  double x, y, phi, sine, cosine;
};

/// Lengths of the pieces of a word, whose kinds its formula knows; rad and turning radii.
struct Lengths {
  double t, u, v;
};

struct Polar {
  double r, theta;
};

Polar polar(double x, double y) {
  return {std::hypot(x, y), std::atan2(y, x)};
}

// Rounding must not hide words with a piece of no length.
constexpr double kZero = 1e-10;

bool is_forward(double value) {
  return value >= -kZero;
}

bool is_reverse(double value) {
  return value <= kZero;
}

/// "tau" and "omega" of the paper, before equation 8.7.
void tau_omega(double u, double v, double xi, double eta, double phi, double& tau, double& omega) {
  const double delta = wrap_angle(u - v);
  const double a = std::sin(u) - std::sin(delta);
  const double b = std::cos(u) - std::cos(delta) - 1;
  const double t1 = std::atan2(eta * a - xi * b, xi * a + eta * b);
  const double t2 = 2 * (std::cos(delta) - std::cos(v) - std::cos(u)) + 3;
  tau = wrap_angle(t2 < 0 ? t1 + pi : t1);
  omega = wrap_angle(tau - u + v - phi);
}

// Equations 8.1 to 8.11 of the paper. L+: left, forwards; and so on. Each says whether it applies.

bool left_straight_left(const Target& g, Lengths& w) {  // 8.1: L+ S+ L+
  const Polar p = polar(g.x - g.sine, g.y - 1 + g.cosine);
  w = {p.theta, p.r, wrap_angle(g.phi - p.theta)};
  return is_forward(w.t) && is_forward(w.v);
}

bool left_straight_right(const Target& g, Lengths& w) {  // 8.2: L+ S+ R+
  const Polar p = polar(g.x + g.sine, g.y - 1 - g.cosine);
  if (p.r < 2) {
    return false;
  }
  w.u = std::sqrt(p.r * p.r - 4);
  w.t = wrap_angle(p.theta + std::atan2(2, w.u));
  w.v = wrap_angle(w.t - g.phi);
  return is_forward(w.t) && is_forward(w.v);
}

bool left_right_left(const Target& g, Lengths& w) {  // 8.3 and 8.4: L+ R- L
  const Polar p = polar(g.x - g.sine, g.y - 1 + g.cosine);
  if (p.r > 4) {
    return false;
  }
  w.u = -2 * std::asin(p.r / 4);
  w.t = wrap_angle(p.theta + w.u / 2 + pi);
  w.v = wrap_angle(g.phi - w.t + w.u);
  return is_forward(w.t) && is_reverse(w.u);
}

bool two_arcs_mirrored(const Target& g, Lengths& w) {  // 8.7: L+ Ru+ Lu- R-
  const double xi = g.x + g.sine;
  const double eta = g.y - 1 - g.cosine;
  const double rho = (2 + std::hypot(xi, eta)) / 4;
  if (rho > 1) {
    return false;
  }
  w.u = std::acos(rho);
  tau_omega(w.u, -w.u, xi, eta, g.phi, w.t, w.v);
  return is_forward(w.t) && is_reverse(w.v);
}

bool two_arcs_alike(const Target& g, Lengths& w) {  // 8.8: L+ Ru- Lu- R+
  const double xi = g.x + g.sine;
  const double eta = g.y - 1 - g.cosine;
  const double rho = (20 - xi * xi - eta * eta) / 16;
  if (rho < 0 || rho > 1) {
    return false;
  }
  w.u = -std::acos(rho);
  tau_omega(w.u, w.u, xi, eta, g.phi, w.t, w.v);
  return is_forward(w.t) && is_forward(w.v);
}

bool quarter_straight_left(const Target& g, Lengths& w) {  // 8.9: L+ R(pi/2)- S- L-
  const Polar p = polar(g.x - g.sine, g.y - 1 + g.cosine);
  if (p.r < 2) {
    return false;
  }
  const double r = std::sqrt(p.r * p.r - 4);
  w.u = 2 - r;
  w.t = wrap_angle(p.theta + std::atan2(r, -2));
  w.v = wrap_angle(g.phi - pi / 2 - w.t);
  return is_forward(w.t) && is_reverse(w.u) && is_reverse(w.v);
}

bool quarter_straight_right(const Target& g, Lengths& w) {  // 8.10: L+ R(pi/2)- S- R-
  const Polar p = polar(-(g.y - 1 - g.cosine), g.x + g.sine);
  if (p.r < 2) {
    return false;
  }
  w = {p.theta, 2 - p.r, wrap_angle(p.theta + pi / 2 - g.phi)};
  return is_forward(w.t) && is_reverse(w.u) && is_reverse(w.v);
}

bool two_quarters(const Target& g, Lengths& w) {  // 8.11: L+ R(pi/2)- S- L(pi/2)- R+
  const double xi = g.x + g.sine;
  const double eta = g.y - 1 - g.cosine;
  const double rho = std::hypot(xi, eta);
  if (rho < 2) {
    return false;
  }
  w.u = 4 - std::sqrt(rho * rho - 4);
  w.t = wrap_angle(std::atan2((4 - w.u) * xi - 2 * eta, -2 * xi + (w.u - 4) * eta));
  w.v = wrap_angle(w.t - g.phi);
  return is_reverse(w.u) && is_forward(w.t) && is_forward(w.v);
}

/// Calls `take(word)` for all words, in turning radii.
template <typename Take>
void for_each_word(const Pose2d& from, const Pose2d& to, double radius, const Take& take) {
  const Pose2d seen = relative(from, to);
  const double x = seen.x / radius;
  const double y = seen.y / radius;
  const double phi = seen.heading;
  const double sine = std::sin(phi);
  const double cosine = std::cos(phi);
  const auto try_all = [&](auto formula, const std::array<int, 5>& turns, int count,
                           const auto& lengths, double x_of, double y_of) {
    for (const int time : {1, -1}) {
      for (const int side : {1, -1}) {
        // Time flipped: driven the other way; reflected: left and right exchanged.
        const Target goal{time * x_of, side * y_of, time * side * phi, time * side * sine, cosine};
        Lengths found{};
        if (!formula(goal, found)) {
          continue;
        }
        const std::array<double, 5> all = lengths(found);
        SteeringWord word;
        word.count = count;
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
          word.pieces[i] = {side * turns[i], time * all[i]};
        }
        take(word);
      }
    }
  };
  // Backwards: the word in the other order leads from the goal, seen in its own frame.
  const double back_x = x * cosine + y * sine;
  const double back_y = x * sine - y * cosine;
  constexpr int kL = 1;
  constexpr int kR = -1;
  const auto straight = [](const Lengths& w) { return std::array<double, 5>{w.t, w.u, w.v}; };
  const auto turned = [](const Lengths& w) { return std::array<double, 5>{w.v, w.u, w.t}; };
  const auto quarter = [](const Lengths& w) {
    return std::array<double, 5>{w.t, -pi / 2, w.u, w.v};
  };
  const auto quarter_turned = [](const Lengths& w) {
    return std::array<double, 5>{w.v, w.u, -pi / 2, w.t};
  };
  try_all(left_straight_left, {kL, 0, kL}, 3, straight, x, y);
  try_all(left_straight_right, {kL, 0, kR}, 3, straight, x, y);
  try_all(left_right_left, {kL, kR, kL}, 3, straight, x, y);
  try_all(left_right_left, {kL, kR, kL}, 3, turned, back_x, back_y);
  try_all(
      two_arcs_mirrored, {kL, kR, kL, kR}, 4,
      [](const Lengths& w) {
        return std::array<double, 5>{w.t, w.u, -w.u, w.v};
      },
      x, y);
  try_all(
      two_arcs_alike, {kL, kR, kL, kR}, 4,
      [](const Lengths& w) {
        return std::array<double, 5>{w.t, w.u, w.u, w.v};
      },
      x, y);
  try_all(quarter_straight_left, {kL, kR, 0, kL}, 4, quarter, x, y);
  try_all(quarter_straight_right, {kL, kR, 0, kR}, 4, quarter, x, y);
  try_all(quarter_straight_left, {kL, 0, kR, kL}, 4, quarter_turned, back_x, back_y);
  try_all(quarter_straight_right, {kR, 0, kR, kL}, 4, quarter_turned, back_x, back_y);
  try_all(
      two_quarters, {kL, kR, 0, kL, kR}, 5,
      [](const Lengths& w) {
        return std::array<double, 5>{w.t, -pi / 2, w.u, -pi / 2, w.v};
      },
      x, y);
}

void check_radius(double radius) {
  constexpr double kLargestRadius = 1e4;  // m
  validation::check_above("radius", radius, 0, kLargestRadius);
}

}  // namespace

double SteeringWord::length() const {
  double sum = 0;
  for (const SteeringPiece& piece : pieces) {
    sum += std::abs(piece.length);
  }
  return sum;
}

std::vector<SteeringWord> reeds_shepp_words(const Pose2d& from, const Pose2d& to, double radius) {
  check_radius(radius);
  std::vector<SteeringWord> words;
  if (!is_finite(from) || !is_finite(to)) {
    return words;
  }
  for_each_word(from, to, radius, [&](SteeringWord word) {
    for (SteeringPiece& piece : word.pieces) {
      piece.length *= radius;
    }
    words.push_back(word);
  });
  std::sort(words.begin(), words.end(),
            [](const SteeringWord& a, const SteeringWord& b) { return a.length() < b.length(); });
  return words;
}

double reeds_shepp_length(const Pose2d& from, const Pose2d& to, double radius) {
  check_radius(radius);
  double shortest = std::numeric_limits<double>::infinity();
  if (is_finite(from) && is_finite(to)) {
    for_each_word(from, to, radius, [&](const SteeringWord& word) {
      shortest = std::min(shortest, word.length() * radius);
    });
  }
  return shortest;
}

Path drive_word(const Pose2d& from, const SteeringWord& word, double radius, double step) {
  check_radius(radius);
  validation::require("step", step, step > 0, "above 0");
  constexpr double kShortest = 1e-9;  // m; pieces that are shorter are none
  std::vector<PathPose> poses;
  Pose2d pose = from;
  double driven = 0;
  for (int i = 0; i < word.count; ++i) {
    const SteeringPiece& piece = word.pieces[static_cast<std::size_t>(i)];
    const double length = std::abs(piece.length);
    if (length < kShortest) {
      continue;
    }
    const double curvature = piece.turn / radius;
    const double parts = std::ceil(length / step);
    const Direction direction = piece.length > 0 ? Direction::kForward : Direction::kReverse;
    if (!poses.empty() && poses.back().direction == direction) {
      poses.pop_back();  // this piece says how the path goes on from there
    }
    for (double part = 0; part <= parts; ++part) {
      poses.push_back({drive_arc(pose, curvature, piece.length * part / parts), direction,
                       curvature, driven + length * part / parts});
    }
    pose = poses.back().pose;
    driven = poses.back().arc_length;
  }
  if (poses.empty()) {
    poses.push_back({.pose = from});
  }
  return Path(std::move(poses));
}

}  // namespace pipescout::navigation
