// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include "pipescout/estimation/factors.hpp"

namespace pipescout::estimation {

/// FNV-1a over the kind and the numbers of a measurement: to know it again.
class Fingerprint {
 public:
  explicit Fingerprint(FactorKind kind) { add_bits(static_cast<std::uint64_t>(kind)); }
  Fingerprint& add(double value) {
    add_bits(std::bit_cast<std::uint64_t>(value));
    return *this;
  }
  template <class Derived>
  Fingerprint& add(const Eigen::MatrixBase<Derived>& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      add(values(i));
    }
    return *this;
  }
  Fingerprint& add(const geometry::SE3& t) {
    return add(t.translation()).add(t.rotation().quaternion().coeffs());
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  void add_bits(std::uint64_t bits) {
    for (int i = 0; i < 8; ++i) {
      hash_ = (hash_ ^ (bits & 0xffU)) * 0x100000001b3U;
      bits >>= 8U;
    }
  }
  std::uint64_t hash_ = 0xcbf29ce484222325U;
};

inline std::uint64_t fingerprint_of(const GpsMeasurement& m) {
  return Fingerprint(FactorKind::kGps).add(m.time).add(m.position).value();
}
inline std::uint64_t fingerprint_of(const HeadingMeasurement& m) {
  return Fingerprint(FactorKind::kHeading).add(m.time).add(m.heading).value();
}
inline std::uint64_t fingerprint_of(const VisualPoseMeasurement& m) {
  return Fingerprint(FactorKind::kVisualPose).add(m.time).add(m.T_rack_body).value();
}
inline std::uint64_t fingerprint_of(const WeldMeasurement& m) {
  return Fingerprint(FactorKind::kWeld).add(m.time).add(m.position).value();
}
inline std::uint64_t fingerprint_of(const CentreLineMeasurement& m) {
  return Fingerprint(FactorKind::kCentreLine).add(m.time).value();
}
inline std::uint64_t fingerprint_of(const NonHolonomicMeasurement& m) {
  return Fingerprint(FactorKind::kNonHolonomic).add(m.time).value();
}
inline std::uint64_t fingerprint_of(const ZeroVelocityMeasurement& m) {
  return Fingerprint(FactorKind::kZeroVelocity).add(m.time).value();
}
inline std::uint64_t fingerprint_of(const ZeroAngularRateMeasurement& m) {
  return Fingerprint(FactorKind::kZeroAngularRate).add(m.time).add(m.angular_rate).value();
}
inline std::uint64_t fingerprint_of(const OdometerMeasurement& m) {
  return Fingerprint(FactorKind::kOdometer).add(m.from_time).add(m.to_time).add(m.distance).value();
}
inline std::uint64_t fingerprint_of(const RelativePoseMeasurement& m) {
  return Fingerprint(FactorKind::kRelativePose)
      .add(m.from_time)
      .add(m.to_time)
      .add(m.T_from_to)
      .value();
}

}  // namespace pipescout::estimation
