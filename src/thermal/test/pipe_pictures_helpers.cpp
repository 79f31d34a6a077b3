// SPDX-License-Identifier: Apache-2.0
#include "pipe_pictures_helpers.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::thermal::test {

Picture& Picture::pipe(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double half_width,
                       double celsius, const std::vector<Warm>& warm) {
  const Eigen::Vector2d u = (b - a).normalized();
  const double length = (b - a).norm();
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const Eigen::Vector2d d = Eigen::Vector2d(x, y) - a;
      const double along = u.dot(d);
      const double off = std::abs(u.x() * d.y() - u.y() * d.x());
      const double share = std::clamp(half_width - off + 0.5, 0.0, 1.0) *
                           std::clamp(std::min(along, length - along) + 0.5, 0.0, 1.0);
      if (share <= 0) {
        continue;
      }
      double own = celsius;
      for (const Warm& w : warm) {
        const double part =
            std::clamp(along - w.from + 0.5, 0.0, 1.0) * std::clamp(w.to - along + 0.5, 0.0, 1.0);
        own += part * (w.celsius - own);
      }
      at(x, y) = static_cast<float>(at(x, y) + share * (own - at(x, y)));
    }
  }
  return *this;
}

Picture& Picture::ring(const Eigen::Vector2d& centre, double radius, double half_width,
                       double celsius) {
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const double off = std::abs((Eigen::Vector2d(x, y) - centre).norm() - radius);
      const double share = std::clamp(half_width - off + 0.5, 0.0, 1.0);
      at(x, y) = static_cast<float>(at(x, y) + share * (celsius - at(x, y)));
    }
  }
  return *this;
}

Picture& Picture::box(int x, int y, int width, int height, double celsius) {
  for (int j = std::max(0, y); j < std::min(height_, y + height); ++j) {
    for (int i = std::max(0, x); i < std::min(width_, x + width); ++i) {
      at(i, j) = static_cast<float>(celsius);
    }
  }
  return *this;
}

Picture& Picture::noise(double deviation, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal(0, deviation);
  for (float& pixel : pixels_) {
    pixel += static_cast<float>(normal(engine));
  }
  return *this;
}

std::vector<std::uint16_t> Picture::counts(int stride) const {
  std::vector<std::uint16_t> all(static_cast<std::size_t>(stride) *
                                 static_cast<std::size_t>(height_));
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const float celsius = pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                    static_cast<std::size_t>(x)];
      all[static_cast<std::size_t>(y) * static_cast<std::size_t>(stride) +
          static_cast<std::size_t>(x)] =
          static_cast<std::uint16_t>(std::lround((celsius + 100) * kCountsPerKelvin));
    }
  }
  return all;
}

std::vector<float> Picture::table() {
  std::vector<float> celsius(65536);
  for (std::size_t i = 0; i < celsius.size(); ++i) {
    celsius[i] = static_cast<float>(static_cast<double>(i) / kCountsPerKelvin - 100);
  }
  return celsius;
}

}  // namespace pipescout::thermal::test
