// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "chain_elimination.hpp"
#include "pipescout/estimation/carried_factor.hpp"
#include "pipescout/estimation/fixed_lag_smoother.hpp"
#include "pipescout/estimation/imu_timeline.hpp"

namespace pipescout::estimation {

/// Times that differ by less are one, s.
inline constexpr double kSameTime = 1e-4;

/// Place of a kind in arrays over all kinds.
[[nodiscard]] inline std::size_t index_of(FactorKind kind) {
  return static_cast<std::size_t>(kind);
}

/// A measurement with what ties it to the keyframes.
struct PlacedFactor {
  AnyFactor factor;
  CarryingMotions motions{};
  bool to_next = false;
  bool fresh = true;    // came in with this update
  bool judged = false;  // by its kernel, not only fitted
  double weight = 1;    // as linearised
};

struct Keyframe {
  double time = 0;
  NavState linear{};    // where it is linearised
  NavState estimate{};  // linear.retract(delta)
  StateVector delta = StateVector::Zero();
  StateVector linearised_delta = StateVector::Zero();  // `delta` when the residuals were taken
  std::optional<ImuFactor> link{};                     // to the next keyframe
  double coasted = 0;                                  // s of it without the IMU
  std::vector<PlacedFactor> factors{};
  Clique clique{};
  Message in{};  // from the keyframes before, or what is known beforehand
  Eliminated eliminated{};
  bool dirty = true;  // `clique` is not that of the factors
};

/// Transposed derivatives of N numbers by the globals that are estimated.
template <int N>
using GlobalRows = Eigen::Matrix<double, Eigen::Dynamic, N, 0, kGlobalSize, N>;

class FixedLagSmoother::Implementation {
 public:
  explicit Implementation(const FixedLagSmootherParameters& parameters);

  void initialise(double time, const NavState& mean, const StateMatrix& covariance);
  void restart(double time, const NavState& mean, const StateMatrix& covariance);
  void set_earth(const Earth& earth) { parameters_.earth = earth; }
  Outcome add_imu(const ImuSample& sample) noexcept;
  Outcome add(const AnyFactor& factor) noexcept;
  void update(double time) noexcept;

  // smoother_output.cpp
  [[nodiscard]] StateMatrix covariance(std::size_t keyframe) const noexcept;
  [[nodiscard]] Eigen::Matrix<double, kGlobalSize, kGlobalSize> global_covariance() const noexcept;
  [[nodiscard]] std::optional<Propagated> propagated() const noexcept;
  [[nodiscard]] StateMatrix propagated_covariance() const noexcept;
  void report_factors(std::vector<FactorReport>& reports) const;

  [[nodiscard]] const Keyframe& keyframe(std::size_t i) const noexcept {
    return ring_[(first_ + i) % ring_.size()];
  }
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] const GlobalStates& globals() const noexcept { return globals_; }
  [[nodiscard]] const UpdateReport& report() const noexcept { return report_; }
  [[nodiscard]] const OutcomeCounts& counts(FactorKind kind) const noexcept {
    return counts_[index_of(kind)];
  }

 private:
  [[nodiscard]] Keyframe& keyframe(std::size_t i) noexcept {
    return ring_[(first_ + i) % ring_.size()];
  }
  [[nodiscard]] Keyframe& newest() noexcept { return keyframe(count_ - 1); }
  [[nodiscard]] const Keyframe& newest() const noexcept { return keyframe(count_ - 1); }
  void begin(double time, const NavState& mean, const PriorFactor& prior);
  Outcome count(FactorKind kind, Outcome outcome) noexcept;
  void reset(ResetReason reason) noexcept;
  /// Counts and reports.
  void note(const PlacedFactor& factor, Outcome outcome, double chi_square);

