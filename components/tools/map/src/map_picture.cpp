// SPDX-License-Identifier: Apache-2.0
#include "map_picture.hpp"

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

namespace pipescout::map {
namespace {

using navigation::CellState;
using navigation::PipeSide;
using navigation::Point2d;
using navigation::RouteEdge;

// Blue, green, red.
const cv::Scalar kRoad(200, 100, 30);
const cv::Scalar kAlongPipes(60, 150, 30);
const cv::Scalar kClosed(0, 140, 255);
const cv::Scalar kNode(80, 20, 20);
const cv::Scalar kProblem(0, 0, 230);
constexpr int kThin = 1;
constexpr int kThick = 2;

std::uint8_t shade_of(CellState state) {
  constexpr std::uint8_t kFree = 255;
  constexpr std::uint8_t kOccupied = 40;
  constexpr std::uint8_t kUnknown = 205;
  switch (state) {
    case CellState::kFree:
      return kFree;
    case CellState::kOccupied:
      return kOccupied;
    case CellState::kUnknown:
      break;
  }
  return kUnknown;
}

class Canvas {
 public:
  Canvas(const navigation::OccupancyGrid& grid, int scale) : grid_(grid), scale_(scale) {
    cv::Mat cells(grid.height(), grid.width(), CV_8UC1);
    for (int row = 0; row < grid.height(); ++row) {
      for (int column = 0; column < grid.width(); ++column) {
        cells.at<std::uint8_t>(grid.height() - 1 - row, column) = shade_of(grid.at({column, row}));
      }
    }
    cv::resize(cells, cells, {}, scale, scale, cv::INTER_NEAREST);
    cv::cvtColor(cells, image_, cv::COLOR_GRAY2BGR);
  }

  void draw_graph(const navigation::RouteGraph& graph) {
    for (const RouteEdge& edge : graph.edges()) {
      std::vector<Point2d> line = edge.line;
      if (line.empty()) {
        line = {graph.nodes()[edge.from].position, graph.nodes()[edge.to].position};
      }
      const cv::Scalar& colour = edge.closed_until                   ? kClosed
                                 : edge.pipe_side != PipeSide::kNone ? kAlongPipes
                                                                     : kRoad;
      for (std::size_t i = 1; i < line.size(); ++i) {
        draw_arrow(line[i - 1], line[i], colour);
      }
    }
    constexpr int kDot = 3;  // pixels
    constexpr double kLetters = 0.35;
    for (const navigation::RouteNode& node : graph.nodes()) {
      const cv::Point at = pixel_of(node.position);
      cv::circle(image_, at, kDot, kNode, cv::FILLED, cv::LINE_AA);
      cv::putText(image_, std::to_string(node.id), at + cv::Point(kDot + 1, -kDot),
                  cv::FONT_HERSHEY_SIMPLEX, kLetters, kNode, kThin, cv::LINE_AA);
    }
  }
  void mark(const Point2d& position) {
    constexpr int kRadius = 9;  // pixels
    cv::circle(image_, pixel_of(position), kRadius, kProblem, kThick, cv::LINE_AA);
  }
  [[nodiscard]] const cv::Mat& image() const { return image_; }

 private:
  [[nodiscard]] cv::Point pixel_of(const Point2d& p_map) const {
    const Point2d p = grid_.to_grid(p_map);
    return {static_cast<int>(std::lround(p.x * scale_)),
            static_cast<int>(std::lround((grid_.height() - p.y) * scale_))};
  }
  /// Its tip stands in the middle: edges there and back lie over each other.
  void draw_arrow(const Point2d& from, const Point2d& to, const cv::Scalar& colour) {
    constexpr double kTip = 8;  // pixels
    constexpr double kPlace = 0.55;
    const cv::Point a = pixel_of(from);
    const cv::Point b = pixel_of(to);
    cv::line(image_, a, b, colour, kThick, cv::LINE_AA);
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    if (length < 2 * kTip) {
      return;
    }
    const cv::Point2d along((b.x - a.x) / length, (b.y - a.y) / length);
    const cv::Point2d tip = cv::Point2d(a) + kPlace * length * along;
    const cv::Point2d aside(-along.y, along.x);
    for (const double side : {-0.5, 0.5}) {
      cv::line(image_, tip, tip - kTip * along + side * kTip * aside, colour, kThick, cv::LINE_AA);
    }
  }

  const navigation::OccupancyGrid& grid_;
  int scale_;
  cv::Mat image_;
};

}  // namespace

void draw_map(const std::filesystem::path& file, const MapPicture& picture, int scale) {
  constexpr double kMostPixels = 1e8;
  const double pixels =
      static_cast<double>(picture.grid.width()) * picture.grid.height() * scale * scale;
  if (pixels > kMostPixels) {
    throw std::invalid_argument("scale: " + std::to_string(scale) + " gives " +
                                std::to_string(std::llround(pixels)) +
                                " pixels; at most 1e8 are drawn");
  }
  Canvas canvas(picture.grid, scale);
  if (picture.graph) {
    canvas.draw_graph(*picture.graph);
  }
  for (const navigation::MapProblem& problem : picture.problems) {
    canvas.mark(problem.position);
  }
  bool written = false;
  std::string why;
  try {
    written = cv::imwrite(file.string(), canvas.image());
  } catch (const cv::Exception& error) {
    why = ": " + error.err;
  }
  if (!written) {
    throw std::runtime_error("cannot write " + file.string() + why);
  }
}

}  // namespace pipescout::map
