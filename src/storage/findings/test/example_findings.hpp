// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "pipescout/leak_findings/finding.hpp"
#include "pipescout/leak_store/evidence.hpp"

namespace pipescout::test {

/// With a value in every field, all different; those of another id differ.
[[nodiscard]] leak_findings::Finding example_finding(std::uint64_t id);

/// Of which nothing is known but that it is there.
[[nodiscard]] leak_findings::Finding bare_finding(std::uint64_t id);

/// A pipe of 140 degC with a leak of 230 degC and a joint, made by the detector of a picture of
/// 160 x 120.
struct ExamplePicture {
  ExamplePicture();
  [[nodiscard]] thermal::TemperatureView view() const { return {degrees.data(), 160, 120, 160}; }
  std::vector<float> degrees;
  thermal::LeakDetectorParameters parameters;
  thermal::Detections detections;
};

}  // namespace pipescout::test
