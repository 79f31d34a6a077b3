// SPDX-License-Identifier: Apache-2.0
#include "first_pose_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "first_pose_across.hpp"
#include "first_pose_along.hpp"
#include "first_pose_evidence.hpp"
#include "first_pose_pencil.hpp"
#include "first_pose_profile.hpp"
#include "first_pose_refinement.hpp"
#include "first_pose_segments.hpp"
#include "first_pose_slopes.hpp"
#include "pipescout/rack_vision/contour.hpp"

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

constexpr std::size_t kPencils = 2;                 // one may be that of the supports
constexpr std::size_t kAcross = 200;                // poses across the flow, of each direction
constexpr std::size_t kTried = 250;                 // of all, that are refined once
constexpr std::size_t kRefined = 12;                // distinct ones, that are refined on all edges
constexpr std::size_t kVotedPlaces = 8;             // along the flow, of each
constexpr std::size_t kPlaces = 3;                  // of these, at which it is refined
constexpr double kGate = 3.5;                       // standard deviations of a hint
constexpr double kTiltMargin = 0.2;                 // rad, of a heading before the roll is known
constexpr double kPencilTolerance = 1.5;            // pixels
constexpr double kVoteTolerance = 6;                // pixels
constexpr double kFixed = 1e-3;                     // m, along the flow
constexpr double kRefinedAlong = 0.3;               // m
constexpr std::array<double, 1> kFirstRanges{8};    // pixels, of a refinement
constexpr std::array<double, 2> kLastRanges{6, 4};  // pixels
constexpr int kPlaceReach = 3;                      // pixels
constexpr int kFinalReach = 2;                      // pixels
constexpr double kPlaceMargin = 2;                  // nats of a place along the flow over any other
constexpr double kSameAlong = 0.1;                  // m
constexpr double kSamePlace = 0.03;                 // m
constexpr double kSameRotation = 0.02;              // rad

/// The image seen along one direction of the flow.
struct FlowView {
  SO3 R_nominal;
  LineProfile profile;
};

/// A pose on its way to being a candidate.
struct Hypothesis {
  SE3 T_camera_rack;
  bool along_from_image = false;
  Evidence evidence;
  std::size_t view = 0;  ///< index of the profile that it comes from
  std::optional<RefinedPose> refined{};
  double on_pipes = 0;  ///< nats
  double value = 0;     ///< nats: evidence and what the hint says
};

double wrapped(double angle) {
  return std::remainder(angle, 2 * std::numbers::pi);
}

/// Of the optical axis against straight down.
double tilt_of(const SO3& R_camera_rack) {
  return std::acos(std::clamp(-R_camera_rack.matrix()(2, 2), -1.0, 1.0));
}

double heading_of(const SO3& R_camera_rack) {
  const Vector3d right = R_camera_rack.inverse() * Vector3d::UnitX();
  return std::atan2(right.y(), right.x());
}

void sort_best_first(std::vector<Hypothesis>& hypotheses) {
  std::ranges::stable_sort(hypotheses, std::greater<>{}, &Hypothesis::value);
}

/// How the camera's place moves with mu of equation (5).
Eigen::Matrix<double, 3, 6> motion_of_centre(const SE3& T_camera_rack) {
  Eigen::Matrix<double, 3, 6> motion;
  motion << -Eigen::Matrix3d::Identity(), geometry::skew(T_camera_rack.inverse().translation());
  return motion;
}

/// Of the camera's place in x and z, the larger one.
double deviation_across(const FirstPoseCandidate& candidate) {
  const auto motion = motion_of_centre(candidate.T_camera_rack);
  const Eigen::Matrix3d covariance = motion * candidate.covariance * motion.transpose();
  return std::sqrt(std::max(covariance(0, 0), covariance(2, 2)));
}

/// With the camera's y known this well and from elsewhere, whatever was known
/// of it.
geometry::Matrix6d with_place(const RefinedPose& pose, double deviation) {
  // In terms of the camera's own place and rotation, y stands alone.
  geometry::Matrix6d to_camera = -geometry::Matrix6d::Identity();
  to_camera.topRows<3>() = motion_of_centre(pose.T_camera_rack);
  geometry::Matrix6d covariance = to_camera * pose.covariance * to_camera.transpose();
  covariance.row(1).setZero();
  covariance.col(1).setZero();
  covariance(1, 1) = deviation * deviation;
  geometry::Matrix6d back = to_camera;
  back.topRightCorner<3, 3>() *= -1;
  return back * covariance * back.transpose();
}

