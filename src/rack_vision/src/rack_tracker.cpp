// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/rack_tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "image_check.hpp"
#include "intrinsics_memory.hpp"
#include "offset_memory.hpp"
#include "pipescout/linear_algebra/products.hpp"
#include "pose_belief.hpp"
#include "track_step.hpp"
#include "view_change.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;

constexpr int kLeastGreyRange = 8;  // grey levels: below it an image is black, white or fog
constexpr int kMostCoasting = 2;    // images without a pose before the track is lost
constexpr int kMostRepeated = 10;   // identical images in a row, then the camera is frozen
constexpr double kShaken = 3;       // times the usual accelerations
constexpr int kImagesPerOpinion = 10;
constexpr int kImagesPerPlacing = 5;
constexpr int kImagesPerJudgement = 5;
constexpr double kKeptOfRadii = 0.9;  // of the evidence for them, from one judgement to the next
// Pipes, over the judgements that are kept: one pipe in view may be in a bad light all the time.
constexpr double kEnoughRadii = 12;
constexpr double kLeastForRadii = 1.25;  // of a pipe, on average: by chance it is 1
constexpr double kStartQuality = 0.5;
constexpr int kProbation = 5;           // images
constexpr int kProbationOfPlaces = 25;  // where pipes may have been taken for others
constexpr int kFreshPoints = 10;        // enough of them to ask
constexpr double kLeastFreshShare = 0.2;
// What alike errors of successive images add to the covariance, measured.
constexpr double kCovarianceFactor = 2.5;
// m, of x, where places of pipes were searched and nothing has been seen that cannot have moved:
// all pipes in view may be taken for what lies as far beside them, and no image tells.
constexpr double kTakenForOthers = 0.035;
// What the first image leaves uncertain, others of its view do not tell better.
constexpr double kViewsUntilUnlike = 2;
constexpr double kAlikeAlong = 0.05 * 0.05;  // m^2: supports that come into view later tell better

}  // namespace

class RackTracker::Implementation {
 public:
  Implementation(const RackModel& model, const geometry::Camera& camera,
                 const RackTrackerParameters& parameters)
      : model_(model),
        camera_(camera),
        parameters_(parameters),
        step_(model, camera, parameters),
        offsets_(step_.model(), parameters.estimate_offsets ? parameters.offset_sigma : 0),
        intrinsics_(camera, parameters.focal_sigma, parameters.centre_sigma) {}

  bool set_pose(const geometry::SE3& T_rack_camera, const Matrix6d& covariance) {
    if (!T_rack_camera.matrix().allFinite() || !is_covariance(covariance)) {
      return false;
    }
    start_at(T_rack_camera, covariance);
    state_ = TrackStatus::kCoasting;
    starting_ = true;
    probation_ = kProbation;
    last_stamp_.reset();
    leapt_stamp_.reset();
    return true;
  }

  RackTrackerResult track(const ImageView& image, double stamp,
                          const std::optional<MotionPrediction>& motion) {
    ++counts_.images;
    RackTrackerResult result = blank();
    if (!check_stamp(stamp, result) || !check_image(image, result)) {
      return result;
    }
    if (state_ == TrackStatus::kNotStarted || state_ == TrackStatus::kLost) {
      last_stamp_ = stamp;
      result.reason = state_ == TrackStatus::kLost ? lost_reason_ : "no pose was given";
      return result;
    }
    const double dt = last_stamp_ ? stamp - *last_stamp_ : 0.0;
    last_stamp_ = stamp;
    if (dt > parameters_.longest_gap) {
      lose("no images for too long", result);
      return result;
    }
    const PoseBelief last = pose_;
    offsets_.predict(dt);
    intrinsics_.predict(dt);
    const bool measured = predict(dt, motion);
    if (repeated_ > 0 && !starting_) {
      // It was used before: drivers repeat images, and to what moved meanwhile it says nothing.
      coasted_time_ += dt;
      state_ = TrackStatus::kCoasting;
      fill(result);
      result.reason = "the image is identical to the previous one: predicted";
      return result;
    }
    const PoseBelief predicted = pose_;
    step_.look_at(image);
    find(image);
    if (!borne_out() && !find_by_other_motion(image, last, dt, measured)) {
      pose_ = predicted;
    }
    judge(image, result);
    if (state_ == TrackStatus::kTracking) {
      tracked_ = pose_;
      coasted_time_ = 0;
    } else {
      coasted_time_ += dt;
    }
    return result;
  }

