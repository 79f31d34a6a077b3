// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <string_view>
#include <type_traits>

#include "pipescout/estimation/fingerprint.hpp"
#include "pipescout/estimation/state.hpp"

/// What a factor is. The factors of this library and those of its users are made by the same means:
/// a class of fixed size with a time, a residual and derivatives. SI units, radians; times in
/// seconds of any one clock. Frames as in state.hpp.
namespace pipescout::estimation {

inline constexpr std::size_t kOwnFactorKinds = 16;
/// By kind robustness is chosen, and measurements are counted and reported.
enum class FactorKind : std::uint8_t {
  kImu,
  kPrior,
  kGps,
  kHeading,
  kVisualPose,
  kWeld,
  kNonHolonomic,
  kZeroVelocity,
  kOdometer,
  kRelativePose,
  kZeroAngularRate,
  kCentreLine,
  kOwn,  ///< and `kOwnFactorKinds` - 1 that follow it: see `own_kind`
};
inline constexpr std::size_t kFactorKinds =
    static_cast<std::size_t>(FactorKind::kOwn) + kOwnFactorKinds;

/// Kinds for factors of the user; `i` in [0, kOwnFactorKinds), not checked.
[[nodiscard]] constexpr FactorKind own_kind(std::size_t i) noexcept {
  return static_cast<FactorKind>(static_cast<std::size_t>(FactorKind::kOwn) + i);
}

/// "imu", "prior", "gps", "heading", "visual_pose", "weld", "non_holonomic", "zero_velocity",
/// "odometer", "relative_pose", "zero_angular_rate", "centre_line", "own_0" to "own_15"; "unknown"
/// for any other value.
[[nodiscard]] std::string_view to_string(FactorKind kind) noexcept;

/// Faults of a measurement's values.
enum class InputFault : std::uint8_t {
  kNone,
  kNotFinite,      ///< a NaN or infinity
  kBadCovariance,  ///< a standard deviation outside [1e-9, 1e9], or a covariance that is not
                   ///< symmetric and positive definite
  kBadInterval,    ///< `to_time` is not after `from_time`
  kBadDirection,   ///< its norm differs from 1 by more than 1e-6
};

/// Most rows that a factor may have.
inline constexpr int kMaxFactorRows = 6;

/// A factor of one time has
///
///     static constexpr int kRows;           // of the residual, 1 to kMaxFactorRows
///     double time() const;
///     Eigen::Matrix<double, kRows, 1> evaluate(const NavState& x, const GlobalStates& globals,
///                                              Jacobians<kRows>* derivatives) const;
///
/// and one of two times has `from_time()` and `to_time()` and an `evaluate` of two states. They
/// return the whitened residual, which has unit covariance if the covariance of the measurement is
/// right. Where `derivatives` is not null it is zero, and the whitened derivatives that are not
/// zero are set in it. Neither throws or allocates; both are pure. A residual that is not finite
/// says that the factor is undefined at that state: it is left out there.
///
/// It may have
///
///     InputFault fault() const;             // of its numbers; else: whether its times are finite
///     void identify(Fingerprint&) const;    // what tells it from others of its kind and time;
///                                           // else: the residual at some state
///     static constexpr bool kUsesGlobals;   // else: true
///     static constexpr bool kNeedsMap;      // whether it depends on position, heading or velocity
///                                           // in the map; else: true of one time, false of two
///
/// It is copied without throwing or allocating, and is no larger than AnyFactor::kMaxSize.
template <class F>
concept FactorOfOneTime = requires(const F& f, const NavState& x, const GlobalStates& globals,
                                   Jacobians<F::kRows>* derivatives) {
  { f.time() } -> std::convertible_to<double>;
  {
    f.evaluate(x, globals, derivatives)
    } -> std::convertible_to<Eigen::Matrix<double, F::kRows, 1>>;
};
template <class F>
concept FactorOfTwoTimes = requires(const F& f, const NavState& x, const GlobalStates& globals,
                                    Jacobians<F::kRows>* derivatives) {
  { f.from_time() } -> std::convertible_to<double>;
  { f.to_time() } -> std::convertible_to<double>;
  {
    f.evaluate(x, x, globals, derivatives)
    } -> std::convertible_to<Eigen::Matrix<double, F::kRows, 1>>;
};
template <class F>
concept Factor = FactorOfOneTime<F> || FactorOfTwoTimes<F>;

/// A factor from a measurement without faults according to `check(measurement)`, which is a
/// precondition. The base of this library's own; the derived classes differ in `evaluate`.
template <class Measurement, int Rows>
class WhitenedFactor {
 public:
  using MeasurementType = Measurement;
  static constexpr int kRows = Rows;
  using Residual = Eigen::Matrix<double, Rows, 1>;
  using Derivatives = Jacobians<Rows>;

