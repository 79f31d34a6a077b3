// SPDX-License-Identifier: Apache-2.0
#include "thermal_peer.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc.hpp>
#include <vector>

namespace pipescout::benchmarks {
namespace {

constexpr double kLowest = 100.0;  // degC, of the grey levels; the paper's
constexpr double kHighest = 300.0;
constexpr int kAcross = 7;  // pixels

}  // namespace

struct ThinningPeer::Implementation {
  cv::Mat grey;
  cv::Mat mask;
  cv::Mat skeleton;
  cv::Mat temperatures;
  cv::Mat strip;
  std::vector<cv::Vec4i> lines;
  std::vector<float> profile;
  thermal::ProfileAnalysis analysis{thermal::ProfileParameters{}};
  double length = 0;
};

ThinningPeer::ThinningPeer() : implementation_(std::make_unique<Implementation>()) {
  cv::setNumThreads(1);
}
ThinningPeer::~ThinningPeer() = default;

double ThinningPeer::length() const {
  return implementation_->length;
}

std::size_t ThinningPeer::detect(const thermal::CountView& image, std::span<const float> celsius) {
  Implementation& i = *implementation_;
  i.temperatures.create(image.height, image.width, CV_32F);
  for (int y = 0; y < image.height; ++y) {
    float* const row = i.temperatures.ptr<float>(y);
    for (int x = 0; x < image.width; ++x) {
      const float value = celsius[image(x, y)];
      row[x] = std::isnan(value) ? 0.0F : value;
    }
  }
  const double gain = 255 / (kHighest - kLowest);
  i.temperatures.convertTo(i.grey, CV_8U, gain, -gain * kLowest);
  cv::threshold(i.grey, i.mask, 0, 255, cv::THRESH_BINARY);
  cv::ximgproc::thinning(i.mask, i.skeleton, cv::ximgproc::THINNING_ZHANGSUEN);
  cv::HoughLinesP(i.skeleton, i.lines, 1, CV_PI / 360, 40, 30, 20);
  cv::Vec4i longest(0, 0, 0, 0);
  i.length = 0;
  for (const cv::Vec4i& line : i.lines) {
    const double length = std::hypot(line[2] - line[0], line[3] - line[1]);
    if (length > i.length) {
      i.length = length;
      longest = line;
    }
  }
  if (i.length < 1) {
    return 0;
  }
  // The section laid out level, then the mean of its columns.
  const cv::Point2f u(static_cast<float>((longest[2] - longest[0]) / i.length),
                      static_cast<float>((longest[3] - longest[1]) / i.length));
  const cv::Matx23f to_image(u.x, -u.y, static_cast<float>(longest[0]) + u.y * (kAcross / 2), u.y,
                             u.x, static_cast<float>(longest[1]) - u.x * (kAcross / 2));
  cv::warpAffine(i.temperatures, i.strip, to_image, cv::Size(static_cast<int>(i.length), kAcross),
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
  cv::Mat mean;
  cv::reduce(i.strip, mean, 0, cv::REDUCE_AVG, CV_32F);
  i.profile.assign(mean.begin<float>(), mean.end<float>());
  i.analysis.analyse(i.profile, {}, {});
  return i.analysis.leaks().size();
}

}  // namespace pipescout::benchmarks
