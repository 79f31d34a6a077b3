// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/transform_buffer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <mutex>
#include <shared_mutex>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "pipescout/runtime/conversions.hpp"
#include "rigid_transform.hpp"
#include "text_for_people.hpp"
#include "transform_history.hpp"

namespace pipescout {
namespace {

/// Of the squared norm of a quaternion from 1; as tf2.
constexpr double kNormTolerance = 1e-2;

using Id = std::uint32_t;
constexpr Id kNone = std::numeric_limits<Id>::max();

struct Frame {
  std::string name;
  Id parent = kNone;
  std::uint32_t depth = 0;  // steps to the root
  bool is_static = false;
  RigidTransform fixed;      // of a static one
  TransformHistory history;  // of one that moves
  Gid authority;
  std::uint64_t received = 0;
};

struct NameHash {
  using is_transparent = void;
  std::size_t operator()(std::string_view name) const noexcept {
    return std::hash<std::string_view>{}(name);
  }
};

std::string_view without_slash(std::string_view name) noexcept {
  return name.starts_with('/') ? name.substr(1) : name;
}

/// As stamps are printed: seconds with nine decimals.
std::string seconds(Time time) {
  const auto whole = std::chrono::floor<std::chrono::seconds>(time.time_since_epoch());
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%lld.%09lld", static_cast<long long>(whole.count()),
                static_cast<long long>((time.time_since_epoch() - whole).count()));
  return text.data();
}

std::string quoted(std::string_view name) {
  std::string text(1, '\'');
  text.append(name).push_back('\'');
  return text;
}

bool is_finite(const RigidTransform& transform) {
  const auto finite = [](double value) { return std::isfinite(value); };
  return std::ranges::all_of(transform.translation, finite) &&
         std::ranges::all_of(transform.rotation, finite);
}

double squared_norm(const std::array<double, 4>& q) {
  return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
}

/// Where a lookup failed; words are made of it only for those who want them.
struct Obstacle {
  TransformError error{};
  Id first = kNone;   // kUnknownFrame: none; kDisconnected: a root; else the child of the transform
  Id second = kNone;  // kDisconnected: the other root
  std::string_view unknown = {};
  Time asked{};
};

}  // namespace

std::string_view to_string(TransformError error) noexcept {
  switch (error) {
    case TransformError::kUnknownFrame:
      return "unknown_frame";
    case TransformError::kDisconnected:
      return "disconnected";
    case TransformError::kPast:
      return "past";
    case TransformError::kFuture:
      return "future";
    case TransformError::kTooManyWaits:
      return "too_many_waits";
  }
  return "unknown";
}

std::string_view to_string(TransformFault fault) noexcept {
  switch (fault) {
    case TransformFault::kNoFrame:
      return "no_frame";
    case TransformFault::kSameFrame:
      return "same_frame";
    case TransformFault::kNotFinite:
      return "not_finite";
    case TransformFault::kNotNormalised:
      return "not_normalised";
    case TransformFault::kLoop:
      return "loop";
    case TransformFault::kTwoParents:
      return "two_parents";
    case TransformFault::kTwoKinds:
      return "two_kinds";
    case TransformFault::kFromFuture:
      return "from_future";
    case TransformFault::kTooManyFrames:
      return "too_many_frames";
  }
  return "unknown";
}

class TransformBuffer::Impl {
 public:
  explicit Impl(const TransformBufferOptions& given) : options_(given) {}

