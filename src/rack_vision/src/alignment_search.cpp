// SPDX-License-Identifier: Apache-2.0
#include "alignment_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipescout/linear_algebra/products.hpp"
#include "pipescout/linear_algebra/semidefinite.hpp"
#include "pipescout/linear_algebra/symmetric_eigen.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::Vector6d;

constexpr int kSamples = 16;                     // along a contour
constexpr double kLongestReach = 160;            // px
constexpr double kHalfStrength = 10;             // grey levels: an edge that scores one half
constexpr double kFullLength = 80;               // px: shorter contours say less
constexpr double kPerContour = 6;                // log-likelihood of a strong contour
constexpr double kDeviations = 3;                // searched
constexpr std::size_t kMostPoses = 600000;       // of a search for several peaks ...
constexpr std::size_t kMostPosesForOne = 60000;  // ... and for the best only

/// Squared motion of the contours per motion, px^2: mean over their ends.
Matrix6d mean_square_by_motion(std::span<const AlignmentContour> contours) {
  Matrix6d sum = Matrix6d::Zero();
  for (const AlignmentContour& contour : contours) {
    sum += contour.start_by_motion * contour.start_by_motion.transpose();
    sum += contour.end_by_motion * contour.end_by_motion.transpose();
  }
  return sum / static_cast<double>(2 * contours.size());
}

double pixels_apart(const Matrix6d& mean_square, const Vector6d& motion) {
  return std::sqrt(std::max(0.0, (motion.transpose() * mean_square * motion).value()));
}

/// Matrix L with covariance = L L^T; the covariance may be singular.
Matrix6d root(const Matrix6d& covariance) {
  const auto eigen = linear_algebra::symmetric_eigen(covariance);
  return eigen.vectors * eigen.values.cwiseMax(0).cwiseSqrt().asDiagonal();
}

}  // namespace

float nearest_grey(const ImageView& image, const geometry::Camera& camera,
                   const Eigen::Vector2d& ideal) noexcept {
  const Eigen::Vector2d at =
      camera.has_distortion() ? camera.distort(ideal).value_or(ideal) : ideal;
  const int u = std::clamp(static_cast<int>(at.x() + 0.5), 0, image.width - 1);
  const int v = std::clamp(static_cast<int>(at.y() + 0.5), 0, image.height - 1);
  return static_cast<float>(image.row(v)[u]);
}

Matrix6d AlignmentSearch::remaining(std::span<const AlignmentContour> contours,
                                    const Matrix6d& covariance, double step) {
  if (contours.empty()) {
    return covariance;
  }
  const Matrix6d information =
      mean_square_by_motion(contours) * static_cast<double>(contours.size()) / (step * step);
  // With covariance = L L^T: L (I + L^T A L)^-1 L^T, which needs no inverse of the covariance.
  const Matrix6d factor = root(covariance);
  const Matrix6d inner =
      Matrix6d::Identity() + linear_algebra::propagate<6, 6>(factor.transpose(), information);
  return factor * linear_algebra::solve_semidefinite<6, 6>(inner, factor.transpose());
}

