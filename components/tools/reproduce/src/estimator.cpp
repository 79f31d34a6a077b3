// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "each_seed.hpp"
#include "estimator_losses.hpp"
#include "estimator_robots.hpp"
#include "estimator_worlds.hpp"
#include "figure_rows.hpp"
#include "pipescout/batch_estimation/batch_smoother.hpp"
#include "pipescout/csv/csv_file.hpp"
#include "pipescout/estimation_study/car_recording.hpp"
#include "pipescout/estimation_study/fusion_stream.hpp"
#include "pipescout/estimation_study/husky_recording.hpp"
#include "pipescout/estimation_study/late_rack.hpp"
#include "pipescout/estimation_study/lawnmower_recording.hpp"
#include "pipescout/estimation_study/long_drive.hpp"
#include "pipescout/estimation_study/run_score.hpp"
#include "reproduce.hpp"
#include "seed_values.hpp"
#include "stage_progress.hpp"

namespace pipescout::reproduce {
namespace {

using estimation_study::CarOutage;
using estimation_study::CarRecording;
using estimation_study::RunOptions;
using estimation_study::RunScore;
using estimation_study::Sensor;
using estimation_study::Vehicle;

constexpr double kDegrees = 180.0 / std::numbers::pi;

/// Of the times, that the mean over the seeds must be within its 95 % bounds.
constexpr double kLeastShareInBounds = 0.9;

std::vector<double> position_errors(const std::vector<RunScore>& runs) {
  return each(runs, [](const RunScore& run) { return run.position_rmse(); });
}

class Estimator {
 public:
  Estimator(const ReproduceOptions& options, const EstimatorExtent& extent, std::ostream& out)
      : options_(options),
        extent_(extent),
        out_(out),
        seeds_(seeds_of(options, options.seeds)),
        rows_(result_, out),
        progress_(options) {}

  Reproduction run() {
    out_ << "The state estimator. Seeds " << seeds_.front() << " to " << seeds_.back()
         << ", not used for tuning.\n\n";
    result_.seeds = seeds_;
    bool consistent = true;
    double worst_ratio = 0;
    double captured = 0;
    for (const Robot& robot : robots()) {
      const std::vector<RunScore> clean = drive(robot, "all sensors", {});
      consistent = add_clean(robot, clean) && consistent;
      if (robot.vehicle != Vehicle::kCrawler) {
        add_outage(robot);
        captured += add_trap(robot);
      }
      worst_ratio = std::max(worst_ratio, add_outliers(robot, pooled(position_errors(clean))));
    }
    rows_.add_study(
        "All robots together",
        {{"NEES and NIS within their 95 % bounds in " +
              std::to_string(std::lround(100 * kLeastShareInBounds)) + " % of the time, 1: yes",
          consistent ? 1.0 : 0.0,
          {},
          {.least = 1, .most = 1},
          "nees_in_bounds"},
         {"outliers: largest ratio of the error to the clean run",
          worst_ratio,
          {},
          {.most = 1.2},
          "outlier_rmse_ratio"},
         {"false re-acquisitions", captured, {}, {.least = 0, .most = 0}, "false_reacquisition"}});
    reproduce_losses(options_, extent_, rows_, progress_);
    reproduce_worlds(options_, extent_, rows_, progress_);
    add_late_rack();
    add_long_drive();
    add_stream();
    add_car();
    add_lawnmowers();
    add_husky();
    return std::move(result_);
  }

 private:
  [[nodiscard]] RunOptions options() const {
    RunOptions options;
    options.duration = extent_.duration;
    return options;
  }
  /// The last third of a run: the UAV is over its rack by then.
  [[nodiscard]] double outage_begin() const { return extent_.duration - extent_.outage; }

  std::vector<RunScore> drive(const Robot& robot, const std::string& what,
                              const std::function<void(RunOptions&)>& change) {
    RunOptions used = options();
    if (change) {
      change(used);
    }
    return for_each_seed(
        progress_, std::string(robot.article) + ": " + what, seeds_, [&](std::uint64_t seed) {
          const auto run = estimation_study::vehicle_run(robot.vehicle, used, seed);
          return estimation_study::score_run(run, used,
                                             estimation_study::estimator_parameters(run, used));
        });
  }

