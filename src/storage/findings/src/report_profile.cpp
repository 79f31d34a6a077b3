// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "markup.hpp"
#include "report_figures.hpp"

namespace pipescout {
namespace {

constexpr double kWidth = 560;  // pixels, of each plot
constexpr double kHeight = 150;
constexpr double kLeft = 52;
constexpr double kRight = 12;
constexpr double kTop = 22;
constexpr double kBottom = 34;
constexpr const char* kLeakColour = "#1a9641";  // green, as the paper's Figure 5C
constexpr const char* kPartColour = "#55606a";

/// Axes and what is drawn between them.
class Plot {
 public:
  Plot(std::string title, double x_most, std::string x_name, double y_least, double y_most,
       std::string y_name)
      : x_most_(std::max(x_most, 1e-9)), y_least_(y_least), y_most_(y_most) {
    // For curves at the end of the range, and for what is written above them.
    const double room = std::max(0.15 * (y_most_ - y_least_), 0.5);
    y_most_ += room;
    y_least_ -= y_least_ == 0 ? 0 : room;
    svg_ = "<svg class=\"plot\" viewBox=\"0 0 " + fixed(kWidth, 0) + " " + fixed(kHeight, 0) +
           "\" role=\"img\" aria-label=\"" + escaped(title) + "\"><text class=\"title\" x=\"" +
           fixed(kLeft, 0) + "\" y=\"13\">" + escaped(title) + "</text>";
    axes(x_name, y_name);
  }

  [[nodiscard]] double x(double value) const {
    return kLeft + value / x_most_ * (kWidth - kLeft - kRight);
  }
  [[nodiscard]] double y(double value) const {
    return kHeight - kBottom -
           (value - y_least_) / (y_most_ - y_least_) * (kHeight - kTop - kBottom);
  }

  /// Value i stands at (i + offset) * step; NaN interrupts the line.
  void curve(const std::vector<float>& values, double offset, double step, const char* colour) {
    std::string path;
    bool drawing = false;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i])) {
        drawing = false;
        continue;
      }
      path += drawing ? 'L' : 'M';
      path += fixed(x((static_cast<double>(i) + offset) * step), 1) + " " +
              fixed(y(double{values[i]}), 1);
      drawing = true;
    }
    svg_ +=
        "<path d=\"" + path + "\" fill=\"none\" stroke=\"" + colour + "\" stroke-width=\"1.3\"/>";
  }
  void line(double x0, double y0, double x1, double y1, const std::string& colour,
            const char* width, const char* dash = "") {
    svg_ += "<line x1=\"" + fixed(x(x0), 1) + "\" y1=\"" + fixed(y(y0), 1) + "\" x2=\"" +
            fixed(x(x1), 1) + "\" y2=\"" + fixed(y(y1), 1) + "\" stroke=\"" + colour +
            "\" stroke-width=\"" + width + "\"" +
            (*dash == '\0' ? std::string() : std::string(" stroke-dasharray=\"") + dash + "\"") +
            "/>";
  }
  void label(double at_x, double at_y, const std::string& text, const std::string& colour) {
    svg_ += "<text x=\"" + fixed(x(at_x), 1) + "\" y=\"" + fixed(y(at_y) - 4, 1) +
            "\" text-anchor=\"middle\" fill=\"" + colour + "\">" + escaped(text) + "</text>";
  }
  void band(double from, double to, const char* colour) {
    svg_ += "<rect x=\"" + fixed(x(from), 1) + "\" y=\"" + fixed(kTop, 0) + "\" width=\"" +
            fixed(std::max(x(to) - x(from), 0.0), 1) + "\" height=\"" +
            fixed(kHeight - kTop - kBottom, 0) + "\" fill=\"" + colour +
            "\" fill-opacity=\"0.13\"/>";
  }
  [[nodiscard]] std::string done() const { return svg_ + "</svg>"; }
  [[nodiscard]] double x_most() const { return x_most_; }

 private:
  void axes(const std::string& x_name, const std::string& y_name) {
    const auto decimals = [](double step) {
      return std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
    };
    svg_ += "<g class=\"grid\">";
    const double dx = round_step(x_most_, 9);
    for (int i = 0; i * dx <= x_most_ * (1 + 1e-9); ++i) {
      const std::string at = fixed(x(i * dx), 1);
      svg_ += "<line x1=\"" + at + "\" x2=\"" + at + "\" y1=\"" + fixed(kTop, 0) + "\" y2=\"" +
              fixed(kHeight - kBottom, 0) + "\"/><text x=\"" + at + "\" y=\"" +
              fixed(kHeight - kBottom + 13, 0) + "\" text-anchor=\"middle\">" +
              fixed(i * dx, decimals(dx)) + "</text>";
    }
    const double dy = round_step(y_most_ - y_least_, 5);
    for (double v = std::ceil(y_least_ / dy) * dy; v <= y_most_; v += dy) {
      const std::string at = fixed(y(v), 1);
      svg_ += "<line y1=\"" + at + "\" y2=\"" + at + "\" x1=\"" + fixed(kLeft, 0) + "\" x2=\"" +
              fixed(kWidth - kRight, 0) + "\"/><text x=\"" + fixed(kLeft - 5, 0) + "\" y=\"" + at +
              "\" dy=\"4\" text-anchor=\"end\">" + fixed(v, decimals(dy)) + "</text>";
    }
    svg_ += "<text x=\"" + fixed((kWidth + kLeft) / 2, 0) + "\" y=\"" + fixed(kHeight - 5, 0) +
            "\" text-anchor=\"middle\">" + escaped(x_name) + "</text><text x=\"12\" y=\"" +
            fixed((kTop + kHeight - kBottom) / 2, 0) +
            "\" text-anchor=\"middle\" transform=\"rotate(-90 12 " +
            fixed((kTop + kHeight - kBottom) / 2, 0) + ")\">" + escaped(y_name) + "</text></g>";
  }

  double x_most_;
  double y_least_;
  double y_most_;
  std::string svg_;
};

