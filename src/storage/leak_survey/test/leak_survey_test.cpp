// SPDX-License-Identifier: Apache-2.0
// A drive past a pipe of 140 degC, drawn here, with a leak of 230 degC 20 m along it: pictures in a
// folder, and what is made of them.
#include "pipescout/leak_survey/leak_survey.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "pipescout/files/testing/comma_locale.hpp"
#include "pipescout/leak_store/leak_store.hpp"
#include "threshold_reader.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr double kDistance = 8;      // m, from the camera to the pipe
constexpr double kLeakAt = 20;       // m, along x of the map
constexpr double kLeakLength = 0.8;  // m
constexpr double kFocal = 160;       // pixels

std::string content(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

class Survey : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("leak_survey_" + std::to_string(::getpid()) + "_" + test->name());
    fs::create_directories(folder_ / "night");
    write("night/thermal.yaml", "scale: {gain: 0.01, offset: -100}\n");
    // The camera looks along y of the map: its x is that of the robot.
    write("night/survey.yaml",
          "field_of_view: " + std::to_string(2 * std::atan(0.5 * kWidth / kFocal) * 180 / M_PI) +
              "\ncamera_roll_pitch_yaw: [-90, 0, 0]\n"
              "range: {source: distance, distance: 8, distance_deviation: 0.2}\n"
              "datum: {latitude: 36.66, longitude: -5.8, altitude: 60}\n"
              "weather: clear night, 14 degC\n");
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }

  /// What the camera sees from `x`: 16-bit hundredths of a degree from -100 degC on.
  static cv::Mat picture(double x, bool leaks) {
    cv::Mat image(kHeight, kWidth, CV_16UC1);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const double along = x + (u - 0.5 * (kWidth - 1)) / kFocal * kDistance;
        const bool pipe = std::abs(v - 60) <= 6;
        const bool leak = leaks && pipe && std::abs(along - kLeakAt) <= 0.5 * kLeakLength;
        const double degrees = leak ? 230 : pipe ? 140 : 15 + (u * 7 + v * 13) % 5;
        image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>((degrees + 100) * 100);
      }
    }
    return image;
  }

  /// 30 pictures from x = 14 to 26 m, and the poses of the robot.
  void drive(const std::string& folder, bool leaks, double begin) const {
    std::string poses = "file,time,x,y,z,qx,qy,qz,qw\n";
    for (int i = 0; i < 30; ++i) {
      const double x = 14 + 0.4 * i;
      std::array<char, 32> name{};
      std::snprintf(name.data(), name.size(), "%03d.png", i);
      cv::imwrite((folder_ / folder / name.data()).string(), picture(x, leaks));
      poses += std::string(name.data()) + "," + std::to_string(begin + 0.1 * i) + "," +
               std::to_string(x) + ",0,1.5,0,0,0,1\n";
    }
    write(folder + "/poses.csv", poses);
  }

  LeakSurveyOptions options(const std::string& folder = "night") {
    LeakSurveyOptions o;
    o.read_parameters = test::read_threshold;
    o.pictures = folder_ / folder;
    o.out = folder_ / "out";
    o.made = "Made by a test";
    o.complain = [this](const std::string& problem) { problems_.push_back(problem); };
    return o;
  }

  fs::path folder_;
  std::vector<std::string> problems_;
};

TEST_F(Survey, FindsTheLeakWhereItIs) {
  drive("night", true, 1000);
  std::vector<std::size_t> steps;
  LeakSurveyOptions o = options();
  o.progress = [&steps](std::size_t done, std::size_t total) {
    EXPECT_EQ(total, 30U);
    steps.push_back(done);
  };
  const LeakSurveyResult result = survey_leaks(o);
  EXPECT_EQ(result.pictures, 30U);
  EXPECT_EQ(result.failed, 0U);
  EXPECT_EQ(result.with_pipes, 30U);
  EXPECT_EQ(result.raised, 1U);
  EXPECT_EQ(steps.size(), 31U);
  EXPECT_EQ(steps.back(), 30U);
  EXPECT_THAT(problems_, ::testing::IsEmpty());

  const LeakStore store(folder_ / "out" / "leaks.sqlite");
  const auto findings = store.findings();
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_NEAR(findings[0].mean_delta, 90, 5);
  ASSERT_TRUE(findings[0].position.has_value());
  EXPECT_NEAR(findings[0].position->point.x(), kLeakAt, 0.2);
  EXPECT_NEAR(findings[0].position->point.y(), kDistance, 0.5);
  EXPECT_NEAR(findings[0].length, kLeakLength, 0.15);
  ASSERT_TRUE(store.evidence(1).has_value());
  EXPECT_THAT(store.evidence(1)->source, HasSubstr(".png"));
  ASSERT_EQ(store.conditions().size(), 1U);
  EXPECT_EQ(store.conditions()[0].weather, "clear night, 14 degC");

  const std::string html = content(folder_ / "out" / "report.html");
  EXPECT_THAT(html, HasSubstr("id=\"leak1\""));
  EXPECT_THAT(html, HasSubstr("WGS 84: 36.66"));
  EXPECT_THAT(content(folder_ / "out" / "leaks.geojson"), HasSubstr("\"Point\""));
  EXPECT_THAT(content(folder_ / "out" / "leaks.kml"), HasSubstr("<Point>"));
  EXPECT_THAT(content(folder_ / "out" / "leaks.csv"), HasSubstr("\n1,raised,"));
}

