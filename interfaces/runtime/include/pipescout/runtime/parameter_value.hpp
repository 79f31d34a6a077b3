// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace pipescout {

/// The numbers are those of `rcl_interfaces/msg/ParameterType`.
enum class ParameterType : std::uint8_t {
  kNotSet = 0,
  kBool = 1,
  kInteger = 2,
  kDouble = 3,
  kString = 4,
  kByteArray = 5,
  kBoolArray = 6,
  kIntegerArray = 7,
  kDoubleArray = 8,
  kStringArray = 9,
};

/// "not set", "boolean", "integer", "double", "string", "byte array", "boolean array", ...
[[nodiscard]] const char* to_string(ParameterType type) noexcept;
[[nodiscard]] bool is_array(ParameterType type) noexcept;

namespace detail {

template <class T>
inline constexpr bool kIsCharacter =
    std::same_as<T, char> || std::same_as<T, wchar_t> || std::same_as<T, char8_t> ||
    std::same_as<T, char16_t> || std::same_as<T, char32_t>;

template <class T>
concept PlainInteger = std::integral<T> && !std::same_as<T, bool> && !kIsCharacter<T>;

using ParameterStorage =
    std::variant<std::monostate, bool, std::int64_t, double, std::string, std::vector<std::uint8_t>,
                 std::vector<bool>, std::vector<std::int64_t>, std::vector<double>,
                 std::vector<std::string>>;

template <class T, class Storage>
inline constexpr bool kIsAlternative = false;
template <class T, class... Alternatives>
inline constexpr bool kIsAlternative<T, std::variant<Alternatives...>> =
    (std::same_as<T, Alternatives> || ...);

template <class T>
concept ParameterAlternative =
    kIsAlternative<T, ParameterStorage> && !std::same_as<T, std::monostate>;

}  // namespace detail

/// The value of a parameter: one of the types of ROS 2, or not set. A regular value type; two
/// values are equal when type and content are equal (so NaN differs from itself).
class ParameterValue {
 public:
  ParameterValue() = default;

  template <detail::ParameterAlternative T>
  ParameterValue(T value)  // NOLINT(google-explicit-constructor): a literal is a value
      : storage_(std::in_place_type<T>, std::move(value)) {}
  /// Throws std::out_of_range for an unsigned value above the largest int64.
  template <detail::PlainInteger T>
  requires(!detail::ParameterAlternative<T>)
      ParameterValue(T value)  // NOLINT(google-explicit-constructor)
      : storage_(std::in_place_type<std::int64_t>, to_int64(value)) {}
  ParameterValue(float value)  // NOLINT(google-explicit-constructor)
      : storage_(std::in_place_type<double>, static_cast<double>(value)) {}
  ParameterValue(const char* value)  // NOLINT(google-explicit-constructor)
      : storage_(std::in_place_type<std::string>, value) {}
  ParameterValue(std::string_view value)  // NOLINT(google-explicit-constructor)
      : storage_(std::in_place_type<std::string>, value) {}

  [[nodiscard]] ParameterType type() const noexcept {
    return static_cast<ParameterType>(storage_.index());
  }
  [[nodiscard]] bool is_set() const noexcept { return type() != ParameterType::kNotSet; }

  /// `T` is exactly the stored type. Throws std::bad_variant_access when the value is of another.
  template <detail::ParameterAlternative T>
  [[nodiscard]] const T& get() const {
    return std::get<T>(storage_);
  }
  /// Null when the value is of another type.
  template <detail::ParameterAlternative T>
  [[nodiscard]] const T* get_if() const noexcept {
    return std::get_if<T>(&storage_);
  }
  /// Calls the visitor with the stored value, std::monostate when there is none.
  template <class Visitor>
  decltype(auto) visit(Visitor&& visitor) const {
    return std::visit(std::forward<Visitor>(visitor), storage_);
  }

  bool operator==(const ParameterValue&) const = default;

 private:
  template <class T>
  static std::int64_t to_int64(T value) {
    if (!std::in_range<std::int64_t>(value)) {
      throw std::out_of_range("integer parameter value " + std::to_string(value) +
                              " is above the largest, " +
                              std::to_string(std::numeric_limits<std::int64_t>::max()));
    }
    return static_cast<std::int64_t>(value);
  }

  detail::ParameterStorage storage_;
};

static_assert(std::variant_size_v<detail::ParameterStorage> == 10);

/// As `ros2 param get --hide-type` prints it, in Python's notation: True, 7, 1.0, 1e-07, text
/// without quotes, [True, False], ['a', 'b'], array('q', [1, 2]), array('d', [0.5]), [b'\x01'];
/// None when not set.
[[nodiscard]] std::string to_string(const ParameterValue& value);

/// What `ros2 param get` prints before the value: "Integer value is:", "Double values are:";
/// "Parameter not set." when there is none.
[[nodiscard]] const char* value_label(ParameterType type) noexcept;

/// As YAML in one line, read back to an equal value by `parse_parameter_value`: true, 7, 1.0,
/// "text" (quoted only where needed), [1, 2], !!binary "AQ==". "null" when not set. Empty arrays
/// all read "[]".
[[nodiscard]] std::string to_yaml(const ParameterValue& value);

/// What a user typed on a command line, as `ros2 param set` takes it: 1 is an integer, 1.0 and 1e3
/// doubles, true a boolean, [1, 2] an integer array, '1' and "1" strings, and so is everything else
/// (also "" and "null"). Scalars are typed as in parameter files, see `type_yaml_scalar`. [] is an
/// empty array, which fits a parameter of any array type. Throws std::invalid_argument for an array
/// of mixed or nested content and for numbers out of range.
[[nodiscard]] ParameterValue parse_parameter_value(const std::string& text);

/// The type of an unquoted YAML scalar by the rules of rcl_yaml_param_parser, in this order:
/// boolean (true, yes, on, y, ...: YAML 1.1), integer (decimal, 0x hexadecimal, leading 0 octal),
/// double (also nan, inf, .nan, .inf), else string. One rule is stricter: a whole number outside
/// int64 and a number outside double throw std::out_of_range instead of changing their type.
[[nodiscard]] ParameterValue type_yaml_scalar(std::string_view text);

/// One parameter of a node, `rcl_interfaces/msg/Parameter`.
struct NamedParameter {
  std::string name;
  ParameterValue value;
  bool operator==(const NamedParameter&) const = default;
};

/// A parameter value from outside the code: a file, the command line.
struct ParameterOverride {
  std::string name{};
  ParameterValue value{};
  std::string source{};  ///< for messages: "file:line", "command line"
  /// It applies to many nodes at once (`/**`): a node without that parameter is not an error.
  bool from_wildcard = false;
  bool operator==(const ParameterOverride&) const = default;
};

/// `name:=value` or `node:name:=value`, as `ros2 run ... --ros-args -p` takes it.
struct ParameterRule {
  std::string node;  ///< name without namespace, or empty: for every node
  ParameterOverride parameter;

  /// `source` goes into the override. Throws std::invalid_argument when the text has no `:=`, the
  /// name is empty, or the value is malformed.
  [[nodiscard]] static ParameterRule parse(const std::string& text,
                                           const std::string& source = "command line");
};

}  // namespace pipescout
