// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "drawn_rack.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"

namespace pipescout::rack_vision {
namespace {

using test::DrawnImage;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kFlown = 6;

geometry::SE3 flight(int k) {
  return test::drawn_pose(0.78 + 0.010 * k, 4.0 + 0.016 * k, 2.8 - 0.004 * k, 0.10 + 0.003 * k);
}

geometry::Matrix6d spread(double place, double turn) {
  geometry::Vector6d variances;
  variances << Eigen::Vector3d::Constant(place * place), Eigen::Vector3d::Constant(turn * turn);
  return variances.asDiagonal();
}

/// A few images of a flight, then what a camera may send besides.
const std::vector<DrawnImage>& images() {
  static const std::vector<DrawnImage> all = [] {
    std::vector<DrawnImage> made;
    const RackModel model = test::drawn_rack();
    const geometry::Camera camera = test::drawn_camera();
    for (int k = 0; k < kFlown; ++k) {
      made.push_back(test::draw(model, camera, flight(k)));
    }
    made.push_back(test::draw(model, camera, test::drawn_pose(1.5, 4.0, 1.9, 1.2)));
    std::mt19937_64 engine(7);
    DrawnImage noise = made.front();
    std::ranges::generate(noise.pixels, [&] { return static_cast<std::uint8_t>(engine() & 255U); });
    made.push_back(noise);
    DrawnImage faint = made.front();
    std::ranges::for_each(faint.pixels, [&](std::uint8_t& grey) {
      grey = static_cast<std::uint8_t>(grey / 16 + engine() % 8);
    });
    made.push_back(faint);
    std::ranges::fill(noise.pixels, std::uint8_t{0});
    made.push_back(noise);
    return made;
  }();
  return all;
}

int draw_index(int below) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, below));
}

double draw_from(std::initializer_list<double> values) {
  return *(values.begin() + draw_index(static_cast<int>(values.size())));
}

const DrawnImage& draw_image() {
  return images()[static_cast<std::size_t>(draw_index(static_cast<int>(images().size())))];
}

geometry::Matrix6d draw_covariance() {
  geometry::Matrix6d covariance =
      spread(draw_from({0.001, 0.01, 0.05, 0.5, 50}), draw_from({0.0005, 0.005, 0.05, 0.5, 5}));
  switch (draw_index(8)) {
    case 0:
      return -covariance;
    case 1:
      covariance(draw_index(6), draw_index(6)) = draw_from({kNan, kInfinity, -kInfinity});
      return covariance;
    case 2:
      covariance.setZero();
      return covariance;
    case 3:
      covariance(0, 1) = 100;  // not symmetric
      return covariance;
    default:
      return covariance;
  }
}

std::optional<MotionPrediction> draw_motion() {
  if (draw_index(3) == 0) {
    return std::nullopt;
  }
  geometry::Vector6d step;
  std::ranges::generate(step, [] { return draw_from({0, 0.004, -0.01, 0.02, 0.3}); });
  return MotionPrediction{geometry::SE3::exp(step), draw_covariance()};
}

std::uint64_t refused(const RackTrackerCounts& counts) {
  return counts.wrong_size + counts.frozen + counts.without_contrast + counts.bad_stamps;
}

void check(const RackTrackerResult& result, bool intrinsics) {
  RC_ASSERT(result.offsets.size() == 4U);
  RC_ASSERT(result.offset_variances.size() == 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    RC_ASSERT(std::isfinite(result.offsets[i]));
    RC_ASSERT(result.offset_variances[i] >= 0 && std::isfinite(result.offset_variances[i]));
  }
  RC_ASSERT(result.quality >= 0 && result.quality <= 1);
  RC_ASSERT(result.inlier_share >= 0 && result.inlier_share <= 1);
  RC_ASSERT(result.edge_samples_found >= 0 && result.edge_samples_found <= result.edge_samples);
  RC_ASSERT(result.points_matched >= 0 && result.points_matched <= result.points);
  RC_ASSERT(result.points <= 60);
  RC_ASSERT(result.reason.empty() == (result.status == TrackStatus::kTracking));
  RC_ASSERT(result.intrinsics.has_value() == intrinsics);
  if (intrinsics) {
    RC_ASSERT(result.intrinsics->mean.allFinite());
    RC_ASSERT(result.intrinsics->covariance.llt().info() == Eigen::Success);
  }
  if (result.status == TrackStatus::kTracking || result.status == TrackStatus::kCoasting) {
    RC_ASSERT(result.T_rack_camera.matrix().allFinite());
    RC_ASSERT(result.covariance.allFinite());
    RC_ASSERT((result.covariance - result.covariance.transpose()).cwiseAbs().maxCoeff() <=
              1e-9 * result.covariance.cwiseAbs().maxCoeff());
    RC_ASSERT(result.covariance.llt().info() == Eigen::Success);
  }
}