  explicit WhitenedFactor(const Measurement& measurement) : measurement_(measurement) {}
  [[nodiscard]] const Measurement& measurement() const noexcept { return measurement_; }
  [[nodiscard]] double time() const noexcept requires requires(const Measurement& m) { m.time; }
  { return measurement_.time; }
  [[nodiscard]] double from_time() const noexcept requires requires(const Measurement& m) {
    m.from_time;
  }
  { return measurement_.from_time; }
  [[nodiscard]] double to_time() const noexcept requires requires(const Measurement& m) {
    m.to_time;
  }
  { return measurement_.to_time; }
  [[nodiscard]] InputFault fault() const noexcept { return check(measurement_); }
  void identify(Fingerprint& fingerprint) const { add_values(measurement_, fingerprint); }

 protected:
  Measurement measurement_;
  /// W with W^T W the inverse of the covariance.
  Eigen::Matrix<double, Rows, Rows, Eigen::DontAlign> whitening_;
};

/// One that is always of the same kind.
template <class Measurement, FactorKind Kind, int Rows>
class MeasuredFactor : public WhitenedFactor<Measurement, Rows> {
 public:
  static constexpr FactorKind kKind = Kind;
  using WhitenedFactor<Measurement, Rows>::WhitenedFactor;
};

/// What a factor says at one place. Rows from `rows` on, and derivatives that were not asked for,
/// are not set.
struct FactorValue {
  template <int Columns>
  using Rows = Eigen::Matrix<double, kMaxFactorRows, Columns, Eigen::RowMajor>;
  int rows = 0;
  Eigen::Matrix<double, kMaxFactorRows, 1> residual;
  Rows<kStateSize> from;
  Rows<kStateSize> to;  ///< zero for factors of one time
  Rows<kGlobalSize> globals;
};

/// Any factor, held in place: never allocates.
class AnyFactor {
 public:
  static constexpr std::size_t kMaxSize = 1024;

  /// The factor of a measurement of factors.hpp, of a kind of the caller's.
  template <class Measurement>
  requires requires { typename Measurement::FactorType; }
  AnyFactor(const Measurement& m, FactorKind kind)
      : AnyFactor(typename Measurement::FactorType(m), kind) {}
  /// Of its own kind, if it has one. Implicit: each of them is a factor.
  template <class Measurement>
  requires requires { Measurement::FactorType::kKind; }
  AnyFactor(const Measurement& m)  // NOLINT(google-explicit-constructor)
      : AnyFactor(typename Measurement::FactorType(m), Measurement::FactorType::kKind) {}
  template <Factor F>
  AnyFactor(const F& factor, FactorKind kind) : table_(&kTable<F>), kind_(kind) {
    static_assert(F::kRows >= 1 && F::kRows <= kMaxFactorRows, "a factor has 1 to 6 rows");
    static_assert(sizeof(F) <= kMaxSize && alignof(F) <= kAlignment, "the factor is too large");
    std::construct_at(reinterpret_cast<F*>(storage_), factor);
    if constexpr (FactorOfTwoTimes<F>) {
      from_time_ = factor.from_time();
      to_time_ = factor.to_time();
    } else {
      from_time_ = to_time_ = factor.time();
    }
    Fingerprint fingerprint;
    fingerprint.add(static_cast<std::uint64_t>(kind)).add(from_time_).add(to_time_);
    if constexpr (requires { factor.identify(fingerprint); }) {
      factor.identify(fingerprint);
    } else if constexpr (FactorOfTwoTimes<F>) {
      fingerprint.add(factor.evaluate(some_state(), NavState{}, GlobalStates{}, nullptr));
    } else {
      fingerprint.add(factor.evaluate(some_state(), GlobalStates{}, nullptr));
    }
    fingerprint_ = fingerprint.value();
  }
  AnyFactor(const AnyFactor& other)
      : table_(other.table_),
        kind_(other.kind_),
        from_time_(other.from_time_),
        to_time_(other.to_time_),
        fingerprint_(other.fingerprint_),
        scale_(other.scale_) {
    table_->copy(other.storage_, storage_);
  }
  AnyFactor& operator=(const AnyFactor& other) {
    if (this != &other) {
      std::destroy_at(this);
      std::construct_at(this, other);
    }
    return *this;
  }
  ~AnyFactor() { table_->destroy(storage_); }

