// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/edge_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "bilinear.hpp"
#include "limb_pair.hpp"
#include "limb_profile.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr int kMostTaps = 12;
constexpr int kLongestProfile = 2 * static_cast<int>(kLongestSearch) + 2 * kMostTaps + 8;
// Mean over this far to both sides along the edge: halves what noise and texture do to a sample.
constexpr double kSideStep = 2.0;
constexpr int kSideSteps = 2;
constexpr int kMostSideSteps = 5;  // in noise: samples of an edge are this far from each other
constexpr std::size_t kMostBeside = 2 * kMostSideSteps + 1;
constexpr double kNoisy = 5.0;       // grey levels
constexpr double kNoiseGate = 3.0;   // deviations of a step that is not noise
constexpr double kImageBlur = 0.88;  // px: a good lens, the pixels' own size, the interpolation
constexpr int kSupportShare = 3;
constexpr double kStepSigma = 0.1;  // px, of a plain step

struct Span {
  int first = 0;
  int last = -1;
};

/// Whole steps t of first..last for which `start + t direction` keeps within [low, high].
void clip(double start, double direction, double low, double high, Span& span) noexcept {
  if (std::abs(direction) < 1e-9) {
    if (start < low || start > high) {
      span.last = span.first - 1;
    }
    return;
  }
  const double a = (low - start) / direction;
  const double b = (high - start) / direction;
  span.first = std::max(span.first, static_cast<int>(std::ceil(std::min(a, b))));
  span.last = std::min(span.last, static_cast<int>(std::floor(std::max(a, b))));
}

/// Place of the peak of |r| between the neighbours, -0.5..0.5: a parabola through the logarithms,
/// which is exact for the Gaussian that a blurred step leaves.
double peak_offset(float before, float at, float after) noexcept {
  const double a = std::abs(static_cast<double>(before));
  const double b = std::abs(static_cast<double>(at));
  const double c = std::abs(static_cast<double>(after));
  const bool one_sign = before * at > 0 && after * at > 0;
  const double x = one_sign && a > 0.05 * b && c > 0.05 * b ? std::log(a) : a;
  const double y = x == a ? b : std::log(b);
  const double z = x == a ? c : std::log(c);
  const double bend = x - 2 * y + z;
  return bend < 0 ? std::clamp(0.5 * (x - z) / bend, -0.5, 0.5) : 0.0;
}

}  // namespace

void EdgeSearchParameters::validate() const {
  validation::check_within("samples_per_edge", samples_per_edge, 2, 100);
  validation::check_within("filter_sigma", filter_sigma, 0.6, 4.0);
  validation::check_within("least_contrast", least_contrast, 0.1, 255.0);
  validation::check_within("least_share", least_share, 0.0, 1.0);
  validation::check_within("row_time", row_time, 0.0, 1e-3);
}

Eigen::Vector2d edge_normal(const VisibleEdge& edge, const Pipe* pipe,
                            const geometry::SE3& T_camera_rack,
                            const geometry::Camera& camera) noexcept {
  const Eigen::Vector2d along = (edge.image_end - edge.image_start).normalized();
  const Eigen::Vector2d left(along.y(), -along.x());  // v points down
  if (pipe == nullptr) {
    return left;
  }
  const Eigen::Vector3d middle = 0.5 * (edge.start + edge.end);
  const Eigen::Vector3d axis =
      pipe->start + pipe->direction * pipe->direction.dot(middle - pipe->start);
  const Eigen::Vector3d inside = camera.matrix() * (T_camera_rack * axis);
  const Eigen::Vector2d towards =
      inside.head<2>() / inside.z() - 0.5 * (edge.image_start + edge.image_end);
  return left.dot(towards) > 0 ? Eigen::Vector2d(-left) : left;
}

EdgeMemory::EdgeMemory(const RackModel& model) {
  std::size_t next = 0;
  for (const Pipe& pipe : model.pipes) {
    first_of_pipe_.push_back(next);
    next += 2 * pipe.radii.size();
  }
  first_of_supports_ = next;
  looks_.resize(next + 12 * model.supports.size());
}

std::size_t EdgeMemory::index(const EdgeId& id) const noexcept {
  return id.kind == EdgeKind::kPipe ? first_of_pipe_[id.body] + 2U * id.part + id.side
                                    : first_of_supports_ + 12U * id.body + id.part;
}

const EdgeMemory::Look& EdgeMemory::look(const EdgeId& id) const noexcept {
  return looks_[index(id)];
}