void AlignmentSearch::tabulate(const ImageView& image, const AlignmentContour& contour, double step,
                               double farthest, AlignmentTable& table) {
  table.weight = kPerContour * std::min(1.0, (contour.end - contour.start).norm() / kFullLength);
  table.reach = static_cast<int>(std::ceil(std::min(farthest, kLongestReach) / step));
  const int reach = table.reach;
  const auto width = static_cast<std::size_t>(2 * reach + 1);
  const auto samples = static_cast<std::size_t>(kSamples);
  differences_.resize(samples * width);
  // Two steps more on either side: the difference is that of the means over two steps each.
  profile_.resize(width + 4);
  for (std::size_t j = 0; j < samples; ++j) {
    const double share = (static_cast<double>(j) + 0.5) / kSamples;
    const Eigen::Vector2d middle = contour.start + share * (contour.end - contour.start);
    for (std::size_t i = 0; i < profile_.size(); ++i) {
      const double offset = step * (static_cast<double>(i) - reach - 2);
      const Eigen::Vector2d ideal = middle + offset * contour.normal;
      profile_[i] = nearest_grey(image, camera_, ideal);
    }
    for (std::size_t i = 0; i < width; ++i) {
      differences_[j * width + i] =
          0.5F * (profile_[i + 4] + profile_[i + 3] - profile_[i + 1] - profile_[i]);
    }
  }
  table.scores.resize(width * width);
  const double half = kHalfStrength;
  for (int start = -reach; start <= reach; ++start) {
    for (int end = -reach; end <= reach; ++end) {
      float sum = 0;
      float place = static_cast<float>(start + reach) + 0.5F;
      const float by_sample = static_cast<float>(end - start) / static_cast<float>(kSamples);
      place += 0.5F * by_sample;
      for (std::size_t j = 0; j < samples; ++j, place += by_sample) {
        sum += differences_[j * width + static_cast<std::size_t>(place)];
      }
      const double mean = static_cast<double>(sum) / kSamples;
      const double strength =
          contour.sign == 0 ? std::abs(mean) : std::max(0.0, contour.sign * mean);
      table.scores[static_cast<std::size_t>(start + reach) * width +
                   static_cast<std::size_t>(end + reach)] =
          static_cast<float>(table.weight * strength / (strength + half));
    }
  }
}

void AlignmentSearch::choose_directions(std::span<const AlignmentContour> contours,
                                        const Matrix6d& covariance, double step,
                                        std::size_t most_poses) {
  const Matrix6d factor = root(covariance);
  const auto eigen = linear_algebra::symmetric_eigen(
      linear_algebra::propagate<6, 6>(factor.transpose(), mean_square_by_motion(contours)));
  double spacing = step;
  do {
    directions_.clear();
    std::size_t poses = 1;
    for (int k = 5; k >= 0; --k) {
      Direction direction;
      direction.motion = factor * eigen.vectors.col(k);
      direction.pixels = std::sqrt(std::max(0.0, eigen.values(k)));
      direction.steps = static_cast<int>(kDeviations * direction.pixels / spacing + 0.5);
      if (direction.steps > 0) {
        direction.by_step = direction.motion * kDeviations / direction.steps;
        poses *= static_cast<std::size_t>(2 * direction.steps + 1);
        directions_.push_back(direction);
      }
    }
    if (poses <= most_poses) {
      return;
    }
    spacing *= 1.2;
  } while (true);
}

void AlignmentSearch::search(const ImageView& image, std::span<const AlignmentContour> contours,
                             const Matrix6d& covariance, double step, double distance,
                             std::size_t most, std::vector<AlignmentPeak>& peaks) {
  peaks.clear();
  if (contours.empty()) {
    return;
  }
  choose_directions(contours, covariance, step, most > 1 ? kMostPoses : kMostPosesForOne);
  tables_.resize(std::max(tables_.size(), contours.size()));
  for (std::size_t i = 0; i < contours.size(); ++i) {
    const AlignmentContour& contour = contours[i];
    double reach = 0;
    for (const Direction& direction : directions_) {
      reach += kDeviations * std::max(std::abs(contour.start_by_motion.dot(direction.motion)),
                                      std::abs(contour.end_by_motion.dot(direction.motion)));
    }
    tabulate(image, contour, step, reach, tables_[i]);
  }
  score_all(contours, tables_, step);
  find_peaks(contours, distance, most, peaks);
}

void AlignmentSearch::search(std::span<const AlignmentContour> contours,
                             std::span<const AlignmentTable> tables, const Matrix6d& covariance,
                             double step, double distance, std::size_t most, std::size_t most_poses,
                             std::vector<AlignmentPeak>& peaks) {
  peaks.clear();
  if (contours.empty()) {
    return;
  }
  choose_directions(contours, covariance, step, most_poses);
  score_all(contours, tables, step);
  find_peaks(contours, distance, most, peaks);
}