  /// Whether NEES and NIS are in their bounds.
  bool add_clean(const Robot& robot, const std::vector<RunScore>& runs) {
    const auto position = position_errors(runs);
    const auto rotation =
        each(runs, [](const RunScore& run) { return kDegrees * run.rotation_rmse(); });
    const auto velocity = each(runs, [](const RunScore& run) { return run.velocity_rmse(); });
    const auto started = each(runs, [](const RunScore& run) { return run.started; });
    const std::string prefix(robot.name);
    std::vector<Measure> measures{
        {"position, root mean square, m", pooled(position), position, kSmallIsGood,
         prefix + "_position_rmse_m"},
        {"orientation, root mean square, deg", pooled(rotation), rotation, kSmallIsGood,
         prefix + "_orientation_rmse_deg"},
        {"velocity, root mean square, m/s", pooled(velocity), velocity, kSmallIsGood,
         prefix + "_velocity_rmse_mps"},
        {"first state in the map after, s", mean(started), started, kSmallIsGood}};
    const auto consistency = estimation_study::consistency(runs);
    for (Measure& measure : std::vector<Measure>{
             {"NEES, mean (expected 9)", consistency.nees, {}, {}, prefix + "_nees"},
             {"NIS, mean (expected 3)", consistency.nis, {}, {}, prefix + "_nis"},
             {"share of the time with the mean NEES in its 95 % bounds",
              consistency.nees_share,
              {},
              {.least = kLeastShareInBounds}},
             {"share of the time with it below: conservative",
              consistency.nees_below,
              {},
              kSmallIsGood},
             {"share of the time with the mean NIS in its 95 % bounds",
              consistency.nis_share,
              {},
              {.least = kLeastShareInBounds}}}) {
      measures.push_back(std::move(measure));
    }
    rows_.add_study(robot.article, measures);
    return consistency.nees_share >= kLeastShareInBounds &&
           consistency.nis_share >= kLeastShareInBounds;
  }

  void add_outage(const Robot& robot) {
    const std::string what = "no GPS for " + std::to_string(std::lround(extent_.outage)) + " s";
    const auto runs = drive(robot, what, [&](RunOptions& options) {
      options.silences = {
          {.sensor = Sensor::kGps, .begin = outage_begin(), .duration = extent_.outage}};
    });
    const auto drift = each(runs, [](const RunScore& run) { return run.silences[0].drift; });
    const auto percent = each(runs, [](const RunScore& run) {
      return 100 * run.silences[0].drift / run.silences[0].way;
    });
    const std::string study = std::string(robot.article) + ": " + what;
    if (robot.vehicle == Vehicle::kGroundRobot) {
      rows_.add_study(study, {{"drift, % of the distance, mean",
                               mean(percent),
                               percent,
                               {.most = 0.3},
                               "outage_drift_percent"},
                              {"drift, m", mean(drift), drift, kSmallIsGood}});
    } else {
      rows_.add_study(
          study, {{"drift, m, mean", mean(drift), drift, {.most = 0.05}, "outage_rack_drift_m"}});
    }
  }

  /// How many of the traps have captured it.
  double add_trap(const Robot& robot) {
    double captured = 0;
    for (const bool moves_along : {false, true}) {
      const std::string what = std::string("after an outage, fixes 700 m away that ") +
                               (moves_along ? "move along" : "stand still");
      const auto runs = drive(robot, what, [&](RunOptions& options) {
        const double begin = options.duration / 3;
        options.silences = {{.sensor = Sensor::kGps, .begin = begin, .duration = 20}};
        options.traps = {{.begin = begin + 20,
                          .duration = options.duration - begin - 20,
                          .offset = {700, 0, 0},
                          .moves_along = moves_along}};
      });
      const auto traps = each(runs, [](const RunScore& run) { return run.false_reacquisitions; });
      const auto worst =
          each(runs, [](const RunScore& run) { return run.largest_position_error(); });
      double sum = 0;
      for (const double trapped : traps) {
        sum += trapped;
      }
      rows_.add_study(std::string(robot.article) + ": " + what,
                      {{"captured", sum, traps, {.least = 0, .most = 0}},
                       {"largest error, m", mean(worst), worst, kSmallIsGood}});
      captured += sum;
    }
    return captured;
  }

