// SPDX-License-Identifier: Apache-2.0
// `pipescout track`, on images made here: a warm pipe that sways, hidden in some of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sensor_msgs/msg/image.hpp>

#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/idl/message_type.hpp"
#include "pipescout/testing/program.hpp"
#include "pipescout/thermal_files/thermal_file.hpp"

namespace pipescout::track {
namespace {

namespace fs = std::filesystem;
using ::pipescout::testing::content;
using ::pipescout::testing::run_program;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr int kImages = 30;

double row_of(int image) {
  return 60 + 10 * std::sin(0.2 * image);
}

/// degC; none of the pipe in images 15 to 19.
std::vector<float> temperatures(int image) {
  std::vector<float> degrees(kWidth * kHeight);
  const bool hidden = image >= 15 && image < 20;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool pipe = !hidden && std::abs(y - row_of(image)) <= 4;
      degrees[static_cast<std::size_t>(y * kWidth + x)] =
          pipe ? 60.0F : 15.0F + 0.1F * static_cast<float>((x * 7 + y * 13) % 5);
    }
  }
  return degrees;
}

class TrackCommand : public ::testing::Test {
 protected:
  void write_folder() const {
    fs::create_directories(folder_.path() / "images");
    for (int i = 0; i < kImages; ++i) {
      const std::vector<float> degrees = temperatures(i);
      std::ofstream(folder_.path() / "images" / (std::to_string(i) + ".tiff"), std::ios::binary)
          << to_tiff(thermal::TemperatureView{degrees.data(), kWidth, kHeight, kWidth});
    }
  }
  void write_bag(const std::vector<std::string>& topics,
                 const std::string& encoding = "32FC1") const {
    bags::BagWriter writer(folder_.path() / "bag", {});
    for (int i = 0; i < kImages; ++i) {
      sensor_msgs::msg::Image image;
      image.header.stamp.sec = 100 + i / 10;
      image.header.stamp.nanosec = 100'000'000U * static_cast<std::uint32_t>(i % 10);
      image.width = kWidth;
      image.height = kHeight;
      image.encoding = encoding;
      image.step = kWidth * sizeof(float);
      const std::vector<float> degrees = temperatures(i);
      image.data.resize(degrees.size() * sizeof(float));
      std::memcpy(image.data.data(), degrees.data(), image.data.size());
      for (const std::string& topic : topics) {
        write(writer, topic, image);
      }
    }
    writer.close();
  }
  static void write(bags::BagWriter& writer, const std::string& topic,
                    const sensor_msgs::msg::Image& image);

  [[nodiscard]] auto run(const std::vector<std::string>& arguments) const {
    return run_program(TRACK_COMMAND, arguments, folder_.path());
  }
  /// Names, in their order.
  [[nodiscard]] std::vector<std::string> pictures() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path() / "out" / "overlays")) {
      names.push_back(entry.path().filename());
    }
    std::ranges::sort(names);
    return names;
  }
  [[nodiscard]] CsvTable track() const {
    return {content(folder_.path() / "out" / "track.csv"), "track.csv"};
  }
  /// Of all images after the first ones, against the truth.
  void check_track() const {
    const CsvTable csv = track();
    ASSERT_EQ(csv.rows(), kImages);
    for (int i = 5; i < kImages; ++i) {
      const auto row = static_cast<std::size_t>(i);
      const bool hidden = i >= 15 && i < 20;
      EXPECT_EQ(csv.cell(row, 2), hidden ? "coasting" : "locked") << i;
      EXPECT_EQ(csv.cell(row, 3), "1") << i;
      EXPECT_NEAR(csv.required(row, 5), row_of(i), hidden ? 15 : 4) << i;
    }
  }

  ::pipescout::testing::TemporaryFolder folder_;
};

void TrackCommand::write(bags::BagWriter& writer, const std::string& topic,
                         const sensor_msgs::msg::Image& image) {
  const MessageType& type = message_type<sensor_msgs::msg::Image>();
  std::vector<std::byte> data(type.serialized_size(&image));
  ASSERT_EQ(type.serialize(&image, data), data.size());
  const auto index = writer.add_topic({.name = topic, .type = "sensor_msgs/msg/Image"});
  const std::int64_t time = image.header.stamp.sec * 1'000'000'000LL + image.header.stamp.nanosec;
  writer.write({.topic = index, .log_time = time, .publish_time = time, .data = data});
}

TEST_F(TrackCommand, FollowsThePipeOfAFolder) {
  write_folder();
  const auto result = run({"images", "--out", "out", "--preset", "hot_pipes"});
  EXPECT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("30 images, 25 with pipes\n1 track; locked in "));
  check_track();
  EXPECT_EQ(pictures().size(), 30U);
  const auto again = run({"images", "--out", "out"});
  EXPECT_EQ(again.code(), 1);
  EXPECT_THAT(again.err, HasSubstr("out: is not empty ("));
}

