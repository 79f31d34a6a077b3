// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ceres/manifold.h>

#include <array>
#include <vector>

#include "pipescout/estimation/state.hpp"

/// States as Ceres keeps them: numbers, of which four are a quaternion.
///
/// Ceres asks for derivatives by these numbers and multiplies them with the manifold's. Ours are
/// over the tangent space already; so both sides pretend that the first numbers are the tangent
/// vector. Only the products count, and these are right.
namespace pipescout::estimation {

/// [position; velocity; gyro bias; accelerometer bias; quaternion x y z w]
inline constexpr int kStateNumbers = kStateSize + 1;
inline constexpr int kGlobalNumbers = kGlobalSize + 1;
using StateBlock = std::array<double, kStateNumbers>;
using GlobalBlock = std::array<double, kGlobalNumbers>;

void pack(const NavState& state, double* numbers);
void pack(const GlobalStates& globals, double* numbers);
[[nodiscard]] NavState unpack_state(const double* numbers);
[[nodiscard]] GlobalStates unpack_globals(const double* numbers);

class StateManifold : public ceres::Manifold {
 public:
  [[nodiscard]] int AmbientSize() const override { return kStateNumbers; }
  [[nodiscard]] int TangentSize() const override { return kStateSize; }
  bool Plus(const double* x, const double* delta, double* moved) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* difference) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// Of those global states alone that are estimated.
class GlobalManifold : public ceres::Manifold {
 public:
  /// Places in the tangent space of GlobalStates.
  explicit GlobalManifold(std::vector<int> estimated) : estimated_(std::move(estimated)) {}
  [[nodiscard]] int AmbientSize() const override { return kGlobalNumbers; }
  [[nodiscard]] int TangentSize() const override { return static_cast<int>(estimated_.size()); }
  bool Plus(const double* x, const double* delta, double* moved) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* difference) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  std::vector<int> estimated_;
};

}  // namespace pipescout::estimation
