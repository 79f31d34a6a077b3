// SPDX-License-Identifier: Apache-2.0
#include "pipescout/map_files/route_graph_file.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "map_text.hpp"
#include "pipescout/files/whole_file.hpp"

namespace pipescout {
namespace {

using navigation::PipeSide;
using navigation::Point2d;
using navigation::RouteEdge;
using navigation::RouteGraph;
using navigation::RouteNode;
using nlohmann::json;

constexpr std::string_view kFurtherNotice = "further notice";
constexpr std::array<std::string_view, 4> kSides{"none", "left", "right", "both"};

class GraphReader {
 public:
  explicit GraphReader(const std::filesystem::path& path) : path_(path.string()) {}

  RouteGraph read(const json& root) {
    const json* features = find(root, "features");
    if (features == nullptr || !features->is_array()) {
      fail("", "features must be a list");
    }
    for (const json& feature : *features) {
      const std::string kind = kind_of(feature);
      if (kind == "Point") {
        add_node(feature);
      }
    }
    std::size_t count = 0;
    for (const json& feature : *features) {
      const std::string kind = kind_of(feature);
      if (kind == "LineString" || kind == "MultiLineString") {
        add_edge(feature, kind);
      } else if (kind != "Point") {
        fail("feature " + std::to_string(count),
             "its geometry must be a Point, a LineString or a MultiLineString");
      }
      ++count;
    }
    try {
      return {std::move(nodes_), std::move(edges_)};
    } catch (const std::invalid_argument& error) {
      throw MapFileError(path_ + ": " + error.what());
    }
  }

 private:
  [[noreturn]] void fail(const std::string& where, const std::string& message) const {
    throw MapFileError(path_ + ": " + (where.empty() ? "" : where + ": ") + message);
  }

  static const json* find(const json& object, const char* key) {
    if (!object.is_object()) {
      return nullptr;
    }
    const auto found = object.find(key);
    return found == object.end() || found->is_null() ? nullptr : &*found;
  }

  static std::string kind_of(const json& feature) {
    const json* geometry = find(feature, "geometry");
    const json* type = geometry == nullptr ? nullptr : find(*geometry, "type");
    return type != nullptr && type->is_string() ? type->get<std::string>() : "";
  }

  [[nodiscard]] const json& properties(const json& feature, const std::string& where) const {
    const json* found = find(feature, "properties");
    if (found == nullptr) {
      fail(where, "properties are missing");
    }
    return *found;
  }

  [[nodiscard]] std::int64_t id(const json& of, const char* key, const std::string& where) const {
    const json* value = find(of, key);
    if (value == nullptr || !value->is_number_integer()) {
      fail(where, std::string(key) + " must be a whole number");
    }
    return value->get<std::int64_t>();
  }

  [[nodiscard]] std::optional<double> number(const json& of, const char* key,
                                             const std::string& where) const {
    const json* value = find(of, key);
    if (value == nullptr) {
      return std::nullopt;
    }
    if (!value->is_number()) {
      fail(where, std::string(key) + " must be a number");
    }
    return value->get<double>();
  }

  [[nodiscard]] Point2d point(const json& value, const std::string& where) const {
    if (!value.is_array() || value.size() < 2 || !value[0].is_number() || !value[1].is_number()) {
      fail(where, "coordinates must be numbers x, y");
    }
    return {value[0].get<double>(), value[1].get<double>()};
  }

  [[nodiscard]] const json& coordinates(const json& feature, const std::string& where) const {
    const json* found = find(feature["geometry"], "coordinates");
    if (found == nullptr || !found->is_array()) {
      fail(where, "coordinates are missing");
    }
    return *found;
  }

  void add_node(const json& feature) {
    const std::string unnamed = "node " + std::to_string(nodes_.size() + 1) + " of the file";
    const json& values = properties(feature, unnamed);
    RouteNode node{.id = id(values, "id", unnamed)};
    const std::string where = "node " + std::to_string(node.id);
    node.position = point(coordinates(feature, where), where);
    if (const json* frame = find(values, "frame")) {
      if (!frame->is_string() || frame->get<std::string>().empty()) {
        fail(where, "frame must be a text");
      }
      node.frame = frame->get<std::string>();
    }
    positions_[node.id] = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back(std::move(node));
  }

  [[nodiscard]] std::uint32_t end_of(const json& values, const char* key,
                                     const std::string& where) const {
    const std::int64_t node = id(values, key, where);
    const auto found = positions_.find(node);
    if (found == positions_.end()) {
      fail(where, std::string(key) + " is " + std::to_string(node) + "; no such node is there");
    }
    return found->second;
  }