RC_GTEST_PROP(RackTrackerProperty, WhateverComesItThrowsNothingAndItsResultsAreSound, ()) {
  RackTrackerParameters parameters;
  parameters.estimate_intrinsics = draw_index(2) == 1;
  RackTracker tracker(test::drawn_rack(), test::drawn_camera(), parameters);
  double stamp = 0;
  std::uint64_t refused_results = 0;
  constexpr int kImages = 12;
  for (int i = 0; i < kImages; ++i) {
    if (i == 0 || draw_index(6) == 0) {
      const geometry::Matrix6d covariance = i == 0 ? spread(0.01, 0.005) : draw_covariance();
      const bool is_one = covariance.allFinite() && covariance.isApprox(covariance.transpose()) &&
                          covariance.llt().info() == Eigen::Success;
      RC_ASSERT(tracker.set_pose(flight(draw_index(kFlown)), covariance) == is_one);
    }
    const double step =
        draw_from({0.04, 0.04, 0.04, 0.04, 0.2, 0, -0.04, 0.49, 30, kNan, kInfinity});
    const bool bad = !std::isfinite(step);
    const DrawnImage& image =
        draw_index(3) > 0 ? images()[static_cast<std::size_t>(i % kFlown)] : draw_image();
    ImageView view = image.view();
    if (draw_index(15) == 0) {
      view.height = draw_index(240);
    }
    const RackTrackerResult result = tracker.track(view, stamp + step, draw_motion());
    check(result, parameters.estimate_intrinsics);
    RC_ASSERT(!bad || result.status == TrackStatus::kBadStamp);
    const bool refused_now =
        result.status == TrackStatus::kBadImage || result.status == TrackStatus::kBadStamp;
    refused_results += refused_now ? 1 : 0;
    stamp += result.status == TrackStatus::kBadStamp ? 0 : step;
    RC_ASSERT(tracker.counts().images == static_cast<std::uint64_t>(i + 1));
    RC_ASSERT(refused(tracker.counts()) == refused_results);
    RC_ASSERT(tracker.counts().bad_predictions <= tracker.counts().images);
    RC_ASSERT(tracker.counts().losses <= tracker.counts().images);
  }
}

RC_GTEST_PROP(RackTrackerProperty, AfterAResetItIsAsNew, ()) {
  RackTracker tracker(test::drawn_rack(), test::drawn_camera());
  const int before = draw_index(5);
  for (int i = 0; i < before; ++i) {
    if (draw_index(2) == 0) {
      (void)tracker.set_pose(flight(i), spread(0.01, 0.005));
    }
    (void)tracker.track(draw_image().view(), 0.04 * i, draw_motion());
  }
  tracker.reset();
  RackTracker fresh(test::drawn_rack(), test::drawn_camera());
  RC_ASSERT(tracker.set_pose(flight(0), spread(0.01, 0.005)));
  RC_ASSERT(fresh.set_pose(flight(0), spread(0.01, 0.005)));
  for (int k = 0; k < 3; ++k) {
    const ImageView view = images()[static_cast<std::size_t>(k)].view();
    const RackTrackerResult result = tracker.track(view, 2 + 0.04 * k);
    const RackTrackerResult expected = fresh.track(view, 2 + 0.04 * k);
    RC_ASSERT(result.status == TrackStatus::kTracking);
    RC_ASSERT(expected.status == TrackStatus::kTracking);
    RC_ASSERT(result.T_rack_camera.matrix() == expected.T_rack_camera.matrix());
    RC_ASSERT(result.covariance == expected.covariance);
    RC_ASSERT(result.map_points == expected.map_points);
    RC_ASSERT(std::ranges::equal(result.offset_observed, expected.offset_observed));
  }
}

}  // namespace
}  // namespace pipescout::rack_vision
