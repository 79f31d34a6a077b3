// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_file/rack_file.hpp"

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "pipescout/files/yaml_location.hpp"

namespace pipescout {
namespace {

using rack_vision::InvalidRack;
using rack_vision::Pipe;
using rack_vision::RackModel;
using rack_vision::RadiusAt;
using rack_vision::RowPipe;
using rack_vision::ShapeDeviation;
using rack_vision::Support;

class RackReader {
 public:
  RackReader(const YAML::Node& root, const std::string& path) : root_(root), path_(path) {}

  RackModel read() {
    check_fields(root_, "a rack", {"row", "pipes", "vessels", "supports"});
    RackModel model;
    try {
      for (const YAML::Node& entry : list(root_, "row")) {
        add_to_row(entry);
      }
      model.pipes = rack_vision::row_of_pipes(row_);
      for (std::size_t i = 0; i < model.pipes.size(); ++i) {
        model.pipes[i].movable = row_movable_[i];
        model.pipes[i].shape_deviation = row_deviations_[i];
      }
      for (const YAML::Node& entry : list(root_, "pipes")) {
        model.pipes.push_back(pipe(entry, model.pipes.empty()));
      }
      for (const YAML::Node& entry : list(root_, "vessels")) {
        model.pipes.push_back(vessel(entry));
      }
      for (const YAML::Node& entry : list(root_, "supports")) {
        model.supports.push_back(support(entry));
      }
      model.validate();
    } catch (const InvalidRack& error) {
      throw YamlError(path_, place_of(error), error.what());
    }
    return model;
  }

 private:
  [[noreturn]] void fail(const YAML::Node& node, const std::string& message) const {
    throw YamlError(path_, node.Mark(), message);
  }

  [[nodiscard]] YAML::Mark place_of(const InvalidRack& error) const {
    switch (error.part()) {
      case InvalidRack::Part::kPipe:
        return pipe_marks_.at(error.index());
      case InvalidRack::Part::kSupport:
        return support_marks_.at(error.index());
      case InvalidRack::Part::kRack:
        break;
    }
    return root_.Mark();
  }

  void check_fields(const YAML::Node& node, const std::string& what,
                    std::initializer_list<std::string_view> known) const {
    if (!node.IsMap()) {
      fail(node, what + " must be a map of fields");
    }
    for (const auto& entry : node) {
      const std::string& key = entry.first.Scalar();
      std::string names;
      bool is_known = false;
      for (const std::string_view name : known) {
        is_known = is_known || name == key;
        names += (names.empty() ? "" : ", ") + std::string(name);
      }
      if (!is_known) {
        fail(entry.first, "unknown field '" + key + "' of " + what + " (known: " + names + ")");
      }
    }
  }

  [[nodiscard]] YAML::Node field(const YAML::Node& node, const std::string& key) const {
    const YAML::Node value = node[key];
    if (!value) {
      fail(node, "field '" + key + "' is missing");
    }
    return value;
  }

  /// Empty when the field is missing.
  [[nodiscard]] std::vector<YAML::Node> list(const YAML::Node& node, const std::string& key) const {
    const YAML::Node value = node[key];
    if (!value) {
      return {};
    }
    if (!value.IsSequence()) {
      fail(value, key + " must be a list");
    }
    return {value.begin(), value.end()};
  }

  [[nodiscard]] std::string text(const YAML::Node& node, const std::string& key) const {
    const YAML::Node value = field(node, key);
    if (!value.IsScalar() || value.Scalar().empty()) {
      fail(value, key + " must be a text");
    }
    return value.Scalar();
  }

  /// A finite number; quoted ones are texts.
  [[nodiscard]] double number(const YAML::Node& value, const std::string& what) const {
    const std::string& scalar = value.IsScalar() && value.Tag() != "!" ? value.Scalar() : kNone;
    double result = 0;
    const char* end = scalar.data() + scalar.size();
    const auto [stop, error] = std::from_chars(scalar.data(), end, result);
    if (scalar.empty() || error != std::errc() || stop != end || !std::isfinite(result)) {
      fail(value, what + " must be a finite number" +
                      (value.IsScalar() ? ", not '" + value.Scalar() + "'" : ""));
    }
    return result;
  }

  [[nodiscard]] double number_or_zero(const YAML::Node& node, const char* key) const {
    const YAML::Node value = node[key];
    return value ? number(value, key) : 0;
  }

  [[nodiscard]] double length(const YAML::Node& node, const std::string& key,
                              bool may_be_zero) const {
    const YAML::Node value = field(node, key);
    const double result = number(value, key);
    if (result < 0 || (result == 0 && !may_be_zero)) {
      fail(value, key + " is " + value.Scalar() + "; it must be " +
                      (may_be_zero ? "at least 0 m" : "above 0 m"));
    }
    return result;
  }

  [[nodiscard]] Eigen::Vector3d vector(const YAML::Node& node, const std::string& key) const {
    const YAML::Node value = field(node, key);
    if (!value.IsSequence() || value.size() != 3) {
      fail(value, key + " must be a list of 3 numbers");
    }
    return {number(value[0], key), number(value[1], key), number(value[2], key)};
  }

