// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/rack_thermal.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"
#include "rack_thermal_radiometry.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector3d;
using rack_vision::Pipe;
using rack_vision::PipeSection;
using validation::check_above;
using validation::check_within;
using validation::Field;

// Purposes of random draws.
constexpr std::uint64_t kSurfaceDraws = 71;
constexpr std::uint64_t kPatternDraws = 72;
constexpr std::uint64_t kNoiseDraws = 1000;

constexpr double kFlank = 0.04;           // m, over which a hot spot fades at its border
constexpr double kGrainCell = 0.12;       // m
constexpr int kGrainCells = 256;          // repeats beyond
constexpr double kLongestHorizon = 60.0;  // m: the ground beyond is as the sky's lower border
/// K: the top of a pipe radiates to the sky.
constexpr double kSkyCooling = 1.5;
constexpr int kBlurReach = 4;  // pixels

void check_spots(const RackThermalScene& scene) {
  for (std::size_t i = 0; i < scene.hot_spots.size(); ++i) {
    const HotSpot& spot = scene.hot_spots[i];
    const std::string name = "hot_spots[" + std::to_string(i) + "].";
    if (spot.pipe >= scene.model.pipes.size()) {
      validation::refuse(name, "pipe: ", spot.pipe, " is outside [0, ",
                         scene.model.pipes.size() - 1, "]");
    }
    check_within(Field(name, "along"), spot.along, 0, scene.model.pipes[spot.pipe].length());
    check_within(Field(name, "azimuth"), spot.azimuth, -std::numbers::pi, std::numbers::pi);
    check_within(Field(name, "length"), spot.length, 0.05, 50);
    check_above(Field(name, "half_angle"), spot.half_angle, 0, std::numbers::pi);
    check_above(Field(name, "rise"), spot.rise, 0, 500);
  }
}

/// Directions across a pipe: away from the ground, and to the side of a positive azimuth.
struct Around {
  Vector3d top;
  Vector3d side;
};

Around around(const Vector3d& direction) {
  const Vector3d up =
      std::abs(direction.z()) > 0.99 ? Vector3d(Vector3d::UnitX()) : Vector3d(Vector3d::UnitZ());
  const Vector3d top = (up - direction * direction.dot(up)).normalized();
  return {top, direction.cross(top)};
}

double radius_at(const Pipe& pipe, double along) {
  for (std::size_t i = 1; i < pipe.radii.size(); ++i) {
    const auto& from = pipe.radii[i - 1];
    const auto& to = pipe.radii[i];
    if (along <= to.along && to.along > from.along) {
      return std::lerp(from.radius, to.radius, (along - from.along) / (to.along - from.along));
    }
  }
  return pipe.radii.back().radius;
}

double fifth_power(double x) {
  const double square = x * x;
  return square * square * x;
}

