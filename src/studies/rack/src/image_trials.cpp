// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/image_trials.hpp"

#include <cmath>
#include <optional>
#include <random>

#include "pipescout/rack_study/image_score.hpp"
#include "pipescout/simulation/rack_image_light.hpp"
#include "pipescout/statistics/chi_square.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::rack_study {
namespace {

using geometry::Matrix6d;
using geometry::SE3;
using geometry::Vector6d;

constexpr std::size_t kImagesBefore = 5;  // of a tracker that tracks, before a wrong prediction

Matrix6d isotropic(double position_deviation, double rotation_deviation) {
  Vector6d deviations;
  deviations << Eigen::Vector3d::Constant(position_deviation),
      Eigen::Vector3d::Constant(rotation_deviation);
  return deviations.cwiseAbs2().asDiagonal();
}

SE3 displaced(const SE3& T_rack_camera, const Vector6d& error) {
  return {geometry::SO3::exp(error.tail<3>()) * T_rack_camera.rotation(),
          T_rack_camera.translation() + error.head<3>()};
}

class Place {
 public:
  Place(const WrongStartSettings& settings, std::uint64_t seed)
      : settings_(settings), engine_(seed) {
    take_images();
  }

  WrongStartTrial first_pose() {
    WrongStartTrial trial{.kind = WrongStart::kFirstPose, .start_error = draw_error()};
    // A vector of norm r in a random direction has a standard deviation of r / sqrt(3) per axis.
    const double share = 1 / std::sqrt(3.0);
    rack_vision::RackTracker tracker(settings_.scene.model, camera_, settings_.tracker);
    tracker.set_pose(displaced(truth(kImagesBefore), trial.start_error),
                     isotropic(share * settings_.position_error, share * settings_.rotation_error));
    trial.last = follow(tracker, kImagesBefore, {});
    return trial;
  }

  WrongStartTrial prediction() {
    constexpr double kPosition = 0.01;   // m
    constexpr double kRotation = 0.005;  // rad
    WrongStartTrial trial{.kind = WrongStart::kPrediction, .start_error = draw_error()};
    rack_vision::RackTracker tracker(settings_.scene.model, camera_, settings_.tracker);
    tracker.set_pose(truth(0), isotropic(kPosition, kRotation));
    for (std::size_t i = 0; i < kImagesBefore; ++i) {
      static_cast<void>(tracker.track(view(i), motions_[i].time));
    }
    const SE3 wrong = displaced(truth(kImagesBefore), trial.start_error);
    trial.last = follow(tracker, kImagesBefore,
                        rack_vision::MotionPrediction{
                            .T_previous_current = truth(kImagesBefore - 1).inverse() * wrong,
                            .covariance = isotropic(settings_.stated_position_deviation,
                                                    settings_.stated_rotation_deviation)});
    return trial;
  }

 private:
  void take_images() {
    constexpr double kEarliest = 2;  // s
    constexpr double kLatest = 25;   // s
    const std::size_t count = kImagesBefore + settings_.images;
    CameraFlightSettings flight;
    const double begin = statistics::uniform(engine_, kEarliest, kLatest);
    flight.duration = begin + static_cast<double>(count) / flight.frame_rate;
    motions_ = fly_camera(inspection_way_points(flight.duration, engine_()), flight, engine_());
    motions_.erase(motions_.begin(), motions_.end() - static_cast<std::ptrdiff_t>(count));

    simulation::RackScene scene = settings_.scene;
    scene.seed = engine_();
    simulation::RackImageRenderer renderer(scene, camera_);
    const simulation::ChangingRackLight light({}, engine_());
    const auto pixels = static_cast<std::size_t>(camera_.parameters().width) *
                        static_cast<std::size_t>(camera_.parameters().height);
    for (const CameraMotion& motion : motions_) {
      images_.emplace_back(pixels);
      renderer.render(view_of(motion, light, images_.size()), images_.back());
    }
  }

  Vector6d draw_error() {
    Vector6d error;
    error.head<3>() = settings_.position_error * statistics::normals<3>(engine_).normalized();
    error.tail<3>() = settings_.rotation_error * statistics::normals<3>(engine_).normalized();
    return error;
  }

  [[nodiscard]] SE3 truth(std::size_t i) const { return motions_[i].T_camera_rack.inverse(); }

  [[nodiscard]] rack_vision::ImageView view(std::size_t i) const {
    const int width = camera_.parameters().width;
    return {.pixels = images_[i].data(),
            .width = width,
            .height = camera_.parameters().height,
            .stride = width};
  }

  /// From image `begin`, which comes with `motion`, to the last.
  FrameScore follow(rack_vision::RackTracker& tracker, std::size_t begin,
                    const std::optional<rack_vision::MotionPrediction>& motion) const {
    FrameScore last;
    for (std::size_t i = begin; i < images_.size(); ++i) {
      const auto result =
          tracker.track(view(i), motions_[i].time, i == begin ? motion : std::nullopt);
      last = score_frame(result, motions_[i].T_camera_rack);
      last.time = motions_[i].time;
    }
    return last;
  }

  const WrongStartSettings& settings_;
  std::mt19937_64 engine_;
  geometry::Camera camera_;
  std::vector<CameraMotion> motions_;
  std::vector<std::vector<std::uint8_t>> images_;
};

}  // namespace

WrongStartScore& WrongStartScore::operator+=(const WrongStartScore& other) noexcept {
  trials += other.trials;
  converged += other.converged;
  lost += other.lost;
  admitted_wrong += other.admitted_wrong;
  silent_wrong += other.silent_wrong;
  return *this;
}

std::vector<WrongStartTrial> try_wrong_starts(const WrongStartSettings& settings,
                                              std::size_t trials, std::uint64_t seed) {
  Place place(settings, seed);
  std::vector<WrongStartTrial> results;
  for (std::size_t i = 0; i < trials; ++i) {
    results.push_back(place.first_pose());
    results.push_back(place.prediction());
  }
  return results;
}

WrongStartScore score_wrong_starts(std::span<const WrongStartTrial> trials) noexcept {
  const double pose_99 = statistics::chi_square_quantile(0.99, 6);
  WrongStartScore score;
  for (const WrongStartTrial& trial : trials) {
    ++score.trials;
    if (!trial.last.has_pose) {
      ++score.lost;
    } else if (is_wrong(trial.last)) {
      // Written so that NaN is silent.
      ++(trial.last.pose_nees <= pose_99 ? score.admitted_wrong : score.silent_wrong);
    } else {
      ++score.converged;
    }
  }
  return score;
}

}  // namespace pipescout::rack_study
