// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/image_flight.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>

#include "pipescout/rack_study/pose_run.hpp"
#include "pipescout/rack_study/rack_bodies.hpp"
#include "pipescout/simulation/contour_clutter.hpp"
#include "pipescout/simulation/rack_image_light.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::rack_study {
namespace {

using geometry::Matrix6d;
using geometry::SE3;
using geometry::Vector6d;
using rack_vision::TrackStatus;

constexpr double kOdometryPosition = 0.005;               // m / root of s, per axis
constexpr double kOdometryRotation = 0.1 * 0.0174532925;  // rad / root of s, per axis

template <int kSize>
double squared_mahalanobis(const Eigen::Matrix<double, kSize, 1>& error,
                           const Eigen::Matrix<double, kSize, kSize>& covariance) {
  const Eigen::LLT<Eigen::Matrix<double, kSize, kSize>> factor(covariance);
  if (factor.info() != Eigen::Success || !error.allFinite()) {
    return std::numeric_limits<double>::infinity();
  }
  return factor.matrixL().solve(error).squaredNorm();
}

Matrix6d diagonal(double position_variance, double rotation_variance) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(position_variance),
      Eigen::Vector3d::Constant(rotation_variance);
  return variances.asDiagonal();
}

class Flight {
 public:
  Flight(const ImageFlightSettings& settings, std::uint64_t seed)
      : settings_(settings),
        engine_(seed),
        camera_(settings.camera),
        light_({}, engine_()),
        motions_(fly_camera(settings.way_points, settings.flight, engine_())),
        scene_(with_seed(settings.scene, engine_())),
        localization_(settings.rack_file.value_or(settings.scene.model), camera_,
                      settings.localization),
        grey_(static_cast<std::size_t>(camera_.parameters().width) *
              static_cast<std::size_t>(camera_.parameters().height)) {
    if (settings.mesh) {
      MeshScene mesh = *settings.mesh;
      mesh.model = scene_.model;
      mesh.bodies = scene_.bodies;
      mesh.people = scene_.people;
      mesh.seed = scene_.seed;
      mesh_.emplace(mesh, camera_);
      return;
    }
    renderer_.emplace(scene_, camera_, settings.sensor);
    if (scene_.clutter_share > 0 && settings.clutter_begin > 0) {
      simulation::RackScene clear = scene_;
      clear.clutter_share = 0;
      before_clutter_.emplace(clear, camera_, settings.sensor);
    }
  }

