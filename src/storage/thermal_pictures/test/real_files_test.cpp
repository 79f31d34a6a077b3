// SPDX-License-Identifier: Apache-2.0
// Pictures of five FLIR cameras, and what the maker's own software exported of one of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "pipescout/thermal_files/flir_reference.hpp"
#include "pipescout/thermal_files/thermal_file.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

class RealFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* shared = std::getenv("PIPESCOUT_SHARED_DATA");
    folder_ = fs::path(shared == nullptr ? "" : shared) / "thermal_flir";
    if (!fs::exists(folder_ / kFlirReferenceFile)) {
      GTEST_SKIP() << "NOT TESTED on real thermal pictures: PIPESCOUT_SHARED_DATA names no folder "
                      "with thermal_flir/iguana_sc660.jpg";
    }
  }
  [[nodiscard]] ThermalPicture read(const std::string& name,
                                    const ThermalSettings& settings = {}) const {
    return ThermalFileReader(settings).read(folder_ / name);
  }

  fs::path folder_;
};

TEST_F(RealFiles, AgreeWithOtherSoftware) {
  const FlirReferenceErrors errors = score_flir_reference(folder_);
  // Half of the last digit printed is all that may be off.
  EXPECT_LE(errors.thermacam.mean_abs, 0.026);
  EXPECT_LE(errors.thermacam.max_abs, 0.0501);
  EXPECT_LE(errors.research.mean_abs, 0.0005);
  EXPECT_LE(errors.research.max_abs, 0.001);
  EXPECT_LE(errors.decoded.max_abs, 0.02);
}

TEST_F(RealFiles, TellWhatToDoubt) {
  EXPECT_THAT(read("conveyor_zenmuse_xtr.jpg").doubts, Contains(HasSubstr("emissivity 0.7")));
  EXPECT_THAT(read("pipe_ax8.jpg").doubts, Contains(HasSubstr("clock was not set")));
  EXPECT_THAT(read("fluorescent_tubes_t650sc.jpg").doubts,
              Contains(HasSubstr("unchanged factory defaults")));
  const ThermalPicture duo = read("duo_pro_r_640x512.fff");
  ASSERT_TRUE(duo.place.has_value());
  EXPECT_NEAR(duo.place->latitude, 53.4489064, 1e-6);
  EXPECT_NEAR(duo.place->longitude, -2.8150262, 1e-6);
}

TEST_F(RealFiles, CutShortAreRefused) {
  const fs::path whole = folder_ / "iguana_sc660.jpg";
  const fs::path cut = fs::temp_directory_path() / ("cut_" + std::to_string(::getpid()) + ".jpg");
  for (const std::uintmax_t size : {100000U, 300000U, 600000U}) {
    fs::copy_file(whole, cut, fs::copy_options::overwrite_existing);
    fs::permissions(cut, fs::perms::owner_all);
    fs::resize_file(cut, size);
    EXPECT_THAT([&] { (void)ThermalFileReader({}).read(cut); },
                ::testing::ThrowsMessage<ThermalFileError>(::testing::StartsWith(cut.string())));
  }
  fs::remove(cut);
}

TEST_F(RealFiles, VisibleLightIsNoThermalPicture) {
  EXPECT_THAT([&] { (void)read("pipe_ax8_visible.jpg"); },
              ::testing::ThrowsMessage<ThermalFileError>(HasSubstr("is a colour image")));
}

}  // namespace
}  // namespace pipescout