  void reset() {
    step_.forget();
    pose_ = {};
    tracked_ = {};
    coasted_time_ = 0;
    outcome_ = {};
    offsets_.reset();
    step_.forget_shapes();
    intrinsics_.reset();
    step_.set_camera(camera_);
    state_ = TrackStatus::kNotStarted;
    starting_ = false;
    last_stamp_.reset();
    leapt_stamp_.reset();
    fingerprint_.reset();
    repeated_ = 0;
  }

  [[nodiscard]] const RackTrackerCounts& counts() const noexcept { return counts_; }

 private:
  void start_at(const geometry::SE3& T_rack_camera, const Matrix6d& covariance) {
    // What is known along y is the anchor; the pose itself is exact relative to what it will see.
    anchor_variance_ = covariance(1, 1);
    Matrix6d relative = covariance;
    relative.row(1).setZero();
    relative.col(1).setZero();
    relative(1, 1) = kRelativeVariance;
    pose_.restart(T_rack_camera, relative);
    tracked_ = pose_;
    coasted_time_ = 0;
    coasted_ = 0;
    since_opinion_ = 0;
  }

  bool check_stamp(double stamp, RackTrackerResult& result) {
    const bool ahead = last_stamp_ && stamp > *last_stamp_ + parameters_.longest_gap;
    const bool back = last_stamp_ && stamp < *last_stamp_ - parameters_.longest_gap;
    // One leap may be a broken stamp; a second image that follows it says that time went on, or
    // that the clock was set back.
    const bool confirmed =
        leapt_stamp_ && stamp > *leapt_stamp_ && stamp <= *leapt_stamp_ + parameters_.longest_gap;
    if (back && confirmed) {
      last_stamp_ = leapt_stamp_;
    }
    if (std::isfinite(stamp) && (!last_stamp_ || stamp > *last_stamp_) && (!ahead || confirmed)) {
      leapt_stamp_.reset();
      return true;
    }
    ++counts_.bad_stamps;
    result.status = TrackStatus::kBadStamp;
    result.reason = !std::isfinite(stamp) ? "the stamp is not finite"
                    : ahead               ? "the stamp jumps ahead"
                    : back                ? "the stamp jumps back"
                                          : "the stamp is not after the last one";
    leapt_stamp_ = ahead || back ? std::optional(stamp) : std::nullopt;
    return false;
  }

  bool check_image(const ImageView& image, RackTrackerResult& result) {
    const geometry::CameraParameters& expected = camera_.parameters();
    result.status = TrackStatus::kBadImage;
    if (!image.valid() || image.width != expected.width || image.height != expected.height) {
      ++counts_.wrong_size;
      result.reason = "the image size differs from the camera's";
      return false;
    }
    const std::uint64_t bits = fingerprint(image);
    if (fingerprint_ != bits) {
      repeated_ = 0;
    } else if (!starting_) {
      repeated_ = std::min(repeated_ + 1, kMostRepeated);
      ++(repeated_ == kMostRepeated ? counts_.frozen : counts_.repeated);
      if (repeated_ == kMostRepeated) {
        result.reason = "the last images are identical: the camera is frozen";
        return false;
      }
    }
    fingerprint_ = bits;
    if (grey_range(image) < kLeastGreyRange) {
      ++counts_.without_contrast;
      result.reason = "the image has no contrast";
      return false;
    }
    result.status = state_;
    return true;
  }

  /// Returns whether the motion was used.
  bool predict(double dt, const std::optional<MotionPrediction>& motion) {
    if (dt <= 0) {
      return false;
    }
    if (motion && motion->T_previous_current.matrix().allFinite() &&
        is_covariance(motion->covariance)) {
      // It is since the last tracked image, and images may have been predicted through since.
      pose_ = tracked_;
      pose_.predict(motion->T_previous_current, motion->covariance, dt + coasted_time_);
      return true;
    }
    counts_.bad_predictions += motion ? 1 : 0;
    pose_.predict(dt, parameters_.acceleration_sigma, parameters_.angular_acceleration_sigma);
    return false;
  }

  void find(const ImageView& image) {
    const TrackBelief before{
        pose_.pose(), pose_.covariance(), anchor_variance_,           offsets_.belief(),
        pose_.map(),  pose_.velocity(),   pose_.velocity_covariance()};
    if (starting_) {
      step_.find_from_far(image, before, outcome_);
    } else {
      step_.find(image, before, outcome_);
    }
  }

