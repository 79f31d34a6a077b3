// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_store/leak_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>

#include "example_findings.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;
using leak_findings::Finding;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

class Store : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("leak_store_" + std::to_string(::getpid()) + "_" + test->name());
    fs::create_directories(folder_);
    file_ = folder_ / "leaks.sqlite";
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Runs SQL as another program would.
  void sql(const char* text) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(::sqlite3_open(file_.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(::sqlite3_exec(database, text, nullptr, nullptr, nullptr), SQLITE_OK)
        << ::sqlite3_errmsg(database);
    ::sqlite3_close(database);
  }
  auto refuses(const char* why) const {
    EXPECT_THAT([this] { LeakStore store(file_); },
                ThrowsMessage<LeakStoreError>(AllOf(StartsWith(file_.string()), HasSubstr(why))));
  }

  fs::path folder_;
  fs::path file_;
};

void expect_same(double a, double b) {
  EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << a << " and " << b;
}

void expect_same(const std::optional<leak_findings::MapPosition>& a,
                 const std::optional<leak_findings::MapPosition>& b) {
  ASSERT_EQ(a.has_value(), b.has_value());
  if (a) {
    EXPECT_EQ(a->point, b->point);
    EXPECT_EQ(a->covariance, b->covariance);
    EXPECT_EQ(a->direction, b->direction);
  }
}

void expect_same(const Finding& a, const Finding& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.severity, b.severity);
  EXPECT_EQ(a.frames, b.frames);
  EXPECT_EQ(a.pass_count, b.pass_count);
  EXPECT_EQ(a.best.frame, b.best.frame);
  EXPECT_EQ(a.best.start, b.best.start);
  EXPECT_EQ(a.best.end, b.best.end);
  const auto numbers = [](const Finding& f) {
    return std::vector<double>{f.probability,
                               f.first_time,
                               f.last_time,
                               f.mean_delta,
                               f.mean_delta_interval.low,
                               f.mean_delta_interval.high,
                               f.peak_delta,
                               f.peak_delta_interval.low,
                               f.peak_delta_interval.high,
                               f.length,
                               f.length_deviation,
                               f.delta_growth,
                               f.length_growth,
                               f.best.time,
                               f.best.half_width,
                               f.best.score};
  };
  for (std::size_t i = 0; i < numbers(a).size(); ++i) {
    expect_same(numbers(a)[i], numbers(b)[i]);
  }
  expect_same(a.position, b.position);
  ASSERT_EQ(a.passes.size(), b.passes.size());
  for (std::size_t i = 0; i < a.passes.size(); ++i) {
    EXPECT_EQ(a.passes[i].frames, b.passes[i].frames);
    expect_same(a.passes[i].time, b.passes[i].time);
    expect_same(a.passes[i].delta, b.passes[i].delta);
    expect_same(a.passes[i].delta_deviation, b.passes[i].delta_deviation);
    expect_same(a.passes[i].peak_delta, b.passes[i].peak_delta);
    expect_same(a.passes[i].length, b.passes[i].length);
    expect_same(a.passes[i].length_deviation, b.passes[i].length_deviation);
    expect_same(a.passes[i].position, b.passes[i].position);
  }
}

TEST_F(Store, KeepsEveryFieldOverADay) {
  {
    LeakStore store(file_);
    store.save(test::example_finding(2));
    store.save(test::bare_finding(1));
  }
  const LeakStore store(file_);
  const auto findings = store.findings();
  ASSERT_EQ(findings.size(), 2U);
  expect_same(findings[0], test::bare_finding(1));
  expect_same(findings[1], test::example_finding(2));
  EXPECT_FALSE(store.evidence(1).has_value());
}

TEST_F(Store, ALaterStateTakesThePlaceOfTheEarlier) {
  LeakStore store(file_);
  const test::ExamplePicture picture;
  const Evidence evidence =
      make_evidence(picture.view(), picture.detections, 0, picture.parameters.profile, 12, "a.png");
  Finding finding = test::example_finding(1);
  store.save(finding, &evidence);
  finding.frames = 400;
  finding.passes.pop_back();
  finding.position.reset();
  store.save(finding);
  ASSERT_EQ(store.findings().size(), 1U);
  expect_same(store.findings()[0], finding);
  // What shows it is still there.
  ASSERT_TRUE(store.evidence(1).has_value());
}