  /// The largest ratio of all sensors.
  double add_outliers(const Robot& robot, double clean) {
    double largest = 0;
    std::vector<Measure> measures;
    for (const Sensor sensor : robot.sensors) {
      const auto runs = drive(robot, std::string("20 % outliers, ") + name_of(sensor),
                              [&](RunOptions& options) { options.outliers = sensor; });
      std::vector<double> position = position_errors(runs);
      for (double& value : position) {
        // A run without any state is no good one.
        value = std::isfinite(value) ? value : std::numeric_limits<double>::infinity();
      }
      const double ratio = pooled(position) / clean;
      measures.push_back({std::string("outliers in ") + name_of(sensor) +
                              ": ratio of the position error to the clean run",
                          ratio,
                          {},
                          {.most = 1.2}});
      measures.push_back(
          {std::string("outliers in ") + name_of(sensor) + ": position, root mean square, m",
           pooled(position), position, kSmallIsGood});
      largest = std::max(largest, ratio);
    }
    rows_.add_study(std::string(robot.article) + ": 20 % gross outliers in one sensor", measures);
    return largest;
  }

  /// The contents of files of a data set; nothing, said aloud, where it is not.
  std::optional<std::vector<std::string>> texts(const std::string& study,
                                                const std::string& data_set,
                                                const std::vector<std::string>& files) {
    const std::filesystem::path folder =
        std::filesystem::path(options_.data.empty() ? default_data_folder() : options_.data) /
        data_set;
    if (options_.data.empty() && !exists(folder / files.front())) {
      out_ << study << "\n\n  NOT MEASURED, its figures are left out: there is no " << data_set
           << "/" << files.front()
           << "\n  in the folder of --data, $PIPESCOUT_SHARED_DATA or ../shared/data.\n\n";
      return std::nullopt;
    }
    std::vector<std::string> result;
    for (const std::string& file : files) {
      result.push_back(read_csv_text((folder / file).string()));
    }
    return result;
  }

  void add_late_rack() {
    struct LateRackScores {
      estimation_study::LateRackScore online;
      double batch_nees = 0;
    };
    const auto scores =
        for_each_seed(progress_, "a rack that is seen late", seeds_, [](std::uint64_t seed) {
          const auto flight = estimation_study::fly_to_late_rack({}, seed);
          estimation::BatchSmoother batch(
              estimation::BatchSmootherParameters::like(flight.parameters),
              {.times = flight.times,
               .first = flight.first,
               .first_covariance = flight.first_covariance,
               .imu = flight.imu,
               .measurements = flight.measurements()});
          batch.solve();
          return LateRackScores{estimation_study::score_late_rack(flight),
                                estimation_study::rack_nees(batch.globals(), flight.truth,
                                                            batch.global_covariance())};
        });
    std::vector<double> online;
    std::vector<double> batch;
    std::vector<double> accepted;
    for (const LateRackScores& score : scores) {
      online.push_back(score.online.nees);
      batch.push_back(score.batch_nees);
      accepted.push_back(score.online.accepted_share);
    }
    rows_.add_study(
        "A rack that is seen after 25 s, with a prior of 2 m and 0.5 rad, against the batch",
        {{"NEES of its pose, on line / batch",
          mean(online) / mean(batch),
          {},
          at_most(1.2),
          "rack_seen_late_nees_ratio"},
         {"NEES on line, mean (expected 6)", mean(online), online, kSmallIsGood},
         {"NEES of the batch, mean (expected 6)", mean(batch), batch, kSmallIsGood},
         {"visual poses accepted, share", mean(accepted), accepted, kLargeIsGood}});
  }

  void add_long_drive() {
    constexpr double kMilliradians = 1e3;
    const auto on_earth = estimation_study::score_long_drive({});
    const auto flat = estimation_study::score_long_drive({.earth = false});
    rows_.add_study("A drive of 50 km over the ellipsoid, sensors without errors",
                    {{"heading, root mean square over the last 5 km, mrad",
                      kMilliradians * on_earth.heading,
                      {},
                      at_most(0.2),
                      "earth_50km_heading_mrad"},
                     {"tilt, mrad", kMilliradians * on_earth.tilt, {}, kSmallIsGood},
                     {"the same on a flat Earth at rest: heading, mrad",
                      kMilliradians * flat.heading,
                      {},
                      kSmallIsGood},
                     {"tilt, mrad", kMilliradians * flat.tilt, {}, kSmallIsGood}});
  }

