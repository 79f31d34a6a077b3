// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <bit>
#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/runtime/parameter_value.hpp"

/// The parameters of one node, with the semantics of ROS 2 (rclcpp): declared with type, range and
/// description before use, and statically typed. Any client may set them; the callbacks below can
/// adjust or refuse a set.
namespace pipescout {

/// A parameter cannot be declared or read. The message names the parameter and, for a value from
/// outside the code, its source ("robot.yaml:12: parameter 'gain': ...").
class ParameterError : public std::runtime_error {
 public:
  ParameterError(std::string name, const std::string& message)
      : std::runtime_error(message), name_(std::move(name)) {}
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  std::string name_;
};

/// Values from..to, both included; with a step, only from + k step, and `to` itself.
struct IntegerRange {
  std::int64_t from = std::numeric_limits<std::int64_t>::min();
  std::int64_t to = std::numeric_limits<std::int64_t>::max();
  std::uint64_t step = 0;  ///< 0: any value in the range
  bool operator==(const IntegerRange&) const = default;
};

/// Values from..to, both included and exact; with a step, only from + k step up to rounding errors,
/// and `to` itself. NaN is in no range.
struct FloatingPointRange {
  double from = -std::numeric_limits<double>::infinity();
  double to = std::numeric_limits<double>::infinity();
  double step = 0.0;  ///< 0: any value in the range
  bool operator==(const FloatingPointRange&) const = default;
};

/// `rcl_interfaces/msg/ParameterDescriptor`, to be written with designated initialisers:
/// `{.description = "...", .integer_range = IntegerRange{2, 16}}`. A range also holds for each
/// element of an array.
struct ParameterDescriptor {
  std::string name{};
  ParameterType type = ParameterType::kNotSet;
  std::string description{};
  std::string additional_constraints{};
  bool read_only = false;       ///< fixed once declared
  bool dynamic_typing = false;  ///< a set may change the type, and may undeclare the parameter
  std::optional<FloatingPointRange> floating_point_range{};
  std::optional<IntegerRange> integer_range{};
  bool operator==(const ParameterDescriptor&) const = default;

  /// Throws ParameterError when the name has empty parts, spaces or control characters, a range is
  /// empty or has a negative or unusable step, or does not go with the type.
  void validate() const;

  /// The reason why the value is invalid (type, range), or nothing when it is valid. The text gives
  /// the value and the expectation, not the parameter.
  [[nodiscard]] std::optional<std::string> objection(const ParameterValue& value) const;
};

/// "[0, 10]", "[0, 10] in steps of 2"; "at most 5", "at least 0" for a range open at one end.
[[nodiscard]] std::string to_string(const IntegerRange& range);
[[nodiscard]] std::string to_string(const FloatingPointRange& range);

/// `rcl_interfaces/msg/SetParametersResult`.
struct SetResult {
  bool successful = true;
  /// The reason of a failure. For a successful set: an error in an `on_changed` callback, else
  /// empty.
  std::string reason{};

  [[nodiscard]] static SetResult accept() { return {}; }
  [[nodiscard]] static SetResult refuse(std::string reason) { return {false, std::move(reason)}; }
  bool operator==(const SetResult&) const = default;
};

/// The content of `/parameter_events`.
struct ParameterChange {
  std::vector<NamedParameter> new_parameters{};
  std::vector<NamedParameter> changed_parameters{};
  std::vector<NamedParameter> deleted_parameters{};  ///< with their last value
  bool operator==(const ParameterChange&) const = default;
};

/// Result of `Parameters::list`, sorted.
struct ParameterList {
  std::vector<std::string> names{};
  std::vector<std::string> prefixes{};  ///< of the names, up to the last '.'
  bool operator==(const ParameterList&) const = default;
};

/// An override of a parameter that was not declared.
struct UnusedOverride {
  ParameterOverride parameter;
  std::optional<std::string> nearest;  ///< the most similar declared name
};

/// "robot.yaml:12: no parameter 'gian'; did you mean 'gain'?"
[[nodiscard]] std::string to_string(const UnusedOverride& unused);

namespace detail {

/// The current value of one parameter: written by its `Parameters`, read from any thread.
class ParameterCell {
 public:
  ParameterCell(std::string name, std::shared_ptr<const ParameterValue> value);

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] std::shared_ptr<const ParameterValue> load() const;
  /// Never null.
  void store(std::shared_ptr<const ParameterValue> value) noexcept;

