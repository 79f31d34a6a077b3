// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_files/temperature_export.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

namespace pipescout {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class TemperatureExport : public ::testing::Test {
 protected:
  void TearDown() override { fs::remove(file_); }

  void write(const std::string& text) const { std::ofstream(file_, std::ios::binary) << text; }
  void write_zipped(const std::string& text) const {
    gzFile stream = ::gzopen(file_.c_str(), "wb");
    ASSERT_EQ(::gzwrite(stream, text.data(), static_cast<unsigned>(text.size())),
              static_cast<int>(text.size()));
    ASSERT_EQ(::gzclose(stream), Z_OK);
  }

  fs::path file_ =
      fs::temp_directory_path() / ("temperature_export_" + std::to_string(::getpid()) + ".csv");
};

TEST_F(TemperatureExport, IsReadWholeOrZipped) {
  write("33.33,-4.5\r\n0.125,1e2\r\n");
  EXPECT_THAT(read_temperature_export(file_), ElementsAre(33.33F, -4.5F, 0.125F, 100.0F));
  write_zipped("33.33,-4.5\n0.125,1e2\n");
  EXPECT_THAT(read_temperature_export(file_), ElementsAre(33.33F, -4.5F, 0.125F, 100.0F));
}

TEST_F(TemperatureExport, RefusesWhatIsNoneOrNotWhole) {
  const auto refused = [this](const char* text) {
    EXPECT_THAT([this] { (void)read_temperature_export(file_); },
                ThrowsMessage<ThermalFileError>(
                    ::testing::AllOf(HasSubstr(file_.string()), HasSubstr(text))));
  };
  refused("cannot be opened");
  write("1.5,warm,2");
  refused("value 2 is not a number");
  write("1.5,2x");
  refused("value 2 is not a number");
  std::string much;
  for (int i = 0; i < 20000; ++i) {
    much += std::to_string(0.001 * i) + ",";
  }
  write_zipped(much);
  fs::resize_file(file_, fs::file_size(file_) / 2);
  refused("truncated");
}

TEST_F(TemperatureExport, ErrorsAreOverAllPixels) {
  ThermalPicture picture;
  picture.degrees = {10, 20, 30, 40};
  const TemperatureError error = temperature_error(picture, std::vector<float>{10, 20.5, 29, 40});
  EXPECT_NEAR(error.mean_abs, 0.375, 1e-9);
  EXPECT_NEAR(error.max_abs, 1, 1e-9);
  picture.degrees[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isinf(temperature_error(picture, std::vector<float>{10, 20, 30, 40}).max_abs));
  EXPECT_THROW((void)temperature_error(picture, std::vector<float>{10}), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout
