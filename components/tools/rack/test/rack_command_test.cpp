// SPDX-License-Identifier: Apache-2.0
// `pipescout rack track` on rendered images.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/compressed_image.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <string>
#include <vector>

#include "pipescout/bag_topics/bag_topic.hpp"
#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/rack_file/rack_file.hpp"
#include "pipescout/testing/program.hpp"
#include "rendered_flight.hpp"

namespace pipescout::rack {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

const std::string kRack = R"(row:
  - {name: P1, radius: 0.20, length: 10}
  - {name: P2, radius: 0.15, length: 10}
  - {name: P3, radius: 0.20, length: 10}
  - {name: P4, radius: 0.18, length: 10}
supports:
  - {name: B1, lowest_corner: [-0.3, 4.00, -0.2], highest_corner: [2.06, 4.20, 0]}
  - {name: B2, lowest_corner: [-0.3, 5.80, -0.2], highest_corner: [2.06, 6.00, 0]}
)";
const std::string kCamera = R"(image_width: 360
image_height: 240
camera_name: down
camera_matrix: {rows: 3, cols: 3, data: [315, 0, 180, 0, 315, 120, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.1, 0.02, 0, 0, 0]}
)";
constexpr std::size_t kImages = 12;

geometry::Camera camera() {
  return geometry::Camera({.width = 360,
                           .height = 240,
                           .focal_length = 315,
                           .centre_u = 180,
                           .centre_v = 120,
                           .k1 = -0.1,
                           .k2 = 0.02});
}

