// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/dds/dds_transport.hpp"

namespace pipescout {
namespace {

using ::testing::HasSubstr;

class DdsOptionsTest : public ::testing::Test {
 protected:
  void SetUp() override { clear(); }
  void TearDown() override { clear(); }

  static void clear() {
    unsetenv("ROS_DOMAIN_ID");
    unsetenv("ROS_LOCALHOST_ONLY");
    for (const char* const name :
         {"ROS_DISCOVERY_SERVER", "ROS_SUPER_CLIENT", "ROS_STATIC_PEERS", "PIPESCOUT_NETWORK",
          "ROS_SECURITY_ENABLE", "ROS_SECURITY_STRATEGY", "ROS_SECURITY_KEYSTORE",
          "ROS_SECURITY_ENCLAVE_OVERRIDE", "PIPESCOUT_STRICT_KEYS"}) {
      unsetenv(name);
    }
  }
  static void expect_refused(const char* name, const char* value) {
    clear();
    setenv(name, value, 1);
    try {
      (void)DdsOptions::from_environment();
      FAIL() << name << "=" << value << " was taken";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr(name));
      EXPECT_THAT(error.what(), HasSubstr(std::string("'") + value + "'"));
    }
  }
};

TEST_F(DdsOptionsTest, DefaultsAreThoseOfRos2) {
  const DdsOptions options = DdsOptions::from_environment();
  EXPECT_EQ(options.domain_id, 0U);
  EXPECT_FALSE(options.localhost_only);
  EXPECT_EQ(options.enclave, "/");
}

TEST_F(DdsOptionsTest, ReadsTheEnvironment) {
  setenv("ROS_DOMAIN_ID", "42", 1);
  setenv("ROS_LOCALHOST_ONLY", "1", 1);
  const DdsOptions options = DdsOptions::from_environment();
  EXPECT_EQ(options.domain_id, 42U);
  EXPECT_TRUE(options.localhost_only);
}

TEST_F(DdsOptionsTest, ReadsSecurityAsRclDoes) {
  EXPECT_FALSE(DdsOptions::from_environment().security.enabled);
  setenv("ROS_SECURITY_ENABLE", "true", 1);
  setenv("ROS_SECURITY_STRATEGY", "Enforce", 1);
  setenv("ROS_SECURITY_KEYSTORE", "/keys", 1);
  setenv("ROS_SECURITY_ENCLAVE_OVERRIDE", "/robot", 1);
  EXPECT_FALSE(DdsOptions::from_environment().security.strict_keys);
  setenv("PIPESCOUT_STRICT_KEYS", "true", 1);
  const auto security = DdsOptions::from_environment().security;
  EXPECT_TRUE(security.enabled);
  EXPECT_TRUE(security.enforce);
  EXPECT_TRUE(security.strict_keys);
  EXPECT_EQ(security.keystore, "/keys");
  EXPECT_EQ(security.enclave_override, "/robot");
  expect_refused("ROS_SECURITY_ENABLE", "True");
  expect_refused("ROS_SECURITY_STRATEGY", "enforce");
  expect_refused("PIPESCOUT_STRICT_KEYS", "1");
}

TEST_F(DdsOptionsTest, EmptyIsAsNotSet) {
  setenv("ROS_DOMAIN_ID", "", 1);
  setenv("ROS_LOCALHOST_ONLY", "", 1);
  const DdsOptions options = DdsOptions::from_environment();
  EXPECT_EQ(options.domain_id, 0U);
  EXPECT_FALSE(options.localhost_only);
}

TEST_F(DdsOptionsTest, AcceptsTheLimitsOfTheDomain) {
  setenv("ROS_DOMAIN_ID", "232", 1);
  setenv("ROS_LOCALHOST_ONLY", "0", 1);
  const DdsOptions options = DdsOptions::from_environment();
  EXPECT_EQ(options.domain_id, 232U);
  EXPECT_FALSE(options.localhost_only);
}

TEST_F(DdsOptionsTest, RefusesWhatItCannotRead) {
  for (const char* value : {"233", "-1", "4x", " 4", "one", "99999999999999999999"}) {
    expect_refused("ROS_DOMAIN_ID", value);
  }
  for (const char* value : {"2", "true", "01"}) {
    expect_refused("ROS_LOCALHOST_ONLY", value);
  }
}

TEST(GidTest, PrintsAsDdsToolsDo) {
  const Gid gid{{0x01, 0x0f, 0x45, 0xd2, 0, 0, 0, 0, 0, 0, 0xab, 0xff, 0, 0, 0x12, 0x03}};
  EXPECT_EQ(to_string(gid), "01.0f.45.d2.00.00.00.00.00.00.ab.ff|00.00.12.03");
}

TEST_F(DdsOptionsTest, ReadsDiscoveryServersByTheirPlaces) {
  setenv("ROS_DISCOVERY_SERVER", "10.0.0.1;;station:11888", 1);
  setenv("ROS_SUPER_CLIENT", "TRUE", 1);
  const DdsOptions options = DdsOptions::from_environment();
  const std::vector<DiscoveryServerAddress> expected{{.id = 0, .host = "10.0.0.1", .port = 11811},
                                                     {.id = 2, .host = "station", .port = 11888}};
  EXPECT_EQ(options.discovery_servers, expected);
  EXPECT_TRUE(options.super_client);
}

TEST_F(DdsOptionsTest, RefusesDiscoveryServersThatItCannotReach) {
  expect_refused("ROS_DISCOVERY_SERVER", "10.0.0.1:0");
  expect_refused("ROS_DISCOVERY_SERVER", "10.0.0.1:70000");
  expect_refused("ROS_DISCOVERY_SERVER", "10.0.0.1:11x");
  expect_refused("ROS_DISCOVERY_SERVER", "TCPv4:[10.0.0.1]:1");
  expect_refused("ROS_DISCOVERY_SERVER", "fe80::1");
  expect_refused("ROS_SUPER_CLIENT", "yes");
}

TEST_F(DdsOptionsTest, ReadsPeersFromTheEnvironmentAndFromFiles) {
  const auto file =
      std::filesystem::temp_directory_path() / ("pipescout_peers_" + std::to_string(getpid()));
  std::ofstream(file) << "# the fleet\n10.0.0.2\n\n robot-3  # on the crane\n10.0.0.1\n";
  setenv("ROS_STATIC_PEERS", ("10.0.0.1; " + file.string() + ";;").c_str(), 1);
  EXPECT_THAT(DdsOptions::from_environment().static_peers,
              ::testing::ElementsAre("10.0.0.1", "10.0.0.2", "robot-3"));
  std::filesystem::remove(file);
}

TEST_F(DdsOptionsTest, NamesTheLineOfAPeerThatIsNone) {
  const auto file =
      std::filesystem::temp_directory_path() / ("pipescout_bad_peers_" + std::to_string(getpid()));
  std::ofstream(file) << "10.0.0.2\nrobot 3\n";
  try {
    (void)parse_static_peers(file.string());
    ADD_FAILURE() << "was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr(file.string() + ":2: 'robot 3'"));
  }
  std::filesystem::remove(file);
  EXPECT_THROW((void)parse_static_peers("/no/such/file"), std::invalid_argument);
  expect_refused("ROS_STATIC_PEERS", "10.0.0.2:7400");
}

TEST_F(DdsOptionsTest, ReadsTheProfileOfTheNetwork) {
  EXPECT_EQ(DdsOptions::from_environment().network.kind, NetworkProfile::Kind::kWire);
  setenv("PIPESCOUT_NETWORK", "wifi:2.5", 1);
  const auto network = DdsOptions::from_environment().network;
  EXPECT_EQ(network.kind, NetworkProfile::Kind::kWifi);
  EXPECT_EQ(network.rate, 2.5);
  for (const char* const wrong : {"WiFi", "wifi:", "wifi:0", "wifi:fast", "wire:2", "wifi:1e9"}) {
    expect_refused("PIPESCOUT_NETWORK", wrong);
  }
}

}  // namespace
}  // namespace pipescout
