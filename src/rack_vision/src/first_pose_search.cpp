// SPDX-License-Identifier: Apache-2.0
#include "first_pose_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "first_pose_along.hpp"
#include "first_pose_chance.hpp"
#include "first_pose_evidence.hpp"
#include "first_pose_resection.hpp"
#include "pipescout/rack_vision/contour.hpp"

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

constexpr std::size_t kPencils = 2;         // one may be that of the supports
constexpr std::size_t kResections = 16;     // of each pencil and direction, that are rendered
constexpr std::size_t kRefined = 12;        // of all, that are refined
constexpr std::size_t kTypicalPlaces = 8;   // along the flow, at which all are rendered
constexpr std::size_t kVotedPlaces = 3;     // by edges across the flow, at the same time
constexpr std::size_t kPlaces = 8;          // along the flow, of one pose
constexpr double kGate = 4;                 // standard deviations of a hint
constexpr double kProposalTolerance = 4;    // of FirstPoseParameters::pixel_tolerance
constexpr double kSmallestTransverse = 80;  // pixels of edges that show the place along the flow
constexpr double kClearlyBetter = 1.02;
constexpr double kWeakShare = 0.5;         // of the best value: edges across cannot make up
constexpr double kTransverseShare = 0.35;  // of the visible ones
constexpr double kPlaceMargin = 0.3;       // of these pixels, over any other place
constexpr double kKeptContours = 0.97;     // along the flow, where they are seen
constexpr double kSamePlace = 0.03;        // m
constexpr double kSameRotation = 0.02;     // rad

/// A pose on its way to being a candidate.
struct Hypothesis {
  SE3 T_camera_rack;
  double y = 0;
  double y_deviation = 0;
  bool along_from_image = false;
  std::size_t lines = 0;  ///< of the pencil that it comes from
  Evidence evidence;
};

double wrapped(double angle) {
  return std::remainder(angle, 2 * std::numbers::pi);
}

/// The search in one image.
class Search {
 public:
  Search(const FirstPoseParameters& parameters, const RackOutline& rack,
         const geometry::Camera& camera, const FirstPoseHint& hint,
         std::span<const SegmentPlane> planes)
      : parameters_(parameters),
        rack_(rack),
        camera_(camera),
        hint_(hint),
        planes_(planes),
        circles_(pipe_circles(rack)),
        evidence_(rack, camera, planes) {}

  FirstPose run() {
    FirstPose result;
    std::vector<Hypothesis> hypotheses;
    for (const Pencil& pencil : find_pencils(planes_, camera_, parameters_.largest_tilt,
                                             0.75 * parameters_.pixel_tolerance, kPencils)) {
      result.pencil_lines = std::max(result.pencil_lines, pencil.lines.size());
      for (const double sign : {1.0, -1.0}) {
        propose(pencil, sign, hypotheses);
      }
    }
    keep_best(hypotheses, kRefined);
    std::vector<Hypothesis> refined;
    for (Hypothesis& hypothesis : hypotheses) {
      if (refine(hypothesis)) {
        refined.push_back(std::move(hypothesis));
      }
    }
    keep_distinct(refined);
    for (Hypothesis& hypothesis : refined) {
      find_along(hypothesis);
    }
    std::ranges::stable_sort(refined, std::greater<>{},
                             [](const Hypothesis& h) { return h.evidence.total_value(); });
    conclude(refined, result);
    return result;
  }

