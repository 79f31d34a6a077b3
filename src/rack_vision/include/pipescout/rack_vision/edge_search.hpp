// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/image_noise.hpp"
#include "pipescout/rack_vision/image_view.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"

/// Search of the rendered edges in an image (Lippiello and Cacace, section III and Figure 3, left):
/// from each sample of an edge, along the normal. Beyond the paper: subpixel positions, several
/// candidates per sample, and an appearance model of each edge.
namespace pipescout::rack_vision {

struct EdgeSearchParameters {
  int samples_per_edge = 20;  ///< 2..100, at j / (N + 1), as in the paper; supports: a third
  /// px, 0.6..4: of the Gaussian whose derivative finds the edge; about the blur of the image.
  double filter_sigma = 1.2;
  /// Grey levels across an edge, > 0: smaller steps are noise, up to kNominalNoise. Above it, those
  /// that noise makes by chance are.
  double least_contrast = 7.0;
  /// Candidates weaker than this share of the strongest along the same normal are ignored, 0..1.
  double least_share = 0.25;
  double row_time = 0;  ///< s, 0..1e-3: see RowMotion

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

inline constexpr int kMaxEdgeCandidates = 3;
inline constexpr double kLongestSearch = 60.0;  ///< px to either side

/// A step in grey level on the normal of a sample.
struct EdgeCandidate {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< ideal: as without distortion
  double distance = 0;                              ///< px along the normal, of the ideal image
  double contrast = 0;                              ///< grey levels: outside minus inside
  double sigma = 0;                                 ///< ideal px, of `distance`, noise included
  double noise_sigma = 0;                           ///< ideal px, what image noise makes of it
};

struct SearchedSample {
  std::uint32_t edge = 0;  ///< index into the searched edges
  Eigen::Vector2d place;   ///< on the rendered edge, ideal pixel
  Eigen::Vector2d normal;  ///< unit vector, away from the pipe; supports: see `edge_normal`
  /// Ideal px across the edge to a px of the image: 1 but for a lens with distortion.
  double ideal_per_pixel = 1;
  bool searched = false;  ///< false: too near to the border of the image
  /// px: of the candidates, from the velocity by which they are corrected for the time of their
  /// rows; common to all samples of an image.
  double motion_sigma = 0;
  int count = 0;  ///< number of candidates, ordered by plausibility, best first
  std::array<EdgeCandidate, kMaxEdgeCandidates> candidates;
};

/// Velocity of an edge along its normal in the ideal image, at its start and at its end; in between
/// it changes linearly.
struct EdgeMotion {
  Eigen::Vector2d speed = Eigen::Vector2d::Zero();       ///< px/s
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of `speed`, px^2/s^2
};

/// Unit normal of an edge in the ideal image: for a pipe it points away from the pipe, for a
/// support to the left of the direction from its start to its end.
[[nodiscard]] Eigen::Vector2d edge_normal(const VisibleEdge& edge, const Pipe* pipe,
                                          const geometry::SE3& T_camera_rack,
                                          const geometry::Camera& camera) noexcept;

/// Appearance of each edge of a rack: sign and size of its step. Estimated from inlier samples with
/// exponential forgetting, because the light changes.
class EdgeMemory {
 public:
  explicit EdgeMemory(const RackModel& model);

  struct Look {
    double contrast = 0;   ///< mean of outside minus inside, grey levels
    double spread = 0;     ///< standard deviation of it
    double samples = 0;    ///< effective number, with forgetting
    double agreement = 0;  ///< share of the samples that have the sign of `contrast`, 0.5..1
    /// Whether the sign of a candidate shows that it is another edge.
    [[nodiscard]] bool decides_sign() const noexcept { return is_known() && agreement > 0.85; }
    [[nodiscard]] bool is_known() const noexcept { return samples >= 10; }
    /// Estimated from several images.
    [[nodiscard]] bool is_established() const noexcept { return samples >= 100; }
  };

  [[nodiscard]] const Look& look(const EdgeId& id) const noexcept;
  void learn(const EdgeId& id, double contrast) noexcept;
  /// Resets the model.
  void clear() noexcept;

 private:
  [[nodiscard]] std::size_t index(const EdgeId& id) const noexcept;

  std::vector<std::size_t> first_of_pipe_;
  std::size_t first_of_supports_ = 0;
  std::vector<Look> looks_;
};

class LimbPair;
class LimbProfile;

/// Searches edges in images of one camera. Allocates only until the longest list has occurred.
class EdgeSearch {
 public:
  /// Throws std::invalid_argument as EdgeSearchParameters::validate.
  EdgeSearch(const geometry::Camera& camera, const EdgeSearchParameters& parameters);
  ~EdgeSearch();
  EdgeSearch(EdgeSearch&&) noexcept;
  EdgeSearch& operator=(EdgeSearch&&) noexcept;

  /// Sets another camera of the same image size.
  void set_camera(const geometry::Camera& camera) { camera_ = camera; }

  /// Sets the noise of the images that are searched next; none before.
  void set_noise(const ImageNoise& noise) noexcept { noise_ = noise; }

  /// Appends the samples of one visible edge. `range`: px to either side of it, limited to
  /// kLongestSearch. Samples whose normal leaves the image are searched up to its border. With a
  /// row time, each is searched where its row sees the edge, which moves by `motion`, and its
  /// candidates are where the middle row would have seen them.
  void search(const ImageView& image, const VisibleEdge& edge, std::uint32_t index,
              const Eigen::Vector2d& normal, double range, const EdgeMemory::Look& look,
              std::vector<SearchedSample>& samples, const EdgeMotion& motion = {});

  /// s from the exposure of the middle row to that of the row in which an ideal pixel is seen; 0
  /// where it is not seen.
  [[nodiscard]] double instant(const Eigen::Vector2d& ideal) const noexcept;

 private:
  void search_sample(const ImageView& image, double range, bool round, const EdgeMemory::Look& look,
                     SearchedSample& sample);
  void candidates_along(const ImageView& image, const Eigen::Vector2d& middle,
                        const Eigen::Vector2d& direction, double scale, double range, bool round,
                        const EdgeMemory::Look& look, SearchedSample& sample);

  geometry::Camera camera_;
  EdgeSearchParameters parameters_;
  ImageNoise noise_;
  std::unique_ptr<LimbProfile> limb_;
  std::unique_ptr<LimbPair> limb_pair_;
  std::vector<float> filter_;  ///< odd half: weights of profile(t + i) - profile(t - i), i = 1...
  double contrast_per_response_ = 1;
  /// Noise of a contrast, and of a place times its contrast, per noise of a value of the profile.
  double contrast_noise_ = 1;
  double place_noise_ = 1;
};

}  // namespace pipescout::rack_vision