  std::optional<TransformRefusal> insert(const TransformStamped& message, bool is_static,
                                         const Gid& authority) {
    const std::string_view child_name = without_slash(message.child_frame_id);
    const std::string_view parent_name = without_slash(message.header.frame_id);
    RigidTransform transform = rigid::from_message(message.transform);
    if (auto refusal = check(child_name, parent_name, transform)) {
      return refusal;
    }
    const Time time = from_message(message.header.stamp);

    const std::unique_lock lock(mutex_);
    const Id known_child = find(child_name);
    const Id known_parent = find(parent_name);
    if (known_child == kNone || frames_[known_child].parent == kNone ||
        frames_[known_child].parent != known_parent) {
      if (auto refusal =
              check_parent(known_child, known_parent, child_name, parent_name, is_static, time)) {
        return refusal;
      }
    } else if (frames_[known_child].is_static != is_static) {
      return two_kinds(frames_[known_child], is_static);
    }
    const Id parent = known_parent != kNone ? known_parent : add(parent_name);
    const Id child = known_child != kNone ? known_child : add(child_name);
    if (frames_[child].parent != parent) {
      attach(child, parent, is_static);
    }
    Frame& frame = frames_[child];
    frame.authority = authority;
    ++frame.received;
    if (is_static) {
      frame.fixed = transform;
    } else {
      frame.history.insert({time, transform}, options_.history, options_.samples_per_frame);
    }
    return std::nullopt;
  }

  void clear_moving() {
    const std::unique_lock lock(mutex_);
    for (Frame& frame : frames_) {
      if (!frame.is_static) {
        frame.history.clear();
        frame.parent = kNone;
        frame.received = 0;
      }
    }
    forget_lone_frames();
  }

  void extend_history(Duration history) {
    const std::unique_lock lock(mutex_);
    options_.history = std::max(options_.history, history);
  }

  TransformResult lookup(std::string_view target, std::string_view source, Time time) const {
    const std::shared_lock lock(mutex_);
    Obstacle obstacle;
    Duration gap{};
    const Id from = known(source, obstacle);
    const Id to = from == kNone ? kNone : known(target, obstacle);
    RigidTransform transform;
    if (to == kNone || !compose(to, from, time, transform, gap, obstacle)) {
      return TransformResult(failure(obstacle, target, source));
    }
    return result(to, from, time, transform, gap);
  }

  TransformResult lookup(std::string_view target, Time target_time, std::string_view source,
                         Time source_time, std::string_view fixed) const {
    const std::shared_lock lock(mutex_);
    Obstacle obstacle;
    Duration gap{};
    const Id from = known(source, obstacle);
    const Id over = from == kNone ? kNone : known(fixed, obstacle);
    const Id to = over == kNone ? kNone : known(target, obstacle);
    RigidTransform first;
    RigidTransform second;
    if (to == kNone || !compose(over, from, source_time, first, gap, obstacle) ||
        !compose(to, over, target_time, second, gap, obstacle)) {
      return TransformResult(failure(obstacle, target, source));
    }
    return result(to, from, target_time, second * first, gap);
  }

  bool can_transform(std::string_view target, std::string_view source, Time time,
                     TransformFailure* reason) const {
    const std::shared_lock lock(mutex_);
    Obstacle obstacle;
    const Id from = known(source, obstacle);
    const Id to = from == kNone ? kNone : known(target, obstacle);
    if (to != kNone) {
      const Id top = meeting(to, from, obstacle);
      if (top != kNone && resolve(to, from, top, time, obstacle)) {
        return true;
      }
    }
    if (reason != nullptr) {
      *reason = failure(obstacle, target, source);
    }
    return false;
  }

  std::vector<TransformFrame> frames() const {
    std::vector<TransformFrame> result;
    {
      const std::shared_lock lock(mutex_);
      result.reserve(frames_.size());
      for (const Frame& frame : frames_) {
        TransformFrame& told = result.emplace_back();
        told.name = frame.name;
        if (frame.parent != kNone) {
          told.parent = frames_[frame.parent].name;
        }
        told.is_static = frame.is_static;
        told.authority = frame.authority;
        told.received = frame.received;
        if (!frame.history.empty()) {
          told.oldest = frame.history.oldest();
          told.newest = frame.history.newest();
        }
      }
    }
    std::ranges::sort(result, {}, &TransformFrame::name);
    return result;
  }