TEST_F(Survey, TheReportIsTheSameInALocaleWithCommas) {
  drive("night", true, 1000);
  survey_leaks(options());
  const std::string kml = content(folder_ / "out" / "leaks.kml");
  const std::string html = content(folder_ / "out" / "report.html");
  const ::pipescout::testing::CommaLocale locale;
  fs::remove_all(folder_ / "out");
  survey_leaks(options());
  EXPECT_EQ(content(folder_ / "out" / "leaks.kml"), kml);
  EXPECT_EQ(content(folder_ / "out" / "report.html"), html);
}

TEST_F(Survey, AnotherDayFindsTheSameLeak) {
  drive("night", true, 1000);
  survey_leaks(options());
  fs::create_directories(folder_ / "next");
  for (const char* name : {"thermal.yaml", "survey.yaml"}) {
    fs::copy_file(folder_ / "night" / name, folder_ / "next" / name);
  }
  drive("next", true, 87400);
  survey_leaks(options("next"));
  const auto findings = LeakStore(folder_ / "out" / "leaks.sqlite").findings();
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].pass_count, 2U);
  EXPECT_NEAR(findings[0].first_time, 1001, 1);
  EXPECT_NEAR(findings[0].last_time, 87402, 1);
}

TEST_F(Survey, AutomaticGainGivesLeaksAndNoDegrees) {
  drive("night", true, 1000);
  for (int i = 0; i < 30; ++i) {
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "%03d.png", i);
    const std::string file = (folder_ / "night" / name.data()).string();
    cv::Mat grey;
    cv::imread(file, cv::IMREAD_UNCHANGED).convertTo(grey, CV_8U, 0.005 + 0.0001 * i, -50);
    cv::imwrite(file, grey);
  }
  write("night/thermal.yaml", "grey: automatic_gain\n");
  EXPECT_THAT([this] { survey_leaks(options()); },
              ThrowsMessage<std::runtime_error>(HasSubstr("it needs preset contrast")));
  LeakSurveyOptions o = options();
  o.preset = thermal::DetectorPreset::kContrast;
  const LeakSurveyResult result = survey_leaks(o);
  EXPECT_EQ(result.levels, 30U);
  EXPECT_EQ(result.raised, 1U);
  EXPECT_THAT(result.degrees, HasSubstr("nothing is told in degrees"));
  EXPECT_THAT(content(folder_ / "out" / "report.html"), HasSubstr(result.degrees));
  const LeakStore store(folder_ / "out" / "leaks.sqlite");
  ASSERT_EQ(store.findings().size(), 1U);
  EXPECT_TRUE(std::isnan(store.findings()[0].mean_delta));
  EXPECT_NEAR(store.findings()[0].position->point.x(), kLeakAt, 0.2);
  // Another day knows it again.
  EXPECT_EQ(survey_leaks(o).raised, 1U);
}

TEST_F(Survey, ByContrastTheReportSaysHowSureTheDegreesAre) {
  drive("night", true, 1000);
  const thermal::Radiometry radiometry(
      {.planck = {.r1 = 21106.77, .r2 = 0.012545258, .b = 1501, .f = 1, .o = -7340}},
      {.emissivity = 0.06, .reflected_temperature = 4, .distance = 8});
  for (int i = 0; i < 30; ++i) {
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "%03d.png", i);
    const std::string file = (folder_ / "night" / name.data()).string();
    cv::Mat image = cv::imread(file, cv::IMREAD_UNCHANGED);
    image.forEach<std::uint16_t>([&](std::uint16_t& value, const int*) {
      value = static_cast<std::uint16_t>(radiometry.counts(value / 100.0 - 100));
    });
    cv::imwrite(file, image);
  }
  write("night/thermal.yaml",
        "preset: ibarguren2013\nplanck: {r1: 21106.77, r2: 0.012545258, b: 1501, f: 1, o: -7340}\n"
        "deviations: {reflected_temperature: 6, emissivity: 0.02}\n");
  LeakSurveyOptions o = options();
  o.preset = thermal::DetectorPreset::kContrast;
  const LeakSurveyResult result = survey_leaks(o);
  EXPECT_EQ(result.raised, 1U);
  EXPECT_THAT(result.degrees, HasSubstr("from 30 images: sound pipe"));
  const LeakStore store(folder_ / "out" / "leaks.sqlite");
  ASSERT_EQ(store.findings().size(), 1U);
  EXPECT_LT(store.findings()[0].mean_delta_interval.low, 90);
  EXPECT_GT(store.findings()[0].mean_delta_interval.high, 90);
}

