// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_store/leak_store.hpp"

#include <array>
#include <utility>

#include "evidence_text.hpp"
#include "sqlite.hpp"

namespace pipescout {
namespace {

using leak_findings::Finding;
using leak_findings::MapPosition;
using leak_findings::PassSummary;

// "leak" in ASCII: PRAGMA application_id, by which `file` tells such a store from others.
constexpr std::int64_t kApplicationId = 0x6c65616b;

constexpr const char* kSchema = R"(
CREATE TABLE finding(
  id INTEGER PRIMARY KEY, state TEXT NOT NULL, probability REAL, severity TEXT NOT NULL,
  first_time REAL, last_time REAL, frames INTEGER NOT NULL,
  mean_delta REAL, mean_delta_low REAL, mean_delta_high REAL,
  peak_delta REAL, peak_delta_low REAL, peak_delta_high REAL,
  length REAL, length_deviation REAL, delta_growth REAL, length_growth REAL,
  pass_count INTEGER NOT NULL,
  best_time REAL, best_frame INTEGER, best_start_u REAL, best_start_v REAL, best_end_u REAL,
  best_end_v REAL, best_half_width REAL, best_score REAL,
  x REAL, y REAL, z REAL, xx REAL, xy REAL, xz REAL, yy REAL, yz REAL, zz REAL,
  along_x REAL, along_y REAL, along_z REAL);
CREATE TABLE pass(
  finding INTEGER NOT NULL REFERENCES finding(id), number INTEGER NOT NULL, time REAL,
  frames INTEGER NOT NULL, delta REAL, delta_deviation REAL, peak_delta REAL, length REAL,
  length_deviation REAL,
  x REAL, y REAL, z REAL, xx REAL, xy REAL, xz REAL, yy REAL, yz REAL, zz REAL,
  along_x REAL, along_y REAL, along_z REAL,
  PRIMARY KEY(finding, number)) WITHOUT ROWID;
CREATE TABLE evidence(
  finding INTEGER PRIMARY KEY REFERENCES finding(id), time REAL, source TEXT NOT NULL,
  thumbnail BLOB NOT NULL, details TEXT NOT NULL);
CREATE TABLE condition(
  number INTEGER PRIMARY KEY, time REAL, source TEXT NOT NULL, camera TEXT NOT NULL,
  parameters TEXT NOT NULL, weather TEXT NOT NULL, calibration TEXT NOT NULL,
  doubts TEXT NOT NULL);
)";

constexpr std::string_view kFindingColumns =
    "id, state, probability, severity, first_time, last_time, frames, mean_delta, mean_delta_low, "
    "mean_delta_high, peak_delta, peak_delta_low, peak_delta_high, length, length_deviation, "
    "delta_growth, length_growth, pass_count, best_time, best_frame, best_start_u, best_start_v, "
    "best_end_u, best_end_v, best_half_width, best_score, x, y, z, xx, xy, xz, yy, yz, zz, "
    "along_x, along_y, along_z";
constexpr int kFindingColumnCount = 38;
constexpr int kPassColumnCount = 21;

std::string insertion(const char* table, int columns) {
  std::string sql = std::string("INSERT OR REPLACE INTO ") + table + " VALUES(?";
  for (int i = 1; i < columns; ++i) {
    sql += ",?";
  }
  return sql + ")";
}

void bind_position(Statement& statement, const std::optional<MapPosition>& position) {
  // The whole of it is NULL where it is not known: NaN becomes that.
  const auto value = [&position](double known) {
    return position ? known : std::numeric_limits<double>::quiet_NaN();
  };
  const MapPosition p = position.value_or(MapPosition{});
  const Eigen::Matrix3d& c = p.covariance;
  for (const double number :
       {p.point.x(), p.point.y(), p.point.z(), c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2),
        p.direction.x(), p.direction.y(), p.direction.z()}) {
    statement.bind(value(number));
  }
}

std::optional<MapPosition> position_of(Statement& row) {
  std::array<double, 12> n{};
  bool known = true;
  for (double& number : n) {
    number = row.number();
    known = known && number == number;
  }
  if (!known) {
    return std::nullopt;
  }
  MapPosition p;
  p.point = {n[0], n[1], n[2]};
  p.covariance << n[3], n[4], n[5], n[4], n[6], n[7], n[5], n[7], n[8];
  p.direction = {n[9], n[10], n[11]};
  return p;
}

