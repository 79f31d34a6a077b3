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

/// The life of a track: taken up, locked, coasting where nothing is seen, lost, taken up again.
/// Pixels, radians, seconds; pixel (0, 0) is the middle of the upper left one, x to the right, y
/// down.
namespace pipescout::tracking {

enum class TrackState : std::uint8_t {
  kDetecting,  ///< nothing has been locked on yet, or given up; a candidate may be followed already
  kLocked,     ///< seen in this picture
  kCoasting,   ///< not seen in it: predicted
  kLost,       ///< predicted for longer than `max_coast`
};
/// "detecting", "locked", "coasting", "lost"; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(TrackState state) noexcept;

/// Why a picture, or something of it, was not used.
enum class TrackFault : std::uint8_t {
  kNone,
  kBadStamp,      ///< not finite: the picture is not used
  kTimeWentBack,  ///< not after the last one: the picture is not used. By more than `max_back`: the
                  ///< track begins anew
  kBadImageSize,  ///< not within [1, 32767]: the picture is not used
  kTooManyRegions,  ///< more than `max_regions`: the picture counts as one without any
  kBadRegion,       ///< one with numbers that are not finite, or of no size: it is left out
  kBadMotion,       ///< of the camera, not `usable`: left out
  kBadHint,         ///< not finite, or without deviation: left out
};
inline constexpr std::size_t kTrackFaults = 8;
/// "none", "bad_stamp", ...; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(TrackFault fault) noexcept;

template <TrackableShape Model>
struct ShapeTrackerParameters {
  ShapeTrackerParameters();  ///< the shape's own deviations, for pictures of some 320 to 640 px

  ParticleFilterParameters<Model> filter{};
  /// Of the rate, per square root of a second, > 0: random walk, where the camera's motion is not
  /// told.
  ShapeState<Model> rate_walk;
  double motion_share = 0.06;  ///< (0, 1]: of `rate_walk`, where it is told
  double rate_memory = 1.0;    ///< s, (0, 100]: rates that nothing bears out fade within it
  double gate = 4.0;           ///< deviations, [1, 20]: readings within it may be of the shape
  double detection = 0.95;     ///< (0, 1): probability that the shape is found when it is there
  double clutter = 0.5;        ///< (0, 100]: false regions a picture, expected
  double doubt = 0.02;         ///< (0, 1): probability that a doubtful reading is of something else
  std::size_t confirm = 3;     ///< [1, 100]: pictures in which a candidate has to be seen
  double confidence_time = 1;  ///< s, (0, 1000]: unseen, the confidence fades within it
  double max_coast = 1.5;      ///< s, (0, 1000]: unseen for longer, it is lost
  /// s, [0, 1000]: lost for so long, only what fits the prediction or a hint is taken; then
  /// anything, as a new track.
  double max_lost = 3.0;
  double max_back = 1.0;           ///< s, [0, 1000]
  std::size_t max_regions = 1000;  ///< [1, 100000]
  /// Distance as of equation (14), > 0: a region so near the particles' robust mean is taken when
  /// nothing has been within the gate for two pictures; particles farther from what is locked on
  /// begin anew there.
  double guard_distance = 20.0;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Where the shape should be: from the fused pose of the camera and a map.
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
  /// How the picture moves since the last one, where the motion of the camera is known.
  std::optional<ImageMotion> motion{};
  /// Used while nothing is locked on: then only regions that fit it are taken up.
  std::optional<TrackHint<Model>> hint{};
};

template <TrackableShape Model>
struct Track {
  using State = ShapeState<Model>;

  TrackState state = TrackState::kDetecting;
  std::uint64_t number = 0;  ///< which one, from 1 on: another number, another shape; 0: none yet
  double time = 0;           ///< s, of the last picture that was used
  ImageSize image{};
  TrackFault fault = TrackFault::kNone;  ///< the last of this picture

  /// The Kalman filter's, the one to use: of the part in the picture, to first order. All estimates
  /// are zero where there is neither track nor candidate.
  State estimate = State::Zero();
  ShapeCovariance<Model> covariance = ShapeCovariance<Model>::Zero();
  State rate = State::Zero();   ///< of it, 1/s
  bool in_view = false;         ///< otherwise it is predicted outside the picture
  bool start_censored = false;  ///< as of ShapeInView: the shape is longer than the estimate
  bool end_censored = false;
  /// With what is beyond the border, as long as it was when it left the picture; never shrunk by
  /// it. An end that has never been seen is anywhere within some diagonals of the picture.
  State whole = State::Zero();

  State best_particle = State::Zero();  ///< Ibarguren and others (2013), section 7.2
  State robust_mean = State::Zero();
  State weighted_mean = State::Zero();
  double effective_samples = 0;

  double confidence = 0;  ///< [0, 1]: probability that the track is of a shape, and the same one
  double since_seen = 0;  ///< s; NaN: never
  std::optional<std::size_t> region{};  ///< which of the picture's counts most; none: not seen
  std::size_t regions = 0;              ///< that were usable
};

/// Follows one shape. A Kalman filter of rates that fade tells where it is; each reading of a
/// region counts with its own accuracy, so that what the border of the picture cuts says nothing of
/// the length. The likeliest region within the gate is taken, and with it those that fit then too:
/// parts of the same. The probability that there is a shape is that of Musicki, Evans, Stankovic,
/// "Integrated probabilistic data association" (IEEE Transactions on Automatic Control 39, 1994),
/// but that pictures in which it is missing count by their time: gaps come in one piece. The
/// paper's particle filter runs beside it and takes it along where the picture jumps. Other regions
/// are followed too, so that none is taken for the shape when that is hidden. The same frames and
/// seed give the same bits. Allocates nothing after construction. Not thread-safe.
template <TrackableShape Model>
class ShapeTracker {
 public:
  using State = ShapeState<Model>;
  using Region = typename Model::Region;

  /// Throws as the `validate` of its arguments.
  ShapeTracker(const Model& model, const ShapeTrackerParameters<Model>& parameters,
               std::uint64_t seed);

  /// The next picture. Never throws for what is in it; the result stays until the next call.
  const Track<Model>& update(const TrackingFrame<Model>& frame);
  /// Forgets the track, and begins anew with the next picture.
  void restart();

  [[nodiscard]] const Track<Model>& track() const noexcept { return track_; }
  /// How often each happened, by TrackFault.
  [[nodiscard]] const std::array<std::size_t, kTrackFaults>& faults() const noexcept {
    return faults_;
  }
  [[nodiscard]] const ParticleFilter<Model>& filter() const noexcept { return filter_; }
  [[nodiscard]] const ShapeTrackerParameters<Model>& parameters() const noexcept {
    return parameters_;
  }

 private:
  /// Another shape that is seen.
  struct Rival {
    ShapeKalman<Model> kalman;
    std::size_t seen = 0;  // pictures
    double last_seen = 0;
  };
  /// A usable region of the picture.
  struct Usable {
    std::size_t region = 0;  // in the frame's
    double size = 0;
    double ratio = 0;  // likelihood of the shape over that of clutter; 0: not within the gate
    std::optional<std::size_t> rival{};  // whose it is; none: nobody's, or the shape's
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
  double existence_ = 0;    // probability, of what is followed
  bool following_ = false;  // a track or a candidate
  bool confirmed_ = false;  // it is a track
  bool clocked_ = false;    // the time of a picture is known
  std::vector<Rival> rivals_;
  std::vector<Usable> usable_;
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