TEST_F(TrackCommand, PicturesShowTheTrackWhereItIs) {
  write_folder();
  ASSERT_EQ(run({"images", "--out", "out", "--preset", "hot_pipes", "--overlays", "6"}).code(), 0);
  const std::vector<std::string> names = pictures();
  ASSERT_EQ(names.size(), 6U);
  EXPECT_EQ(names[2], "000010_10.tiff.png");
  const cv::Mat picture = cv::imread((folder_.path() / "out/overlays" / names[2]).string());
  ASSERT_EQ(picture.cols, 640);
  // The green outline lies about the pipe, above and below.
  cv::Mat green;
  cv::inRange(picture, cv::Scalar(60, 200, 40), cv::Scalar(100, 240, 80), green);
  cv::Mat rows;
  cv::reduce(green, rows, 1, cv::REDUCE_MAX);
  std::vector<cv::Point> found;
  cv::findNonZero(rows, found);
  ASSERT_FALSE(found.empty());
  const double scale = 640.0 / kWidth;
  EXPECT_NEAR(found.front().y / scale, row_of(10) - 5, 2.5);
  EXPECT_NEAR(found.back().y / scale, row_of(10) + 5, 2.5);
  // One of the images in which it is hidden: predicted.
  const cv::Mat hidden = cv::imread((folder_.path() / "out/overlays" / names[3]).string());
  cv::inRange(hidden, cv::Scalar(10, 120, 235), cv::Scalar(50, 160, 255), green);
  EXPECT_GT(cv::countNonZero(green), 0);
}

TEST_F(TrackCommand, NoPicturesWhereNoneAreAskedFor) {
  write_folder();
  ASSERT_EQ(run({"images", "--out", "out", "--preset", "hot_pipes", "--overlays", "0"}).code(), 0);
  EXPECT_FALSE(fs::exists(folder_.path() / "out/overlays"));
}

TEST_F(TrackCommand, NamesThePresetThatFindsPipes) {
  write_folder();
  const auto result = run({"images", "--out", "out"});
  EXPECT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("30 images, 0 with pipes"));
  EXPECT_THAT(
      result.err,
      HasSubstr("note: no pipe in 30 images with preset collectors, which looks for what is "
                "above 100 degC; the images are from 15.0 to 60.0 degC. Tried on 15 of them: "
                "--preset hot_pipes finds pipes in "));
}

TEST_F(TrackCommand, SaysWhatToExportInPlaceOfFalseColours) {
  fs::create_directories(folder_.path() / "images");
  for (const char* name : {"1.png", "2.png"}) {
    cv::imwrite((folder_.path() / "images" / name).string(),
                cv::Mat(8, 8, CV_8UC3, cv::Scalar(1, 2, 3)));
  }
  const auto result = run({"images", "--out", "out"});
  EXPECT_EQ(result.code(), 1);
  EXPECT_THAT(result.err, AllOf(HasSubstr("1.png: is a colour image"),
                                HasSubstr("note: instead of pictures in colours export ")));
}

TEST_F(TrackCommand, ProblemsOfManyImagesAreToldOnce) {
  write_bag({"/thermal/image_raw"}, "rgb8");
  const auto result = run({"bag", "--out", "out"});
  EXPECT_EQ(result.code(), 1);
  EXPECT_THAT(result.err, AllOf(HasSubstr("warning: 1: encoding is 'rgb8', colours, from which no "
                                          "temperatures can be read"),
                                HasSubstr(", and so 29 more images\n")));
}

TEST_F(TrackCommand, SaysWhyImagesFarApartGiveNoTrack) {
  write_folder();
  std::ofstream(folder_.path() / "images" / "survey.yaml") << "preset: hot_pipes\nframe_rate: 1\n";
  const auto result = run({"images", "--out", "out", "--preset", "hot_pipes"});
  EXPECT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("30 images, 25 with pipes\n0 tracks;"));
  EXPECT_THAT(result.err, HasSubstr("note: pipes in 25 images, and none that is surely the same in "
                                    "3: the images are 1 s apart on average"));
}

TEST_F(TrackCommand, FollowsThePipeOfABag) {
  write_bag({"/thermal/image_raw"});
  const auto result = run({"bag", "--out", "out", "--preset", "hot_pipes"});
  EXPECT_EQ(result.code(), 0) << result.err;
  check_track();
  EXPECT_EQ(track().cell(0, 1), "100");
}

TEST_F(TrackCommand, ChoosesAmongTopics) {
  write_bag({"/front", "/back"});
  const auto undecided = run({"bag", "--out", "out", "--preset", "hot_pipes"});
  EXPECT_EQ(undecided.code(), 1);
  EXPECT_THAT(undecided.err, HasSubstr("choose one with --topic: /front, /back"));
  EXPECT_EQ(run({"bag", "--out", "out", "--topic", "/back"}).code(), 0);
}

TEST_F(TrackCommand, UsesADamagedBagAsFarAsItGoes) {
  write_bag({"/thermal/image_raw"});
  for (const auto& entry : fs::directory_iterator(folder_.path() / "bag")) {
    if (entry.path().filename() != "metadata.yaml") {
      fs::resize_file(entry.path(), fs::file_size(entry.path()) * 2 / 3);
    }
  }
  const auto result = run({"bag", "--out", "out", "--preset", "hot_pipes"});
  EXPECT_EQ(result.code(), 1);
  EXPECT_THAT(result.err, HasSubstr("cannot be read to its end"));
  EXPECT_GE(track().rows(), 10U);
}

TEST_F(TrackCommand, NamesWhatItCannotUse) {
  write_folder();
  std::ofstream(folder_.path() / "images" / "12b.tiff") << "no image";
  const auto result = run({"images", "--out", "out", "--preset", "hot_pipes"});
  EXPECT_EQ(result.code(), 1);
  EXPECT_THAT(result.err, HasSubstr("12b.tiff: is neither PNG, TIFF, JPEG nor FLIR's FFF"));
  EXPECT_EQ(track().rows(), 1U + kImages);
  fs::create_directories(folder_.path() / "empty");
  EXPECT_THAT(run({"empty", "--out", "none"}).err, HasSubstr("empty: contains no image"));
  EXPECT_EQ(run({"nowhere", "--out", "none"}).code(), 2);
}

}  // namespace
}  // namespace pipescout::track
