// SPDX-License-Identifier: Apache-2.0
#include "image_bag.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/compressed_image.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <stdexcept>
#include <utility>

#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/bags/topic_choice.hpp"
#include "pipescout/idl/message_type.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/grey_image.hpp"

namespace pipescout::rack {
namespace {

using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::CompressedImage;
using sensor_msgs::msg::Image;

constexpr const char* kImage = "sensor_msgs/msg/Image";
constexpr const char* kCompressed = "sensor_msgs/msg/CompressedImage";
constexpr const char* kCameraInfo = "sensor_msgs/msg/CameraInfo";

bags::TopicCount choose(const std::filesystem::path& bag, const bags::BagReader& reader,
                        const std::string& wanted) {
  return bags::choose_topic(reader, bag, {kImage, kCompressed}, wanted);
}

/// "/camera/camera_info" for "/camera/image_raw" and "/camera/image_raw/compressed".
std::string info_topic(const bags::BagTopic& images) {
  std::string name = images.name;
  if (images.type == kCompressed && name.ends_with("/compressed")) {
    name.erase(name.rfind('/'));
  }
  return name.substr(0, name.rfind('/') + 1) + "camera_info";
}

class ImageBag final : public ImageSource {
 public:
  ImageBag(const std::filesystem::path& bag, const std::string& topic)
      : reader_(bag), topic_(choose(bag, reader_, topic)) {
    const std::string& name = topic_.topic.name;
    reader_.set_filter({.topics = {{name}}});
    said_.push_back(bag.string() + ", topic " + name + ": " + std::to_string(topic_.messages) +
                    (is_compressed() ? " compressed images." : " images."));
  }

  std::optional<SourceImage> next() override {
    while (const auto message = read()) {
      const std::string name = topic_.topic.name + " " + std::to_string(read_ - 1);
      try {
        return is_compressed() ? compressed(*message, name) : raw(*message, name);
      } catch (const std::invalid_argument& error) {
        left_out_.push_back({name, error.what()});
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] std::size_t count() const override { return topic_.messages; }
  [[nodiscard]] std::vector<std::string> said() const override {
    std::vector<std::string> said = said_;
    if (without_stamp_ > 0) {
      said.push_back("header.stamp is zero in " + std::to_string(without_stamp_) +
                     " images; the times of recording are used.");
    }
    return said;
  }
  [[nodiscard]] const std::vector<LeftOut>& left_out() const override { return left_out_; }

 private:
  [[nodiscard]] bool is_compressed() const { return topic_.topic.type == kCompressed; }

  std::optional<bags::BagMessage> read() {
    std::string damage;
    auto message = reader_.next_before_damage(damage);
    read_ += message ? 1 : 0;
    if (!damage.empty()) {
      said_.push_back("The bag cannot be read to its end: " + damage +
                      ". What was read before is used.");
    }
    return message;
  }

  template <class T>
  Stamp decode(const bags::BagMessage& message, T& into) {
    if (!message_type<T>().deserialize(message.data, &into)) {
      throw std::invalid_argument("the message cannot be decoded");
    }
    const auto& stamp = into.header.stamp;
    if (stamp.sec == 0 && stamp.nanosec == 0) {
      ++without_stamp_;
      return Stamp(std::chrono::nanoseconds(message.log_time));
    }
    return Stamp(std::chrono::seconds(stamp.sec) + std::chrono::nanoseconds(stamp.nanosec));
  }

  SourceImage raw(const bags::BagMessage& message, const std::string& name) {
    const Stamp stamp = decode(message, image_);
    return {.name = name, .stamp = stamp, .view = grey_.read(image_)};
  }

  SourceImage compressed(const bags::BagMessage& message, const std::string& name) {
    const Stamp stamp = decode(message, compressed_);
    if (compressed_.data.empty()) {
      throw std::invalid_argument("data is empty");
    }
    try {
      const cv::Mat bytes(1, static_cast<int>(compressed_.data.size()), CV_8UC1,
                          compressed_.data.data());
      decoded_ = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {
      decoded_.release();
    }
    if (decoded_.empty()) {
      throw std::invalid_argument("data of format '" + compressed_.format + "' cannot be decoded");
    }
    return {
        .name = name,
        .stamp = stamp,
        .view = {decoded_.data, decoded_.cols, decoded_.rows, static_cast<int>(decoded_.step[0])}};
  }

  bags::BagReader reader_;
  bags::TopicCount topic_;
  Image image_;
  CompressedImage compressed_;
  GreyImageReader grey_;
  cv::Mat decoded_;
  std::size_t read_ = 0;
  std::size_t without_stamp_ = 0;
  std::vector<std::string> said_;
  std::vector<LeftOut> left_out_;
};

}  // namespace

std::unique_ptr<ImageSource> open_bag(const std::filesystem::path& bag, const std::string& topic) {
  return std::make_unique<ImageBag>(bag, topic);
}

std::optional<BagCamera> camera_of_bag(const std::filesystem::path& bag, const std::string& topic) {
  bags::BagReader reader(bag);
  const std::string name = info_topic(choose(bag, reader, topic).topic);
  bool there = false;
  for (const bags::BagTopic& each : reader.topics()) {
    there = there || (each.name == name && each.type == kCameraInfo);
  }
  if (!there) {
    return std::nullopt;
  }
  reader.set_filter({.topics = {{name}}});
  const auto message = reader.next();
  if (!message) {
    return std::nullopt;
  }
  CameraInfo info;
  if (!message_type<CameraInfo>().deserialize(message->data, &info)) {
    throw std::runtime_error(bag.string() + ", topic " + name + ": the message cannot be decoded");
  }
  try {
    return BagCamera{from_message(info), name};
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(bag.string() + ", topic " + name + ": " + error.what());
  }
}

}  // namespace pipescout::rack