void EdgeMemory::learn(const EdgeId& id, double contrast) noexcept {
  constexpr double kRemembered = 200;  // samples: about ten images of one edge
  Look& look = looks_[index(id)];
  look.samples = std::min(look.samples + 1, kRemembered);
  const double weight = 1 / look.samples;
  const double before = contrast - look.contrast;
  look.contrast += weight * before;
  const double variance =
      (1 - weight) * look.spread * look.spread + weight * before * (contrast - look.contrast);
  look.spread = std::sqrt(std::max(0.0, variance));
  const bool same_sign = contrast * look.contrast > 0;
  look.agreement += weight * ((same_sign ? 1.0 : 0.0) - look.agreement);
}

void EdgeMemory::clear() noexcept {
  std::ranges::fill(looks_, Look{});
}

EdgeSearch::EdgeSearch(const geometry::Camera& camera, const EdgeSearchParameters& parameters)
    : camera_(camera),
      parameters_(parameters),
      limb_(std::make_unique<LimbProfile>(kImageBlur)),
      limb_pair_(std::make_unique<LimbPair>(kImageBlur)) {
  parameters.validate();
  const double sigma = parameters.filter_sigma;
  const int taps = std::min(kMostTaps, static_cast<int>(std::ceil(3 * sigma)));
  double slope = 0;
  for (int i = 1; i <= taps; ++i) {
    const double weight = i * std::exp(-0.5 * i * i / (sigma * sigma));
    filter_.push_back(static_cast<float>(weight));
    slope += 2 * i * weight;
  }
  for (float& weight : filter_) {
    weight = static_cast<float>(weight / slope);  // a ramp of slope 1 gives 1
  }
  const double squared_blur = sigma * sigma + kImageBlur * kImageBlur;
  contrast_per_response_ = std::sqrt(2 * std::numbers::pi * squared_blur);
  // The response to white noise has the variance of the filter's weights, its slope that of their
  // differences; and a step's response is curved by its contrast over the squared blur.
  double squares = 0;
  double squared_slopes = 0;
  const auto weight_at = [&](int i) {
    const auto size = static_cast<std::size_t>(std::abs(i));
    return i == 0 || std::abs(i) > taps ? 0.0
                                        : std::copysign(static_cast<double>(filter_[size - 1]), i);
  };
  for (int i = -taps - 1; i <= taps + 1; ++i) {
    squares += weight_at(i) * weight_at(i);
    squared_slopes += std::pow(0.5 * (weight_at(i + 1) - weight_at(i - 1)), 2);
  }
  contrast_noise_ = contrast_per_response_ * std::sqrt(squares);
  place_noise_ = contrast_per_response_ * squared_blur * std::sqrt(squared_slopes);
}

EdgeSearch::~EdgeSearch() = default;
EdgeSearch::EdgeSearch(EdgeSearch&&) noexcept = default;
EdgeSearch& EdgeSearch::operator=(EdgeSearch&&) noexcept = default;

