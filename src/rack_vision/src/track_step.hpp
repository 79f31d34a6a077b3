// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <optional>
#include <vector>

#include "alignment_search.hpp"
#include "offset_memory.hpp"
#include "pipe_places.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/contour.hpp"
#include "pipescout/rack_vision/edge_search.hpp"
#include "pipescout/rack_vision/image_noise.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"
#include "pipescout/rack_vision/row_motion.hpp"
#include "pipescout/rack_vision/surface_points.hpp"
#include "pipescout/rack_vision/texture_map.hpp"
#include "pipescout/rack_vision/track_quality.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"
#include "pose_belief.hpp"
#include "radius_rank.hpp"
#include "shape_memory.hpp"

namespace pipescout::rack_vision {

/// m^2: variance along y of a pose relative to its anchor.
inline constexpr double kRelativeVariance = 1e-6;

/// px to either side of an edge where it is rendered.
inline constexpr double kLeastRange = 3.0;
/// px, three deviations of an offset: beyond it nothing of a pipe is to be seen where it is
/// believed.
inline constexpr double kFarFromBelieved = 30;
inline constexpr double kLeastSupported = 0.5;  ///< of the pipes in view: where they are believed
inline constexpr int kEnoughProven = 10;        ///< points

/// What is believed before or after an image.
struct TrackBelief {
  geometry::SE3 T_rack_camera;
  geometry::Matrix6d covariance = geometry::Matrix6d::Identity();  ///< relative to the anchor
  double anchor_variance = 0;                                      ///< m^2, along y
  OffsetBelief offsets;
  MapErrorBelief map{};
  geometry::Vector6d velocity = geometry::Vector6d::Zero();             ///< as in RowMotion
  geometry::Matrix6d velocity_covariance = geometry::Matrix6d::Zero();  ///< the same
};

/// Of a rack.
struct Bodies {
  std::bitset<kMaxPipes> pipes = std::bitset<kMaxPipes>().set();
  bool supports = true;
};

struct StepOutcome {
  bool solved = false;
  TrackBelief belief;  ///< after the image; as before it when it was not solved
  /// Solved against the map alone, the place along y was moved by this to where supports have it,
  /// m. Contained in `belief`.
  double shift_along = 0;
  /// Where the map took part: what it is found to be wrong by. Not yet taken out of it.
  std::optional<MapErrorSolution> map_error;
  TrackEvidence evidence;
  std::array<PipeSupport, kMaxPipes> pipes{};
  PoseStatus status = PoseStatus::kNoFeatures;
  std::bitset<kMaxPipes> offset_observed;
  std::vector<ShapeBelief> shapes;  ///< of TrackStep::shapes
  /// m, one sigma, above 0 where pipes lie farther from where they were believed than was said: the
  /// prior with which their offsets were found.
  double misplaced_by = 0;
  bool places_searched = false;  ///< of pipes, at a start
  /// Something that tells x and cannot have moved is seen where the pose has it.
  bool reference_found = false;
  geometry::Matrix6d covariance_by_offsets = geometry::Matrix6d::Zero();
  geometry::Matrix6d edge_information = geometry::Matrix6d::Zero();  ///< as in PoseSolution
  double inlier_share = 0;
  int iterations = 0;
  int edge_samples = 0;
};

/// How much more an image looks like the pipes of the model than like pipes of other radii.
struct RadiusEvidence {
  double sum = 0;    ///< over the pipes: negative logarithm of RadiusRank, 1 each by chance
  double pipes = 0;  ///< that it is known of
};

/// Where a pipe was found.
struct FoundPipe {
  std::size_t pipe = 0;
  double offset = 0;  ///< m
};

/// After a wide search a few points that agree are not enough.
[[nodiscard]] bool borne_out_by_texture(const StepOutcome& outcome) noexcept;

/// One image: render, search, match, solve (Lippiello and Cacace, Figure 4). It holds the texture
/// map and what the edges look like, and the working memory of all parts.
class TrackStep {
 public:
  TrackStep(const RackModel& model, const geometry::Camera& camera,
            const RackTrackerParameters& parameters);

