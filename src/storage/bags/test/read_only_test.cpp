// SPDX-License-Identifier: Apache-2.0
// Reading a bag leaves its folder as it was, byte by byte, whatever state its files are in.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sqlite3.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "pipescout/bags/bag_maintenance.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "sqlite_database.hpp"
#include "test_bag.hpp"

namespace pipescout::bags {
namespace {

using ::testing::IsEmpty;
namespace fs = std::filesystem;

/// How a database was left by its writer.
enum class Left {
  kClosed,         ///< journal_mode=DELETE, nothing beside it
  kHotJournal,     ///< killed within a commit
  kWal,            ///< killed in WAL mode: -wal and -shm beside it
  kWalWithoutShm,  ///< the same, copied without the -shm
  kClosedWal,      ///< in WAL mode, closed
  kWriting         ///< in WAL mode, its writer lives and has the file open
};

std::string name_of(Left left) {
  switch (left) {
    case Left::kClosed:
      return "Closed";
    case Left::kHotJournal:
      return "HotJournal";
    case Left::kWal:
      return "Wal";
    case Left::kWalWithoutShm:
      return "WalWithoutShm";
    case Left::kClosedWal:
      return "ClosedWal";
    case Left::kWriting:
      break;
  }
  return "Writing";
}

class ReadOnly : public ::testing::TestWithParam<Left> {
 protected:
  void SetUp() override {
    BagWriter writer(bag_, {});
    for (const auto& message : stored_) {
      testing::write(writer, message);
    }
    writer.close();
  }
  void TearDown() override { end_writer(); }

  /// Opens the file as a writer that adds messages, and is then killed, closes it or stays.
  void leave(Left left) {
    if (left == Left::kClosed) {
      return;
    }
    int ready[2];
    ASSERT_EQ(::pipe(ready), 0);
    writer_ = ::fork();
    ASSERT_GE(writer_, 0);
    if (writer_ == 0) {
      const char done = write_and_stay(left) ? 'y' : 'n';
      (void)!::write(ready[1], &done, 1);
      ::pause();
      ::_exit(0);
    }
    char done = 'n';
    ASSERT_EQ(::read(ready[0], &done, 1), 1);
    ::close(ready[0]);
    ::close(ready[1]);
    ASSERT_EQ(done, 'y');
    if (left != Left::kWriting) {
      end_writer();
    }
    if (left == Left::kWalWithoutShm) {
      fs::remove(file_.string() + "-shm");
    }
  }

  /// In the child: leaves the file open.
  bool write_and_stay(Left left) const {
    sqlite3* database = nullptr;
    const auto run = [&](const char* sql) {
      return sqlite3_exec(database, sql, nullptr, nullptr, nullptr) == SQLITE_OK;
    };
    const char* kAdd =
        "INSERT INTO messages(topic_id, timestamp, data) SELECT topic_id, timestamp + "
        "1000000000, data FROM messages";
    if (sqlite3_open(file_.c_str(), &database) != SQLITE_OK) {
      return false;
    }
    if (left == Left::kHotJournal) {
      // A transaction whose pages no longer fit the cache is in the file before it is committed.
      return run("PRAGMA journal_mode=DELETE") && run("PRAGMA cache_size=1") && run("BEGIN") &&
             run(kAdd);
    }
    const bool wal = run("PRAGMA journal_mode=WAL") && run(kAdd);
    return left == Left::kClosedWal ? wal && sqlite3_close(database) == SQLITE_OK : wal;
  }

  void end_writer() {
    if (writer_ > 0) {
      ::kill(writer_, SIGKILL);
      ::waitpid(writer_, nullptr, 0);
      writer_ = 0;
    }
  }

  /// Names, content and times of change of all that is in the folder.
  [[nodiscard]] std::map<std::string, std::string> state() const {
    std::map<std::string, std::string> result;
    for (const auto& entry : fs::directory_iterator(bag_)) {
      std::ifstream file(entry.path(), std::ios::binary);
      result[entry.path().filename().string()] =
          std::string(std::istreambuf_iterator<char>(file), {}) +
          std::to_string(fs::last_write_time(entry.path()).time_since_epoch().count());
    }
    return result;
  }

  [[nodiscard]] std::size_t expected() const {
    const bool added = GetParam() != Left::kClosed && GetParam() != Left::kHotJournal;
    return stored_.size() * (added ? 2 : 1);
  }

  pipescout::testing::TemporaryFolder folder_;
  fs::path bag_ = folder_.path() / "mission 1%";  // a name that a URI must encode
  fs::path file_ = bag_ / "mission 1%_0.db3";
  std::vector<testing::Stored> stored_ = testing::messages(200, 2000);
  pid_t writer_ = 0;
};

TEST_P(ReadOnly, ReadingChangesNothing) {
  leave(GetParam());
  const auto before = state();
  const fs::path journal = file_.string() + "-journal";
  EXPECT_EQ(fs::exists(journal) && fs::file_size(journal) > 0, GetParam() == Left::kHotJournal);
  for (const fs::path& what : {bag_, file_}) {
    BagReader reader(what);
    EXPECT_EQ(testing::read(reader).size(), expected());
    reader.seek(stored_[100].log_time);
    EXPECT_TRUE(reader.next());
  }
  (void)check_bag(bag_);
  (void)recover_bag(bag_, folder_.path() / "recovered", {});
  EXPECT_EQ(state(), before);
}

TEST_P(ReadOnly, MediaThatCannotBeWrittenAreRead) {
  leave(GetParam());
  constexpr int kNotPossible = 77;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    if (::unshare(CLONE_NEWNS) != 0 ||
        ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        ::mount(bag_.c_str(), bag_.c_str(), nullptr, MS_BIND, nullptr) != 0 ||
        ::mount(nullptr, bag_.c_str(), nullptr, MS_REMOUNT | MS_BIND | MS_RDONLY, nullptr) != 0) {
      ::_exit(kNotPossible);
    }
    std::size_t count = 0;
    try {
      count = testing::read(bag_).size();
    } catch (const BagError& error) {
      (void)!::write(STDERR_FILENO, error.what(), std::strlen(error.what()));
    }
    ::_exit(count == expected() ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNotPossible) {
    GTEST_SKIP() << "NOT TESTED on read-only media: this user may not mount one";
  }
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

INSTANTIATE_TEST_SUITE_P(States, ReadOnly,
                         ::testing::Values(Left::kClosed, Left::kHotJournal, Left::kWal,
                                           Left::kWalWithoutShm, Left::kClosedWal, Left::kWriting),
                         [](const auto& test) { return name_of(test.param); });

}  // namespace
}  // namespace pipescout::bags
