// SPDX-License-Identifier: Apache-2.0
#include "rack_inputs.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <string>

#include "pipescout/rack_vision/surface_points.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"
#include "pipescout/simulation/rack_image.hpp"

namespace pipescout::benchmarks {
namespace {

using geometry::SE3;
using Engine = std::mt19937_64;

constexpr double kHeight = 3.0;  ///< m, of the flight

/// A smooth motion of one coordinate: two sines, the slow one of the flight and the fast one of the
/// gusts.
class Sway {
 public:
  Sway(Engine& engine, double amplitude, double frequency, double gust, double gust_frequency)
      : amplitudes_{amplitude, gust}, frequencies_{frequency, gust_frequency} {
    std::uniform_real_distribution<double> phase(0.0, 2.0 * std::numbers::pi);
    phases_ = {phase(engine), phase(engine)};
  }
  [[nodiscard]] double at(double t) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < phases_.size(); ++i) {
      sum += amplitudes_[i] * std::sin(2.0 * std::numbers::pi * frequencies_[i] * t + phases_[i]);
    }
    return sum;
  }

 private:
  std::array<double, 2> amplitudes_;   ///< m or rad
  std::array<double, 2> frequencies_;  ///< Hz
  std::array<double, 2> phases_{};     ///< rad
};

class Motion {
 public:
  Motion(std::uint64_t seed, const Eigen::Vector3d& middle)
      : engine_(seed),
        middle_(middle),
        x_(engine_, 0.35, 0.11, 0.010, 0.9),
        y_(engine_, 0.45, 0.10, 0.010, 0.8),
        z_(engine_, 0.20, 0.13, 0.008, 0.7),
        roll_(engine_, 0.03, 0.17, 0.012, 1.1),
        pitch_(engine_, 0.03, 0.19, 0.012, 1.0),
        yaw_(engine_, 0.15, 0.10, 0.005, 0.6) {}

  /// Image x is across the pipes and image down is against the flow where all sways are zero.
  [[nodiscard]] SE3 T_rack_camera(double t) const {
    const Eigen::Matrix3d down = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
    const Eigen::AngleAxisd yaw(yaw_.at(t), Eigen::Vector3d::UnitZ());
    const Eigen::AngleAxisd pitch(pitch_.at(t), Eigen::Vector3d::UnitX());
    const Eigen::AngleAxisd roll(roll_.at(t), Eigen::Vector3d::UnitY());
    const Eigen::Matrix3d rotation = (yaw * pitch * roll).toRotationMatrix() * down;
    return {geometry::SO3::from_matrix(rotation),
            middle_ + Eigen::Vector3d(x_.at(t), y_.at(t), z_.at(t))};
  }

 private:
  Engine engine_;
  Eigen::Vector3d middle_;
  Sway x_, y_, z_, roll_, pitch_, yaw_;
};

Eigen::Vector3d above_the_middle(const rack_vision::RackModel& model) {
  const rack_vision::Pipe& last = model.pipes.back();
  const double width = last.start.x() + last.largest_radius();
  return {width / 2.0, last.length() / 2.0, kHeight};
}

}  // namespace

rack_vision::RackModel benchmark_rack() {
  constexpr double kLength = 10.0;
  const auto cylinder = [](const char* name, double radius) {
    return rack_vision::RowPipe{.name = name, .radii = {{0.0, radius}, {kLength, radius}}};
  };
  const std::array row = {cylinder("water", 0.15), cylinder("steam", 0.20), cylinder("gas", 0.17),
                          cylinder("oil", 0.19)};
  rack_vision::RackModel model{.pipes = rack_vision::row_of_pipes(row), .supports = {}};
  const double width = model.pipes.back().start.x() + model.pipes.back().largest_radius();
  for (int i = 0; i < 5; ++i) {
    const double y = 0.9 + 2.0 * i;
    model.supports.push_back({.name = "beam " + std::to_string(i + 1),
                              .lowest_corner = {-0.2, y, -0.2},
                              .highest_corner = {width + 0.2, y + 0.2, 0.0}});
  }
  model.validate();
  return model;
}

geometry::Camera benchmark_camera() {
  return geometry::Camera(geometry::CameraParameters{});
}

