// SPDX-License-Identifier: Apache-2.0
#include "track_report.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "pipescout/command_line/formatted.hpp"
#include "pipescout/csv/csv_line.hpp"
#include "pipescout/mission_tables/pose_csv.hpp"

namespace pipescout::rack {
namespace {

using command_line::formatted;
using rack_vision::TrackStatus;

bool is_tracked(const TrackedImage& image) {
  return image.status == TrackStatus::kTracking;
}

double seconds(Stamp stamp) {
  return std::chrono::duration<double>(stamp.time_since_epoch()).count();
}

/// "1 image", "2 images".
std::string images_text(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " image" : " images");
}

/// Of the camera's position along a unit vector, median over the tracked images, m.
double median_deviation(const TrackRun& run, const Eigen::Vector3d& direction) {
  std::vector<double> values;
  for (const TrackedImage& image : run.images) {
    if (is_tracked(image)) {
      const double variance = direction.dot(image.covariance.topLeftCorner<3, 3>() * direction);
      values.push_back(std::sqrt(std::max(0.0, variance)));
    }
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

std::string summary(const TrackRun& run) {
  const double begin = seconds(run.images.front().stamp);
  const auto count = static_cast<double>(run.images.size());
  std::string text =
      formatted("%s in %.2f s: the rack was tracked in %zu (%.1f %%).\n",
                images_text(run.images.size()).c_str(), seconds(run.images.back().stamp) - begin,
                run.tracked, 100 * static_cast<double>(run.tracked) / count);
  if (run.tracked == 0) {
    return text;
  }
  const auto first = std::ranges::find_if(run.images, is_tracked);
  text += formatted("First pose after %.2f s, in %s.\n", seconds(first->stamp) - begin,
                    first->name.c_str());
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  text += formatted(
      "Stated standard deviation of the camera's position, median over the images: %.1f mm across "
      "the pipes, %.1f mm along them, %.1f mm in height.\n",
      1e3 * median_deviation(run, run.along.cross(up).normalized()),
      1e3 * median_deviation(run, run.along), 1e3 * median_deviation(run, up));
  return text;
}

/// Runs of images with one status and one reason.
std::string course(const TrackRun& run) {
  constexpr std::size_t kMostLines = 60;
  std::string text =
      "\n## What was tracked when\n\n| from [s] | to [s] | images | state | reason |\n"
      "|---|---|---|---|---|\n";
  const double begin = seconds(run.images.front().stamp);
  std::size_t lines = 0;
  for (std::size_t i = 0; i < run.images.size();) {
    const TrackedImage& head = run.images[i];
    std::size_t end = i;
    while (end < run.images.size() && run.images[end].status == head.status &&
           run.images[end].reason == head.reason) {
      ++end;
    }
    if (lines++ < kMostLines) {
      text += formatted("| %.2f | %.2f | %zu | %s | %s |\n", seconds(head.stamp) - begin,
                        seconds(run.images[end - 1].stamp) - begin, end - i,
                        std::string(to_string(head.status)).c_str(), head.reason.c_str());
    }
    i = end;
  }
  if (lines > kMostLines) {
    text += formatted("\n%zu more changes are in `images.csv`.\n", lines - kMostLines);
  }
  return text;
}

std::string pipes(const TrackRun& run) {
  if (run.offsets.empty()) {
    return {};
  }
  std::string text =
      "\n## Pipes\n\nOffset along rack x against the rack file, after the last tracked "
      "image:\n\n| pipe | offset [mm] | standard deviation [mm] |\n|---|---|---|\n";
  for (const PipeOffset& each : run.offsets) {
    text += each.movable ? formatted("| %s | %.1f | %.1f |\n", each.pipe.c_str(), 1e3 * each.offset,
                                     1e3 * each.deviation)
                         : formatted("| %s | as in the file | |\n", each.pipe.c_str());
  }
  return text;
}

std::string shapes(const TrackRun& run) {
  if (run.shapes.empty()) {
    return {};
  }
  std::string text =
      "\n## Shapes of pipes\n\nAgainst the rack file, with one standard deviation, after the last "
      "tracked image. Turns are those of the axis about its middle.\n\n"
      "| pipe | height [mm] | radius [mm] | turned aside [mrad] | turned up [mrad] |\n"
      "|---|---|---|---|---|\n";
  for (const PipeShapeFound& each : run.shapes) {
    const auto cell = [](double value, double deviation) {
      return formatted(" %.1f +- %.1f |", 1e3 * value, 1e3 * deviation);
    };
    text += "| " + each.pipe + " |";
    text += each.found ? cell(each.shape.height, each.deviation.height) +
                             cell(each.shape.radius, each.deviation.radius) +
                             cell(each.shape.turn_aside, each.deviation.turn_aside) +
                             cell(each.shape.turn_up, each.deviation.turn_up) + "\n"
                       : " not told by the images | | | |\n";
  }
  return text;
}

std::vector<std::string> left_out(const TrackRun& run) {
  constexpr std::size_t kMostNames = 3;
  std::map<std::string, std::vector<std::string>> by_reason;
  for (const LeftOut& each : run.left_out) {
    by_reason[each.reason].push_back(each.name);
  }
  for (const TrackedImage& image : run.images) {
    if (image.status == TrackStatus::kBadImage || image.status == TrackStatus::kBadStamp) {
      by_reason[image.reason].push_back(image.name);
    }
  }
  std::vector<std::string> lines;
  for (const auto& [reason, names] : by_reason) {
    std::string line = images_text(names.size()) + ": " + reason + " (";
    for (std::size_t i = 0; i < std::min(names.size(), kMostNames); ++i) {
      line += (i == 0 ? "" : ", ") + names[i];
    }
    lines.push_back(line + (names.size() > kMostNames ? ", ...)." : ")."));
  }
  return lines;
}

/// What a user can do about it.
std::vector<std::string> advice(const TrackRun& run) {
  constexpr double kUnknownAlong = 0.5;  // m
  std::vector<std::string> lines;
  const auto& starts = run.starts;
  if (run.tracked == 0) {
    if (starts.image_ambiguous > 0) {
      lines.push_back(formatted(
          "The contours of %s fit several poses of the camera: the rack looks the same turned by "
          "180 degrees, or one pitch further. Give --heading, --near or --start.",
          images_text(starts.image_ambiguous).c_str()));
    }
    if (starts.image_unclear > 0) {
      lines.push_back(formatted(
          "No pose explains %s. Compare rack file (all lengths in m), calibration and images; give "
          "--start if you know where the camera was.",
          images_text(starts.image_unclear).c_str()));
    }
    if (starts.given > 0) {
      lines.emplace_back("The pose of --start was not confirmed by the images.");
    }
  } else if (median_deviation(run, run.along) > kUnknownAlong) {
    lines.emplace_back(
        "The position along the pipes is not determined by these images: no support, crossing "
        "pipe or pipe end was recognised. Its changes are meaningful, its value is not.");
  }
  return lines;
}

void add_list(std::string& text, const char* title, const std::vector<std::string>& lines,
              const char* none) {
  text += std::string("\n## ") + title + "\n\n";
  for (const std::string& line : lines) {
    text += "- " + line + "\n";
  }
  if (lines.empty()) {
    text += std::string(none) + "\n";
  }
}

}  // namespace

std::string poses_csv(const TrackRun& run) {
  std::string text = uncertain_pose_csv_header() + ",image\n";
  for (const TrackedImage& image : run.images) {
    if (is_tracked(image)) {
      CsvLine line = uncertain_pose_csv_line(image.stamp, image.T_rack_camera, image.covariance);
      text += line.add(std::string_view(image.name)).text() + "\n";
    }
  }
  return text;
}

std::string poses_tum(const TrackRun& run) {
  std::string text;
  for (const TrackedImage& image : run.images) {
    if (is_tracked(image)) {
      const Eigen::Vector3d& p = image.T_rack_camera.translation();
      const auto& q = image.T_rack_camera.rotation().quaternion();
      text += format_stamp(image.stamp.time_since_epoch()) +
              formatted(" %.6f %.6f %.6f %.8f %.8f %.8f %.8f\n", p.x(), p.y(), p.z(), q.x(), q.y(),
                        q.z(), q.w());
    }
  }
  return text;
}

std::string images_csv(const TrackRun& run) {
  std::string text =
      "stamp,image,status,reason,quality,edge_samples,edge_samples_found,points,points_matched\n";
  for (const TrackedImage& image : run.images) {
    CsvLine line(image.stamp);
    line.add(std::string_view(image.name)).add(to_string(image.status)).add(image.reason);
    is_tracked(image) ? line.add_short(image.quality) : line.add_empty();
    for (const int count :
         {image.edge_samples, image.edge_samples_found, image.points, image.points_matched}) {
      line.add(static_cast<std::uint64_t>(count));
    }
    text += line.text() + "\n";
  }
  return text;
}

std::string report(const TrackRun& run, const std::vector<std::string>& said) {
  std::string text = "# Camera poses over the rack\n\n" + summary(run);
  std::vector<std::string> taken = said;
  taken.insert(taken.end(), run.said.begin(), run.said.end());
  add_list(text, "What was taken for what", taken, "Nothing.");
  text += course(run);
  text += pipes(run);
  text += shapes(run);
  add_list(text, "What was left out, and why", left_out(run), "Nothing.");
  if (const auto lines = advice(run); !lines.empty()) {
    add_list(text, "What to do", lines, "");
  }
  return text;
}

}  // namespace pipescout::rack
