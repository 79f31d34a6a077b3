// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "pipescout/tracking/particle_filter_definition.hpp"
#include "pipescout/tracking/shape_kalman_definition.hpp"
#include "pipescout/tracking/shape_tracker.hpp"

/// Implementation of `ShapeTracker`, for shapes that are not compiled in the library.
namespace pipescout::tracking {

template <TrackableShape Model>
ShapeTrackerParameters<Model>::ShapeTrackerParameters() {
  for (std::size_t i = 0; i < Model::kSize; ++i) {
    const auto index = static_cast<Eigen::Index>(i);
    filter.start_deviation[index] = Model::kStartDeviation[i];
    filter.process_deviation[index] = Model::kProcessDeviation[i];
    rate_walk[index] = Model::kRateWalk[i];
  }
}

template <TrackableShape Model>
void ShapeTrackerParameters<Model>::validate() const {
  filter.validate();
  for (const double walk : rate_walk) {
    validation::require("rate_walk", walk, walk > 0 && walk <= 1e6, "(0, 1e6]");
  }
  validation::require("motion_share", motion_share, motion_share > 0 && motion_share <= 1,
                      "(0, 1]");
  validation::require("rate_memory", rate_memory, rate_memory > 0 && rate_memory <= 100,
                      "(0, 100]");
  validation::require("gate", gate, gate >= 1 && gate <= 20, "[1, 20]");
  validation::require("detection", detection, detection > 0 && detection < 1, "(0, 1)");
  validation::require("clutter", clutter, clutter > 0 && clutter <= 100, "(0, 100]");
  validation::require("doubt", doubt, doubt > 0 && doubt < 1, "(0, 1)");
  validation::require("confirm", static_cast<double>(confirm), confirm >= 1 && confirm <= 100,
                      "[1, 100]");
  validation::require("confidence_time", confidence_time,
                      confidence_time > 0 && confidence_time <= 1000, "(0, 1000]");
  validation::require("max_coast", max_coast, max_coast > 0 && max_coast <= 1000, "(0, 1000]");
  validation::require("max_lost", max_lost, max_lost >= 0 && max_lost <= 1000, "[0, 1000]");
  validation::require("max_back", max_back, max_back >= 0 && max_back <= 1000, "[0, 1000]");
  validation::require("max_regions", static_cast<double>(max_regions),
                      max_regions >= 1 && max_regions <= 100000, "[1, 100000]");
  validation::require("guard_distance", guard_distance, guard_distance > 0 && guard_distance <= 1e6,
                      "(0, 1e6]");
}

template <TrackableShape Model>
ShapeTracker<Model>::ShapeTracker(const Model& model,
                                  const ShapeTrackerParameters<Model>& parameters,
                                  std::uint64_t seed)
    : model_(model), parameters_(parameters), filter_(model, parameters.filter, seed) {
  parameters_.validate();
  rivals_.reserve(kMostRivals);
  usable_.reserve(parameters_.max_regions);
  compared_.reserve(kMostCompared);
  restart();
}

template <TrackableShape Model>
void ShapeTracker<Model>::restart() {
  track_ = Track<Model>{};
  track_.since_seen = std::numeric_limits<double>::quiet_NaN();
  rivals_.clear();
  following_ = false;
  confirmed_ = false;
  clocked_ = false;
}

template <TrackableShape Model>
void ShapeTracker<Model>::note(TrackFault fault) noexcept {
  track_.fault = fault;
  ++faults_[static_cast<std::size_t>(fault)];
}

template <TrackableShape Model>
bool ShapeTracker<Model>::accept(const TrackingFrame<Model>& frame) {
  track_.fault = TrackFault::kNone;
  if (!std::isfinite(frame.time)) {
    note(TrackFault::kBadStamp);
    return false;
  }
  constexpr int kLargest = 32767;
  if (frame.image.width < 1 || frame.image.height < 1 || frame.image.width > kLargest ||
      frame.image.height > kLargest) {
    note(TrackFault::kBadImageSize);
    return false;
  }
  if (clocked_ && frame.time <= track_.time) {
    const bool anew = track_.time - frame.time > parameters_.max_back;
    if (anew) {
      restart();
    }
    note(TrackFault::kTimeWentBack);
    return anew;
  }
  return true;
}

template <TrackableShape Model>
const Track<Model>& ShapeTracker<Model>::update(const TrackingFrame<Model>& frame) {
  if (!accept(frame)) {
    return track_;
  }
  Motion motion = frame.motion;
  if (motion && !motion->usable()) {
    note(TrackFault::kBadMotion);
    motion.reset();
  }
  const double dt = clocked_ ? frame.time - track_.time : 0;
  track_.time = frame.time;
  clocked_ = true;
  resize(frame.image);
  gather(frame.regions);
  if (following_ && frame.time - last_seen_ > parameters_.max_coast + parameters_.max_lost) {
    following_ = false;
    rivals_.clear();
  }
  if (following_) {
    predict(dt, motion);
    if (frame.hint && lost()) {
      ++misses_;  // where it is, the hint tells better
    } else {
      associate(frame.regions);
      correct(frame.regions);
      jump(frame.regions);
    }
    follow_rivals(frame.regions, motion);
    weigh(frame.regions);
  }
  take_up(frame, motion);
  live();
  report();
  return track_;
}

template <TrackableShape Model>
void ShapeTracker<Model>::resize(const ImageSize& image) {
  const ImageSize before = track_.image;
  track_.image = image;
  if (!following_ || before == image) {
    return;
  }
  const double across = static_cast<double>(image.width) / before.width;
  const double down = static_cast<double>(image.height) / before.height;
  constexpr double kSameView = 0.02;
  if (std::abs(across / down - 1) > kSameView) {
    // Another part of the scene is shown: where the shape is in it is not known.
    following_ = false;
    rivals_.clear();
    return;
  }
  const double factor = std::sqrt(across * down);
  kalman_.scale(factor);
  for (Rival& rival : rivals_) {
    rival.kalman.scale(factor);
  }
  filter_.start(Model::in_view(kalman_.state(), image).shape);
}

template <TrackableShape Model>
void ShapeTracker<Model>::gather(Regions regions) {
  usable_.clear();
  track_.region.reset();
  track_.regions = 0;
  if (regions.size() > parameters_.max_regions) {
    note(TrackFault::kTooManyRegions);
    return;
  }
  constexpr double kFarthest = 1e6;  // px
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const State state = Model::state_of(regions[i]);
    const double size = Model::size_of(regions[i]);
    if (state.allFinite() && state.cwiseAbs().maxCoeff() < kFarthest && size > 0) {
      usable_.push_back({.region = i, .size = size});
    } else {
      note(TrackFault::kBadRegion);
    }
  }
  track_.regions = usable_.size();
}