  void add_edge(const json& feature, const std::string& kind) {
    const std::string unnamed = "edge " + std::to_string(edges_.size() + 1) + " of the file";
    const json& values = properties(feature, unnamed);
    RouteEdge edge{.id = id(values, "id", unnamed)};
    const std::string where = "edge " + std::to_string(edge.id);
    edge.from = end_of(values, "startid", where);
    edge.to = end_of(values, "endid", where);
    edge.cost = number(values, "cost", where);
    const json& lines = coordinates(feature, where);
    const auto add_line = [&](const json& line) {
      if (!line.is_array()) {
        fail(where, "coordinates must be a list of points");
      }
      for (const json& value : line) {
        edge.line.push_back(point(value, where));
      }
    };
    if (kind == "LineString") {
      add_line(lines);
    } else {
      for (const json& line : lines) {
        add_line(line);
      }
    }
    if (const json* metadata = find(values, "metadata")) {
      add_metadata(*metadata, edge, where);
    }
    edges_.push_back(std::move(edge));
  }

  void add_metadata(const json& metadata, RouteEdge& edge, const std::string& where) const {
    edge.speed = number(metadata, "speed", where);
    edge.width = number(metadata, "width", where);
    if (const json* side = find(metadata, "pipe_side")) {
      const std::string text = side->is_string() ? side->get<std::string>() : "";
      const auto found = std::find(kSides.begin(), kSides.end(), text);
      if (found == kSides.end()) {
        fail(where, "pipe_side must be none, left, right or both");
      }
      edge.pipe_side = static_cast<PipeSide>(found - kSides.begin());
    }
    if (const json* one_way = find(metadata, "one_way")) {
      if (!one_way->is_boolean()) {
        fail(where, "one_way must be true or false");
      }
      edge.one_way = one_way->get<bool>();
    }
    const json* closed = find(metadata, "closed_until");
    if (closed != nullptr && closed->is_string()) {
      if (closed->get<std::string>() != kFurtherNotice) {
        fail(where, "closed_until must be a time in s or 'further notice'");
      }
      edge.closed_until = std::numeric_limits<double>::infinity();
    } else {
      edge.closed_until = number(metadata, "closed_until", where);
    }
  }

  std::string path_;
  std::vector<RouteNode> nodes_;
  std::vector<RouteEdge> edges_;
  std::map<std::int64_t, std::uint32_t> positions_;
};

json metadata_of(const RouteEdge& edge) {
  json metadata = json::object();
  if (edge.speed) {
    metadata["speed"] = *edge.speed;
  }
  if (edge.width) {
    metadata["width"] = *edge.width;
  }
  if (edge.pipe_side != PipeSide::kNone) {
    metadata["pipe_side"] = kSides[static_cast<std::size_t>(edge.pipe_side)];
  }
  if (edge.one_way) {
    metadata["one_way"] = true;
  }
  if (edge.closed_until == std::numeric_limits<double>::infinity()) {
    metadata["closed_until"] = kFurtherNotice;
  } else if (edge.closed_until) {
    metadata["closed_until"] = *edge.closed_until;
  }
  return metadata;
}

}  // namespace

navigation::RouteGraph read_route_graph(const std::filesystem::path& path) {
  return GraphReader(path).read(map_json_of(path));
}

void write_route_graph(const std::filesystem::path& path, const navigation::RouteGraph& graph) {
  json features = json::array();
  for (const RouteNode& node : graph.nodes()) {
    features.push_back(
        {{"type", "Feature"},
         {"properties", {{"id", node.id}, {"frame", node.frame}}},
         {"geometry",
          {{"type", "Point"}, {"coordinates", json::array({node.position.x, node.position.y})}}}});
  }
  for (const RouteEdge& edge : graph.edges()) {
    json line = json::array();
    for (const Point2d& point : edge.line) {
      line.push_back(json::array({point.x, point.y}));
    }
    if (edge.line.empty()) {
      for (const std::uint32_t node : {edge.from, edge.to}) {
        const Point2d& point = graph.nodes()[node].position;
        line.push_back(json::array({point.x, point.y}));
      }
    }
    json properties{{"id", edge.id},
                    {"startid", graph.nodes()[edge.from].id},
                    {"endid", graph.nodes()[edge.to].id}};
    if (edge.cost) {
      properties["cost"] = *edge.cost;
    }
    if (json metadata = metadata_of(edge); !metadata.empty()) {
      properties["metadata"] = std::move(metadata);
    }
    features.push_back(
        {{"type", "Feature"},
         {"properties", std::move(properties)},
         {"geometry",
          {{"type", "MultiLineString"}, {"coordinates", json::array({std::move(line)})}}}});
  }
  const json root{
      {"type", "FeatureCollection"}, {"name", "graph"}, {"features", std::move(features)}};
  replace_file(path, root.dump(1) + "\n");
}

}  // namespace pipescout
