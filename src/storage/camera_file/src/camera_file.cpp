// SPDX-License-Identifier: Apache-2.0
#include "pipescout/camera_file/camera_file.hpp"

#include <yaml-cpp/yaml.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "pipescout/files/yaml_location.hpp"
#include "pipescout/geometry/camera_calibration.hpp"

namespace pipescout {
namespace {

constexpr int kLargestImage = 1 << 16;  // pixels, of a side

class CameraFileReader {
 public:
  CameraFileReader(const YAML::Node& root, const std::string& path) : root_(root), path_(path) {}

  geometry::CameraParameters read() {
    if (!root_.IsMap()) {
      fail(root_, "a calibration must be a map of fields, as ROS' camera_calibration writes it");
    }
    geometry::CameraParameters camera;
    camera.width = size("image_width");
    camera.height = size("image_height");
    read_matrix(camera);
    const YAML::Node model = field("distortion_model");
    if (!model.IsScalar()) {
      fail(model, "distortion_model must be a text");
    }
    const std::vector<double> coefficients = data("distortion_coefficients");
    try {
      geometry::set_distortion(model.Scalar(), coefficients, camera);
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
};

}  // namespace

geometry::CameraParameters read_camera(const std::string& path) {
  return CameraFileReader(load_yaml(path), path).read();
}

geometry::CameraParameters parse_camera(const std::string& text, const std::string& path) {
  return CameraFileReader(parse_yaml(text, path), path).read();
}

}  // namespace pipescout
