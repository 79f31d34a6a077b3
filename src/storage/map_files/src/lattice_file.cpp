// SPDX-License-Identifier: Apache-2.0
#include "pipescout/map_files/lattice_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "map_text.hpp"
#include "pipescout/files/whole_file.hpp"

namespace pipescout {
namespace {

using navigation::LatticePrimitives;
using navigation::MotionPrimitive;
using navigation::Pose2d;
using nlohmann::json;

constexpr double kSameHeading = 1e-3;  // rad

class LatticeReader {
 public:
  explicit LatticeReader(const std::filesystem::path& path) : path_(path.string()) {}

  LatticePrimitives read(const json& root) {
    const json& metadata = field(root, "lattice_metadata", "");
    lattice_.turning_radius = number(metadata, "turning_radius", "lattice_metadata");
    lattice_.spacing = number(metadata, "grid_resolution", "lattice_metadata");
    if (lattice_.spacing <= 0) {
      fail("lattice_metadata", "grid_resolution must be above 0");
    }
    const json& headings = field(metadata, "heading_angles", "lattice_metadata");
    if (!headings.is_array() || headings.empty()) {
      fail("lattice_metadata", "heading_angles must be a list of numbers");
    }
    for (const json& heading : headings) {
      if (!heading.is_number()) {
        fail("lattice_metadata", "heading_angles must be a list of numbers");
      }
      lattice_.headings.push_back(heading.get<double>());
    }
    const json& primitives = field(root, "primitives", "");
    if (!primitives.is_array()) {
      fail("", "primitives must be a list");
    }
    for (const json& primitive : primitives) {
      add(primitive);
    }
    try {
      lattice_.validate();
    } catch (const std::invalid_argument& error) {
      fail("", error.what());
    }
    return std::move(lattice_);
  }

 private:
  [[noreturn]] void fail(const std::string& where, const std::string& message) const {
    throw MapFileError(path_ + ": " + (where.empty() ? "" : where + ": ") + message);
  }

  [[nodiscard]] const json& field(const json& of, const char* key, const std::string& where) const {
    const auto found = of.is_object() ? of.find(key) : of.end();
    if (found == of.end()) {
      fail(where, std::string(key) + " is missing");
    }
    return *found;
  }

  [[nodiscard]] double number(const json& of, const char* key, const std::string& where) const {
    const json& value = field(of, key, where);
    if (!value.is_number()) {
      fail(where, std::string(key) + " must be a number");
    }
    return value.get<double>();
  }

  [[nodiscard]] int heading(const json& of, const char* key, const std::string& where) const {
    const json& value = field(of, key, where);
    if (!value.is_number_integer() || value.get<std::int64_t>() < 0 ||
        value.get<std::int64_t>() >= static_cast<std::int64_t>(lattice_.headings.size())) {
      fail(where, std::string(key) + " must be a position in heading_angles");
    }
    return value.get<int>();
  }

  [[nodiscard]] Pose2d pose(const json& value, const std::string& where) const {
    if (!value.is_array() || value.size() != 3 ||
        !std::all_of(value.begin(), value.end(), [](const json& x) { return x.is_number(); })) {
      fail(where, "poses must be lists of x, y, yaw");
    }
    return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
  }

