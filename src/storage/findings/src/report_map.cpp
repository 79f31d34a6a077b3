// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "markup.hpp"
#include "pipescout/statistics/chi_square.hpp"
#include "report_figures.hpp"

namespace pipescout {
namespace {

constexpr double kWidth = 960;  // pixels, of the whole map
constexpr double kLeastHeight = 220;
constexpr double kMostHeight = 640;
constexpr double kMargin = 46;
constexpr int kMostGridLines = 8;

/// Metres of the map to pixels of the drawing.
class MapScale {
 public:
  MapScale(Eigen::Vector2d low, Eigen::Vector2d high) {
    // Room for what is a point, and for names at the border.
    const double grow = std::max(2.0, 0.06 * (high - low).maxCoeff());
    low -= Eigen::Vector2d::Constant(grow);
    high += Eigen::Vector2d::Constant(grow);
    const Eigen::Vector2d size = high - low;
    scale_ = std::min((kWidth - 2 * kMargin) / size.x(), (kMostHeight - 2 * kMargin) / size.y());
    height_ = std::max(kLeastHeight, size.y() * scale_ + 2 * kMargin);
    const Eigen::Vector2d shown((kWidth - 2 * kMargin) / scale_, (height_ - 2 * kMargin) / scale_);
    const Eigen::Vector2d middle = 0.5 * (low + high);
    low_ = middle - 0.5 * shown;
    high_ = middle + 0.5 * shown;
  }
  [[nodiscard]] double x(double metres) const { return kMargin + (metres - low_.x()) * scale_; }
  [[nodiscard]] double y(double metres) const {
    return height_ - kMargin - (metres - low_.y()) * scale_;
  }
  [[nodiscard]] std::string at(const Eigen::Vector2d& p) const {
    return fixed(x(p.x()), 1) + "," + fixed(y(p.y()), 1);
  }
  [[nodiscard]] double pixels(double metres) const { return metres * scale_; }
  [[nodiscard]] double height() const { return height_; }
  [[nodiscard]] const Eigen::Vector2d& low() const { return low_; }
  [[nodiscard]] const Eigen::Vector2d& high() const { return high_; }

