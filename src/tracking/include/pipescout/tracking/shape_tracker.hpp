// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "pipescout/tracking/particle_filter.hpp"
#include "pipescout/tracking/shape_kalman.hpp"
#include "pipescout/tracking/trackable_shape.hpp"

/// Track management: acquisition, lock, coasting without detection, loss, re-acquisition. Pixels,
/// radians, seconds; pixel (0, 0) is the middle of the upper left one, x to the right, y down.
namespace pipescout::tracking {

enum class TrackState : std::uint8_t {
  kDetecting,  ///< no track; a candidate may exist
  kLocked,     ///< detected in this image
  kCoasting,   ///< not detected: predicted
  kLost,       ///< predicted for longer than `max_coast`
};
/// "detecting", "locked", "coasting", "lost"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(TrackState state) noexcept;

/// The reason why an image, or a part of its data, was not used.
enum class TrackFault : std::uint8_t {
  kNone,
  kBadStamp,        ///< not finite: the image is not used
  kTimeWentBack,    ///< not after the last one: the image is not used. By more than `max_back`: the
                    ///< track is restarted
  kBadImageSize,    ///< not within [1, 32767]: the image is not used
  kTooManyRegions,  ///< more than `max_regions`: treated as none
  kBadRegion,       ///< a region that is not finite, or of size 0: ignored
  kBadMotion,       ///< motion of the camera not `usable`: ignored
  kBadHint,         ///< not finite, or without deviation: ignored
};
inline constexpr std::size_t kTrackFaults = 8;
/// "none", "bad_stamp", ...; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(TrackFault fault) noexcept;

template <TrackableShape Model>
struct ShapeTrackerParameters {
  ShapeTrackerParameters();  ///< the shape's own deviations, for pictures of some 320 to 640 px

  ParticleFilterParameters<Model> filter{};
  /// Random walk of the rate, per square root of a second, > 0, if the camera's motion is unknown.
  ShapeState<Model> rate_walk;
  double motion_share = 0.06;  ///< (0, 1]: share of `rate_walk` if it is known
  double rate_memory = 1.0;    ///< s, (0, 100]: decay time of unconfirmed rates
  double gate = 4.0;           ///< standard deviations, [1, 20]: gate of readings
  double detection = 0.95;     ///< (0, 1): probability of detecting a visible shape
  double clutter = 0.5;        ///< (0, 100]: expected false regions per image
  double doubt = 0.02;         ///< (0, 1): probability that a doubtful reading is of another object
  std::size_t confirm = 3;     ///< [1, 100]: images in which a candidate must be detected
  double confidence_time = 1;  ///< s, (0, 1000]: decay time of the confidence without detection
  /// s, (0, 1000]: without detection, until it is lost; for as long a pipe that reached the border
  /// is expected to go on there behind a post.
  double max_coast = 1.5;
  /// s, [0, 1000]: time after the loss in which only regions near the prediction or a hint are
  /// accepted; then any region starts a new track.
  double max_lost = 3.0;
  double max_back = 1.0;           ///< s, [0, 1000]
  std::size_t max_regions = 1000;  ///< [1, 100000]
  /// Distance of equation (14), > 0: a region within it of the particles' robust mean is accepted
  /// when no region has been within the gate for two images; particles farther from the track are
  /// reset to it.
  double guard_distance = 20.0;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Expected position of the shape: from the fused pose of the camera and a map.
template <TrackableShape Model>
struct TrackHint {
  ShapeState<Model> shape = ShapeState<Model>::Zero();
  ShapeState<Model> deviation = ShapeState<Model>::Ones();  ///< > 0
};

template <TrackableShape Model>
struct TrackingFrame {
  double time = 0;  ///< s, of the measurement
  ImageSize image{};
  std::span<const typename Model::Region> regions{};
  /// Motion of the image since the last one, if the motion of the camera is known.
  std::optional<ImageMotion> motion{};
  /// Used while there is no track: then only regions near it become candidates.
  std::optional<TrackHint<Model>> hint{};
};

template <TrackableShape Model>
struct Track {
  using State = ShapeState<Model>;

  TrackState state = TrackState::kDetecting;
  std::uint64_t number = 0;  ///< number of the track, from 1 on; 0: none yet
  double time = 0;           ///< s, of the last image that was used
  ImageSize image{};
  TrackFault fault = TrackFault::kNone;  ///< the last of this image

  /// Estimate of the Kalman filter, for use: of the visible part, to first order. All estimates are
  /// zero without a track or candidate.
  State estimate = State::Zero();
  ShapeCovariance<Model> covariance = ShapeCovariance<Model>::Zero();
  State rate = State::Zero();   ///< of it, 1/s
  bool in_view = false;         ///< otherwise it is predicted outside the image
  bool start_censored = false;  ///< as of ShapeInView: the shape is longer than the estimate
  bool end_censored = false;
  /// Including the part beyond the border, with its length when it left the image. The uncertainty
  /// of an end that has never been visible is some diagonals of the image.
  State whole = State::Zero();

  State best_particle = State::Zero();  ///< Ibarguren and others (2013), section 7.2
  State robust_mean = State::Zero();
  State weighted_mean = State::Zero();
  double effective_samples = 0;

