// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/rack_bodies.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "pipescout/statistics/draw.hpp"

namespace pipescout::rack_study {
namespace {

using Eigen::Vector3d;
using rack_vision::Pipe;
using rack_vision::RackModel;
using rack_vision::RadiusAt;
using statistics::uniform;

constexpr double kSteel = 0.3;    // albedo
constexpr double kJacket = 0.62;  // of aluminium
constexpr double kGalvanised = 0.5;

bool along_y(const Pipe& pipe) {
  return pipe.direction.isApprox(Vector3d::UnitY());
}

/// The radius where it is the same over `length` from there on, m; 0 where it changes.
double constant_radius(const Pipe& pipe, double along, double length) {
  for (std::size_t i = 1; i < pipe.radii.size(); ++i) {
    const RadiusAt& a = pipe.radii[i - 1];
    const RadiusAt& b = pipe.radii[i];
    if (along >= a.along && along + length <= b.along) {
      return a.radius == b.radius ? a.radius : 0;
    }
  }
  return 0;
}

class Fitter {
 public:
  Fitter(const RackModel& rack, std::uint64_t seed) : engine_(seed), rack_(rack) {
    fitted_.with_bodies = rack;
  }

  FittedRack fit() {
    for (std::size_t i = 0; i < rack_.pipes.size(); ++i) {
      if (along_y(rack_.pipes[i])) {
        fit_pipe(i);
      }
    }
    add_tray();
    fitted_.with_bodies.validate();
    return std::move(fitted_);
  }

 private:
  /// Stretches of one pipe that something lies on, so that nothing else does.
  struct Taken {
    double from = 0, to = 0;
  };

  void fit_pipe(std::size_t index) {
    constexpr double kBetweenFlanges = 3.0;  // m, of a branch line
    constexpr double kBetweenSeams = 1.0;    // m, of sheets of cladding
    taken_.clear();
    keep_off_others(index);
    const double length = rack_.pipes[index].length();
    add_valve(index);
    add_lagging(index);
    for (double along = uniform(engine_, 0.5, 2); along < length;
         along += kBetweenFlanges * uniform(engine_, 0.8, 1.2)) {
      add_flange(index, along);
    }
    add_branch(index);
    for (double along = uniform(engine_, 0, kBetweenSeams); along < length;
         along += kBetweenSeams) {
      add_seam(index, along);
    }
  }

  /// Nothing is mounted below and in pipes that cross this one.
  void keep_off_others(std::size_t index) {
    constexpr double kRoom = 0.5;  // m
    for (const Pipe& other : rack_.pipes) {
      if (!along_y(other)) {
        const double along = other.start.y() - rack_.pipes[index].start.y();
        taken_.push_back({along - kRoom, along + kRoom});
      }
    }
  }

  /// The radius of the pipe there when the place is free, which it then is not any more; 0 when
  /// not.
  double take(std::size_t index, double along, double length) {
    constexpr double kApart = 0.1;  // m
    const Pipe& pipe = rack_.pipes[index];
    const double radius = constant_radius(pipe, along, length);
    const bool free = std::ranges::none_of(taken_, [&](const Taken& taken) {
      return along < taken.to + kApart && along + length > taken.from - kApart;
    });
    if (radius == 0 || !free) {
      return 0;
    }
    taken_.push_back({along, along + length});
    return radius;
  }

  [[nodiscard]] Vector3d on_axis(std::size_t index, double along) const {
    return rack_.pipes[index].start + along * rack_.pipes[index].direction;
  }

  void add_ring(std::size_t index, double along, double length, double radius, double albedo) {
    fitted_.bodies.cylinders.push_back({.start = on_axis(index, along),
                                        .direction = rack_.pipes[index].direction,
                                        .length = length,
                                        .radius = radius,
                                        .albedo = albedo});
  }

  /// A ring that the measured rack file has, too.
  void widen(std::size_t index, double along, double length, double radius, double wider) {
    std::vector<RadiusAt>& radii = fitted_.with_bodies.pipes[index].radii;
    const auto after =
        std::ranges::find_if(radii, [along](const RadiusAt& at) { return at.along > along; });
    radii.insert(after, {{along, radius},
                         {along, radius + wider},
                         {along + length, radius + wider},
                         {along + length, radius}});
  }

  void add_flange(std::size_t index, double along) {
    constexpr double kThickness = 0.06;  // m, of a pair
    constexpr double kWider = 0.04;      // m
    if (const double radius = take(index, along, kThickness); radius > 0) {
      add_ring(index, along, kThickness, radius + kWider, kSteel);
      widen(index, along, kThickness, radius, kWider);
    }
  }

  void add_lagging(std::size_t index) {
    const double length = uniform(engine_, 0.5, 1.5);
    const double thickness = uniform(engine_, 0.02, 0.04);
    const double along = uniform(engine_, 0, rack_.pipes[index].length() - length);
    if (const double radius = take(index, along, length); radius > 0) {
      add_ring(index, along, length, radius + thickness, kJacket);
      widen(index, along, length, radius, thickness);
    }
  }

  void add_seam(std::size_t index, double along) {
    constexpr double kWidth = 0.04;    // m
    constexpr double kHeight = 0.002;  // m
    if (const double radius = take(index, along, kWidth); radius > 0) {
      add_ring(index, along, kWidth, radius + kHeight, uniform(engine_) < 0.5 ? kJacket : kSteel);
    }
  }

