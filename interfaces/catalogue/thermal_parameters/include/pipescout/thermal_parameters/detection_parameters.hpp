// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/message_conversions/thermal_image.hpp"
#include "pipescout/runtime/bound_parameters.hpp"
#include "pipescout/runtime/parameters.hpp"
#include "pipescout/thermal/leak_detector.hpp"
#include "pipescout/thermal/radiometry.hpp"
#include "pipescout/thermal/temperature_table.hpp"

/// Common parameters of components that detect pipes in thermal images.
namespace pipescout {

/// An image whose values cannot be converted, because the parameters do not describe its camera.
class UndescribedPicture final : public std::invalid_argument {
 public:
  UndescribedPicture(std::string counter, const std::string& text)
      : std::invalid_argument(text), counter_(std::move(counter)) {}
  /// As `Component::report_fault` takes it.
  [[nodiscard]] const std::string& counter() const noexcept { return counter_; }

 private:
  std::string counter_;
};

struct DetectionSettings {
  thermal::LeakDetectorParameters detector;  ///< valid
  /// Conversion of `mono16` counts to degC; nothing: the camera is not described.
  std::optional<thermal::TemperatureTable> counts;
  /// Conversion of `mono8` grey levels to degC; nothing: not described.
  std::optional<thermal::TemperatureTable> grey;
  /// `mono8` images are of automatic gain: their levels have no degrees.
  bool levels = false;

  /// Conversion of pixel values to degC, valid as long as these settings; empty for images in degC.
  /// Throws UndescribedPicture.
  [[nodiscard]] std::span<const float> celsius_of(const ThermalImageReader::View& picture) const;
};

/// `celsius`: as DetectionSettings::celsius_of. As LeakDetector::detect.
const thermal::Detections& detect(thermal::LeakDetector& detector,
                                  const ThermalImageReader::View& picture,
                                  std::span<const float> celsius,
                                  const thermal::FrameConditions& conditions = {});

/// Parameters of the detector, the camera and the object: docs/components/leak_inspector.md.
class DetectionParameters {
 public:
  /// Declares them, with the defaults of the preset that the parameter `preset` names. Throws
  /// ParameterError for an unknown preset.
  explicit DetectionParameters(Parameters& parameters);

  /// Throws std::invalid_argument naming the parameter.
  [[nodiscard]] DetectionSettings read() const;
  [[nodiscard]] thermal::ObjectParameters object() const { return object_->read(); }
  /// Nothing when they do not describe a camera. Throws as `read`.
  [[nodiscard]] std::optional<thermal::CameraConstants> camera_constants() const;
  /// K per count and degC at count 0; empty: not described by them.
  [[nodiscard]] std::vector<double> linear() const { return linear_.get(); }
  /// degC of black and of white; empty: not known.
  [[nodiscard]] std::vector<double> grey_range() const { return grey_range_.get(); }
  /// Description of the temperature conversion, for a log.
  [[nodiscard]] std::string calibration_text() const;

 private:
  struct Preset {
    thermal::LeakDetectorParameters detector;
    thermal::ObjectParameters object;
    std::vector<double> grey_range;
  };
  [[nodiscard]] static Preset preset(const std::string& name);

  void declare_detector(Parameters& parameters);
  void declare_camera(Parameters& parameters);
  void declare_object();
  [[nodiscard]] bool by_contrast() const;
  [[nodiscard]] std::optional<thermal::TemperatureTable> counts() const;
  [[nodiscard]] std::optional<thermal::TemperatureTable> grey() const;

  Preset defaults_;
  std::optional<BoundParameters<thermal::LeakDetectorParameters>> detector_;
  std::optional<BoundParameters<thermal::ObjectParameters>> object_;
  Parameter<std::string> threshold_rule_;
  Parameter<std::string> polarity_;
  Parameter<std::vector<double>> leak_delta_;
  Parameter<std::vector<double>> maximum_temperature_;
  Parameter<std::vector<double>> planck_;
  Parameter<std::vector<double>> linear_;
  Parameter<std::vector<double>> grey_range_;
};

}  // namespace pipescout