  /// Measures the noise of the image that the functions below are given next.
  void look_at(const ImageView& image);
  /// Finds the pose. Changes nothing that is learnt.
  void find(const ImageView& image, const TrackBelief& before, StepOutcome& outcome);
  /// Finds the pose from texture that was mapped before or edges alone, from a first guess that may
  /// be wrong by the parameters' start range. Not solved when no place explains the image, or when
  /// two places do about as well.
  void find_from_far(const ImageView& image, const TrackBelief& before, StepOutcome& outcome);
  /// Takes over what the last image taught: call it when its outcome is trusted. `relative`:
  /// covariance of the pose against the map.
  void learn(const ImageView& image, const StepOutcome& outcome,
             const geometry::Matrix6d& relative);
  void forget();
  /// What the edges of the last image, whose outcome this is, say of the intrinsics: not the
  /// texture, which was mapped through the camera that is in doubt. Nothing when they say nothing.
  struct Intrinsics {
    IntrinsicsBelief belief;  ///< after the image
    Eigen::Matrix<double, 6, 3> pose_by_intrinsics;
  };
  [[nodiscard]] std::optional<Intrinsics> find_intrinsics(const IntrinsicsBelief& before,
                                                          const OffsetBelief& offsets,
                                                          const StepOutcome& outcome);
  /// A second opinion on the last image: from `outcome`, the first one, but without what earlier
  /// images say of the pose and of the offsets, of which `offsets` is all that is known. Returns
  /// whether it explains the edges clearly better; only then is it the outcome. Call it after
  /// `learn`.
  [[nodiscard]] bool find_anew(const ImageView& image, const OffsetBelief& offsets,
                               StepOutcome& outcome);
  /// Of the last image, at the pose of this outcome, which is rendered for it. In flight, call it
  /// after `learn`.
  [[nodiscard]] RadiusEvidence evidence_for_radii(const ImageView& image,
                                                  const StepOutcome& outcome);
  /// Of the pipes that are unplaced, the one whose place the last image, whose outcome this is,
  /// tells best. Nothing when it tells none. Call it after `learn`.
  [[nodiscard]] std::optional<FoundPipe> find_unplaced(const ImageView& image,
                                                       const StepOutcome& outcome);
  /// What the last image, whose outcome this is, says of pipes that may not be as the model has
  /// them; `share` of it was not told by those before. Call it after `learn`.
  void learn_shapes(const ImageView& image, const StepOutcome& outcome, double share);
  void forget_shapes();
  /// Of a pipe that may not be as the model has it.
  struct ShapedPipe {
    std::size_t pipe = 0;
    Pipe drawn;  ///< as the model has it
    ShapeMemory memory;
  };
  [[nodiscard]] const std::vector<ShapedPipe>& shapes() const noexcept { return shapes_; }
  /// A camera of the same size, from the next image on.
  void set_camera(const geometry::Camera& camera);

  [[nodiscard]] const RackModel& model() const noexcept { return model_; }
  [[nodiscard]] std::size_t map_points() const noexcept { return map_.size(); }