 private:
  /// What can be seen of the transform alone. Makes the rotation's norm 1.
  static std::optional<TransformRefusal> check(std::string_view child, std::string_view parent,
                                               RigidTransform& transform) {
    const auto refuse = [&](TransformFault fault, std::string_view text) {
      return TransformRefusal{
          fault,
          "transform of " + quoted(child) + " in " + quoted(parent) + ": " + std::string(text),
          std::nullopt};
    };
    if (child.empty() || parent.empty()) {
      return refuse(TransformFault::kNoFrame, "a name is empty");
    }
    if (child == parent) {
      return refuse(TransformFault::kSameFrame, "a frame is no child of its own");
    }
    if (!is_finite(transform)) {
      return refuse(TransformFault::kNotFinite, "a number is NaN or infinite");
    }
    const double norm = squared_norm(transform.rotation);
    if (std::abs(norm - 1) > kNormTolerance) {
      return refuse(TransformFault::kNotNormalised,
                    "the quaternion has the norm " + text_for_people(std::sqrt(norm)) + ", not 1");
    }
    for (double& value : transform.rotation) {
      value /= std::sqrt(norm);
    }
    return std::nullopt;
  }

  TransformRefusal two_kinds(const Frame& frame, bool is_static) const {
    return {TransformFault::kTwoKinds,
            "transform of " + quoted(frame.name) + " in " + quoted(frames_[frame.parent].name) +
                (is_static ? " comes as static, and moves" : " moves, and is static"),
            frame.authority};
  }

  /// Whether the child may get this parent, which it has not.
  std::optional<TransformRefusal> check_parent(Id child, Id parent, std::string_view child_name,
                                               std::string_view parent_name, bool is_static,
                                               Time time) const {
    const std::size_t fresh = (child == kNone ? 1U : 0U) + (parent == kNone ? 1U : 0U);
    if (frames_.size() + fresh > options_.frames) {
      return TransformRefusal{TransformFault::kTooManyFrames,
                              "transform of " + quoted(child_name) + " in " + quoted(parent_name) +
                                  ": " + std::to_string(frames_.size()) +
                                  " frames are known already",
                              std::nullopt};
    }
    if (child == kNone) {
      return std::nullopt;
    }
    const Frame& frame = frames_[child];
    if (frame.parent != kNone) {
      // Between static ones the last word counts: each is said once, and may be a correction.
      if (frame.is_static ? !is_static : is_static || !has_ended(frame.history, time)) {
        return TransformRefusal{TransformFault::kTwoParents,
                                "frame " + quoted(child_name) +
                                    " has two parents: " + quoted(frames_[frame.parent].name) +
                                    ", which stays, and " + quoted(parent_name),
                                frame.authority};
      }
    }
    for (Id ancestor = parent; ancestor != kNone; ancestor = frames_[ancestor].parent) {
      if (ancestor == child) {
        return TransformRefusal{TransformFault::kLoop, loop_text(child, parent), std::nullopt};
      }
    }
    return std::nullopt;
  }

  /// Whether a transform to another parent at `time` is later than what the one before still says,
  /// or of a clock that was set back.
  [[nodiscard]] bool has_ended(const TransformHistory& history, Time time) const {
    return time > history.newest() ? time - history.newest() > options_.parent_silence
                                   : history.newest() - time > options_.history;
  }

  [[nodiscard]] std::string loop_text(Id child, Id parent) const {
    std::string text = "loop of transforms: " + quoted(frames_[child].name);
    for (Id ancestor = parent; ancestor != child; ancestor = frames_[ancestor].parent) {
      text += " in " + quoted(frames_[ancestor].name);
    }
    return text + " in " + quoted(frames_[child].name);
  }

  [[nodiscard]] Id find(std::string_view name) const {
    const auto found = ids_.find(name);
    return found == ids_.end() ? kNone : found->second;
  }

  Id add(std::string_view name) {
    const Id id = static_cast<Id>(frames_.size());
    frames_.emplace_back().name = name;
    ids_.emplace(name, id);
    return id;
  }

  /// Rare: at the first transform of a child, or when it changes its parent.
  void attach(Id child, Id parent, bool is_static) {
    Frame& frame = frames_[child];
    frame.parent = parent;
    frame.is_static = is_static;
    frame.history.clear();
    frame.received = 0;
    frame.depth = frames_[parent].depth + 1;
    const bool has_children =
        std::ranges::any_of(frames_, [child](const Frame& other) { return other.parent == child; });
    if (has_children) {
      measure_depths();
    }
  }

