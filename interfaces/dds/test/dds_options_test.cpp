// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

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
    for (const char* const name : {"ROS_SECURITY_ENABLE", "ROS_SECURITY_STRATEGY",
                                   "ROS_SECURITY_KEYSTORE", "ROS_SECURITY_ENCLAVE_OVERRIDE"}) {
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
  const auto security = DdsOptions::from_environment().security;
  EXPECT_TRUE(security.enabled);
  EXPECT_TRUE(security.enforce);
  EXPECT_EQ(security.keystore, "/keys");
  EXPECT_EQ(security.enclave_override, "/robot");
  expect_refused("ROS_SECURITY_ENABLE", "True");
  expect_refused("ROS_SECURITY_STRATEGY", "enforce");
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

}  // namespace
}  // namespace pipescout