TEST_F(Survey, ASoundPipeGivesNoFinding) {
  drive("night", false, 1000);
  const LeakSurveyResult result = survey_leaks(options());
  EXPECT_EQ(result.with_pipes, 30U);
  EXPECT_EQ(result.raised, 0U);
  EXPECT_EQ(result.leak_detections, 0U);
  EXPECT_THAT(content(folder_ / "out" / "report.html"), HasSubstr("No finding."));
}

TEST_F(Survey, WithoutPosesThereAreFindingsWithoutAPlace) {
  drive("night", true, 1000);
  fs::remove(folder_ / "night/poses.csv");
  EXPECT_EQ(survey_leaks(options()).raised, 1U);
  EXPECT_FALSE(LeakStore(folder_ / "out" / "leaks.sqlite").findings()[0].position.has_value());
}

TEST_F(Survey, PicturesWithoutAPoseAreToldOnce) {
  drive("night", true, 1000);
  std::istringstream poses(content(folder_ / "night" / "poses.csv"));
  std::string changed;
  std::string line;
  for (int i = 0; std::getline(poses, line); ++i) {
    const bool unknown = i == 3 || i == 4;
    changed +=
        (unknown ? line.substr(0, line.find(',', line.find(',') + 1)) + ",,,,,,," : line) + "\n";
  }
  write("night/poses.csv", changed);
  const LeakSurveyResult result = survey_leaks(options());
  EXPECT_EQ(result.without_pose, 2U);
  EXPECT_EQ(result.raised, 1U);
  EXPECT_THAT(problems_, ::testing::ElementsAre(
                             HasSubstr("no pose for 2 of 30 pictures, the first of them 002.png")));
}

TEST_F(Survey, BrokenPicturesAreToldAndTheOthersCount) {
  drive("night", true, 1000);
  write("night/000.png", "");
  write("night/001.png", content(folder_ / "night" / "002.png").substr(0, 90));
  write("night/0045.jpg", "\xff\xd8\xff\xe0 no more of it");
  cv::imwrite((folder_ / "night" / "0071.png").string(),
              cv::Mat(9, 9, CV_8UC3, cv::Scalar(1, 2, 3)));
  cv::imwrite((folder_ / "night" / "0072.png").string(),
              cv::Mat(kHeight, kWidth, CV_16UC1, cv::Scalar(65535)));
  cv::imwrite((folder_ / "night" / "0073.tiff").string(),
              cv::Mat(kHeight, kWidth, CV_32FC1, cv::Scalar(NAN)));
  cv::imwrite((folder_ / "night" / "0074.png").string(), cv::Mat(40, 40, CV_16UC1, cv::Scalar(0)));
  write("night/notes.txt", "no picture");
  const LeakSurveyResult result = survey_leaks(options());
  EXPECT_EQ(result.raised, 1U);
  EXPECT_THAT(problems_, Contains(HasSubstr("000.png: is empty")));
  EXPECT_THAT(problems_, Contains(HasSubstr("001.png: cannot be decoded")));
  EXPECT_THAT(problems_, Contains(HasSubstr("0045.jpg: ")));
  EXPECT_THAT(problems_, Contains(HasSubstr("0071.png: is a colour image")));
  EXPECT_THAT(problems_, Contains(HasSubstr("0072.png: all pixels are the same")));
  EXPECT_THAT(problems_, Contains(HasSubstr("0073.tiff: no pixel has a temperature")));
  EXPECT_EQ(result.failed, 7U);
  EXPECT_EQ(problems_.size(), 7U);
  EXPECT_THAT(content(folder_ / "out" / "report.html"), HasSubstr("000.png: is empty"));
}

TEST_F(Survey, FalseColoursAreAdvisedOnOnce) {
  drive("night", true, 1000);
  for (const char* name : {"0071.png", "0072.png"}) {
    cv::imwrite((folder_ / "night" / name).string(),
                cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar(1, 2, 3)));
  }
  const LeakSurveyResult result = survey_leaks(options());
  EXPECT_EQ(result.failed, 2U);
  EXPECT_EQ(problems_.size(), 2U);
  EXPECT_THAT(result.advice, ::testing::ElementsAre(HasSubstr("FLIR's radiometric JPEG")));
}

