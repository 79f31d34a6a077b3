// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>

#include "pipescout/geometry/se3.hpp"

namespace pipescout::estimation {

/// FNV-1a over the numbers of a measurement: recognises one that comes twice.
class Fingerprint {
 public:
  Fingerprint& add(std::uint64_t bits) {
    for (int i = 0; i < 8; ++i) {
      hash_ = (hash_ ^ (bits & 0xffU)) * 0x100000001b3U;
      bits >>= 8U;
    }
    return *this;
  }
  Fingerprint& add(double value) { return add(std::bit_cast<std::uint64_t>(value)); }
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
  std::uint64_t hash_ = 0xcbf29ce484222325U;
};

}  // namespace pipescout::estimation