template <TrackableShape Model>
void ShapeTracker<Model>::predict(double dt, const Motion& motion) {
  const State walk = (motion ? parameters_.motion_share : 1.0) * parameters_.rate_walk;
  const State before = Model::in_view(kalman_.state(), track_.image).shape;
  kalman_.predict(dt, motion, walk, parameters_.rate_memory);
  for (Rival& rival : rivals_) {
    rival.kalman.predict(dt, motion, walk, parameters_.rate_memory);
  }
  if (dt > 0) {
    State rate = (Model::in_view(kalman_.state(), track_.image).shape - before) / dt;
    for (std::size_t i = 0; i < Model::kSize; ++i) {
      const auto index = static_cast<Eigen::Index>(i);
      if (Model::kPeriods[i] > 0) {
        rate[index] = std::remainder(rate[index], Model::kPeriods[i] / dt);
      }
    }
    filter_.predict(dt, rate);
  }
}

template <TrackableShape Model>
typename ShapeKalman<Model>::Fit ShapeTracker<Model>::fit(ShapeKalman<Model>& kalman,
                                                          const Region& region) {
  model_.observe(region, kalman.state(), kalman.covariance(), track_.image, rows_);
  return kalman.correct(rows_, parameters_.gate, parameters_.doubt);
}

template <TrackableShape Model>
bool ShapeTracker<Model>::of_known_rival(const Usable& usable) const {
  return usable.rival && rivals_[*usable.rival].seen >= parameters_.confirm;
}