bool same_across(const SE3& a, const SE3& b) {
  const Vector3d apart = a.inverse().translation() - b.inverse().translation();
  return std::abs(apart.x()) < kSamePlace && std::abs(apart.z()) < kSamePlace &&
         (a.rotation() * b.rotation().inverse()).log().norm() < kSameRotation;
}

/// Best first, at most `most`, without those that are the same as a better one.
void keep_distinct(std::vector<Hypothesis>& hypotheses, std::size_t most) {
  sort_best_first(hypotheses);
  std::vector<Hypothesis> kept;
  for (Hypothesis& hypothesis : hypotheses) {
    const bool known = std::ranges::any_of(kept, [&](const Hypothesis& other) {
      return same_across(other.T_camera_rack, hypothesis.T_camera_rack);
    });
    if (!known && kept.size() < most) {
      kept.push_back(std::move(hypothesis));
    }
  }
  hypotheses = std::move(kept);
}

/// The search in one image.
class Search {
 public:
  Search(const FirstPoseParameters& parameters, const RackOutline& rack, const ImageView& image,
         const geometry::Camera& camera, const FirstPoseHint& hint,
         std::span<const SegmentPlane> planes)
      : parameters_(parameters),
        rack_(rack),
        image_(image),
        camera_(camera),
        hint_(hint),
        planes_(planes),
        circles_(pipe_circles(rack)),
        slopes_(image, camera),
        evidence_(rack, camera, slopes_),
        refinement_(rack, camera, parameters.edge_sigma) {}

  FirstPose run() {
    std::vector<Hypothesis> hypotheses;
    for (const Vector3d& direction :
         find_pencils(planes_, camera_, parameters_.largest_tilt, kPencilTolerance, kPencils)) {
      for (const double sign : {1.0, -1.0}) {
        propose(sign * direction, hypotheses);
      }
    }
    sort_best_first(hypotheses);
    hypotheses.resize(std::min(hypotheses.size(), kTried));
    std::erase_if(hypotheses, [&](Hypothesis& hypothesis) {
      return !refine(hypothesis, PoseRefinement::Edges::kAlongFlow, kFirstRanges);
    });
    keep_distinct(hypotheses, kRefined);
    std::erase_if(hypotheses, [&](Hypothesis& hypothesis) { return !find_along(hypothesis); });
    keep_distinct(hypotheses, kMaxFirstPoseCandidates);
    return conclude(hypotheses);
  }

 private:
  [[nodiscard]] AcrossLimits limits() const {
    AcrossLimits limits;
    double highest = std::numeric_limits<double>::lowest();
    limits.x_low = std::numeric_limits<double>::max();
    limits.x_high = std::numeric_limits<double>::lowest();
    for (const PipeCircle& circle : circles_) {
      highest = std::max(highest, circle.centre.y());
      limits.x_low = std::min(limits.x_low, circle.centre.x() - parameters_.largest_beside);
      limits.x_high = std::max(limits.x_high, circle.centre.x() + parameters_.largest_beside);
    }
    limits.z_low = highest + parameters_.smallest_height;
    limits.z_high = highest + parameters_.largest_height;
    limits.largest_roll = parameters_.largest_tilt;
    limits.typical_roll = parameters_.typical_tilt;
    const auto gate = [](const std::optional<FirstPoseHint::Value>& known, double& low,
                         double& high) {
      if (known) {
        low = std::max(low, known->value - kGate * known->standard_deviation);
        high = std::min(high, known->value + kGate * known->standard_deviation);
      }
    };
    gate(hint_.x, limits.x_low, limits.x_high);
    gate(hint_.z, limits.z_low, limits.z_high);
    return limits;
  }

  /// Along the flow, where pipes are.
  [[nodiscard]] std::pair<double, double> range_along() const {
    double low = rack_.start;
    double high = rack_.end;
    if (hint_.y) {
      low = std::max(low, hint_.y->value - kGate * hint_.y->standard_deviation);
      high = std::min(high, hint_.y->value + kGate * hint_.y->standard_deviation);
    }
    return {low, high};
  }

