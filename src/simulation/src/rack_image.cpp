// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/rack_image.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "pipescout/validation/check.hpp"
#include "rack_image_bodies.hpp"
#include "rack_image_rays.hpp"
#include "rack_image_scene.hpp"
#include "rack_image_sensor.hpp"
#include "rack_image_shade.hpp"

namespace pipescout::simulation {
namespace {

using validation::check_within;

void check_paint(const std::string& body, double albedo) {
  check_within(body + "albedo", albedo, 0.02, 0.95);
}

/// Samples of a pixel that more than one surface shares: a Fibonacci lattice, so that a straight
/// edge at any angle is placed to 1/110 pixel, and the mean of all samples is the pixel's middle.
constexpr std::size_t kSamples = 55;
constexpr int kLatticeStep = 34;

}  // namespace

void SceneBodies::validate() const {
  constexpr double kFarthest = 1e5;   // m
  constexpr double kSmallest = 1e-4;  // m
  const auto check_place = [](const std::string& field, const Eigen::Vector3d& place) {
    for (const double coordinate : place) {
      check_within(field, coordinate, -kFarthest, kFarthest);
    }
  };
  constexpr double kMost = 1000;
  check_within("SceneBodies (how many)", static_cast<double>(cylinders.size() + boxes.size()), 0,
               kMost);
  for (std::size_t i = 0; i < cylinders.size(); ++i) {
    const SceneCylinder& cylinder = cylinders[i];
    const std::string field = "SceneBodies.cylinders[" + std::to_string(i) + "].";
    check_place(field + "start", cylinder.start);
    check_within(field + "direction (its norm)", cylinder.direction.norm(), 1 - 1e-6, 1 + 1e-6);
    check_within(field + "length", cylinder.length, kSmallest, kFarthest);
    check_within(field + "radius", cylinder.radius, kSmallest, kFarthest);
    check_paint(field, cylinder.albedo);
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const SceneBox& box = boxes[i];
    const std::string field = "SceneBodies.boxes[" + std::to_string(i) + "].";
    check_place(field + "lowest_corner", box.lowest_corner);
    const Eigen::Vector3d size = box.highest_corner - box.lowest_corner;
    check_within(field + "highest_corner (its least distance from lowest_corner)", size.minCoeff(),
                 kSmallest, kFarthest);
    check_paint(field, box.albedo);
  }
}

void RackScene::validate() const {
  model.validate();
  if (!finishes.empty() && finishes.size() != model.pipes.size()) {
    throw std::invalid_argument("RackScene.finishes: " + std::to_string(finishes.size()) +
                                " entries; there must be none or one for each of the " +
                                std::to_string(model.pipes.size()) + " pipes");
  }
  for (std::size_t i = 0; i < finishes.size(); ++i) {
    const std::string field = "RackScene.finishes[" + std::to_string(i) + "].";
    check_within(field + "albedo", finishes[i].albedo, 0.02, 0.95);
    check_within(field + "rust", finishes[i].rust, 0, 1);
    check_within(field + "contrast", finishes[i].contrast, 0, 1.5);
    check_within(field + "gloss", finishes[i].gloss, 0, 2);
  }
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const std::string field = "RackScene.plain[" + std::to_string(i) + "].";
    check_within(field + "from", plain[i].from, -1e6, 1e6);
    check_within(field + "to", plain[i].to, plain[i].from, 1e6);
  }
  check_within("RackScene.ground_height", ground_height, -100, -0.5);
  check_within("RackScene.ground_albedo", ground_albedo, 0.02, 0.95);
  check_within("RackScene.clutter_share", clutter_share, 0, 0.8);
  bodies.validate();
  check_within("RackScene.people", static_cast<double>(people), 0, kMostPeople);
}

void ImageSensor::validate() const {
  check_within("ImageSensor.exposure", exposure, 0, 0.1);
  check_within("ImageSensor.row_time", row_time, 0, 1e-4);
  check_within("ImageSensor.lens_blur", lens_blur, 0, 5);
  check_within("ImageSensor.vignetting", vignetting, 0, 0.9);
  check_within("ImageSensor.electrons_per_level", electrons_per_level, 0, 1e6);
  check_within("ImageSensor.read_noise", read_noise, 0, 50);
}

ImageSensor perfect_image_sensor() {
  return {
      .exposure = 0, .lens_blur = 0, .vignetting = 0, .electrons_per_level = 0, .read_noise = 0};
}