/// Where a mark of the thumbnail goes.
std::string box(const OverlayLine& line, const char* css) {
  const Eigen::Vector2d along = line.end - line.start;
  const double length = along.norm();
  if (!(length > 0) || !std::isfinite(length)) {
    return "";
  }
  const Eigen::Vector2d across =
      Eigen::Vector2d(-along.y(), along.x()) / length * std::max(line.half_width, 2.0);
  std::string points;
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(line.start + across), Eigen::Vector2d(line.end + across),
        Eigen::Vector2d(line.end - across), Eigen::Vector2d(line.start - across)}) {
    points += fixed(corner.x(), 1) + "," + fixed(corner.y(), 1) + " ";
  }
  return std::string("<polygon class=\"") + css + "\" points=\"" + points + "\"/>";
}

}  // namespace

std::string profile_figure(const Evidence& e) {
  std::vector<float> known;
  std::copy_if(e.profile.begin(), e.profile.end(), std::back_inserter(known),
               [](float t) { return std::isfinite(t); });
  if (known.empty()) {
    return "<p>Without a profile.</p>";
  }
  const auto [least, most] = std::minmax_element(known.begin(), known.end());
  const bool metric = e.metres_per_sample > 0;
  const double step = metric ? e.metres_per_sample : 1;
  const double length = static_cast<double>(e.profile.size()) * step;
  const std::string x_name = metric ? "along the pipe / m" : "along the pipe / pixels";

  Plot temperature("A  Temperature along the pipe", length, x_name, double{*least}, double{*most},
                   "T / degC");
  temperature.curve(e.profile, 0.5, step, "#c0143c");

  std::vector<float> change;
  thermal::absolute_change(e.profile, e.split_distance, change);
  float largest = 0;
  for (const float value : change) {
    largest = std::isfinite(value) ? std::max(largest, value) : largest;
  }
  Plot derivative("B  Absolute value of its change over " + std::to_string(e.split_distance) +
                      (e.split_distance == 1 ? " sample" : " samples"),
                  length, x_name, 0, std::max(double{largest}, e.split_delta), "|dT| / K");
  derivative.curve(change, 0.5 * (1 + e.split_distance), step, "#2a78b5");
  derivative.line(0, e.split_delta, length, e.split_delta, "#777777", "1", "4 3");

  Plot parts("C  Parts and their labels", length, x_name, double{*least}, double{*most},
             "T / degC");
  parts.band(e.leak_from * step, e.leak_to * step, kLeakColour);
  parts.curve(e.profile, 0.5, step, "#e3a6b2");
  if (std::isfinite(e.reference_temperature)) {
    parts.line(0, e.reference_temperature, length, e.reference_temperature, "#777777", "1", "4 3");
  }
  for (const ProfilePart& part : e.parts) {
    if (!std::isfinite(part.mean)) {
      continue;
    }
    const bool leak = part.kind == thermal::PartKind::kLeak;
    const bool pipe = part.kind == thermal::PartKind::kPipe;
    parts.line(part.from * step, part.mean, part.to * step, part.mean,
               leak ? kLeakColour : kPartColour, leak || pipe ? "3" : "1",
               leak || pipe ? "" : "2 2");
    if (leak) {
      parts.label((part.from + part.to) / 2 * step, part.mean, fixed(part.mean, 1), kLeakColour);
    }
  }
  return "<div class=\"profile\">" + temperature.done() + derivative.done() + parts.done() +
         "<p class=\"note\">Dashed: Delta-T at which the pipe is split (B), the sound pipe (C). "
         "Green: leak. Thin and dashed: too short, hidden, or another object.</p></div>";
}

std::string thumbnail_figure(const Thumbnail& thumbnail, const std::vector<OverlayLine>& pipes,
                             const std::vector<OverlayLine>& leaks,
                             const std::string& description) {
  const std::string size =
      std::to_string(thumbnail.width) + "\" height=\"" + std::to_string(thumbnail.height);
  std::string svg = "<svg class=\"thumbnail\" width=\"" + size + "\" viewBox=\"0 0 " +
                    std::to_string(thumbnail.width) + " " + std::to_string(thumbnail.height) +
                    "\" role=\"img\" aria-label=\"" + escaped(description) + "\"><image width=\"" +
                    size + "\" href=\"" + png_uri(thumbnail.png) + "\"/>";
  for (const OverlayLine& line : pipes) {
    svg += box(line, "pipe-mark");
  }
  for (const OverlayLine& line : leaks) {
    svg += box(line, "leak-mark");
  }
  return svg + "</svg>";
}

}  // namespace pipescout