template <TrackableShape Model>
void ShapeTracker<Model>::associate(Regions regions) {
  for (Usable& usable : usable_) {
    ShapeKalman<Model> trial = kalman_;
    const auto target = fit(trial, regions[usable.region]);
    usable.ratio = target.gated ? target.ratio : 0;
    for (std::size_t k = 0; k < rivals_.size(); ++k) {
      trial = rivals_[k].kalman;
      const auto rival = fit(trial, regions[usable.region]);
      if (rival.gated && rival.ratio > usable.rival_ratio) {
        usable.rival_ratio = rival.ratio;
        usable.rival = k;
      }
    }
    if (of_known_rival(usable) && usable.rival_ratio > usable.ratio) {
      usable.ratio = 0;
    }
  }
}

template <TrackableShape Model>
void ShapeTracker<Model>::seen_in(std::size_t region) {
  track_.region = region;
  last_seen_ = track_.time;
  misses_ = 0;
  ++times_seen_;
}

template <TrackableShape Model>
void ShapeTracker<Model>::correct(Regions regions) {
  const auto likeliest = std::ranges::max_element(usable_, {}, &Usable::ratio);
  if (likeliest == usable_.end() || likeliest->ratio == 0) {
    ++misses_;
    model_.keep_open(kalman_.state(), kalman_.covariance(), track_.image, rows_);
    kalman_.correct(rows_, parameters_.gate, parameters_.doubt);
    return;
  }
  ShapeKalman<Model> trial = kalman_;
  fit(trial, regions[likeliest->region]);
  Region seen = regions[likeliest->region];
  const Ends censored{.start = track_.time - start_censored_ <= parameters_.max_coast,
                      .end = track_.time - end_censored_ <= parameters_.max_coast};
  for (Usable& usable : usable_) {
    if (usable.ratio > 0 && usable.region != likeliest->region) {
      // Another part of the same, or something else that was near the prediction.
      ShapeKalman<Model> with_both = trial;
      if (fit(with_both, regions[usable.region]).gated) {
        usable.rival.reset();
        seen = model_.joined(seen, regions[usable.region], track_.image, censored);
      } else {
        usable.ratio = 0;
      }
    }
  }
  fit(kalman_, seen);
  seen_ = Model::state_of(seen);
  // 1 - delta of Musicki, Evans and Stankovic.
  const double evidence =
      1 - parameters_.detection + parameters_.detection / parameters_.clutter * likeliest->ratio;
  existence_ = evidence * existence_ / (1 - existence_ + evidence * existence_);
  likeliest->rival.reset();
  seen_in(likeliest->region);
}

template <TrackableShape Model>
double ShapeTracker<Model>::distance_between(const State& a, const State& b) const {
  std::array<double, Model::kSize> difference;
  for (std::size_t i = 0; i < Model::kSize; ++i) {
    const double d = a[static_cast<Eigen::Index>(i)] - b[static_cast<Eigen::Index>(i)];
    difference[i] = Model::kPeriods[i] > 0 ? std::remainder(d, Model::kPeriods[i]) : d;
  }
  return model_.distance(difference);
}

template <TrackableShape Model>
void ShapeTracker<Model>::jump(Regions regions) {
  constexpr std::size_t kMisses = 2;
  if (misses_ < kMisses) {
    return;
  }
  const State particles = filter_.robust_mean();
  double least = parameters_.guard_distance;
  Usable* nearest = nullptr;
  for (Usable& usable : usable_) {
    if (of_known_rival(usable)) {
      continue;
    }
    const double distance = distance_between(particles, Model::state_of(regions[usable.region]));
    if (distance < least) {
      least = distance;
      nearest = &usable;
    }
  }
  if (nearest == nullptr) {
    return;
  }
  const State away = Model::state_of(regions[nearest->region]) -
                     Model::in_view(kalman_.state(), track_.image).shape;
  // What the region does not tell, as the length of what is cut, is kept.
  kalman_.widen(away.cwiseAbs() + start_deviation(), start_rate_deviation());
  fit(kalman_, regions[nearest->region]);
  if (nearest->rival) {
    rivals_.erase(rivals_.begin() + static_cast<std::ptrdiff_t>(*nearest->rival));
    for (Usable& usable : usable_) {
      usable.rival.reset();
    }
  }
  nearest->ratio = 1;
  seen_ = Model::state_of(regions[nearest->region]);
  seen_in(nearest->region);
}