void RackLight::validate() const {
  check_within("RackLight.to_sun (its norm)", to_sun.norm(), 1 - 1e-6, 1 + 1e-6);
  check_within("RackLight.sun", sun, 0, 10);
  check_within("RackLight.sky", sky, 0, 10);
  check_within("RackLight.gain", gain, 0, 100);
  check_within("RackLight.offset", offset, -255, 255);
}

class RackImageRenderer::Implementation {
 public:
  Implementation(const RackScene& scene, const geometry::Camera& camera, const ImageSensor& sensor)
      : camera_(camera),
        built_(internal::build_scene(scene)),
        rays_(camera),
        eye_(built_.bodies),
        shader_(built_.bodies, built_.wardrobe, scene.shadows),
        sensor_(sensor, camera, scene.seed),
        row_time_(sensor.row_time),
        radiance_(width(), height()),
        codes_(static_cast<std::size_t>(width()) * static_cast<std::size_t>(height())) {
    block_bodies_.reserve(built_.bodies.size());
    tile_bodies_.reserve(built_.bodies.size());
    for (std::size_t i = 0; i < kSamples; ++i) {
      const double x = (static_cast<double>(i) + 0.5) / kSamples;
      const double y = x * kLatticeStep - std::floor(x * kLatticeStep);
      lattice_[i] = Eigen::Vector2f(static_cast<float>(x - 0.5), static_cast<float>(y - 0.5));
    }
  }

  [[nodiscard]] const geometry::Camera& camera() const noexcept { return camera_; }

  void render(const RackView& view, std::span<std::uint8_t> grey) {
    if (grey.size() != codes_.size()) {
      throw std::invalid_argument("RackImageRenderer::render: grey has " +
                                  std::to_string(grey.size()) + " pixels, the camera " +
                                  std::to_string(codes_.size()));
    }
    view.light.validate();
    if (!view.velocity.allFinite()) {
      throw std::invalid_argument("RackView.velocity is not finite");
    }
    place_people(view.people);
    shader_.prepare(view.light, 1 / camera_.parameters().focal_length);
    trace_image(view);
    for (int v = 0; v < height(); v += internal::kRayTile) {
      look(view, time_of_tile(v));
      for (int u = 0; u < width(); u += internal::kRayTile) {
        refine_tile(u, v);
      }
    }
    look(view, 0);
    find_velocities(view);
    sensor_.expose(radiance_, view.light, view.frame, grey);
  }

 private:
  /// One sample of a pixel that waits to be shaded.
  struct Share {
    int u = 0;
    int v = 0;
    float weight = 0;
  };

