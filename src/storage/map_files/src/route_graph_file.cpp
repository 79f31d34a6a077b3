// SPDX-License-Identifier: Apache-2.0
#include "pipescout/map_files/route_graph_file.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <type_traits>

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
/// Keys of an edge's metadata that are used.
constexpr std::array<std::string_view, 6> kMetadata{"speed",     "abs_speed_limit", "width",
                                                    "pipe_side", "one_way",         "closed_until"};
using Counts = std::map<std::string, std::size_t>;
constexpr std::array<std::string_view, 4> kSides{"none", "left", "right", "both"};

class GraphReader {
 public:
  GraphReader(const std::filesystem::path& path, std::vector<std::string>& remarks)
      : path_(path.string()), remarks_(remarks) {}

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
        add_edge(feature);
      } else if (kind != "Point") {
        fail("feature " + std::to_string(count),
             "its geometry must be a Point, a LineString or a MultiLineString");
      }
      ++count;
    }
    remark();
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

  void add_node(const json& feature) {
    const std::string unnamed = "node " + std::to_string(nodes_.size() + 1) + " of the file";
    const json& values = properties(feature, unnamed);
    RouteNode node{.id = id(values, "id", unnamed)};
    const std::string where = "node " + std::to_string(node.id);
    const json* coordinates = find(feature["geometry"], "coordinates");
    if (coordinates == nullptr) {
      fail(where, "coordinates are missing");
    }
    node.position = point(*coordinates, where);
    if (const json* frame = find(values, "frame")) {
      if (!frame->is_string() || frame->get<std::string>().empty()) {
        fail(where, "frame must be a text");
      }
      node.frame = frame->get<std::string>();
    }
    count_keys(values, "operations", operations_);
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

  void add_edge(const json& feature) {
    const std::string unnamed = "edge " + std::to_string(edge_count_ + 1) + " of the file";
    ++edge_count_;
    const json& values = properties(feature, unnamed);
    RouteEdge edge{.id = id(values, "id", unnamed)};
    const std::string where = "edge " + std::to_string(edge.id);
    edge.from = end_of(values, "startid", where);
    edge.to = end_of(values, "endid", where);
    if (edge.from == edge.to) {
      ++loops_[edge.id];
      return;
    }
    edge.cost = cost(values, where);
    if (const json* line = find(feature["geometry"], "coordinates")) {
      append_line(*line, edge.line, where);
    }
    count_keys(values, "operations", operations_);
    if (const json* metadata = find(values, "metadata")) {
      add_metadata(*metadata, edge, where);
    }
    ++ids_[edge.id];
    edges_.push_back(std::move(edge));
  }

  /// Points, or lists of points, of which each begins where the one before ends.
  void append_line(const json& value, std::vector<Point2d>& line, const std::string& where) const {
    if (!value.is_array()) {
      fail(where, "coordinates must be a list of points");
    }
    for (const json& part : value) {
      if (part.is_array() && !part.empty() && part.front().is_array()) {
        append_line(part, line, where);
        continue;
      }
      const Point2d next = point(part, where);
      const bool joins = &part == &value.front() && !line.empty() && line.back() == next;
      if (!joins) {
        line.push_back(next);
      }
    }
  }

  [[nodiscard]] std::optional<double> cost(const json& values, const std::string& where) {
    const std::optional<double> value = number(values, "cost", where);
    const json* overridable = find(values, "overridable");
    if (overridable != nullptr && !overridable->is_boolean()) {
      fail(where, "overridable must be true or false");
    }
    if (!value || overridable == nullptr || !overridable->get<bool>()) {
      return value;
    }
    // Nav2's saver writes a cost of 0 where there is none.
    overridable_costs_ += *value != 0 ? 1U : 0U;
    return std::nullopt;
  }

  void add_metadata(const json& metadata, RouteEdge& edge, const std::string& where) {
    edge.speed = number(metadata, "speed", where);
    if (!edge.speed) {
      edge.speed = number(metadata, "abs_speed_limit", where);
    }
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
    if (metadata.is_object()) {
      for (const auto& [key, value] : metadata.items()) {
        if (std::ranges::find(kMetadata, key) == kMetadata.end()) {
          ++metadata_[key];
        }
      }
    }
  }

  static void count_keys(const json& of, const char* key, Counts& counts) {
    const json* found = find(of, key);
    if (found != nullptr && (found->is_object() || found->is_array())) {
      for (const auto& [name, value] : found->items()) {
        const json* type = find(value, "type");
        ++counts[type != nullptr && type->is_string() ? type->get<std::string>() : name];
      }
    }
  }

  /// "speed_limit (12), class (3)".
  template <typename Key>
  static std::string list_of(const std::map<Key, std::size_t>& counts) {
    std::string text;
    for (const auto& [key, count] : counts) {
      text += text.empty() ? "" : ", ";
      if constexpr (std::is_same_v<Key, std::string>) {
        text += key;
      } else {
        text += std::to_string(key);
      }
      text += " (" + std::to_string(count) + ")";
    }
    return text;
  }

  void remark() {
    std::erase_if(ids_, [](const auto& each) { return each.second == 1; });
    const auto add = [this](const std::string& counts, const char* before, const char* behind) {
      if (!counts.empty()) {
        remarks_.push_back(path_ + ": " + before + counts + behind);
      }
    };
    add(list_of(metadata_), "not used of the edges' metadata, with the number of edges: ", "");
    if (metadata_.contains("speed_limit")) {
      remarks_.push_back(path_ +
                         ": speed_limit is percent of a speed that the file does not say; give "
                         "abs_speed_limit in m/s");
    }
    add(list_of(operations_), "operations that are not carried out, with their number: ", "");
    add(list_of(loops_), "edges from a node to itself are left out: ", "");
    add(list_of(ids_),
        "ids of several edges between the same places: ", "; nothing can name one of them");
    if (overridable_costs_ > 0) {
      remarks_.push_back(path_ + ": the cost of " + std::to_string(overridable_costs_) +
                         " edges does not count, since overridable is true; their length does");
    }
  }

  std::string path_;
  std::vector<std::string>& remarks_;
  std::vector<RouteNode> nodes_;
  std::vector<RouteEdge> edges_;
  std::size_t edge_count_ = 0;
  std::size_t overridable_costs_ = 0;
  Counts metadata_;    ///< edges by a key that is not used
  Counts operations_;  ///< by their type
  std::map<std::int64_t, std::size_t> loops_;
  std::map<std::int64_t, std::size_t> ids_;
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

navigation::RouteGraph read_route_graph(const std::filesystem::path& path,
                                        std::vector<std::string>& remarks) {
  return GraphReader(path, remarks).read(map_json_of(path));
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
