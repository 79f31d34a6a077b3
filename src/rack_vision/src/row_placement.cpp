// SPDX-License-Identifier: Apache-2.0
#include "row_placement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipescout/rack_vision/visible_edges.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr int kParts = 8;  // of a contour
constexpr int kSamplesOfPart = 6;
constexpr float kMost = 30;          // grey levels: of a sample; texture has stronger edges
constexpr double kHalf = 10;         // grey levels: an edge that scores one half
constexpr double kWhole = 80;        // px: shorter contours say less
constexpr double kShort = 8;         // px: these say nothing
constexpr double kOfEdge = 6;        // log-likelihood of a strong contour ...
constexpr double kNowhere = -2;      // ... and of none at all: what lies anywhere scores about 0
constexpr double kStepPixels = 1.0;  // px, of offsets
constexpr std::size_t kMostSteps = 401;
constexpr double kElsewhere = 6.0;    // px, between offsets that are not the same one
constexpr double kOverlap = 0.005;    // m, of neighbours: radii are not exact
constexpr double kLeastHeight = 0.5;  // m
constexpr double kNever = -1e9;

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
    if (std::abs(direction.y()) > std::abs(direction.x())) {
      order_.push_back(i);
    }
  }
  std::ranges::stable_sort(order_, {}, [this](std::size_t i) { return model_.pipes[i].start.x(); });
  lanes_.resize(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) {
    lanes_[i].pipe = order_[i];
    lanes_[i].score.reserve(kMostSteps);
    lanes_[i].both.reserve(kMostSteps);
    lanes_[i].best.reserve(kMostSteps);
    lanes_[i].from.reserve(kMostSteps);
  }
  sections_.reserve(kMaxSections);
}

double RowPlacement::contour_score(const ImageView& image, const Eigen::Vector2d& start,
                                   const Eigen::Vector2d& end) const {
  const Eigen::Vector2d along = (end - start).normalized();
  const Eigen::Vector2d normal(along.y(), -along.x());
  // Rust and shadows change the sign of the difference from one part of a contour to the next.
  float sum = 0;
  for (int part = 0; part < kParts; ++part) {
    float of_part = 0;
    for (int j = 0; j < kSamplesOfPart; ++j) {
      const double share = (part + (j + 0.5) / kSamplesOfPart) / kParts;
      const Eigen::Vector2d middle = start + share * (end - start);
      const auto grey = [&](double aside) {
        const Eigen::Vector2d ideal = middle + aside * normal;
        return grey_near(image,
                         camera_.has_distortion() ? camera_.distort(ideal).value_or(ideal) : ideal);
      };
      of_part +=
          std::clamp(0.5F * (grey(1.5) + grey(0.5) - grey(-0.5) - grey(-1.5)), -kMost, kMost);
    }
    sum += std::abs(of_part) / kSamplesOfPart;
  }
  const double strength = static_cast<double>(sum) / kParts;
  return std::min(1.0, (end - start).norm() / kWhole) *
         (kNowhere + kOfEdge * strength / (strength + kHalf));
}

void RowPlacement::fill(const ImageView& image, const ImageWindow& window, Lane& lane) {
  lane.seen = false;
  for (std::size_t k = 0; k < lane.score.size(); ++k) {
    sections_.clear();
    append_sections(model_.pipes[lane.pipe], lane.offset(k), sections_);
    std::array<double, 2> length{};
    double sum = 0;
    for (const PipeSection& section : sections_) {
      ContourLine lines[2];
      if (!contour_lines(section, window.eye(), lines)) {
        continue;
      }
      for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
        Eigen::Vector3d start = lines[side].start - window.eye();
        Eigen::Vector3d end = lines[side].end - window.eye();
        if (!window.clip(start, end)) {
          continue;
        }
        const Eigen::Vector2d first = window.pixel(start);
        const Eigen::Vector2d last = window.pixel(end);
        if ((last - first).norm() >= kShort) {
          length[side] += (last - first).norm();
          sum += contour_score(image, first, last);
        }
      }
    }
    lane.score[k] = sum;
    lane.both[k] = std::min(length[0], length[1]) >= 0.5 * kWhole;
    lane.seen = lane.seen || length[0] > 0 || length[1] > 0;
  }
}

std::optional<double> RowPlacement::least_distance(std::size_t left, std::size_t right) const {
  const double radii = model_.pipes[left].largest_radius() + model_.pipes[right].largest_radius();
  const double rise = model_.pipes[left].start.z() - model_.pipes[right].start.z();
  if (std::abs(rise) >= radii) {
    return std::nullopt;
  }
  return std::sqrt(radii * radii - rise * rise) - kOverlap;
}

