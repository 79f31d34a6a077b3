// SPDX-License-Identifier: Apache-2.0
#include "pipescout/files/whole_file.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <string>
#include <system_error>

#include "pipescout/files/testing/temporary_folder.hpp"

namespace {

int syncs = 0;

}  // namespace

// Takes the place of the C library's, so that tests see who waits for the disk.
extern "C" int fsync(int descriptor) {
  ++syncs;
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

namespace pipescout {
namespace {

using pipescout::testing::content;
using pipescout::testing::lines;
using pipescout::testing::TemporaryFolder;
using ::testing::HasSubstr;

TEST(LineFile, LinesAreThereAtOnce) {
  const TemporaryFolder folder;
  LineFile file(folder.path() / "a.csv");
  file.write("x,y");
  EXPECT_EQ(content(file.path()), "x,y\n");
  file.write("");
  file.write("1,2");
  EXPECT_EQ(content(file.path()), "x,y\n\n1,2\n");
  EXPECT_NO_THROW(file.sync());
}

TEST(LineFile, NeverTouchesAnExistingFile) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.csv";
  { LineFile(path).write("old"); }
  try {
    const LineFile again(path);
    FAIL() << "made a second time";
  } catch (const std::system_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(path.string()));
  }
  EXPECT_EQ(content(path), "old\n");
}

TEST(LineFile, ErrorsNameTheFile) {
  const TemporaryFolder folder;
  try {
    const LineFile file(folder.path() / "missing" / "a.csv");
    FAIL() << "made in a folder that is not there";
  } catch (const std::system_error& error) {
    EXPECT_EQ(error.code(), std::errc::no_such_file_or_directory);
    EXPECT_THAT(error.what(), HasSubstr("missing/a.csv"));
  }
}

/// Runs in a child, which may be killed.
template <class Function>
pid_t run_in_child(Function function) {
  const pid_t child = ::fork();
  if (child == 0) {
    try {
      function();
    } catch (...) {
      ::_exit(1);
    }
    ::_exit(0);
  }
  return child;
}

TEST(LineFile, KilledWriterLeavesWholeLines) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.csv";
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const pid_t child = run_in_child([&] {
    LineFile file(path);
    for (int i = 0;; ++i) {
      file.write("line " + std::to_string(i));
      if (i == 1000) {
        (void)!::write(pipe[1], "x", 1);
      }
    }
  });
  ASSERT_GT(child, 0);
  char byte = 0;
  ASSERT_EQ(::read(pipe[0], &byte, 1), 1);
  ASSERT_EQ(::kill(child, SIGKILL), 0);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  ::close(pipe[0]);
  ::close(pipe[1]);

  const auto written = lines(path);
  ASSERT_GT(written.size(), 1000U);
  // All but a line that the kill may have cut.
  for (std::size_t i = 0; i + 1 < written.size(); ++i) {
    ASSERT_EQ(written[i], "line " + std::to_string(i));
  }
}

TEST(LineFile, FullDiskLeavesWholeLines) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.csv";
  const pid_t child = run_in_child([&] {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{.rlim_cur = 25, .rlim_max = 25};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    LineFile file(path);
    file.write("123456789");
    file.write("123456789");
    try {
      file.write("123456789");
    } catch (const std::system_error& error) {
      ::_exit(error.code() == std::errc::file_too_large ? 0 : 2);
    }
    ::_exit(3);
  });
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(content(path), "123456789\n123456789\n");
}

TEST(ReplaceFile, ReplacesTheWhole) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.json";
  replace_file(path, "a long first version");
  replace_file(path, "second");
  EXPECT_EQ(content(path), "second");
  EXPECT_FALSE(std::filesystem::exists(path.string() + ".tmp"));
}

TEST(ReplaceFile, WaitsForTheDiskOnlyWhenAskedTo) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.json";
  syncs = 0;
  replace_file(path, "first", Survives::kKill);
  EXPECT_EQ(syncs, 0);
  EXPECT_EQ(content(path), "first");
  replace_file(path, "second", Survives::kPowerLoss);
  EXPECT_EQ(syncs, 2) << "the file and its folder";
  EXPECT_EQ(content(path), "second");
}

TEST(ReplaceFile, AFailureLeavesTheOldVersion) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.json";
  replace_file(path, "old");
  const pid_t child = run_in_child([&] {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{.rlim_cur = 4, .rlim_max = 4};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    try {
      replace_file(path, "too long for the limit");
    } catch (const std::system_error&) {
      ::_exit(0);
    }
    ::_exit(2);
  });
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(content(path), "old");
  EXPECT_FALSE(std::filesystem::exists(path.string() + ".tmp"));
}

}  // namespace
}  // namespace pipescout
