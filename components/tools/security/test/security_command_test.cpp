// SPDX-License-Identifier: Apache-2.0
// `pipescout security` on the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "dds_test_support.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/keystore/policy.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout::security {
namespace {

using ::pipescout::testing::Finished;
using ::pipescout::testing::run_program;
using ::pipescout::testing::TemporaryFolder;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

class SecurityCommand : public ::testing::Test {
 protected:
  // The programs take the domain that the environment has at the first of them.
  SecurityCommand() {
    setenv("ROS_DOMAIN_ID", std::to_string(dds_test::local_options().domain_id).c_str(), 1);
  }
  Finished run(const std::vector<std::string>& arguments) {
    return run_program(SECURITY_COMMAND, arguments, folder_.path());
  }

  TemporaryFolder folder_;
};

TEST_F(SecurityCommand, MakesChecksAndRevokes) {
  EXPECT_EQ(run({"create-keystore", "keys", "--domain", "7"}).code(), 0);
  EXPECT_EQ(run({"create-enclave", "keys", "/robot_1"}).code(), 0);
  EXPECT_EQ(run({"list", "keys"}).out, "/robot_1\n");
  const auto check = run({"check", "keys"});
  EXPECT_EQ(check.code(), 0) << check.out << check.err;
  EXPECT_THAT(check.out, ContainsRegex("valid for 36[45] days"));
  EXPECT_THAT(run({"check", "keys", "--warn-days", "400"}).out, HasSubstr("warning"));
  EXPECT_EQ(run({"revoke", "keys", "/robot_1"}).code(), 0);
  const auto findings = nlohmann::json::parse(run({"check", "keys", "--json"}).out);
  EXPECT_THAT(findings.dump(), HasSubstr("revoked on"));
}

TEST_F(SecurityCommand, NamesWhatIsWrong) {
  EXPECT_EQ(run({"list", "nowhere"}).code(), 1);
  EXPECT_THAT(run({"list", "nowhere"}).err, HasSubstr("nowhere: is no keystore"));
  EXPECT_EQ(run({"create-keystore", "keys", "--domain", "300"}).code(), 2);
  EXPECT_EQ(run({"create-keystore", "keys"}).code(), 0);
  std::filesystem::remove(folder_.path() / "keys/private/permissions_ca.key.pem");
  EXPECT_THAT(run({"create-enclave", "keys", "/a"}).err, HasSubstr("permissions_ca.key.pem"));
  EXPECT_THAT(run({"create-enclave", "keys", "/a", "--policy", "none.xml"}).err,
              HasSubstr("none.xml: No such file"));
}

// As `ros2 security create_keystore` and `create_enclave` leave them.
TEST_F(SecurityCommand, KeysThatOthersCanReadAreWarnedOfOrRefused) {
  namespace fs = std::filesystem;
  EXPECT_EQ(run({"create-keystore", "keys"}).code(), 0);
  fs::permissions(folder_.path() / "keys/private/identity_ca.key.pem", fs::perms::others_read,
                  fs::perm_options::add);
  const auto made = run({"create-enclave", "keys", "/robot_1"});
  EXPECT_EQ(made.code(), 0);
  EXPECT_THAT(made.err,
              HasSubstr("warning: keys/private/identity_ca.key.pem: others than its owner"));
  const auto refused = run({"create-enclave", "keys", "/robot_2", "--strict-keys"});
  EXPECT_EQ(refused.code(), 1);
  EXPECT_THAT(refused.err, HasSubstr("identity_ca.key.pem: others than its owner"));
  EXPECT_FALSE(fs::exists(folder_.path() / "keys/enclaves/robot_2"));
  fs::permissions(folder_.path() / "keys/enclaves/robot_1/key.pem", fs::perms::group_read,
                  fs::perm_options::add);
  EXPECT_EQ(run({"check", "keys"}).code(), 0);
  EXPECT_THAT(run({"check", "keys"}).out, ContainsRegex("warning +keys/enclaves/robot_1/key.pem"));
  EXPECT_EQ(run({"check", "keys", "--strict-keys"}).code(), 1);
  setenv("PIPESCOUT_STRICT_KEYS", "true", 1);
  EXPECT_EQ(run({"check", "keys"}).code(), 1);
  unsetenv("PIPESCOUT_STRICT_KEYS");
}

TEST_F(SecurityCommand, PolicyOfARunningSystemHasWhatItUses) {
  auto options = dds_test::local_options();
  options.enclave = "/robot_1";
  const auto transport = create_dds_transport(options);
  dds_test::WriterRecord record;
  const auto writer = transport->create_writer({"rt/weld", &message_type<std_msgs::msg::String>()},
                                               QoS::reliable(), record);
  const auto finished = run({"generate-policy", "policy.xml"});
  ASSERT_EQ(finished.code(), 0) << finished.err;
  const auto policy = keystore::read_policy(folder_.path() / "policy.xml");
  ASSERT_TRUE(policy.contains("/robot_1"));
  EXPECT_EQ(policy.at("/robot_1").publish, std::set<std::string>{"/weld"});
  EXPECT_TRUE(policy.at("/robot_1").subscribe.empty());
}

}  // namespace
}  // namespace pipescout::security