  /// Lock-free; the result is unspecified unless the value is a boolean, integer or double.
  template <class T>
  [[nodiscard]] T load_scalar() const noexcept {
    const std::uint64_t bits = scalar_.load(std::memory_order_acquire);
    if constexpr (std::same_as<T, double>) {
      return std::bit_cast<double>(bits);
    } else {
      return static_cast<T>(static_cast<std::int64_t>(bits));
    }
  }

 private:
  std::string name_;
  std::atomic<std::uint64_t> scalar_;
  mutable std::mutex mutex_;
  std::shared_ptr<const ParameterValue> value_;
};

/// The stored type for a C++ type: itself, or int64 for the other integers.
template <class T>
struct ParameterStored;
template <ParameterAlternative T>
struct ParameterStored<T> {
  using Type = T;
};
template <PlainInteger T>
requires(!ParameterAlternative<T>) struct ParameterStored<T> {
  using Type = std::int64_t;
};

template <class T>
concept ParameterCompatible = requires {
  typename ParameterStored<T>::Type;
};

template <class T, class... Alternatives>
consteval ParameterType type_of(const std::variant<Alternatives...>*) {
  std::uint8_t index = 0;
  (void)((std::same_as<T, Alternatives> || (++index, false)) || ...);
  return static_cast<ParameterType>(index);
}

template <ParameterCompatible T>
inline constexpr ParameterType kTypeOf =
    type_of<typename ParameterStored<T>::Type>(static_cast<const ParameterStorage*>(nullptr));

}  // namespace detail

/// A typed view of a declared parameter that always has its current value. Cheap to copy; usable
/// from any thread, also after the node is destroyed (it then keeps the last value). An empty
/// handle (default constructed) has no value.
template <detail::ParameterCompatible T>
class Parameter {
 public:
  Parameter() = default;

  /// The current value. Lock-free for booleans and numbers; strings and arrays are copied, use
  /// `share` where that matters. Throws std::logic_error for an empty handle.
  [[nodiscard]] T get() const {
    if constexpr (std::is_arithmetic_v<T>) {
      return static_cast<T>(cell().template load_scalar<Stored>());
    } else {
      return *share();
    }
  }

  /// The current value without a copy; a later set leaves this object untouched.
  [[nodiscard]] std::shared_ptr<const T> share() const requires(!std::is_arithmetic_v<T>) {
    std::shared_ptr<const ParameterValue> value = cell().load();
    const T* content = &value->template get<T>();
    return {std::move(value), content};
  }

  [[nodiscard]] const std::string& name() const { return cell().name(); }
  [[nodiscard]] explicit operator bool() const noexcept { return cell_ != nullptr; }

 private:
  friend class Parameters;
  using Stored = typename detail::ParameterStored<T>::Type;

  explicit Parameter(std::shared_ptr<const detail::ParameterCell> cell) : cell_(std::move(cell)) {}
  [[nodiscard]] const detail::ParameterCell& cell() const {
    if (!cell_) {
      throw std::logic_error("a parameter handle is used before its parameter was declared");
    }
    return *cell_;
  }

  std::shared_ptr<const detail::ParameterCell> cell_;
};

