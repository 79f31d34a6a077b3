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
#include "pipescout/leak_survey/preset_advice.hpp"
#include "pipescout/leak_survey/survey_poses.hpp"
#include "pipescout/thermal_files/picture_folder.hpp"
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
    if (reader_.settings().automatic_gain &&
        settings_.detector.threshold_rule != thermal::ThresholdRule::kContrast) {
      throw std::runtime_error((options_.pictures / kThermalFile).string() +
                               ": grey: automatic_gain has no degrees: it needs preset contrast");
    }
    if (options_.poses) {
      const std::string file = options_.poses->string();
      poses_ = parse_survey_poses(read_csv_text(file), file, settings_);
      for (const std::string& note : poses_.notes) {
        complain(note);
      }
    }
  }

  LeakSurveyResult run() {
    const auto told = [this](const std::string& name) {
      const auto pose = poses_.by_file.find(name);
      return pose == poses_.by_file.end() ? std::nullopt : pose->second.time;
    };
    const PictureFolder found = pictures_in(options_.pictures, told, reader_);
    tell_unread(found);
    const std::vector<FolderPicture>& pictures = found.pictures;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      progress(i, pictures.size());
      try {
        look_at(pictures[i]);
        tell_alike();
      } catch (const ThermalFileError& error) {
        tell_failed(pictures[i], error.what());
        advise(error.advice());
      }
    }
    tell_alike();
    progress(pictures.size(), pictures.size());
    if (result_.without_pose > 0) {
      complain("no pose for " + std::to_string(result_.without_pose) + " of " +
               std::to_string(pictures.size()) + " pictures, the first of them " +
               first_without_pose_ + ": leaks in them have no position");
    }
    if (result_.same_time > 0) {
      complain(std::to_string(result_.same_time) + " of " + std::to_string(pictures.size()) +
               " pictures have the time of the one before: they follow it at frame_rate");
    }
    if (result_.with_pipes == 0) {
      advise(preset_advice(preset_trial_, settings_, result_.pictures));
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

  /// Once, whatever the number of images that ask for it.
  void advise(const std::string& advice) {
    if (!advice.empty() && std::ranges::find(result_.advice, advice) == result_.advice.end()) {
      result_.advice.push_back(advice);
    }
  }

  void tell_unread(const PictureFolder& found) {
    if (!found.problem.empty()) {
      complain(found.problem);
    }
    for (const std::string& name : found.unread) {
      ++result_.failed;
      complain(name + ": is a recording in a format that is not read");
      show({.name = name, .problem = "is a recording in a format that is not read"}, 3);
    }
  }

  /// Of the frames of a sequence that fail alike only the first.
  void tell_failed(const FolderPicture& picture, const std::string& problem) {
    ++result_.failed;
    const std::string reason = problem.substr(std::min(problem.rfind(": "), problem.size()));
    if (picture.frame > 0 && reason == failed_reason_) {
      ++failed_alike_;
      return;
    }
    tell_alike();
    failed_reason_ = reason;
    failed_file_ = picture.file.string();
    complain(problem);
    show({.name = picture.name(), .problem = problem}, 3);
  }
  /// And then how many more.
  void tell_alike() {
    if (failed_alike_ > 0) {
      complain(failed_file_ + ": " + std::to_string(failed_alike_) + " more frames likewise" +
               failed_reason_);
    }
    failed_alike_ = 0;
    failed_reason_.clear();
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
  /// the frame rate, from when the first file was written; so do pictures of the same time, as
  /// clocks of whole seconds give it.
  double time_of(const FolderPicture& from, const ThermalPicture& picture,
                 const PicturePose* pose) {
    std::optional<double> told = pose != nullptr && pose->time ? pose->time : picture.taken;
    told = told ? told : from.taken;
    times_are_told_ = times_are_told_ || told;
    if (!told && times_are_told_) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    const double next = last_time_ ? *last_time_ + 1 / settings_.frame_rate : written(from.file);
    if (!told) {
      return next;
    }
    const bool is_same = last_time_ && last_told_ && *told >= *last_told_ && *told <= *last_time_;
    result_.same_time += is_same ? 1U : 0U;
    last_told_ = told;
    return is_same ? next : *told;
  }

  void look_at(const FolderPicture& from) {
    ThermalPicture picture = reader_.read(from.file, *from.frames, from.frame);
    ++result_.pictures;
    const std::string name = from.name();
    if (!picture.unit_doubt.empty() && !unit_is_doubted_) {
      unit_is_doubted_ = true;
      complain(name + ": " + picture.unit_doubt);
    }
    const auto pose = poses_.by_file.find(name);
    const PicturePose* known = pose == poses_.by_file.end() ? nullptr : &pose->second;

    leak_findings::LeakFindings& findings = findings_for(picture);
    leak_findings::Frame frame;
    frame.time = time_of(from, picture, known);
    frame.number = ++number_;
    if (known != nullptr && known->pose) {
      frame.pose = known->pose;
      track_.emplace_back(known->pose->T_map_base.translation().head<2>());
    }
    thermal::FrameConditions conditions = findings.conditions(frame);
    if (!settings_.field_of_view && !settings_.camera) {
      conditions.metres_per_pixel = 0;  // the usual one would be a guess
    }
    conditions.levels = picture.levels;
    result_.levels += picture.levels ? 1U : 0U;
    conditions.posterior = posterior_of(picture);
    if (conditions.posterior != nullptr) {
      thermal::TemperatureTable(thermal::apparent_radiometry(picture.radiometry->camera()))
          .convert(picture.counts, picture.degrees);
    } else if (picture.radiometry) {
      conditions.errors.emplace(*picture.radiometry, reader_.settings().deviations);
    }
    const thermal::Detections& detections = detector_.detect(picture.view(), conditions);
    if (const thermal::PipeSection* pipe = detections.main_pipe();
        conditions.posterior != nullptr && pipe != nullptr) {
      posterior_->observe(pipe->reference_temperature);
    }
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

  /// Where counts are inspected by contrast; null for others. Of one camera and object: what the
  /// first picture tells.
  const thermal::RadiometryPosterior* posterior_of(const ThermalPicture& picture) {
    if (detector_.parameters().threshold_rule != thermal::ThresholdRule::kContrast ||
        !picture.radiometry || picture.counts.empty()) {
      return nullptr;
    }
    if (!posterior_) {
      posterior_.emplace(picture.radiometry->camera(), picture.radiometry->object(),
                         reader_.settings().deviations, reader_.settings().pipe_temperature);
    }
    return &*posterior_;
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
    if (result_.with_pipes == 0 && !picture.levels) {
      preset_trial_.keep(picture.view());
    }
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
    report.degrees = degrees_text(posterior_ ? &*posterior_ : nullptr, result_.levels > 0);
    result_.degrees = report.degrees;
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
  std::optional<thermal::RadiometryPosterior> posterior_;  // by contrast
  std::optional<leak_findings::LeakFindings> findings_;    // from the first picture on
  std::vector<Eigen::Vector2d> track_;
  std::vector<Shown> shown_;
  std::size_t shown_count_ = 0;
  std::uint64_t number_ = 0;
  std::optional<double> last_time_;
  std::optional<double> last_told_;
  bool times_are_told_ = false;
  std::string failed_reason_;  // of the frame before
  std::string failed_file_;
  std::size_t failed_alike_ = 0;  // frames in a row
  LeakSurveyResult result_;
  thermal::PresetTrial preset_trial_;
  bool unit_is_doubted_ = false;
  std::string first_without_pose_;  // file name
};

}  // namespace

LeakSurveyResult survey_leaks(const LeakSurveyOptions& options) {
  return Survey(options).run();
}

}  // namespace pipescout