void AlignmentSearch::find_peaks(std::span<const AlignmentContour> contours, double distance,
                                 std::size_t most, std::vector<AlignmentPeak>& peaks) const {
  const Matrix6d mean_square = mean_square_by_motion(contours);
  while (peaks.size() < most) {
    AlignmentPeak best{Vector6d::Zero(), -std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0; i < scores_.size(); ++i) {
      if (static_cast<double>(scores_[i]) <= best.score) {
        continue;
      }
      const Vector6d motion = motion_of(i);
      if (std::ranges::none_of(peaks, [&](const AlignmentPeak& peak) {
            return pixels_apart(mean_square, peak.motion - motion) < distance;
          })) {
        best = {motion, static_cast<double>(scores_[i])};
      }
    }
    if (!std::isfinite(best.score)) {
      break;
    }
    peaks.push_back(best);
  }
}

Vector6d AlignmentSearch::motion_of(std::size_t index) const {
  Vector6d motion = Vector6d::Zero();
  for (const Direction& direction : directions_) {
    const auto count = static_cast<std::size_t>(2 * direction.steps + 1);
    motion += (static_cast<double>(index % count) - direction.steps) * direction.by_step;
    index /= count;
  }
  return motion;
}

void AlignmentSearch::score_all(std::span<const AlignmentContour> contours,
                                std::span<const AlignmentTable> tables, double step) {
  std::size_t poses = 1;
  for (const Direction& direction : directions_) {
    poses *= static_cast<std::size_t>(2 * direction.steps + 1);
  }
  scores_.assign(poses, 0.0F);
  // The first direction is the innermost: along it a contour's ends move on evenly.
  const Direction still{Vector6d::Zero(), Vector6d::Zero(), 0, 0};
  const Direction& inner = directions_.empty() ? still : directions_.front();
  const auto row = static_cast<std::size_t>(2 * inner.steps + 1);
  for (std::size_t first = 0; first < poses; first += row) {
    const Vector6d begin = motion_of(first);
    float* const scores = scores_.data() + first;
    for (std::size_t i = 0; i < contours.size(); ++i) {
      const AlignmentTable& table = tables[i];
      const auto width = static_cast<std::size_t>(2 * table.reach + 1);
      const double middle = table.reach + 0.5;
      auto start = static_cast<float>(middle + contours[i].start_by_motion.dot(begin) / step);
      auto end = static_cast<float>(middle + contours[i].end_by_motion.dot(begin) / step);
      const auto start_step =
          static_cast<float>(contours[i].start_by_motion.dot(inner.by_step) / step);
      const auto end_step = static_cast<float>(contours[i].end_by_motion.dot(inner.by_step) / step);
      const auto last = static_cast<float>(width);
      for (std::size_t j = 0; j < row; ++j, start += start_step, end += end_step) {
        if (start >= 0 && end >= 0 && start < last && end < last) {
          scores[j] +=
              table.scores[static_cast<std::size_t>(start) * width + static_cast<std::size_t>(end)];
        }
      }
    }
    float deviations = 0;
    std::size_t rest = first / row;
    for (std::size_t k = 1; k < directions_.size(); ++k) {
      const Direction& direction = directions_[k];
      const auto count = static_cast<std::size_t>(2 * direction.steps + 1);
      const double z = kDeviations * (static_cast<double>(rest % count) / direction.steps - 1);
      deviations += static_cast<float>(z * z);
      rest /= count;
    }
    for (std::size_t j = 0; j < row; ++j) {
      const float z = inner.steps == 0
                          ? 0.0F
                          : static_cast<float>(kDeviations) *
                                (static_cast<float>(j) / static_cast<float>(inner.steps) - 1.0F);
      scores[j] -= 0.5F * (deviations + z * z);
    }
  }
}

}  // namespace pipescout::rack_vision
