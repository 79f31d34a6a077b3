// SPDX-License-Identifier: Apache-2.0
#include "place_images.hpp"

#include <cmath>
#include <cstddef>
#include <optional>

#include "pipescout/rack_study/image_flight.hpp"
#include "pipescout/rack_study/mesh_renderer.hpp"
#include "pipescout/simulation/rack_image.hpp"
#include "pipescout/simulation/rack_image_light.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::rack_study {

FirstPose draw_first_pose(double position, double rotation, std::mt19937_64& engine) {
  FirstPose first;
  first.sigma << Eigen::Vector3d::Constant(position), Eigen::Vector3d::Constant(rotation);
  first.error = first.sigma.cwiseProduct(statistics::normals<6>(engine));
  return first;
}

PlaceImages::PlaceImages(const rack_vision::RackModel& rack, World world, double duration,
                         std::mt19937_64& engine) {
  constexpr double kEarliest = 2;  // s
  constexpr double kLatest = 25;   // s
  CameraFlightSettings flight;
  const auto count = static_cast<std::size_t>(std::lround(duration * flight.frame_rate));
  flight.duration = statistics::uniform(engine, kEarliest, kLatest) + duration;
  motions_ = fly_camera(inspection_way_points(flight.duration, engine()), flight, engine());
  motions_.erase(motions_.begin(), motions_.end() - static_cast<std::ptrdiff_t>(count));
  const auto pixels = static_cast<std::size_t>(camera_.parameters().width) *
                      static_cast<std::size_t>(camera_.parameters().height);
  const simulation::ChangingRackLight light({}, engine());
  simulation::RackScene scene;
  scene.model = rack;
  scene.seed = engine();
  std::optional<simulation::RackImageRenderer> caster;
  std::optional<MeshRenderer> mesh;
  if (world == World::kMesh) {
    mesh.emplace(MeshScene{.model = scene.model, .seed = scene.seed}, camera_);
  } else {
    caster.emplace(scene, camera_);
  }
  for (const CameraMotion& motion : motions_) {
    std::vector<std::uint8_t>& image = images_.emplace_back(pixels);
    if (mesh) {
      mesh->render(motion.T_camera_rack, images_.size(), image);
    } else {
      caster->render(view_of(motion, light, images_.size()), image);
    }
  }
}

std::vector<FrameScore> PlaceImages::localize(
    const rack_vision::RackModel& file, const rack_vision::RackLocalizationParameters& parameters,
    const FirstPose& first, const OnImage& on_image) const {
  rack_vision::RackLocalization localization(file, camera_, parameters);
  const geometry::SE3 truth = motions_.front().T_camera_rack.inverse();
  localization.set_pose(geometry::SE3(geometry::SO3::exp(first.error.tail<3>()) * truth.rotation(),
                                      truth.translation() + first.error.head<3>()),
                        geometry::Matrix6d(first.sigma.cwiseAbs2().asDiagonal()));
  std::vector<FrameScore> frames;
  for (std::size_t i = 0; i < images_.size(); ++i) {
    const rack_vision::ImageView view{.pixels = images_[i].data(),
                                      .width = camera_.parameters().width,
                                      .height = camera_.parameters().height,
                                      .stride = camera_.parameters().width};
    const auto result = localization.track(view, motions_[i].time);
    FrameScore& frame = frames.emplace_back(score_frame(result, motions_[i].T_camera_rack));
    frame.time = motions_[i].time;
    if (on_image) {
      on_image(result, frame);
    }
  }
  return frames;
}

PlaceOutcome outcome_of(std::span<const FrameScore> frames) {
  const FrameScore last = frames.empty() ? FrameScore{} : frames.back();
  return {.images = score_flight(frames),
          .converged = last.has_pose && !is_wrong(last),
          .lost = !last.has_pose};
}

}  // namespace pipescout::rack_study