  /// From `last`, where the image does not bear out the motion that was predicted.
  bool find_by_other_motion(const ImageView& image, const PoseBelief& last, double dt,
                            bool measured) {
    const auto is_found = [&](double shaken) {
      pose_ = last;
      pose_.predict(dt, shaken * parameters_.acceleration_sigma,
                    shaken * parameters_.angular_acceleration_sigma);
      find(image);
      return borne_out();
    };
    // Odometry may be wrong, and a gust may turn the camera farther than it is searched for.
    const bool found = (measured && is_found(1)) || (!starting_ && is_found(kShaken));
    counts_.bad_predictions += measured && found ? 1 : 0;
    return found;
  }

  [[nodiscard]] double quality() const {
    return outcome_.solved ? track_quality(outcome_.evidence) : 0.0;
  }
  [[nodiscard]] bool borne_out() const {
    const TrackEvidence& evidence = outcome_.evidence;
    if (probation_ > 0 && evidence.points >= kFreshPoints &&
        evidence.points_matched < kLeastFreshShare * evidence.points) {
      return false;  // points made a moment ago are found again if anything is
    }
    return quality() >= (probation_ > 0 ? kStartQuality : parameters_.lost_below);
  }

  void judge(const ImageView& image, RackTrackerResult& result) {
    if (!borne_out()) {
      if (probation_ > 0 || ++coasted_ > kMostCoasting) {
        lose(probation_ > 0 ? "the image does not confirm the initial pose"
                            : "the image no longer confirms the pose",
             result);
      } else {
        state_ = TrackStatus::kCoasting;
        fill(result);
        result.reason = "the image does not confirm the pose: predicted";
      }
      result.quality = quality();
      return;
    }
    pose_.shift_along(outcome_.shift_along);
    pose_.update(outcome_.belief.T_rack_camera, outcome_.belief.covariance, outcome_.map_error);
    if (step_.map_points() == 0) {
      pose_.begin_map();
    }
    if (outcome_.misplaced_by > 0) {
      offsets_.widen(outcome_.misplaced_by);
    }
    if (starting_) {
      radii_ = {};
      reference_seen_ = false;
      places_searched_ = outcome_.places_searched;
      probation_ = places_searched_ ? kProbationOfPlaces : kProbation;
      covariance_at_start_ = pose_.covariance();
      covariance_at_start_(1, 1) += std::min(outcome_.belief.anchor_variance, kAlikeAlong);
    }
    reference_seen_ = reference_seen_ || outcome_.reference_found;
    anchor_variance_ = outcome_.belief.anchor_variance;
    covariance_by_edges_ = covariance_by_edges();
    const double share = share_of_view();
    offsets_.learn(outcome_.belief.offsets, outcome_.pipes, share);
    state_ = TrackStatus::kTracking;
    starting_ = false;
    probation_ = std::max(0, probation_ - 1);
    coasted_ = 0;
    if (parameters_.estimate_intrinsics) {
      learn_intrinsics();
    }
    step_.learn(image, outcome_, pose_.relative_covariance());
    if (++since_opinion_ >= kImagesPerOpinion) {
      since_opinion_ = 0;
      ask_second_opinion(image);
    }
    place_pipes(image);
    step_.learn_shapes(image, outcome_, share);
    if (places_searched_ && !radii_are_borne_out(image)) {
      // What was learnt of such pipes is worth as little as of others that were taken for them.
      offsets_.reset();
      step_.forget_shapes();
      step_.forget();
      lose("the pipes do not look as wide as the rack file has them", result);
      return;
    }
    improve_camera();
    fill(result);
    result.quality = quality();
  }

  /// Of a pose over pipes that were found with it, of which little else is known. What shading
  /// moves a contour by it moves it by in every image: the sum of them tells no more than one. Zero
  /// over other pipes.
  [[nodiscard]] Matrix6d covariance_by_edges() const {
    if (!places_searched_) {
      return Matrix6d::Zero();
    }
    const Matrix6d before = linear_algebra::inverse(covariance_at_start_);
    return linear_algebra::inverse<6>(outcome_.edge_information + before);
  }

