// SPDX-License-Identifier: Apache-2.0
#include "flir_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "picture_time.hpp"

namespace pipescout {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = (bits << 8U) | (i + k < bytes.size() ? bytes[i + k] : 0U);
    }
    for (unsigned k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : kDigits[(bits >> (18 - 6 * k)) & 63U];
    }
  }
  return text;
}

/// A picture of 2 x 2 counts as the camera's PNG has it.
std::string png(const std::vector<std::uint16_t>& counts) {
  const cv::Mat image(2, 2, CV_16UC1, const_cast<std::uint16_t*>(counts.data()));
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", image, bytes);
  return base64(bytes);
}

constexpr const char* kObject =
    R"("Emissivity":0.9,"ObjectDistance":2,"ReflectedApparentTemperature":15,
       "AtmosphericTemperature":16,"IRWindowTemperature":17,"IRWindowTransmission":0.8,
       "RelativeHumidity":0.4,"AtmosphericTransAlpha1":"0.006569","AtmosphericTransAlpha2":0.01262,
       "AtmosphericTransBeta1":"-0.002276","AtmosphericTransBeta2":-0.00667,
       "AtmosphericTransX":1.9,"PlanckR1":21106.77,"PlanckB":1501,"PlanckF":1,"PlanckO":-7340,
       "PlanckR2":0.0125,"DateTimeOriginal":"2018:11:05 12:14:43.5+01:00","CameraModel":"SC",
       "CameraSerialNumber":404)";

std::string document(const std::string& picture, const std::string& more = "",
                     const std::string& object = kObject) {
  return R"([{"SourceFile":"-","RawThermalImage":"base64:)" + picture +
         R"(","RawThermalImageType":"PNG","RawThermalImageWidth":2,"RawThermalImageHeight":2,)" +
         more + object + "}]";
}

// 20000 is 0x4e20; with the bytes the other way round 8270.
const std::vector<std::uint16_t> kSwapped = {8270, 8270, 8270, 0x214e};

FlirContent content_of(const std::string& json) {
  std::string complaint;
  auto content = flir_content(json, complaint);
  EXPECT_TRUE(content.has_value());
  return content.value_or(FlirContent{});
}

TEST(FlirFile, ReadsAllOfIt) {
  const FlirContent content = content_of(document(png(kSwapped)));
  EXPECT_THAT(content.counts.values, ElementsAre(20000, 20000, 20000, 20001));
  EXPECT_DOUBLE_EQ(content.object.emissivity, 0.9);
  EXPECT_DOUBLE_EQ(content.object.window_transmission, 0.8);
  EXPECT_DOUBLE_EQ(content.camera.atmosphere.alpha1, 0.006569);
  EXPECT_DOUBLE_EQ(content.camera.planck.o, -7340);
  EXPECT_EQ(content.camera_name, "SC 404");
  EXPECT_DOUBLE_EQ(content.taken.value_or(0), 1541416483.5);
  EXPECT_FALSE(content.place.has_value());
  EXPECT_THAT(content.doubts, IsEmpty());
}

TEST(FlirFile, TheNotedMedianTellsTheOrderOfBytes) {
  const std::string noted = R"("RawValueMedian":20000,"RawValueRange":500,)";
  EXPECT_THAT(content_of(document(png(kSwapped), noted)).counts.values,
              ElementsAre(20000, 20000, 20000, 20001));
  const FlirContent right = content_of(document(png({20000, 20000, 20000, 20001}), noted));
  EXPECT_THAT(right.counts.values, ElementsAre(20000, 20000, 20000, 20001));
  EXPECT_THAT(right.doubts, IsEmpty());
  const FlirContent neither = content_of(document(png({100, 100, 100, 100}), noted));
  EXPECT_THAT(neither.doubts, Contains(HasSubstr("the camera noted 20000")));
}

TEST(FlirFile, SaysWhatItHadToTakeForGranted) {
  const FlirContent content = content_of(document(
      png(kSwapped), "",
      R"("PlanckR1":1,"PlanckB":1,"PlanckF":1,"PlanckO":1,"PlanckR2":1,"Emissivity":0.5)"));
  EXPECT_DOUBLE_EQ(content.object.emissivity, 0.5);
  EXPECT_THAT(content.doubts, Contains("distance: not in the file; 1 is used"));
  EXPECT_THAT(content.doubts, Contains("taken: not in the file"));
}

TEST(FlirFile, NoThermalBlockIsNothing) {
  std::string complaint;
  EXPECT_FALSE(flir_content(R"([{"SourceFile":"-"}])", complaint).has_value());
  EXPECT_EQ(complaint, "");
  EXPECT_FALSE(flir_content(R"([{"Error":"File is empty","Warning":"w"}])", complaint).has_value());
  EXPECT_EQ(complaint, "File is empty");
}

TEST(FlirFile, ABrokenBlockIsNamed) {
  const auto reading = [](const std::string& json) {
    return [json] {
      std::string complaint;
      (void)flir_content(json, complaint);
    };
  };
  const auto throws = [](const char* what) { return ThrowsMessage<FlirError>(HasSubstr(what)); };
  EXPECT_THAT(reading("no json"), throws("is not JSON"));
  EXPECT_THAT(reading("[]"), throws("is not JSON"));
  EXPECT_THAT(reading(R"([{"RawThermalImage":"Binary data"}])"), throws("contains no image"));
  EXPECT_THAT(reading(R"([{"RawThermalImage":17}])"), throws("contains no image"));
  EXPECT_THAT(reading(document("AAAA")), throws("cannot be decoded"));
  EXPECT_THAT(reading(document(base64({0xff, 0xd8, 0xff, 0xf7, 0, 11}))), throws("JPEG-LS"));
  EXPECT_THAT(reading(document(png(kSwapped).substr(0, 60))), throws("cannot be decoded"));
  EXPECT_THAT(reading(document(png(kSwapped), "", R"("PlanckR1":5)")), throws("no PlanckR2"));
  std::string other = document(png(kSwapped));
  other.replace(other.find("Width\":2"), 8, "Width\":3");
  EXPECT_THAT(reading(other), throws("differs in size"));
  const cv::Mat grey(2, 2, CV_8UC1, cv::Scalar(7));
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", grey, bytes);
  EXPECT_THAT(reading(document(base64(bytes))), throws("does not have 16 bits"));
}

TEST(ExifTime, IsUtc) {
  EXPECT_DOUBLE_EQ(exif_time("1970:01:02 00:00:00").value_or(-1), 86400);
  EXPECT_DOUBLE_EQ(exif_time("1970:01:01 00:00:01.25Z").value_or(-1), 1.25);
  EXPECT_DOUBLE_EQ(exif_time("2013:04:16 15:12:26.104-05:00").value_or(-1), 1366143146.104);
  EXPECT_DOUBLE_EQ(exif_time("1970:01:01 05:45:00+05:45").value_or(-1), 0);
  for (const char* text :
       {"", "2013", "2013:13:01 00:00:00", "2013:02:30 00:00:00", "2013:02:03 24:00:00",
        "2013:02:03 00:60:00", "2013:02:03 00:00:00 PM"}) {
    EXPECT_FALSE(exif_time(text).has_value()) << text;
  }
}

TEST(FlirFile, AClockThatWasNeverSetIsDoubted) {
  std::string json = document(png(kSwapped));
  json.replace(json.find("2018:11"), 4, "2000");
  EXPECT_THAT(content_of(json).doubts, ElementsAre(HasSubstr("clock was not set")));
  EXPECT_FALSE(content_of(json).taken.has_value());
}

}  // namespace
}  // namespace pipescout