void EdgeSearch::candidates_along(const ImageView& image, const Eigen::Vector2d& middle,
                                  const Eigen::Vector2d& direction, double scale, double range,
                                  bool round, const EdgeMemory::Look& look,
                                  SearchedSample& sample) {
  const int taps = static_cast<int>(filter_.size());
  const int reach = static_cast<int>(std::ceil(range * scale)) + 1;
  Span span{-(reach + std::max(taps, kLimbInside)), reach + std::max(taps, kLimbOutside)};
  const Eigen::Vector2d side = kSideStep * Eigen::Vector2d(-direction.y(), direction.x());
  const double level = image.row(
      std::clamp(static_cast<int>(middle.y()), 0,
                 image.height - 1))[std::clamp(static_cast<int>(middle.x()), 0, image.width - 1)];
  const int sides = noise_.excess(level) > kNoisy ? kMostSideSteps : kSideSteps;
  const auto beside = static_cast<std::size_t>(2 * sides + 1);
  const Eigen::Vector2d low = sides * side.cwiseAbs();
  clip(middle.x(), direction.x(), low.x(), image.width - 1.001 - low.x(), span);
  clip(middle.y(), direction.y(), low.y(), image.height - 1.001 - low.y(), span);
  const int length = span.last - span.first + 1;
  if (length < 2 * taps + 3 || length > kLongestProfile) {
    return;
  }
  sample.searched = true;
  BilinearSamples<kMostBeside * kLongestProfile> samples;
  for (int j = -sides; j <= sides; ++j) {
    samples.add_line(middle, direction, j * side, span.first, length);
  }
  std::array<float, kMostBeside * kLongestProfile> values;
  samples.read(image, values);
  std::array<float, kLongestProfile> profile;
  Eigen::Map<Eigen::ArrayXf> means(profile.data(), length);
  means.setZero();
  for (std::size_t j = 0; j < beside; ++j) {
    means += Eigen::Map<const Eigen::ArrayXf>(values.data() + j * static_cast<std::size_t>(length),
                                              length);
  }
  means /= static_cast<float>(beside);
  // Of a value of the profile: what is beyond the usual noise.
  const double noise =
      noise_.excess(static_cast<double>(means.mean())) / std::sqrt(static_cast<double>(beside));
  std::array<float, kLongestProfile> response{};
  for (int j = 0; j < taps; ++j) {
    const float weight = filter_[static_cast<std::size_t>(j)];
    for (int i = taps; i < length - taps; ++i) {
      response[static_cast<std::size_t>(i)] +=
          weight * (profile[static_cast<std::size_t>(i + j + 1)] -
                    profile[static_cast<std::size_t>(i - j - 1)]);
    }
  }
  const float strongest =
      Eigen::Map<const Eigen::ArrayXf>(response.data(), length).abs().maxCoeff();
  const double least =
      std::max(std::max(parameters_.least_contrast, kNoiseGate * contrast_noise_ * noise) /
                   contrast_per_response_,
               parameters_.least_share * static_cast<double>(strongest));
  std::array<double, kMaxEdgeCandidates> scores{};
  std::array<int, kMaxEdgeCandidates> peaks{};
  for (int i = taps + 1; i < length - taps - 1; ++i) {
    const float at = response[static_cast<std::size_t>(i)];
    const float before = response[static_cast<std::size_t>(i - 1)];
    const float after = response[static_cast<std::size_t>(i + 1)];
    const double size = std::abs(static_cast<double>(at));
    // Peaks of either sign; a neighbour of the other sign is no rival.
    if (size < least || (before * at > 0 && std::abs(before) > std::abs(at)) ||
        (after * at > 0 && std::abs(after) >= std::abs(at))) {
      continue;
    }
    const double contrast = static_cast<double>(at) * contrast_per_response_;
    if (look.decides_sign() && contrast * look.contrast < 0) {
      continue;
    }
    const double distance = (span.first + i + peak_offset(before, at, after)) / scale;
    if (std::abs(distance) > range) {
      continue;
    }
    double score = size;
    if (look.is_known()) {
      // How unlike it is to what the edge looked like, in sigmas, tempered: light changes.
      const double spread = look.spread + 0.15 * std::abs(look.contrast) + 2;
      score = std::exp(-0.5 * std::pow((contrast - look.contrast) / spread, 2)) + 1e-6 * size;
    }
    int place = sample.count;
    while (place > 0 && score > scores[static_cast<std::size_t>(place - 1)]) {
      --place;
    }
    if (place == kMaxEdgeCandidates) {
      continue;
    }
    sample.count = std::min(sample.count + 1, kMaxEdgeCandidates);
    for (int j = sample.count - 1; j > place; --j) {
      scores[static_cast<std::size_t>(j)] = scores[static_cast<std::size_t>(j - 1)];
      peaks[static_cast<std::size_t>(j)] = peaks[static_cast<std::size_t>(j - 1)];
      sample.candidates[static_cast<std::size_t>(j)] =
          sample.candidates[static_cast<std::size_t>(j - 1)];
    }
    scores[static_cast<std::size_t>(place)] = score;
    peaks[static_cast<std::size_t>(place)] = i;
    const double by_noise = place_noise_ * noise / std::abs(contrast) / scale;
    sample.candidates[static_cast<std::size_t>(place)] = {
        .pixel = Eigen::Vector2d::Zero(),
        .distance = distance,
        .contrast = contrast,
        .sigma = std::hypot(kStepSigma / scale, by_noise),
        .noise_sigma = by_noise};
  }
  const auto set_place = [&](EdgeCandidate& candidate, double distance) {
    candidate.distance = distance;
    const Eigen::Vector2d pixel = middle + distance * scale * direction;
    candidate.pixel =
        camera_.has_distortion()
            ? camera_.undistort(pixel).value_or(sample.place + distance * sample.normal)
            : pixel;
  };
  for (std::size_t j = 0, found = static_cast<std::size_t>(sample.count); j < found; ++j) {
    EdgeCandidate& candidate = sample.candidates[j];
    const int first = peaks[j] - kLimbInside;
    if (!round || first < 0 || first + kLimbWindow > length) {
      set_place(candidate, candidate.distance);
      continue;
    }
    const LimbWindow window(profile.data() + first, static_cast<std::size_t>(kLimbWindow));
    const LimbProfile::Fit fit = limb_->fit(window);
    candidate.sigma = fit.sigma / scale;
    // Of what the fit leaves, that is the part of noise; the other one is shading that it does not
    // know.
    candidate.noise_sigma = candidate.sigma * std::min(1.0, noise / std::sqrt(fit.left));
    const double alone = (span.first + peaks[j] + fit.place) / scale;
    // Two places explain more than one, and too much on edges of which little is known. A pair
    // whose contour is farther from the expected edge than the one step's rather takes shading for
    // a step.
    const auto pair = look.is_established() ? limb_pair_->fit(window, fit.left) : std::nullopt;
    const double contour = pair ? (span.first + peaks[j] + pair->contour) / scale : alone;
    if (!pair || std::abs(contour) >= std::abs(alone)) {
      set_place(candidate, alone);
      continue;
    }
    candidate.sigma = std::max(candidate.sigma, pair->sigma / scale);
    set_place(candidate, contour);
    if (sample.count < kMaxEdgeCandidates) {
      EdgeCandidate& border = sample.candidates[static_cast<std::size_t>(sample.count++)];
      border = candidate;
      set_place(border, (span.first + peaks[j] + pair->border) / scale);
    }
  }
}

