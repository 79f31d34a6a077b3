// SPDX-License-Identifier: Apache-2.0
// What it costs to write a bag. The peer is what rosbag2 does at its fastest: prepared inserts into
// SQLite without a journal on the disk, a transaction for each 10 MiB, and a page cache of that
// size. Times are those of the writing thread's processor: what the disk does later is the same for
// all.
#include <benchmark/benchmark.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "figures.hpp"
#include "pipescout/bags/bag_writer.hpp"
#include "program.hpp"
#include "samples.hpp"

namespace pipescout::benchmarks {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMcap = "MCAP with CRC";
constexpr const char* kMcapWithoutCrc = "MCAP without CRC";
constexpr const char* kSqlite = "SQLite bag";
constexpr const char* kPlain = "plain inserts into SQLite";
constexpr const char* kLz4 = "MCAP with CRC, LZ4";
constexpr std::size_t kTopics = 22;

struct Message {
  bags::TopicIndex topic = 0;
  std::size_t size = 0;
};

/// One second of a robot: 20 topics of 100 to 2,000 bytes at 200 Hz, thermal images of 640x512 at
/// 60 Hz, colour images of 6 MB at 10 Hz.
std::vector<Message> messages() {
  std::mt19937 random(1);
  std::vector<Message> result;
  constexpr std::size_t kTicks = 200;
  for (std::size_t tick = 0; tick < kTicks; ++tick) {
    for (bags::TopicIndex topic = 0; topic < 20; ++topic) {
      result.push_back({topic, 100 + random() % 1900});
    }
    if (tick * 60 / kTicks != (tick + 1) * 60 / kTicks) {
      result.push_back({20, std::size_t{640} * 512 * 2});
    }
    if (tick % 20 == 0) {
      result.push_back({21, 6'000'000});
    }
  }
  return result;
}

const std::vector<Message>& input() {
  static const std::vector<Message> kInput = messages();
  return kInput;
}

double megabytes() {
  double bytes = 0.0;
  for (const Message& message : input()) {
    bytes += static_cast<double>(message.size);
  }
  return bytes / 1e6;
}

std::span<const std::byte> content(std::size_t size) {
  static const std::vector<std::byte> kContent = [] {
    std::mt19937 random(2);
    std::vector<std::byte> bytes(6'000'000);
    for (std::byte& each : bytes) {
      // Half of the bits are noise, as in the images of a camera.
      each = static_cast<std::byte>(random() & 0x0FU);
    }
    return bytes;
  }();
  return std::span(kContent).first(size);
}

fs::path new_folder() {
  static int count = 0;
  return fs::temp_directory_path() /
         ("pipescout_recording_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
}

void write_bag(const fs::path& folder, const bags::BagWriterOptions& options) {
  bags::BagWriter writer(folder, options);
  for (std::size_t topic = 0; topic < kTopics; ++topic) {
    writer.add_topic({.name = "/topic" + std::to_string(topic), .type = "std_msgs/msg/String"});
  }
  std::int64_t time = 0;
  for (const Message& message : input()) {
    time += 250'000;
    writer.write({.topic = message.topic,
                  .log_time = time,
                  .publish_time = time,
                  .data = content(message.size)});
  }
  writer.close();
}

class PlainSqlite {
 public:
  explicit PlainSqlite(const fs::path& path) {
    check(sqlite3_open(path.c_str(), &database_));
    execute("PRAGMA journal_mode = MEMORY");
    execute("PRAGMA synchronous = OFF");
    execute("PRAGMA cache_size = -10240");
    execute(
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, "
        "timestamp INTEGER NOT NULL, data BLOB NOT NULL)");
    execute("CREATE INDEX timestamp_idx ON messages (timestamp ASC)");
    check(sqlite3_prepare_v2(database_,
                             "INSERT INTO messages (timestamp, topic_id, data) VALUES (?, ?, ?)",
                             -1, &insert_, nullptr));
    execute("BEGIN");
  }
  ~PlainSqlite() {
    sqlite3_finalize(insert_);
    sqlite3_close(database_);
  }
  PlainSqlite(const PlainSqlite&) = delete;
  PlainSqlite& operator=(const PlainSqlite&) = delete;

  void insert(std::int64_t time, const Message& message) {
    const auto data = content(message.size);
    sqlite3_bind_int64(insert_, 1, time);
    sqlite3_bind_int64(insert_, 2, message.topic);
    sqlite3_bind_blob64(insert_, 3, data.data(), data.size(), SQLITE_STATIC);
    if (sqlite3_step(insert_) != SQLITE_DONE) {
      throw std::runtime_error(sqlite3_errmsg(database_));
    }
    sqlite3_reset(insert_);
    constexpr std::size_t kTransaction = std::size_t{10} * 1024 * 1024;
    pending_ += data.size();
    if (pending_ >= kTransaction) {
      execute("COMMIT");
      execute("BEGIN");
      pending_ = 0;
    }
  }
  void close() { execute("COMMIT"); }

 private:
  void check(int result) const {
    if (result != SQLITE_OK) {
      throw std::runtime_error(sqlite3_errmsg(database_));
    }
  }
  void execute(const char* sql) const {
    check(sqlite3_exec(database_, sql, nullptr, nullptr, nullptr));
  }

  sqlite3* database_ = nullptr;
  sqlite3_stmt* insert_ = nullptr;
  std::size_t pending_ = 0;
};

void write_plain(const fs::path& folder) {
  fs::create_directory(folder);
  PlainSqlite database(folder / "plain.db3");
  std::int64_t time = 0;
  for (const Message& message : input()) {
    time += 250'000;
    database.insert(time, message);
  }
  database.close();
}

template <class Write>
void add_case(const char* name, Write write) {
  benchmark::RegisterBenchmark(name,
                               [=](benchmark::State& state) {
                                 for (auto _ : state) {
                                   const fs::path folder = new_folder();
                                   const auto start = thread_cpu_nanoseconds();
                                   write(folder);
                                   const auto took =
                                       static_cast<double>(thread_cpu_nanoseconds() - start);
                                   state.SetIterationTime(took * 1e-9);
                                   all_samples()[name].add(took * 1e-3);
                                   fs::remove_all(folder);
                                 }
                               })
      ->UseManualTime()
      ->Iterations(1)
      ->Unit(benchmark::kMillisecond);
}

void register_cases() {
  using bags::Storage;
  (void)content(1);
  const auto bag = [](const bags::BagWriterOptions& options) {
    return [options](const fs::path& folder) { write_bag(folder, options); };
  };
  add_case(kMcap, bag({.storage = Storage::kMcap}));
  add_case(kMcapWithoutCrc, bag({.storage = Storage::kMcap, .checksums = false}));
  add_case(kSqlite, bag({.storage = Storage::kSqlite}));
  add_case(kPlain, write_plain);
  add_case(kLz4,
           bag({.storage = Storage::kMcap, .chunk_compression = bags::ChunkCompression::kLz4}));
}

/// MB/s of the writing thread's time.
double rate(const char* name) {
  return megabytes() / (all_samples()[name].median() * 1e-6);
}

Figures evaluate() {
  using Bound = Figures::Bound;
  Figures figures;
  for (const char* name : {kMcap, kMcapWithoutCrc, kSqlite, kPlain, kLz4}) {
    const Samples& samples = all_samples()[name];
    figures.add_row({{"case", name},
                     {"median_us", samples.median()},
                     {"p99_us", samples.quantile(0.99)},
                     {"mb_per_s", rate(name)},
                     {"samples", samples.size()}});
  }
  figures.add("record_mcap_mb_per_s", rate(kMcap));
  figures.add("record_mcap_vs_sqlite", rate(kMcap) / rate(kPlain), Bound::kAtLeast, 3.0);
  figures.add("record_sqlite_vs_plain", rate(kSqlite) / rate(kPlain), Bound::kAtLeast, 0.8);
  figures.add("crc_cost_percent", (rate(kMcapWithoutCrc) / rate(kMcap) - 1.0) * 100.0,
              Bound::kAtMost, 10.0);
  return figures;
}

}  // namespace
}  // namespace pipescout::benchmarks

int main(int argc, char** argv) {
  return pipescout::benchmarks::run_program(argc, argv, pipescout::benchmarks::register_cases,
                                            pipescout::benchmarks::evaluate);
}
