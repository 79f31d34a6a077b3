// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometer_replay/odometer_replay.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/csv/csv_file.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout {

namespace {

/// A replay that is later than this does not catch up: the clock was set, or the machine slept.
constexpr Duration kMaximumDelay = std::chrono::seconds(1);

}  // namespace

OdometerReplay::OdometerReplay(ComponentOptions options) : Component(std::move(options)) {
  file_ = parameters().declare<std::string>(
      "file", "", {.description = "CSV file of readings, see docs/components/odometer_replay.md"});
  odometers_ = parameters().declare<std::vector<std::string>>(
      "odometers", {},
      {.description =
           "columns to publish, in this order; empty: every column that is an odometer"});
  ignored_columns_ = parameters().declare<std::vector<std::string>>(
      "ignored_columns", {}, {.description = "columns that are not odometers; they may be absent"});
  delimiter_ = parameters().declare<std::string>(
      "delimiter", "",
      {.description =
           "between the file's columns: ',', ';', '|', tab or blank; empty: recognised"});
  decimal_mark_ = parameters().declare<std::string>(
      "decimal_mark", "", {.description = "of the file's numbers: '.' or ','; empty: recognised"});
  time_unit_ = parameters().declare<std::string>(
      "time_unit", "", {.description = "of the file's stamps: s, ms, us or ns; empty: recognised"});
  standard_deviations_ = parameters().declare<std::vector<double>>(
      "standard_deviations", {},
      {.description = "m, one per odometer; empty: the file's columns NAME.standard_deviation",
       .floating_point_range = FloatingPointRange{1e-9, 1e6}});
  period_ = parameters().declare<double>(
      "period", 0.1,
      {.description = "s, between two readings of a file without stamps",
       .floating_point_range = FloatingPointRange{1e-4, 3600.0}});
  rate_ = parameters().declare<double>(
      "rate", 1.0,
      {.description = "playback rate, as a multiple of the recording's; may be changed at any time",
       .floating_point_range = FloatingPointRange{1e-3, 1e3}});
  use_recorded_stamps_ =
      parameters().declare<bool>("use_recorded_stamps", false,
                                 {.description = "publish the stamps of the file; false: the time "
                                                 "at which the replay publishes the reading"});
  frame_id_ = parameters().declare<std::string>("frame_id", "base_link",
                                                {.description = "base frame of the robot"});
}

OdometerReplay::~OdometerReplay() = default;

CallbackReturn OdometerReplay::on_configure() {
  const std::string file = file_.get();
  if (file.empty()) {
    throw std::invalid_argument("parameter 'file' is empty: a CSV file of readings is needed");
  }
  CsvFormat format{.settings = "the parameters"};
  format.set("delimiter", delimiter_.get());
  format.set("decimal_mark", decimal_mark_.get());
  format.set("time_unit", time_unit_.get());
  recording_ = parse_readings_csv(
      read_csv_text(file), file,
      {.odometers = odometers_.get(), .ignored_columns = ignored_columns_.get(), .format = format});
  for (const std::string& note : recording_.notes) {
    logger().info(note);
  }
  settings_ = {.standard_deviations = standard_deviations_.get(),
               .period = from_seconds(period_.get()),
               .use_recorded_stamps = use_recorded_stamps_.get(),
               .frame_id = frame_id_.get()};
  check_settings();
  next_ = 0;
  publisher_ =
      create_publisher(topics::kOdometerReadings, {.events = {.matched = awaited_.on_matched()}});
  awaited_.watch({publisher_.untyped()}, [this] {
    if (phase_ == Phase::kWaiting) {
      wait_or_play();
    }
  });
  logger().info(std::to_string(recording_.size()) + " readings of " +
                std::to_string(recording_.odometers.size()) + " odometers in " + file);
  return CallbackReturn::kSuccess;
}

CallbackReturn OdometerReplay::on_activate() {
  if (next_ == recording_.size()) {
    report();
  } else {
    wait_or_play();
  }
  return CallbackReturn::kSuccess;
}

