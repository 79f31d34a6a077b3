// SPDX-License-Identifier: Apache-2.0
// How `generate-policy` runs a composition, with a `pipescout` in its place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "dds_test_support.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/keystore/policy.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout::security {
namespace {

using ::pipescout::testing::content;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

class Observation : public ::testing::Test {
 protected:
  Observation() {
    setenv("ROS_DOMAIN_ID", std::to_string(dds_test::local_options().domain_id).c_str(), 1);
    setenv("PATH", (folder_.path().string() + ":" + path_).c_str(), 1);
  }
  ~Observation() override { setenv("PATH", path_.c_str(), 1); }

  void write_pipescout(const std::string& end) const {
    const auto file = folder_.path() / "pipescout";
    std::ofstream(file) << "#!/bin/sh\necho \"$@\" > '" << (folder_.path() / "words").string()
                        << "'\necho to out\necho to err >&2\n"
                        << end << '\n';
    fs::permissions(file, fs::perms::owner_all);
  }
  ::pipescout::testing::Finished generate() {
    return ::pipescout::testing::run_program(
        SECURITY_COMMAND,
        {"generate-policy", "policy.xml", "--enclave", "/robot_1", "--namespace", "/robot_1",
         "--composition", "c.yaml", "seed:=3"},
        folder_.path());
  }

  const std::string path_ = std::getenv("PATH");
  ::pipescout::testing::TemporaryFolder folder_;
};

TEST_F(Observation, RunsInTheNamespaceAndSaysNothingOfIt) {
  write_pipescout("exec tail -f /dev/null");
  const auto transport = create_dds_transport(dds_test::local_options());
  dds_test::WriterRecord record;
  const auto writer = transport->create_writer(
      {"rt/robot_1/weld", &message_type<std_msgs::msg::String>()}, QoS::reliable(), record);
  const auto finished = generate();
  EXPECT_EQ(finished.code(), 0) << finished.err;
  EXPECT_EQ(finished.out, "wrote policy.xml\n");
  EXPECT_THAT(finished.err, IsEmpty());
  EXPECT_THAT(content(folder_.path() / "words"), HasSubstr("run c.yaml seed:=3 --out "));
  EXPECT_THAT(content(folder_.path() / "words"), HasSubstr(" --namespace /robot_1\n"));
  EXPECT_THAT(keystore::read_policy(folder_.path() / "policy.xml").at("/robot_1").publish,
              ::testing::Contains("/robot_1/weld"));
}

TEST_F(Observation, ShowsWhatAFailedRunPrinted) {
  write_pipescout("exit 3");
  const auto finished = generate();
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err,
              HasSubstr("ended with an error before it was observed:\nto out\nto err"));
}

}  // namespace
}  // namespace pipescout::security