  /// Where the camera is put along the flow before the image is asked.
  [[nodiscard]] double likely_place() const {
    const double middle = 0.5 * (rack_.start + rack_.end);
    return hint_.y ? std::clamp(hint_.y->value, rack_.start, rack_.end) : middle;
  }

  /// `margin`: rad, beyond the gate.
  [[nodiscard]] bool heading_fits(const SO3& R_camera_rack, double margin) const {
    return !hint_.heading || std::abs(wrapped(heading_of(R_camera_rack) - hint_.heading->value)) <=
                                 kGate * hint_.heading->standard_deviation + margin;
  }

  /// `all_edges`: otherwise those across the flow do not count.
  void judge(Hypothesis& hypothesis, int reach, bool all_edges) {
    const SE3& T = hypothesis.T_camera_rack;
    const FlowView& view = views_[hypothesis.view];
    hypothesis.evidence = evidence_.find(T, reach, view.profile.line_share());
    const Vector3d centre = T.inverse().translation();
    const double roll = (view.R_nominal.inverse() * T.rotation()).log().y();
    hypothesis.on_pipes =
        evidence_on_pipes(view.profile, circles_, {centre.x(), centre.z(), roll, 0});
    hypothesis.value = hypothesis.evidence.along + hypothesis.on_pipes +
                       (all_edges ? hypothesis.evidence.transverse : 0.0) + log_prior_of(T);
  }

  [[nodiscard]] double log_prior_of(const SE3& T_camera_rack) const {
    const Vector3d centre = T_camera_rack.inverse().translation();
    const double tilt = tilt_of(T_camera_rack.rotation()) / parameters_.typical_tilt;
    double sum = log_prior(hint_.x, centre.x()) + log_prior(hint_.y, centre.y()) +
                 log_prior(hint_.z, centre.z()) - 0.5 * tilt * tilt;
    if (hint_.heading) {
      const double off = wrapped(heading_of(T_camera_rack.rotation()) - hint_.heading->value);
      sum += log_prior(hint_.heading, hint_.heading->value + off);
    }
    return sum;
  }

  void propose(const Vector3d& flow, std::vector<Hypothesis>& hypotheses) {
    const SO3 R_nominal = nominal_rotation(flow);
    if (!heading_fits(R_nominal, kTiltMargin)) {
      return;
    }
    views_.push_back({R_nominal, LineProfile(slopes_, camera_, R_nominal)});
    for (const AcrossPose& across :
         search_across(views_.back().profile, circles_, camera_, limits(), hint_, kAcross)) {
      const SO3 R = R_nominal * SO3::about_y(across.roll);
      if (heading_fits(R, 0) && tilt_of(R) <= parameters_.largest_tilt) {
        const SE3 T(R, -(R * Vector3d(across.x, likely_place(), across.z)));
        Hypothesis& proposed = hypotheses.emplace_back();
        proposed.T_camera_rack = T;
        proposed.view = views_.size() - 1;
        proposed.value = across.value;
      }
    }
  }

  /// Least squares and new samples in turn, within a range that narrows.
  bool refine(Hypothesis& hypothesis, PoseRefinement::Edges edges, std::span<const double> ranges) {
    const bool all = edges == PoseRefinement::Edges::kAll;
    hypothesis.refined = refinement_.refine(image_, hypothesis.T_camera_rack,
                                            all ? kRefinedAlong : kFixed, edges, ranges);
    if (hypothesis.refined) {
      hypothesis.T_camera_rack = hypothesis.refined->T_camera_rack;
      judge(hypothesis, kFinalReach, all);
    }
    return hypothesis.refined.has_value();
  }

  /// Looks for the place along the flow in the edges across it. The image tells
  /// it when they are clearly better explained there than at any other place.
  bool find_along(Hypothesis& hypothesis) {
    const auto [low, high] = range_along();
    std::vector<Hypothesis> there{hypothesis};
    judge(there.front(), kPlaceReach, true);
    for (const double y : places_along(hypothesis.T_camera_rack, planes_, rack_, camera_,
                                       kVoteTolerance, low, high, kVotedPlaces)) {
      Hypothesis& at = there.emplace_back(hypothesis);
      at.T_camera_rack = at_place(hypothesis.T_camera_rack, y);
      judge(at, kPlaceReach, true);
    }
    sort_best_first(there);
    double rival = std::numeric_limits<double>::lowest();
    for (const Hypothesis& other : there) {
      if (std::abs(place_of(other) - place_of(there.front())) > kSameAlong) {
        rival = std::max(rival, other.value);
      }
    }
    const bool clear = there.front().evidence.transverse >= kPlaceMargin &&
                       there.front().evidence.transverse_edges >= 2 &&
                       there.front().value - rival >= kPlaceMargin;
    there.resize(std::min(there.size(), kPlaces));
    std::erase_if(there, [&](Hypothesis& one) {
      return !refine(one, PoseRefinement::Edges::kAll, kFirstRanges) ||
             !refine(one, PoseRefinement::Edges::kAll, kLastRanges);
    });
    if (there.empty()) {
      return false;
    }
    sort_best_first(there);
    hypothesis = std::move(there.front());
    hypothesis.along_from_image = clear;
    return true;
  }

