// SPDX-License-Identifier: Apache-2.0
#include "row_placement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipescout::rack_vision {
namespace {

constexpr int kSamplesAlong = 24;
constexpr double kHalf = 10;         // grey levels: an edge that scores one half
constexpr double kWhole = 80;        // px: shorter contours say less
constexpr double kOfContour = 6;     // log-likelihood of a strong contour
constexpr double kStepPixels = 1.0;  // px, of offsets
constexpr std::size_t kMostSteps = 400;
constexpr double kElsewhere = 6.0;     // px, between offsets that are not the same one
constexpr double kNearlyAsWell = 4.0;  // log-likelihood
constexpr double kOverlap = 0.005;     // m, of neighbours: radii are not exact
constexpr double kShort = 8;           // px

float grey_near(const ImageView& image, const Eigen::Vector2d& at) {
  const int u = std::clamp(static_cast<int>(at.x() + 0.5), 0, image.width - 1);
  const int v = std::clamp(static_cast<int>(at.y() + 0.5), 0, image.height - 1);
  return static_cast<float>(image.row(v)[u]);
}

}  // namespace

RowPlacement::RowPlacement(const RackModel& model, const geometry::Camera& camera)
    : model_(model), camera_(camera) {
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    const Eigen::Vector3d& direction = model_.pipes[i].direction;
    if (model_.pipes[i].movable && std::abs(direction.y()) > std::abs(direction.x())) {
      order_.push_back(i);
    }
  }
  std::ranges::stable_sort(order_, {}, [this](std::size_t i) { return model_.pipes[i].start.x(); });
  lanes_.resize(order_.size());
}

double RowPlacement::strength_at(const ImageView& image, const MovingContour& contour,
                                 double shift) const {
  float sum = 0;
  for (int j = 0; j < kSamplesAlong; ++j) {
    const double share = (j + 0.5) / kSamplesAlong;
    const double along = shift * (contour.start_by_offset +
                                  share * (contour.end_by_offset - contour.start_by_offset));
    const Eigen::Vector2d middle =
        contour.start + share * (contour.end - contour.start) + along * contour.normal;
    const auto grey = [&](double aside) {
      const Eigen::Vector2d ideal = middle + aside * contour.normal;
      return grey_near(image,
                       camera_.has_distortion() ? camera_.distort(ideal).value_or(ideal) : ideal);
    };
    sum += 0.5F * (grey(1.5) + grey(0.5) - grey(-0.5) - grey(-1.5));
  }
  const double strength = std::abs(static_cast<double>(sum)) / kSamplesAlong;
  const double weight = kOfContour * std::min(1.0, (contour.end - contour.start).norm() / kWhole);
  return weight * strength / (strength + kHalf);
}

void RowPlacement::sample(const ImageView& image, std::span<const MovingContour> contours,
                          double offset, Lane& lane) {
  for (std::size_t k = 0; k < lane.strength.size(); ++k) {
    const double shift = lane.first + static_cast<double>(k) * lane.step - offset;
    double sum = 0;
    for (const MovingContour& contour : contours) {
      if (contour.pipe == lane.pipe && (contour.end - contour.start).norm() >= kShort) {
        sum += strength_at(image, contour, shift);
      }
    }
    lane.strength[k] = sum;
  }
}

double RowPlacement::least_distance(std::size_t left, std::size_t right) const {
  const double radii = model_.pipes[left].largest_radius() + model_.pipes[right].largest_radius();
  const double rise = model_.pipes[left].start.z() - model_.pipes[right].start.z();
  return std::sqrt(std::max(0.0, radii * radii - rise * rise)) - kOverlap;
}

