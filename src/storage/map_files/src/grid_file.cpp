// SPDX-License-Identifier: Apache-2.0
#include "pipescout/map_files/grid_file.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include "grid_image.hpp"
#include "map_text.hpp"
#include "pipescout/files/whole_file.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout {
namespace {

using navigation::Cell;
using navigation::CellState;
using navigation::GridGeometry;
using navigation::OccupancyGrid;

constexpr double kOccupiedThreshold = 0.65;  // what map_saver writes
constexpr double kFreeThreshold = 0.25;
constexpr double kOldFreeThreshold = 0.196;  // of ROS 1, which wrote what is unknown as 205
constexpr double kPercent = 100;

struct Description {
  std::string image;
  GridMode mode = GridMode::kTrinary;
  GridGeometry geometry;
  bool negate = false;
  double occupied_threshold = kOccupiedThreshold;
  double free_threshold = kFreeThreshold;
};

class DescriptionReader {
 public:
  explicit DescriptionReader(const std::string& path) : path_(path), root_(load_yaml(path)) {}

  Description read() const {
    constexpr double kLargestResolution = 1000;  // m
    if (!root_.IsMap()) {
      throw YamlError(path_, root_.Mark(), "a map must be keys and values");
    }
    Description result;
    const YAML::Node image = field("image");
    if (!image.IsScalar() || image.Scalar().empty()) {
      fail(image, "image must be the name of a file");
    }
    result.image = image.Scalar();
    result.mode = mode();
    result.geometry.resolution = number(field("resolution"), "resolution");
    if (result.geometry.resolution <= 0 || result.geometry.resolution > kLargestResolution) {
      fail(field("resolution"), "resolution must be within (0, 1000] m");
    }
    const YAML::Node origin = field("origin");
    if (!origin.IsSequence() || origin.size() != 3) {
      fail(origin, "origin must be three numbers: x, y, yaw");
    }
    result.geometry.origin = {number(origin[0], "origin"), number(origin[1], "origin"),
                              number(origin[2], "origin")};
    result.negate = negate();
    result.occupied_threshold = threshold("occupied_thresh");
    result.free_threshold = threshold("free_thresh");
    if (result.free_threshold >= result.occupied_threshold) {
      fail(field("free_thresh"), "free_thresh must be below occupied_thresh");
    }
    return result;
  }

  [[noreturn]] void fail_at(const std::string& key, const std::string& message) const {
    fail(root_[key], message);
  }
  [[nodiscard]] std::string location_of(const std::string& key) const {
    return location(path_, root_[key].Mark());
  }

 private:
  [[noreturn]] void fail(const YAML::Node& node, const std::string& message) const {
    throw YamlError(path_, node.Mark(), message);
  }

  [[nodiscard]] YAML::Node field(const std::string& key) const {
    const YAML::Node value = root_[key];
    if (!value) {
      fail(root_, "key '" + key + "' is missing");
    }
    return value;
  }

  [[nodiscard]] double number(const YAML::Node& node, const std::string& what) const {
    double value = 0;
    const std::string text = node.IsScalar() ? node.Scalar() : "";
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc() || stop != text.data() + text.size() ||
        !std::isfinite(value)) {
      fail(node, what + " must be a finite number, not '" + text + "'");
    }
    return value;
  }

  [[nodiscard]] double threshold(const std::string& key) const {
    const double value = number(field(key), key);
    if (value < 0 || value > 1) {
      fail(field(key), key + " is " + field(key).Scalar() + "; it must be within [0, 1]");
    }
    return value;
  }

  [[nodiscard]] bool negate() const {
    const YAML::Node node = field("negate");
    const std::string text = node.IsScalar() ? node.Scalar() : "";
    if (text != "0" && text != "1" && text != "false" && text != "true") {
      fail(node, "negate must be 0 or 1, not '" + text + "'");
    }
    return text == "1" || text == "true";
  }

  [[nodiscard]] GridMode mode() const {
    const YAML::Node node = root_["mode"];
    if (!node) {
      return GridMode::kTrinary;
    }
    const std::string text = node.IsScalar() ? node.Scalar() : "";
    if (text != "trinary" && text != "scale" && text != "raw") {
      fail(node, "mode must be trinary, scale or raw, not '" + text + "'");
    }
    return text == "raw" ? GridMode::kRaw : text == "scale" ? GridMode::kScale : GridMode::kTrinary;
  }

  const std::string& path_;
  YAML::Node root_;
};

/// Shade of a pixel to occupancy, as map_server does it.
class Classifier {
 public:
  Classifier(const GridImage& image, const Description& description)
      : image_(image), description_(description) {}

  [[nodiscard]] CellState state(std::size_t pixel) const {
    const std::uint32_t shade = image_.shades[pixel];
    const double white = image_.white;
    if (description_.mode == GridMode::kRaw) {
      constexpr double kLargestByte = 255;
      const double percent = std::round(shade * kLargestByte / white);
      return percent > kPercent ? CellState::kUnknown : state_of(percent / kPercent);
    }
    if (description_.mode == GridMode::kScale && !image_.transparent.empty() &&
        image_.transparent[pixel]) {
      return CellState::kUnknown;
    }
    return state_of((description_.negate ? shade : image_.white - shade) / white);
  }

