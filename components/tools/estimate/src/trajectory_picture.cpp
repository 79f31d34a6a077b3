// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "output.hpp"
#include "pipescout/command_line/formatted.hpp"

namespace pipescout::estimate {
namespace {

using command_line::formatted;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPanel = 720;  // pixels, the longer side
constexpr double kShortest = 160;
constexpr double kLeft = 70;  // for the labels of the y axis
constexpr double kRight = 20;
constexpr double kTop = 34;  // for the legend
constexpr double kBottom = 56;
constexpr int kMostLines = 8;       // of the grid, along the longer side
constexpr double kLeastExtent = 1;  // m, of what hardly moved

/// 1, 2 or 5 times a power of ten, so that `span` has no more than kMostLines of them.
double step_of(double span) {
  const double least = span / kMostLines;
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  const double factor = least / power;
  return power * (factor <= 1 ? 1 : factor <= 2 ? 2 : factor <= 5 ? 5 : 10);
}

/// Metres of the map to pixels, with the same scale along both axes, and 4 % of room around.
struct View {
  View(const Vector2d& least, const Vector2d& most) {
    const double extent = std::max((most - least).maxCoeff(), kLeastExtent);
    const Vector2d room = Vector2d::Constant(0.04 * extent);
    const Vector2d middle = 0.5 * (least + most);
    const Vector2d half = (0.5 * (most - least) + room).cwiseMax(0.5 * extent * kShortest / kPanel);
    low = middle - half;
    high = middle + half;
    scale = kPanel / (high - low).maxCoeff();
    size = scale * (high - low);
  }
  [[nodiscard]] double x(double metres) const { return kLeft + scale * (metres - low.x()); }
  [[nodiscard]] double y(double metres) const { return kTop + scale * (high.y() - metres); }

  Vector2d low;
  Vector2d high;
  double scale = 1;
  Vector2d size;  // pixels
};

/// Lines with their metres, and what the axes are.
std::string axes(const View& view) {
  const double step = step_of((view.high - view.low).maxCoeff());
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  std::string out = "<g stroke=\"#dddddd\" stroke-width=\"1\">\n";
  std::string labels = "<g font-family=\"sans-serif\" font-size=\"13\" fill=\"#333333\">\n";
  const double right = kLeft + view.size.x();
  const double bottom = kTop + view.size.y();
  // Whole steps: -0 would be written with its sign.
  for (double k = std::ceil(view.low.x() / step); k * step <= view.high.x(); k += 1) {
    const double at = view.x(k * step);
    out += formatted("<path d=\"M%.1f %.1fV%.1f\"/>\n", at, kTop, bottom);
    labels += formatted("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%.*f</text>\n", at,
                        bottom + 17, decimals, k * step + 0.0);
  }
  for (double k = std::ceil(view.low.y() / step); k * step <= view.high.y(); k += 1) {
    const double at = view.y(k * step);
    out += formatted("<path d=\"M%.1f %.1fH%.1f\"/>\n", kLeft, at, right);
    labels += formatted("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%.*f</text>\n", kLeft - 6,
                        at + 4, decimals, k * step + 0.0);
  }
  out += formatted(
      "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"none\" "
      "stroke=\"#888888\"/>\n</g>\n",
      kLeft, kTop, view.size.x(), view.size.y());
  labels += formatted("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">x [m]</text>\n",
                      kLeft + view.size.x() / 2, bottom + 40);
  const double middle = kTop + view.size.y() / 2;
  labels += formatted(
      "<text x=\"18\" y=\"%.1f\" text-anchor=\"middle\" transform=\"rotate(-90 18 "
      "%.1f)\">y [m]</text>\n",
      middle, middle);
  return out + labels + "</g>\n";
}

std::string legend(bool with_fixes) {
  std::string out = formatted(
      "<g font-family=\"sans-serif\" font-size=\"13\" fill=\"#333333\">\n"
      "<path d=\"M%.0f 17h22\" stroke=\"#1b4f9c\" stroke-width=\"2\"/>\n"
      "<text x=\"%.0f\" y=\"21\">trajectory</text>\n",
      kLeft, kLeft + 28);
  if (with_fixes) {
    out += formatted(
        "<circle cx=\"%.0f\" cy=\"17\" r=\"2.5\" fill=\"#d95f02\"/>\n"
        "<text x=\"%.0f\" y=\"21\">GPS</text>\n",
        kLeft + 118, kLeft + 127);
  }
  return out + "</g>\n";
}

}  // namespace

std::string trajectory_svg(const Trajectory& trajectory) {
  Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity());
  Vector2d high = -low;
  const auto include = [&](const Vector3d& p) {
    low = low.cwiseMin(p.head<2>());
    high = high.cwiseMax(p.head<2>());
  };
  for (const auto& p : trajectory.points) {
    include(p.position);
  }
  for (const auto& fix : trajectory.fixes) {
    include(fix.position);
  }
  const View view(low, high);
  std::string out = formatted(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\">\n"
      "<rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n",
      kLeft + view.size.x() + kRight, kTop + view.size.y() + kBottom);
  out += axes(view) + legend(!trajectory.fixes.empty()) + "<g fill=\"#d95f02\">\n";
  for (const auto& fix : trajectory.fixes) {
    out += formatted("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"1.5\"/>\n", view.x(fix.position.x()),
                     view.y(fix.position.y()));
  }
  out += "</g>\n<polyline fill=\"none\" stroke=\"#1b4f9c\" stroke-width=\"1.5\" points=\"";
  for (const auto& p : trajectory.points) {
    out += formatted("%.1f,%.1f ", view.x(p.position.x()), view.y(p.position.y()));
  }
  return out + "\"/>\n</svg>\n";
}

}  // namespace pipescout::estimate