 private:
  double scale_ = 1;
  double height_ = 0;
  Eigen::Vector2d low_;
  Eigen::Vector2d high_;
};

std::string grid(const MapScale& map) {
  const double step = round_step((map.high() - map.low()).maxCoeff(), kMostGridLines);
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  std::string svg = "<g class=\"grid\">";
  for (double x = std::ceil(map.low().x() / step) * step; x <= map.high().x(); x += step) {
    const std::string at = fixed(map.x(x), 1);
    svg += "<line x1=\"" + at + "\" x2=\"" + at + "\" y1=\"" + fixed(kMargin, 0) + "\" y2=\"" +
           fixed(map.height() - kMargin, 1) + "\"/><text x=\"" + at + "\" y=\"" +
           fixed(map.height() - kMargin + 16, 1) + "\" text-anchor=\"middle\">" +
           fixed(x, decimals) + "</text>";
  }
  for (double y = std::ceil(map.low().y() / step) * step; y <= map.high().y(); y += step) {
    const std::string at = fixed(map.y(y), 1);
    svg += "<line y1=\"" + at + "\" y2=\"" + at + "\" x1=\"" + fixed(kMargin, 0) + "\" x2=\"" +
           fixed(kWidth - kMargin, 1) + "\"/><text x=\"" + fixed(kMargin - 6, 0) + "\" y=\"" + at +
           "\" dy=\"4\" text-anchor=\"end\">" + fixed(y, decimals) + "</text>";
  }
  svg += "<text x=\"" + fixed(kWidth / 2, 0) + "\" y=\"" + fixed(map.height() - 10, 0) +
         "\" text-anchor=\"middle\">x / m (map)</text>";
  svg += "<text x=\"8\" y=\"" + fixed(kMargin - 16, 0) + "\">y / m (map)</text></g>";
  return svg;
}

std::string marker(const MapScale& map, const leak_findings::Finding& finding) {
  const Eigen::Vector2d point = finding.position->point.head<2>();
  const std::string colour = severity_colour(finding.severity);
  const std::string x = fixed(map.x(point.x()), 1);
  const std::string y = fixed(map.y(point.y()), 1);
  std::string svg = "<g>";
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(
      finding.position->covariance.topLeftCorner<2, 2>());
  if (axes.info() == Eigen::Success && axes.eigenvalues().allFinite()) {
    const double ellipse_95 = statistics::chi_square_quantile(0.95, 2);
    const auto radius = [&](int i) {
      return map.pixels(std::sqrt(std::max(axes.eigenvalues()[i], 0.0) * ellipse_95));
    };
    const Eigen::Vector2d large = axes.eigenvectors().col(1);
    // The drawing's y points down.
    const double angle = -std::atan2(large.y(), large.x()) * 180 / std::numbers::pi;
    svg += "<ellipse cx=\"" + x + "\" cy=\"" + y + "\" rx=\"" + fixed(radius(1), 1) + "\" ry=\"" +
           fixed(radius(0), 1) + "\" transform=\"rotate(" + fixed(angle, 1) + " " + x + " " + y +
           ")\" fill=\"" + colour + "\" fill-opacity=\"0.2\" stroke=\"" + colour + "\"/>";
  }
  const std::string id = std::to_string(finding.id);
  const bool cleared = finding.state == leak_findings::FindingState::kCleared;
  svg += "<a href=\"#leak" + id + "\"><circle cx=\"" + x + "\" cy=\"" + y + "\" r=\"5\" fill=\"" +
         (cleared ? "#ffffff" : colour) + "\" stroke=\"" + colour +
         "\" stroke-width=\"2\"/><text class=\"name\" x=\"" + fixed(map.x(point.x()) + 8, 1) +
         "\" y=\"" + fixed(map.y(point.y()) - 7, 1) + "\">" + id + "</text></a></g>";
  return svg;
}

std::string track(const MapScale& map, const std::vector<Eigen::Vector2d>& points) {
  if (points.size() < 2) {
    return "";
  }
  std::string svg = "<polyline class=\"track\" points=\"";
  for (const Eigen::Vector2d& point : points) {
    svg += map.at(point) + " ";
  }
  return svg + "\"/>";
}

}  // namespace

std::string map_figure(const LeakReport& report) {
  std::vector<Eigen::Vector2d> points;
  std::vector<const leak_findings::Finding*> placed;
  for (const ReportedFinding& reported : report.findings) {
    if (reported.finding.position && reported.finding.position->point.allFinite()) {
      placed.push_back(&reported.finding);
      points.emplace_back(reported.finding.position->point.head<2>());
    }
  }
  std::vector<Eigen::Vector2d> way;
  std::copy_if(report.track.begin(), report.track.end(), std::back_inserter(way),
               [](const Eigen::Vector2d& p) { return p.allFinite(); });
  if (placed.empty() && way.empty()) {
    return "<p>No finding has a position: the images have no poses, or the range of the pipes is "
           "unknown.</p>";
  }
  points.insert(points.end(), way.begin(), way.end());
  for (const leak_findings::PipeLine& pipe : report.pipes) {
    points.emplace_back(pipe.from.head<2>());
    points.emplace_back(pipe.to.head<2>());
  }
  Eigen::Vector2d low = points.front();
  Eigen::Vector2d high = low;
  for (const Eigen::Vector2d& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const MapScale map(low, high);
  const std::string height = fixed(map.height(), 0);
  std::string svg = "<svg class=\"map\" viewBox=\"0 0 " + fixed(kWidth, 0) + " " + height +
                    "\" role=\"img\" aria-label=\"Map of the findings\">" + grid(map);
  for (const leak_findings::PipeLine& pipe : report.pipes) {
    svg += "<polyline class=\"pipe\" points=\"" + map.at(pipe.from.head<2>()) + " " +
           map.at(pipe.to.head<2>()) + "\"/>";
  }
  svg += track(map, way);
  for (const leak_findings::Finding* finding : placed) {
    svg += marker(map, *finding);
  }
  svg += "</svg><p class=\"note\">Ellipses: 95 % confidence. Hollow: cleared. ";
  svg += way.empty() ? "" : "Dashed: path of the robot. ";
  return svg + (report.pipes.empty() ? "" : "Grey: pipes. ") + "</p>";
}

}  // namespace pipescout