void RowPlacement::search(const ImageView& image, std::span<const MovingContour> contours,
                          const std::array<double, kMaxPipes>& offsets,
                          const std::bitset<kMaxPipes>& searched,
                          const std::array<double, kMaxPipes>& reach, const OffsetBelief& prior,
                          std::size_t most, std::vector<RowPlaces>& places) {
  places.clear();
  used_ = 0;
  for (const std::size_t pipe : order_) {
    double by_offset = 0;  // px/m
    for (const MovingContour& contour : contours) {
      if (contour.pipe == pipe) {
        by_offset = std::max(
            {by_offset, std::abs(contour.start_by_offset), std::abs(contour.end_by_offset)});
      }
    }
    if (!searched[pipe] || by_offset <= 0) {
      continue;
    }
    Lane& lane = lanes_[used_++];
    lane.pipe = pipe;
    const double wanted = 2 * reach[pipe] * by_offset / kStepPixels;
    const auto steps = 1 + 2 * static_cast<std::size_t>(
                                   std::min(0.5 * wanted, 0.5 * static_cast<double>(kMostSteps)));
    lane.step = steps > 1 ? 2 * reach[pipe] / static_cast<double>(steps - 1) : reach[pipe];
    lane.first = offsets[pipe] - lane.step * static_cast<double>(steps / 2);
    lane.strength.resize(steps);
    lane.score.resize(steps);
    lane.best.resize(steps);
    lane.from.resize(steps);
    sample(image, contours, offsets[pipe], lane);
    const auto row = static_cast<Eigen::Index>(pipe);
    const double variance = prior.covariance(row, row);
    for (std::size_t k = 0; k < steps; ++k) {
      const double off = lane.first + static_cast<double>(k) * lane.step - prior.mean[pipe];
      lane.score[k] = lane.strength[k] - (variance > 0 ? 0.5 * off * off / variance : 0.0);
    }
  }
  places.push_back(best_places(offsets, -1, 0));
  const RowPlaces best = places.front();
  for (std::size_t i = 0; i < used_ && most > 1; ++i) {
    const RowPlaces other = best_places(offsets, static_cast<int>(i), best.offsets[lanes_[i].pipe]);
    if (other.score > best.score - kNearlyAsWell) {
      places.push_back(other);
    }
  }
  std::ranges::stable_sort(places, std::greater<>{}, &RowPlaces::score);
  places.resize(std::min(places.size(), most));
}

RowPlaces RowPlacement::best_places(const std::array<double, kMaxPipes>& offsets, int barred_lane,
                                    double barred_offset) {
  constexpr double kNever = -1e9;
  const auto x_of = [this](std::size_t pipe) { return model_.pipes[pipe].start.x(); };
  for (std::size_t i = 0; i < used_; ++i) {
    Lane& lane = lanes_[i];
    const bool barred = static_cast<int>(i) == barred_lane;
    for (std::size_t k = 0; k < lane.score.size(); ++k) {
      const double offset = lane.first + static_cast<double>(k) * lane.step;
      const bool is_barred = barred && std::abs(offset - barred_offset) < kElsewhere * lane.step;
      lane.best[k] = is_barred ? kNever : lane.score[k];
      lane.from[k] = -1;
      if (i == 0) {
        continue;
      }
      const Lane& before = lanes_[i - 1];
      // Of the lane before: those far enough to the left.
      const double limit =
          x_of(lane.pipe) + offset - least_distance(before.pipe, lane.pipe) - x_of(before.pipe);
      double most = kNever;
      for (std::size_t j = 0; j < before.best.size(); ++j) {
        if (before.first + static_cast<double>(j) * before.step > limit) {
          break;
        }
        if (before.best[j] > most) {
          most = before.best[j];
          lane.from[k] = static_cast<int>(j);
        }
      }
      lane.best[k] += most;
    }
  }
  RowPlaces result;
  result.offsets = offsets;
  if (used_ == 0) {
    return result;
  }
  const Lane& last = lanes_[used_ - 1];
  auto at = static_cast<int>(std::ranges::max_element(last.best) - last.best.begin());
  result.score = last.best[static_cast<std::size_t>(at)];
  for (std::size_t i = used_; i-- > 0 && at >= 0;) {
    const Lane& lane = lanes_[i];
    result.offsets[lane.pipe] = lane.first + at * lane.step;
    at = lane.from[static_cast<std::size_t>(at)];
  }
  return result;
}

double RowPlacement::better_elsewhere(std::size_t pipe) const noexcept {
  for (std::size_t i = 0; i < used_; ++i) {
    const Lane& lane = lanes_[i];
    if (lane.pipe != pipe) {
      continue;
    }
    const std::size_t middle = lane.strength.size() / 2;
    double here = 0;
    double best = 0;
    for (std::size_t k = 0; k < lane.strength.size(); ++k) {
      const double away = std::abs(static_cast<double>(k) - static_cast<double>(middle));
      best = std::max(best, lane.strength[k]);
      if (away <= kElsewhere) {
        here = std::max(here, lane.strength[k]);
      }
    }
    return best - here;
  }
  return 0;
}

}  // namespace pipescout::rack_vision