 private:
  void reserve();
  void render(const geometry::SE3& T_rack_camera, const OffsetBelief& offsets);
  /// An image begins: pipes have the shapes that are believed, and those are left out whose
  /// contours may, for what is unknown of them, be too far from where the camera would see them.
  void begin_shapes(const TrackBelief& belief);
  /// From here on the model has the pipes with these shapes; `shape_of`: by index into shapes_.
  void use_shapes(const auto& shape_of);
  void use_believed_shapes();
  void use_solved_shapes();
  /// Pipes that may not be as the model has them.
  [[nodiscard]] std::bitset<kMaxPipes> shaped_pipes() const noexcept;
  /// px, one sigma, that a contour may be elsewhere for what is unknown of its pipe's shape.
  [[nodiscard]] double shape_deviation(const VisibleEdge& edge, const Eigen::Vector2d& normal,
                                       const CameraView& seen) const;
  /// The contours of one pipe in the last image, where the model in use has them: into edges_.
  void render_only(std::size_t pipe, const StepOutcome& outcome);
  void take_view(const ImageView& image, const StepOutcome& outcome, ShapedPipe& shaped);
  void search(const ImageView& image, const TrackBelief& belief, double least_range,
              double along_variance);
  /// How a motion of the camera, as in `pose_difference`, moves a point of the rack along an image
  /// normal, px.
  [[nodiscard]] geometry::Vector6d by_motion(const Eigen::Vector3d& point,
                                             const Eigen::Vector2d& normal,
                                             const geometry::SE3& T_rack_camera) const;
  [[nodiscard]] double range_of(const VisibleEdge& edge, const Eigen::Vector2d& normal,
                                const TrackBelief& belief) const;
  /// How the camera moves while the image is exposed that is looked through next.
  void set_velocity(const TrackBelief& before);
  [[nodiscard]] EdgeMotion motion_of(const VisibleEdge& edge, const Eigen::Vector2d& normal,
                                     const geometry::SE3& T_rack_camera) const;
  /// What tells the place along y before the points are matched.
  enum class Along : std::uint8_t {
    kBySupports,  ///< and orthogonal pipes
    kByTexture    ///< nothing: edges that depend on it wait for the points
  };
  void find_by(const ImageView& image, const TrackBelief& before, Along along,
               StepOutcome& outcome);
  /// How far contours of pipes may be from where they are rendered, px.
  [[nodiscard]] double farthest_of_pipes(const TrackBelief& belief) const;
  /// Whether contours of pipes may be so far from where they are expected that others are nearer.
  [[nodiscard]] bool is_wide(const TrackBelief& belief) const;
  bool find_edges(const ImageView& image, const TrackBelief& belief, Along along);
  bool solve(const TrackBelief& guess, const geometry::Matrix6d& prior_covariance,
             const geometry::SE3& prior_pose, const OffsetBelief& offsets, bool with_points);
  bool solve_by(PoseSolver& solver, const TrackBelief& guess,
                const geometry::Matrix6d& prior_covariance, const geometry::SE3& prior_pose,
                const OffsetBelief& offsets, bool with_points, PipeOffsets first_offsets = {});
  /// Whether the edges that run across the pipes are seen where the solved pose has them.
  [[nodiscard]] bool across_is_found() const;
  void anchor_by_supports(const ImageView& image, TrackBelief& belief, StepOutcome& outcome);
  /// How far along y the points of the map are seen from where the map has them, m, if the camera
  /// is where `solution_` has it; nothing where too few are found.
  std::optional<double> shift_of_map(const ImageView& image, const TrackBelief& belief);
  void match_points(const ImageView& image, const TrackBelief& before, TrackBelief& guess);
  /// Fills contours_ from the rendered edges: those that an error along y of three deviations moves
  /// by at most `farthest` px.
  void gather_contours(const geometry::SE3& T_rack_camera, double along_deviation, double farthest,
                       const Bodies& of = {});
  /// Fills peaks_ with the places at which edges line up best, and left_by_peaks_. Here and below
  /// the covariance of `around` is the whole one, along y too.
  void find_peaks(const ImageView& image, const TrackBelief& around, std::size_t most);
  /// The pose at one of them, more exactly.
  geometry::SE3 narrowed(const ImageView& image, const TrackBelief& around,
                         const AlignmentPeak& peak);
  /// Where a start is tried.
  struct StartGuess {
    geometry::SE3 T_rack_camera;
    /// Where the pipes were found; without, they are looked for about where they are believed.
    std::optional<std::array<double, kMaxPipes>> offsets;
  };
  bool refine_start(const ImageView& image, const TrackBelief& around, const StartGuess& start,
                    double along_variance, PoseSolver& solver);
  /// Refines, and asks the texture map where there is one.
  bool try_start(const ImageView& image, const TrackBelief& around, const StartGuess& start,
                 StepOutcome& outcome);
  struct TriedStart {
    StartGuess start;
    geometry::SE3 found;                      ///< the pose, from there
    std::array<double, kMaxPipes> offsets{};  ///< and the offsets
    double share = 0;                         ///< of what is looked for at that pose, found
    double merit = 0;
    bool explains = false;  ///< the image
  };
  /// Whether a start that was tried just now, which found this share and moved the pose so, may be
  /// the right one.
  [[nodiscard]] bool explains_the_image(const TrackBelief& around, const StepOutcome& tried,
                                        double share, const geometry::Vector6d& moved) const;
  [[nodiscard]] bool any_explains() const;
  /// Tries a start, and keeps in tried_ what became of it.
  void consider_start(const ImageView& image, const TrackBelief& around, const StartGuess& start,
                      StepOutcome& outcome);
  /// Tries places beside the best of tried_, until none of them is better.
  void look_beside_the_best(const ImageView& image, const TrackBelief& around,
                            StepOutcome& outcome);
  using Rivalry = bool (TrackStep::*)(const TriedStart& best, const TriedStart& other) const;
  /// The best of tried_ that explains the image, if no other one is a rival.
  [[nodiscard]] std::optional<TriedStart> clear_best(Rivalry rivals) const;
  /// Another place of the camera that explains the image about as well.
  [[nodiscard]] bool is_elsewhere(const TriedStart& best, const TriedStart& other) const;
  /// The same where pipes may lie elsewhere too.
  [[nodiscard]] bool is_rival(const TriedStart& best, const TriedStart& other) const;
  /// The outcome of this start.
  void declare_start(const ImageView& image, const TrackBelief& around, const StartGuess& start,
                     StepOutcome& outcome);
  /// The outcome of the best start with the pipes about where they are believed. Returns whether
  /// there is one.
  bool start_at_offsets(const ImageView& image, const TrackBelief& around, StepOutcome& outcome);
  /// The outcome of the best start, if the pose is clear, without the pipes whose place is not.
  /// `misplaced`: what they were tried around. Returns whether there is one.
  bool declare_with_offsets(const ImageView& image, const TrackBelief& misplaced,
                            StepOutcome& outcome);
  /// Pipes that lie elsewhere in another one of tried_ that explains the image about as well.
  [[nodiscard]] std::bitset<kMaxPipes> in_doubt(const TriedStart& best) const;
  /// The pipes are about where they are believed.
  void find_at_offsets(const ImageView& image, const TrackBelief& around, StepOutcome& outcome);
  /// Pose and offsets together: each pipe is looked for where its contours line up with the image.
  void find_with_offsets(const ImageView& image, const TrackBelief& around, StepOutcome& outcome);
  /// Tries the best combinations of places_.
  void consider_places(const ImageView& image, const TrackBelief& around,
                       const geometry::SE3& T_rack_camera, std::size_t most, StepOutcome& outcome);
  /// Moves one pipe after the other to its other places, until nothing is better: of the best of
  /// tried_, without those before `from`. `covariance`: of the pose there.
  void look_beside_places(const ImageView& image, const TrackBelief& around,
                          const geometry::Matrix6d& covariance, std::size_t from,
                          StepOutcome& outcome);
  /// How strong the mean step in grey level across the contours at this pose is, which were
  /// rendered last: texture has candidates there too, but none. A log-likelihood.
  double contrast_along(const ImageView& image, const geometry::SE3& T_rack_camera);
  /// Of the pipes in view those that are found; those that are unplaced are not.
  [[nodiscard]] double supported_share(const StepOutcome& outcome) const;
  /// How far contours may be from where they are expected for what is unknown of the offsets, px.
  [[nodiscard]] double farthest_by_offsets(const TrackBelief& around);
  /// Whether offsets that were found are where they were believed to be.
  [[nodiscard]] bool are_probable(const OffsetBelief& found, const OffsetBelief& believed) const;
  /// Widens what is believed of the offsets, for a rack file that is wrong; returns the deviation,
  /// m. 0, and nothing changes, where it is as wide already or where the pose is not known well
  /// enough to look for pipes that lie elsewhere.
  double misplace(TrackBelief& around);
  /// Renders what is believed. Pipes that are farther from where they are believed than contours
  /// can be told apart are unplaced from here on.
  void render_placed(TrackBelief& belief);
  /// Fills places_ for a camera at this pose, whose errors have this covariance.
  void find_places(const ImageView& image, const TrackBelief& around,
                   const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance);
  /// From the texture map, edges after it; `around` as above. Returns whether both bear the pose
  /// out: only then is there an outcome.
  bool find_by_texture(const ImageView& image, const TrackBelief& around, StepOutcome& outcome);
  /// Whether supports fit the place along y that was found, and no other one about as well.
  bool along_is_clear(const ImageView& image, const StepOutcome& outcome, double along_variance);
  /// How far apart, in px, edges look from two places.
  [[nodiscard]] double apart(const geometry::SE3& a, const geometry::SE3& b) const;
  void accept(double anchor_variance, StepOutcome& outcome);
  [[nodiscard]] bool agrees(const PointObservation& point, const CameraView& seen,
                            const OffsetBelief& offsets) const;
  /// Whether the points bear each other out at the pose that was solved.
  [[nodiscard]] bool points_agree() const;
  /// Whether what is as the model has it determines the pose across the pipes, where others in view
  /// may not be: pose and shapes that are both unknown explain anything.
  [[nodiscard]] bool rests_on_what_is_known() const;
  /// Whether an edge moves more with x than with y, and cannot have moved along x by itself.
  [[nodiscard]] bool is_reference(const VisibleEdge& edge, const OffsetBelief& offsets) const;
  void forget_matches();
  void collect_evidence(StepOutcome& outcome) const;
  /// How near the edges that were found are to where they are rendered: 1 when all lie on them, 0
  /// when none is found.
  [[nodiscard]] double sharpness() const;
  /// Whether one of its candidates lies on the line on which the edge is seen.
  [[nodiscard]] static bool is_found(const SearchedSample& sample, const VisibleEdge& edge);
  [[nodiscard]] const VisibleEdge* rendered(const EdgeId& id) const noexcept;
  [[nodiscard]] UncertainView view(const TrackBelief& belief) const;