template <TrackableShape Model>
void ShapeTracker<Model>::follow_rivals(Regions regions, const Motion& motion) {
  for (std::size_t k = 0; k < rivals_.size(); ++k) {
    const Usable* best = nullptr;
    for (const Usable& usable : usable_) {
      if (usable.rival == k && (best == nullptr || usable.rival_ratio > best->rival_ratio)) {
        best = &usable;
      }
    }
    Rival& rival = rivals_[k];
    if (best != nullptr) {
      fit(rival.kalman, regions[best->region]);
      ++rival.seen;
      rival.last_seen = track_.time;
    } else if (track_.region) {
      // Nothing is its own, and what is the shape's fits it too: it is the same.
      ShapeKalman<Model> trial = rival.kalman;
      if (fit(trial, regions[*track_.region]).gated) {
        rival.last_seen = -std::numeric_limits<double>::infinity();
      }
    }
  }
  std::erase_if(rivals_, [this](const Rival& rival) {
    return track_.time - rival.last_seen > parameters_.max_coast;
  });
  for (const Usable& usable : usable_) {
    if (usable.ratio == 0 && !usable.rival && rivals_.size() < kMostRivals) {
      Rival rival{.kalman = {}, .seen = 1, .last_seen = track_.time};
      start_at(rival.kalman, regions[usable.region], motion);
      rivals_.push_back(rival);
    }
  }
}

template <TrackableShape Model>
void ShapeTracker<Model>::weigh(Regions regions) {
  compared_.clear();
  if (track_.region) {
    compared_.push_back(seen_);
  }
  for (const Usable& usable : usable_) {
    const bool part = track_.region && usable.ratio > 0;
    if (compared_.size() < kMostCompared && !part && !of_known_rival(usable)) {
      compared_.push_back(Model::state_of(regions[usable.region]));
    }
  }
  filter_.update(compared_);
  // Where what was predicted in a gap turns out wrong, they do not come back by themselves.
  const State estimate = Model::in_view(kalman_.state(), track_.image).shape;
  if (track_.region &&
      distance_between(filter_.robust_mean(), estimate) > parameters_.guard_distance) {
    filter_.start(estimate);
    filter_.update(compared_);
  }
}

template <TrackableShape Model>
std::optional<std::size_t> ShapeTracker<Model>::fits_hint(Regions regions,
                                                          const TrackHint<Model>& hint) {
  std::optional<std::size_t> best;
  double greatest = 0;
  for (const Usable& usable : usable_) {
    ShapeKalman<Model> expected;
    expected.start(hint.shape, hint.deviation, start_rate_deviation());
    const auto result = fit(expected, regions[usable.region]);
    if (result.gated && result.ratio > greatest) {
      greatest = result.ratio;
      best = usable.region;
    }
  }
  return best;
}

template <TrackableShape Model>
void ShapeTracker<Model>::take_up(const TrackingFrame<Model>& frame, const Motion& motion) {
  std::optional<TrackHint<Model>> hint = frame.hint;
  if (hint &&
      !(hint->shape.allFinite() && hint->deviation.allFinite() && hint->deviation.minCoeff() > 0)) {
    note(TrackFault::kBadHint);
    hint.reset();
  }
  if (usable_.empty() || (following_ && !lost())) {
    return;
  }
  if (hint) {
    const auto region = fits_hint(frame.regions, *hint);
    if (region) {
      const bool same = lost();
      begin(frame.regions[*region], motion);
      confirmed_ = same;
      seen_in(*region);
    }
    return;
  }
  if (!following_) {
    const auto largest = std::ranges::max_element(usable_, {}, &Usable::size);
    begin(frame.regions[largest->region], motion);
    confirmed_ = false;
    seen_in(largest->region);
  }
}

template <TrackableShape Model>
typename ShapeTracker<Model>::State ShapeTracker<Model>::start_rate_deviation() const {
  // What the random walk comes to when it is left to itself.
  return parameters_.rate_walk * std::sqrt(parameters_.rate_memory / 2);
}

