// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "pipescout/runtime/time.hpp"
#include "pipescout/runtime/transport.hpp"

namespace pipescout {

/// As the time of a lookup: the latest at which each transform of the chain is known.
inline constexpr Time kLatestTransform{};

/// Why there is no transform between two frames.
enum class TransformError {
  kUnknownFrame,  ///< nobody has spoken of one of the frames, or its name is empty
  kDisconnected,  ///< the frames belong to different trees
  kPast,          ///< asked for a time before the history of a transform of the chain
  kFuture,        ///< asked for a time after the latest of a transform of the chain
  kTooManyWaits,  ///< only for `Transforms::wait_for`: its bound is reached
};

/// "unknown_frame", "disconnected", "past", "future", "too_many_waits"
[[nodiscard]] std::string_view to_string(TransformError error) noexcept;

struct TransformFailure {
  TransformError error{};
  std::string text;  ///< names frames, roots of trees, times asked for and known
};

/// A transform, or why there is none.
class [[nodiscard]] TransformResult {
 public:
  using TransformStamped = geometry_msgs::msg::TransformStamped;

  /// `gap`: see the getter.
  TransformResult(TransformStamped transform, Duration gap)
      : content_(std::move(transform)), gap_(gap) {}
  explicit TransformResult(TransformFailure failure) : content_(std::move(failure)) {}

  [[nodiscard]] bool has_value() const noexcept { return content_.index() == 0; }
  [[nodiscard]] explicit operator bool() const noexcept { return has_value(); }
  /// Maps coordinates in `child_frame_id`, the source, to those in `header.frame_id`, the target;
  /// `header.stamp` is the time for which it holds (0 when all of the chain is static). Throws
  /// std::bad_variant_access when there is none.
  [[nodiscard]] const TransformStamped& value() const {
    return std::get<TransformStamped>(content_);
  }
  const TransformStamped& operator*() const { return value(); }
  const TransformStamped* operator->() const { return &value(); }
  /// Throws std::bad_variant_access when there is a transform.
  [[nodiscard]] const TransformFailure& failure() const {
    return std::get<TransformFailure>(content_);
  }
  /// The longest time between two received transforms that was interpolated over; zero where none
  /// was. Over a long one the true motion is anybody's guess.
  [[nodiscard]] Duration gap() const noexcept { return gap_; }

 private:
  std::variant<TransformStamped, TransformFailure> content_;
  Duration gap_{};
};

/// Why a received transform was not taken.
enum class TransformFault {
  kNoFrame,        ///< one of the names is empty
  kSameFrame,      ///< child and parent are the same
  kNotFinite,      ///< a number is NaN or infinite
  kNotNormalised,  ///< the quaternion is none of a rotation
  kLoop,           ///< the child is an ancestor of its parent
  kTwoParents,     ///< the child has another parent, whose publisher still speaks
  kTwoKinds,       ///< the child is known as static, or as moving, and is told as the other
  kFromFuture,     ///< its stamp is far ahead of the clock; only `Transforms` knows one
  kTooManyFrames,  ///< the bound of the buffer is reached
};

/// "no_frame", "same_frame", "not_finite", "not_normalised", "loop", "two_parents", "two_kinds",
/// "from_future", "too_many_frames"
[[nodiscard]] std::string_view to_string(TransformFault fault) noexcept;

struct TransformRefusal {
  TransformFault fault{};
  std::string text;            ///< names frames, and the chain of a loop
  std::optional<Gid> told_by;  ///< kTwoParents, kTwoKinds: the publisher that is believed
};

struct TransformBufferOptions {
  /// How long transforms are kept, back from the latest of the same child. Positive.
  Duration history = std::chrono::seconds(10);
  /// Of one child, whatever the history: 10 s at 2 kHz. At least 2.
  std::size_t samples_per_frame = 20'000;
  /// At least 2.
  std::size_t frames = 10'000;
  /// A child gets another parent when the transforms to the one before end this long before the new
  /// one; earlier it is a conflict of two publishers. Not negative.
  Duration parent_silence = std::chrono::seconds(1);
};

/// What a buffer knows of one frame.
struct TransformFrame {
  std::string name;
  std::string parent;  ///< empty: the root of a tree
  bool is_static = false;
  Gid authority;               ///< the publisher that spoke last of it; all zero for a root
  Time oldest{};               ///< of the history; zero for static ones and roots
  Time newest{};               ///< likewise
  std::uint64_t received = 0;  ///< transforms to the present parent since it is known
};

/// The trees of frames that `/tf` and `/tf_static` tell of, over the last seconds; interpolates and
/// composes them. What tf2's BufferCore is to ROS 2, with these differences: a transform that would
/// close a loop or give a child a second parent is refused when it comes, so that a tree is one at
/// all times; and a child whose stamps go back by more than the history (a simulation that was
/// started again) begins anew, instead of being refused until its old time comes again.
///
/// Names: a leading slash is left out. Positions are interpolated linearly, rotations on the
/// shortest arc. Nothing is extrapolated. No thread, no clock. Memory is bounded by the options.
/// Thread-safe; lookups run side by side.
class TransformBuffer {
 public:
  using TransformStamped = geometry_msgs::msg::TransformStamped;

  /// Throws std::invalid_argument naming the option that is out of range.
  explicit TransformBuffer(const TransformBufferOptions& options = {});
  TransformBuffer(const TransformBuffer&) = delete;
  TransformBuffer& operator=(const TransformBuffer&) = delete;
  ~TransformBuffer();

  /// Takes a transform of the child to its parent, or says why not; what was known stays then. A
  /// second one of the same child and stamp is passed over. `authority`: the publisher.
  std::optional<TransformRefusal> insert(const TransformStamped& transform, bool is_static,
                                         const Gid& authority = {});
  /// Forgets what moves; what is static stays, as it is not sent again.
  void clear_moving();
  /// Keeps at least that long from now on; a shorter one changes nothing.
  void extend_history(Duration history);

  /// Maps coordinates in `source` to `target` at `time`.
  TransformResult lookup(std::string_view target, std::string_view source,
                         Time time = kLatestTransform) const;
  /// Maps coordinates in `source` at `source_time` to `target` at `target_time`, over `fixed`, a
  /// frame that does not move in between (`odom`, `map`): where something seen then is now.
  TransformResult lookup(std::string_view target, Time target_time, std::string_view source,
                         Time source_time, std::string_view fixed) const;
  /// True when `lookup` would succeed; else `reason`, when given, is why not.
  [[nodiscard]] bool can_transform(std::string_view target, std::string_view source,
                                   Time time = kLatestTransform,
                                   TransformFailure* reason = nullptr) const;

  /// Sorted by name.
  [[nodiscard]] std::vector<TransformFrame> frames() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pipescout