  void add_stream() {
    const std::string study = "fusion_stream, with GTSAM as reference, lag 2 s";
    const auto files = texts(study, "fusion_stream", {"stream.csv"});
    if (!files) {
      return;
    }
    const auto stream = estimation_study::parse_fusion_stream(files->front());
    const auto score = [&](const estimation_study::StreamSensors& use) {
      estimation::FixedLagSmoother smoother(estimation_study::fusion_stream_parameters());
      return estimation_study::run_fusion_stream(stream, use, smoother);
    };
    const auto all = score({});
    rows_.add_study(study, {{"all sensors: position, root mean square, m",
                             all.position,
                             {},
                             {.most = 0.0142},
                             "stream_position_rmse_m"},
                            {"all sensors: orientation, root mean square, deg",
                             kDegrees * all.rotation,
                             {},
                             {.most = 0.096},
                             "stream_orientation_rmse_deg"},
                            {"all sensors: NEES, mean (expected 15)", all.nees, {}, kSmallIsGood},
                            {"no vision: position, root mean square, m",
                             score({.vision = false}).position,
                             {},
                             {.most = 0.0328},
                             "stream_no_vision_position_rmse_m"},
                            {"IMU and vision: position, root mean square, m",
                             score({.gps = false, .odometry = false}).position,
                             {},
                             {.most = 0.0335},
                             "stream_imu_vision_position_rmse_m"}});
  }

  void add_car() {
    constexpr double kFirst = 15;  // s after its beginning
    constexpr double kEvery = 5;   // s
    constexpr double kEnd = 59;    // s
    const std::string study = "A real car (comma2k19): wheel speeds, IMU, GPS";
    const auto files = texts(study, "car_comma2k19",
                             {"accelerometer.csv", "gyro.csv", "wheel_speed.csv",
                              "gnss_ublox_live.csv", "reference_pose_20hz.csv"});
    if (!files) {
      return;
    }
    const CarRecording car = estimation_study::read_car({.accelerometer = (*files)[0],
                                                         .gyro = (*files)[1],
                                                         .wheel_speed = (*files)[2],
                                                         .gnss = (*files)[3],
                                                         .reference = (*files)[4]});
    const auto score = estimation_study::score_car(car);
    std::vector<Measure> measures{
        {"first state in the map after, s", score.started, {}, kSmallIsGood},
        {"horizontal position error, root mean square, m",
         score.position,
         {},
         kSmallIsGood,
         "car_position_rmse_m"},
        {"speed, root mean square, m/s", score.speed, {}, kSmallIsGood, "car_speed_rmse_mps"},
        {"course, root mean square, deg",
         kDegrees * score.course,
         {},
         kSmallIsGood,
         "car_course_rmse_deg"}};
    for (const double duration : {10.0, 20.0, 40.0}) {
      std::vector<double> ours;
      std::vector<double> dead_reckoned;
      for (double begin = kFirst; begin + duration <= kEnd; begin += kEvery) {
        const CarOutage outage =
            estimation_study::score_car_outage(car, car.events.front().arrival + begin, duration);
        ours.push_back(outage.error);
        dead_reckoned.push_back(outage.dead_reckoned);
      }
      const std::string seconds = std::to_string(std::lround(duration));
      const std::string without =
          "without GPS for " + seconds + " s, " + std::to_string(ours.size()) + " times: ";
      measures.push_back({without + "error at the end, mean, m",
                          mean(ours),
                          {},
                          kSmallIsGood,
                          "car_outage_" + seconds + "s_m"});
      measures.push_back({without + "wheels and gyro alone, m",
                          mean(dead_reckoned),
                          {},
                          kSmallIsGood,
                          "car_dead_reckoning_" + seconds + "s_m"});
      measures.push_back({without + "ratio",
                          mean(ours) / mean(dead_reckoned),
                          {},
                          duration == 20.0 ? Target{.most = 0.5} : kSmallIsGood,
                          "car_outage_" + seconds + "s_ratio"});
    }
    rows_.add_study(study, measures);
  }

  void add_lawnmowers() {
    using estimation_study::ReferenceHeading;
    // Plaza1: as good as its gyro, whose steps need but be summed up.
    add_lawnmower("1", ReferenceHeading::kForwards, at_most(1.94));
    add_lawnmower("2", ReferenceHeading::kBackwards, at_most(6.3));
  }