rack_vision::ImageView RackFlight::image(std::size_t index) const {
  const int width = camera.parameters().width;
  const int height = camera.parameters().height;
  const auto bytes = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  return {
      .pixels = pixels.data() + index * bytes, .width = width, .height = height, .stride = width};
}

RackFlight rack_flight(std::uint64_t seed, bool textured, std::size_t images,
                       std::optional<double> noise) {
  const rack_vision::RackModel model = benchmark_rack();
  RackFlight flight{.camera = benchmark_camera(), .T_rack_camera = {}, .pixels = {}};
  simulation::RackScene scene{.model = model, .seed = seed};
  if (!textured) {
    constexpr double kBeyondEnds = 1.0;
    scene.plain = {{-kBeyondEnds, model.pipes.front().length() + kBeyondEnds}};
  }
  simulation::ImageSensor sensor;
  if (noise) {
    sensor.electrons_per_level = 0;
    sensor.read_noise = *noise;
  }
  simulation::RackImageRenderer renderer(scene, flight.camera, sensor);
  const Motion motion(seed, above_the_middle(model));
  const std::size_t bytes = static_cast<std::size_t>(flight.camera.parameters().width) *
                            static_cast<std::size_t>(flight.camera.parameters().height);
  flight.pixels.resize(images * bytes);
  for (std::size_t i = 0; i < images; ++i) {
    const double t = kImagePeriod * static_cast<double>(i);
    constexpr double kHalfStep = 1e-3;
    const SE3 before = motion.T_rack_camera(t - kHalfStep);
    const SE3 after = motion.T_rack_camera(t + kHalfStep);
    flight.T_rack_camera.push_back(motion.T_rack_camera(t));
    renderer.render({.T_camera_rack = flight.T_rack_camera.back().inverse(),
                     .velocity = (before.inverse() * after).log() / (2.0 * kHalfStep),
                     .light = {},
                     .frame = i},
                    std::span(flight.pixels).subspan(i * bytes, bytes));
  }
  return flight;
}

FeatureFrame feature_frame(const rack_vision::RackModel& model, const geometry::Camera& camera,
                           std::uint64_t seed) {
  constexpr std::size_t kEdgeSamples = 500;
  constexpr std::size_t kPoints = 50;
  constexpr double kSigma = 0.3;
  Engine engine(seed);
  std::normal_distribution<double> noise(0.0, kSigma);
  FeatureFrame frame;
  frame.T_camera_rack = Motion(seed, above_the_middle(model)).T_rack_camera(0.0).inverse();
  geometry::Vector6d wrong;
  wrong << 0.01, -0.01, 0.014, 0.006, -0.006, 0.006;
  frame.first_guess = SE3::exp(wrong) * frame.T_camera_rack;

  std::vector<rack_vision::VisibleEdge> edges;
  rack_vision::EdgeRenderer().render(model, {}, camera, frame.T_camera_rack, edges);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const std::size_t first = i * kEdgeSamples / edges.size();
    const std::size_t last = (i + 1) * kEdgeSamples / edges.size();
    const Eigen::Vector2d along = edges[i].image_end - edges[i].image_start;
    const Eigen::Vector2d normal = Eigen::Vector2d(-along.y(), along.x()).normalized();
    for (std::size_t j = first; j < last; ++j) {
      const double share =
          static_cast<double>(j - first + 1) / static_cast<double>(last - first + 1);
      rack_vision::EdgeSample sample{.edge = edges[i].id, .candidates = {}, .sigma = kSigma};
      sample.candidates[0] = edges[i].image_start + share * along + noise(engine) * normal;
      frame.edges.push_back(sample);
    }
  }

  const rack_vision::RackSurface surface(model, {});
  std::uniform_real_distribution<double> u(0.0, camera.parameters().width - 1.0);
  std::uniform_real_distribution<double> v(0.0, camera.parameters().height - 1.0);
  while (frame.points.size() < kPoints) {
    const Eigen::Vector2d pixel(u(engine), v(engine));
    const auto hit = surface.seen_at(camera, frame.T_camera_rack, pixel);
    if (hit && hit->kind == rack_vision::EdgeKind::kPipe) {
      frame.points.push_back({.pipe = hit->body,
                              .place = hit->point,
                              .pixel = pixel + Eigen::Vector2d(noise(engine), noise(engine)),
                              .sigma = kSigma});
    }
  }
  return frame;
}

}  // namespace pipescout::benchmarks