  /// Whether the pipes of this track look as wide as the rack file has them.
  bool radii_are_borne_out(const ImageView& image) {
    if (++since_judged_ < kImagesPerJudgement) {
      return true;
    }
    since_judged_ = 0;
    const RadiusEvidence evidence = step_.evidence_for_radii(image, outcome_);
    radii_.sum = kKeptOfRadii * radii_.sum + evidence.sum;
    radii_.pipes = kKeptOfRadii * radii_.pipes + evidence.pipes;
    return radii_.pipes < kEnoughRadii || radii_.sum >= kLeastForRadii * radii_.pipes;
  }

  /// Those that the start could not place, once the view tells.
  void place_pipes(const ImageView& image) {
    if (outcome_.belief.offsets.unplaced.none() || ++since_placed_ < kImagesPerPlacing) {
      return;
    }
    since_placed_ = 0;
    if (const std::optional<FoundPipe> found = step_.find_unplaced(image, outcome_)) {
      offsets_.place(found->pipe, found->offset);
    }
  }

  /// What misled the first images is believed by now, and holds the pose that it led to.
  void ask_second_opinion(const ImageView& image) {
    OffsetMemory doubted = offsets_;
    doubted.doubt();
    const geometry::SE3 first = outcome_.belief.T_rack_camera;
    if (!step_.find_anew(image, doubted.belief(), outcome_)) {
      return;
    }
    offsets_ = doubted;
    offsets_.learn(outcome_.belief.offsets, outcome_.pipes, 1);
    pose_.shift(pose_difference(first, outcome_.belief.T_rack_camera));
    anchor_variance_ = outcome_.belief.anchor_variance;
    step_.forget();
    pose_.begin_map();
    view_.begin(pose_.pose(), *last_stamp_);
    step_.learn(image, outcome_, pose_.relative_covariance());
  }

  /// Of what the image says, what those before it did not.
  double share_of_view() {
    if (!starting_) {
      return view_.see(pose_.pose(), *last_stamp_);
    }
    view_.begin(pose_.pose(), *last_stamp_);
    return 1;
  }

  /// Before the step learns: its working memory holds the image's edges.
  void learn_intrinsics() {
    const auto found = step_.find_intrinsics(intrinsics_.belief(), offsets_.belief(), outcome_);
    if (!found) {
      return;
    }
    intrinsics_.learn(found->belief);
    pose_by_intrinsics_ = found->pose_by_intrinsics;
  }

  /// After all that was found through the camera as it was.
  void improve_camera() {
    const Eigen::Vector3d before = intrinsics_.in_use();
    if (const std::optional<geometry::Camera> camera = intrinsics_.improved()) {
      step_.set_camera(*camera);
      pose_.shift(pose_by_intrinsics_ * (intrinsics_.in_use() - before));
    }
  }

  void lose(std::string_view reason, RackTrackerResult& result) {
    ++(starting_ ? counts_.refused_starts : counts_.losses);
    if (probation_ > 0) {
      offsets_.reset();  // as little as the pose, they may have been found
      step_.forget_shapes();
    }
    state_ = TrackStatus::kLost;
    starting_ = false;
    lost_reason_ = reason;
    result = blank();
    result.reason = reason;
  }