CallbackReturn OdometerReplay::on_deactivate() {
  phase_ = Phase::kPaused;
  timer_.reset();
  return CallbackReturn::kSuccess;
}

CallbackReturn OdometerReplay::on_cleanup() {
  phase_ = Phase::kPaused;
  timer_.reset();
  awaited_.stop();
  publisher_ = {};
  recording_ = {};
  return CallbackReturn::kSuccess;
}

void OdometerReplay::check_settings() const {
  const std::size_t given = settings_.standard_deviations.size();
  const std::size_t odometers = recording_.odometers.size();
  if (given == 0 && recording_.standard_deviations.empty()) {
    std::string columns;
    for (const std::string& name : recording_.odometers) {
      columns += (columns.empty() ? "" : ", ") + name + ".standard_deviation";
    }
    throw std::invalid_argument(
        "the standard deviations of the odometers are not known: give parameter "
        "'standard_deviations' (inspect.sh: --sigma), " +
        std::to_string(odometers) + " values in m, one for each odometer; or the file columns " +
        columns);
  }
  if (given != 0 && given != odometers) {
    throw std::invalid_argument("parameter 'standard_deviations' has " + std::to_string(given) +
                                " values for " + std::to_string(odometers) + " odometers");
  }
  if (settings_.use_recorded_stamps && recording_.stamps.empty()) {
    throw std::invalid_argument(
        "parameter 'use_recorded_stamps' is true, but the file has no column 'stamp'");
  }
}

void OdometerReplay::wait_or_play() {
  if (awaited_.all_there()) {
    phase_ = Phase::kPlaying;
    due_ = now();
    schedule(Duration(1));
    return;
  }
  phase_ = Phase::kWaiting;
  const std::string text = "waiting for the subscriptions of " + awaited_.missing();
  logger().info(text);
  report_progress(next_, recording_.size(), text);
}

void OdometerReplay::publish_next() {
  const Time time = now();
  follow_clock(time);
  ReadingsRow row = recording_.row(next_);
  auto message = std::make_unique<pipescout_msgs::msg::OdometerReadings>();
  message->header.stamp = to_message(settings_.use_recorded_stamps ? Time(row.stamp) : due_);
  message->header.frame_id = settings_.frame_id;
  message->name = recording_.odometers;
  message->distance = std::move(row.distance);
  message->standard_deviation = settings_.standard_deviations.empty()
                                    ? std::move(row.standard_deviation)
                                    : settings_.standard_deviations;
  message->valid = std::move(row.valid);
  publisher_.publish(std::move(message));
  ++next_;

  report();
  if (next_ == recording_.size()) {
    timer_.reset();
    return;
  }
  due_ += interval_before(next_);
  // One row per turn of the executor, also when the replay is late: those who listen in this
  // process keep up, and no queue overflows.
  schedule(std::max(due_ - time, Duration(1)));
}

/// Keeps the rhythm when a row is late, but not when the clock was set: then the rows go on from
/// the new time, with its stamps.
void OdometerReplay::follow_clock(Time time) {
  if (due_ > time || time - due_ > std::max(interval_before(next_), kMaximumDelay)) {
    due_ = time;
  }
}

void OdometerReplay::schedule(Duration delay) {
  timer_ = create_timer(delay, [this] { publish_next(); });
}

Duration OdometerReplay::interval_before(std::size_t row) const {
  if (row == 0) {
    return Duration::zero();
  }
  const Duration recorded = recording_.stamps.empty()
                                ? settings_.period
                                : recording_.stamps[row] - recording_.stamps[row - 1];
  return std::max(from_seconds(to_seconds(recorded) / rate_.get()), Duration(1));
}

void OdometerReplay::report() {
  const std::size_t total = recording_.size();
  // At most a hundred reports, however many readings.
  if (next_ == total || next_ * 100 / total != (next_ - 1) * 100 / total) {
    report_progress(next_, total);
  }
  if (next_ == total) {
    report_complete("all " + std::to_string(total) + " readings are published");
  }
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::OdometerReplay)