void RowPlacement::search(const ImageView& image, const geometry::SE3& T_camera_rack,
                          const std::array<double, kMaxPipes>& offsets,
                          const std::bitset<kMaxPipes>& searched,
                          const std::array<double, kMaxPipes>& reach, const OffsetBelief& prior) {
  const ImageWindow window(camera_, T_camera_rack);
  for (Lane& lane : lanes_) {
    const double height =
        std::max(kLeastHeight, std::abs(window.eye().z() - model_.pipes[lane.pipe].start.z()));
    lane.pixel = height / camera_.matrix()(0, 0);
    const double wanted = searched[lane.pipe] ? reach[lane.pipe] / (kStepPixels * lane.pixel) : 0.0;
    const auto half = static_cast<std::size_t>(std::min(std::ceil(wanted), 0.5 * kMostSteps - 0.5));
    lane.step = half > 0 ? reach[lane.pipe] / static_cast<double>(half) : lane.pixel;
    lane.first = offsets[lane.pipe] - static_cast<double>(half) * lane.step;
    const std::size_t steps = 2 * half + 1;
    lane.score.assign(steps, 0);
    lane.both.assign(steps, false);
    lane.best.resize(steps);
    lane.from.resize(steps);
    if (half == 0) {
      lane.seen = false;
      continue;
    }
    fill(image, window, lane);
    const auto row = static_cast<Eigen::Index>(lane.pipe);
    const double variance = prior.covariance(row, row);
    for (std::size_t k = 0; k < steps && variance > 0; ++k) {
      lane.score[k] -= 0.5 * std::pow(lane.offset(k) - prior.mean[lane.pipe], 2) / variance;
    }
  }
  places_ = offsets;
  best_ = best_row(nullptr, &places_);
}

double RowPlacement::best_row(const Limit* limit, std::array<double, kMaxPipes>* offsets) {
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    Lane& lane = lanes_[i];
    const bool limited = limit != nullptr && limit->lane == i;
    Lane const* before = i > 0 ? &lanes_[i - 1] : nullptr;
    const auto distance =
        before != nullptr ? least_distance(before->pipe, lane.pipe) : std::optional<double>();
    const double gap = before != nullptr
                           ? model_.pipes[lane.pipe].start.x() -
                                 model_.pipes[before->pipe].start.x() - distance.value_or(0)
                           : 0;
    // Of the lane before: the best of those far enough to the left.
    std::size_t next = 0;
    int best_before = -1;
    for (std::size_t k = 0; k < lane.score.size(); ++k) {
      const bool near =
          limited && std::abs(lane.offset(k) - limit->offset) < kElsewhere * lane.pixel;
      lane.best[k] = limited && near != limit->within ? kNever : lane.score[k];
      lane.from[k] = -1;
      if (before == nullptr) {
        continue;
      }
      while (next < before->best.size() &&
             (!distance || before->offset(next) <= lane.offset(k) + gap)) {
        if (best_before < 0 ||
            before->best[next] > before->best[static_cast<std::size_t>(best_before)]) {
          best_before = static_cast<int>(next);
        }
        ++next;
      }
      lane.from[k] = best_before;
      lane.best[k] +=
          best_before < 0 ? kNever : before->best[static_cast<std::size_t>(best_before)];
    }
  }
  if (lanes_.empty()) {
    return 0;
  }
  const Lane& last = lanes_.back();
  auto at = static_cast<int>(std::ranges::max_element(last.best) - last.best.begin());
  const double result = last.best[static_cast<std::size_t>(at)];
  for (std::size_t i = lanes_.size(); offsets != nullptr && i-- > 0 && at >= 0;) {
    const Lane& lane = lanes_[i];
    (*offsets)[lane.pipe] = lane.offset(static_cast<std::size_t>(at));
    at = lane.from[static_cast<std::size_t>(at)];
  }
  return result;
}

std::optional<std::size_t> RowPlacement::lane_of(std::size_t pipe) const {
  const auto found = std::ranges::find(lanes_, pipe, &Lane::pipe);
  if (found == lanes_.end() || !found->seen || best_ <= 0.5 * kNever) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(found - lanes_.begin());
}

PipePlace RowPlacement::place(std::size_t pipe) {
  PipePlace result{.offset = places_[pipe]};
  if (const auto index = lane_of(pipe)) {
    const Lane& lane = lanes_[*index];
    const auto at = static_cast<std::size_t>(std::lround((result.offset - lane.first) / lane.step));
    result.both_in_view = lane.both[at];
    const Limit limit{.lane = *index, .offset = result.offset, .within = false};
    result.margin = best_ - best_row(&limit, nullptr);
  }
  return result;
}

double RowPlacement::better_elsewhere(std::size_t pipe, double offset) {
  const auto index = lane_of(pipe);
  if (!index) {
    return 0;
  }
  const Limit limit{.lane = *index, .offset = offset, .within = true};
  return best_ - best_row(&limit, nullptr);
}

}  // namespace pipescout::rack_vision
