// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/carried_factor.hpp"

namespace pipescout::estimation {
namespace {

/// A state at the end of a motion, with derivatives by the state that it begins at and by the scale
/// of the IMU.
class Carried {
 public:
  Carried(const ImuMotion& motion, const NavState& begin, const GlobalStates& globals,
          const Gravity& gravity, bool derive)
      : motion_(motion), begin_(begin) {
    if (motion.duration() > 0) {
      end_ = motion.propagate(begin, globals.imu_scale, gravity, derive ? &by_state_ : nullptr,
                              derive ? &by_scale_ : nullptr);
    }
  }
  [[nodiscard]] const NavState& state() const { return motion_.duration() > 0 ? end_ : begin_; }

  /// From derivatives by the state that the motion leads to, to those by the one it begins at.
  void chain(int rows, FactorValue::Rows<kStateSize>& by_carried,
             FactorValue::Rows<kGlobalSize>& by_globals) const {
    if (motion_.duration() <= 0) {
      return;
    }
    switch (rows) {
      case 1:
        return chain_rows<1>(by_carried, by_globals);
      case 2:
        return chain_rows<2>(by_carried, by_globals);
      case 3:
        return chain_rows<3>(by_carried, by_globals);
      case 4:
        return chain_rows<4>(by_carried, by_globals);
      case 5:
        return chain_rows<5>(by_carried, by_globals);
      default:
        return chain_rows<6>(by_carried, by_globals);
    }
  }

 private:
  /// Of a known number of rows: twice as fast as any number of them.
  template <int Rows>
  void chain_rows(FactorValue::Rows<kStateSize>& by_carried,
                  FactorValue::Rows<kGlobalSize>& by_globals) const {
    if (motion_.scaled()) {
      by_globals.topRows<Rows>().template middleCols<kImuScaleSize>(kImuScale).noalias() +=
          by_carried.topRows<Rows>().template leftCols<9>() * by_scale_;
    }
    by_carried.topRows<Rows>() = (by_carried.topRows<Rows>() * by_state_).eval();
  }

  const ImuMotion& motion_;
  const NavState& begin_;
  NavState end_;
  StateMatrix by_state_;
  ImuMotion::ScaleJacobian by_scale_;
};

}  // namespace

void evaluate_carried(const AnyFactor& factor, const CarryingMotions& motions, const NavState& from,
                      const NavState& to, const GlobalStates& globals, const Gravity& gravity,
                      bool with_derivatives, FactorValue& value) {
  const Carried begin(motions.from, from, globals, gravity, with_derivatives);
  if (!factor.is_of_two_times()) {
    factor.evaluate(begin.state(), begin.state(), globals, with_derivatives, value);
  } else {
    const Carried end(motions.to, to, globals, gravity, with_derivatives);
    factor.evaluate(begin.state(), end.state(), globals, with_derivatives, value);
    if (with_derivatives) {
      end.chain(value.rows, value.to, value.globals);
    }
  }
  if (with_derivatives) {
    begin.chain(value.rows, value.from, value.globals);
  }
}

double chi_square(const AnyFactor& factor, const CarryingMotions& motions, const NavState& from,
                  const NavState& to, const GlobalStates& globals, const Gravity& gravity) {
  FactorValue value;
  evaluate_carried(factor, motions, from, to, globals, gravity, false, value);
  return value.residual.head(value.rows).squaredNorm();
}

}  // namespace pipescout::estimation
