// SPDX-License-Identifier: Apache-2.0
#include "doctor/checks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace pipescout::host::doctor {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr std::uintmax_t kMegabyte = std::uintmax_t{1} << 20U;

auto error(const std::string& text) {
  return AllOf(Field(&Finding::severity, Severity::kError), Field(&Finding::what, HasSubstr(text)),
               Field(&Finding::advice, Not(IsEmpty())));
}
auto warning(const std::string& text) {
  return AllOf(Field(&Finding::severity, Severity::kWarning),
               Field(&Finding::what, HasSubstr(text)), Field(&Finding::advice, Not(IsEmpty())));
}

GraphEndpoint endpoint(const std::string& node, bool publisher, const std::string& topic,
                       const QoS& qos = QoS::reliable(),
                       const std::string& type = "sensor_msgs::msg::dds_::Imu_") {
  GraphEndpoint result;
  result.is_publisher = publisher;
  result.wire_topic = mangle_topic_name(topic, DdsTopicKind::kTopic);
  result.wire_type = type;
  result.qos = qos;
  result.node = NodeName::parse(node);
  return result;
}

Observation graph(std::vector<GraphEndpoint> endpoints) {
  Observation seen;
  for (const auto& each : endpoints) {
    if (each.node) {
      seen.nodes.push_back(*each.node);
    }
  }
  std::sort(seen.nodes.begin(), seen.nodes.end());
  seen.nodes.erase(std::unique(seen.nodes.begin(), seen.nodes.end()), seen.nodes.end());
  seen.endpoints = std::move(endpoints);
  return seen;
}

TEST(DoctorQualityOfService, NamesBothNodesOfAPairThatCannotMeet) {
  EXPECT_THAT(check_quality_of_service(
                  graph({endpoint("/driver", true, "/imu/data", QoS::sensor_data()),
                         endpoint("/estimator", false, "/imu/data", QoS::reliable())})),
              ElementsAre(AllOf(error("/estimator gets nothing from /driver on /imu/data"),
                                Field(&Finding::advice, HasSubstr("best effort")))));
  EXPECT_THAT(check_quality_of_service(
                  graph({endpoint("/driver", true, "/imu/data", QoS::reliable()),
                         endpoint("/estimator", false, "/imu/data", QoS::sensor_data())})),
              IsEmpty());
}

TEST(DoctorTypes, NamesATopicOfTwoTypes) {
  EXPECT_THAT(
      check_types(graph({endpoint("/a", true, "/x"), endpoint("/b", false, "/x", QoS::reliable(),
                                                              "std_msgs::msg::dds_::String_")})),
      ElementsAre(error("/x is used with several types: sensor_msgs/msg/Imu, "
                        "std_msgs/msg/String")));
}

TEST(DoctorInputs, FindsNothingMissingWhereTheGraphIsNotKnownWhole) {
  auto seen = graph({endpoint("/estimator", false, "/imu/data")});
  EXPECT_THAT(check_inputs(seen), ElementsAre(warning("Nobody publishes /imu/data")));
  seen.undiscovered = {"process 7 (driver) has not answered"};
  EXPECT_THAT(check_inputs(seen), IsEmpty());
  EXPECT_THAT(check_discovery(seen), ElementsAre(warning("process 7 (driver) has not answered")));
}

TEST(DoctorLocalhostOnly, NamesWhoHasItAndWhoHasNot) {
  Observation seen;
  seen.nodes_on_loopback_alone = {NodeName::parse("/talker")};
  EXPECT_THAT(check_localhost_only(seen), IsEmpty());
  seen.nodes_beyond_loopback = {NodeName::parse("/listener")};
  EXPECT_THAT(check_localhost_only(seen), ElementsAre(error("/talker with it, /listener without")));
}

TEST(DoctorLocalhostOnly, ComparesTheCommandItselfToo) {
  Observation seen;
  seen.machine.emplace();
  seen.machine->interfaces = {{"lo", 65536, true, false}, {"eth0", 1500, false, true}};
  seen.nodes_on_loopback_alone = {NodeName::parse("/talker")};
  EXPECT_THAT(check_localhost_only(seen), ElementsAre(error("/talker with it, this command")));
  seen.machine->localhost_only = true;
  EXPECT_THAT(check_localhost_only(seen), IsEmpty());
  // Without another interface everybody is on the loopback.
  seen.machine->localhost_only = false;
  seen.machine->interfaces.pop_back();
  EXPECT_THAT(check_localhost_only(seen), IsEmpty());
}

TEST(DoctorNetwork, NamesAMissingLoopback) {
  Observation seen;
  seen.machine.emplace();
  seen.machine->localhost_only = true;
  seen.machine->interfaces = {{"eth0", 1500, false, true}};
  EXPECT_THAT(check_network(seen), ElementsAre(error("loopback interface is missing or down")));
  seen.unreachable_network = "DDS domain 3: cannot create a participant";
  EXPECT_THAT(check_network(seen), ElementsAre(error("cannot create a participant"),
                                               error("loopback interface is missing or down")));
}