/// Keeps a callback registered; destroying it unregisters. Once the destructor returned, no call is
/// in progress on another thread and none follows; a callback may destroy its own handle. So do not
/// destroy it while holding a lock that the callback takes. May outlive the `Parameters`.
class [[nodiscard]] ParameterCallbackHandle {
 public:
  ParameterCallbackHandle() = default;
  explicit ParameterCallbackHandle(std::function<void()> unregister)
      : unregister_(std::move(unregister)) {}
  ParameterCallbackHandle(ParameterCallbackHandle&& other) noexcept
      : unregister_(std::exchange(other.unregister_, nullptr)) {}
  ParameterCallbackHandle& operator=(ParameterCallbackHandle&& other) noexcept;
  ParameterCallbackHandle(const ParameterCallbackHandle&) = delete;
  ParameterCallbackHandle& operator=(const ParameterCallbackHandle&) = delete;
  ~ParameterCallbackHandle() { reset(); }

  void reset();

 private:
  std::function<void()> unregister_;
};

/// The parameters of one node. Thread-safe. Declarations and sets happen one after the other, with
/// their callbacks, on the calling thread; reading never waits for a callback, and callbacks may
/// read. A callback that declares, sets or undeclares is refused, as in rclcpp. Parameters that
/// were not declared cannot be set.
class Parameters {
 public:
  /// Before a set is validated: may change, add and remove proposed parameters.
  using AdjustCallback = std::function<void(std::vector<NamedParameter>&)>;
  /// Before a set, after the checks of types and ranges, and before a declaration with its initial
  /// value: may refuse. Must have no side effects, since a later callback may refuse.
  using ValidateCallback = std::function<SetResult(const std::vector<NamedParameter>&)>;
  /// After a set (not after a declaration), when the new values are visible to all readers.
  using ChangedCallback = std::function<void(const std::vector<NamedParameter>&)>;
  /// After each declaration and each change, in order. An exception from it reaches the caller of
  /// the declaration or set, whose effect stays.
  using EventSink = std::function<void(const ParameterChange&)>;

  /// Of two overrides with the same name the later one is used.
  explicit Parameters(std::vector<ParameterOverride> overrides = {});
  ~Parameters();
  Parameters(const Parameters&) = delete;
  Parameters& operator=(const Parameters&) = delete;

  /// Declares a parameter; the initial value is that of its override, else `default_value`.
  /// The type is that of the descriptor or, if not set there, that of the default. Without any
  /// value the parameter is declared but not set. Types are strict, as in ROS 2: 1 is no double.
  /// But an empty array fits every array type, since YAML does not tell of what it is empty, and a
  /// text that is wholly a number fits a double, since `ros2 param load` sends small ones as texts.
  /// Throws ParameterError for an invalid descriptor or default, a name already declared, one that
  /// is a part of another ("line" and "line.width", a value and a map in YAML), an override of the
  /// wrong type or out of range, or an initial value that a callback refuses.
  ParameterValue declare(ParameterDescriptor descriptor, ParameterValue default_value = {});

  /// The same with a C++ type: bool, double, std::string, any integer, std::vector of
  /// std::uint8_t, bool, std::int64_t, double or std::string. Integers narrower than int64 get the
  /// limits of their type as range. Name and type of the descriptor are filled in.
  // The type of the name is deduced, so that a braced descriptor is never taken for a name.
  template <detail::ParameterCompatible T, std::convertible_to<std::string> Name>
  Parameter<T> declare(Name&& name, const T& default_value, ParameterDescriptor descriptor = {}) {
    return declare_typed<T>(std::forward<Name>(name), default_value, std::move(descriptor));
  }

  /// A required parameter: throws ParameterError when no override sets it.
  template <detail::ParameterCompatible T>
  Parameter<T> declare_required(std::string name, ParameterDescriptor descriptor = {}) {
    require_override(name, detail::kTypeOf<T>);
    return declare_typed<T>(std::move(name), {}, std::move(descriptor));
  }

  /// A typed view of a declared parameter. Throws ParameterError when it is not declared, has no
  /// value, or has another type or dynamic typing.
  template <detail::ParameterCompatible T>
  [[nodiscard]] Parameter<T> handle(const std::string& name) const {
    return Parameter<T>(cell(name, detail::kTypeOf<T>, limits_of<T>()));
  }