  /// A body of the valve's bonnet and, over it, spindle and hand wheel.
  void add_valve(std::size_t index) {
    constexpr double kBody = 0.3;  // m, along the pipe
    constexpr double kSpindle = 0.02, kWheel = 0.14, kRim = 0.03;
    const double along = uniform(engine_, 1, rack_.pipes[index].length() - 1);
    const double radius = take(index, along, kBody);
    if (radius == 0) {
      return;
    }
    const double half = radius + 0.03;
    const Vector3d middle = on_axis(index, along + 0.5 * kBody);
    const Vector3d size(half, 0.5 * kBody, half);
    fitted_.bodies.boxes.push_back(
        {.lowest_corner = middle - size, .highest_corner = middle + size, .albedo = kSteel});
    const Vector3d top = middle + half * Vector3d::UnitZ();
    const double height = uniform(engine_, 0.2, 0.4);
    fitted_.bodies.cylinders.push_back(
        {.start = top, .length = height, .radius = kSpindle, .albedo = kSteel});
    const Vector3d wheel = top + height * Vector3d::UnitZ();
    fitted_.bodies.cylinders.push_back(
        {.start = wheel, .length = kRim, .radius = kWheel, .albedo = uniform(engine_, 0.1, 0.6)});
    const std::string name = "valve " + std::to_string(index + 1);
    fitted_.with_bodies.supports.push_back(
        {.name = name, .lowest_corner = middle - size, .highest_corner = middle + size});
    fitted_.with_bodies.pipes.push_back({.name = name + ", wheel",
                                         .start = wheel,
                                         .direction = Vector3d::UnitZ(),
                                         .radii = {{0, kWheel}, {kRim, kWheel}},
                                         .movable = false});
  }

  /// A thin pipe that rises from the top, and turns by an elbow over the neighbours.
  void add_branch(std::size_t index) {
    constexpr double kRadius = 0.04;       // m
    constexpr double kBend = 3 * kRadius;  // m: 1.5 D
    constexpr int kPieces = 8;             // of the elbow
    constexpr double kAngle = 0.5 * std::numbers::pi / kPieces;
    const double along = uniform(engine_, 1, rack_.pipes[index].length() - 1);
    const double radius = take(index, along, 2 * kRadius);
    if (radius == 0) {
      return;
    }
    const double albedo = uniform(engine_, 0.1, 0.6);
    const double turn = uniform(engine_, -std::numbers::pi, std::numbers::pi);
    const Vector3d side(std::cos(turn), std::sin(turn), 0);
    const auto add = [&](const Vector3d& from, const Vector3d& to) {
      fitted_.bodies.cylinders.push_back({.start = from,
                                          .direction = (to - from).normalized(),
                                          .length = (to - from).norm(),
                                          .radius = kRadius,
                                          .albedo = albedo});
    };
    const Vector3d root = on_axis(index, along + kRadius);
    const Vector3d elbow = root + (radius + uniform(engine_, 0.1, 0.3)) * Vector3d::UnitZ();
    add(root, elbow);
    Vector3d before = elbow;
    for (int i = 1; i <= kPieces; ++i) {
      const double angle = i * kAngle;
      const Vector3d next =
          elbow + kBend * ((1 - std::cos(angle)) * side + std::sin(angle) * Vector3d::UnitZ());
      add(before, next);
      before = next;
    }
    add(before, before + uniform(engine_, 0.4, 1.2) * side);
  }

  void add_tray() {
    constexpr double kApart = 0.12;  // m, beside the last pipe
    constexpr double kWidth = 0.30, kDepth = 0.10;
    double right = 0;
    double length = 0;
    for (const Pipe& pipe : rack_.pipes) {
      if (along_y(pipe)) {
        right = std::max(right, pipe.start.x() + pipe.largest_radius());
        length = std::max(length, pipe.start.y() + pipe.length());
      }
    }
    const Vector3d low(right + kApart, 0, 0);
    const Vector3d high = low + Vector3d(kWidth, length, kDepth);
    fitted_.bodies.boxes.push_back(
        {.lowest_corner = low, .highest_corner = high, .albedo = kGalvanised});
    fitted_.with_bodies.supports.push_back(
        {.name = "cable tray", .lowest_corner = low, .highest_corner = high});
  }

  std::mt19937_64 engine_;
  const RackModel& rack_;
  FittedRack fitted_;
  std::vector<Taken> taken_;
};

}  // namespace

FittedRack fit_out(const RackModel& rack, std::uint64_t seed) {
  return Fitter(rack, seed).fit();
}

std::vector<Vector3d> people_beside(const RackModel& rack, std::size_t people, double time) {
  constexpr double kAside = 0.6;   // m, from the pipes
  constexpr double kBelow = -0.3;  // m, of the walkway, rack z
  constexpr double kApart = 3.1;   // m, of one person from the next
  double left = 0;
  double right = 0;
  double length = 0;
  for (const Pipe& pipe : rack.pipes) {
    if (along_y(pipe)) {
      left = std::min(left, pipe.start.x() - pipe.largest_radius());
      right = std::max(right, pipe.start.x() + pipe.largest_radius());
      length = std::max(length, pipe.start.y() + pipe.length());
    }
  }
  std::vector<Vector3d> feet;
  for (std::size_t i = 0; i < people; ++i) {
    const double walked = std::fmod(time + kApart * static_cast<double>(i), 2 * length);
    feet.emplace_back(i % 2 == 0 ? left - kAside : right + kAside,
                      walked < length ? walked : 2 * length - walked, kBelow);
  }
  return feet;
}

}  // namespace pipescout::rack_study
