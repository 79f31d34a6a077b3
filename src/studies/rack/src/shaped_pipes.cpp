// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/shaped_pipes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

#include "pipescout/geometry/so3.hpp"
#include "pipescout/statistics/draw.hpp"
#include "place_images.hpp"

namespace pipescout::rack_study {
namespace {

using Eigen::Vector3d;
using rack_vision::Pipe;
using rack_vision::PipeShape;
using rack_vision::PipeShapeEstimate;
using rack_vision::RackModel;
using rack_vision::ShapeDeviation;

constexpr double kWithin99 = 2.58;  // deviations that hold a normal error in 99 of 100 cases

bool is_steep(const Vector3d& direction) {
  return std::abs(direction.z()) > std::numbers::sqrt2 / 2;
}

/// Unit vectors across a pipe, about which it is rotated.
struct AcrossPipe {
  Vector3d up;
  Vector3d level;
};

AcrossPipe across(const Vector3d& direction) {
  const Vector3d above = is_steep(direction) ? Vector3d::UnitY() : Vector3d::UnitZ();
  const Vector3d level = direction.cross(above).normalized();
  return {.up = level.cross(direction), .level = level};
}

Vector3d middle(const Pipe& pipe) {
  return pipe.start + 0.5 * pipe.length() * pipe.direction;
}

/// Normal, at most two sigma.
double limited_error(double sigma, statistics::Engine& engine) {
  constexpr double kMost = 2;
  while (true) {
    const double error = statistics::normal(engine);
    if (std::abs(error) <= kMost) {
      return sigma * error;
    }
  }
}

/// The file's pipe for a true one, with the deviations that it states.
Pipe misshapen(const Pipe& truth, const ShapeDeviation& drawn, statistics::Engine& engine) {
  Pipe file = truth;
  file.shape_deviation = drawn;
  if (is_steep(truth.direction)) {
    file.shape_deviation.height = 0;
  }
  const auto error = [&engine](double sigma) { return limited_error(sigma, engine); };
  const double height = error(file.shape_deviation.height);
  const double turn = error(drawn.direction);
  const double raise = error(drawn.direction);
  const double radius = error(drawn.radius);
  const AcrossPipe axes = across(truth.direction);
  file.direction =
      (geometry::SO3::exp(turn * axes.up + raise * axes.level) * truth.direction).normalized();
  file.start = middle(truth) + height * Vector3d::UnitZ() - 0.5 * truth.length() * file.direction;
  for (rack_vision::RadiusAt& at : file.radii) {
    at.radius += radius;
  }
  return file;
}

RackModel draw_misshapen_file(const ShapedPipesSettings& settings, statistics::Engine& engine) {
  constexpr int kMostDraws = 1000;
  for (int i = 0; i < kMostDraws; ++i) {
    RackModel file = settings.rack;
    for (const std::size_t pipe : settings.pipes) {
      file.pipes[pipe] = misshapen(settings.rack.pipes[pipe], settings.drawn, engine);
    }
    try {
      file.validate();
      return file;
    } catch (const rack_vision::InvalidRack&) {
      continue;  // pipes ran through each other, or a radius was too small
    }
  }
  throw std::invalid_argument("no valid rack file among " + std::to_string(kMostDraws) +
                              " with the drawn deviations of shapes");
}

/// Images of one place, and a file whose shapes are wrong.
class ShapedPlace {
 public:
  ShapedPlace(const ShapedPipesSettings& settings, std::uint64_t seed)
      : engine_(seed),
        file_(draw_misshapen_file(checked(settings), engine_)),
        first_(draw_first_pose(settings.start_position, settings.start_rotation, engine_)),
        images_(settings.rack, settings.world, settings.duration, engine_) {
    for (std::size_t i = 0; i < file_.pipes.size(); ++i) {
      shapes_.push_back(shape_of(settings.rack.pipes[i], file_.pipes[i]));
    }
  }

