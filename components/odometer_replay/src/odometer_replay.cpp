// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometer_replay/odometer_replay.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include "pipescout/interfaces/conversions.hpp"
#include "pipescout/interfaces/register_component.hpp"
#include "pipescout/interfaces/topics.hpp"
#include "pipescout/odometer_replay/csv_file.hpp"

namespace pipescout {

namespace {

std::uint32_t mission_count(std::size_t count) {
  return static_cast<std::uint32_t>(
      std::min<std::size_t>(count, std::numeric_limits<std::uint32_t>::max()));
}

}  // namespace

OdometerReplay::OdometerReplay(ComponentOptions options) : Component(std::move(options)) {
  file_ = parameters().declare<std::string>(
      "file", "", {.description = "CSV file of readings, see docs/components/odometer_replay.md"});
  odometers_ = parameters().declare<std::vector<std::string>>(
      "odometers", {},
      {.description =
           "columns to publish, in this order; empty: every column that is an odometer"});
  ignored_columns_ = parameters().declare<std::vector<std::string>>(
      "ignored_columns", {}, {.description = "columns that are no odometers; they need not exist"});
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
      {.description = "speed of the replay, as a multiple of that of the recording; may be changed "
                      "while it plays",
       .floating_point_range = FloatingPointRange{1e-3, 1e3}});
  use_recorded_stamps_ = parameters().declare<bool>(
      "use_recorded_stamps", false,
      {.description = "publish the stamps of the file; false: the time at which each reading is "
                      "due in the replay"});
  wait_for_subscribers_ = parameters().declare<int>(
      "wait_for_subscribers", 1,
      {.description = "nothing is published before so many subscriptions of odometer/readings are "
                      "matched",
       .integer_range = IntegerRange{0, 1000}});
  frame_id_ = parameters().declare<std::string>("frame_id", "base_link",
                                                {.description = "base frame of the robot"});
}

OdometerReplay::~OdometerReplay() {
  close();
}

CallbackReturn OdometerReplay::on_configure() {
  const std::string file = file_.get();
  if (file.empty()) {
    throw std::invalid_argument("parameter 'file' is empty: a CSV file of readings is needed");
  }
  recording_ = parse_readings_csv(
      read_csv_text(file), file,
      {.odometers = odometers_.get(), .ignored_columns = ignored_columns_.get()});
  choose_standard_deviations();
  choose_stamps();
  next_ = 0;
  publisher_ =
      create_publisher(topics::kOdometerReadings, {.matched = [this](std::size_t subscriptions) {
                         if (phase_ == Phase::kWaiting) {
                           wait_or_play(subscriptions);
                         }
                       }});
  logger().info(std::to_string(recording_.rows.size()) + " readings of " +
                std::to_string(recording_.odometers.size()) + " odometers in " + file);
  return CallbackReturn::kSuccess;
}

CallbackReturn OdometerReplay::on_activate() {
  if (next_ == recording_.rows.size()) {
    report();
  } else {
    wait_or_play(publisher_.subscription_count());
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
  publisher_ = {};
  recording_ = {};
  return CallbackReturn::kSuccess;
}

/// Every row gets the standard deviations that are published with it.
void OdometerReplay::choose_standard_deviations() {
  const std::vector<double> given = standard_deviations_.get();
  const std::size_t odometers = recording_.odometers.size();
  if (given.empty() && !recording_.has_standard_deviations) {
    throw std::invalid_argument(
        "no standard deviations: parameter 'standard_deviations' is empty and the file has no "
        "columns NAME.standard_deviation");
  }
  if (given.empty()) {
    return;
  }
  if (given.size() != odometers) {
    throw std::invalid_argument("parameter 'standard_deviations' has " +
                                std::to_string(given.size()) + " values for " +
                                std::to_string(odometers) + " odometers");
  }
  for (ReadingsRow& row : recording_.rows) {
    row.standard_deviation = given;
  }
}

/// Every row gets a stamp, if only for its distance in time from the others.
void OdometerReplay::choose_stamps() {
  if (recording_.has_stamps) {
    return;
  }
  if (use_recorded_stamps_.get()) {
    throw std::invalid_argument(
        "parameter 'use_recorded_stamps' is true, but the file has no column 'stamp'");
  }
  const Duration period = from_seconds(period_.get());
  Duration stamp{};
  for (ReadingsRow& row : recording_.rows) {
    row.stamp = stamp;
    stamp += period;
  }
}

void OdometerReplay::wait_or_play(std::size_t subscriptions) {
  const auto wanted = static_cast<std::size_t>(wait_for_subscribers_.get());
  if (subscriptions >= wanted) {
    phase_ = Phase::kPlaying;
    due_ = now();
    schedule(Duration(1));
    return;
  }
  phase_ = Phase::kWaiting;
  const std::string text = "waiting for " + std::to_string(wanted) +
                           " subscriptions of odometer/readings, there are " +
                           std::to_string(subscriptions);
  logger().info(text);
  report_progress(mission_count(next_), mission_count(recording_.rows.size()), text);
}

void OdometerReplay::publish_next() {
  const ReadingsRow& row = recording_.rows[next_];
  auto message = std::make_unique<pipescout_msgs::msg::OdometerReadings>();
  message->header().stamp(to_message(use_recorded_stamps_.get() ? Time(row.stamp) : due_));
  message->header().frame_id(frame_id_.get());
  message->name(recording_.odometers);
  message->distance(row.distance);
  message->standard_deviation(row.standard_deviation);
  message->valid(row.valid);
  publisher_.publish(std::move(message));
  ++next_;

  report();
  if (next_ == recording_.rows.size()) {
    timer_.reset();
    return;
  }
  const Duration interval = interval_before(next_);
  const Time time = now();
  due_ += interval;
  if (due_ - time > interval) {
    // The clock was set back.
    due_ = time + interval;
  }
  // One row per turn of the executor, also when the replay is late: those who listen in this
  // process keep up, and no queue overflows.
  schedule(std::max(due_ - time, Duration(1)));
}

void OdometerReplay::schedule(Duration delay) {
  timer_ = create_timer(delay, [this] { publish_next(); });
}

Duration OdometerReplay::interval_before(std::size_t row) const {
  const Duration recorded = recording_.rows[row].stamp - recording_.rows[row - 1].stamp;
  return std::max(from_seconds(to_seconds(recorded) / rate_.get()), Duration(1));
}

void OdometerReplay::report() {
  const std::size_t total = recording_.rows.size();
  // At most a hundred reports, however many readings.
  if (next_ == total || next_ * 100 / total != (next_ - 1) * 100 / total) {
    report_progress(mission_count(next_), mission_count(total));
  }
  if (next_ == total) {
    report_complete("all " + std::to_string(total) + " readings are published");
  }
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::OdometerReplay)
