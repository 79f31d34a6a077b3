// SPDX-License-Identifier: Apache-2.0
// Files of all kinds, made here; FLIR's among them, which the real exiftool reads.
#include "pipescout/thermal_files/thermal_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "pipescout/thermal_files/testing/synthetic_files.hpp"
#include "pipescout/thermal_files/testing/synthetic_flir.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

class ThermalFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("thermal_file_" + std::to_string(::getpid()) + "_" + test->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  fs::path write(const std::string& name, const cv::Mat& image) const {
    cv::imwrite((folder_ / name).string(), image);
    return folder_ / name;
  }
  static auto refuses(const fs::path& file, const ThermalSettings& settings, const char* why) {
    EXPECT_THAT([&] { (void)ThermalFileReader(settings).read(file); },
                ThrowsMessage<ThermalFileError>(AllOf(StartsWith(file.string()), HasSubstr(why))));
  }

  fs::path folder_;
};

std::string content(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST_F(ThermalFile, FlirFff) {
  const ThermalPicture picture =
      ThermalFileReader({}).read(write("a.fff", test::SyntheticFlir{}.bytes()));
  EXPECT_EQ(picture.kind, ThermalFileKind::kFlir);
  EXPECT_EQ(picture.width, 8);
  EXPECT_EQ(picture.height, 6);
  EXPECT_EQ(picture.view()(7, 5), picture.degrees.back());
  // As FLIR's own software has it for these counts, parameters and constants.
  EXPECT_NEAR(picture.degrees[0], 34.703, 1e-3);
  EXPECT_EQ(picture.counts.front(), 20118);
  EXPECT_DOUBLE_EQ(picture.taken.value_or(0), 1700000000);
  EXPECT_EQ(picture.camera, "Test camera");
  ASSERT_TRUE(picture.radiometry.has_value());
  EXPECT_NEAR(picture.radiometry->object().emissivity, 0.95, 1e-6);
  EXPECT_THAT(picture.doubts, ElementsAre(HasSubstr("unchanged factory defaults")));
  EXPECT_EQ(picture.count.above_range, 0U);
}

TEST_F(ThermalFile, SettingsTakeThePlaceOfWhatAFileSays) {
  const fs::path file = write("a.fff", test::SyntheticFlir{}.bytes());
  ThermalSettings settings;
  settings.object.emissivity = 0.96;
  settings.regions = {{.x = 2, .y = 1, .width = 2, .height = 2, .object = {.emissivity = 0.5}}};
  settings.range = thermal::CountRange{0, 20118};
  const ThermalPicture picture = ThermalFileReader(settings).read(file);
  EXPECT_LT(picture.degrees[0], 34.703 - 0.05);
  EXPECT_GT(picture.view()(2, 1), 40);
  EXPECT_LT(picture.view()(4, 1), 35);
  EXPECT_EQ(picture.count.above_range, 48U);
  EXPECT_EQ(picture.count.pixels, 48U);
}

TEST_F(ThermalFile, AnyNameIsJustAName) {
  const std::string bytes = test::SyntheticFlir{}.bytes();
  for (const char* name : {"-b.fff", "a b;$(touch pwned)`x`.fff", "\xff\xfe.fff", "@x.fff",
                           "quote\"'.fff", "new\nline.fff", "noextension"}) {
    EXPECT_NEAR(ThermalFileReader({}).read(write(name, bytes)).degrees[0], 34.703, 1e-3) << name;
  }
  EXPECT_FALSE(fs::exists("pwned"));
}

TEST_F(ThermalFile, DoubtfulParametersAreToldAndImpossibleOnesRefused) {
  test::SyntheticFlir flir;
  flir.emissivity = 0.7F;
  flir.distance = 20;
  EXPECT_THAT(ThermalFileReader({}).read(write("a.fff", flir.bytes())).doubts,
              ElementsAre(HasSubstr("emissivity 0.7: below 0.8")));
  flir.humidity = 1.5F;  // exiftool takes what is above 2 for a percentage
  const fs::path file = write("b.fff", flir.bytes());
  refuses(file, {}, "relative_humidity: 1.5 is outside [0, 1]");
  ThermalSettings settings;
  settings.object.relative_humidity = 0.5;
  EXPECT_FALSE(ThermalFileReader(settings).read(file).degrees.empty());
  flir.emissivity = 0;
  refuses(write("c.fff", flir.bytes()), settings, "emissivity: 0 is outside (0, 1]");
}

TEST_F(ThermalFile, CountsBelowTheReflectedShareAreCounted) {
  test::SyntheticFlir flir;
  flir.emissivity = 0.04F;
  flir.counts[5] = 9000;
  const ThermalPicture picture = ThermalFileReader({}).read(write("a.fff", flir.bytes()));
  EXPECT_TRUE(std::isnan(picture.degrees[5]));
  EXPECT_EQ(picture.count.without_temperature, 1U);
}

TEST_F(ThermalFile, BrokenFilesAreNamed) {
  const std::string whole = test::SyntheticFlir{}.bytes();
  refuses(write("zero.jpg", ""), {}, "is empty");
  refuses(folder_ / "missing.jpg", {}, "No such file");
  refuses(folder_, {}, "is not a file");
  refuses(write("text.png", "hello"), {}, "neither PNG");
  refuses(write("short.fff", whole.substr(0, 150)), {}, "no thermal block (exiftool: ");
  refuses(write("header.fff", whole.substr(0, 40)), {}, "no thermal block");
  // Cut in the camera's data: counts without constants.
  refuses(write("camera.fff", whole.substr(0, whole.size() - 0x39c)), {}, "");
}

TEST_F(ThermalFile, AJpegWithoutThermalBlock) {
  const fs::path colour = write("colour.jpg", cv::Mat(6, 8, CV_8UC3, cv::Scalar(10, 20, 30)));
  refuses(colour, {}, "is a colour image (false colours, or a photograph)");
  ThermalSettings settings;
  settings.grey = GreyScale{.black = 0, .white = 255};
  refuses(colour, settings, "is a colour image");
  const fs::path grey = write("grey.jpg", cv::Mat(6, 8, CV_8UC1, cv::Scalar(100)));
  refuses(grey, {}, "has no thermal block");
  const ThermalPicture picture = ThermalFileReader(settings).read(grey);
  EXPECT_EQ(picture.kind, ThermalFileKind::kGrey8);
  EXPECT_NEAR(picture.degrees[3], 100, 2);
}

TEST_F(ThermalFile, FalseColoursAreToldWhatToExportInstead) {
  const auto advice_for = [](const fs::path& file) {
    try {
      (void)ThermalFileReader({}).read(file);
    } catch (const ThermalFileError& error) {
      return error.advice();
    }
    return std::string();
  };
  const cv::Mat colours(6, 8, CV_8UC3, cv::Scalar(10, 20, 30));
  for (const char* name : {"a.png", "a.tiff", "a.jpg"}) {
    EXPECT_THAT(advice_for(write(name, colours)),
                AllOf(HasSubstr("FLIR's radiometric JPEG"),
                      HasSubstr("TIFF of 32-bit temperatures"), HasSubstr("16-bit counts")))
        << name;
  }
  EXPECT_EQ(advice_for(write("no_image.png", "hello")), "");
  const std::string jpeg = content(folder_ / "a.jpg");
  EXPECT_THAT(advice_for(write("dji.jpg", test::jpeg_made_by(jpeg, "DJI"))),
              HasSubstr("DJI's Thermal SDK"));
  EXPECT_THAT(advice_for(write("flir.jpg", test::jpeg_made_by(jpeg, "FLIR Systems AB"))),
              HasSubstr("as the camera saved them"));
}

TEST_F(ThermalFile, GreyLevelsMayBeSavedAsColours) {
  ThermalSettings settings;
  settings.grey = GreyScale{.black = 0, .white = 255};
  const fs::path file = write("grey.png", cv::Mat(6, 8, CV_8UC3, cv::Scalar(70, 70, 70)));
  EXPECT_FLOAT_EQ(ThermalFileReader(settings).read(file).degrees[0], 70);
}

TEST_F(ThermalFile, AScaleThatGivesTemperaturesOfNoBodyIsRefusedAndTheLikelyOneNamed) {
  ThermalSettings settings;
  settings.scale = LinearScale{.gain = 0.1, .offset = -273.15};
  cv::Mat hundredths(6, 8, CV_16UC1, cv::Scalar(29500));
  hundredths.at<std::uint16_t>(2, 3) = 36315;
  const fs::path file = write("a.tiff", hundredths);
  refuses(file, settings, "makes its counts 2676.8 to 2676.8 degC, which no body here has");
  refuses(file, settings, "likely is scale {gain: 0.01, offset: -273.15}: 21.9 to 21.9 degC");
  settings.scale = LinearScale{.gain = 0.01, .offset = -273.15};
  const fs::path tenths = write("b.tiff", cv::Mat(6, 8, CV_16UC1, cv::Scalar(2950)));
  refuses(tenths, settings, "likely is scale {gain: 0.1, offset: -273.15}: 21.9 to 21.9 degC");
  // Fewer than half: dead pixels, of which there may be many.
  cv::Mat dead = hundredths.clone();
  dead(cv::Rect(0, 0, 3, 6)).setTo(0);
  EXPECT_EQ(ThermalFileReader(settings).read(write("c.tiff", dead)).count.without_temperature, 18U);
}

TEST_F(ThermalFile, TemperaturesInTheOtherUnitAreTold) {
  const fs::path kelvin = write("a.tiff", cv::Mat(6, 8, CV_32FC1, cv::Scalar(295.5)));
  EXPECT_THAT(
      ThermalFileReader({}).read(kelvin).unit_doubt,
      AllOf(HasSubstr("295.5 to 295.5 degC and nothing colder"), HasSubstr("float_unit: kelvin")));
  cv::Mat furnace(6, 8, CV_32FC1, cv::Scalar(295.5));
  furnace.at<float>(0, 0) = 20;
  EXPECT_EQ(ThermalFileReader({}).read(write("b.tiff", furnace)).unit_doubt, "");
  const fs::path celsius = write("c.tiff", cv::Mat(6, 8, CV_32FC1, cv::Scalar(22.5)));
  EXPECT_EQ(ThermalFileReader({}).read(celsius).unit_doubt, "");
  ThermalSettings settings;
  settings.float_unit = TemperatureUnit::kKelvin;
  EXPECT_EQ(ThermalFileReader(settings).read(kelvin).unit_doubt, "");
  refuses(celsius, settings, "likely is float_unit: celsius in thermal.yaml: 22.5 to 22.5 degC");
}

TEST_F(ThermalFile, Counts16NeedAMeaning) {
  cv::Mat image(6, 8, CV_16UC1, cv::Scalar(30000));
  image.at<std::uint16_t>(2, 3) = 31000;
  for (const char* name : {"a.png", "a.tiff"}) {
    const fs::path file = write(name, image);
    refuses(file, {}, "must convert them, by scale or planck");
    ThermalSettings settings;
    settings.scale = LinearScale{.gain = 0.01, .offset = -273.15};
    const ThermalPicture picture = ThermalFileReader(settings).read(file);
    EXPECT_EQ(picture.kind, ThermalFileKind::kCounts16);
    EXPECT_NEAR(picture.view()(3, 2), 36.85, 1e-4);
    EXPECT_NEAR(picture.view()(0, 0), 26.85, 1e-4);
    EXPECT_FALSE(picture.radiometry.has_value());
    settings.scale.reset();
    settings.planck =
        thermal::PlanckConstants{.r1 = 21106.77, .r2 = 0.012545258, .b = 1501, .f = 1, .o = -7340};
    EXPECT_TRUE(ThermalFileReader(settings).read(file).radiometry.has_value());
  }
}

TEST_F(ThermalFile, FloatTemperatures) {
  cv::Mat image(6, 8, CV_32FC1, cv::Scalar(300.5));
  image.at<float>(1, 1) = NAN;
  image.at<float>(1, 2) = INFINITY;
  image.at<float>(1, 3) = 9999;
  image.at<float>(1, 4) = 3.4e38F;
  image.at<float>(1, 5) = -9999;
  const fs::path file = write("a.tiff", image);
  const ThermalPicture celsius = ThermalFileReader({}).read(file);
  EXPECT_EQ(celsius.kind, ThermalFileKind::kTemperature32);
  EXPECT_FLOAT_EQ(celsius.degrees[0], 300.5F);
  EXPECT_EQ(celsius.count.without_temperature, 5U);
  EXPECT_TRUE(std::isnan(celsius.view()(2, 1)));
  EXPECT_TRUE(std::isnan(celsius.view()(3, 1)));
  ThermalSettings settings;
  settings.float_unit = TemperatureUnit::kKelvin;
  EXPECT_NEAR(ThermalFileReader(settings).read(file).degrees[0], 27.35, 1e-3);
}

TEST_F(ThermalFile, GreyOfARange) {
  cv::Mat image(6, 8, CV_8UC1, cv::Scalar(51));
  image.at<std::uint8_t>(0, 0) = 255;
  const fs::path file = write("a.png", image);
  refuses(file, {}, "must convert them, by grey");
  ThermalSettings settings;
  settings.grey = GreyScale{.black = 100, .white = 300};
  const ThermalPicture picture = ThermalFileReader(settings).read(file);
  EXPECT_FLOAT_EQ(picture.degrees[1], 140);
  EXPECT_EQ(picture.count.above_range, 1U);
}

TEST_F(ThermalFile, PicturesCutShort) {
  ThermalSettings settings;
  settings.scale = LinearScale{.gain = 1, .offset = 0};
  cv::Mat image(64, 64, CV_16UC1);
  cv::RNG random(3);
  random.fill(image, cv::RNG::UNIFORM, 0, 65536);
  for (const char* name : {"whole.png", "whole.tiff"}) {
    const std::string bytes = content(write(name, image));
    refuses(write(std::string("half_") + name, bytes.substr(0, bytes.size() / 2)), settings,
            "truncated");
  }
}

TEST_F(ThermalFile, AMissingExiftoolIsNamed) {
  const fs::path file = write("a.fff", test::SyntheticFlir{}.bytes());
  EXPECT_THAT([&] { (void)ThermalFileReader({}, "/nowhere/exiftool").read(file); },
              ThrowsMessage<ThermalFileError>(AllOf(StartsWith(file.string()),
                                                    HasSubstr("cannot run /nowhere/exiftool"),
                                                    HasSubstr("libimage-exiftool-perl"))));
  EXPECT_THAT([&] { (void)ThermalFileReader({}, "/bin/cat").read(file); },
              ThrowsMessage<ThermalFileError>(StartsWith(file.string())));
}

TEST(HasThermalExtension, InAnyCase) {
  for (const char* name : {"a.jpg", "a.JPEG", "b.Fff", "c.png", "d.TIF", "d.tiff"}) {
    EXPECT_TRUE(has_thermal_extension(name)) << name;
  }
  for (const char* name : {"a.csv", "jpg", ".jpg", "a.jpg.txt"}) {
    EXPECT_FALSE(has_thermal_extension(name)) << name;
  }
}

}  // namespace
}  // namespace pipescout
