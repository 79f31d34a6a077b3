// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_survey/leak_survey.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pipescout/csv/csv_file.hpp"
#include "pipescout/leak_store/findings_archive.hpp"
#include "pipescout/leak_store/leak_report.hpp"
#include "pipescout/leak_survey/picture_recording.hpp"
#include "pipescout/leak_survey/survey_poses.hpp"
#include "pipescout/thermal_files/thermal_file.hpp"
#include "pipescout/thermal_files/yaml_entries.hpp"
#include "survey_texts.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;
using leak_findings::Finding;
using leak_findings::FindingState;

constexpr int kOverviewSide = 320;  // pixels
// Where nobody has told it, and no pose needs it: that of a lens as cameras are sold with.
constexpr double kUsualFieldOfView = 0.436;  // rad

std::vector<fs::path> pictures_in(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (!at->is_directory() && has_thermal_extension(at->path())) {
      files.push_back(at->path());
    }
  }
  if (error) {
    throw std::runtime_error(folder.string() + ": " + error.message());
  }
  if (files.empty()) {
    throw std::runtime_error(folder.string() +
                             ": contains no image: no .jpg, .jpeg, .fff, .png, .tif or .tiff");
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// s since 1970 UTC
double written(const fs::path& file) {
  std::error_code error;
  const auto time = fs::last_write_time(file, error);
  if (error) {
    return 0;
  }
  const auto system = std::chrono::file_clock::to_sys(time);
  return std::chrono::duration<double>(system.time_since_epoch()).count();
}

SurveySettings settings_of(const LeakSurveyOptions& options) {
  const fs::path file = options.pictures / kSurveyFile;
  SurveySettings settings =
      parse_survey_settings(fs::exists(file) ? text_of(file) : "", file.string(),
                            options.read_parameters, options.preset);
  if (options.poses && !settings.field_of_view && !settings.camera) {
    throw std::runtime_error(
        file.string() + ": poses need the camera's field_of_view, or camera; neither is given");
  }
  return settings;
}

ThermalSettings thermal_settings_of(const LeakSurveyOptions& options) {
  const fs::path file = options.pictures / kThermalFile;
  return fs::exists(file) ? read_thermal_settings(file) : ThermalSettings{};
}

/// Finds the pictures of a mission, and the poses with them.
LeakSurveyOptions located(LeakSurveyOptions options) {
  if (fs::is_directory(options.pictures / kMissionPictures)) {
    options.pictures /= kMissionPictures;
  }
  const fs::path poses = options.pictures / kPosesFile;
  if (!options.poses && fs::exists(poses)) {
    options.poses = poses;
  }
  return options;
}

class Survey {
 public:
  explicit Survey(const LeakSurveyOptions& options)
      : options_(located(options)),
        settings_(settings_of(options_)),
        reader_(thermal_settings_of(options_), options.exiftool),
        detector_(settings_.detector),
        archive_(made(options.out) / "leaks.sqlite", options.out) {
    if (options_.poses) {
      const std::string file = options_.poses->string();
      poses_ = parse_survey_poses(read_csv_text(file), file, settings_);
      if (!poses_.problem.empty()) {
        complain(poses_.problem);
      }
    }
  }

  LeakSurveyResult run() {
    const std::vector<fs::path> files = pictures_in(options_.pictures);
    for (std::size_t i = 0; i < files.size(); ++i) {
      progress(i, files.size());
      try {
        look_at(files[i]);
      } catch (const ThermalFileError& error) {
        ++result_.failed;
        complain(error.what());
        show({.name = files[i].filename().string(), .problem = error.what()}, 3);
      }
    }
    progress(files.size(), files.size());
    if (result_.without_pose > 0) {
      complain("no pose for " + std::to_string(result_.without_pose) + " of " +
               std::to_string(files.size()) + " pictures, the first of them " +
               first_without_pose_ + ": leaks in them have no position");
    }
    finish();
    return result_;
  }

 private:
  struct Shown {
    std::size_t number = 0;
    int rank = 0;  // the greater, the rather it is shown
    ReportedPicture picture;
  };

  static fs::path made(const fs::path& folder) {
    fs::create_directories(folder);
    return folder;
  }

  void progress(std::size_t done, std::size_t total) const {
    if (options_.progress) {
      options_.progress(done, total);
    }
  }
  void complain(const std::string& problem) const {
    if (options_.complain) {
      options_.complain(problem);
    }
  }

  [[nodiscard]] double focal_length(int width) const {
    return 0.5 * width / std::tan(0.5 * settings_.field_of_view.value_or(kUsualFieldOfView));
  }

  leak_findings::LeakFindings& findings_for(const ThermalPicture& picture) {
    if (!findings_) {
      geometry::CameraParameters camera = settings_.camera.value_or(geometry::CameraParameters{});
      if (!settings_.camera) {
        camera.width = picture.width;
        camera.height = picture.height;
        camera.focal_length = focal_length(picture.width);
        camera.centre_u = 0.5 * (picture.width - 1);
        camera.centre_v = 0.5 * (picture.height - 1);
      }
      findings_.emplace(settings_.findings, geometry::Camera(camera));
      findings_->restore(archive_.known());
    }
    return *findings_;
  }

  /// NaN where the picture does not tell and others do. Where none does, they follow each other at
  /// the frame rate, from when the first file was written.
  double time_of(const fs::path& file, const ThermalPicture& picture, const PicturePose* pose) {
    const std::optional<double> told = pose != nullptr && pose->time ? pose->time : picture.taken;
    times_are_told_ = times_are_told_ || told;
    if (told || times_are_told_) {
      return told.value_or(std::numeric_limits<double>::quiet_NaN());
    }
    return last_time_ ? *last_time_ + 1 / settings_.frame_rate : written(file);
  }

  void look_at(const fs::path& file) {
    const ThermalPicture picture = reader_.read(file);
    ++result_.pictures;
    const std::string name = file.filename().string();
    const auto pose = poses_.by_file.find(name);
    const PicturePose* known = pose == poses_.by_file.end() ? nullptr : &pose->second;

    leak_findings::LeakFindings& findings = findings_for(picture);
    leak_findings::Frame frame;
    frame.time = time_of(file, picture, known);
    frame.number = ++number_;
    if (known != nullptr && known->pose) {
      frame.pose = known->pose;
      track_.emplace_back(known->pose->T_map_base.translation().head<2>());
    }
    thermal::FrameConditions conditions = findings.conditions(frame);
    if (!settings_.field_of_view && !settings_.camera) {
      conditions.metres_per_pixel = 0;  // the usual one would be a guess
    }
    if (picture.radiometry) {
      conditions.errors.emplace(*picture.radiometry, reader_.settings().deviations);
    }
    const thermal::Detections& detections = detector_.detect(picture.view(), conditions);
    const leak_findings::FrameResult& outcome = findings.update(frame, detections);
    if (outcome.fault != leak_findings::InputFault::kBadTime) {
      last_time_ = frame.time;
      archive_.log(condition_record(picture, reader_.settings(), settings_, frame.time,
                                    options_.pictures.string()));
    }
    keep_evidence(picture, detections, outcome, frame, name);
    save(outcome);
    tell(picture, detections, outcome, frame.time, name);
  }

  /// Of each finding that this frame shows better than those before.
  void keep_evidence(const ThermalPicture& picture, const thermal::Detections& detections,
                     const leak_findings::FrameResult& outcome, const leak_findings::Frame& frame,
                     const std::string& name) {
    const std::size_t leaks = std::min(outcome.finding_of.size(), detections.leaks.size());
    for (std::size_t i = 0; i < leaks; ++i) {
      const Finding* finding = findings_->find(outcome.finding_of[i]);
      if (finding != nullptr && archive_.wants(*finding, frame.time)) {
        archive_.keep(finding->id, make_evidence(picture.view(), detections, i,
                                                 detector_.parameters().profile, frame.time, name));
      }
    }
  }

  void save(const leak_findings::FrameResult& outcome) {
    for (const leak_findings::Event& event : outcome.events) {
      if (const Finding* finding = findings_->find(event.finding)) {
        archive_.save(*finding);
      }
    }
  }

  void tell(const ThermalPicture& picture, const thermal::Detections& detections,
            const leak_findings::FrameResult& outcome, double time, const std::string& name) {
    ReportedPicture shown;
    shown.name = name;
    shown.summary = picture_summary(picture, detections);
    shown.doubts = joined_lines(picture.doubts);
    shown.problem = fault_text(detections.fault);
    if (detections.fault != thermal::FrameFault::kNone) {
      ++result_.failed;
    } else if (outcome.fault == leak_findings::InputFault::kBadTime) {
      ++result_.out_of_order;
      shown.problem = std::isnan(time)
                          ? "has no time, although others have one: it does not update findings"
                          : "was not taken after the previous image: it does not update findings";
    } else if (outcome.fault == leak_findings::InputFault::kBadSize) {
      shown.problem = std::string("differs in size from ") +
                      (settings_.camera ? "the camera" : "the first image") +
                      ": it does not update findings";
    }
    const int rank = !detections.leaks.empty()   ? 4
                     : !shown.problem.empty()    ? 3
                     : !detections.pipes.empty() ? 2
                                                 : 1;
    if (!shown.problem.empty()) {
      complain(name + ": " + shown.problem);
    } else if (outcome.fault == leak_findings::InputFault::kNoPose && options_.poses) {
      // Often so of all until the robot knows where it is: told once, at the end.
      shown.problem = "has no pose: leaks in it have no position";
      if (++result_.without_pose == 1) {
        first_without_pose_ = name;
      }
    }
    result_.with_pipes += detections.pipes.empty() ? 0U : 1U;
    result_.leak_detections += detections.leaks.size();
    if (detections.width == picture.width && detections.height == picture.height) {
      shown.overview = make_overview(picture.view(), detections, kOverviewSide);
    }
    show(std::move(shown), rank);
  }

  void show(ReportedPicture picture, int rank) {
    shown_.push_back({shown_count_++, rank, std::move(picture)});
    if (shown_.size() >= 2 * options_.most_pictures + 16) {
      prune();
    }
  }
  /// Keeps what is worth showing most, in the order in which it came.
  void prune() {
    std::stable_sort(shown_.begin(), shown_.end(),
                     [](const Shown& a, const Shown& b) { return a.rank > b.rank; });
    if (shown_.size() > options_.most_pictures) {
      shown_.erase(shown_.begin() + static_cast<std::ptrdiff_t>(options_.most_pictures),
                   shown_.end());
    }
    std::sort(shown_.begin(), shown_.end(),
              [](const Shown& a, const Shown& b) { return a.number < b.number; });
  }

  void finish() {
    if (findings_) {
      for (const Finding& finding : findings_->findings()) {
        archive_.save(finding);
        result_.raised += finding.state == FindingState::kRaised ? 1U : 0U;
      }
      result_.candidates = findings_->candidates().size();
    }
    LeakReport report;
    report.title = "Leaks: " + fs::absolute(options_.pictures).lexically_normal().string();
    report.made = options_.made;
    report.pipes = settings_.findings.lines;
    report.track = std::move(track_);
    report.datum = settings_.datum;
    report.pictures_read = result_.pictures;
    report.pictures_failed = result_.failed;
    prune();
    for (Shown& shown : shown_) {
      report.pictures.push_back(std::move(shown.picture));
    }
    // From the store: what other days have found and this one could not see is there too.
    archive_.write_report(archive_.known(), std::move(report));
  }

  const LeakSurveyOptions options_;
  SurveySettings settings_;
  ThermalFileReader reader_;
  thermal::LeakDetector detector_;
  FindingsArchive archive_;
  SurveyPoses poses_;
  std::optional<leak_findings::LeakFindings> findings_;  // from the first picture on
  std::vector<Eigen::Vector2d> track_;
  std::vector<Shown> shown_;
  std::size_t shown_count_ = 0;
  std::uint64_t number_ = 0;
  std::optional<double> last_time_;
  bool times_are_told_ = false;
  LeakSurveyResult result_;
  std::string first_without_pose_;  // file name
};

}  // namespace

LeakSurveyResult survey_leaks(const LeakSurveyOptions& options) {
  return Survey(options).run();
}

}  // namespace pipescout
