// SPDX-License-Identifier: Apache-2.0
// Looks for pipes and leaks in a thermal image made here: a pipe of 60 degC with 1.5 m at 90 degC.
#include <algorithm>
#include <iostream>
#include <vector>

#include "pipescout/thermal/leak_detector.hpp"

using namespace pipescout::thermal;

int main() {
  constexpr int kWidth = 320;
  constexpr int kHeight = 240;
  std::vector<float> image(kWidth * kHeight, 15.0F);  // degC
  for (int y = 118; y < 126; ++y) {
    std::fill_n(image.begin() + y * kWidth, kWidth, 60.0F);
    std::fill_n(image.begin() + y * kWidth + 200, 30, 90.0F);
  }
  LeakDetector detector(LeakDetectorParameters::adaptive());
  const Detections& found = detector.detect(TemperatureView{image.data(), kWidth, kHeight, kWidth},
                                            {.metres_per_pixel = 0.05});
  for (const PipeSection& pipe : found.pipes) {
    std::cout << "pipe from " << pipe.start.transpose() << " to " << pipe.end.transpose() << ", "
              << pipe.reference_temperature << " degC\n";
  }
  for (const LeakDetection& leak : found.leaks) {
    std::cout << "leak at " << leak.centre().transpose() << ", " << leak.length << " m, +"
              << leak.delta << " K, " << to_string(leak.severity) << '\n';
  }
  return found.pipes.size() == 1 && found.leaks.size() == 1 ? 0 : 1;
}