TEST(DoctorInputs, NamesWhatNobodyPublishes) {
  EXPECT_THAT(
      check_inputs(graph(
          {endpoint("/estimator", false, "/imu/data"), endpoint("/estimator", false, "/gps/fix"),
           endpoint("/driver", true, "/gps/fix"), endpoint("/estimator", false, "/clock"),
           endpoint("/_command", false, "/nothing")})),
      ElementsAre(warning("Nobody publishes /imu/data (sensor_msgs/msg/Imu), to which "
                          "/estimator subscribes")));
}

TEST(DoctorNodeNames, NamesTwoOfOneName) {
  Observation seen;
  seen.nodes = {NodeName::parse("/a"), NodeName::parse("/b"), NodeName::parse("/a")};
  EXPECT_THAT(check_node_names(seen), ElementsAre(error("2 nodes have the name /a")));
}

TEST(DoctorClock, NamesTwoThatDriveIt) {
  const std::string type = "rosgraph_msgs::msg::dds_::Clock_";
  const auto simulator = endpoint("/simulator", true, "/clock", QoS::reliable(), type);
  EXPECT_THAT(check_clock_publishers(graph({simulator})), IsEmpty());
  EXPECT_THAT(check_clock_publishers(
                  graph({simulator, endpoint("/player", true, "/clock", QoS::reliable(), type)})),
              ElementsAre(error("2 publishers drive /clock (/player, /simulator)")));
}

TEST(DoctorStamps, NamesClocksThatDiffer) {
  Observation seen;
  seen.stamp_age = {{"/imu/data", 0.01}, {"/gps/fix", 3.25}, {"/scan", -2.0}};
  EXPECT_THAT(check_stamps(seen), ElementsAre(warning("/gps/fix are 3.25 s behind"),
                                              warning("/scan are 2.00 s ahead")));
  seen.simulated_time = true;
  EXPECT_THAT(check_stamps(seen), IsEmpty());
}

Observation imu(const Vector& force, const Vector& rate = {}, const std::string& frame = "imu") {
  Observation seen;
  seen.imus["/imu/data"] = {frame, {force, force}, {rate, rate}};
  return seen;
}

TEST(DoctorImu, JudgesGravityAtRest) {
  EXPECT_THAT(check_imu(imu({0.1, -0.2, 9.79})), IsEmpty());
  EXPECT_THAT(check_imu(imu({0.01, 0.02, 0.03})), ElementsAre(error("Gravity is taken out")));
  EXPECT_THAT(check_imu(imu({0, 0, 0})), ElementsAre(error("exactly 0")));
  EXPECT_THAT(check_imu(imu({0, 0, 1.001})), ElementsAre(error("measures in g")));
  EXPECT_THAT(check_imu(imu({0, 0, 11.0})), ElementsAre(warning("11.00 m/s^2, not 9.81")));
  EXPECT_THAT(check_imu(imu({0, 0, std::numeric_limits<double>::quiet_NaN()})),
              ElementsAre(error("no numbers")));
}

TEST(DoctorImu, SaysNothingOfGravityInMotion) {
  EXPECT_THAT(check_imu(imu({0, 0, 3.0}, {0, 0, 1.0})), IsEmpty());
}

TEST(DoctorImu, JudgesItsFrame) {
  EXPECT_THAT(check_imu(imu({0, 0, 9.81}, {}, "")), ElementsAre(error("does not say its frame")));
  EXPECT_THAT(check_imu(imu({0, 9.81, 0}, {}, "base_link")),
              ElementsAre(error("its z axis is 90 degrees from upright")));
  EXPECT_THAT(check_imu(imu({0, 9.81, 0}, {}, "imu")), IsEmpty());
}

Observation fix(std::uint8_t type, double variance) {
  Observation seen;
  seen.fixes["/gps/fix"] = {
      true, 46.5, 8.0, {variance, 0, 0, 0, variance, 0, 0, 0, variance}, type};
  return seen;
}

TEST(DoctorGps, JudgesTheCovariance) {
  EXPECT_THAT(check_gps(fix(2, 0.25)), IsEmpty());
  EXPECT_THAT(check_gps(fix(0, 0.0)), ElementsAre(warning("do not say how good")));
  for (const double variance : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(check_gps(fix(2, variance)), ElementsAre(warning("said to be known")));
  }
}

TEST(DoctorGps, JudgesTheFix) {
  auto seen = fix(2, 0.25);
  seen.fixes["/gps/fix"].latitude = seen.fixes["/gps/fix"].longitude = 0.0;
  EXPECT_THAT(check_gps(seen), ElementsAre(error("are at 0, 0")));
  seen.fixes["/gps/fix"].has_fix = false;
  EXPECT_THAT(check_gps(seen), ElementsAre(warning("no fix")));
}