 private:
  [[nodiscard]] ResectionLimits limits() const {
    ResectionLimits limits;
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

  /// Where the pipes look different enough to be tried apart: at the hint, between the places at
  /// which one begins, ends or changes, and next to the ends, which leave half of the image empty.
  [[nodiscard]] std::vector<double> typical_places() const {
    constexpr double kNextToEnd = 0.7;  // m
    const auto [low, high] = range_along();
    if (high < low) {
      return {hint_.y->value};
    }
    std::vector<double> borders{low, high};
    for (std::size_t i = 0; i < rack_.sections.size(); ++i) {
      for (const PipeSection& section : rack_.sections[i]) {
        for (const double along : {0.0, section.length}) {
          const double y = section.start.y() + along * section.direction.y();
          if (rack_.along_flow[i] && y > low && y < high) {
            borders.push_back(y);
          }
        }
      }
    }
    std::ranges::sort(borders);
    std::vector<double> wanted;
    if (hint_.y) {
      wanted.push_back(std::clamp(hint_.y->value, low, high));
    }
    for (std::size_t i = 1; i < borders.size(); ++i) {
      wanted.push_back(0.5 * (borders[i] + borders[i - 1]));
    }
    wanted.insert(wanted.end(), {low, high, low + kNextToEnd, high - kNextToEnd});
    std::vector<double> places;
    for (const double y : wanted) {
      const bool known = std::ranges::any_of(
          places, [&](double other) { return std::abs(other - y) < 0.5 * kNextToEnd; });
      if (!known && y >= low && y <= high && places.size() < kTypicalPlaces) {
        places.push_back(y);
      }
    }
    return places;
  }

  [[nodiscard]] bool heading_fits(const SO3& R_camera_rack) const {
    if (!hint_.heading) {
      return true;
    }
    const Vector3d right = R_camera_rack.inverse() * Vector3d::UnitX();
    const double off = wrapped(std::atan2(right.y(), right.x()) - hint_.heading->value);
    return std::abs(off) <= kGate * hint_.heading->standard_deviation;
  }

  void propose(const Pencil& pencil, double sign, std::vector<Hypothesis>& hypotheses) {
    const SO3 R_nominal = nominal_rotation(sign * pencil.direction);
    const double tolerance = kProposalTolerance * parameters_.pixel_tolerance;
    const double deviation = hint_.y ? hint_.y->standard_deviation : parameters_.unknown_along;
    const std::vector<double> typical = typical_places();
    const auto [low, high] = range_along();
    for (const Resection& r : resections(pencil.lines, R_nominal, circles_, camera_, limits(),
                                         tolerance, parameters_.largest_lines, kResections)) {
      const SO3 R = R_nominal * SO3::about_y(r.roll);
      if (!heading_fits(R)) {
        continue;
      }
      Hypothesis best;
      double best_value = 0;
      std::vector<double> places = typical;
      const SE3 anywhere(R, -(R * Vector3d(r.x, 0, r.z)));
      for (const double y :
           places_along(anywhere, planes_, rack_, camera_, tolerance, low, high, kVotedPlaces)) {
        places.push_back(y);
      }
      for (const double y : places) {
        const SE3 T = at_place(anywhere, y);
        Evidence evidence = evidence_.find(T, tolerance);
        // The first, which is the hint, unless another is clearly better.
        if (evidence.value() > kClearlyBetter * best_value) {
          best_value = evidence.value();
          best = {T, y, deviation, false, pencil.lines.size(), std::move(evidence)};
        }
      }
      if (best_value > 0) {
        hypotheses.push_back(std::move(best));
      }
    }
  }

  static void keep_best(std::vector<Hypothesis>& hypotheses, std::size_t most) {
    std::ranges::stable_sort(hypotheses, std::greater<>{},
                             [](const Hypothesis& h) { return h.evidence.value(); });
    hypotheses.resize(std::min(hypotheses.size(), most));
  }

  /// Without those that became the same as a better one, or are far from being a rival.
  void keep_distinct(std::vector<Hypothesis>& hypotheses) const {
    std::ranges::stable_sort(hypotheses, std::greater<>{},
                             [](const Hypothesis& h) { return h.evidence.value(); });
    std::vector<Hypothesis> kept;
    for (Hypothesis& hypothesis : hypotheses) {
      const bool known = std::ranges::any_of(kept, [&](const Hypothesis& other) {
        return same_across(other.T_camera_rack, hypothesis.T_camera_rack);
      });
      const bool weak =
          !kept.empty() && hypothesis.evidence.value() < kWeakShare * kept.front().evidence.value();
      if (!known && !weak) {
        kept.push_back(std::move(hypothesis));
      }
    }
    hypotheses = std::move(kept);
  }

  /// Least squares and new matches in turn, with a tolerance that narrows.
  bool refine(Hypothesis& hypothesis) {
    for (const double widening : {2.0, 1.0, 1.0}) {
      const auto fit = evidence_.fit(
          hypothesis.T_camera_rack, hypothesis.evidence.matches, hypothesis.along_from_image,
          {hypothesis.y, hypothesis.y_deviation}, parameters_.segment_sigma);
      if (!fit) {
        return false;
      }
      hypothesis.T_camera_rack = fit->T_camera_rack;
      hypothesis.evidence =
          evidence_.find(hypothesis.T_camera_rack, widening * parameters_.pixel_tolerance);
    }
    return true;
  }

  /// Looks for the place along the flow in the edges across it. It is taken when they are worth
  /// more there than at any other place, and no contour along the flow is lost for it.
  void find_along(Hypothesis& hypothesis) {
    const auto [low, high] = range_along();
    std::vector<Hypothesis> there;
    for (const double y : places_along(hypothesis.T_camera_rack, planes_, rack_, camera_,
                                       parameters_.pixel_tolerance, low, high, kPlaces)) {
      Hypothesis at = hypothesis;
      at.T_camera_rack = at_place(hypothesis.T_camera_rack, y);
      at.y = y;
      at.along_from_image = true;
      at.evidence =
          evidence_.find(at.T_camera_rack, kProposalTolerance * parameters_.pixel_tolerance);
      Hypothesis fitted = at;
      // One that cannot be refined still is a rival.
      there.push_back(refine(fitted) ? std::move(fitted) : std::move(at));
    }
    std::ranges::stable_sort(there, std::greater<>{},
                             [](const Hypothesis& h) { return h.evidence.total_value(); });
    if (there.empty() || !shows_place(there.front().evidence) ||
        there.front().evidence.value() < kKeptContours * hypothesis.evidence.value()) {
      return;
    }
    const double best = there.front().evidence.total_value();
    const double margin = kPlaceMargin * there.front().evidence.transverse_covered;
    const double y = place_of(there.front());
    const bool rivals = std::ranges::any_of(there, [&](const Hypothesis& other) {
      return std::abs(place_of(other) - y) > kSamePlace &&
             other.evidence.total_value() > best - margin;
    });
    if (!rivals) {
      hypothesis = std::move(there.front());
    }
  }

  [[nodiscard]] static double place_of(const Hypothesis& hypothesis) {
    return hypothesis.T_camera_rack.inverse().translation().y();
  }

  /// Whether enough edges across the flow, and not one alone, are where they should be.
  [[nodiscard]] static bool shows_place(const Evidence& evidence) {
    std::vector<EdgeId> edges;
    for (const EdgeMatch& match : evidence.matches) {
      if (!match.along_flow && std::ranges::find(edges, match.id) == edges.end()) {
        edges.push_back(match.id);
      }
    }
    return edges.size() >= 2 && evidence.transverse_covered >= kSmallestTransverse &&
           evidence.transverse_covered >= kTransverseShare * evidence.transverse_predicted;
  }

  /// Takes the distinct ones, best first, while they are rivals of the best.
  void conclude(std::span<const Hypothesis> hypotheses, FirstPose& result) const {
    double best_value = 0;
    for (const Hypothesis& hypothesis : hypotheses) {
      const double value = hypothesis.evidence.total_value();
      if (result.candidates.size() == kMaxFirstPoseCandidates ||
          value < parameters_.rival_share * best_value) {
        break;
      }
      const auto candidate = explained(hypothesis);
      // What a better pose that is not believed leaves behind is not to be believed either.
      if (!candidate && result.candidates.empty()) {
        break;
      }
      const bool known =
          candidate && std::ranges::any_of(result.candidates, [&](const FirstPoseCandidate& other) {
            return same_across(other.T_camera_rack, candidate->T_camera_rack);
          });
      if (candidate && !known) {
        best_value = std::max(best_value, value);
        result.candidates.push_back(*candidate);
      }
    }
    if (!result.candidates.empty()) {
      result.status =
          result.candidates.size() == 1 ? FirstPoseStatus::kFound : FirstPoseStatus::kAmbiguous;
    }
  }

  /// Nothing when the pose explains too little.
  [[nodiscard]] std::optional<FirstPoseCandidate> explained(const Hypothesis& hypothesis) const {
    const Evidence& evidence = hypothesis.evidence;
    if (evidence.contours < parameters_.smallest_matches || evidence.pipes < 2 ||
        evidence.share() < parameters_.smallest_score) {
      return std::nullopt;
    }
    const auto fit =
        evidence_.fit(hypothesis.T_camera_rack, evidence.matches, hypothesis.along_from_image,
                      {hypothesis.y, hypothesis.y_deviation}, parameters_.segment_sigma);
    if (!fit || !heading_fits(fit->T_camera_rack.rotation()) ||
        false_alarms(evidence, hypothesis.lines, circles_.back().rank + 1, fit->rms, camera_) >
            parameters_.largest_false_alarms) {
      return std::nullopt;
    }
    const Vector3d centre = fit->T_camera_rack.inverse().translation();
    geometry::Matrix6d to_tangent;
    for (Eigen::Index i = 0; i < 6; ++i) {
      to_tangent.col(i) = rack_motion(centre, geometry::Vector6d::Unit(i));
    }
    const geometry::Matrix6d covariance =
        fit->inflation * fit->information.ldlt().solve(geometry::Matrix6d::Identity());
    return FirstPoseCandidate{.T_camera_rack = fit->T_camera_rack,
                              .covariance = to_tangent * covariance * to_tangent.transpose(),
                              .score = evidence.share(),
                              .matches = evidence.contours,
                              .along_from_image = hypothesis.along_from_image};
  }

  [[nodiscard]] static bool same_across(const SE3& a, const SE3& b) {
    const Vector3d apart = a.inverse().translation() - b.inverse().translation();
    return std::abs(apart.x()) < kSamePlace && std::abs(apart.z()) < kSamePlace &&
           (a.rotation() * b.rotation().inverse()).log().norm() < kSameRotation;
  }

  const FirstPoseParameters& parameters_;
  const RackOutline& rack_;
  const geometry::Camera& camera_;
  const FirstPoseHint& hint_;
  std::span<const SegmentPlane> planes_;
  std::vector<PipeCircle> circles_;
  EvidenceFinder evidence_;
};

}  // namespace

FirstPose search_first_pose(const FirstPoseParameters& parameters, const RackOutline& rack,
                            const geometry::Camera& camera, const FirstPoseHint& hint,
                            std::span<const SegmentPlane> planes) {
  return Search(parameters, rack, camera, hint, planes).run();
}

}  // namespace pipescout::rack_vision::internal
