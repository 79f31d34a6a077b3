// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/carried_factor.hpp"

namespace pipescout::estimation {
namespace {

/// A motion's derivatives, by the state that it begins at and by the scale of the IMU.
struct By {
  StateMatrix state;
  ImuMotion::ScaleJacobian scale;
};

/// From derivatives by the state that a motion leads to, to those by the state that it begins at.
template <int Rows>
void chain(const ImuMotion& motion, const By& by,
           Eigen::Matrix<double, Rows, kStateSize>& by_carried,
           Eigen::Matrix<double, Rows, kGlobalSize>& by_globals) {
  if (motion.duration() <= 0) {
    return;
  }
  if (motion.scaled()) {
    by_globals.template middleCols<kImuScaleSize>(kImuScale).noalias() +=
        by_carried.template leftCols<9>() * by.scale;
  }
  by_carried = (by_carried * by.state).eval();
}

}  // namespace

template <class Factor>
typename Factor::Residual evaluate_carried(const Factor& factor, const CarryingMotions& motions,
                                           const NavState& from, const NavState& to,
                                           const GlobalStates& globals, double gravity,
                                           typename Factor::Derivatives* derivatives) {
  By by_from;
  By by_to;
  const auto carry = [&](const ImuMotion& motion, const NavState& state, By& by) {
    const bool derive = derivatives != nullptr;
    return motion.duration() > 0
               ? motion.propagate(state, globals.imu_scale, gravity, derive ? &by.state : nullptr,
                                  derive ? &by.scale : nullptr)
               : state;
  };
  typename Factor::Residual residual;
  if constexpr (Factor::kRelative) {
    residual = factor.evaluate(carry(motions.from, from, by_from), carry(motions.to, to, by_to),
                               globals, derivatives);
    if (derivatives != nullptr) {
      chain<Factor::kRows>(motions.to, by_to, derivatives->to, derivatives->globals);
    }
  } else {
    residual = factor.evaluate(carry(motions.from, from, by_from), globals, derivatives);
  }
  if (derivatives != nullptr) {
    chain<Factor::kRows>(motions.from, by_from, derivatives->from, derivatives->globals);
  }
  return residual;
}

template GpsFactor::Residual evaluate_carried(const GpsFactor&, const CarryingMotions&,
                                              const NavState&, const NavState&, const GlobalStates&,
                                              double, GpsFactor::Derivatives*);
template HeadingFactor::Residual evaluate_carried(const HeadingFactor&, const CarryingMotions&,
                                                  const NavState&, const NavState&,
                                                  const GlobalStates&, double,
                                                  HeadingFactor::Derivatives*);
template VisualPoseFactor::Residual evaluate_carried(const VisualPoseFactor&,
                                                     const CarryingMotions&, const NavState&,
                                                     const NavState&, const GlobalStates&, double,
                                                     VisualPoseFactor::Derivatives*);
template WeldFactor::Residual evaluate_carried(const WeldFactor&, const CarryingMotions&,
                                               const NavState&, const NavState&,
                                               const GlobalStates&, double,
                                               WeldFactor::Derivatives*);
template NonHolonomicFactor::Residual evaluate_carried(const NonHolonomicFactor&,
                                                       const CarryingMotions&, const NavState&,
                                                       const NavState&, const GlobalStates&, double,
                                                       NonHolonomicFactor::Derivatives*);
template ZeroVelocityFactor::Residual evaluate_carried(const ZeroVelocityFactor&,
                                                       const CarryingMotions&, const NavState&,
                                                       const NavState&, const GlobalStates&, double,
                                                       ZeroVelocityFactor::Derivatives*);
template OdometerFactor::Residual evaluate_carried(const OdometerFactor&, const CarryingMotions&,
                                                   const NavState&, const NavState&,
                                                   const GlobalStates&, double,
                                                   OdometerFactor::Derivatives*);
template RelativePoseFactor::Residual evaluate_carried(const RelativePoseFactor&,
                                                       const CarryingMotions&, const NavState&,
                                                       const NavState&, const GlobalStates&, double,
                                                       RelativePoseFactor::Derivatives*);
template ZeroAngularRateFactor::Residual evaluate_carried(const ZeroAngularRateFactor&,
                                                          const CarryingMotions&, const NavState&,
                                                          const NavState&, const GlobalStates&,
                                                          double,
                                                          ZeroAngularRateFactor::Derivatives*);
template CentreLineFactor::Residual evaluate_carried(const CentreLineFactor&,
                                                     const CarryingMotions&, const NavState&,
                                                     const NavState&, const GlobalStates&, double,
                                                     CentreLineFactor::Derivatives*);

}  // namespace pipescout::estimation