  void measure_depths() {
    constexpr auto kUnmeasured = std::numeric_limits<std::uint32_t>::max();
    for (Frame& frame : frames_) {
      frame.depth = frame.parent == kNone ? 0 : kUnmeasured;
    }
    std::vector<Id> path;  // up to one that is measured
    for (Id start = 0; start < frames_.size(); ++start) {
      Id id = start;
      for (; frames_[id].depth == kUnmeasured; id = frames_[id].parent) {
        path.push_back(id);
      }
      for (; !path.empty(); path.pop_back()) {
        frames_[path.back()].depth = frames_[frames_[path.back()].parent].depth + 1;
      }
    }
  }

  /// Frames that are neither child nor parent any more would be known for ever.
  void forget_lone_frames() {
    std::vector<bool> used(frames_.size(), false);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (frames_[i].parent != kNone) {
        used[i] = true;
        used[frames_[i].parent] = true;
      }
    }
    std::vector<Id> renamed(frames_.size(), kNone);
    std::vector<Frame> kept;
    ids_.clear();
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (used[i]) {
        renamed[i] = static_cast<Id>(kept.size());
        ids_.emplace(frames_[i].name, renamed[i]);
        kept.push_back(std::move(frames_[i]));
      }
    }
    for (Frame& frame : kept) {
      if (frame.parent != kNone) {
        frame.parent = renamed[frame.parent];
      }
    }
    frames_ = std::move(kept);
    measure_depths();
  }

  [[nodiscard]] Id known(std::string_view name, Obstacle& obstacle) const {
    const Id id = find(without_slash(name));
    if (id == kNone) {
      obstacle = {.error = TransformError::kUnknownFrame, .unknown = name};
    }
    return id;
  }

  [[nodiscard]] Id root_of(Id frame) const {
    while (frames_[frame].parent != kNone) {
      frame = frames_[frame].parent;
    }
    return frame;
  }

  /// The nearest frame that is above both, or one of them.
  [[nodiscard]] Id meeting(Id a, Id b, Obstacle& obstacle) const {
    Id high = a;
    Id low = b;
    while (high != low) {
      Id& deeper = frames_[high].depth > frames_[low].depth ? high : low;
      deeper = frames_[deeper].parent;
      if (deeper == kNone) {
        obstacle = {
            .error = TransformError::kDisconnected, .first = root_of(a), .second = root_of(b)};
        return kNone;
      }
    }
    return high;
  }

  /// Checks that all transforms are known at `time`, after it made that the latest common one if it
  /// is kLatestTransform.
  [[nodiscard]] bool resolve(Id a, Id b, Id top, Time& time, Obstacle& obstacle) const {
    Time oldest = Time::min();
    Time newest = Time::max();
    Id young = kNone;  // the child whose history begins last
    Id behind = kNone;
    for (const Id start : {a, b}) {
      for (Id id = start; id != top; id = frames_[id].parent) {
        const Frame& frame = frames_[id];
        if (frame.is_static) {
          continue;
        }
        if (frame.history.oldest() > oldest) {
          oldest = frame.history.oldest();
          young = id;
        }
        if (frame.history.newest() < newest) {
          newest = frame.history.newest();
          behind = id;
        }
      }
    }
    if (time == kLatestTransform && behind != kNone) {
      time = newest;
    }
    if (young != kNone && time < oldest) {
      obstacle = {.error = TransformError::kPast, .first = young, .asked = time};
      return false;
    }
    if (behind != kNone && time > newest) {
      obstacle = {.error = TransformError::kFuture, .first = behind, .asked = time};
      return false;
    }
    return true;
  }

  /// `time` becomes the latest common one if it is kLatestTransform.
  [[nodiscard]] bool compose(Id target, Id source, Time& time, RigidTransform& transform,
                             Duration& gap, Obstacle& obstacle) const {
    const Id top = meeting(target, source, obstacle);
    if (top == kNone || !resolve(target, source, top, time, obstacle)) {
      return false;
    }
    transform = up(source, top, time, gap);
    if (target != top) {
      transform = inverse(up(target, top, time, gap)) * transform;
    }
    return true;
  }

  /// From a frame to one above it.
  [[nodiscard]] RigidTransform up(Id from, Id top, Time time, Duration& gap) const {
    RigidTransform transform;
    bool first = true;
    for (Id id = from; id != top; id = frames_[id].parent) {
      const Frame& frame = frames_[id];
      const RigidTransform step = frame.is_static ? frame.fixed : frame.history.at(time, gap);
      transform = first ? step : step * transform;
      first = false;
    }
    return transform;
  }

  [[nodiscard]] TransformResult result(Id target, Id source, Time time,
                                       const RigidTransform& transform, Duration gap) const {
    TransformStamped told;
    told.header.stamp = to_message(time);
    told.header.frame_id = frames_[target].name;
    told.child_frame_id = frames_[source].name;
    told.transform = rigid::to_message(transform);
    return {std::move(told), gap};
  }

  [[nodiscard]] TransformFailure failure(const Obstacle& obstacle, std::string_view target,
                                         std::string_view source) const {
    std::string text = "no transform from " + quoted(source) + " to " + quoted(target) + ": ";
    switch (obstacle.error) {
      case TransformError::kUnknownFrame:
        text += obstacle.unknown.empty()
                    ? "the name of a frame is empty"
                    : "frame " + quoted(obstacle.unknown) + " is not known; nobody has sent it";
        break;
      case TransformError::kDisconnected:
        text += "they are in different trees, below " + quoted(frames_[obstacle.first].name) +
                " and " + quoted(frames_[obstacle.second].name) + ", which no transform connects";
        break;
      case TransformError::kPast:
      case TransformError::kFuture:
      case TransformError::kTooManyWaits: {
        const Frame& frame = frames_[obstacle.first];
        text += "asked for " + seconds(obstacle.asked) + " s, but " + quoted(frame.name) + " in " +
                quoted(frames_[frame.parent].name) + " is known from " +
                seconds(frame.history.oldest()) + " to " + seconds(frame.history.newest()) + " s";
        break;
      }
    }
    return {obstacle.error, std::move(text)};
  }

  mutable std::shared_mutex mutex_;
  TransformBufferOptions options_;
  std::vector<Frame> frames_;
  std::unordered_map<std::string, Id, NameHash, std::equal_to<>> ids_;
};