  // smoother_input.cpp
  [[nodiscard]] bool is_known(std::uint64_t fingerprint) const noexcept;
  void append_keyframe(double time);
  void place_waiting();
  [[nodiscard]] Outcome place(PlacedFactor& factor);
  void note_fresh();
  [[nodiscard]] FactorReport report_of(const PlacedFactor& factor) const;
  [[nodiscard]] std::size_t keyframe_at(double time) const noexcept;
  /// A motion that begins at `start`, of no duration yet.
  [[nodiscard]] ImuPreintegration no_motion(const NavState& start, const ImuScale& scale) const;
  [[nodiscard]] ImuMotion motion_to(std::size_t keyframe, double time) const;
  /// The chi-square of its difference from what is known without it; infinite when that cannot be
  /// told.
  [[nodiscard]] double innovation(const PlacedFactor& factor, std::size_t keyframe,
                                  bool in_the_equations) const;
  /// Integrates from `begin` to `end` after `start`, the state at which the integration began.
  /// Returns the time of which the IMU says nothing.
  double integrate(const NavState& start, double begin, double end, ImuPreintegration& sum) const;
  [[nodiscard]] ImuIntegration integration() const noexcept;
  void drop_oldest();
  /// Own states have walked since they did so last.
  void walk_own_states();
  /// Those that a clique which leaves has tied to others.
  void bind_globals(const Clique& clique);
  void carry_ahead(double until);
  /// The chi-square above which it is rejected; 0: no gate.
  [[nodiscard]] double gate_of(const PlacedFactor& factor) const noexcept {
    return gates_[index_of(factor.factor.kind())]
                 [static_cast<std::size_t>(factor.factor.rows() - 1)];
  }

  // smoother_linearise.cpp
  /// The factor of keyframe `k`: derivatives where it is linearised, the residual as of there too.
  /// Returns the squared norm of its residual at the estimate.
  double linearise(const PlacedFactor& factor, std::size_t k, FactorValue& linear) const;
  /// Squared norm of its residual at the estimate.
  [[nodiscard]] double chi_square(const PlacedFactor& factor, std::size_t k) const;
  [[nodiscard]] statistics::KernelValue kernel(const PlacedFactor& factor, double chi_square) const;
  /// Whether its kernel may weigh it down.
  [[nodiscard]] bool may_judge(const PlacedFactor& factor) const noexcept;
  /// Whether a part of the window is without the IMU.
  [[nodiscard]] bool has_coasted() const noexcept;
  void linearise_prior();
  void linearise_clique(std::size_t k);
  [[nodiscard]] CornerVector estimated_part(const GlobalVector& all) const;
  [[nodiscard]] GlobalVector whole(const CornerVector& part) const;
  [[nodiscard]] double cost() const;

  // smoother_solve.cpp
  void solve();
  /// The chain without what is at fault; false when that is no single factor.
  [[nodiscard]] bool eliminate_sound();
  bool prepare();  // true: something is to be eliminated anew
  void relinearise();
  [[nodiscard]] bool eliminate_chain(double damping);
  /// By which of the factors that came in with this update is taken for the culprit.
  enum class Blame : std::uint8_t { kInformation, kResidual };
  [[nodiscard]] bool blame_a_factor(Blame blame);
  /// Counts and reports it.
  void take_out(std::size_t k, std::size_t factor, Outcome outcome);
  /// Of those that came in with this update each had been judged without the others. Takes out the
  /// one that the rest speaks against most, where that is more than its gate allows. False: none.
  [[nodiscard]] bool drop_contradicted();
  /// After a step that went to where no estimate is of use.
  [[nodiscard]] bool go_back_and_blame();
  [[nodiscard]] bool substitute_all();
  [[nodiscard]] bool substitute_globals();
  [[nodiscard]] bool substitute_state(std::size_t k, const StateVector* next);
  [[nodiscard]] bool step();
  void remember();
  void go_back();
  /// To where the watchdog began.
  void go_back_to_watched();
  /// J P J^T, with P the joint covariance of a keyframe's state and the estimated globals, from the
  /// transposed derivatives by both.
  template <int N>
  [[nodiscard]] Eigen::Matrix<double, N, N> covariance_of(
      std::size_t k, Eigen::Matrix<double, kStateSize, N> by_state, GlobalRows<N> by_globals) const;