template <class Enumerator>
Enumerator named(const Database& database, const std::string& name, int count) {
  for (int i = 0; i < count; ++i) {
    if (to_string(static_cast<Enumerator>(i)) == name) {
      return static_cast<Enumerator>(i);
    }
  }
  database.fail("'" + name + "' is unknown");
}

void bind_finding(Statement& s, const Finding& f) {
  s.bind(static_cast<std::int64_t>(f.id)).bind(to_string(f.state)).bind(f.probability);
  s.bind(to_string(f.severity)).bind(f.first_time).bind(f.last_time);
  s.bind(static_cast<std::int64_t>(f.frames));
  s.bind(f.mean_delta).bind(f.mean_delta_interval.low).bind(f.mean_delta_interval.high);
  s.bind(f.peak_delta).bind(f.peak_delta_interval.low).bind(f.peak_delta_interval.high);
  s.bind(f.length).bind(f.length_deviation).bind(f.delta_growth).bind(f.length_growth);
  s.bind(static_cast<std::int64_t>(f.pass_count));
  s.bind(f.best.time).bind(static_cast<std::int64_t>(f.best.frame));
  s.bind(f.best.start.x()).bind(f.best.start.y()).bind(f.best.end.x()).bind(f.best.end.y());
  s.bind(f.best.half_width).bind(f.best.score);
  bind_position(s, f.position);
}

Finding finding_of(const Database& database, Statement& row) {
  Finding f;
  f.id = static_cast<std::uint64_t>(row.integer());
  f.state = named<leak_findings::FindingState>(database, row.text(), 3);
  f.probability = row.number();
  f.severity = named<thermal::Severity>(database, row.text(), 4);
  f.first_time = row.number();
  f.last_time = row.number();
  f.frames = static_cast<std::size_t>(row.integer());
  f.mean_delta = row.number();
  f.mean_delta_interval.low = row.number();
  f.mean_delta_interval.high = row.number();
  f.peak_delta = row.number();
  f.peak_delta_interval.low = row.number();
  f.peak_delta_interval.high = row.number();
  f.length = row.number();
  f.length_deviation = row.number();
  f.delta_growth = row.number();
  f.length_growth = row.number();
  f.pass_count = static_cast<std::size_t>(row.integer());
  f.best.time = row.number();
  f.best.frame = static_cast<std::uint64_t>(row.integer());
  f.best.start.x() = row.number();
  f.best.start.y() = row.number();
  f.best.end.x() = row.number();
  f.best.end.y() = row.number();
  f.best.half_width = row.number();
  f.best.score = row.number();
  f.position = position_of(row);
  return f;
}

PassSummary pass_of(Statement& row) {
  PassSummary pass;
  pass.time = row.number();
  pass.frames = static_cast<std::size_t>(row.integer());
  pass.delta = row.number();
  pass.delta_deviation = row.number();
  pass.peak_delta = row.number();
  pass.length = row.number();
  pass.length_deviation = row.number();
  pass.position = position_of(row);
  return pass;
}

std::int64_t pragma(const Database& database, const char* name) {
  Statement statement(database, std::string("PRAGMA ") + name);
  return statement.step() ? statement.integer() : 0;
}

}  // namespace

struct LeakStore::Implementation {
  explicit Implementation(const std::filesystem::path& file) : database(file) {
    const std::int64_t version = pragma(database, "user_version");
    if (version > kSchemaVersion) {
      database.fail("has version " + std::to_string(version) + ", later than " +
                    std::to_string(kSchemaVersion) + ", the last that is known here");
    }
    if (version != 0 && pragma(database, "application_id") != kApplicationId) {
      database.fail("is not a database of findings");
    }
    if (version == 0) {
      Statement tables(database, "SELECT count(*) FROM sqlite_master");
      if (tables.step() && tables.integer() != 0) {
        database.fail("is not a database of findings");
      }
    }
    // FULL: a commit waits for the disk, so that not even a power cut takes it back.
    database.execute("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON");
    if (version == 0) {
      create();
    }
  }

  void create() const {
    Transaction transaction(database);
    // Another process may have been faster.
    if (pragma(database, "user_version") == 0) {
      database.execute(kSchema);
      database.execute(("PRAGMA application_id=" + std::to_string(kApplicationId)).c_str());
      database.execute(("PRAGMA user_version=" + std::to_string(kSchemaVersion)).c_str());
    }
    transaction.commit();
  }

  Database database;
};

LeakStore::LeakStore(const std::filesystem::path& file)
    : implementation_(std::make_unique<Implementation>(file)) {}