  [[nodiscard]] FactorKind kind() const noexcept { return kind_; }
  [[nodiscard]] int rows() const noexcept { return table_->rows; }
  [[nodiscard]] bool is_of_two_times() const noexcept { return table_->two_times; }
  [[nodiscard]] bool uses_globals() const noexcept { return table_->uses_globals; }
  [[nodiscard]] bool needs_map() const noexcept { return table_->needs_map; }
  /// s; equal for a factor of one time.
  [[nodiscard]] double from_time() const noexcept { return from_time_; }
  [[nodiscard]] double to_time() const noexcept { return to_time_; }
  /// Of kind, times and numbers: equal for a measurement that comes again.
  [[nodiscard]] std::uint64_t fingerprint() const noexcept { return fingerprint_; }
  /// Of its numbers; kNotFinite or kBadInterval also of its times.
  [[nodiscard]] InputFault fault() const noexcept;
  /// Multiplies the covariance of the measurement; `factor` > 0, not checked.
  void scale_covariance(double factor) noexcept;
  /// `to` is not used by a factor of one time.
  void evaluate(const NavState& from, const NavState& to, const GlobalStates& globals,
                bool with_derivatives, FactorValue& value) const;

 private:
  static constexpr std::size_t kAlignment = 32;
  struct Table {
    int rows;
    bool two_times;
    bool uses_globals;
    bool needs_map;
    void (*copy)(const std::byte* from, std::byte* to);
    void (*destroy)(std::byte* factor);
    InputFault (*fault)(const std::byte* factor);
    void (*evaluate)(const std::byte* factor, const NavState& from, const NavState& to,
                     const GlobalStates& globals, bool with_derivatives, FactorValue& value);
  };

  /// Where two different measurements hardly have the same residual.
  [[nodiscard]] static const NavState& some_state();

  template <class F>
  static const F& as(const std::byte* storage) {
    return *std::launder(reinterpret_cast<const F*>(storage));
  }
  template <class F>
  static void evaluate_one(const std::byte* storage, const NavState& from, const NavState& to,
                           const GlobalStates& globals, bool with_derivatives, FactorValue& value) {
    constexpr int kRows = F::kRows;
    value.rows = kRows;
    const auto residual = [&](Jacobians<kRows>* derivatives) {
      if constexpr (FactorOfTwoTimes<F>) {
        value.residual.head<kRows>() = as<F>(storage).evaluate(from, to, globals, derivatives);
      } else {
        value.residual.head<kRows>() = as<F>(storage).evaluate(from, globals, derivatives);
      }
    };
    if (!with_derivatives) {
      residual(nullptr);
      return;
    }
    Jacobians<kRows> derivatives;
    residual(&derivatives);
    value.from.topRows<kRows>() = derivatives.from;
    value.to.topRows<kRows>() = derivatives.to;
    value.globals.topRows<kRows>() = derivatives.globals;
  }
  template <class F>
  static InputFault fault_of(const std::byte* storage) {
    if constexpr (requires { as<F>(storage).fault(); }) {
      return as<F>(storage).fault();
    } else {
      return InputFault::kNone;
    }
  }
  template <class F>
  static constexpr bool uses_globals_of() {
    if constexpr (requires { F::kUsesGlobals; }) {
      return F::kUsesGlobals;
    } else {
      return true;
    }
  }
  template <class F>
  static constexpr bool needs_map_of() {
    if constexpr (requires { F::kNeedsMap; }) {
      return F::kNeedsMap;
    } else {
      return !FactorOfTwoTimes<F>;
    }
  }
  template <class F>
  static constexpr Table kTable = {
      F::kRows,
      FactorOfTwoTimes<F>,
      uses_globals_of<F>(),
      needs_map_of<F>(),
      [](const std::byte* from, std::byte* to) {
        std::construct_at(reinterpret_cast<F*>(to), as<F>(from));
      },
      [](std::byte* factor) { std::destroy_at(std::launder(reinterpret_cast<F*>(factor))); },
      &fault_of<F>,
      &evaluate_one<F>,
  };

  const Table* table_;
  FactorKind kind_;
  double from_time_ = 0;
  double to_time_ = 0;
  std::uint64_t fingerprint_ = 0;
  double scale_ = 1;  // on residual and derivatives
  alignas(kAlignment) std::byte storage_[kMaxSize];
};

}  // namespace pipescout::estimation
