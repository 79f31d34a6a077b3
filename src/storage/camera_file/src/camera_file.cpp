// SPDX-License-Identifier: Apache-2.0
#include "pipescout/camera_file/camera_file.hpp"

#include <yaml-cpp/yaml.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "pipescout/files/yaml_location.hpp"
#include "pipescout/geometry/camera_calibration.hpp"

namespace pipescout {
namespace {

constexpr int kLargestImage = 1 << 16;  // pixels, of a side

class CameraFileReader {
 public:
  CameraFileReader(const YAML::Node& root, const std::string& path,
                   std::vector<std::string>& remarks)
      : root_(root), path_(path), remarks_(remarks) {}

  geometry::CameraParameters read() {
    if (!root_.IsMap()) {
      fail(root_, "a calibration must be a map of fields, as ROS' camera_calibration writes it");
    }
    geometry::CameraParameters camera;
    camera.width = size("image_width");
    camera.height = size("image_height");
    read_matrix(camera);
    const std::string model = distortion_model();
    const std::vector<double> coefficients = data("distortion_coefficients");
    read_region(camera);
    try {
      geometry::set_distortion(model, coefficients, camera);
      camera.validate();
    } catch (const std::invalid_argument& error) {
      fail(root_["distortion_coefficients"], std::string("invalid calibration: ") + error.what());
    }
    return camera;
  }

 private:
  [[noreturn]] void fail(const YAML::Node& node, const std::string& message) const {
    throw YamlError(path_, node.Mark(), message);
  }

  [[nodiscard]] YAML::Node field(const std::string& name) const {
    const YAML::Node value = root_[name];
    if (!value) {
      fail(root_, "field '" + name +
                      "' is missing; the file must be a calibration as ROS' "
                      "camera_calibration writes it");
    }
    return value;
  }

  [[nodiscard]] std::string text(const YAML::Node& node, const std::string& name) const {
    if (!node.IsScalar()) {
      fail(node, name + " must be a text");
    }
    return node.Scalar();
  }

  /// Some versions of camera_calibration write `camera_model: fisheye` in its place
  /// (image_pipeline, issue 682); OpenCV's fisheye model is the equidistant one.
  [[nodiscard]] std::string distortion_model() const {
    constexpr const char* kEquidistant = "equidistant";
    const YAML::Node kind = root_["camera_model"];
    const YAML::Node model = root_["distortion_model"];
    const bool is_fisheye = kind && text(kind, "camera_model") == "fisheye";
    if (!model && is_fisheye) {
      remarks_.push_back(location(path_, kind.Mark()) +
                         ": distortion_model is missing; camera_model: fisheye is taken as "
                         "distortion_model: equidistant");
      return kEquidistant;
    }
    const std::string name = text(field("distortion_model"), "distortion_model");
    if (is_fisheye && name != kEquidistant) {
      fail(kind, "camera_model is fisheye, but distortion_model '" + name +
                     "'; it must be equidistant, or camera_model another one");
    }
    return name;
  }

  /// Binning and region of interest, as sensor_msgs/CameraInfo has them.
  void read_region(geometry::CameraParameters& camera) const {
    geometry::ImageRegion region;
    const auto read = [this](const YAML::Node& map, const char* name, std::uint32_t& value) {
      if (const YAML::Node node = map[name]) {
        const int given = number<int>(node, name);
        if (given < 0) {
          fail(node, std::string(name) + " must not be negative");
        }
        value = static_cast<std::uint32_t>(given);
      }
    };
    read(root_, "binning_x", region.binning_x);
    read(root_, "binning_y", region.binning_y);
    if (const YAML::Node roi = root_["roi"]) {
      if (!roi.IsMap()) {
        fail(roi, "roi must be a map with x_offset, y_offset, width and height");
      }
      read(roi, "x_offset", region.x_offset);
      read(roi, "y_offset", region.y_offset);
      read(roi, "width", region.width);
      read(roi, "height", region.height);
    }
    const int width = camera.width;
    const int height = camera.height;
    try {
      geometry::apply_region(region, camera);
    } catch (const std::invalid_argument& error) {
      fail(root_, error.what());
    }
    if (camera.width != width || camera.height != height) {
      remarks_.push_back(path_ + ": by binning_x, binning_y and roi the images have " +
                         std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                         " of the calibrated " + std::to_string(width) + " x " +
                         std::to_string(height) + " pixels");
    }
  }

