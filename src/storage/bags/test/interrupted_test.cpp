// SPDX-License-Identifier: Apache-2.0
// Recordings that end by force: a kill, a full disk.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <functional>
#include <random>
#include <string>

#include "pipescout/bags/bag_maintenance.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "test_bag.hpp"

namespace pipescout::bags {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Stored;
namespace fs = std::filesystem;

class InterruptedRecording : public ::testing::TestWithParam<Storage> {
 protected:
  [[nodiscard]] Stored message(std::size_t k) const {
    std::mt19937 random(static_cast<unsigned>(k));
    const auto time = static_cast<std::int64_t>(k) * 1'000'000;
    return {k % 5 == 0 ? "/image" : "/pose", time, time,
            testing::cdr(random, k % 5 == 0 ? 9000 : 80)};
  }
  [[nodiscard]] BagWriterOptions options() const {
    return {.storage = GetParam(), .max_file_size = 1'000'000, .chunk_size = 20'000};
  }

  pipescout::testing::TemporaryFolder folder_;
};

TEST_P(InterruptedRecording, FiftyKillsLoseNothingThatWasFlushed) {
  using Counter = std::atomic<std::size_t>;
  void* shared =
      ::mmap(nullptr, sizeof(Counter), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  auto& flushed = *new (shared) Counter(0);
  std::mt19937 random(3);
  for (int kill = 0; kill < 50; ++kill) {
    const fs::path bag = folder_.path() / ("bag" + std::to_string(kill));
    flushed = 0;
    const std::size_t enough = 1 + random() % 400;
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      BagWriter writer(bag, options());
      for (std::size_t k = 0;; ++k) {
        testing::write(writer, message(k));
        if (k % 7 == 0) {
          writer.flush();
          flushed = k + 1;
        }
      }
    }
    while (flushed < enough) {
      ASSERT_EQ(::waitpid(child, nullptr, WNOHANG), 0) << "the writer ended by itself";
      ::sched_yield();
    }
    ::kill(child, SIGKILL);
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    const std::size_t safe = flushed;
    std::string error;
    BagReader reader(bag);
    const auto read = testing::read(reader, &error);
    ASSERT_GE(read.size(), safe) << error;
    for (std::size_t k = 0; k < read.size(); ++k) {
      ASSERT_EQ(read[k], message(k)) << k;
    }
    const fs::path mended = folder_.path() / "mended";
    EXPECT_EQ(recover_bag(bag, mended, options()).messages, read.size());
    EXPECT_THAT(check_bag(mended).faults, IsEmpty());
    fs::remove_all(mended);
    fs::remove_all(bag);
  }
  ::munmap(shared, sizeof(Counter));
}

TEST_P(InterruptedRecording, IsFlushedWhileItIsWritten) {
  const fs::path bag = folder_.path() / "bag";
  BagWriterOptions options = this->options();
  options.chunk_size = 1 << 30U;
  BagWriter writer(bag, options);
  // Ends because time passes: nothing else brings the messages to the file.
  for (std::size_t k = 0; BagReader(bag).metadata().messages == 0; ++k) {
    if (k % 2 == 0) {
      testing::write(writer, message(1));
    } else {
      writer.flush_if_due();
    }
  }
}

TEST_P(InterruptedRecording, FileOfTheLargestSizeAllowedEndsItWithAReadableBag) {
  struct sigaction ignore {};
  ignore.sa_handler = SIG_IGN;
  ::sigaction(SIGXFSZ, &ignore, nullptr);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const fs::path bag = folder_.path() / "bag";
  BagWriter writer(bag, {.storage = GetParam(), .chunk_size = 20'000, .cache_size = 100'000});
  const rlimit limit{.rlim_cur = 700'000, .rlim_max = before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &limit);
  std::size_t count = 0;
  std::string error;
  BagFault fault{};
  try {
    for (;; ++count) {
      testing::write(writer, message(count));
      if (count % 20 == 0) {
        writer.flush();
      }
    }
  } catch (const BagError& full) {
    fault = full.fault();
    error = full.what();
  }
  EXPECT_THROW(testing::write(writer, message(0)), BagError);
  writer.close();
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(fault, BagFault::kNoSpace) << error;
  EXPECT_THAT(error, HasSubstr("bag_0."));
  const auto read = testing::read(bag);
  EXPECT_GE(read.size() + 40, count);
  for (std::size_t k = 0; k < read.size(); ++k) {
    ASSERT_EQ(read[k], message(k));
  }
  EXPECT_THAT(check_bag(bag).faults, IsEmpty());
}

/// In a process with mounts of its own; says why the bag is not what it should be.
std::string record_to_full_disk(const fs::path& folder, const BagWriterOptions& options,
                                const std::function<Stored(std::size_t)>& message) {
  const fs::path bag = folder / "bag";
  BagWriter writer(bag, options);
  std::size_t count = 0;
  try {
    for (;; ++count) {
      testing::write(writer, message(count));
      if (count % 20 == 0) {
        writer.flush();
      }
    }
  } catch (const BagError& full) {
    if (full.fault() != BagFault::kNoSpace) {
      return full.what();
    }
  }
  writer.close();
  std::string error;
  BagReader reader(bag);
  const auto read = testing::read(reader, &error);
  for (std::size_t k = 0; k < read.size(); ++k) {
    if (read[k] != message(k)) {
      return "message " + std::to_string(k) + " differs";
    }
  }
  return read.size() + 40 >= count ? ""
                                   : std::to_string(read.size()) + " of " + std::to_string(count);
}

TEST_P(InterruptedRecording, FullDiskLeavesAReadableBag) {
  constexpr int kNotPossible = 77;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    if (::unshare(CLONE_NEWNS) != 0 ||
        ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        ::mount("tmpfs", folder_.path().c_str(), "tmpfs", 0, "size=1m") != 0) {
      ::_exit(kNotPossible);
    }
    const std::string error =
        record_to_full_disk(folder_.path(), {.storage = GetParam(), .chunk_size = 20'000},
                            [this](std::size_t k) { return message(k); });
    if (!error.empty()) {
      ::write(STDERR_FILENO, error.data(), error.size());
    }
    ::_exit(error.empty() ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNotPossible) {
    GTEST_SKIP() << "NOT TESTED on a full disk: this user may not mount one";
  }
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

INSTANTIATE_TEST_SUITE_P(Formats, InterruptedRecording,
                         ::testing::Values(Storage::kSqlite, Storage::kMcap), [](const auto& test) {
                           return std::string(storage_identifier(test.param));
                         });

}  // namespace
}  // namespace pipescout::bags