  [[nodiscard]] ShapedPipesTrial fly(bool told) const {
    RackModel file = file_;
    if (!told) {
      for (Pipe& pipe : file.pipes) {
        pipe.shape_deviation = {};
      }
    }
    ShapedPipesTrial trial{.shapes = shapes_};
    trial.frames =
        images_.localize(file, {}, first_,
                         [&trial](const rack_vision::RackTrackerResult& result, const FrameScore&) {
                           trial.estimates.assign(result.shapes.begin(), result.shapes.end());
                         });
    return trial;
  }

 private:
  static const ShapedPipesSettings& checked(const ShapedPipesSettings& settings) {
    for (const std::size_t pipe : settings.pipes) {
      if (pipe == 0 || pipe >= settings.rack.pipes.size()) {
        throw std::invalid_argument("pipe " + std::to_string(pipe) +
                                    " cannot be misshapen: it is " +
                                    (pipe == 0 ? "the first" : "not in the rack"));
      }
    }
    return settings;
  }

  statistics::Engine engine_;
  RackModel file_;
  FirstPose first_;
  PlaceImages images_;
  std::vector<PipeShape> shapes_;
};

}  // namespace

PipeShape shape_of(const Pipe& truth, const Pipe& file) {
  const Vector3d level = file.direction.cross(Vector3d::UnitZ());
  constexpr double kUpright = 1e-3;
  const Vector3d right = level.norm() > kUpright ? level.normalized() : Vector3d(Vector3d::UnitX());
  const double along = truth.direction.dot(file.direction);
  return {.offset = middle(truth).x() - middle(file).x(),
          .height = middle(truth).z() - middle(file).z(),
          .turn_aside = truth.direction.dot(right) / along,
          .turn_up = truth.direction.dot(right.cross(file.direction)) / along,
          .radius = truth.radii.front().radius - file.radii.front().radius};
}

ShapedPipesTrial try_shaped_pipes(const ShapedPipesSettings& settings, bool told,
                                  std::uint64_t seed) {
  return ShapedPlace(settings, seed).fly(told);
}

ShapedPipesPair compare_shaped_pipes(const ShapedPipesSettings& settings, std::uint64_t seed) {
  const ShapedPlace place(settings, seed);
  return {.told = place.fly(true), .not_told = place.fly(false)};
}

ShapedPipesScore& ShapedPipesScore::operator+=(const ShapedPipesScore& other) {
  trials += other.trials;
  converged += other.converged;
  lost += other.lost;
  silent_wrong += other.silent_wrong;
  images += other.images;
  shapes += other.shapes;
  shapes_found += other.shapes_found;
  values += other.values;
  values_covered += other.values_covered;
  return *this;
}

double ShapedPipesScore::position_rms() const noexcept {
  if (images.position_errors.empty()) {
    return 0;
  }
  double sum = 0;
  for (const double error : images.position_errors) {
    sum += error * error;
  }
  return std::sqrt(sum / static_cast<double>(images.position_errors.size()));
}

ShapedPipesScore score_shaped_pipes(std::span<const ShapedPipesTrial> trials) {
  ShapedPipesScore score;
  for (const ShapedPipesTrial& trial : trials) {
    const PlaceOutcome outcome = outcome_of(trial.frames);
    ++score.trials;
    score.converged += outcome.converged ? 1U : 0U;
    score.lost += outcome.lost ? 1U : 0U;
    score.silent_wrong += outcome.images.silent_wrong > 0 ? 1U : 0U;
    score.images += outcome.images;
    for (const PipeShapeEstimate& each : trial.estimates) {
      ++score.shapes;
      score.shapes_found += each.found ? 1U : 0U;
      for (const double PipeShape::*value :
           {&PipeShape::height, &PipeShape::turn_aside, &PipeShape::turn_up, &PipeShape::radius}) {
        if (each.found && each.deviation.*value > 0) {
          const double error = each.shape.*value - trial.shapes[each.pipe].*value;
          ++score.values;
          score.values_covered += std::abs(error) <= kWithin99 * each.deviation.*value ? 1U : 0U;
        }
      }
    }
  }
  return score;
}

}  // namespace pipescout::rack_study