TEST(DoctorDatum, ComparesItWithTheFixes) {
  auto seen = fix(2, 0.25);
  const auto node = NodeName::parse("/estimator");
  seen.datums[node] = {46.51, 8.01, 400.0};
  EXPECT_THAT(check_datum(seen), IsEmpty());
  seen.datums[node] = {};
  EXPECT_THAT(check_datum(seen), IsEmpty());
  seen.datums[node] = {8.0, 46.5, 400.0};  // the wrong way round
  EXPECT_THAT(check_datum(seen), ElementsAre(error("/estimator is")));
  seen.datums[node] = {46.5, 8.0};
  EXPECT_THAT(check_datum(seen), ElementsAre(error("has 2 values")));
}

TEST(DoctorCamera, NamesAMissingCalibration) {
  const std::string image = "sensor_msgs::msg::dds_::Image_";
  const auto camera = endpoint("/camera", true, "/front/image_raw", QoS::reliable(), image);
  const auto user = endpoint("/localizer", false, "/front/image_raw", QoS::reliable(), image);
  EXPECT_THAT(check_camera_calibration(graph({camera, user})),
              ElementsAre(warning("nobody publishes /front/camera_info")));
  const auto info = endpoint("/camera", true, "/front/camera_info", QoS::reliable(),
                             "sensor_msgs::msg::dds_::CameraInfo_");
  auto seen = graph({camera, user, info});
  EXPECT_THAT(check_camera_calibration(seen), IsEmpty());
  seen.cameras["/front/camera_info"] = {0.0, 640, 512};
  EXPECT_THAT(check_camera_calibration(seen), ElementsAre(error("focal length is 0")));
}

TEST(DoctorMachine, JudgesSharedMemoryAndDisk) {
  Observation seen;
  EXPECT_THAT(examine(seen), IsEmpty()) << "what was not looked at is not wrong";
  seen.machine = Machine{.shared_memory_total = 64 * kMegabyte,
                         .shared_memory_free = 60 * kMegabyte,
                         .interfaces = {},
                         .localhost_only = true,
                         .recording_folder = "/data",
                         .recording_free = 500 * kMegabyte};
  EXPECT_THAT(check_shared_memory(seen), ElementsAre(warning("60 MB free of 64 MB")));
  EXPECT_THAT(check_disk(seen), ElementsAre(error("/data has 500 MB free")));
  seen.machine->shared_memory_free = kMegabyte;
  EXPECT_THAT(check_shared_memory(seen), ElementsAre(error("/dev/shm has 1 MB free")));
  seen.machine->recording_free = seen.machine->shared_memory_free = 1'000'000 * kMegabyte;
  EXPECT_THAT(check_disk(seen), IsEmpty());
  EXPECT_THAT(check_shared_memory(seen), IsEmpty());
}

TEST(DoctorMachine, JudgesTheNetwork) {
  Observation seen;
  seen.machine.emplace();
  seen.machine->interfaces = {{"lo", 65536, true, false}};
  EXPECT_THAT(check_network(seen), ElementsAre(warning("No network interface")));
  seen.machine->interfaces.push_back({"wlan0", 1280, false, false});
  EXPECT_THAT(check_network(seen),
              ElementsAre(warning("MTU of wlan0 is 1280"), warning("wlan0 has no multicast")));
  seen.machine->localhost_only = true;
  EXPECT_THAT(check_network(seen), IsEmpty());
}

TEST(DoctorComposition, NamesFailuresAndUnknownParameters) {
  Observation seen;
  seen.trials.push_back({"c.yaml:3:5", NodeName::parse("/fusion"), "no such file", {}});
  seen.trials.push_back({"c.yaml:9:5",
                         NodeName::parse("/locator"),
                         "",
                         {{{"gian", 1.0, "c.yaml:12"}, "gain"},
                          {{"use_sim_tim", true, "c.yaml:1", true}, std::nullopt}}});
  EXPECT_THAT(check_components(seen),
              ElementsAre(error("c.yaml:3:5: /fusion cannot be started: no such file")));
  EXPECT_THAT(check_parameters(seen),
              ElementsAre(error("c.yaml:12: no parameter 'gian'; did you mean 'gain'?")));
}

TEST(DoctorReport, CountsWhatWasFound) {
  const std::vector<Finding> findings{{Severity::kError, "A is wrong.", "Mend A."},
                                      {Severity::kWarning, "B may be wrong.", "Look at B."}};
  EXPECT_THAT(report(findings),
              StartsWith("error: A is wrong.\n  Mend A.\nwarning: B may be wrong.\n  Look at B.\n"
                         "1 error, 1 warning from "));
  EXPECT_TRUE(has_errors(findings));
  EXPECT_FALSE(has_errors({findings[1]}));
  EXPECT_THAT(report({}), StartsWith("0 errors, 0 warnings from "));
}

TEST(DoctorChecks, HaveNames) {
  EXPECT_GE(all_checks().size(), 15U);
  for (const auto& check : all_checks()) {
    EXPECT_STRNE(check.name, "");
  }
}

}  // namespace
}  // namespace pipescout::host::doctor