  [[nodiscard]] int width() const { return camera_.parameters().width; }
  [[nodiscard]] int height() const { return camera_.parameters().height; }
  [[nodiscard]] internal::HitCode& code(int u, int v) {
    return codes_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width()) +
                  static_cast<std::size_t>(u)];
  }

  void place_people(std::span<const Eigen::Vector3d> people) {
    if (people.size() != built_.people) {
      throw std::invalid_argument("RackView.people: " + std::to_string(people.size()) +
                                  " places; the scene has " + std::to_string(built_.people));
    }
    std::vector<internal::Cone>& cones = built_.bodies.cones;
    for (std::size_t i = 0; i < people.size(); ++i) {
      if (!people[i].allFinite()) {
        throw std::invalid_argument("RackView.people[" + std::to_string(i) + "] is not finite");
      }
      cones[built_.first_person + i].start = people[i];
    }
  }

  /// s, from the middle of the image to that of the tile whose uppermost row is v.
  [[nodiscard]] double time_of_tile(int v) const {
    return row_time_ * (v + 0.5 * (internal::kRayTile - height()));
  }

  /// From where the camera is `time` s after the view's pose.
  void look(const RackView& view, double time) {
    geometry::SE3 T_rack_camera = view.T_camera_rack.inverse();
    if (time != 0) {
      T_rack_camera = T_rack_camera * geometry::SE3::exp(time * view.velocity);
    }
    R_rack_camera_ = T_rack_camera.rotation().matrix();
    rotation_ = R_rack_camera_.cast<float>();
    eye_.look_from(T_rack_camera.translation());
    shader_.look_from(T_rack_camera.translation());
  }

  /// One ray through the middle of each pixel; bodies are sorted out by blocks, then by tiles.
  void trace_image(const RackView& view) {
    look(view, 0);
    for (const internal::RayTable::Block& block : rays_.blocks()) {
      block_bodies_.clear();
      const internal::RayCone block_cone{R_rack_camera_ * block.cone.axis, block.cone.tangent};
      for (std::size_t body = 0; body < built_.bodies.size(); ++body) {
        // The poses of its tiles differ from the one by which the block is judged.
        if (row_time_ > 0 || eye_.may_hit(body, block_cone)) {
          block_bodies_.push_back(body);
        }
      }
      for (const internal::RayTable::Tile& tile : block.tiles) {
        if (row_time_ > 0) {
          look(view, time_of_tile(tile.v));
        }
        tile_bodies_.clear();
        const internal::RayCone cone{R_rack_camera_ * tile.cone.axis, tile.cone.tangent};
        for (const std::size_t body : block_bodies_) {
          if (eye_.may_hit(body, cone)) {
            tile_bodies_.push_back(body);
          }
        }
        trace_tile(tile);
      }
    }
  }

  void trace_tile(const internal::RayTable::Tile& tile) {
    batch_.count = 0;
    for (int v = tile.v; v < tile.v_end; ++v) {
      for (int u = tile.u; u < tile.u_end; ++u) {
        append_ray(rays_.at(u, v), batch_);
      }
    }
    eye_.trace_ground(batch_);
    for (const std::size_t body : tile_bodies_) {
      eye_.trace(body, batch_);
    }
    shader_.shade(batch_, shades_);
    std::size_t i = 0;
    for (int v = tile.v; v < tile.v_end; ++v) {
      float* row = radiance_.row(v);
      for (int u = tile.u; u < tile.u_end; ++u, ++i) {
        row[u] = shades_[i];
        code(u, v) = batch_.code[i];
      }
    }
  }

  void append_ray(const Eigen::Vector2f& plane, internal::RayBatch& batch) const {
    const Eigen::Vector3f d = rotation_ * Eigen::Vector3f(plane.x(), plane.y(), 1);
    const std::size_t i = batch.count++;
    batch.dx[i] = d.x();
    batch.dy[i] = d.y();
    batch.dz[i] = d.z();
  }

  /// Samples the pixels again where their neighbours show another surface.
  void refine_tile(int u0, int v0) {
    const int u_end = std::min(u0 + internal::kRayTile, width());
    const int v_end = std::min(v0 + internal::kRayTile, height());
    waiting_.count = 0;
    for (int v = v0; v < v_end; ++v) {
      for (int u = u0; u < u_end; ++u) {
        refine_pixel(u, v);
      }
    }
    shade_waiting();
  }

  /// Whether any of the eight neighbours shows another surface.
  [[nodiscard]] bool is_mixed(int u, int v) const {
    const int left = u > 0 ? -1 : 0;
    const int right = u + 1 < width() ? 1 : 0;
    const internal::HitCode* row = codes_.data() + static_cast<std::ptrdiff_t>(v) * width() + u;
    const internal::HitCode* upper = v > 0 ? row - width() : row;
    const internal::HitCode* lower = v + 1 < height() ? row + width() : row;
    const internal::HitCode own = *row;
    return ((row[left] ^ own) | (row[right] ^ own) | (upper[left] ^ own) | (upper[0] ^ own) |
            (upper[right] ^ own) | (lower[left] ^ own) | (lower[0] ^ own) | (lower[right] ^ own)) !=
           0;
  }

  void refine_pixel(int u, int v) {
    if (!is_mixed(u, v)) {
      return;
    }
    std::array<internal::HitCode, 9> bodies{};
    std::size_t count = 0;
    for (int j = std::max(v - 1, 0); j <= std::min(v + 1, height() - 1); ++j) {
      for (int i = std::max(u - 1, 0); i <= std::min(u + 1, width() - 1); ++i) {
        const internal::HitCode other = code(i, j);
        const internal::HitCode body = other & internal::kBodyMask;
        const auto end = bodies.begin() + static_cast<std::ptrdiff_t>(count);
        if (other != internal::kSky && body != internal::kGround &&
            std::find(bodies.begin(), end, body) == end) {
          bodies[count++] = body;
        }
      }
    }
    const Eigen::Vector2f centre = rays_.at(u, v);
    const Eigen::Vector2f along_u = 0.5F * (rays_.at(u + 1, v) - rays_.at(u - 1, v));
    const Eigen::Vector2f along_v = 0.5F * (rays_.at(u, v + 1) - rays_.at(u, v - 1));
    samples_.count = 0;
    for (const Eigen::Vector2f& place : lattice_) {
      append_ray(centre + place.x() * along_u + place.y() * along_v, samples_);
    }
    eye_.trace_ground(samples_);
    for (std::size_t i = 0; i < count; ++i) {
      eye_.trace(static_cast<std::size_t>(bodies[i]), samples_);
    }
    radiance_.row(v)[u] = 0;
    // Each surface within the pixel is shaded once, in the middle of what is seen of it.
    std::array<bool, kSamples> done{};
    for (std::size_t i = 0; i < kSamples; ++i) {
      if (!done[i]) {
        wait_for_shade(u, v, i, done);
      }
    }
  }

  void wait_for_shade(int u, int v, std::size_t first, std::array<bool, kSamples>& done) {
    if (waiting_.count == internal::kBatch) {
      shade_waiting();
    }
    const std::size_t slot = waiting_.count++;
    float x = 0;
    float y = 0;
    float z = 0;
    float t = 0;
    float members = 0;
    for (std::size_t i = first; i < kSamples; ++i) {
      if (samples_.code[i] == samples_.code[first]) {
        done[i] = true;
        x += samples_.dx[i];
        y += samples_.dy[i];
        z += samples_.dz[i];
        t += samples_.t[i];
        members += 1;
      }
    }
    waiting_.dx[slot] = x / members;
    waiting_.dy[slot] = y / members;
    waiting_.dz[slot] = z / members;
    waiting_.t[slot] = t / members;
    waiting_.code[slot] = samples_.code[first];
    shares_[slot] = {u, v, members / kSamples};
  }

  void shade_waiting() {
    shader_.shade(waiting_, shades_);
    for (std::size_t i = 0; i < waiting_.count; ++i) {
      radiance_.row(shares_[i].v)[shares_[i].u] += shares_[i].weight * shades_[i];
    }
    waiting_.count = 0;
  }

  /// Of the points of the plane through the axes that are seen in the middles of the tiles.
  void find_velocities(const RackView& view) {
    constexpr double kFar = 50;  // m, where the plane is not seen
    const std::span<Eigen::Vector2f> velocities = sensor_.velocities();
    const double below = built_.axes_height - eye_.eye().z();
    const Eigen::Matrix3d R_rack_camera = rotation_.cast<double>();
    for (std::size_t i = 0; i < velocities.size(); ++i) {
      const int tile = static_cast<int>(i);
      constexpr int kTile = internal::Sensor::kTile;
      const int u = std::min(tile % sensor_.tiles_across() * kTile + kTile / 2, width() - 1);
      const int v = std::min(tile / sensor_.tiles_across() * kTile + kTile / 2, height() - 1);
      const Eigen::Vector3d ray = rays_.at(u, v).homogeneous().cast<double>();
      const double depth = below / (R_rack_camera * ray).z();
      const Eigen::Vector3d point = (depth > 0 && depth < kFar ? depth : kFar) * ray;
      const Eigen::Vector3d motion =
          -view.velocity.head<3>() - view.velocity.tail<3>().cross(point);
      geometry::Matrix23d derivative;
      velocities[i].setZero();
      if (camera_.project(point, derivative)) {
        velocities[i] = (derivative * motion).cast<float>();
      }
    }
  }

  geometry::Camera camera_;
  internal::BuiltScene built_;
  internal::RayTable rays_;
  internal::BodiesFromEye eye_;
  internal::Shader shader_;
  internal::Sensor sensor_;
  double row_time_;
  internal::Plane radiance_;
  std::vector<internal::HitCode> codes_;
  std::vector<std::size_t> block_bodies_;
  std::vector<std::size_t> tile_bodies_;
  std::array<Eigen::Vector2f, kSamples> lattice_{};
  Eigen::Matrix3d R_rack_camera_ = Eigen::Matrix3d::Identity();  // of the tile
  Eigen::Matrix3f rotation_ = Eigen::Matrix3f::Identity();       // the same
  internal::RayBatch batch_;
  internal::RayBatch samples_;
  internal::RayBatch waiting_;
  std::array<Share, internal::kBatch> shares_{};
  std::array<float, internal::kBatch> shades_{};
};

RackImageRenderer::RackImageRenderer(const RackScene& scene, const geometry::Camera& camera,
                                     const ImageSensor& sensor) {
  scene.validate();
  sensor.validate();
  implementation_ = std::make_unique<Implementation>(scene, camera, sensor);
}

RackImageRenderer::RackImageRenderer(RackImageRenderer&&) noexcept = default;
RackImageRenderer& RackImageRenderer::operator=(RackImageRenderer&&) noexcept = default;
RackImageRenderer::~RackImageRenderer() = default;

void RackImageRenderer::render(const RackView& view, std::span<std::uint8_t> grey) {
  implementation_->render(view, grey);
}

const geometry::Camera& RackImageRenderer::camera() const noexcept {
  return implementation_->camera();
}

}  // namespace pipescout::simulation