  [[nodiscard]] static double place_of(const Hypothesis& hypothesis) {
    return hypothesis.T_camera_rack.inverse().translation().y();
  }

  /// Takes the best and its rivals. One that explains too little to be believed
  /// is a rival all the same; when it is the best, none is believed.
  [[nodiscard]] FirstPose conclude(std::span<const Hypothesis> hypotheses) const {
    FirstPose result;
    std::size_t rivals = 0;
    for (const Hypothesis& hypothesis : hypotheses) {
      if (hypothesis.value < hypotheses.front().value - parameters_.rival_margin) {
        break;
      }
      const auto candidate = explained(hypothesis);
      if (!candidate && result.candidates.empty()) {
        break;
      }
      ++rivals;
      if (candidate) {
        result.candidates.push_back(*candidate);
      }
    }
    if (!result.candidates.empty()) {
      const bool one = rivals == 1 &&
                       deviation_across(result.candidates.front()) <= parameters_.largest_deviation;
      result.status = one ? FirstPoseStatus::kFound : FirstPoseStatus::kAmbiguous;
    }
    return result;
  }

  /// Nothing when the pose explains too little.
  [[nodiscard]] std::optional<FirstPoseCandidate> explained(const Hypothesis& hypothesis) const {
    const Evidence& evidence = hypothesis.evidence;
    const std::size_t matches = evidence.contours + evidence.transverse_edges;
    // Among many lines on the ground, all contours of three pipes are met by
    // chance: it takes a fourth pipe, or edges across the flow, which are not
    // where they should be by chance.
    const bool unlikely_by_chance =
        evidence.pipes >= 4 || (evidence.pipes >= 2 && evidence.transverse_edges >= 2);
    if (evidence.contours < 3 || matches < parameters_.smallest_matches || !unlikely_by_chance ||
        evidence.transverse < 0 || hypothesis.value < parameters_.smallest_evidence ||
        evidence.found < parameters_.smallest_score * evidence.visible ||
        !heading_fits(hypothesis.T_camera_rack.rotation(), 0)) {
      return std::nullopt;
    }
    SE3 T = hypothesis.T_camera_rack;
    geometry::Matrix6d covariance = hypothesis.refined->covariance;
    if (!hypothesis.along_from_image) {
      // Nothing but the hint says where.
      T = at_place(T, likely_place());
      covariance = with_place(*hypothesis.refined,
                              hint_.y ? hint_.y->standard_deviation : parameters_.unknown_along);
    }
    return FirstPoseCandidate{.T_camera_rack = T,
                              .covariance = covariance,
                              .score = evidence.found / evidence.visible,
                              .matches = matches,
                              .along_from_image = hypothesis.along_from_image};
  }

  const FirstPoseParameters& parameters_;
  const RackOutline& rack_;
  const ImageView& image_;
  const geometry::Camera& camera_;
  const FirstPoseHint& hint_;
  std::span<const SegmentPlane> planes_;
  std::vector<PipeCircle> circles_;
  SlopeImage slopes_;
  EvidenceFinder evidence_;
  PoseRefinement refinement_;
  std::vector<FlowView> views_;
};

}  // namespace

FirstPose search_first_pose(const FirstPoseParameters& parameters, const RackOutline& rack,
                            const ImageView& image, const geometry::Camera& camera,
                            const FirstPoseHint& hint) {
  const std::vector<SegmentPlane> planes =
      segment_planes(extract_segments(image, camera, parameters.shortest_segment), camera);
  return Search(parameters, rack, image, camera, hint, planes).run();
}

}  // namespace pipescout::rack_vision::internal
