// SPDX-License-Identifier: Apache-2.0
#include "image_source.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <sensor_msgs/msg/image.hpp>
#include <stdexcept>
#include <variant>
#include <vector>

#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/bags/topic_choice.hpp"
#include "pipescout/idl/message_type.hpp"
#include "pipescout/thermal/temperature_table.hpp"
#include "pipescout/thermal_files/picture_folder.hpp"

namespace pipescout::track {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImage = "sensor_msgs/msg/Image";

/// Of the counts of messages; nothing where the settings do not describe the camera.
std::optional<thermal::TemperatureTable> counts_table(const ThermalSettings& settings) {
  const thermal::CountRange range = settings.range.value_or(thermal::CountRange{});
  if (settings.planck) {
    const thermal::CameraConstants camera{.planck = *settings.planck, .path = settings.air_path};
    return thermal::TemperatureTable(thermal::Radiometry(camera, settings.object.apply({})), range);
  }
  if (settings.scale) {
    return thermal::TemperatureTable(settings.scale->gain, settings.scale->offset, range);
  }
  return std::nullopt;
}

/// The images of a bag as degC.
class MessageImages {
 public:
  explicit MessageImages(const ThermalSettings& settings) : counts_(counts_table(settings)) {
    if (settings.grey) {
      grey_ = thermal::TemperatureTable::of_grey(settings.grey->black, settings.grey->white);
    }
  }

  SourceImage read(const sensor_msgs::msg::Image& message) {
    SourceImage image;
    image.time = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec;
    image.pixels = reader_.read(message);
    if (std::holds_alternative<thermal::CountView>(image.pixels)) {
      image.celsius = of(counts_, "counts: thermal.yaml must convert them, by scale or planck");
    } else if (std::holds_alternative<thermal::GreyView>(image.pixels)) {
      image.celsius = of(grey_, "grey levels: thermal.yaml must convert them, by grey");
    }
    return image;
  }

 private:
  static std::span<const float> of(const std::optional<thermal::TemperatureTable>& table,
                                   const char* what) {
    if (!table) {
      throw std::invalid_argument(std::string("contains ") + what + " (--thermal)");
    }
    return table->degrees();
  }

  ThermalImageReader reader_;
  std::optional<thermal::TemperatureTable> counts_;
  std::optional<thermal::TemperatureTable> grey_;
};

}  // namespace

void read_folder(const fs::path& folder, const ThermalSettings& settings, double frame_rate,
                 const ImageSink& sink) {
  ThermalFileReader reader(settings);
  const PictureFolder found = pictures_in(
      folder, [](const std::string&) { return std::optional<double>(); }, reader);
  if (!found.problem.empty()) {
    sink.fail(folder.string(), found.problem, "");
  }
  for (const std::string& name : found.unread) {
    sink.fail(name, "is a recording in a format that is not read", "");
  }
  std::optional<double> last;
  for (std::size_t i = 0; i < found.pictures.size(); ++i) {
    sink.progress(i, found.pictures.size());
    const FolderPicture& from = found.pictures[i];
    try {
      const ThermalPicture picture = reader.read(from.file, *from.frames, from.frame);
      const auto told = picture.taken ? picture.taken : from.taken;
      const double next = last ? *last + 1 / frame_rate : 0;
      // Clocks of whole seconds give several images the same time.
      last = told && (!last || *told > *last) ? *told : next;
      sink.take({.name = from.name(),
                 .time = *last,
                 .pixels = picture.view(),
                 .celsius = {},
                 .unit_doubt = picture.unit_doubt});
    } catch (const ThermalFileError& error) {
      sink.fail(from.name(), error.what(), error.advice());
    }
  }
  sink.progress(found.pictures.size(), found.pictures.size());
}

void read_bag(const fs::path& bag, const std::string& topic, const ThermalSettings& settings,
              const ImageSink& sink) {
  bags::BagReader reader(bag);
  const bags::TopicCount chosen = bags::choose_topic(reader, bag, {kImage}, topic);
  reader.set_filter({.topics = {{chosen.topic.name}}});
  const MessageType* type = find_message_type(kImage);
  const std::shared_ptr<void> message = type->create();
  MessageImages images(settings);
  std::size_t number = 0;
  std::string damage;
  while (const auto next = reader.next_before_damage(damage)) {
    sink.progress(number, std::max(static_cast<std::size_t>(chosen.messages), number + 1));
    const std::string name = std::to_string(++number);
    if (!type->deserialize(next->data, message.get())) {
      sink.fail(name, "cannot be decoded", "");
      continue;
    }
    try {
      SourceImage image = images.read(*static_cast<const sensor_msgs::msg::Image*>(message.get()));
      image.name = name;
      sink.take(image);
    } catch (const std::invalid_argument& error) {
      sink.fail(name, error.what(), "");
    }
  }
  if (!damage.empty()) {
    sink.fail(bag.string(), "cannot be read to its end: " + damage, "");
  }
  sink.progress(number, number);
}

}  // namespace pipescout::track
