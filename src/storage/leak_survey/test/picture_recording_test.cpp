// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_survey/picture_recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <vector>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/leak_survey/survey_poses.hpp"
#include "threshold_reader.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::TemporaryFolder;
using ::testing::ThrowsMessage;

constexpr int kWidth = 12;
constexpr int kHeight = 7;

geometry::CameraParameters camera() {
  geometry::CameraParameters camera;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.focal_length = 25.1;
  camera.centre_u = 5.6;
  camera.centre_v = 3.1;
  camera.k1 = 0.01;
  return camera;
}

struct Counts {
  std::vector<std::uint16_t> values = std::vector<std::uint16_t>(kWidth * kHeight, 300);
  [[nodiscard]] ThermalView view() const {
    return thermal::CountView{values.data(), kWidth, kHeight, kWidth};
  }
};

TEST(ToTiff, EachPixelIsReadBackAsItWas) {
  const TemporaryFolder folder;
  ThermalSettings settings;
  settings.scale = {.gain = 0.01, .offset = -100};  // any count is a temperature that a scene has
  settings.grey = {.black = 0, .white = 255};
  ThermalFileReader reader(settings);
  EXPECT_TRUE(rc::check([&](const std::vector<std::uint32_t>& bits, bool floats, bool padded) {
    const int width = 1 + static_cast<int>(bits.size() % 9);
    const int stride = width + (padded ? 3 : 0);
    const int height = 1 + static_cast<int>(bits.size()) / stride;
    const std::size_t pixels = static_cast<std::size_t>(stride) * static_cast<std::size_t>(height);
    const fs::path file = folder.path() / "picture.tiff";
    std::vector<std::uint16_t> counts(pixels);
    std::vector<float> degrees(pixels);
    for (std::size_t i = 0; i < bits.size(); ++i) {
      counts[i] = static_cast<std::uint16_t>(bits[i]);
      const auto value = std::bit_cast<float>(bits[i]);
      degrees[i] = std::abs(value) < 200 ? value : std::numeric_limits<float>::quiet_NaN();
    }
    std::ofstream(file, std::ios::binary)
        << (floats ? to_tiff(thermal::TemperatureView{degrees.data(), width, height, stride})
                   : to_tiff(thermal::CountView{counts.data(), width, height, stride}));
    const ThermalPicture picture = reader.read(file);
    RC_ASSERT(picture.width == width);
    RC_ASSERT(picture.height == height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const auto from = static_cast<std::size_t>(y * stride + x);
        const auto to = static_cast<std::size_t>(y * width + x);
        if (!floats) {
          RC_ASSERT(picture.counts[to] == counts[from]);
        } else if (std::isnan(degrees[from])) {
          RC_ASSERT(std::isnan(picture.degrees[to]));
        } else {
          RC_ASSERT(picture.degrees[to] == degrees[from]);
        }
      }
    }
  }));
  const std::vector<std::uint8_t> greys{0, 1, 128, 254, 255, 7};
  std::ofstream(folder.path() / "grey.tiff", std::ios::binary)
      << to_tiff(thermal::GreyView{greys.data(), 3, 2, 3});
  const ThermalPicture picture = reader.read(folder.path() / "grey.tiff");
  EXPECT_EQ(picture.kind, ThermalFileKind::kGrey8);
  EXPECT_TRUE(std::equal(greys.begin(), greys.end(), picture.counts.begin()));
  EXPECT_THROW((void)to_tiff(thermal::GreyView{}), std::invalid_argument);
}