TEST_F(Store, KeepsEvidence) {
  const test::ExamplePicture picture;
  const Evidence e = make_evidence(picture.view(), picture.detections, 0,
                                   picture.parameters.profile, 12.5, "folder/\xff\"b\".png");
  {
    LeakStore store(file_);
    store.save(test::example_finding(3), &e);
  }
  const auto read = LeakStore(file_).evidence(3);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->source, e.source);
  EXPECT_EQ(read->time, e.time);
  EXPECT_EQ(read->thumbnail.png, e.thumbnail.png);
  EXPECT_EQ(read->thumbnail.width, e.thumbnail.width);
  EXPECT_EQ(read->leak.start, e.leak.start);
  EXPECT_EQ(read->pipe.half_width, e.pipe.half_width);
  ASSERT_EQ(read->profile.size(), e.profile.size());
  for (std::size_t i = 0; i < e.profile.size(); ++i) {
    EXPECT_NEAR(read->profile[i], e.profile[i], 0.0051);
  }
  ASSERT_EQ(read->parts.size(), e.parts.size());
  EXPECT_EQ(read->parts[0].kind, e.parts[0].kind);
  EXPECT_EQ(read->leak_to, e.leak_to);
  EXPECT_EQ(read->split_delta, e.split_delta);
  EXPECT_EQ(read->metres_per_sample, e.metres_per_sample);
}

TEST_F(Store, TheLogGrowsWhenConditionsChange) {
  ConditionRecord record{.time = 1, .source = "day 1", .camera = "A20", .parameters = "e = 0.04"};
  {
    LeakStore store(file_);
    store.log(record);
    record.time = 2;
    store.log(record);  // as before
    record.weather = "rain";
    store.log(record);
  }
  const auto log = LeakStore(file_).conditions();
  ASSERT_EQ(log.size(), 2U);
  EXPECT_EQ(log[0].time, 1);
  EXPECT_EQ(log[1], record);
}

/// A process that saves findings 1, 2, ... and says so after each, until it is killed.
TEST_F(Store, NothingThatWasSavedIsLostOnAKill) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    LeakStore store(file_);
    for (std::uint64_t id = 1; id < 100000; ++id) {
      store.save(test::example_finding(id));
      if (::write(ends[1], &id, sizeof(id)) != sizeof(id)) {
        break;
      }
    }
    ::_exit(1);
  }
  ::close(ends[1]);
  std::uint64_t told = 0;
  while (told < 25) {
    ASSERT_EQ(::read(ends[0], &told, sizeof(told)), static_cast<ssize_t>(sizeof(told)));
  }
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  for (std::uint64_t id = 0; ::read(ends[0], &id, sizeof(id)) == sizeof(id);) {
    told = id;
  }
  ::close(ends[0]);
  const auto findings = LeakStore(file_).findings();
  ASSERT_GE(findings.size(), told);
  for (const Finding& finding : findings) {
    expect_same(finding, test::example_finding(finding.id));
  }
}

TEST_F(Store, IsReadWhileItIsWritten) {
  LeakStore writer(file_);
  writer.save(test::example_finding(1));
  const LeakStore reader(file_);
  writer.save(test::example_finding(2));
  EXPECT_EQ(reader.findings().size(), 2U);
}

TEST_F(Store, OtherFilesAreNotTouched) {
  std::ofstream(file_) << "no database, but quite a long text that is none either, for certain";
  refuses("not a database");
  fs::remove(file_);
  sql("CREATE TABLE accounts(x)");
  refuses("is not a database of findings");
  fs::remove(file_);
  { LeakStore store(file_); }
  sql("PRAGMA user_version=2");
  refuses("has version 2, later than 1");
  sql("PRAGMA user_version=1; PRAGMA application_id=5");
  refuses("is not a database of findings");
  EXPECT_THAT([] { LeakStore store("/nowhere/leaks.sqlite"); },
              ThrowsMessage<LeakStoreError>(StartsWith("/nowhere/leaks.sqlite: ")));
}

TEST_F(Store, DamageIsNamed) {
  {
    LeakStore store(file_);
    const test::ExamplePicture picture;
    const Evidence e = make_evidence(picture.view(), picture.detections, 0,
                                     picture.parameters.profile, 12.5, "b.png");
    store.save(test::example_finding(1), &e);
  }
  sql("UPDATE evidence SET details='{}'");
  EXPECT_THAT([this] { (void)LeakStore(file_).evidence(1); },
              ThrowsMessage<LeakStoreError>(HasSubstr("evidence of finding 1 cannot be read")));
  sql("UPDATE finding SET severity='dreadful'");
  EXPECT_THAT([this] { (void)LeakStore(file_).findings(); },
              ThrowsMessage<LeakStoreError>(HasSubstr("'dreadful' is unknown")));
}

}  // namespace
}  // namespace pipescout