TEST_F(Survey, WithoutPipesPresetsThatFindThemAreNamed) {
  for (const char* name : {"0.tiff", "1.tiff", "2.tiff"}) {
    cv::Mat image;
    picture(0, false).convertTo(image, CV_32F, 0.01, -100);
    image.setTo(85, image > 100);
    cv::imwrite((folder_ / "night" / name).string(), image);
  }
  const LeakSurveyResult result = survey_leaks(options());
  EXPECT_EQ(result.with_pipes, 0U);
  EXPECT_THAT(
      result.advice,
      ::testing::ElementsAre(HasSubstr(
          "no pipe in 3 images with preset collectors, which looks for what is above 100 degC; "
          "the images are from 15.0 to 85.0 degC. Tried on 3 of them: --preset hot_pipes finds "
          "pipes in 3")));
  LeakSurveyOptions other = options();
  other.preset = thermal::DetectorPreset::kHotPipes;
  other.out = folder_ / "other";
  EXPECT_THAT(survey_leaks(other).advice, ::testing::IsEmpty());
}

TEST_F(Survey, KelvinTakenForCelsiusIsDoubtedOnce) {
  for (const char* name : {"0.tiff", "1.tiff"}) {
    cv::Mat image;
    picture(0, false).convertTo(image, CV_32F, 0.01, -100 + 273.15);
    cv::imwrite((folder_ / "night" / name).string(), image);
  }
  (void)survey_leaks(options());
  EXPECT_THAT(problems_, Contains(HasSubstr("0.tiff: temperatures of 288.")));
  EXPECT_THAT(problems_, Not(Contains(HasSubstr("1.tiff"))));
}

TEST_F(Survey, PosesMayLieElsewhere) {
  drive("night", true, 1000);
  fs::rename(folder_ / "night/poses.csv", folder_ / "elsewhere.csv");
  LeakSurveyOptions o = options();
  o.poses = folder_ / "elsewhere.csv";
  survey_leaks(o);
  EXPECT_TRUE(LeakStore(folder_ / "out" / "leaks.sqlite").findings()[0].position.has_value());
}

TEST_F(Survey, PosesThatAreCutShortAreTold) {
  drive("night", true, 1000);
  const std::string poses = content(folder_ / "night" / "poses.csv");
  write("night/poses.csv", poses.substr(0, poses.size() - 12));
  const LeakSurveyResult result = survey_leaks(options());
  EXPECT_EQ(result.raised, 1U);
  EXPECT_EQ(result.out_of_order, 1U) << "the last picture";
  EXPECT_THAT(problems_, Contains(HasSubstr("poses.csv:31: the last line is truncated")));
}

TEST_F(Survey, ImagesAreTakenInTheOrderOfTheirTimes) {
  drive("night", true, 1000);
  std::string poses = content(folder_ / "night" / "poses.csv");
  poses.replace(poses.find("1001.0"), 6, "0900.0");
  write("night/poses.csv", poses);
  const LeakSurveyResult result = survey_leaks(options());
  EXPECT_EQ(result.out_of_order, 0U);
  EXPECT_EQ(result.raised, 1U);
  EXPECT_THAT(problems_, ::testing::IsEmpty());
}

TEST_F(Survey, ReportsShowNoMoreThanTheyMay) {
  drive("night", true, 1000);
  LeakSurveyOptions o = options();
  o.most_pictures = 5;
  survey_leaks(o);
  const std::string html = content(folder_ / "out" / "report.html");
  std::size_t shown = 0;
  for (std::size_t at = html.find("<div class=\"picture\">"); at != std::string::npos;
       at = html.find("<div class=\"picture\">", at + 1)) {
    ++shown;
  }
  EXPECT_EQ(shown, 5U);
}

TEST_F(Survey, WhatCannotBeginIsNamed) {
  const auto throws = [](const char* what) {
    return ThrowsMessage<std::runtime_error>(HasSubstr(what));
  };
  EXPECT_THAT([this] { survey_leaks(options()); }, throws("night: contains no image"));
  EXPECT_THAT([this] { survey_leaks(options("nowhere")); }, throws("nowhere"));
  drive("night", false, 0);
  write("night/survey.yaml", "preset: hot_pipes\n");
  EXPECT_THAT([this] { survey_leaks(options()); }, throws("survey.yaml: poses need the camera's"));
  write("night/survey.yaml", "presett: hot_pipes\n");
  EXPECT_THAT([this] { survey_leaks(options()); }, throws("survey.yaml:1: unknown name 'presett'"));
  fs::remove(folder_ / "night/survey.yaml");
  fs::remove(folder_ / "night/poses.csv");
  write("night/thermal.yaml", "scale: [1]\n");
  EXPECT_THAT([this] { survey_leaks(options()); }, throws("thermal.yaml:1: scale is not a map"));
}

}  // namespace
}  // namespace pipescout
