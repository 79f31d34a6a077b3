// SPDX-License-Identifier: Apache-2.0
#include "first_pose_profile.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPlaceSigma = 0.8;      // pixels
constexpr double kFullLength = 250;      // pixels of a contour
constexpr double kMissing = 2.5;         // nats: few contours are not to be seen
constexpr double kSmallestShare = 0.05;  // of bearings with a line
constexpr double kLine = 0.35;           // clear share of a line
constexpr double kShortestLine = 100;    // pixels
constexpr std::size_t kLineReach = 3;    // bins in which one line has one maximum
constexpr double kLineWidth = 3;         // bins within a pixel of a line
constexpr double kMargin = 8;            // bins next to a contour, where shading and shadows end
constexpr double kOnPipe = 0.25;         // density of lines on pipes against that elsewhere
constexpr double kOnPipeWeight = 0.7;

/// The part of a line within the image.
std::optional<std::pair<Vector2d, Vector2d>> clipped(const Vector3d& line,
                                                     const geometry::Camera& camera) {
  const Vector2d along(-line.y(), line.x());
  const Vector2d foot = -line.z() * line.head<2>();
  const Vector2d size(camera.parameters().width - 1, camera.parameters().height - 1);
  double low = -1e9;
  double high = 1e9;
  for (int i = 0; i < 2; ++i) {
    if (std::abs(along(i)) < 1e-9) {
      if (foot(i) < 0 || foot(i) > size(i)) {
        return std::nullopt;
      }
      continue;
    }
    const double a = -foot(i) / along(i);
    const double b = (size(i) - foot(i)) / along(i);
    low = std::max(low, std::min(a, b));
    high = std::min(high, std::max(a, b));
  }
  if (!(high > low)) {
    return std::nullopt;
  }
  return std::pair(Vector2d(foot + low * along), Vector2d(foot + high * along));
}

/// What is seen along a line from border to border.
struct LineView {
  double pixels = 0;
  double share = 0;  ///< that is clear
};

LineView view_along(const SlopeImage& image, const Vector2d& start, const Vector2d& end) {
  const Vector2d whole = end - start;
  const double length = whole.norm();
  const auto count = static_cast<int>(length / kPieceLength);
  LineView view;
  for (int i = 0; i < count; ++i) {
    const Vector2d from = start + whole * (static_cast<double>(i) / count);
    const Vector2d to = start + whole * (static_cast<double>(i + 1) / count);
    if (const auto fit = image.fit(from, to, Vector2d(-whole.y(), whole.x()) / length, 0)) {
      view.pixels += length / count;
      view.share += length / count * clearness(*fit);
    }
  }
  view.share = view.pixels > 0 ? view.share / view.pixels : 0;
  return view;
}

}  // namespace

double clearness(const PieceFit& fit) noexcept {
  return std::clamp((fit.coherence - 0.4) / 0.35, 0.0, 1.0) *
         std::exp(-0.5 * fit.offset * fit.offset / (kPlaceSigma * kPlaceSigma));
}

double evidence_of_contour(double share, double pixels, double line_share) noexcept {
  const double gain = -std::log(std::max(line_share, kSmallestShare));
  return std::min(1.0, pixels / kFullLength) * (share * gain - (1 - share) * kMissing);
}

LineProfile::LineProfile(const SlopeImage& image, const geometry::Camera& camera,
                         const geometry::SO3& R_nominal)
    : bins_per_slope_(camera.parameters().focal_length) {
  const auto bins = 2 * static_cast<std::size_t>(kWidest * bins_per_slope_) + 1;
  std::vector<LineView> views(bins);
  for (std::size_t i = 0; i < bins; ++i) {
    const double slope = static_cast<double>(i) / bins_per_slope_ - kWidest;
    const Vector3d normal = R_nominal * Vector3d(-1, 0, -slope);
    Vector3d line = camera.inverse_matrix().transpose() * normal;
    const double scale = line.head<2>().norm();
    if (!(scale > 1e-12)) {
      continue;
    }
    line /= scale;
    if (const auto part = clipped(line, camera)) {
      views[i] = view_along(image, part->first, part->second);
    }
  }
  lines_.resize(bins + 1, 0);
  seen_.resize(bins + 1, 0);
  for (std::size_t i = 0; i < bins; ++i) {
    bool is_line = views[i].share > kLine && views[i].pixels > kShortestLine;
    for (std::size_t k = i > kLineReach ? i - kLineReach : 0;
         k < bins && k <= i + kLineReach && is_line; ++k) {
      is_line = views[k].share < views[i].share || (views[k].share == views[i].share && k >= i);
    }
    lines_[i + 1] = lines_[i] + (is_line ? views[i].share : 0);
    seen_[i + 1] = seen_[i] + (views[i].pixels > kShortestLine ? 1 : 0);
  }
  line_share_ = std::min(0.5, kLineWidth * lines_.back() / std::max(1.0, seen_.back()));
  for (std::size_t level = 0; level < kReach.size(); ++level) {
    std::vector<float>& out = levels_[level];
    out.resize(bins);
    const auto reach = static_cast<std::size_t>(kReach[level]);
    for (std::size_t i = 0; i < bins; ++i) {
      double share = 0;
      for (std::size_t k = i > reach ? i - reach : 0; k < bins && k <= i + reach; ++k) {
        share = std::max(share, views[k].share);
      }
      out[i] = static_cast<float>(evidence_of_contour(share, views[i].pixels, line_share_));
    }
  }
}

double LineProfile::evidence_on_pipe(double left, double right) const noexcept {
  const auto bin = [this](double slope) {
    const double at = (slope + kWidest) * bins_per_slope_ + 0.5;
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(lines_.size() - 1)));
  };
  const std::size_t from = bin(left + kMargin / bins_per_slope_);
  const std::size_t to = bin(right - kMargin / bins_per_slope_);
  if (to <= from) {
    return 0;
  }
  // A Poisson process of lines, of another density on pipes than elsewhere.
  const double expected = line_share_ / kLineWidth * (seen_[to] - seen_[from]);
  return kOnPipeWeight *
         ((1 - kOnPipe) * expected + std::log(kOnPipe) * (lines_[to] - lines_[from]));
}

}  // namespace pipescout::rack_vision::internal