  RackTrackerResult blank() {
    RackTrackerResult result;
    result.status = state_;
    const OffsetBelief& offsets = offsets_.belief();
    offset_means_ = offsets.mean;
    for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
      const auto pipe = static_cast<Eigen::Index>(i);
      offset_variances_[i] = offsets.covariance(pipe, pipe);
      offset_observed_[i] = outcome_.offset_observed[i] ? 1 : 0;
    }
    result.offsets = std::span(offset_means_).first(model_.pipes.size());
    result.offset_variances = std::span(offset_variances_).first(model_.pipes.size());
    result.offset_observed = std::span(offset_observed_).first(model_.pipes.size());
    shapes_.clear();
    for (const TrackStep::ShapedPipe& shaped : step_.shapes()) {
      const ShapeMemory& memory = shaped.memory;
      shapes_.push_back({.pipe = shaped.pipe,
                         .found = memory.found(),
                         .shape = memory.value(),
                         .deviation = memory.deviation()});
      offset_means_[shaped.pipe] = shapes_.back().shape.offset;
      offset_variances_[shaped.pipe] = std::pow(shapes_.back().deviation.offset, 2);
      offset_observed_[shaped.pipe] = memory.found() ? 1 : 0;
    }
    result.shapes = shapes_;
    if (parameters_.estimate_intrinsics) {
      result.intrinsics = intrinsics_.belief();
    }
    result.map_points = static_cast<int>(step_.map_points());
    return result;
  }

  void fill(RackTrackerResult& result) {
    result = blank();
    result.T_rack_camera = pose_.pose();
    const double alike = std::exp(-view_.views() / kViewsUntilUnlike);
    result.covariance = kCovarianceFactor * pose_.covariance() + alike * covariance_at_start_;
    result.covariance += outcome_.covariance_by_offsets + covariance_by_edges_;
    result.covariance(1, 1) += anchor_variance_;
    if (!reference_seen_) {
      result.covariance(0, 0) += (1 - alike) * covariance_at_start_(0, 0) +
                                 (places_searched_ ? kTakenForOthers * kTakenForOthers : 0.0);
    }
    if (parameters_.estimate_intrinsics) {
      result.covariance +=
          pose_by_intrinsics_ * intrinsics_.belief().covariance * pose_by_intrinsics_.transpose();
    }
    result.inlier_share = outcome_.inlier_share;
    result.edges = outcome_.evidence.edges;
    result.edge_samples = outcome_.evidence.edge_samples;
    result.edge_samples_found = outcome_.evidence.edge_samples_found;
    result.points = outcome_.evidence.points;
    result.points_matched = outcome_.evidence.points_matched;
    result.iterations = outcome_.iterations;
  }

  RackModel model_;
  geometry::Camera camera_;
  RackTrackerParameters parameters_;
  TrackStep step_;
  StepOutcome outcome_;
  RackTrackerCounts counts_;

  TrackStatus state_ = TrackStatus::kNotStarted;
  bool starting_ = false;  ///< no image has borne out the pose that was given
  int probation_ = 0;      ///< images that still have to bear it out as well as the first one
  ViewChange view_;
  Matrix6d covariance_at_start_ = Matrix6d::Zero();  ///< after the first image
  bool places_searched_ = false;                     ///< by the start
  bool reference_seen_ = false;                      ///< since then
  Matrix6d covariance_by_edges_ = Matrix6d::Zero();
  int coasted_ = 0;
  int since_opinion_ = 0;  ///< images
  int since_placed_ = 0;   ///< the same
  int since_judged_ = 0;   ///< the same
  RadiusEvidence radii_;   ///< of this track
  std::string_view lost_reason_;
  PoseBelief pose_;
  PoseBelief tracked_;       ///< at the last tracked image
  double coasted_time_ = 0;  ///< s since then, of images that were predicted through
  double anchor_variance_ = 0;
  OffsetMemory offsets_;
  IntrinsicsMemory intrinsics_;
  /// How the pose that fits moves with the intrinsics, as the last image had it.
  Eigen::Matrix<double, 6, 3> pose_by_intrinsics_ = Eigen::Matrix<double, 6, 3>::Zero();
  std::optional<double> last_stamp_;
  std::optional<double> leapt_stamp_;
  std::optional<std::uint64_t> fingerprint_;
  int repeated_ = 0;  ///< identical images before this one, in a row
  std::array<double, kMaxPipes> offset_means_{};
  std::array<double, kMaxPipes> offset_variances_{};
  std::array<std::uint8_t, kMaxPipes> offset_observed_{};
  std::vector<PipeShapeEstimate> shapes_;
};

RackTracker::RackTracker(const RackModel& model, const geometry::Camera& camera,
                         const RackTrackerParameters& parameters) {
  model.validate();
  parameters.validate();
  implementation_ = std::make_unique<Implementation>(model, camera, parameters);
}

RackTracker::~RackTracker() = default;
RackTracker::RackTracker(RackTracker&&) noexcept = default;
RackTracker& RackTracker::operator=(RackTracker&&) noexcept = default;

bool RackTracker::set_pose(const geometry::SE3& T_rack_camera, const Matrix6d& covariance) {
  return implementation_->set_pose(T_rack_camera, covariance);
}

RackTrackerResult RackTracker::track(const ImageView& image, double stamp,
                                     const std::optional<MotionPrediction>& motion) {
  return implementation_->track(image, stamp, motion);
}

void RackTracker::reset() {
  implementation_->reset();
}

const RackTrackerCounts& RackTracker::counts() const noexcept {
  return implementation_->counts();
}

}  // namespace pipescout::rack_vision