double EdgeSearch::instant(const Eigen::Vector2d& ideal) const noexcept {
  const std::optional<Eigen::Vector2d> seen =
      camera_.has_distortion() ? camera_.distort(ideal) : std::optional(ideal);
  return seen ? parameters_.row_time * (seen->y() - 0.5 * (camera_.parameters().height - 1)) : 0.0;
}

void EdgeSearch::search_sample(const ImageView& image, double range, bool round,
                               const EdgeMemory::Look& look, SearchedSample& sample) {
  if (!camera_.has_distortion()) {
    candidates_along(image, sample.place, sample.normal, 1.0, range, round, look, sample);
    return;
  }
  // Over the few pixels of the search the distortion is as good as linear.
  const std::optional<Eigen::Vector2d> middle = camera_.distort(sample.place);
  const std::optional<Eigen::Vector2d> beside = camera_.distort(sample.place + sample.normal);
  if (middle && beside) {
    const Eigen::Vector2d direction = *beside - *middle;
    const double scale = direction.norm();
    sample.ideal_per_pixel = 1 / scale;
    candidates_along(image, *middle, direction / scale, scale, range, round, look, sample);
  }
}

void EdgeSearch::search(const ImageView& image, const VisibleEdge& edge, std::uint32_t index,
                        const Eigen::Vector2d& normal, double range, const EdgeMemory::Look& look,
                        std::vector<SearchedSample>& samples, const EdgeMotion& motion) {
  const double reach = std::clamp(range, 1.0, kLongestSearch * 0.8);
  const bool round = edge.id.kind == EdgeKind::kPipe;
  // Supports have many short edges, and fix little but the place along the pipes.
  const int count = round ? parameters_.samples_per_edge
                          : std::max(2, parameters_.samples_per_edge / kSupportShare);
  for (int j = 1; j <= count; ++j) {
    const double share = static_cast<double>(j) / (count + 1);
    SearchedSample& sample = samples.emplace_back();
    sample.edge = index;
    sample.normal = normal;
    sample.place = edge.image_start + share * (edge.image_end - edge.image_start);
    if (parameters_.row_time == 0) {
      search_sample(image, reach, round, look, sample);
      continue;
    }
    const Eigen::Vector2d place = sample.place;
    const Eigen::Vector2d shares(1 - share, share);
    const double speed = shares.dot(motion.speed);
    const double moved = speed * instant(place);
    sample.place = place + moved * normal;
    search_sample(image, reach, round, look, sample);
    for (std::size_t i = 0; i < static_cast<std::size_t>(sample.count); ++i) {
      EdgeCandidate& candidate = sample.candidates[i];
      const double since_middle_row = speed * instant(candidate.pixel);
      candidate.pixel -= since_middle_row * normal;
      candidate.distance += moved - since_middle_row;
    }
    sample.motion_sigma = std::abs(instant(sample.place)) *
                          std::sqrt(std::max(0.0, shares.dot(motion.covariance * shares)));
    sample.place = place;
  }
}

}  // namespace pipescout::rack_vision
