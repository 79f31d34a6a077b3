// SPDX-License-Identifier: Apache-2.0
#include "pipescout/map_files/grid_file.hpp"

#include <yaml-cpp/yaml.h>

#include <charconv>
#include <cmath>
#include <vector>

#include "map_text.hpp"
#include "pipescout/files/whole_file.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout {
namespace {

using navigation::Cell;
using navigation::CellState;
using navigation::GridGeometry;
using navigation::OccupancyGrid;

constexpr double kWhite = 255;
constexpr double kOccupiedThreshold = 0.65;  // what map_saver writes
constexpr double kFreeThreshold = 0.25;
constexpr double kOldFreeThreshold = 0.196;  // of ROS 1, which wrote what is unknown as 205
constexpr double kPercent = 100;

struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;  ///< top row first, 0 to 255
};

class PgmReader {
 public:
  PgmReader(std::string_view text, std::string path) : text_(text), path_(std::move(path)) {}

  Image read() {
    constexpr int kLargestSide = 100'000;
    constexpr std::size_t kMostPixels = 1'000'000'000;
    const std::string_view magic = text_.substr(0, 2);
    if (magic != "P5" && magic != "P2") {
      fail("it is no PGM image (P5 or P2)");
    }
    at_ = 2;
    Image image;
    image.width = number("width", 1, kLargestSide);
    image.height = number("height", 1, kLargestSide);
    const int white = number("largest value", 1, static_cast<int>(kWhite));
    const auto count =
        static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (count > kMostPixels) {
      fail("it has more than 1e9 pixels");
    }
    ++at_;  // one white space
    if (magic == "P5" && text_.size() < at_ + count) {
      fail("it is truncated: " + std::to_string(count) + " pixels expected, " +
           std::to_string(text_.size() - std::min(at_, text_.size())) + " found");
    }
    image.pixels.reserve(std::min(count, text_.size()));
    for (std::size_t i = 0; i < count; ++i) {
      const int value =
          magic == "P5" ? static_cast<std::uint8_t>(text_[at_ + i]) : number("pixel", 0, white);
      if (value > white) {
        fail("pixel " + std::to_string(i) + " is " + std::to_string(value) + ", above " +
             std::to_string(white));
      }
      image.pixels.push_back(static_cast<std::uint8_t>(std::lround(value * kWhite / white)));
    }
    return image;
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw MapFileError(path_ + ": " + message);
  }

  int number(const std::string& what, int low, int high) {
    while (at_ < text_.size() && (is_space(text_[at_]) || text_[at_] == '#')) {
      at_ = text_[at_] == '#' ? std::min(text_.find('\n', at_), text_.size()) : at_ + 1;
    }
    int value = 0;
    const char* end = text_.data() + text_.size();
    const auto [stop, error] =
        std::from_chars(text_.data() + std::min(at_, text_.size()), end, value);
    if (error != std::errc() || value < low || value > high) {
      fail(what + " is missing or outside [" + std::to_string(low) + ", " + std::to_string(high) +
           "]");
    }
    at_ = static_cast<std::size_t>(stop - text_.data());
    return value;
  }

  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

  std::string_view text_;
  std::string path_;
  std::size_t at_ = 0;
};

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

CellState state_of(std::uint8_t pixel, const Description& description) {
  double occupied = (description.negate ? pixel : kWhite - pixel) / kWhite;
  if (description.mode == GridMode::kRaw) {
    if (pixel > kPercent) {
      return CellState::kUnknown;
    }
    occupied = pixel / kPercent;
  }
  if (occupied > description.occupied_threshold) {
    return CellState::kOccupied;
  }
  return occupied < description.free_threshold ? CellState::kFree : CellState::kUnknown;
}

OccupancyGrid grid_of(const Image& image, Description description) {
  description.geometry.width = image.width;
  description.geometry.height = image.height;
  std::vector<CellState> cells;
  cells.reserve(image.pixels.size());
  const auto width = static_cast<std::size_t>(image.width);
  for (auto row = static_cast<std::size_t>(image.height); row-- > 0;) {
    for (std::size_t column = 0; column < width; ++column) {
      cells.push_back(state_of(image.pixels[row * width + column], description));
    }
  }
  return {description.geometry, std::move(cells)};
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
  return grid_of(PgmReader(*text, image_path.string()).read(), description);
}

navigation::OccupancyGrid read_grid_image(const std::filesystem::path& image, double resolution) {
  const std::optional<std::string> text = map_text_of(image);
  if (!text) {
    throw MapFileError(image.string() + ": it cannot be read");
  }
  Description description;
  description.geometry.resolution = resolution;
  description.free_threshold = kOldFreeThreshold;
  return grid_of(PgmReader(*text, image.string()).read(), description);
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
