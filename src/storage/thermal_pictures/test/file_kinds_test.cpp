// SPDX-License-Identifier: Apache-2.0
// What cameras and geographic software put into files beside an image: sequences, clocks that were
// never set, texts that are none, and values of missing pixels.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "pipescout/thermal_files/testing/synthetic_files.hpp"
#include "pipescout/thermal_files/testing/synthetic_flir.hpp"
#include "pipescout/thermal_files/thermal_file.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Optional;
using ::testing::ThrowsMessage;

class FileKinds : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("file_kinds_" + std::to_string(::getpid()) + "_" + test->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }

  fs::path folder_;
};

std::string frame(std::uint16_t count, std::uint32_t taken) {
  test::SyntheticFlir flir;
  flir.counts.assign(flir.counts.size(), count);
  flir.median = count;
  flir.taken = taken;
  return flir.bytes();
}

std::string jpeg() {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", cv::Mat(6, 8, CV_8UC1, cv::Scalar(9)), bytes);
  return {bytes.begin(), bytes.end()};
}

TEST_F(FileKinds, ASequenceIsReadFrameByFrame) {
  // Some cameras fill up between frames.
  const std::string bytes = frame(20000, 1700000000) + frame(20100, 1700000001) +
                            std::string(1000, '\0') + frame(20200, 1700000002);
  for (const char* name : {"a.seq", "b.csq", "c.fff"}) {
    const fs::path file = write(name, bytes);
    EXPECT_TRUE(has_thermal_extension(file));
    const auto frames = ThermalFileReader::frames(file);
    ASSERT_EQ(frames.size(), 3U) << name;
    ThermalFileReader reader({});
    for (std::size_t i = 0; i < 3; ++i) {
      const ThermalPicture picture = reader.read(file, frames, i);
      EXPECT_EQ(picture.counts.front(), 20000 + 100 * i);
      EXPECT_THAT(picture.taken, Optional(1700000000.0 + static_cast<double>(i)));
      EXPECT_EQ(frames[i].taken, picture.taken);
    }
  }
}

TEST_F(FileKinds, AFrameThatIsCutShortIsNamed) {
  const std::string whole = frame(20000, 1700000000);
  const fs::path file = write("a.seq", whole + whole.substr(0, whole.size() / 2));
  const auto frames = ThermalFileReader::frames(file);
  ASSERT_EQ(frames.size(), 2U);
  ThermalFileReader reader({});
  EXPECT_EQ(reader.read(file, frames, 0).counts.front(), 20000);
  EXPECT_THAT([&] { (void)reader.read(file, frames, 1); },
              ThrowsMessage<ThermalFileError>(HasSubstr("a.seq: frame 2: ")));
}

TEST_F(FileKinds, AnyOtherFileIsOneImage) {
  for (const std::string& bytes :
       {std::string("FFF"), std::string("no image"), std::string(),
        std::string("FFF\0", 4) + std::string(100, '\xff'), frame(1, 1).substr(0, 40)}) {
    const auto frames = ThermalFileReader::frames(write("a.seq", bytes));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].size, bytes.size());
  }
  EXPECT_EQ(ThermalFileReader::frames(folder_).size(), 1U);
  EXPECT_EQ(ThermalFileReader::frames(folder_ / "missing").size(), 1U);
}

TEST_F(FileKinds, ExifHasTheTimeWhereTheClockOfTheBlockWasNotSet) {
  const std::string block = frame(20118, 0);
  const ThermalPicture picture = ThermalFileReader({}).read(
      write("a.jpg", test::jpeg_with(jpeg(), block, "2024:05:06 07:08:10")));
  EXPECT_THAT(picture.taken, Optional(1714979290.0));
  EXPECT_THAT(picture.doubts, Contains(HasSubstr("taken for UTC")));
  EXPECT_FALSE(
      ThermalFileReader({}).read(write("b.jpg", test::jpeg_with(jpeg(), block, ""))).taken);
  const ThermalPicture set = ThermalFileReader({}).read(write(
      "c.jpg", test::jpeg_with(jpeg(), frame(20118, 1700000000), "2024:05:06 07:08:10+01:00")));
  EXPECT_THAT(set.taken, Optional(1700000000.0));
  EXPECT_THAT(set.doubts, Not(Contains(HasSubstr("taken"))));
}

