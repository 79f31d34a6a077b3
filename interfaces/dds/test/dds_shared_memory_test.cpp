// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "dds_test_support.hpp"
#include "shared_memory.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;

class SegmentFolderTest : public ::testing::Test {
 protected:
  SegmentFolderTest()
      : folder_(fs::temp_directory_path() / ("pipescout_segments_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~SegmentFolderTest() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  fs::path make(const std::string& name, std::chrono::seconds age = std::chrono::minutes(1)) const {
    const fs::path file = folder_ / name;
    std::ofstream(file) << "content";
    fs::last_write_time(file, fs::file_time_type::clock::now() - age);
    return file;
  }

  const fs::path folder_;
};

TEST_F(SegmentFolderTest, RemovesSegmentsWhoseOwnerIsGone) {
  const fs::path segment = make("fastrtps_0123456789abcdef");
  const fs::path lock = make("fastrtps_0123456789abcdef_el");
  dds::remove_abandoned_segments(folder_);
  EXPECT_FALSE(fs::exists(segment));
  EXPECT_FALSE(fs::exists(lock));
}

TEST_F(SegmentFolderTest, LeavesEverythingElseAlone) {
  const fs::path owned = make("fastrtps_1111111111111111");
  const fs::path owned_lock = make("fastrtps_1111111111111111_el");
  const int owner = open(owned_lock.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_EQ(flock(owner, LOCK_EX), 0);
  const fs::path young = make("fastrtps_2222222222222222");
  const fs::path young_lock = make("fastrtps_2222222222222222_el", std::chrono::seconds(0));
  const fs::path port = make("fastrtps_port7410");
  const fs::path port_lock = make("fastrtps_port7410_el");
  const fs::path foreign = make("notes_el");
  dds::remove_abandoned_segments(folder_);
  for (const fs::path& file : {owned, owned_lock, young, young_lock, port, port_lock, foreign}) {
    EXPECT_TRUE(fs::exists(file)) << file;
  }
  close(owner);
}

TEST_F(SegmentFolderTest, SurvivesAMissingFolder) {
  dds::remove_abandoned_segments(folder_ / "absent");
  EXPECT_FALSE(dds::fitting_segment_bytes(1, folder_ / "absent"));
}

TEST_F(SegmentFolderTest, LeavesRoomForOthers) {
  const auto room = fs::space(folder_).available;
  const auto least = dds::fitting_segment_bytes(1, folder_);
  ASSERT_TRUE(least);
  EXPECT_EQ(*least, 512U * 1024U);
  const auto most = dds::fitting_segment_bytes(SIZE_MAX, folder_);
  ASSERT_TRUE(most);
  EXPECT_LE(*most, room / 4);
}

// The other process of the test below: offers a message and stays until it is killed.
TEST(DdsProcessTest, DISABLED_Talker) {
  const char* tester = std::getenv("PIPESCOUT_TEST_PROCESS");
  ASSERT_NE(tester, nullptr);
  DdsOptions options = dds_test::local_options();
  options.domain_id = 100 + static_cast<std::uint32_t>(std::stoul(tester)) % 100;
  const auto transport = create_dds_transport(options);
  dds_test::WriterRecord told;
  const auto writer = transport->create_writer(dds_test::text_topic("killed", std::stoi(tester)),
                                               QoS::latched(), told);
  const auto message = dds_test::make_text("from another process");
  writer->write(&message, {});
  alarm(60);  // should nobody be left to kill it
  pause();
}

pid_t start_talker() {
  const std::string process = "PIPESCOUT_TEST_PROCESS=" + std::to_string(getpid());
  std::string program = fs::read_symlink("/proc/self/exe").string();
  std::string filter = "--gtest_filter=DdsProcessTest.DISABLED_Talker";
  std::string disabled = "--gtest_also_run_disabled_tests";
  const std::array<char*, 4> arguments{program.data(), filter.data(), disabled.data(), nullptr};
  putenv(const_cast<char*>(process.c_str()));
  pid_t talker = 0;
  const int error =
      posix_spawn(&talker, program.c_str(), nullptr, nullptr, arguments.data(), environ);
  unsetenv("PIPESCOUT_TEST_PROCESS");
  return error == 0 ? talker : 0;
}

TEST(DdsProcessTest, AKilledProcessDoesNotStopTheNext) {
  for (int round = 0; round < 2; ++round) {
    const auto transport = create_dds_transport(dds_test::local_options());
    dds_test::ReaderRecord heard;
    const auto reader =
        transport->create_reader(dds_test::text_topic("killed"), QoS::latched(), heard);
    const pid_t talker = start_talker();
    ASSERT_GT(talker, 0);
    const bool arrived = heard.await_messages(1);
    kill(talker, SIGKILL);
    int status = 0;
    waitpid(talker, &status, 0);
    ASSERT_TRUE(arrived);
    EXPECT_EQ(heard.text(0), "from another process");
    EXPECT_TRUE(WIFSIGNALED(status));
  }
}

}  // namespace
}  // namespace pipescout