  [[nodiscard]] bool boolean(const YAML::Node& node, const std::string& key, bool missing) const {
    const YAML::Node value = node[key];
    if (!value) {
      return missing;
    }
    if (!value.IsScalar() || (value.Scalar() != "true" && value.Scalar() != "false")) {
      fail(value, key + " must be true or false");
    }
    return value.Scalar() == "true";
  }

  /// Either `radius` and `length`, or `radii`.
  [[nodiscard]] std::vector<RadiusAt> radii(const YAML::Node& node) const {
    if (!node["radii"]) {
      if (!node["radius"]) {
        fail(node, "field 'radius', with 'length', or 'radii' is missing");
      }
      const double radius = length(node, "radius", false);
      return {{0, radius}, {length(node, "length", false), radius}};
    }
    for (const char* key : {"radius", "length"}) {
      if (node[key]) {
        fail(node[key], std::string(key) + " and radii exclude each other");
      }
    }
    std::vector<RadiusAt> result;
    for (const YAML::Node& entry : list(node, "radii")) {
      check_fields(entry, "an entry of radii", {"along", "radius"});
      result.push_back({length(entry, "along", true), length(entry, "radius", false)});
    }
    return result;
  }

  void add_to_row(const YAML::Node& node) {
    check_fields(node, "a pipe of the row",
                 {"name", "radius", "length", "radii", "gap", "movable", kHeightDeviation,
                  kDirectionDeviation, kRadiusDeviation});
    pipe_marks_.push_back(node.Mark());
    RowPipe entry{.name = text(node, "name"), .radii = radii(node)};
    if (node["gap"]) {
      if (row_.empty()) {
        fail(node["gap"], "the first pipe of the row has no gap, because no pipe precedes it");
      }
      entry.gap = length(node, "gap", true);
    }
    row_movable_.push_back(boolean(node, "movable", !row_.empty()));
    row_deviations_.push_back(shape_deviation(node));
    row_.push_back(std::move(entry));
  }

  [[nodiscard]] Pipe pipe(const YAML::Node& node, bool is_first) {
    check_fields(node, "a pipe",
                 {"name", "start", "direction", "radius", "length", "radii", "movable",
                  kHeightDeviation, kDirectionDeviation, kRadiusDeviation});
    Pipe result = body(node);
    const bool is_along_x = std::abs(result.direction.x()) > kAlongX;
    result.movable = boolean(node, "movable", !is_first && !is_along_x);
    return result;
  }

  [[nodiscard]] Pipe vessel(const YAML::Node& node) {
    check_fields(node, "a vessel",
                 {"name", "start", "direction", "radius", "length", "radii", kHeightDeviation,
                  kDirectionDeviation, kRadiusDeviation});
    Pipe result = body(node);
    result.movable = false;
    return result;
  }

  [[nodiscard]] Pipe body(const YAML::Node& node) {
    pipe_marks_.push_back(node.Mark());
    Pipe result{.name = text(node, "name"), .start = vector(node, "start"), .radii = radii(node)};
    const Eigen::Vector3d direction = vector(node, "direction");
    const double norm = direction.stableNorm();
    if (!(norm > 0) || !std::isfinite(norm)) {
      fail(node["direction"], "direction must not be zero");
    }
    result.direction = direction / norm;
    result.shape_deviation = shape_deviation(node);
    return result;
  }

  /// Signs and limits are the model's to check, which knows the pipe.
  [[nodiscard]] ShapeDeviation shape_deviation(const YAML::Node& node) const {
    return {.height = number_or_zero(node, kHeightDeviation),
            .direction = number_or_zero(node, kDirectionDeviation),
            .radius = number_or_zero(node, kRadiusDeviation)};
  }

  [[nodiscard]] Support support(const YAML::Node& node) {
    check_fields(node, "a support", {"name", "lowest_corner", "highest_corner"});
    support_marks_.push_back(node.Mark());
    return {text(node, "name"), vector(node, "lowest_corner"), vector(node, "highest_corner")};
  }

  static constexpr double kAlongX = 0.99;  ///< such pipes are left where they are unless told to
  inline static const std::string kNone;
  static constexpr const char* kHeightDeviation = "height_deviation";
  static constexpr const char* kDirectionDeviation = "direction_deviation";
  static constexpr const char* kRadiusDeviation = "radius_deviation";

  YAML::Node root_;
  const std::string& path_;
  std::vector<RowPipe> row_;
  std::vector<bool> row_movable_;
  std::vector<ShapeDeviation> row_deviations_;
  std::vector<YAML::Mark> pipe_marks_, support_marks_;
};

}  // namespace

rack_vision::RackModel read_rack(const std::string& path) {
  return RackReader(load_yaml(path), path).read();
}

rack_vision::RackModel parse_rack(const std::string& text, const std::string& path) {
  return RackReader(parse_yaml(text, path), path).read();
}

}  // namespace pipescout
