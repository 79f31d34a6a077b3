// SPDX-License-Identifier: Apache-2.0
#include "pipe_tracks.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/thermal_parameters/detection_parameters.hpp"

namespace pipescout::track {
namespace {

using tracking::TrackState;

constexpr const char* kHeader =
    "image,time,state,track,x,y,length,angle,x_sd,y_sd,length_sd,angle_sd,confidence,in_view,"
    "regions,problem\n";

std::string percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? "0 %" : std::to_string((100 * part + whole / 2) / whole) + " %";
}

}  // namespace

PipeTracks::PipeTracks(const thermal::LeakDetectorParameters& detector, std::uint64_t seed)
    : detector_(detector),
      tracker_(tracking::PipeShape{}, tracking::PipeTrackerParameters{}, seed),
      csv_(kHeader) {}

void PipeTracks::take(const SourceImage& image) {
  const thermal::Detections& detections = detect(detector_, image.pixels, image.celsius);
  regions_.clear();
  for (const thermal::PipeSection& pipe : detections.pipes) {
    regions_.push_back({.start = pipe.start,
                        .end = pipe.end,
                        .half_width = pipe.half_width,
                        .cut_along = pipe.cut_along});
  }
  const tracking::PipeTrack& track =
      tracker_.update({.time = image.time,
                       .image = {.width = detections.width, .height = detections.height},
                       .regions = regions_,
                       .motion = {},
                       .hint = {}});
  std::string problem;
  if (detections.fault != thermal::FrameFault::kNone) {
    problem = to_string(detections.fault);
  } else if (track.fault != tracking::TrackFault::kNone) {
    problem = to_string(track.fault);
  }
  ++images_;
  times_.push_back(image.time);
  with_pipes_ += regions_.empty() ? 0U : 1U;
  locked_ += track.state == TrackState::kLocked ? 1U : 0U;
  coasting_ += track.state == TrackState::kCoasting ? 1U : 0U;
  failed_ += problem.empty() ? 0U : 1U;
  tracks_ = std::max(tracks_, track.number);

  std::string line = csv_cell(image.name) + "," + format_csv_number(image.time) + "," +
                     std::string(to_string(track.state)) + "," + std::to_string(track.number);
  if (track.number > 0) {
    for (const double value : track.estimate) {
      line += "," + format_csv_number(value);
    }
    for (const double variance : track.covariance.diagonal()) {
      line += "," + format_csv_number(std::sqrt(std::max(0.0, variance)));
    }
  } else {
    line.append(2 * tracking::PipeShape::kSize, ',');
  }
  line += "," + format_csv_number(track.confidence) + (track.in_view ? ",1," : ",0,") +
          std::to_string(regions_.size()) + "," + csv_cell(problem) + "\n";
  csv_ += line;
}

void PipeTracks::fail(const std::string& name, const std::string& problem) {
  ++failed_;
  csv_ += csv_cell(name) + std::string(15, ',') + csv_cell(problem) + "\n";
}

std::string PipeTracks::summary() const {
  return std::to_string(images_) + " images, " + std::to_string(with_pipes_) + " with pipes\n" +
         std::to_string(tracks_) + (tracks_ == 1 ? " track" : " tracks") + "; locked in " +
         percent(locked_, images_) + " of the images, predicted in " + percent(coasting_, images_) +
         "\n";
}

std::string PipeTracks::advice() const {
  if (tracks_ > 0 || with_pipes_ < tracker_.parameters().confirm) {
    return {};
  }
  const double interval =
      (times_.back() - times_.front()) / static_cast<double>(times_.size() - 1);  // s
  return "pipes in " + std::to_string(with_pipes_) +
         " images, and none that is surely the same in " +
         std::to_string(tracker_.parameters().confirm) + ": the images are " +
         format_csv_number(std::round(interval * 1000.0) / 1000.0) +
         " s apart on average, and how the camera moved in between is not known; images less than "
         "0.3 s apart can be tracked";
}

}  // namespace pipescout::track