/// 1 inside, 0.5 at the border, 0 outside; `inside`: m from the border.
double within(double inside) {
  const double x = std::clamp(0.5 + 0.5 * inside / kFlank, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

/// What a ray meets first.
struct Hit {
  double range = std::numeric_limits<double>::infinity();
  double celsius = 0;
  Vector3d normal = Vector3d::UnitZ();
};

/// A section with what its surface needs.
struct Tube {
  PipeSection shape;
  std::size_t pipe = 0;
  double begin = 0;  // m along its pipe
  double slope = 0;  // of the radius
};

}  // namespace

Vector3d place_of(const HotSpot& spot, const rack_vision::RackModel& model) {
  const Pipe& pipe = model.pipes.at(spot.pipe);
  const Around axes = around(pipe.direction);
  return pipe.start + spot.along * pipe.direction +
         radius_at(pipe, spot.along) *
             (std::cos(spot.azimuth) * axes.top + std::sin(spot.azimuth) * axes.side);
}

void RackThermalScene::validate() const {
  model.validate();
  if (!pipe_temperatures.empty() && pipe_temperatures.size() != model.pipes.size()) {
    validation::refuse("pipe_temperatures: ", pipe_temperatures.size(), " values: must be ",
                       model.pipes.size(), ", one per pipe");
  }
  for (const double temperature : pipe_temperatures) {
    check_within("pipe_temperatures", temperature, -50, 500);
  }
  check_spots(*this);
  for (const WarmGround& warm : warm_ground) {
    check_within("warm_ground.middle.x", warm.middle.x(), -1e4, 1e4);
    check_within("warm_ground.middle.y", warm.middle.y(), -1e4, 1e4);
    check_above("warm_ground.radius", warm.radius, 0, 100);
    check_within("warm_ground.temperature", warm.temperature, -50, 500);
  }
  check_within("pipe_change", pipe_change, 0, 50);
  check_within("emissivity", emissivity, 0.1, 1);
  check_within("ground_height", ground_height, -100, -0.5);
  check_within("ground_temperature", ground_temperature, -50, 100);
  check_within("ground_grain", ground_grain, 0, 20);
  check_within("sky_temperature", sky_temperature, -80, 60);
  check_within("air_temperature", air_temperature, -50, 60);
  check_within("air_absorption", air_absorption, 0, 0.1);
}

void RackThermalSensor::validate() const {
  check_within("netd", netd, 0, 5);
  check_within("fixed_pattern", fixed_pattern, 0, 10);
  check_within("lens_blur", lens_blur, 0, 3);
}

class RackThermalRenderer::Implementation {
 public:
  Implementation(const RackThermalScene& scene, const geometry::Camera& camera,
                 const RackThermalSensor& sensor)
      : scene_((scene.validate(), scene)), camera_(camera), sensor_((sensor.validate(), sensor)) {
    prepare_pipes();
    prepare_ground();
    prepare_sensor();
  }

  void render(const geometry::SE3& T_rack_camera, std::uint64_t frame,
              std::span<std::uint16_t> counts) {
    if (counts.size() != plane_.size()) {
      validation::refuse("counts: ", counts.size(), " pixels: must be ", plane_.size());
    }
    const Vector3d eye = T_rack_camera.translation();
    for (std::size_t i = 0; i < plane_.size(); ++i) {
      plane_[i] = radiance(eye, T_rack_camera.rotation() * rays_[i]);
    }
    blur();
    auto engine = statistics::make_engine(scene_.seed, kNoiseDraws + frame);
    const double noise = sensor_.netd * per_kelvin_;
    for (std::size_t i = 0; i < plane_.size(); ++i) {
      const double seen = plane_[i] + noise * (statistics::normal(engine) + pattern_[i]);
      const double count = (band_.temperature(seen) - kRackThermalOffset) / kRackThermalGain;
      counts[i] = static_cast<std::uint16_t>(std::clamp(std::lround(count), 0L, 65535L));
    }
  }

  [[nodiscard]] const geometry::Camera& camera() const noexcept { return camera_; }

 private:
  void prepare_pipes() {
    auto engine = statistics::make_engine(scene_.seed, kSurfaceDraws);
    constexpr double kColdest = 30;  // degC
    constexpr double kWarmest = 60;
    for (std::size_t i = 0; i < scene_.model.pipes.size(); ++i) {
      const Pipe& pipe = scene_.model.pipes[i];
      std::vector<PipeSection> sections;
      rack_vision::append_sections(pipe, 0, sections);
      for (const PipeSection& section : sections) {
        tubes_.push_back({.shape = section,
                          .pipe = i,
                          .begin = (section.start - pipe.start).dot(pipe.direction),
                          .slope = (section.radius_end - section.radius_start) / section.length});
      }
      around_.push_back(around(pipe.direction));
      const double drawn = statistics::uniform(engine, kColdest, kWarmest);
      temperatures_.push_back(scene_.pipe_temperatures.empty() ? drawn
                                                               : scene_.pipe_temperatures[i]);
      phases_.push_back(statistics::uniform(engine, 0, 2 * std::numbers::pi));
    }
  }

  void prepare_ground() {
    auto engine = statistics::make_engine(scene_.seed, kSurfaceDraws + kGrainCells);
    grain_.resize(std::size_t{kGrainCells} * kGrainCells);
    for (double& cell : grain_) {
      cell = scene_.ground_grain * statistics::normal(engine);
    }
  }

  void prepare_sensor() {
    const geometry::CameraParameters& p = camera_.parameters();
    for (int v = 0; v < p.height; ++v) {
      for (int u = 0; u < p.width; ++u) {
        const auto ray = camera_.ray({u, v});
        rays_.push_back(ray ? ray->normalized() : Vector3d(Vector3d::UnitZ()));
      }
    }
    plane_.resize(rays_.size());
    buffer_.resize(rays_.size());
    auto engine = statistics::make_engine(scene_.seed, kPatternDraws);
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      pattern_.push_back(sensor_.fixed_pattern * statistics::normal(engine));
    }
    constexpr double kReference = 30;  // degC, of the NETD
    per_kelvin_ = band_.of(kReference + 0.5) - band_.of(kReference - 0.5);
    sky_ = band_.of(scene_.sky_temperature);
    air_ = band_.of(scene_.air_temperature);
    double sum = 0;
    for (int i = -kBlurReach; i <= kBlurReach; ++i) {
      const double x = sensor_.lens_blur > 0 ? i / sensor_.lens_blur : (i == 0 ? 0 : 1e3);
      sum += kernel_[static_cast<std::size_t>(i + kBlurReach)] = std::exp(-0.5 * x * x);
    }
    for (double& weight : kernel_) {
      weight /= sum;
    }
  }

  /// Of the surface of a pipe, degC.
  [[nodiscard]] double surface(std::size_t pipe, double along, const Vector3d& normal,
                               double radius) const {
    constexpr double kWave = 1.7;  // rad/m
    const Around& axes = around_[pipe];
    const double azimuth = std::atan2(normal.dot(axes.side), normal.dot(axes.top));
    double celsius = temperatures_[pipe] +
                     scene_.pipe_change * std::sin(kWave * along + phases_[pipe]) -
                     kSkyCooling * std::max(0.0, std::cos(azimuth));
    for (const HotSpot& spot : scene_.hot_spots) {
      if (spot.pipe != pipe || std::abs(along - spot.along) > 0.5 * spot.length + kFlank) {
        continue;
      }
      const double turn = std::abs(std::remainder(azimuth - spot.azimuth, 2 * std::numbers::pi));
      const double whole =
          spot.half_angle >= std::numbers::pi ? 1.0 : within((spot.half_angle - turn) * radius);
      celsius += spot.rise * whole * within(0.5 * spot.length - std::abs(along - spot.along));
    }
    return celsius;
  }

  void meet(const Tube& tube, const Vector3d& eye, const Vector3d& ray, Hit& hit) const {
    const PipeSection& s = tube.shape;
    const Vector3d w = eye - s.start;
    const double wz = w.dot(s.direction);
    const double vz = ray.dot(s.direction);
    const double k = tube.slope;
    const double stretch = 1 + k * k;
    const double a = 1 - vz * vz * stretch;
    const double b = w.dot(ray) - wz * vz * stretch - k * s.radius_start * vz;
    const double c = w.squaredNorm() - wz * wz * stretch - 2 * k * s.radius_start * wz -
                     s.radius_start * s.radius_start;
    const double discriminant = b * b - a * c;
    if (discriminant <= 0 || a <= 0) {
      return;  // beside it, or along it
    }
    const double range = (-b - std::sqrt(discriminant)) / a;
    const double along = wz + range * vz;
    if (range <= 0 || range >= hit.range || along < 0 || along > s.length) {
      return;
    }
    const Vector3d radial = w + range * ray - along * s.direction;
    const double radius = s.radius_start + k * along;
    hit.range = range;
    hit.normal = (radial / radius - k * s.direction).normalized();
    hit.celsius = surface(tube.pipe, tube.begin + along, radial / radius, radius);
  }

  void meet(const rack_vision::Support& box, const Vector3d& eye, const Vector3d& ray,
            Hit& hit) const {
    double enter = 0;
    double leave = std::numeric_limits<double>::infinity();
    int side = 2;
    for (int i = 0; i < 3; ++i) {
      double from = (box.lowest_corner[i] - eye[i]) / ray[i];
      double to = (box.highest_corner[i] - eye[i]) / ray[i];
      if (from > to) {
        std::swap(from, to);
      }
      side = from > enter ? i : side;
      enter = std::max(enter, from);
      leave = std::min(leave, to);
    }
    if (enter <= 0 || enter > leave || enter >= hit.range) {
      return;
    }
    hit.range = enter;
    hit.normal = Vector3d::Zero();
    hit.normal[side] = ray[side] > 0 ? -1 : 1;
    hit.celsius = scene_.ground_temperature;
  }

  void meet_ground(const Vector3d& eye, const Vector3d& ray, Hit& hit) const {
    const double range = (scene_.ground_height - eye.z()) / ray.z();
    if (!(range > 0) || range >= hit.range || range > kLongestHorizon) {
      return;
    }
    const Eigen::Vector2d place = (eye + range * ray).head<2>();
    hit.range = range;
    hit.normal = Vector3d::UnitZ();
    hit.celsius = scene_.ground_temperature + grain(place);
    for (const WarmGround& warm : scene_.warm_ground) {
      if ((place - warm.middle).norm() < warm.radius) {
        hit.celsius = warm.temperature;
      }
    }
  }

  /// K, bilinear.
  [[nodiscard]] double grain(const Eigen::Vector2d& place) const {
    const Eigen::Vector2d cell = place / kGrainCell;
    const Eigen::Vector2d low(std::floor(cell.x()), std::floor(cell.y()));
    const Eigen::Vector2d share = cell - low;
    const auto value = [&](int dx, int dy) {
      constexpr int kMask = kGrainCells - 1;
      const auto x = static_cast<std::size_t>((static_cast<int>(low.x()) + dx) & kMask);
      const auto y = static_cast<std::size_t>((static_cast<int>(low.y()) + dy) & kMask);
      return grain_[y * kGrainCells + x];
    };
    return std::lerp(std::lerp(value(0, 0), value(1, 0), share.x()),
                     std::lerp(value(0, 1), value(1, 1), share.x()), share.y());
  }

  /// What comes along the ray, W/(m^2 sr).
  [[nodiscard]] double radiance(const Vector3d& eye, const Vector3d& ray) const {
    Hit hit;
    for (const Tube& tube : tubes_) {
      meet(tube, eye, ray, hit);
    }
    for (const rack_vision::Support& support : scene_.model.supports) {
      meet(support, eye, ray, hit);
    }
    meet_ground(eye, ray, hit);
    if (!std::isfinite(hit.range)) {
      return sky_;
    }
    // Reflection by Schlick's approximation of Fresnel's equations: all at grazing angles.
    const double cosine = std::clamp(-ray.dot(hit.normal), 0.0, 1.0);
    const double squarely = 1 - scene_.emissivity;
    const double reflected = squarely + (1 - squarely) * fifth_power(1 - cosine);
    const Vector3d onwards = ray + 2 * cosine * hit.normal;
    const double surroundings = onwards.z() > 0 ? sky_ : air_;
    const double leaves = (1 - reflected) * band_.of(hit.celsius) + reflected * surroundings;
    const double kept = std::exp(-scene_.air_absorption * hit.range);
    return kept * leaves + (1 - kept) * air_;
  }

  void blur() {
    const int width = camera_.parameters().width;
    const int height = camera_.parameters().height;
    const auto pass = [&](const std::vector<double>& from, std::vector<double>& to, bool rows) {
      for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
          double sum = 0;
          for (int i = -kBlurReach; i <= kBlurReach; ++i) {
            const int x = rows ? std::clamp(u + i, 0, width - 1) : u;
            const int y = rows ? v : std::clamp(v + i, 0, height - 1);
            sum += kernel_[static_cast<std::size_t>(i + kBlurReach)] *
                   from[static_cast<std::size_t>(y * width + x)];
          }
          to[static_cast<std::size_t>(v * width + u)] = sum;
        }
      }
    };
    pass(plane_, buffer_, true);
    pass(buffer_, plane_, false);
  }

  RackThermalScene scene_;
  geometry::Camera camera_;
  RackThermalSensor sensor_;
  internal::BandRadiance band_;
  std::vector<Tube> tubes_;
  std::vector<Around> around_;        // by pipe
  std::vector<double> temperatures_;  // likewise
  std::vector<double> phases_;        // likewise
  std::vector<double> grain_;         // K
  std::vector<Vector3d> rays_;        // unit, camera frame
  std::vector<double> pattern_;       // NETD
  std::vector<double> plane_;
  std::vector<double> buffer_;
  std::array<double, 2 * kBlurReach + 1> kernel_{};
  double per_kelvin_ = 1;
  double sky_ = 0;
  double air_ = 0;
};

RackThermalRenderer::RackThermalRenderer(const RackThermalScene& scene,
                                         const geometry::Camera& camera,
                                         const RackThermalSensor& sensor)
    : implementation_(std::make_unique<Implementation>(scene, camera, sensor)) {}
RackThermalRenderer::RackThermalRenderer(RackThermalRenderer&&) noexcept = default;
RackThermalRenderer& RackThermalRenderer::operator=(RackThermalRenderer&&) noexcept = default;
RackThermalRenderer::~RackThermalRenderer() = default;

void RackThermalRenderer::render(const geometry::SE3& T_rack_camera, std::uint64_t frame,
                                 std::span<std::uint16_t> counts) {
  implementation_->render(T_rack_camera, frame, counts);
}

const geometry::Camera& RackThermalRenderer::camera() const noexcept {
  return implementation_->camera();
}

}  // namespace pipescout::simulation
