// SPDX-License-Identifier: Apache-2.0
#include "reproduce.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <optional>
#include <set>
#include <sstream>
#include <string>

#include "figure_rows.hpp"
#include "stage_progress.hpp"

namespace pipescout::reproduce {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Reproduce, OdometryGivesThePapersTable) {
  std::ostringstream out;
  const auto result = reproduce_odometry({}, out);
  const std::vector<std::vector<int>> supports{{2, 3},    {1, 2, 3}, {2, 3}, {1, 3}, {2, 3},
                                               {1, 2, 3}, {1, 2, 3}, {1, 2}, {2, 3}, {1, 2, 3}};
  const std::vector<double> equation_13{5.5099, 5.4623, 5.5148, 5.5219, 5.5049,
                                        5.5157, 5.5320, 5.5117, 5.4749, 5.5392};
  ASSERT_EQ(result.rows.size(), 10U);
  for (std::size_t i = 0; i < result.rows.size(); ++i) {
    const auto& row = result.rows[i];
    EXPECT_EQ(row["readings"].size(), 3U);
    EXPECT_EQ(row["support"].get<std::vector<int>>(), supports[i]) << i;
    EXPECT_NEAR(row["fused_paper"].get<double>(), equation_13[i], 5e-5) << i;
    EXPECT_TRUE(row["fused_ml"].is_number());
    EXPECT_TRUE(row["paper"].is_number());
  }
  EXPECT_LE(result.figures["rows_1_to_9_max_abs_error_m"].get<double>(), 0.006);
  EXPECT_NEAR(result.figures["row_10_error_m"].get<double>(), 0.0184, 1e-4);
  EXPECT_TRUE(result.seeds.is_array());
  EXPECT_TRUE(result.seeds.empty());
  EXPECT_THAT(out.str(), HasSubstr("does not follow from the method"));
}

TEST(Reproduce, ListsItsTables) {
  ASSERT_EQ(reproducible_tables().size(), 7U);
  EXPECT_EQ(reproducible_tables()[0].name, "odometry");
  EXPECT_FALSE(reproducible_tables()[0].simulates);
  EXPECT_EQ(reproducible_tables()[1].name, "in-pipe");
  EXPECT_TRUE(reproducible_tables()[1].simulates);
  EXPECT_EQ(reproducible_tables()[2].name, "rack");
  EXPECT_TRUE(reproducible_tables()[2].simulates);
  EXPECT_EQ(reproducible_tables()[4].name, "leaks");
  EXPECT_TRUE(reproducible_tables()[4].simulates);
  EXPECT_EQ(reproducible_tables()[5].name, "tracking");
  EXPECT_TRUE(reproducible_tables()[5].simulates);
  EXPECT_EQ(reproducible_tables()[6].name, "navigation");
  EXPECT_TRUE(reproducible_tables()[6].simulates);
}

