// SPDX-License-Identifier: Apache-2.0
#include "pipescout/plant_simulation/plant_simulation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/map_files/route_graph_file.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::action::InspectTour;
using testing::ComponentHarness;

TEST(PlantSimulation, PublishesItsSensorsAndAsksForATour) {
  ComponentHarness harness;
  testing::TemporaryFolder folder;
  const auto scans = harness.collect(topics::kScan);
  const auto poses = harness.collect(topics::kOdometryFiltered);
  const auto truth = harness.collect(topics::kTrueOdometry);
  const auto tracks = harness.collect(topics::kPipeTrack);
  std::optional<std::vector<std::int64_t>> asked;
  const auto server = harness.peer().create_action_server<InspectTour>(
      "inspect_tour", {.accepted = [&](const ServerGoal<InspectTour>& goal) {
        asked = goal.goal().rows;
        goal.succeed();
      }});
  auto& simulation = harness.make<PlantSimulation>(
      {.name = "plant",
       .parameters = {{"rate", 1000.0},
                      {"rows", 3},
                      {"operator.rows", std::vector<std::int64_t>{1, 0}},
                      {"map_folder", folder.path().string()}}});
  ASSERT_TRUE(harness.bring_up(simulation).success);
  ASSERT_TRUE(harness.spin_until([&] { return asked.has_value(); }));
  EXPECT_EQ(*asked, (std::vector<std::int64_t>{1, 0}));
  ASSERT_GT(poses.size(), 10U);
  EXPECT_EQ(truth.size(), poses.size());
  EXPECT_EQ(scans.back().ranges.size(), 360U);
  EXPECT_EQ(tracks.back().state, pipescout_msgs::msg::PipeTrack::STATE_LOST);
  EXPECT_GT(poses.back().pose.covariance[35], 0);
  const auto graph = read_route_graph(folder.path() / "plant.geojson");
  EXPECT_EQ(graph.nodes().size(), 8U);
  const auto grid = read_grid(folder.path() / "plant.yaml");
  EXPECT_EQ(grid.at(grid.cell_at({20, 0}).value()), navigation::CellState::kOccupied);
}

TEST(PlantSimulation, WrongParametersAreNamed) {
  ComponentHarness harness;
  for (const auto& [parameter, text] : std::vector<std::pair<NamedParameter, std::string>>{
           {{"obstacles", std::vector<double>{1, 2, 3}}, "parameter 'obstacles'"},
           {{"start", std::vector<double>{1}}, "parameter 'start'"},
           {{"start", std::vector<double>{10, 0, 0}}, "is in an obstacle"}}) {
    auto& simulation = harness.make<PlantSimulation>({.name = "plant", .parameters = {parameter}});
    const auto result = harness.configure(simulation);
    EXPECT_FALSE(result.success);
    EXPECT_THAT(result.message, ::testing::HasSubstr(text));
    harness.destroy(simulation);
  }
}

}  // namespace
}  // namespace pipescout