  void add(const json& value) {
    constexpr double kFarthest = 1e6;  // spacings
    const std::string where =
        "primitive " +
        std::to_string(static_cast<std::int64_t>(number(
            value, "trajectory_id", "primitive " + std::to_string(lattice_.primitives.size()))));
    MotionPrimitive primitive;
    primitive.id = static_cast<std::int64_t>(number(value, "trajectory_id", where));
    primitive.start_heading = heading(value, "start_angle_index", where);
    primitive.end_heading = heading(value, "end_angle_index", where);
    const json& list = field(value, "poses", where);
    if (!list.is_array() || list.empty()) {
      fail(where, "poses must be a list of x, y, yaw");
    }
    const Pose2d end = pose(list.back(), where);
    const double from = lattice_.headings[static_cast<std::size_t>(primitive.start_heading)];
    const double to = lattice_.headings[static_cast<std::size_t>(primitive.end_heading)];
    if (!(std::abs(end.x) < kFarthest * lattice_.spacing &&
          std::abs(end.y) < kFarthest * lattice_.spacing)) {
      fail(where, "poses end too far away");
    }
    if (!(std::abs(navigation::wrap_angle(end.heading - to)) < kSameHeading)) {
      fail(where, "poses end at a heading of " + map_number(end.heading) +
                      " rad; end_angle_index says " + map_number(to));
    }
    primitive.columns = static_cast<int>(std::lround(end.x / lattice_.spacing));
    primitive.rows = static_cast<int>(std::lround(end.y / lattice_.spacing));
    primitive.pieces = navigation::straight_arc_straight(
        from, to, {primitive.columns * lattice_.spacing, primitive.rows * lattice_.spacing});
    if (primitive.pieces.empty()) {
      fail(where, "poses end where no arc forwards leads with these headings");
    }
    check_poses(primitive, list, where);
    lattice_.primitives.push_back(std::move(primitive));
  }

  void check_poses(const MotionPrimitive& primitive, const json& list,
                   const std::string& where) const {
    const auto arcs = lattice_.poses(primitive, lattice_.spacing / 4);
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Pose2d given = pose(list[i], where);
      double off = std::numeric_limits<double>::infinity();
      double turned = 0;
      for (const Pose2d& candidate : arcs) {
        if (distance(candidate, given) < off) {
          off = distance(candidate, given);
          turned = std::abs(navigation::wrap_angle(candidate.heading - given.heading));
        }
      }
      if (!(off <= lattice_.spacing) || !(turned < std::numbers::pi / 4)) {
        fail(where, "pose " + std::to_string(i) + " is not on the way forwards from start to end");
      }
    }
  }

  std::string path_;
  LatticePrimitives lattice_;
};

}  // namespace

navigation::LatticePrimitives read_lattice(const std::filesystem::path& path) {
  return LatticeReader(path).read(map_json_of(path));
}

void write_lattice(const std::filesystem::path& path,
                   const navigation::LatticePrimitives& lattice) {
  json primitives = json::array();
  for (const MotionPrimitive& primitive : lattice.primitives) {
    json poses = json::array();
    double turn = 0;
    for (const auto& piece : primitive.pieces) {
      turn += piece.curvature * piece.length;
    }
    const auto all = lattice.poses(primitive, lattice.spacing);
    for (std::size_t i = 1; i < all.size(); ++i) {
      const double heading = all[i].heading;
      poses.push_back(json::array(
          {all[i].x, all[i].y, heading < 0 ? heading + 2 * std::numbers::pi : heading}));
    }
    primitives.push_back({{"trajectory_id", primitive.id},
                          {"start_angle_index", primitive.start_heading},
                          {"end_angle_index", primitive.end_heading},
                          {"left_turn", turn >= 0},
                          {"trajectory_radius", primitive.radius()},
                          {"trajectory_length", primitive.length()},
                          {"arc_length", primitive.arc_length()},
                          {"straight_length", primitive.length() - primitive.arc_length()},
                          {"poses", std::move(poses)}});
  }
  const json root{{"version", 1.0},
                  {"lattice_metadata",
                   {{"motion_model", "ackermann"},
                    {"turning_radius", lattice.turning_radius},
                    {"grid_resolution", lattice.spacing},
                    {"num_of_headings", lattice.headings.size()},
                    {"heading_angles", lattice.headings},
                    {"number_of_trajectories", lattice.primitives.size()}}},
                  {"primitives", std::move(primitives)}};
  replace_file(path, root.dump(1, '\t') + "\n");
}

}  // namespace pipescout