  /// Pixels of the grey that stands for "unknown" and that these thresholds take for free.
  [[nodiscard]] std::size_t unknown_as_free() const {
    if (description_.mode != GridMode::kTrinary || description_.negate ||
        state_of(saved_unknown()) != CellState::kFree) {
      return 0;
    }
    return static_cast<std::size_t>(std::ranges::count(image_.shades, image_.saved_unknown));
  }
  /// "5000 of 60000 pixels have ..., and are read as free; ..."
  [[nodiscard]] std::string unknown_as_free_text(std::size_t count) const {
    constexpr double kThousand = 1000;
    const double highest = std::floor(saved_unknown() * kThousand) / kThousand;
    return std::to_string(count) + " of " + std::to_string(image_.shades.size()) +
           " pixels have the grey 205, which map savers write for what is unknown, and are read as "
           "free; they are unknown with a free_thresh of " +
           map_number(highest) +
           (image_.transparent.empty() ? "" : " (in trinary mode alpha counts as a colour)");
  }

 private:
  [[nodiscard]] double saved_unknown() const {
    return (image_.white - image_.saved_unknown) / static_cast<double>(image_.white);
  }
  [[nodiscard]] CellState state_of(double occupied) const {
    if (occupied > description_.occupied_threshold) {
      return CellState::kOccupied;
    }
    return occupied < description_.free_threshold ? CellState::kFree : CellState::kUnknown;
  }

  const GridImage& image_;
  const Description& description_;
};

OccupancyGrid grid_of(const GridImage& image, Description description) {
  description.geometry.width = image.width;
  description.geometry.height = image.height;
  const Classifier classifier(image, description);
  std::vector<CellState> cells;
  cells.reserve(image.shades.size());
  const auto width = static_cast<std::size_t>(image.width);
  for (auto row = static_cast<std::size_t>(image.height); row-- > 0;) {
    for (std::size_t column = 0; column < width; ++column) {
      cells.push_back(classifier.state(row * width + column));
    }
  }
  return {description.geometry, std::move(cells)};
}

GridImage image_of(const std::string& content, const std::filesystem::path& path, GridMode mode) {
  return decode_grid_image(content, path,
                           mode == GridMode::kTrinary ? AlphaUse::kAveraged : AlphaUse::kSeparate);
}

std::uint8_t pixel_of(CellState state, GridMode mode) {
  constexpr std::uint8_t kFreePixel = 254;
  constexpr std::uint8_t kUnknownPixel = 128;  // between the thresholds
  constexpr std::uint8_t kRawOccupied = 100;
  constexpr std::uint8_t kRawUnknown = 255;
  const bool raw = mode == GridMode::kRaw;
  switch (state) {
    case CellState::kFree:
      return raw ? 0 : kFreePixel;
    case CellState::kOccupied:
      return raw ? kRawOccupied : 0;
    case CellState::kUnknown:
      break;
  }
  return raw ? kRawUnknown : kUnknownPixel;
}

}  // namespace

navigation::OccupancyGrid read_grid(const std::filesystem::path& yaml,
                                    std::vector<std::string>& remarks,
                                    std::optional<double> resolution) {
  constexpr double kSame = 1e-6;  // m
  const std::string path = yaml.string();
  const DescriptionReader reader(path);
  const Description description = reader.read();
  if (resolution && std::abs(*resolution - description.geometry.resolution) > kSame) {
    reader.fail_at("resolution", "resolution is " + map_number(description.geometry.resolution) +
                                     " m; it must be " + map_number(*resolution) + " m here");
  }
  const std::filesystem::path image_path = yaml.parent_path() / description.image;
  const std::optional<std::string> text = map_text_of(image_path);
  if (!text) {
    reader.fail_at("image", "image '" + image_path.string() + "' cannot be read");
  }
  const GridImage image = image_of(*text, image_path, description.mode);
  const Classifier classifier(image, description);
  if (const std::size_t count = classifier.unknown_as_free(); count > 0) {
    remarks.push_back(reader.location_of("free_thresh") + ": " +
                      classifier.unknown_as_free_text(count));
  }
  return grid_of(image, description);
}

navigation::OccupancyGrid read_grid_image(const std::filesystem::path& path, double resolution) {
  const std::optional<std::string> text = map_text_of(path);
  if (!text) {
    throw MapFileError(path.string() + ": it cannot be read");
  }
  Description description;
  description.geometry.resolution = resolution;
  description.free_threshold = kOldFreeThreshold;
  const GridImage image = image_of(*text, path, description.mode);
  const Classifier classifier(image, description);
  if (const std::size_t count = classifier.unknown_as_free(); count > 0) {
    throw MapFileError(path.string() + ": " + classifier.unknown_as_free_text(count) +
                       ": write a YAML file for it");
  }
  return grid_of(image, description);
}

void write_grid(const std::filesystem::path& yaml, const navigation::OccupancyGrid& grid,
                GridMode mode) {
  std::filesystem::path image = yaml;
  image.replace_extension(".pgm");
  std::string pixels =
      "P5\n" + std::to_string(grid.width()) + " " + std::to_string(grid.height()) + "\n255\n";
  for (int row = grid.height() - 1; row >= 0; --row) {
    for (int column = 0; column < grid.width(); ++column) {
      pixels += static_cast<char>(pixel_of(grid.at({column, row}), mode));
    }
  }
  replace_file(image, pixels);
  const char* name = mode == GridMode::kRaw     ? "raw"
                     : mode == GridMode::kScale ? "scale"
                                                : "trinary";
  const navigation::Pose2d& origin = grid.geometry().origin;
  replace_file(yaml, "image: " + image.filename().string() + "\nmode: " + name + "\nresolution: " +
                         map_number(grid.resolution()) + "\norigin: [" + map_number(origin.x) +
                         ", " + map_number(origin.y) + ", " + map_number(origin.heading) +
                         "]\nnegate: 0\noccupied_thresh: " + map_number(kOccupiedThreshold) +
                         "\nfree_thresh: " + map_number(kFreeThreshold) + "\n");
}

}  // namespace pipescout
