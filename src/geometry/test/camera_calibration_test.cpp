// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/camera_calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace pipescout::geometry {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(SetDistortion, IsUndoneByRosDistortion) {
  struct Case {
    const char* model;
    std::vector<double> d;
  };
  const std::vector<Case> cases{{"plumb_bob", {-0.1, 0.2, 0.3, 0.4, 0.5}},
                                {"rational_polynomial", {1, 2, 3, 4, 5, 6, 7, 8}},
                                {"equidistant", {0.1, 0.2, 0.3, 0.4}}};
  CameraParameters camera;
  for (const Case& each : cases) {
    set_distortion(each.model, each.d, camera);
    const RosDistortion back = ros_distortion(camera);
    EXPECT_EQ(back.model, each.model);
    EXPECT_EQ(back.d, each.d);
  }
}

TEST(SetDistortion, ReplacesWhatWasThere) {
  CameraParameters camera{.k1 = 1, .p2 = 2, .k6 = 3, .lens = LensModel::kEquidistant};
  set_distortion("plumb_bob", std::vector{0.25}, camera);
  EXPECT_THAT(ros_distortion(camera).d, ElementsAre(0.25, 0, 0, 0, 0));
  set_distortion("", {}, camera);
  EXPECT_FALSE(Camera(camera).has_distortion());
}

TEST(SetDistortion, NamesWhatIsWrong) {
  CameraParameters camera;
  const auto set = [&camera](const char* model, const std::vector<double>& d) {
    return [&camera, model, d] { set_distortion(model, d, camera); };
  };
  EXPECT_THAT(set("fov", {}), ThrowsMessage<std::invalid_argument>(
                                  HasSubstr("distortion_model is 'fov'; it must be plumb_bob")));
  EXPECT_THAT(set("plumb_bob", {0, 0, 0, 0, 0, 0.1}),
              ThrowsMessage<std::invalid_argument>(HasSubstr("d[5] is 0.1; it must be 0")));
  EXPECT_THAT(set("equidistant", {0, 0, 0, 0, 0.5}),
              ThrowsMessage<std::invalid_argument>(HasSubstr("d[4] is 0.5")));
  EXPECT_THAT(set("", {0.5}), ThrowsMessage<std::invalid_argument>(HasSubstr("d[0] is 0.5")));
}

}  // namespace
}  // namespace pipescout::geometry
