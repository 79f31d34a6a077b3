// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/factor.hpp"

#include <array>
#include <cmath>

namespace pipescout::estimation {

std::string_view to_string(FactorKind kind) noexcept {
  constexpr std::array<std::string_view, kFactorKinds> kNames = {"imu",
                                                                 "prior",
                                                                 "gps",
                                                                 "heading",
                                                                 "visual_pose",
                                                                 "weld",
                                                                 "non_holonomic",
                                                                 "zero_velocity",
                                                                 "odometer",
                                                                 "relative_pose",
                                                                 "zero_angular_rate",
                                                                 "centre_line",
                                                                 "own_0",
                                                                 "own_1",
                                                                 "own_2",
                                                                 "own_3",
                                                                 "own_4",
                                                                 "own_5",
                                                                 "own_6",
                                                                 "own_7",
                                                                 "own_8",
                                                                 "own_9",
                                                                 "own_10",
                                                                 "own_11",
                                                                 "own_12",
                                                                 "own_13",
                                                                 "own_14",
                                                                 "own_15"};
  const auto i = static_cast<std::size_t>(kind);
  return i < kNames.size() ? kNames[i] : "unknown";
}

InputFault AnyFactor::fault() const noexcept {
  if (!(std::isfinite(from_time_) && std::isfinite(to_time_))) {
    return InputFault::kNotFinite;
  }
  if (is_of_two_times() && !(to_time_ > from_time_)) {
    return InputFault::kBadInterval;
  }
  return table_->fault(storage_);
}

const NavState& AnyFactor::some_state() {
  static const NavState state = {
      .R_map_body = geometry::SO3::exp(Eigen::Vector3d(0.37, -0.61, 1.13)),
      .position = {17.31, -23.77, 5.93},
      .velocity = {1.71, -0.83, 0.29},
      .gyro_bias = {0.013, -0.027, 0.031},
      .accelerometer_bias = {0.11, -0.23, 0.17}};
  return state;
}

void AnyFactor::scale_covariance(double factor) noexcept {
  scale_ /= std::sqrt(factor);
}

void AnyFactor::evaluate(const NavState& from, const NavState& to, const GlobalStates& globals,
                         bool with_derivatives, FactorValue& value) const {
  table_->evaluate(storage_, from, to, globals, with_derivatives, value);
  if (scale_ != 1) {
    value.residual.head(value.rows) *= scale_;
    if (with_derivatives) {
      value.from.topRows(value.rows) *= scale_;
      value.to.topRows(value.rows) *= scale_;
      value.globals.topRows(value.rows) *= scale_;
    }
  }
}

}  // namespace pipescout::estimation
