// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "pipescout/message_conversions/thermal_image.hpp"
#include "pipescout/thermal_files/thermal_settings.hpp"

/// Recorded thermal images, of a folder of files or a bag.
namespace pipescout::track {

struct SourceImage {
  std::string name;  ///< of the file, or the number of the message, from 1 on
  double time = 0;   ///< s
  ThermalImageReader::View pixels;
  std::span<const float> celsius;  ///< of each count or grey level; empty for degC
  std::string unit_doubt;          ///< as of ThermalPicture
};

struct ImageSink {
  std::function<void(const SourceImage& image)> take;
  /// `advice`: as of ThermalFileError.
  std::function<void(const std::string& name, const std::string& problem,
                     const std::string& advice)>
      fail;
  std::function<void(std::size_t done, std::size_t total)> progress;
};

/// The images of a folder, in the order in which they were taken; those without a time follow each
/// other at `frame_rate` (1/s). Throws as `pictures_in`.
void read_folder(const std::filesystem::path& folder, const ThermalSettings& settings,
                 double frame_rate, const ImageSink& sink);

/// The images of a topic with sensor_msgs/msg/Image of a bag, by their stamps. `topic`: empty where
/// there is only one. Throws BagError; what is damaged behind readable messages is a failure of the
/// bag.
void read_bag(const std::filesystem::path& bag, const std::string& topic,
              const ThermalSettings& settings, const ImageSink& sink);

}  // namespace pipescout::track