  RackModel model_;  ///< with the shapes in use
  geometry::Camera camera_;
  RackTrackerParameters parameters_;
  std::vector<ShapedPipe> shapes_;
  std::vector<ShapeBelief> shape_beliefs_;  ///< the same, for the solver
  std::vector<ShapeVector> shapes_in_use_;  ///< the same, that the model has
  std::bitset<kMaxPipes> unshaped_;         ///< pipes that are left out
  std::bitset<kMaxPipes> without_texture_;  ///< pipes whose surface is not known well enough for it
  ImageNoise noise_;
  EdgeRenderer renderer_;
  EdgeSearch edge_search_;
  EdgeMemory edge_memory_;
  RackSurface surface_;
  TextureMap map_;
  PoseSolver solver_;
  PoseSolver start_solver_;

  std::vector<VisibleEdge> edges_;
  std::vector<Eigen::Vector2d> normals_;
  std::vector<SearchedSample> samples_;
  std::vector<EdgeId> searched_;  ///< of the edges that samples_ counts
  std::vector<EdgeSample> features_;
  int skipped_ = 0;  ///< edges not searched, for not knowing y
  AlignmentSearch alignment_;
  RadiusRank radius_rank_;
  std::vector<AlignmentContour> contours_;
  std::vector<AlignmentPeak> peaks_, narrowed_;
  std::vector<TriedStart> tried_;
  std::vector<std::vector<PipePlace>> places_;  ///< by pipe
  std::vector<PlacedPipes> placed_;
  geometry::Matrix6d left_by_peaks_ = geometry::Matrix6d::Zero();  ///< covariance, not told by them
  std::vector<MatchedPoint> matches_;
  std::vector<PointObservation> points_;
  std::vector<double> shifts_;  ///< m
  PoseSolution solution_;
  MapErrorBelief map_error_;  ///< before the image
  RowMotion rows_;            ///< of the image
};

}  // namespace pipescout::rack_vision