TEST(Reproduce, EachRevisionHasSeedsOfItsOwnBeyondThoseOfDevelopment) {
  EXPECT_EQ(seed_base_of("00000000f5"), 1000U);
  EXPECT_EQ(seed_base_of("0000000a"), 11'000U);
  EXPECT_NE(seed_base_of("a711c0b93a03"), seed_base_of("a711c0ba3a03"));
  EXPECT_LE(*seed_base_of("ffffffff-changed"), 1'000'000'000U);
  EXPECT_FALSE(seed_base_of(""));
  EXPECT_FALSE(seed_base_of("a711c0b"));
  EXPECT_FALSE(seed_base_of("release"));
  const std::vector<std::uint64_t> expected{11'000, 11'001, 11'002};
  EXPECT_EQ(seeds_of({.seed_base = 11'000}, 3), expected);
}

TEST(Reproduce, LeaksGiveTheirFigures) {
  std::ostringstream out;
  LeaksExtent extent;
  extent.campaign = {.sequences = 2, .faint_leaks = 1, .other_leaks = 1, .decoys = 1, .length = 40};
  extent.world = {.sequences = 2,
                  .faint_leaks = 1,
                  .near_leaks = 1,
                  .other_leaks = 1,
                  .decoys = 1,
                  .length = 40,
                  .drawn_radiometry = true};
  extent.roc = {.rises = {75}, .netds = {0.1}, .leaks = 1, .decoys = 1};
  const auto result = reproduce_leaks({.seeds = 1}, extent, out);
  for (const char* figure :
       {"fig7_flagged", "fig7_cut_off_degc", "leaks_found_percent", "false_findings",
        "finding_position_p95_m", "finding_coverage95_percent", "world_leaks_found_percent",
        "world_near_found_percent", "world_false_per_km", "world_temperature_coverage95_percent",
        "agc_leaks_found_percent", "agc_false_per_km"}) {
    EXPECT_TRUE(result.figures.contains(figure)) << figure;
  }
  EXPECT_EQ(result.figures["fig7_flagged"].get<double>(), 13);
  EXPECT_EQ(result.figures["leaks_found_percent"].get<double>(), 100);
  EXPECT_EQ(result.seeds.size(), 1U);
  EXPECT_EQ(result.seeds[0], 1001);
  EXPECT_THAT(out.str(), AllOf(HasSubstr("Figure 7"), HasSubstr("2 sequences of 40 m"),
                               HasSubstr("ROC, NETD 100 mK")));
  // What needs real pictures is measured, or said not to be.
  EXPECT_EQ(result.figures.contains("iguana_max_abs_error_k"),
            out.str().find("NOT MEASURED") == std::string::npos);
}

TEST(Reproduce, TrackingGivesItsFigures) {
  std::ostringstream out;
  TrackingExtent extent;
  extent.sequences = 1;
  extent.recording.frames = 60;
  extent.long_sequences = 1;
  extent.long_frames = 80;
  extent.crossings = 5;
  extent.particles = {100, 300};
  extent.arm.length = 100;
  extent.arm.settling = 5;
  extent.inspection = {
      .sequences = 1, .faint_leaks = 0, .other_leaks = 1, .decoys = 0, .length = 24};
  const auto result = reproduce_tracking({.seeds = 1}, extent, out);
  for (const char* figure :
       {"table1_rows_at_or_below_paper", "table1_deviations_at_or_below_paper",
        "paper_filter_rows_at_or_below_paper", "paper_filter_deviations_at_or_below_paper",
        "table1_deviations_not_above_paper", "paper_filter_deviations_not_above_paper",
        "crossing_swaps", "best_position_px", "best_angle_deg", "best_length_px", "in_view_percent",
        "leaks_missed_fixed", "leaks_missed_arm", "tube_seen_percent_fixed",
        "tube_seen_percent_arm"}) {
    EXPECT_TRUE(result.figures.contains(figure)) << figure;
  }
  EXPECT_EQ(result.figures["lost_tracks"].get<double>(), 0);
  EXPECT_THAT(out.str(), AllOf(HasSubstr("best particle, 1000"), HasSubstr("300 particles")));
}

TEST(Reproduce, FliesOverTheRack) {
  std::ostringstream out;
  const RackImageExtent images{.inspection = 0.4,
                               .clutter = 0.4,
                               .clutter_starts = 1,
                               .clutter_start = 0.4,
                               .sparse = 1,
                               .along = 0.2,
                               .plain = 0.5,
                               .before_loss = 0.4,
                               .after_loss = 0.4,
                               .places = 1,
                               .trials = 1,
                               .noise = 0.08,
                               .misplaced = 1,
                               .misplaced_far = 1,
                               .misplaced_places = 1,
                               .figure_8 = 1,
                               .shaped = 1,
                               .shaped_duration = 0.08,
                               .bodies = 0.4,
                               .cameras = 0.4};
  const auto result = reproduce_rack(
      {.seeds = 1},
      RackExtent{
          .every_frame = 30, .first_pose_trials = 10, .images = images, .leaks = {.longest = 1}},
      out);
  for (const char* figure : {"ideal_position_rms_m",
                             "ideal_orientation_rms_deg",
                             "table1_cells_half_of_paper",
                             "table1_cells_above_paper",
                             "table1_worst_ratio_to_bound",
                             "offsets_ideal_frames_to_1mm",
                             "offsets_noise_error_m",
                             "offsets_nees",
                             "outlier30_position_ratio",
                             "features_silent_wrong_pose",
                             "image_tracked_percent",
                             "image_position_median_m",
                             "image_position_p95_m",
                             "image_orientation_median_deg",
                             "image_orientation_p95_deg",
                             "image_along_drift_percent",
                             "image_clutter40_tracked_percent",
                             "image_clutter40_started_percent",
                             "image_clutter40_silent_wrong",
                             "image_plain_10s_covered_percent",
                             "image_recoveries",
                             "image_recoveries_without_odometry",
                             "silent_wrong_pose",
                             "image_6hz_tracked_percent",
                             "noise_grid_tracked_percent",
                             "noise_grid_position_m",
                             "offsets_wrong_silent",
                             "offsets_wrong_converged_percent",
                             "offsets_far_silent",
                             "offsets_far_converged_percent",
                             "fig8_images_offsets_error_m",
                             "fig8_images_offsets_worst_m",
                             "coverage99_percent",
                             "shapes_rays_told_position_median_mm",
                             "shapes_mesh_not_told_coverage99_percent",
                             "row_skew_error_ratio",
                             "fisheye_error_ratio",
                             "rack_leaks_found_percent",
                             "rack_leaks_false",
                             "rack_leaks_position_p95_m"}) {
    EXPECT_TRUE(result.figures.contains(figure)) << figure;
  }
  EXPECT_LE(result.figures["ideal_position_rms_m"].get<double>(), 0.001);
  EXPECT_EQ(result.figures["features_silent_wrong_pose"].get<double>(), 0);
  EXPECT_EQ(result.seeds.size(), 1U);
  EXPECT_THAT(out.str(), HasSubstr("Table I"));
  EXPECT_THAT(out.str(), HasSubstr("On images"));
}

TEST(Reproduce, FliesOverTheRackPartByPart) {
  std::ostringstream out;
  const auto result =
      reproduce_rack({.seeds = 1, .part = "leaks"}, RackExtent{.leaks = {.longest = 1}}, out);
  EXPECT_TRUE(result.figures.contains("rack_leaks_false"));
  EXPECT_FALSE(result.figures.contains("offsets_nees"));
}

TEST(Reproduce, MisplacesPipesWithoutTheFlightsInNoise) {
  std::ostringstream out;
  const RackExtent extent{
      .images = {.misplaced = 1, .misplaced_far = 1, .misplaced_places = 1, .figure_8 = 1}};
  const auto result = reproduce_rack({.part = "offsets"}, extent, out);
  for (const char* figure : {"offsets_wrong_silent", "offsets_far_silent",
                             "fig8_images_offsets_error_m", "coverage99_percent"}) {
    EXPECT_TRUE(result.figures.contains(figure)) << figure;
  }
  EXPECT_FALSE(result.figures.contains("noise_grid_position_m"));
}

TEST(Reproduce, ComparesStatedShapesWithOthers) {
  std::ostringstream out;
  const RackExtent extent{.images = {.shaped = 20, .shaped_duration = 0.08}};
  const auto result = reproduce_rack({.part = "shapes", .trials = 1}, extent, out);
  for (const char* renderer : {"rays", "mesh"}) {
    for (const char* file : {"told", "not_told"}) {
      for (const char* figure : {"position_median_mm", "position_p95_mm", "tracked_percent",
                                 "coverage99_percent", "silent_wrong", "lost"}) {
        const std::string name = std::string("shapes_") + renderer + "_" + file + "_" + figure;
        EXPECT_TRUE(result.figures.contains(name)) << name;
      }
    }
    for (const char* figure : {"found_percent", "values_covered99_percent"}) {
      const std::string name = std::string("shapes_") + renderer + "_told_" + figure;
      EXPECT_TRUE(result.figures.contains(name)) << name;
    }
  }
  EXPECT_EQ(result.figures.size(), 28U);
  EXPECT_THAT(out.str(), AllOf(HasSubstr("by rays"), HasSubstr("by a mesh")));
}

TEST(ReproduceEstimator, GivesAllFigures) {
  std::ostringstream out;
  const auto result = reproduce_estimator(
      {.seeds = 1}, EstimatorExtent{.duration = 80, .outage = 15, .loss_duration = 50}, out);
  for (const char* figure :
       {"ground_robot_position_rmse_m", "ground_robot_orientation_rmse_deg", "uav_position_rmse_m",
        "crawler_position_rmse_m", "crawler_nees", "outage_drift_percent", "outage_rack_drift_m",
        "nees_in_bounds", "outlier_rmse_ratio", "false_reacquisition", "loss_rmse_ratio",
        "loss_coverage95_percent", "loss_refused_beyond_gap_s", "world_rmse_ratio",
        "world_coverage95_percent", "world_lockout_s"}) {
    EXPECT_TRUE(result.figures.contains(figure) && result.figures[figure].is_number()) << figure;
  }
  EXPECT_LT(result.figures["ground_robot_position_rmse_m"].get<double>(), 0.5);
  EXPECT_LT(result.figures["uav_position_rmse_m"].get<double>(), 0.5);
  EXPECT_LT(result.figures["crawler_position_rmse_m"].get<double>(), 1);
  EXPECT_EQ(result.figures["false_reacquisition"].get<double>(), 0);
  EXPECT_EQ(result.seeds.size(), 1U);
}

constexpr InPipeExtent kShort{.run_length = 1000.0,
                              .joints = 200,
                              .double_slips = 4,
                              .detector_length = 200.0,
                              .curve_length = 30.0,
                              .elbows = 10,
                              .bends = 4};

/// Without $PIPESCOUT_SHARED_DATA.
class ReproduceInPipe : public ::testing::Test {
 protected:
  ReproduceInPipe() {
    if (const char* folder = std::getenv(kVariable)) {
      folder_ = folder;
    }
    unsetenv(kVariable);
  }
  ~ReproduceInPipe() override {
    if (folder_) {
      setenv(kVariable, folder_->c_str(), 1);
    }
  }
  ReproduceInPipe(const ReproduceInPipe&) = delete;
  ReproduceInPipe& operator=(const ReproduceInPipe&) = delete;

  static constexpr const char* kVariable = "PIPESCOUT_SHARED_DATA";
  std::optional<std::string> folder_;
};

TEST_F(ReproduceInPipe, GivesAllFiguresAndTheSameOnesEachTime) {
  std::ostringstream out;
  std::ostringstream progress;
  const auto result = reproduce_in_pipe({.seeds = 2, .progress = &progress}, kShort, out);
  const auto figure = [&](const char* name) {
    return result.figures.contains(name) ? result.figures[name].get<double>() : std::nan("");
  };
  EXPECT_LT(figure("paper_worst_error_percent"), 1.0);
  EXPECT_LE(figure("paper_p95_error_percent"), figure("paper_worst_error_percent"));
  EXPECT_GT(figure("lock_joints_median"), 0.0);
  EXPECT_LE(figure("lock_joints_median"), figure("lock_joints_max"));
  EXPECT_LE(figure("lock_joints_max"), 20.0);
  EXPECT_EQ(figure("wrong_joint_after_lock"), 0.0);
  EXPECT_LE(figure("in_joint_p95_m"), 0.05);
  EXPECT_LE(figure("in_joint_worst_m"), 0.15);
  EXPECT_GT(figure("coverage95_percent"), 85.0);
  EXPECT_GT(figure("double_slip_detected_percent"), 60.0);
  EXPECT_LT(figure("elbow_error_p95_m"), 0.1);
  EXPECT_GT(figure("elbow_found_percent"), 70.0);
  EXPECT_GT(figure("elbow_coverage95_percent"), 70.0);
  EXPECT_LE(figure("bends_in_joint_p95_m"), 0.1);
  EXPECT_LE(figure("five_wheels_bends_in_joint_worst_m"), 0.15);
  EXPECT_GT(figure("weld_found_percent"), 95.0);
  EXPECT_LT(figure("weld_false_per_km"), 10.0);
  EXPECT_EQ(result.seeds, (nlohmann::json{1001, 1002}));

  // Six detector studies of the curve and the main one, six of bends, nine others, each with a
  // finished line; and the comparison of those of bends, which runs nothing itself.
  std::set<std::string> studies;
  for (const auto& row : result.rows) {
    studies.insert(row["study"].get<std::string>());
    EXPECT_TRUE(row["value"].is_number());
    if (row.contains("per_seed")) {
      EXPECT_EQ(row["per_seed"].size(), 2U);
      EXPECT_TRUE(row["mean"].is_number());
      EXPECT_TRUE(row["p95"].is_number());
      EXPECT_TRUE(row["worst"].is_number());
    }
  }
  EXPECT_EQ(studies.size(), 23U);
  for (const std::string& study : studies) {
    EXPECT_THAT(out.str(), HasSubstr(study));
    if (study != "Bends, the rules compared") {
      EXPECT_THAT(progress.str(), HasSubstr(study));
    }
  }
  // No real data: said aloud, and no figure is made up.
  EXPECT_THAT(out.str(), HasSubstr("NOT MEASURED"));
  EXPECT_FALSE(result.figures.contains("ili_welds_matched_percent"));

  std::ostringstream again;
  EXPECT_EQ(reproduce_in_pipe({.seeds = 2}, kShort, again).figures, result.figures);
  EXPECT_EQ(again.str(), out.str());
}

TEST_F(ReproduceInPipe, RefusesAFolderWithoutTheRuns) {
  std::ostringstream out;
  constexpr InPipeExtent kLeast{.run_length = 200.0,
                                .joints = 50,
                                .double_slips = 1,
                                .detector_length = 20.0,
                                .curve_length = 20.0,
                                .elbows = 1,
                                .bends = 1};
  EXPECT_THROW(reproduce_in_pipe({.seeds = 1, .data = "no/such/folder"}, kLeast, out),
               std::exception);
}

TEST(FigureRows, PrintsTheWorstInTheSenseOfTheTarget) {
  Reproduction result;
  std::ostringstream out;
  FigureRows rows(result, out);
  rows.add_study("study", {{"low is bad", 2.0, {1.0, 2.0, 3.0}, {.least = 2.0}, "a"},
                           {"high is bad", 2.0, {1.0, 2.0, 3.0}, {.most = 1.0}, "b"},
                           {"far is bad", 2.0, {1.0, 2.0, 2.5}, {.least = 1.0, .most = 3.0}, "c"},
                           {"no figure", 7.0, {}, {}}});
  EXPECT_EQ(result.figures, (nlohmann::json{{"a", 2.0}, {"b", 2.0}, {"c", 2.0}}));
  ASSERT_EQ(result.rows.size(), 4U);
  EXPECT_EQ(result.rows[0]["worst"], 1.0);
  EXPECT_EQ(result.rows[1]["worst"], 3.0);
  EXPECT_EQ(result.rows[1]["mean"], 2.0);
  EXPECT_EQ(result.rows[2]["worst"], 1.0);
  EXPECT_FALSE(result.rows[3].contains("worst"));
  EXPECT_THAT(out.str(), AllOf(HasSubstr("at least 2"), HasSubstr("NOT MET"), HasSubstr("1 to 3")));
}

TEST(StageProgress, RewritesItsLineOnATerminalOnly) {
  for (const bool on_terminal : {false, true}) {
    std::ostringstream out;
    StageProgress progress({.progress = &out, .progress_on_terminal = on_terminal});
    progress.begin("stage", 2);
    progress.step();
    progress.step();
    progress.end();
    EXPECT_THAT(out.str(), HasSubstr("stage"));
    EXPECT_EQ(out.str().find("\rstage: 2 of 2") != std::string::npos, on_terminal);
    EXPECT_EQ(out.str().find('\r') != std::string::npos, on_terminal);
    EXPECT_EQ(out.str().back(), '\n');
  }
}

}  // namespace
}  // namespace pipescout::reproduce