LeakStore::~LeakStore() = default;
LeakStore::LeakStore(LeakStore&& other) noexcept = default;
LeakStore& LeakStore::operator=(LeakStore&& other) noexcept = default;

void LeakStore::save(const Finding& finding, const Evidence* evidence) {
  const Database& database = implementation_->database;
  const auto id = static_cast<std::int64_t>(finding.id);
  Transaction transaction(database);
  // The row is replaced, and passes and evidence refer to it: that is checked at the end.
  database.execute("PRAGMA defer_foreign_keys=ON");
  Statement row(database, insertion("finding", kFindingColumnCount));
  bind_finding(row, finding);
  row.run();
  Statement old(database, "DELETE FROM pass WHERE finding=?");
  old.bind(id).run();
  for (std::size_t i = 0; i < finding.passes.size(); ++i) {
    const PassSummary& pass = finding.passes[i];
    Statement line(database, insertion("pass", kPassColumnCount));
    line.bind(id).bind(static_cast<std::int64_t>(i)).bind(pass.time);
    line.bind(static_cast<std::int64_t>(pass.frames)).bind(pass.delta).bind(pass.delta_deviation);
    line.bind(pass.peak_delta).bind(pass.length).bind(pass.length_deviation);
    bind_position(line, pass.position);
    line.run();
  }
  if (evidence != nullptr) {
    Statement line(database, insertion("evidence", 5));
    line.bind(id).bind(evidence->time).bind(evidence->source);
    line.bind(std::span<const std::uint8_t>(evidence->thumbnail.png));
    line.bind(evidence_details(*evidence)).run();
  }
  transaction.commit();
}

void LeakStore::log(const ConditionRecord& record) {
  const Database& database = implementation_->database;
  Transaction transaction(database);
  Statement last(database,
                 "SELECT source, camera, parameters, weather, calibration, doubts FROM condition "
                 "ORDER BY number DESC LIMIT 1");
  if (last.step()) {
    ConditionRecord before;
    before.time = record.time;
    for (std::string* field : {&before.source, &before.camera, &before.parameters, &before.weather,
                               &before.calibration, &before.doubts}) {
      *field = last.text();
    }
    if (before == record) {
      return;
    }
  }
  Statement line(database, "INSERT INTO condition VALUES(NULL,?,?,?,?,?,?,?)");
  line.bind(record.time).bind(record.source).bind(record.camera).bind(record.parameters);
  line.bind(record.weather).bind(record.calibration).bind(record.doubts).run();
  transaction.commit();
}

std::vector<Finding> LeakStore::findings() const {
  const Database& database = implementation_->database;
  std::vector<Finding> findings;
  Statement rows(database, "SELECT " + std::string(kFindingColumns) + " FROM finding ORDER BY id");
  while (rows.step()) {
    Finding& finding = findings.emplace_back(finding_of(database, rows));
    Statement passes(database, "SELECT * FROM pass WHERE finding=? ORDER BY number");
    passes.bind(static_cast<std::int64_t>(finding.id));
    while (passes.step()) {
      (void)passes.integer();  // the finding
      (void)passes.integer();  // its number
      finding.passes.push_back(pass_of(passes));
    }
  }
  return findings;
}

std::optional<Evidence> LeakStore::evidence(std::uint64_t finding) const {
  const Database& database = implementation_->database;
  Statement row(database, "SELECT time, source, thumbnail, details FROM evidence WHERE finding=?");
  row.bind(static_cast<std::int64_t>(finding));
  if (!row.step()) {
    return std::nullopt;
  }
  Evidence evidence;
  evidence.time = row.number();
  evidence.source = row.text();
  evidence.thumbnail.png = row.blob();
  if (!read_evidence_details(row.text(), evidence)) {
    database.fail("the evidence of finding " + std::to_string(finding) + " cannot be read");
  }
  return evidence;
}

std::vector<ConditionRecord> LeakStore::conditions() const {
  std::vector<ConditionRecord> records;
  Statement rows(implementation_->database,
                 "SELECT time, source, camera, parameters, weather, calibration, doubts FROM "
                 "condition ORDER BY number");
  while (rows.step()) {
    ConditionRecord& record = records.emplace_back();
    record.time = rows.number();
    for (std::string* field : {&record.source, &record.camera, &record.parameters, &record.weather,
                               &record.calibration, &record.doubts}) {
      *field = rows.text();
    }
  }
  return records;
}

}  // namespace pipescout
