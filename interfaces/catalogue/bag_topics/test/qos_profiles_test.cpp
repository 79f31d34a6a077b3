// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bag_topics/qos_profiles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

namespace pipescout {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
using namespace std::chrono_literals;

// As rosbag2 of Humble writes it into metadata.yaml.
constexpr const char* kHumble =
    "- history: 3\n  depth: 0\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: "
    "9223372036\n    nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  avoid_ros_namespace_conventions: false";

TEST(QosProfilesTest, AreWrittenAsHumbleDoes) {
  QoS qos = QoS::latched();
  qos.depth = 0;
  EXPECT_EQ(qos_profiles_to_yaml(std::vector{qos}), kHumble);
  EXPECT_EQ(qos_profiles_to_yaml({}), "");
}

TEST(QosProfilesTest, ComeBackAsTheyWere) {
  const std::vector profiles{QoS::reliable(7), QoS::sensor_data(),
                             QoS{.depth = 3,
                                 .durability = Durability::kTransientLocal,
                                 .deadline = 1500ms,
                                 .liveliness = Liveliness::kManualByTopic,
                                 .liveliness_lease = 2s,
                                 .lifespan = 1ns}};
  EXPECT_EQ(qos_profiles_from_yaml(qos_profiles_to_yaml(profiles)), profiles);
}

TEST(QosProfilesTest, NewerVersionsWriteNames) {
  EXPECT_THAT(qos_profiles_from_yaml("- {history: keep_last, depth: 4, reliability: best_effort, "
                                     "durability: transient_local, liveliness: system_default}"),
              ElementsAre(QoS{.depth = 4,
                              .reliability = Reliability::kBestEffort,
                              .durability = Durability::kTransientLocal}));
  EXPECT_THAT(qos_profiles_from_yaml("[]"), IsEmpty());
  EXPECT_THAT(qos_profiles_from_yaml(""), IsEmpty());
  EXPECT_EQ(qos_profiles_from_yaml(kHumble).at(0).depth, QoS{}.depth);
}

std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const QosProfileError& error) {
    return error.what();
  }
  return "";
}

TEST(QosProfilesTest, OthersAreRefusedByPlaceAndField) {
  const auto refused = [](const std::string& text) {
    return refusal([&] { static_cast<void>(qos_profiles_from_yaml(text)); });
  };
  EXPECT_THAT(refused("- {depth: 1,\n   reliability: perhaps}"),
              ::testing::AllOf(StartsWith("2:"), HasSubstr("reliability = 'perhaps'")));
  EXPECT_THAT(refused("- {depth: -1}"), HasSubstr("depth is negative"));
  EXPECT_THAT(refused("- {depth: many}"), HasSubstr("depth is no number"));
  EXPECT_THAT(refused("- {deadline: {sec: -3, nsec: 0}}"), HasSubstr("deadline is negative"));
  EXPECT_THAT(refused("- {deadline: soon}"), HasSubstr("deadline is no map"));
  EXPECT_THAT(refused("{a: 1}"), HasSubstr("sequence"));
  EXPECT_THAT(refused("- 3"), HasSubstr("is a map"));
  EXPECT_NE(refused("- {depth: ["), "");
}

TEST(QosOverridesTest, SayWhatDiffersFromTheDefault) {
  const auto path =
      std::filesystem::path(::testing::TempDir()) / "pipescout_qos_overrides_test.yaml";
  std::ofstream(path) << "/camera:\n  reliability: best_effort\n  depth: 2\n/map:\n  durability: "
                         "transient_local\n";
  const auto overrides = read_qos_overrides(path.string());
  EXPECT_EQ(overrides.size(), 2U);
  EXPECT_EQ(overrides.at("/camera"), QoS::sensor_data(2));
  EXPECT_EQ(overrides.at("/map"), QoS::latched(10));

  std::ofstream(path) << "/camera:\n  reliability: sometimes\n";
  const auto refused = [&] {
    return refusal([&] { static_cast<void>(read_qos_overrides(path.string())); });
  };
  EXPECT_THAT(refused(), StartsWith(path.string() + ":2:16: reliability"));
  std::filesystem::remove(path);
  EXPECT_THAT(refused(), HasSubstr("cannot be read"));
}

TEST(OfferForTest, IsWhatAllRecordedPublishersOffered) {
  EXPECT_EQ(offer_for({}), QoS{});
  EXPECT_EQ(offer_for(std::vector{QoS::latched(1), QoS::latched(30)}), QoS::latched(30));
  EXPECT_EQ(offer_for(std::vector{QoS::sensor_data(5)}), QoS::sensor_data(10));
  EXPECT_EQ(offer_for(std::vector{QoS::sensor_data(5), QoS::reliable(5)}), QoS::reliable(10));
}

}  // namespace
}  // namespace pipescout