TEST(PictureRecording, TellsAllThatASurveyNeeds) {
  const TemporaryFolder folder;
  const fs::path pictures = folder.path() / "a" / "pictures";
  ThermalSettings thermal;
  thermal.object = ObjectChanges::to({.emissivity = 0.71, .distance = 9.3});
  thermal.planck = {.r1 = 21106.77, .r2 = 0.012545258, .b = 1501, .f = 1, .o = -7340};
  thermal.deviations.emissivity = 0.1 / 3;
  SurveySettings survey;
  survey.parameters = "{threshold: 95.5}";
  survey.findings.T_base_camera = geometry::SE3(geometry::SO3(), {0, 0, 9});
  // On an arm: 2 m above the base, which a roll of the robot swings to the side.
  leak_findings::Frame frame{.time = 1.0 / 3, .number = 1, .pose = leak_findings::FramePose{}};
  frame.pose->T_map_base = geometry::SE3(geometry::SO3(), {5, 6, 0});
  frame.pose->covariance.diagonal() << 0.01, 0.01, 0.01, 1e-4, 1e-6, 1e-6;
  frame.T_base_camera =
      geometry::SE3(geometry::SO3::from_roll_pitch_yaw({-M_PI / 2, 0, 0}), {0, 0, 2});
  {
    PictureRecording recording(pictures, thermal, survey);
    recording.add(Counts{}.view(), frame, camera());
    frame.time = 2.0 / 3;
    frame.pose.reset();
    recording.add(Counts{}.view(), frame, camera());
    EXPECT_EQ(recording.pictures(), 2U);
  }
  const ThermalSettings t = read_thermal_settings(pictures / kThermalFile);
  EXPECT_EQ(t.object.apply({}).emissivity, 0.71);
  EXPECT_EQ(t.object.apply({}).distance, 9.3);
  EXPECT_EQ(t.planck->r2, 0.012545258);
  EXPECT_EQ(t.deviations.emissivity, 0.1 / 3);
  const SurveySettings s = parse_survey_settings(testing::content(pictures / kSurveyFile),
                                                 "survey.yaml", test::read_threshold);
  EXPECT_EQ(s.detector.threshold, 95.5);
  EXPECT_EQ(s.camera->k1, 0.01);
  EXPECT_LT(s.findings.T_base_camera.log().norm(), 1e-15);
  const SurveyPoses poses =
      parse_survey_poses(testing::content(pictures / kPosesFile), "poses.csv", s);
  ASSERT_EQ(poses.by_file.size(), 2U);
  const PicturePose& first = poses.by_file.at("00000001.tiff");
  EXPECT_EQ(first.time, 1.0 / 3);
  EXPECT_LT((first.pose->T_map_base.translation() - Eigen::Vector3d(5, 6, 2)).norm(), 1e-12);
  EXPECT_NEAR(first.pose->covariance(1, 1), 0.01 + 4 * 1e-4, 1e-12) << "swung by the roll";
  EXPECT_NEAR(first.pose->covariance(3, 3), 1e-4, 1e-12);
  EXPECT_FALSE(poses.by_file.at("00000002.tiff").pose.has_value());
  EXPECT_EQ(poses.by_file.at("00000002.tiff").time, 2.0 / 3);
}

TEST(PictureRecording, NeedsAFolderOfItsOwn) {
  const TemporaryFolder folder;
  const fs::path pictures = folder.path() / "pictures";
  { PictureRecording(pictures, {}, {}).add(Counts{}.view(), {.time = 1}, camera()); }
  const std::string before = testing::content(pictures / kPosesFile);
  EXPECT_THAT([&] { PictureRecording(pictures, {}, {}); },
              ThrowsMessage<std::runtime_error>(HasSubstr(pictures.string() + ": is not empty")));
  EXPECT_EQ(testing::content(pictures / kPosesFile), before);
  EXPECT_TRUE(fs::exists(pictures / "00000001.tiff"));
  std::ofstream(folder.path() / "file") << "no folder";
  EXPECT_THAT([&] { PictureRecording(folder.path() / "file" / "pictures", {}, {}); },
              ThrowsMessage<std::system_error>(HasSubstr("file/pictures")));
}

TEST(PictureRecording, WithoutPicturesLeavesNothingBehind) {
  const TemporaryFolder folder;
  const fs::path pictures = folder.path() / "pictures";
  { const PictureRecording recording(pictures, {}, {}); }
  EXPECT_FALSE(fs::exists(pictures));
}

TEST(PictureRecording, APictureThatCannotBeWrittenIsLeftOutAndTheNextOneIsFine) {
  const TemporaryFolder folder;
  const fs::path pictures = folder.path() / "pictures";
  PictureRecording recording(pictures, {}, {});
  const fs::path obstacle = pictures / "00000001.tiff.tmp";
  fs::create_directory(obstacle);
  EXPECT_THROW(recording.add(Counts{}.view(), {.time = 1}, camera()), std::system_error);
  fs::remove(obstacle);
  recording.add(Counts{}.view(), {.time = 2}, camera());
  const SurveyPoses poses =
      parse_survey_poses(testing::content(pictures / kPosesFile), "poses.csv", {});
  ASSERT_EQ(poses.by_file.size(), 1U);
  EXPECT_EQ(poses.by_file.at("00000001.tiff").time, 2);
}

}  // namespace
}  // namespace pipescout