  /// Removes a dynamically typed parameter. Throws ParameterError when it is not declared, is
  /// read-only or statically typed.
  void undeclare(const std::string& name);

  [[nodiscard]] bool has(const std::string& name) const;
  /// Throws ParameterError when the parameter is not declared, or statically typed and not set.
  [[nodiscard]] ParameterValue get(const std::string& name) const;
  /// Values that were current at one moment: no set falls between them. Throws like `get`.
  [[nodiscard]] std::vector<ParameterValue> get_many(const std::vector<std::string>& names) const;
  /// Nothing when the parameter is not declared or not set.
  [[nodiscard]] std::optional<ParameterValue> get_optional(const std::string& name) const;
  /// All parameters at one moment, sorted by name.
  [[nodiscard]] std::vector<NamedParameter> all() const;

  /// As the service `list_parameters` of Humble. No prefixes: all names with fewer than `depth`
  /// separators ('.'). With prefixes: names equal to a prefix, and names below it with fewer than
  /// `depth` separators after the prefix, the one that ends the prefix included. Depth 0: all.
  [[nodiscard]] ParameterList list(const std::vector<std::string>& prefixes = {},
                                   std::uint64_t depth = 0) const;
  /// Throw ParameterError when one of the parameters is not declared.
  [[nodiscard]] std::vector<ParameterDescriptor> describe(
      const std::vector<std::string>& names) const;
  [[nodiscard]] std::vector<ParameterType> types(const std::vector<std::string>& names) const;

  /// One result each; each parameter is set or refused independently. Sets never throw for invalid
  /// values.
  std::vector<SetResult> set(const std::vector<NamedParameter>& parameters);
  SetResult set(const std::string& name, ParameterValue value);
  /// Atomic: all or none. A value that is not set undeclares a dynamically typed parameter.
  SetResult set_atomically(const std::vector<NamedParameter>& parameters);

  /// Callbacks of one kind are called last registered first, as in rclcpp. An exception from an
  /// `on_adjust` or `on_validate` callback refuses the set with its message. An exception from an
  /// `on_changed` callback cannot undo the set: it becomes the reason of a successful result, and
  /// the other callbacks are still called.
  ParameterCallbackHandle on_adjust(AdjustCallback callback);
  ParameterCallbackHandle on_validate(ValidateCallback callback);
  ParameterCallbackHandle on_changed(ChangedCallback callback);
  /// Replaces the sink; an empty one removes it.
  void set_event_sink(EventSink sink);

  /// Overrides of parameters that have not been declared so far.
  [[nodiscard]] std::vector<UnusedOverride> unused_overrides() const;

 private:
  struct State;

  template <class T>
  static std::optional<IntegerRange> limits_of() {
    if constexpr (detail::PlainInteger<T> && !detail::ParameterAlternative<T>) {
      using Limits = std::numeric_limits<T>;
      constexpr auto kMax = std::numeric_limits<std::int64_t>::max();
      return IntegerRange{
          static_cast<std::int64_t>(Limits::min()),
          std::cmp_greater(Limits::max(), kMax) ? kMax : static_cast<std::int64_t>(Limits::max())};
    } else {
      return std::nullopt;
    }
  }

  template <class T>
  Parameter<T> declare_typed(std::string name, ParameterValue default_value,
                             ParameterDescriptor descriptor) {
    descriptor.name = std::move(name);
    descriptor.type = detail::kTypeOf<T>;
    return Parameter<T>(
        declare_static(std::move(descriptor), std::move(default_value), limits_of<T>()));
  }

  std::shared_ptr<const detail::ParameterCell> declare_static(ParameterDescriptor descriptor,
                                                              ParameterValue default_value,
                                                              std::optional<IntegerRange> limits);
  void require_override(const std::string& name, ParameterType type) const;
  [[nodiscard]] std::shared_ptr<const detail::ParameterCell> cell(
      const std::string& name, ParameterType type, std::optional<IntegerRange> limits) const;

  std::shared_ptr<State> state_;
};

}  // namespace pipescout
