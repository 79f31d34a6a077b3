// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/heading_factor.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;
using Eigen::Vector3d;

InputFault check(const HeadingMeasurement& m) noexcept {
  return verdict(finite({m.time, m.heading, m.standard_deviation}),
                 is_deviation(m.standard_deviation));
}

void add_values(const HeadingMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.heading);
}

HeadingFactor::HeadingFactor(const HeadingMeasurement& measurement) : MeasuredFactor(measurement) {
  whitening_(0, 0) = 1 / measurement.standard_deviation;
}

HeadingFactor::Residual HeadingFactor::evaluate(const NavState& x, const GlobalStates& /*globals*/,
                                                Derivatives* derivatives) const {
  constexpr double kVertical = 1e-3;
  const Matrix3d r = x.R_map_body.matrix();
  const Vector3d forward = r.col(0);
  const double square = forward.head<2>().squaredNorm();
  const bool defined = square >= kVertical * kVertical;
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  if (derivatives != nullptr) {
    // d forward = R (d x e_1) = d_z (second column) - d_y (third column)
    const auto by = [&](const Vector3d& change) {
      return defined ? (forward.x() * change.y() - forward.y() * change.x()) / square : nothing;
    };
    derivatives->from(0, kRotation + 1) = -whitening_(0, 0) * by(r.col(2));
    derivatives->from(0, kRotation + 2) = whitening_(0, 0) * by(r.col(1));
  }
  const double heading = std::atan2(forward.y(), forward.x());
  const double error = std::remainder(heading - measurement_.heading, 2 * std::numbers::pi);
  return Residual(defined ? whitening_(0, 0) * error : nothing);
}

}  // namespace pipescout::estimation
