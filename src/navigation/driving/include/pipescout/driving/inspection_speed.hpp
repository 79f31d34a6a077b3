// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>

/// How fast a robot may drive while a thermal camera looks at a pipe, and where it has to look
/// again (Ibarguren and others, 2013, section 8: tracking and findings go into navigation).
namespace pipescout::navigation {

struct InspectionParameters {
  double exposure = 0.01;         ///< s, (0, 1]: time constant of the detector or shutter
  double focal_length = 500;      ///< px, [10, 1e5]
  double largest_blur = 1;        ///< px, (0, 100]: motion during the exposure
  double speed_share = 0.85;      ///< (0, 1]: of the limit by blur; speed and range have errors
  double arm_rate = 0.5;          ///< rad/s, (0, 10]: how fast the arm turns to what passes
  double usual_range = 2;         ///< m, (0, 1000]: if the track has none
  double good_confidence = 0.7;   ///< (0, 1]: below, it is slower
  double least_confidence = 0.3;  ///< [0, good_confidence): at it, slow_speed is left
  double slow_speed = 0.4;        ///< m/s, (0, 10]
  double stop_after = 0.5;        ///< s, [0, 60]: without a track; before, it is slow
  double return_after = 1.5;      ///< s, [stop_after, 600]: it goes back then
  double return_run = 1;          ///< m, [0, 10]: before the place where the pipe was last seen
  int returns = 2;                ///< [0, 10]: to the same place; then it goes on without the pipe
  double nearer = 0.5;            ///< m, [0, 5]: offset to the pipe while a finding is passed again

  /// Throws std::invalid_argument that names the field.
  void validate() const;
};

/// Closed: nothing else limits the speed of an inspection.
enum class InspectionReason {
  kNone,
  kMotionBlur,
  kArmRate,
  kLowConfidence,
  kTrackLost,        ///< slow, then standing
  kGoesBack,         ///< to where the pipe was last seen
  kPipeGivenUp,      ///< not found after `returns`: it drives on slowly
  kDoubtfulFinding,  ///< is passed again from nearer
};
[[nodiscard]] const char* to_string(InspectionReason reason);

/// What the tracker says, and where the robot is then.
struct InspectionView {
  double time = 0;        ///< s
  double arc_length = 0;  ///< m, on the path
  bool tracked = false;
  double confidence = 0;  ///< [0, 1]
  double range = 0;       ///< m to the pipe; not positive or not finite: unknown
};

struct InspectionDecision {
  double speed = std::numeric_limits<double>::infinity();  ///< m/s, at most
  InspectionReason reason = InspectionReason::kNone;       ///< of the lowest limit
  std::optional<double> go_back_to;                        ///< m, of arc length
  bool nearer = false;                                     ///< drive `nearer` m towards the pipe
};

class InspectionSpeed {
 public:
  /// Throws std::invalid_argument.
  explicit InspectionSpeed(const InspectionParameters& parameters);

  /// For a new path.
  void start();
  /// A finding at an arc length that has to be looked at again. Once per place.
  void doubtful_finding(double arc_length);
  /// m/s, at which the image moves by largest_blur during the exposure: blur * range /
  /// (exposure * focal length), for a camera that looks across the way.
  [[nodiscard]] double blur_limit(double range) const;
  /// In each cycle. Values that are not finite count as no track. Allocates nothing.
  InspectionDecision decide(const InspectionView& view);

  [[nodiscard]] const InspectionParameters& parameters() const { return parameters_; }

 private:
  InspectionDecision lost(const InspectionView& view, InspectionDecision decision);

  InspectionParameters parameters_;
  std::optional<double> lost_since_;
  std::optional<double> last_seen_;  ///< m, the farthest arc length with a track
  int returns_ = 0;
  bool given_up_ = false;
  std::optional<double> doubtful_;  ///< m, to be passed again
  std::optional<double> passing_;   ///< m, being passed again
  std::optional<double> last_doubtful_;
};

}  // namespace pipescout::navigation