  template <class Number>
  [[nodiscard]] Number number(const YAML::Node& value, const std::string& what) const {
    const std::string scalar = value.IsScalar() ? value.Scalar() : std::string();
    const char* const end = scalar.data() + scalar.size();
    Number result = 0;
    const auto [stop, error] = std::from_chars(scalar.data(), end, result);
    if (error != std::errc() || stop != end || !std::isfinite(static_cast<double>(result))) {
      fail(value, what + " must be " +
                      (std::is_integral_v<Number> ? "an integer" : "a finite number") +
                      (value.IsScalar() ? ", not '" + scalar + "'" : ""));
    }
    return result;
  }

  [[nodiscard]] int size(const std::string& name) const {
    const YAML::Node node = field(name);
    const int value = number<int>(node, name);
    if (value < 1 || value > kLargestImage) {
      fail(node, name + " is " + std::to_string(value) + "; it must be 1 to " +
                     std::to_string(kLargestImage));
    }
    return value;
  }

  /// Numbers of a matrix: {rows, cols, data}.
  [[nodiscard]] std::vector<double> data(const std::string& name) const {
    const YAML::Node matrix = field(name);
    const YAML::Node list = matrix.IsMap() ? matrix["data"] : YAML::Node();
    if (!list || !list.IsSequence()) {
      fail(matrix, name + " must be a map with rows, cols and the list data");
    }
    std::vector<double> values;
    for (const YAML::Node& value : list) {
      values.push_back(number<double>(value, name + ".data"));
    }
    std::size_t expected = 1;
    for (const char* side : {"rows", "cols"}) {
      const YAML::Node node = matrix[side];
      const std::string what = name + "." + side;
      if (!node) {
        fail(matrix, "field '" + what + "' is missing");
      }
      const int value = number<int>(node, what);
      if (value < 0 || value > kLargestImage) {
        fail(node, what + " is " + std::to_string(value) + "; it must be 0 to " +
                       std::to_string(kLargestImage));
      }
      expected *= static_cast<std::size_t>(value);
    }
    if (values.size() != expected) {
      fail(list, name + ".data has " + std::to_string(values.size()) +
                     " numbers; with these rows and cols it must have " + std::to_string(expected));
    }
    return values;
  }

  void read_matrix(geometry::CameraParameters& camera) const {
    const std::vector<double> k = data("camera_matrix");
    const YAML::Node node = root_["camera_matrix"];
    if (k.size() != 9) {
      fail(node, "camera_matrix.data has " + std::to_string(k.size()) + " numbers; it must have 9");
    }
    if (k[0] == 0) {
      fail(node, "camera_matrix.data[0] is 0: the camera is not calibrated");
    }
    struct Fixed {
      std::size_t place;
      double value;
    };
    for (const Fixed& fixed : std::array<Fixed, 4>{{{3, 0}, {6, 0}, {7, 0}, {8, 1}}}) {
      if (k[fixed.place] != fixed.value) {
        fail(node, "camera_matrix.data[" + std::to_string(fixed.place) + "] must be " +
                       (fixed.value == 0 ? "0" : "1"));
      }
    }
    camera.focal_length = k[0];
    camera.skew = k[1];
    camera.centre_u = k[2];
    camera.aspect_ratio = k[4] / k[0];
    camera.centre_v = k[5];
  }

  YAML::Node root_;
  const std::string& path_;
  std::vector<std::string>& remarks_;
};

}  // namespace

geometry::CameraParameters read_camera(const std::string& path, std::vector<std::string>& remarks) {
  return CameraFileReader(load_yaml(path), path, remarks).read();
}

geometry::CameraParameters parse_camera(const std::string& text, const std::string& path,
                                        std::vector<std::string>& remarks) {
  return CameraFileReader(parse_yaml(text, path), path, remarks).read();
}

}  // namespace pipescout