TEST_F(FileKinds, TimesOfManyFilesAtOnce) {
  const std::string seq = frame(1, 1700000003) + frame(1, 1700000004);
  std::vector<fs::path> files{
      write("-b.jpg", test::jpeg_with(jpeg(), "", "2024:05:06 07:08:10+02:00")),
      write("a.seq", seq),
      write("grey.jpg", jpeg()),
      write("empty.jpg", ""),
      folder_ / "missing.jpg",
      folder_,
      write("c.jpg", test::jpeg_with(jpeg(), frame(20118, 5), "2024:05:06 07:08:10.5"))};
  const ThermalFileReader reader({});
  EXPECT_THAT(reader.times(files),
              ElementsAre(Optional(1714972090.0), Optional(1700000003.0), std::nullopt,
                          std::nullopt, std::nullopt, std::nullopt, Optional(1714979290.5)));
  files.assign(450, files[0]);
  EXPECT_THAT(reader.times(files), ::testing::SizeIs(450));
  EXPECT_THAT([&] { (void)ThermalFileReader({}, "/nowhere/exiftool").times(files); },
              ThrowsMessage<ThermalFileError>(HasSubstr("cannot run /nowhere/exiftool")));
}

TEST_F(FileKinds, TextsThatNobodyCanReadAreLeftOut) {
  test::SyntheticFlir flir;
  flir.camera = "T420 \xae";
  flir.lens = "\xff\xfe\xfd\xfc";
  const ThermalPicture picture = ThermalFileReader({}).read(write("a.fff", flir.bytes()));
  EXPECT_EQ(picture.camera, "T420");
  EXPECT_EQ(picture.lens, "");
}

TEST_F(FileKinds, PixelsWithoutDataHaveNoTemperature) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const char* missing : {"-999", "-999.0", " -9.99e2 ", "+40"}) {
    const std::vector<float> degrees{20, -999, 30, nan, 40, 50};
    const fs::path file = write("a.tif", test::tiff_with_missing(degrees, 3, missing));
    const ThermalPicture picture = ThermalFileReader({}).read(file);
    const bool forty = std::string_view(missing) == "+40";
    EXPECT_EQ(std::isnan(picture.degrees[4]), forty) << missing;
    EXPECT_TRUE(std::isnan(picture.degrees[1]));
    EXPECT_FLOAT_EQ(picture.degrees[5], 50);
    EXPECT_EQ(picture.count.without_temperature, forty ? 3U : 2U);
  }
  for (const char* missing : {"", "nan", "none", "12,5"}) {
    const fs::path file = write("b.tif", test::tiff_with_missing<float>({20, 30}, 2, missing));
    EXPECT_EQ(ThermalFileReader({}).read(file).count.without_temperature, 0U) << missing;
  }
}

TEST_F(FileKinds, CountsWithoutDataHaveNoTemperature) {
  ThermalSettings settings;
  settings.scale = LinearScale{0.01, -100};
  const fs::path file =
      write("a.tif", test::tiff_with_missing<std::uint16_t>({12000, 0, 12100, 65535}, 2, "0"));
  const ThermalPicture picture = ThermalFileReader(settings).read(file);
  EXPECT_TRUE(std::isnan(picture.degrees[1]));
  EXPECT_FLOAT_EQ(picture.degrees[2], 21);
  EXPECT_FALSE(std::isnan(picture.degrees[3]));
  EXPECT_EQ(picture.count.without_temperature, 1U);
}

}  // namespace
}  // namespace pipescout