  ImageFlightRun run() {
    start();
    ImageFlightRun run;
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      run.frames.push_back(frame(i));
    }
    run.tracker = localization_.tracker().counts();
    run.localization = localization_.counts();
    run.cluttered_share = cluttered_share();
    return run;
  }

 private:
  static simulation::RackScene with_seed(simulation::RackScene scene, std::uint64_t seed) {
    scene.seed = seed;
    return scene;
  }

  Vector6d noise(double position_deviation, double rotation_deviation) {
    Vector6d value;
    value << position_deviation * statistics::normals<3>(engine_),
        rotation_deviation * statistics::normals<3>(engine_);
    return value;
  }

  void start() {
    const double position = settings_.start_position_deviation;
    const double rotation = settings_.start_rotation_deviation;
    const Vector6d error = noise(position, rotation);
    const SE3 truth = motions_.front().T_camera_rack.inverse();
    localization_.set_pose(SE3(geometry::SO3::exp(error.tail<3>()) * truth.rotation(),
                               truth.translation() + error.head<3>()),
                           diagonal(position * position, rotation * rotation));
  }

  [[nodiscard]] bool in_outage(double time) const {
    return settings_.loss && time >= settings_.loss->begin &&
           time < settings_.loss->begin + settings_.loss->duration;
  }

  FrameScore frame(std::size_t i) {
    const CameraMotion& motion = motions_[i];
    const bool outage = in_outage(motion.time);
    if (outage && settings_.loss->kind == Outage::kMissing) {
      FrameScore missing;
      missing.time = motion.time;
      missing.outage = true;
      missing.along = motion.T_camera_rack.inverse().translation().y();
      return missing;
    }
    take_image(motion, i, outage);
    const rack_vision::ImageView view{.pixels = grey_.data(),
                                      .width = camera_.parameters().width,
                                      .height = camera_.parameters().height,
                                      .stride = camera_.parameters().width};
    const auto result = localization_.track(view, motion.time, odometry(i));
    last_given_ = i;
    FrameScore score = score_frame(result, motion.T_camera_rack);
    score.time = motion.time;
    score.outage = outage;
    return score;
  }

  void take_image(const CameraMotion& motion, std::size_t i, bool outage) {
    const auto people = people_beside(scene_.model, scene_.people, motion.time);
    if (!outage && mesh_) {
      mesh_->render(motion.T_camera_rack, i, grey_, people);
    } else if (!outage) {
      simulation::RackImageRenderer& renderer =
          before_clutter_ && motion.time < settings_.clutter_begin ? *before_clutter_ : *renderer_;
      simulation::RackView view = view_of(motion, light_, i);
      view.people = people;
      renderer.render(view, grey_);
    } else if (settings_.loss->kind == Outage::kCovered) {
      constexpr double kDark = 8;     // grey level
      constexpr double kNoise = 1.5;  // grey levels
      std::generate(grey_.begin(), grey_.end(), [&] {
        return static_cast<std::uint8_t>(
            std::clamp(kDark + kNoise * statistics::normal(engine_), 0.0, 255.0));
      });
    }
  }

  [[nodiscard]] double cluttered_share() const {
    if (scene_.clutter_share <= 0) {
      return 0;
    }
    std::vector<SE3> views;
    double next = settings_.clutter_begin;
    for (const CameraMotion& motion : motions_) {
      if (motion.time >= next) {
        views.push_back(motion.T_camera_rack);
        next += 1;
      }
    }
    return simulation::cluttered_contour_share(scene_, camera_, views);
  }

  std::optional<rack_vision::MotionPrediction> odometry(std::size_t i) {
    if (!settings_.with_odometry || !last_given_) {
      return std::nullopt;
    }
    const CameraMotion& before = motions_[*last_given_];
    const CameraMotion& now = motions_[i];
    const double growth = std::sqrt(now.time - before.time);
    const double position = kOdometryPosition * growth;
    const double rotation = kOdometryRotation * growth;
    return rack_vision::MotionPrediction{
        .T_previous_current = before.T_camera_rack * now.T_camera_rack.inverse() *
                              SE3::exp(noise(position, rotation)),
        .covariance = diagonal(position * position, rotation * rotation)};
  }

  const ImageFlightSettings& settings_;
  std::mt19937_64 engine_;
  geometry::Camera camera_;
  simulation::ChangingRackLight light_;
  std::vector<CameraMotion> motions_;
  simulation::RackScene scene_;
  std::optional<simulation::RackImageRenderer> renderer_;
  std::optional<MeshRenderer> mesh_;
  std::optional<simulation::RackImageRenderer> before_clutter_;
  rack_vision::RackLocalization localization_;
  std::vector<std::uint8_t> grey_;
  std::optional<std::size_t> last_given_;
};

}  // namespace

FrameScore score_frame(const rack_vision::RackTrackerResult& result, const SE3& T_camera_rack) {
  FrameScore score;
  score.status = result.status;
  score.quality = result.quality;
  score.along = T_camera_rack.inverse().translation().y();
  score.has_pose = result.status == TrackStatus::kTracking;
  if (score.has_pose) {
    score.error = pose_error(result.T_rack_camera.inverse(), T_camera_rack);
    score.along_deviation = std::sqrt(std::max(0.0, result.covariance(1, 1)));
    score.position_nees =
        squared_mahalanobis<3>(score.error.head<3>(), result.covariance.topLeftCorner<3, 3>());
    score.pose_nees = squared_mahalanobis<6>(score.error, result.covariance);
  }
  return score;
}

ImageFlightRun run_image_flight(const ImageFlightSettings& settings, std::uint64_t seed) {
  return Flight(settings, seed).run();
}

}  // namespace pipescout::rack_study