  void add_lawnmower(const std::string& number, estimation_study::ReferenceHeading heading,
                     const Target& target) {
    const std::string name = "Plaza" + number;
    const std::string figure = "plaza" + number + "_";
    const std::string study = "A real lawnmower (" + name + ") by dead reckoning";
    const std::string steps = name + "_DR.txt";
    const std::string reference = name + "_GT.csv";
    const auto files = texts(study, "lawnmower_plaza" + number, {steps, reference});
    if (!files) {
      return;
    }
    const auto score = estimation_study::score_lawnmower((*files)[0], (*files)[1], heading);
    rows_.add_study(
        study,
        {{"way, m", score.way, {}, kLargeIsGood},
         {"position, root mean square, m", score.estimator.rms, {}, target, figure + "rms_m"},
         {"position, largest, m", score.estimator.largest, {}, kSmallIsGood},
         {"position error at the end, % of the distance",
          100 * score.estimator.end / score.way,
          {},
          kSmallIsGood,
          figure + "end_percent"},
         {"reference within the 95 % ellipse, share of the time",
          score.covered_share,
          {},
          kLargeIsGood},
         {"sum of the steps alone: root mean square, m", score.summed.rms, {}, kSmallIsGood},
         {"sum of the steps alone: largest, m", score.summed.largest, {}, kSmallIsGood},
         {"mean turn at the first standstill, mrad/s", 1e3 * score.standing_rate, {}, kSmallIsGood},
         {"sum of the steps less it: root mean square, m",
          score.less_standing.rms,
          {},
          kSmallIsGood,
          figure + "standing_bias_rms_m"},
         {"constant bias that fits the reference best, mrad/s",
          1e3 * score.best_rate,
          {},
          kSmallIsGood},
         {"sum of the steps less that: root mean square, m",
          score.less_best.rms,
          {},
          kSmallIsGood}});
  }

  void add_husky() {
    // Of a plain filter with five states (place, heading, speed, gyro bias).
    constexpr double kFilterRms = 1.65;
    constexpr double kFilterLargest = 5.2;
    constexpr std::array kOutages{std::pair(10.0, 2.0), std::pair(20.0, 3.5), std::pair(40.0, 8.1)};
    constexpr double kFirst = 60;
    constexpr double kEvery = 20;
    const std::string study = "A real ground robot (Husky), off its GPS";
    const auto files =
        texts(study, "husky_outdoor", {"husky_imu.csv", "husky_odom.csv", "husky_fix.csv"});
    if (!files) {
      return;
    }
    const estimation_study::HuskyRecording husky =
        estimation_study::read_husky({.imu = (*files)[0], .odom = (*files)[1], .fix = (*files)[2]});
    const estimation_study::HuskyScore score = estimation_study::score_husky(husky);
    std::vector<Measure> measures{
        {"root mean square, m", score.rms, {}, at_most(kFilterRms), "husky_rms_m"},
        {"largest, m", score.largest, {}, at_most(kFilterLargest), "husky_max_m"},
        {"in the map after, s", score.started, {}, kSmallIsGood},
        {"fixes held out or gated since then",
         static_cast<double>(score.held_out),
         {},
         kSmallIsGood,
         "husky_held_out"}};
    for (const auto& [duration, filter] : kOutages) {
      std::vector<double> errors;
      for (double begin = kFirst; begin + duration <= husky.end; begin += kEvery) {
        if (const auto error = estimation_study::score_husky_outage(husky, begin, duration)) {
          errors.push_back(*error);
        }
      }
      const std::string seconds = std::to_string(std::lround(duration));
      measures.push_back({"without GPS for " + seconds + " s, " + std::to_string(errors.size()) +
                              " times: at the end, mean, m",
                          mean(errors),
                          {},
                          at_most(filter),
                          "husky_outage_" + seconds + "s_m"});
    }
    rows_.add_study(study, measures);
  }

  const ReproduceOptions& options_;
  const EstimatorExtent& extent_;
  std::ostream& out_;
  std::vector<std::uint64_t> seeds_;
  Reproduction result_;
  FigureRows rows_;
  StageProgress progress_;
};

}  // namespace

Reproduction reproduce_estimator(const ReproduceOptions& options, std::ostream& out) {
  return reproduce_estimator(options, EstimatorExtent{}, out);
}

Reproduction reproduce_estimator(const ReproduceOptions& options, const EstimatorExtent& extent,
                                 std::ostream& out) {
  return Estimator(options, extent, out).run();
}

}  // namespace pipescout::reproduce