  [[nodiscard]] Gravity gravity() const { return {parameters_.gravity, parameters_.earth}; }

  FixedLagSmootherParameters parameters_;
  std::array<std::array<double, kMaxFactorRows>, kFactorKinds> gates_{};  // chi-squares, by rows
  std::array<OutcomeCounts, kFactorKinds> counts_{};
  std::vector<PlacedFactor> waiting_{};
  ImuTimeline imu_;
  UpdateReport report_;

  std::vector<Keyframe> ring_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::size_t eliminated_ = 0;  // keyframes from the oldest whose elimination stands
  Message last_{};              // what the chain leaves to the globals
  Corner corner_root_{};

  GlobalStates globals_{};         // estimate
  GlobalStates linear_globals_{};  // where they are linearised
  GlobalVector global_delta_ = GlobalVector::Zero();
  GlobalVector linearised_global_delta_ = GlobalVector::Zero();
  std::vector<int> estimated_{};                            // which of all
  GlobalVector global_information_ = GlobalVector::Zero();  // beforehand
  // As constructed: what is known beforehand is what was estimated, after a restart.
  GlobalStates given_globals_{};
  GlobalVector given_information_ = GlobalVector::Zero();

  std::optional<PriorFactor> prior_{};  // until the first keyframe has left
  // Which globals keep the place where they are linearised: a factor of theirs has left, or they
  // are not estimated.
  Eigen::Array<bool, kGlobalSize, 1> bound_ = Eigen::Array<bool, kGlobalSize, 1>::Constant(false);
  double walked_until_ = 0;  // s
  bool imu_scaled_ = false;  // the scale of the IMU is estimated, or known not to be one

  // For steps that are taken back.
  std::vector<StateVector> old_deltas_{};
  GlobalVector old_global_delta_ = GlobalVector::Zero();

  // Where the first of two steps began that are judged together.
  enum class Watchdog : std::uint8_t { kIdle, kWatching, kFailed };
  Watchdog watchdog_ = Watchdog::kIdle;
  double watched_cost_ = 0;
  std::vector<NavState> watched_states_{};
  GlobalStates watched_globals_{};

  // How it turned when the IMU told it last.
  double turning_ = 0;  // rad/s, about z
  double turning_time_ = 0;

  ImuPreintegration ahead_{};  // from the newest keyframe
  double ahead_time_ = 0;
};

template <int N>
Eigen::Matrix<double, N, N> FixedLagSmoother::Implementation::covariance_of(
    std::size_t k, Eigen::Matrix<double, kStateSize, N> by_state, GlobalRows<N> by_globals) const {
  // With the root R of all the information, R^T R, it is |R^-T J^T|^2: one forward substitution
  // along the chain from the keyframe on.
  Eigen::Matrix<double, N, N> sum = Eigen::Matrix<double, N, N>::Zero();
  for (; k < count_; ++k) {
    const Eliminated& here = keyframe(k).eliminated;
    solve_root(here, by_state);
    sum.noalias() += by_state.transpose().lazyProduct(by_state);
    if (by_globals.rows() > 0) {
      by_globals.noalias() -= here.border.transpose().lazyProduct(by_state);
    }
    if (k + 1 < count_) {
      by_state = (-here.cross.transpose().lazyProduct(by_state)).eval();
    }
  }
  if (by_globals.rows() > 0) {
    corner_root_.triangularView<Eigen::Lower>().solveInPlace(by_globals);
    sum.noalias() += by_globals.transpose().lazyProduct(by_globals);
  }
  return sum;
}

}  // namespace pipescout::estimation