class RackTrack : public ::testing::Test {
 protected:
  RackTrack() {
    write_text("rack.yaml", kRack);
    write_text("camera.yaml", kCamera);
  }
  void write_text(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name) << text;
  }
  void write_images(std::size_t count = kImages) {
    flight().write(folder_.path() / "images", count);
  }
  test::RenderedFlight flight() { return test::RenderedFlight(parse_rack(kRack, "rack"), camera_); }

  template <class T>
  static void write(bags::BagWriter& writer, const std::string& topic, const T& message,
                    std::int64_t time) {
    const MessageType& type = message_type<T>();
    std::vector<std::byte> data(type.serialized_size(&message));
    ASSERT_EQ(type.serialize(&message, data), data.size());
    writer.write({.topic = writer.add_topic(make_bag_topic(topic, std::string(type.name), {})),
                  .log_time = time,
                  .publish_time = time,
                  .data = data});
  }

  [[nodiscard]] testing::Finished run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "track");
    return testing::run_program(RACK_COMMAND, arguments, folder_.path());
  }
  [[nodiscard]] testing::Finished track(const std::string& images,
                                        const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{images,    "--rack", "rack.yaml", "--out", "out",
                                       "--start", "0.92",   "4.58",      "2.69"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  [[nodiscard]] std::string content(const std::string& file) const {
    return testing::content(folder_.path() / "out" / file);
  }
  /// Position in the last line of the TUM file, and the number of lines.
  [[nodiscard]] std::pair<Eigen::Vector3d, std::size_t> last_position() const {
    std::ifstream file(folder_.path() / "out" / "poses.tum");
    Eigen::Vector3d p = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    std::size_t lines = 0;
    double time = 0, qx = 0, qy = 0, qz = 0, qw = 0, x = 0, y = 0, z = 0;
    while (file >> time >> x >> y >> z >> qx >> qy >> qz >> qw) {
      p = {x, y, z};
      ++lines;
    }
    return {p, lines};
  }
  void expect_tracked() const {
    const auto [position, lines] = last_position();
    // The tracker takes some images to confirm a start.
    EXPECT_GE(lines, 3U) << content("report.md");
    const Eigen::Vector3d truth = test::RenderedFlight::T_rack_camera(kImages - 1).translation();
    EXPECT_LT((position - truth).norm(), 0.04) << position.transpose();
  }

  testing::TemporaryFolder folder_;
  geometry::Camera camera_ = camera();
};

TEST_F(RackTrack, WritesPosesPicturesAndAReportOfAFolder) {
  write_images();
  write_text("images/cut.png", "cut off");
  const auto result = track("images", {"--camera", "camera.yaml", "--overlays", "4"});
  ASSERT_EQ(result.code(), 0) << result.out << result.err;
  expect_tracked();
  EXPECT_THAT(content("report.md"),
              AllOf(HasSubstr("camera.yaml: 360 x 240 pixels"), HasSubstr("4 pipes, 2 supports"),
                    HasSubstr("the file cannot be decoded (cut.png)"),
                    HasSubstr("| P1 | as in the file | |"), Not(HasSubstr("nan"))));
  EXPECT_EQ(content("report.md"), result.out);
  EXPECT_THAT(content("images.csv"), HasSubstr("img_12.png,tracking"));
  EXPECT_THAT(content("poses.csv"),
              AllOf(HasSubstr("stamp,x,y,z,qx"), HasSubstr("_correlation,image\n"),
                    HasSubstr(",img_12.png\n"), Not(HasSubstr("cut.png"))));
  std::size_t pictures = 0;
  for (const auto& entry : fs::directory_iterator(folder_.path() / "out" / "overlays")) {
    const cv::Mat picture = cv::imread(entry.path().string());
    EXPECT_EQ(picture.cols, 360);
    ++pictures;
  }
  EXPECT_GE(pictures, 4U);
  const auto again = track("images", {"--camera", "camera.yaml"});
  EXPECT_EQ(again.code(), 1);
  EXPECT_THAT(again.err, HasSubstr("out: is not empty ("));
}

TEST_F(RackTrack, ReadsABagWithItsCalibration) {
  {
    bags::BagWriter writer(folder_.path() / "bag", {});
    auto images = flight();
    for (std::size_t i = 0; i < kImages; ++i) {
      const cv::Mat grey = images.image(i);
      const std::int64_t time =
          1'700'000'000'000'000'000 + static_cast<std::int64_t>(i) * 33'000'000;
      sensor_msgs::msg::CameraInfo info = to_message(camera_.parameters());
      write(writer, "/camera/camera_info", info, time);
      sensor_msgs::msg::Image message;
      message.header.stamp.sec = static_cast<std::int32_t>(time / 1'000'000'000);
      message.header.stamp.nanosec = static_cast<std::uint32_t>(time % 1'000'000'000);
      message.width = 360;
      message.height = 240;
      message.step = 360;
      message.encoding = "mono8";
      message.data.assign(grey.data, grey.data + grey.total());
      write(writer, "/camera/image_raw", message, time);
      sensor_msgs::msg::CompressedImage compressed;
      compressed.header = message.header;
      compressed.format = "png";
      std::vector<std::uint8_t> bytes;
      cv::imencode(".png", grey, bytes);
      compressed.data = bytes;
      write(writer, "/camera/image_raw/compressed", compressed, time);
    }
    writer.close();
  }
  const auto several = track("bag");
  EXPECT_EQ(several.code(), 1);
  EXPECT_THAT(several.err, AllOf(HasSubstr("several topics"), HasSubstr("/camera/image_raw")));
  const auto raw = track("bag", {"--topic", "/camera/image_raw"});
  ASSERT_EQ(raw.code(), 0) << raw.out << raw.err;
  expect_tracked();
  EXPECT_THAT(content("report.md"), HasSubstr("topic /camera/camera_info: 360 x 240"));
  const std::string poses = content("poses.tum");
  EXPECT_THAT(content("poses.csv"), HasSubstr(",/camera/image_raw 11\n"));
  fs::remove_all(folder_.path() / "out");
  const auto compressed = track("bag", {"--topic", "/camera/image_raw/compressed"});
  ASSERT_EQ(compressed.code(), 0) << compressed.out << compressed.err;
  EXPECT_EQ(content("poses.tum"), poses);
}

TEST_F(RackTrack, SaysWhatIsMissingOrWrong) {
  write_images(2);
  const auto expect = [&](const std::vector<std::string>& arguments, int code,
                          const std::string& said) {
    const auto result = run(arguments);
    EXPECT_EQ(result.code(), code) << said;
    EXPECT_THAT(result.err, HasSubstr(said));
  };
  expect({"images", "--rack", "rack.yaml", "--out", "out"}, 1, "need --camera");
  expect({"nowhere", "--rack", "rack.yaml", "--out", "out"}, 1, "nowhere: no such file");
  expect({"images", "--camera", "camera.yaml", "--out", "out"}, 2, "--rack is required");
  expect(
      {"images", "--rack", "rack.yaml", "--camera", "camera.yaml", "--topic", "/a", "--out", "out"},
      1, "--topic is for bags");
  write_text("bad.yaml", "row: [{name: P1, radius: -1, length: 10}]\n");
  expect({"images", "--rack", "bad.yaml", "--camera", "camera.yaml", "--out", "out"}, 1,
         "bad.yaml:1:");
  write_text("bad.yaml", "image_width: 360\n");
  expect({"images", "--rack", "rack.yaml", "--camera", "bad.yaml", "--out", "out"}, 1,
         "bad.yaml:1:1: field 'image_height' is missing");
  std::string small = kCamera;
  small.replace(small.find("360"), 3, "350");
  write_text("small.yaml", small);
  expect({"images", "--rack", "rack.yaml", "--camera", "small.yaml", "--out", "out"}, 1,
         "img_1.png: the image has 360 x 240 pixels; the camera's calibration is for 350 x 240");
}

TEST_F(RackTrack, SaysThatARackThatIsTheSameFromBothEndsIsAmbiguous) {
  const std::string symmetric = R"(row:
  - {name: P1, radius: 0.20, length: 10}
  - {name: P2, radius: 0.12, length: 10, gap: 0.25}
  - {name: P3, radius: 0.15, length: 10, gap: 0.1}
  - {name: P4, radius: 0.12, length: 10, gap: 0.1}
  - {name: P5, radius: 0.20, length: 10, gap: 0.25}
)";
  write_text("rack.yaml", symmetric);
  test::RenderedFlight(parse_rack(symmetric, "rack"), camera_).write(folder_.path() / "images", 4);
  const auto result =
      run({"images", "--rack", "rack.yaml", "--camera", "camera.yaml", "--out", "out"});
  EXPECT_EQ(result.code(), 1);
  EXPECT_THAT(result.err, HasSubstr("not tracked in any image"));
  EXPECT_THAT(content("report.md"), AllOf(HasSubstr("ambiguous: several poses explain the image"),
                                          HasSubstr("Give --heading, --near or --start")));
  EXPECT_EQ(last_position().second, 0U);
}

}  // namespace
}  // namespace pipescout::rack
