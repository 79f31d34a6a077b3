// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/misplaced_pipes.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "pipescout/rack_study/image_score.hpp"
#include "pipescout/rack_vision/rack_localization.hpp"
#include "pipescout/simulation/rack_image_light.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::rack_study {
namespace {

using rack_vision::RackModel;

/// The images of one place, and what is tried on them.
class MisplacedPlace {
 public:
  MisplacedPlace(const MisplacedPipesSettings& settings, std::uint64_t seed)
      : settings_(settings), engine_(seed) {
    take();
  }

  MisplacedPipesTrial fly(const RackModel& file) {
    rack_vision::RackLocalizationParameters parameters;
    if (settings_.stated_deviation > 0) {
      parameters.tracker.offset_sigma = settings_.stated_deviation;
    }
    rack_vision::RackLocalization localization(file, camera_, parameters);
    geometry::Vector6d sigma;
    sigma << Eigen::Vector3d::Constant(settings_.start_position),
        Eigen::Vector3d::Constant(settings_.start_rotation);
    const geometry::Vector6d error = sigma.cwiseProduct(statistics::normals<6>(engine_));
    const geometry::SE3 truth = motions_.front().T_camera_rack.inverse();
    localization.set_pose(geometry::SE3(geometry::SO3::exp(error.tail<3>()) * truth.rotation(),
                                        truth.translation() + error.head<3>()),
                          geometry::Matrix6d(sigma.cwiseAbs2().asDiagonal()));
    MisplacedPipesTrial trial;
    for (std::size_t i = 0; i < images_.size(); ++i) {
      const rack_vision::ImageView view{.pixels = images_[i].data(),
                                        .width = camera_.parameters().width,
                                        .height = camera_.parameters().height,
                                        .stride = camera_.parameters().width};
      const auto result = localization.track(view, motions_[i].time);
      trial.frames.push_back(score_frame(result, motions_[i].T_camera_rack));
      trial.frames.back().time = motions_[i].time;
      if (trial.frames.back().has_pose) {
        trial.largest_offset_error = largest_error(file, result);
      }
    }
    return trial;
  }

  RackModel draw_file() {
    constexpr int kMostDraws = 1000;
    for (int i = 0; i < kMostDraws; ++i) {
      RackModel file = settings_.rack;
      for (rack_vision::Pipe& pipe : file.pipes) {
        if (pipe.movable) {
          pipe.start.x() +=
              statistics::uniform(engine_, -settings_.largest_offset, settings_.largest_offset);
        }
      }
      try {
        file.validate();
        return file;
      } catch (const rack_vision::InvalidRack&) {
        continue;  // some pipes ran through each other
      }
    }
    return settings_.rack;
  }

 private:
  [[nodiscard]] double largest_error(const RackModel& file,
                                     const rack_vision::RackTrackerResult& result) const {
    // Where nothing is observed, all count: to say nothing is not to be right.
    const bool any = std::ranges::any_of(result.offset_observed,
                                         [](std::uint8_t observed) { return observed != 0; });
    double largest = 0;
    for (std::size_t i = 0; i < file.pipes.size(); ++i) {
      if (file.pipes[i].movable && (!any || result.offset_observed[i] != 0)) {
        const double truth = settings_.rack.pipes[i].start.x() - file.pipes[i].start.x();
        largest = std::max(largest, std::abs(result.offsets[i] - truth));
      }
    }
    return largest;
  }

  void take() {
    constexpr double kEarliest = 2;  // s
    constexpr double kLatest = 25;   // s
    CameraFlightSettings flight;
    const auto count =
        static_cast<std::size_t>(std::lround(settings_.duration * flight.frame_rate));
    flight.duration = statistics::uniform(engine_, kEarliest, kLatest) + settings_.duration;
    motions_ = fly_camera(inspection_way_points(flight.duration, engine_()), flight, engine_());
    motions_.erase(motions_.begin(), motions_.end() - static_cast<std::ptrdiff_t>(count));
    const auto pixels = static_cast<std::size_t>(camera_.parameters().width) *
                        static_cast<std::size_t>(camera_.parameters().height);
    const simulation::ChangingRackLight light({}, engine_());
    simulation::RackScene scene;
    scene.model = settings_.rack;
    scene.seed = engine_();
    std::optional<simulation::RackImageRenderer> caster;
    std::optional<MeshRenderer> mesh;
    if (settings_.world == World::kMesh) {
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

  const MisplacedPipesSettings& settings_;
  std::mt19937_64 engine_;
  geometry::Camera camera_;
  std::vector<CameraMotion> motions_;
  std::vector<std::vector<std::uint8_t>> images_;
};

}  // namespace

MisplacedPipesScore& MisplacedPipesScore::operator+=(const MisplacedPipesScore& other) noexcept {
  trials += other.trials;
  converged += other.converged;
  lost += other.lost;
  silent_wrong += other.silent_wrong;
  images_with_pose += other.images_with_pose;
  images_silent += other.images_silent;
  images_covered += other.images_covered;
  return *this;
}

std::vector<MisplacedPipesTrial> try_misplaced_pipes(const MisplacedPipesSettings& settings,
                                                     std::size_t trials, std::uint64_t seed) {
  MisplacedPlace place(settings, seed);
  std::vector<MisplacedPipesTrial> results;
  for (std::size_t i = 0; i < trials; ++i) {
    results.push_back(place.fly(place.draw_file()));
  }
  return results;
}

MisplacedPipesTrial try_misplaced_pipes(const MisplacedPipesSettings& settings,
                                        std::span<const double> file_offsets, std::uint64_t seed) {
  RackModel file = settings.rack;
  for (std::size_t i = 0; i < file.pipes.size() && i < file_offsets.size(); ++i) {
    file.pipes[i].start.x() += file_offsets[i];
  }
  return MisplacedPlace(settings, seed).fly(file);
}

MisplacedPipesScore score_misplaced_pipes(std::span<const MisplacedPipesTrial> trials) {
  MisplacedPipesScore score;
  for (const MisplacedPipesTrial& trial : trials) {
    ++score.trials;
    const ImageFlightScore images = score_flight(trial.frames);
    score.images_with_pose += images.with_pose;
    score.images_covered += images.pose_covered_99;
    score.images_silent += images.silent_wrong;
    score.silent_wrong += images.silent_wrong > 0 ? 1 : 0;
    const FrameScore last = trial.frames.empty() ? FrameScore{} : trial.frames.back();
    score.lost += last.has_pose ? 0 : 1;
    score.converged += last.has_pose && !is_wrong(last) ? 1 : 0;
  }
  return score;
}

}  // namespace pipescout::rack_study