TransformBuffer::TransformBuffer(const TransformBufferOptions& options) {
  const auto refuse = [](const std::string& text) {
    throw std::invalid_argument("transform buffer: " + text);
  };
  if (options.history <= Duration::zero()) {
    refuse("history is " + text_for_people(to_seconds(options.history)) + " s, not positive");
  }
  if (options.samples_per_frame < 2) {
    refuse("samples_per_frame is " + std::to_string(options.samples_per_frame) + ", below 2");
  }
  if (options.frames < 2) {
    refuse("frames is " + std::to_string(options.frames) + ", below 2");
  }
  if (options.parent_silence < Duration::zero()) {
    refuse("parent_silence is " + text_for_people(to_seconds(options.parent_silence)) +
           " s, negative");
  }
  impl_ = std::make_unique<Impl>(options);
}

TransformBuffer::~TransformBuffer() = default;

std::optional<TransformRefusal> TransformBuffer::insert(const TransformStamped& transform,
                                                        bool is_static, const Gid& authority) {
  return impl_->insert(transform, is_static, authority);
}

void TransformBuffer::clear_moving() {
  impl_->clear_moving();
}

void TransformBuffer::extend_history(Duration history) {
  impl_->extend_history(history);
}

TransformResult TransformBuffer::lookup(std::string_view target, std::string_view source,
                                        Time time) const {
  return impl_->lookup(target, source, time);
}

TransformResult TransformBuffer::lookup(std::string_view target, Time target_time,
                                        std::string_view source, Time source_time,
                                        std::string_view fixed) const {
  return impl_->lookup(target, target_time, source, source_time, fixed);
}

bool TransformBuffer::can_transform(std::string_view target, std::string_view source, Time time,
                                    TransformFailure* reason) const {
  return impl_->can_transform(target, source, time, reason);
}

std::vector<TransformFrame> TransformBuffer::frames() const {
  return impl_->frames();
}

}  // namespace pipescout