  double confidence = 0;  ///< [0, 1]: probability that the track is of a shape, and the same one
  double since_seen = 0;  ///< s; NaN: never
  std::optional<std::size_t>
      region{};             ///< index of the region with the largest weight; none: not detected
  std::size_t regions = 0;  ///< usable ones
};

/// Tracks one shape. A Kalman filter with decaying rates estimates it; each reading of a region has
/// its own variance, so that an end cut by the border of the image does not affect the length. The
/// most likely region within the gate is associated, joined with the regions that then fit too, as
/// parts of the same shape: a pipe on both sides of a post. The probability that there is a shape
/// is that of Musicki, Evans, Stankovic, "Integrated probabilistic data association" (IEEE
/// Transactions on Automatic Control 39, 1994), except that images without detection count by their
/// time, because gaps are contiguous. The paper's particle filter runs in parallel and re-acquires
/// the shape after a jump of the image. Other regions are tracked too, so that none is associated
/// with the shape while it is hidden. The same frames and seed give the same bits. Allocates
/// nothing after construction. Not thread-safe.
template <TrackableShape Model>
class ShapeTracker {
 public:
  using State = ShapeState<Model>;
  using Region = typename Model::Region;

  /// Throws as the `validate` of its arguments.
  ShapeTracker(const Model& model, const ShapeTrackerParameters<Model>& parameters,
               std::uint64_t seed);

  /// Processes the next image. Never throws for any content; the result is valid until the next
  /// call.
  const Track<Model>& update(const TrackingFrame<Model>& frame);
  /// Resets the track; the next image starts a new one.
  void restart();

  [[nodiscard]] const Track<Model>& track() const noexcept { return track_; }
  /// Counts, by TrackFault.
  [[nodiscard]] const std::array<std::size_t, kTrackFaults>& faults() const noexcept {
    return faults_;
  }
  [[nodiscard]] const ParticleFilter<Model>& filter() const noexcept { return filter_; }
  [[nodiscard]] const ShapeTrackerParameters<Model>& parameters() const noexcept {
    return parameters_;
  }

 private:
  /// Another visible shape.
  struct Rival {
    ShapeKalman<Model> kalman;
    std::size_t seen = 0;  // pictures
    double last_seen = 0;
  };
  /// A usable region of the image.
  struct Usable {
    std::size_t region = 0;  // in the frame's
    double size = 0;
    double ratio = 0;  // likelihood ratio of the shape to clutter; 0: not within the gate
    std::optional<std::size_t>
        rival{};  // the other shape of the region; none: no shape's, or the track's
    double rival_ratio = 0;
  };
  using Regions = std::span<const Region>;
  using Motion = std::optional<ImageMotion>;
  static constexpr std::size_t kMostRivals = 16;
  static constexpr std::size_t kMostCompared = 16;

  bool accept(const TrackingFrame<Model>& frame);
  void resize(const ImageSize& image);
  void gather(Regions regions);
  void predict(double dt, const Motion& motion);
  void associate(Regions regions);
  void correct(Regions regions);
  void jump(Regions regions);
  void follow_rivals(Regions regions, const Motion& motion);
  void weigh(Regions regions);
  void take_up(const TrackingFrame<Model>& frame, const Motion& motion);
  [[nodiscard]] std::optional<std::size_t> fits_hint(Regions regions, const TrackHint<Model>& hint);
  void begin(const Region& region, const Motion& motion);
  void start_at(ShapeKalman<Model>& kalman, const Region& region, const Motion& motion);
  void seen_in(std::size_t region);
  void live();
  void report();
  void note(TrackFault fault) noexcept;

  [[nodiscard]] State start_deviation() const { return parameters_.filter.start_deviation; }
  [[nodiscard]] State start_rate_deviation() const;
  [[nodiscard]] bool lost() const {
    return confirmed_ && track_.time - last_seen_ > parameters_.max_coast;
  }
  [[nodiscard]] double distance_between(const State& a, const State& b) const;
  [[nodiscard]] bool of_known_rival(const Usable& usable) const;
  typename ShapeKalman<Model>::Fit fit(ShapeKalman<Model>& kalman, const Region& region);

  Model model_;
  ShapeTrackerParameters<Model> parameters_;
  ParticleFilter<Model> filter_;
  ShapeKalman<Model> kalman_;
  Track<Model> track_{};
  std::array<std::size_t, kTrackFaults> faults_{};
  std::uint64_t numbers_ = 0;
  std::size_t times_seen_ = 0;  // of what is followed
  std::size_t misses_ = 0;      // pictures in a row
  double last_seen_ = 0;
  double start_censored_ = 0;  // s: when the start of what is followed was last beyond the border
  double end_censored_ = 0;    // s, the same of its end
  double existence_ = 0;       // probability, of what is followed
  bool following_ = false;     // a track or a candidate
  bool confirmed_ = false;     // it is a track
  bool clocked_ = false;       // the time of a picture is known
  std::vector<Rival> rivals_;
  std::vector<Usable> usable_;
  State seen_ = State::Zero();  // of the regions that are the shape's, joined; if `track_.region`
  std::vector<State> compared_;
  ObservationRows<Model::kSize> rows_;
};

extern template class ShapeTracker<PipeShape>;
extern template class ShapeTracker<ValveShape>;
extern template class ShapeTracker<VesselShape>;
extern template struct ShapeTrackerParameters<PipeShape>;
extern template struct ShapeTrackerParameters<ValveShape>;
extern template struct ShapeTrackerParameters<VesselShape>;

using PipeTracker = ShapeTracker<PipeShape>;
using PipeTrackerParameters = ShapeTrackerParameters<PipeShape>;
using PipeTrack = Track<PipeShape>;

}  // namespace pipescout::tracking
