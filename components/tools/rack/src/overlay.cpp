// SPDX-License-Identifier: Apache-2.0
#include "overlay.hpp"

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>

#include "pipescout/command_line/formatted.hpp"

namespace pipescout::rack {
namespace {

using command_line::formatted;
using rack_vision::TrackStatus;

// Blue, green, red.
const cv::Scalar kPipe(80, 220, 60);
const cv::Scalar kSupport(30, 140, 255);
const cv::Scalar kTracked(80, 220, 60);
const cv::Scalar kNotTracked(60, 60, 255);

/// Fractional bits of OpenCV's coordinates.
constexpr int kShift = 4;

cv::Point fixed_point(const Eigen::Vector2d& pixel) {
  constexpr double kScale = 1 << kShift;
  return {static_cast<int>(std::lround(pixel.x() * kScale)),
          static_cast<int>(std::lround(pixel.y() * kScale))};
}

/// Bent as the lens bends it.
void draw(const rack_vision::VisibleEdge& edge, const geometry::Camera& camera,
          const cv::Scalar& colour, cv::Mat& picture) {
  const int pieces = camera.has_distortion() ? 24 : 1;
  std::optional<Eigen::Vector2d> last;
  for (int i = 0; i <= pieces; ++i) {
    const double share = static_cast<double>(i) / pieces;
    const auto pixel =
        camera.distort(edge.image_start + share * (edge.image_end - edge.image_start));
    // Within OpenCV's range of coordinates.
    const bool near = pixel && pixel->cwiseAbs().maxCoeff() < (1 << 20);
    if (last && near) {
      cv::line(picture, fixed_point(*last), fixed_point(*pixel), colour, 1, cv::LINE_AA, kShift);
    }
    last = near ? pixel : std::nullopt;
  }
}

void print(const std::string& text, const cv::Scalar& colour, cv::Mat& picture) {
  constexpr double kSize = 0.5;
  const cv::Point place(6, 16);
  cv::putText(picture, text, place, cv::FONT_HERSHEY_SIMPLEX, kSize, cv::Scalar(0, 0, 0), 3,
              cv::LINE_AA);
  cv::putText(picture, text, place, cv::FONT_HERSHEY_SIMPLEX, kSize, colour, 1, cv::LINE_AA);
}

}  // namespace

Overlay::Overlay(const rack_vision::RackModel& model, const geometry::Camera& camera)
    : drawn_(model), model_(model), camera_(camera) {}

void Overlay::write(const std::filesystem::path& file, const rack_vision::ImageView& image,
                    const rack_vision::RackTrackerResult& result) {
  // OpenCV wants a matrix that it may write to, and does not.
  const cv::Mat grey(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels),
                     static_cast<std::size_t>(image.stride));
  cv::Mat picture;
  cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
  if (result.status == TrackStatus::kTracking) {
    for (const rack_vision::PipeShapeEstimate& each : result.shapes) {
      rack_vision::PipeShape shape = each.shape;
      shape.offset = 0;  // it is in the offsets
      model_.pipes[each.pipe] = shaped(drawn_.pipes[each.pipe], shape);
    }
    renderer_.render(model_, result.offsets, camera_, result.T_rack_camera.inverse(), edges_);
    for (const rack_vision::VisibleEdge& edge : edges_) {
      draw(edge, camera_, edge.id.kind == rack_vision::EdgeKind::kPipe ? kPipe : kSupport, picture);
    }
    const Eigen::Vector3d& p = result.T_rack_camera.translation();
    print(formatted("tracked, quality %.2f, at %.3f %.3f %.3f m", result.quality, p.x(), p.y(),
                    p.z()),
          kTracked, picture);
  } else {
    const std::string reason(result.reason);
    print(std::string(to_string(result.status)) + (reason.empty() ? "" : ": " + reason),
          kNotTracked, picture);
  }
  bool written = false;
  try {
    written = cv::imwrite(file.string(), picture);
  } catch (const cv::Exception&) {
    written = false;
  }
  if (!written) {
    throw std::runtime_error(file.string() + ": cannot be written");
  }
}

}  // namespace pipescout::rack
