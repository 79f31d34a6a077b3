// SPDX-License-Identifier: Apache-2.0
#include "example_findings.hpp"

#include <cmath>

namespace pipescout::test {

leak_findings::Finding example_finding(std::uint64_t id) {
  const double k = static_cast<double>(id);
  leak_findings::Finding f;
  f.id = id;
  f.state = leak_findings::FindingState::kRaised;
  f.probability = 0.97;
  f.severity = static_cast<thermal::Severity>(id % 4);
  f.first_time = 1381300000 + 60 * k;
  f.last_time = 1381300100.25 + 60 * k;
  f.frames = 31 + id;
  f.mean_delta = 75.5 + 10 * k;
  f.mean_delta_interval = {70.25 + 10 * k, 80.75 + 10 * k};
  f.peak_delta = 140 + k;
  f.peak_delta_interval = {130 + k, 150 + k};
  f.length = 0.4 + 0.1 * k;
  f.length_deviation = 0.05;
  f.delta_growth = 0.3;
  f.length_growth = 0.01;
  f.pass_count = 2;
  f.best = {.time = 1381300050,
            .frame = 77 + id,
            .start = {100.5, 60},
            .end = {140, 61},
            .half_width = 9,
            .score = 3.5};
  leak_findings::MapPosition p;
  p.point = {12.5 * k, 4 + k, 1.5};
  p.covariance << 0.09, 0.01, 0.002, 0.01, 0.04, 0.003, 0.002, 0.003, 0.02;
  p.direction = Eigen::Vector3d(0.6, 0.8, 0);
  f.position = p;
  for (int pass = 0; pass < 2; ++pass) {
    leak_findings::PassSummary s;
    s.time = f.first_time + 86400 * pass;
    s.frames = 15 + static_cast<std::size_t>(pass);
    s.delta = 70 + 5 * pass;
    s.delta_deviation = 2.5;
    s.peak_delta = 135 + pass;
    s.length = 0.4;
    s.length_deviation = 0.06;
    if (pass == 1) {
      s.position = p;
    }
    f.passes.push_back(s);
  }
  return f;
}

leak_findings::Finding bare_finding(std::uint64_t id) {
  leak_findings::Finding f;
  f.id = id;
  f.state = leak_findings::FindingState::kCleared;
  return f;
}

ExamplePicture::ExamplePicture() {
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const bool pipe = std::abs(y - 60) <= 8;
      const bool leak = pipe && x >= 100 && x < 140;
      const bool joint = pipe && x >= 40 && x < 43;
      degrees.push_back(leak ? 230.0F : joint ? 260.0F : pipe ? 140.0F : 15.0F);
    }
  }
  parameters = thermal::LeakDetectorParameters::torresol();
  thermal::LeakDetector detector(parameters);
  detections = detector.detect(view(), {.metres_per_pixel = 0.02});
}

}  // namespace pipescout::test