template <TrackableShape Model>
void ShapeTracker<Model>::start_at(ShapeKalman<Model>& kalman, const Region& region,
                                   const Motion& motion) {
  const State state = Model::state_of(region);
  kalman.start(state, start_deviation(), start_rate_deviation());
  kalman.predict(0, motion, parameters_.rate_walk, parameters_.rate_memory);
  // Nothing is known of what the border cuts.
  constexpr double kUnknown = 1e6;
  model_.observe(region, state, kUnknown * ShapeCovariance<Model>::Identity(), track_.image, rows_);
  kalman.correct(rows_, parameters_.gate, parameters_.doubt);
}

template <TrackableShape Model>
void ShapeTracker<Model>::begin(const Region& region, const Motion& motion) {
  start_at(kalman_, region, motion);
  filter_.start(Model::state_of(region));
  rivals_.clear();
  times_seen_ = 0;
  following_ = true;
  start_censored_ = -std::numeric_limits<double>::infinity();
  end_censored_ = -std::numeric_limits<double>::infinity();
  constexpr double kPrior = 0.5;
  existence_ = kPrior;
}

template <TrackableShape Model>
void ShapeTracker<Model>::live() {
  constexpr std::size_t kGivenUp = 2;  // pictures in a row without a candidate
  constexpr double kSure = 0.9;
  if (following_ && !confirmed_ && misses_ >= kGivenUp) {
    following_ = false;
  }
  if (following_ && !confirmed_ && times_seen_ >= parameters_.confirm && existence_ >= kSure) {
    confirmed_ = true;
    track_.number = ++numbers_;
  }
  if (!following_ || !confirmed_) {
    track_.state = TrackState::kDetecting;
    track_.number = 0;
  } else if (misses_ == 0) {
    track_.state = TrackState::kLocked;
  } else {
    track_.state = lost() ? TrackState::kLost : TrackState::kCoasting;
  }
  track_.since_seen =
      following_ ? track_.time - last_seen_ : std::numeric_limits<double>::quiet_NaN();
  track_.confidence =
      following_ ? existence_ * std::exp(-track_.since_seen / parameters_.confidence_time) : 0;
}

template <TrackableShape Model>
void ShapeTracker<Model>::report() {
  if (!following_) {
    const Track<Model> before = track_;
    track_ = Track<Model>{};
    track_.time = before.time;
    track_.image = before.image;
    track_.fault = before.fault;
    track_.since_seen = before.since_seen;
    track_.regions = before.regions;
    return;
  }
  const State whole = kalman_.state();
  const ShapeInView<Model::kSize> view = Model::in_view(whole, track_.image);
  track_.whole = whole;
  track_.estimate = view.shape;
  track_.in_view = view.in_view;
  track_.start_censored = view.start_censored;
  track_.end_censored = view.end_censored;
  start_censored_ = view.start_censored ? track_.time : start_censored_;
  end_censored_ = view.end_censored ? track_.time : end_censored_;
  // What is in view, by the whole: in small steps to either side.
  ShapeCovariance<Model> derivative;
  for (Eigen::Index i = 0; i < whole.size(); ++i) {
    constexpr double kStep = 1e-4;
    const State step = kStep * State::Unit(i);
    State change = Model::in_view(whole + step, track_.image).shape -
                   Model::in_view(whole - step, track_.image).shape;
    for (std::size_t k = 0; k < Model::kSize; ++k) {
      const auto index = static_cast<Eigen::Index>(k);
      change[index] = Model::kPeriods[k] > 0 ? std::remainder(change[index], Model::kPeriods[k])
                                             : change[index];
    }
    derivative.col(i) = change / (2 * kStep);
  }
  track_.covariance = derivative * kalman_.covariance() * derivative.transpose();
  track_.rate = derivative * kalman_.rate();
  track_.best_particle = filter_.best();
  track_.robust_mean = filter_.robust_mean();
  track_.weighted_mean = filter_.weighted_mean();
  track_.effective_samples = filter_.effective_samples();
}

}  // namespace pipescout::tracking
