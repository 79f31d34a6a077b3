// SPDX-License-Identifier: Apache-2.0
// `pipescout bag` where it only works on files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <builtin_interfaces/msg/time.hpp>
#include <filesystem>
#include <fstream>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <vector>

#include "pipescout/bag_topics/bag_topic.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout::bag_command {
namespace {

using ::testing::AllOf;
using testing::content;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::lines;
using ::testing::StartsWith;
namespace fs = std::filesystem;

class BagCommand : public ::testing::Test {
 protected:
  BagCommand() { record("bag", {}); }

  template <class T>
  void write(bags::BagWriter& writer, const std::string& topic, const T& message,
             std::int64_t time) const {
    const MessageType& type = message_type<T>();
    std::vector<std::byte> data(type.serialized_size(&message));
    ASSERT_EQ(type.serialize(&message, data), data.size());
    writer.write({.topic = writer.add_topic(make_bag_topic(topic, std::string(type.name), {})),
                  .log_time = time,
                  .publish_time = time,
                  .data = data});
  }

  /// 10 s: a joint state every second, a pose every two, two transforms and two images.
  void record(const std::string& name, const bags::BagWriterOptions& options,
              std::int64_t offset = 0) const {
    bags::BagWriter writer(path(name), options);
    for (int second = 0; second < 10; ++second) {
      const std::int64_t time = (second + 1) * std::int64_t{1'000'000'000} + offset;
      sensor_msgs::msg::JointState joints;
      joints.header.stamp.sec = second;
      joints.name = {"shoulder", "elbow, left"};
      joints.position.assign(static_cast<std::size_t>(second % 3), 0.1 * second);
      write(writer, "/joint_states", joints, time);
      if (second % 2 == 0) {
        geometry_msgs::msg::PoseStamped pose;
        pose.header.stamp.sec = second;
        pose.pose.position.x = 1.5 * second;
        pose.pose.orientation.w = 1.0;
        write(writer, "/pose", pose, time);
      }
    }
    tf2_msgs::msg::TFMessage transforms;
    transforms.transforms.resize(2);
    transforms.transforms[0].child_frame_id = "base_link";
    transforms.transforms[0].transform.translation.y = 2.0;
    transforms.transforms[1].child_frame_id = "camera";
    write(writer, "/tf", transforms, 11'000'000'000 + offset);
    write_images(writer, 12'000'000'000 + offset);
    writer.close();
  }

  void write_images(bags::BagWriter& writer, std::int64_t time) const {
    sensor_msgs::msg::Image image;
    image.width = 2;
    image.height = 1;
    image.encoding = "rgb8";
    image.step = 8;  // with two bytes of padding
    image.data = {255, 0, 0, 0, 0, 7, 0, 0};
    write(writer, "/camera", image, time);
    image.encoding = "mono16";
    image.step = 4;
    image.is_bigendian = 1;
    image.data = {0x12, 0x34, 0xFF, 0x00};
    write(writer, "/thermal", image, time + 1);
    image.encoding = "32FC1";
    image.width = 1;
    image.is_bigendian = 0;
    image.data = {0, 0, 0xC0, 0x3F};  // 1.5
    write(writer, "/depth", image, time + 2);
  }

  [[nodiscard]] fs::path path(const std::string& name) const { return folder_.path() / name; }
  [[nodiscard]] testing::Finished run(const std::vector<std::string>& arguments) const {
    return testing::run_program(BAG_COMMAND, arguments, folder_.path());
  }
  [[nodiscard]] std::string out(const std::vector<std::string>& arguments) const {
    const auto finished = run(arguments);
    EXPECT_EQ(finished.code(), 0) << finished.err;
    EXPECT_THAT(finished.err, AnyOf(IsEmpty(), HasSubstr("note:")));
    return finished.out;
  }
  [[nodiscard]] std::string error(const std::vector<std::string>& arguments, int code = 1) const {
    const auto finished = run(arguments);
    EXPECT_EQ(finished.code(), code) << finished.out;
    return finished.err;
  }

  testing::TemporaryFolder folder_;
};

TEST_F(BagCommand, InfoShowsWhatRosbag2Shows) {
  EXPECT_THAT(out({"info", "bag"}),
              AllOf(StartsWith("Files:             bag_0.db3\nBag size:          "),
                    HasSubstr("Storage id:        sqlite3\nDuration:          11.000000002s\n"),
                    HasSubstr("(1.000000000)\n"), HasSubstr("Messages:          19\n"),
                    HasSubstr("Topic: /pose | Type: geometry_msgs/msg/PoseStamped | Count: 5 | "
                              "Serialization Format: cdr\n")));
  EXPECT_THAT(error({"info", "none"}), StartsWith("error: none: there is no such file or folder"));
}

TEST_F(BagCommand, ConvertedBagsHoldTheSame) {
  EXPECT_EQ(out({"convert", "bag", "-o", "mcap", "-s", "mcap", "--chunk-compression", "zstd"}),
            "mcap: 19 messages on 6 topics\n");
  EXPECT_EQ(
      out({"convert", "mcap", "-o", "back", "-s", "sqlite3", "--compression-mode", "message"}),
      "back: 19 messages on 6 topics\n");
  bags::BagReader before(path("bag"));
  bags::BagReader after(path("back"));
  bags::BagReader mcap(path("mcap"));
  EXPECT_THAT(mcap.topics()[0].schema_text, HasSubstr("MSG: std_msgs/Header"));
  while (const auto message = before.next()) {
    const auto same = after.next();
    ASSERT_TRUE(same);
    EXPECT_EQ(same->log_time, message->log_time);
    EXPECT_TRUE(std::equal(same->data.begin(), same->data.end(), message->data.begin(),
                           message->data.end()));
  }
  EXPECT_THAT(error({"convert", "bag", "-o", "mcap"}), HasSubstr("exists already"));
  EXPECT_THAT(error({"convert", "bag"}, 2), HasSubstr("--output is required"));
  EXPECT_THAT(error({"convert", "bag", "-o", "x", "-s", "tape"}, 2), HasSubstr("tape"));
}

TEST_F(BagCommand, FiltersByTopicAndTime) {
  EXPECT_EQ(out({"filter", "bag", "-o", "a", "--topics", "/pose", "--start", "2", "--end", "4.5"}),
            "a: 2 messages on 1 topics\n");
  EXPECT_EQ(out({"filter", "bag", "-o", "b", "-e", "joint|tf", "-x", "^/tf$"}),
            "b: 10 messages on 1 topics\n");
  EXPECT_THAT(error({"filter", "bag", "-o", "c", "--topics", "/poes"}),
              HasSubstr("the bag has no topic /poes"));
  EXPECT_THAT(error({"filter", "bag", "-o", "c", "-e", "["}, 2), HasSubstr("regular expression"));
  EXPECT_THAT(error({"filter", "bag", "-o", "c", "-x", "."}), HasSubstr("no topic of the bag"));
  EXPECT_FALSE(fs::exists(path("c")));
}

TEST_F(BagCommand, MergesByTime) {
  record("other", {.storage = bags::Storage::kMcap}, 500'000'000);
  EXPECT_EQ(out({"merge", "bag", "other", "-o", "both"}), "both: 38 messages on 6 topics\n");
  bags::BagReader reader(path("both"));
  std::int64_t last = 0;
  while (const auto message = reader.next()) {
    EXPECT_GE(message->log_time, last);
    last = message->log_time;
  }
}

TEST_F(BagCommand, MendsWhatItFindsBroken) {
  EXPECT_EQ(out({"check", "bag"}), "bag: 19 messages can be read\n");
  fs::remove(path("bag/metadata.yaml"));
  EXPECT_EQ(out({"reindex", "bag"}), "bag: metadata.yaml for 19 messages on 6 topics in 1 files\n");
  fs::resize_file(path("bag/bag_0.db3"), fs::file_size(path("bag/bag_0.db3")) - 5000);
  const auto checked = run({"check", "bag"});
  EXPECT_EQ(checked.code(), 1);
  EXPECT_THAT(checked.err, StartsWith("fault: bag/bag_0.db3"));
  EXPECT_THAT(checked.out, HasSubstr("can be read, but not everything: "));
  EXPECT_THAT(error({"convert", "bag", "-o", "part"}), HasSubstr("not everything could be read"));
  const auto recovered = run({"recover", "bag", "-o", "whole"});
  EXPECT_EQ(recovered.code(), 0);
  EXPECT_THAT(recovered.err, HasSubstr("lost: bag/bag_0.db3"));
  EXPECT_THAT(out({"check", "whole"}), HasSubstr("messages can be read\n"));
  EXPECT_THAT(error({"check", "none"}), HasSubstr("there is no such file"));
}

TEST_F(BagCommand, SchemaThatContradictsATypeOfOursIsAFault) {
  {
    bags::BagWriter writer(path("odd"), {.storage = bags::Storage::kMcap});
    const auto topic = writer.add_topic({.name = "/t",
                                         .type = "builtin_interfaces/msg/Time",
                                         .schema_encoding = "ros2msg",
                                         .schema_text = "int64 sec\nuint32 nanosec\n"});
    const std::array<std::byte, 12> data{};
    writer.write({.topic = topic, .log_time = 1, .publish_time = 1, .data = data});
  }
  EXPECT_THAT(error({"check", "odd"}),
              HasSubstr("/t: builtin_interfaces/Time has 'int64 sec' in the bag where it has "
                        "'int32 sec' here"));
  EXPECT_THAT(error({"export", "odd", "-o", "out"}), HasSubstr("'int64 sec' in the bag"));
}

TEST_F(BagCommand, ExportsTablesWithFlatColumns) {
  EXPECT_EQ(out({"export", "bag", "-o", "out", "--csv"}),
            "out: 6 tables, 0 trajectories, 0 images\n");
  const auto joints = lines(path("out/joint_states.csv"));
  ASSERT_EQ(joints.size(), 11U);
  EXPECT_EQ(joints[0],
            "log_time,header.stamp.sec,header.stamp.nanosec,header.frame_id,name[0],name[1],"
            "position[0],position[1]");
  EXPECT_EQ(joints[1], "1.000000000,0,0,,shoulder,\"elbow, left\",,");
  EXPECT_EQ(joints[5], "5.000000000,4,0,,shoulder,\"elbow, left\",0.4,");
  EXPECT_THAT(lines(path("out/tf.csv"))[0], HasSubstr("transforms[1].transform.rotation.w"));
  EXPECT_THAT(error({"export", "bag", "-o", "out", "--csv"}), HasSubstr("out: is not empty ("));
  EXPECT_EQ(
      out({"export", "bag", "-o", "short", "--csv", "--topics", "/camera", "--array-limit", "4"}),
      "short: 1 tables, 0 trajectories, 0 images\n");
  EXPECT_THAT(lines(path("short/camera.csv")),
              ElementsAre("log_time,header.stamp.sec,header.stamp.nanosec,header.frame_id,height,"
                          "width,encoding,is_bigendian,step,data.size",
                          "12.000000000,0,0,,1,2,rgb8,0,8,8"));
}

TEST_F(BagCommand, ExportsImagesAndTrajectories) {
  EXPECT_EQ(out({"export", "bag", "-o", "out"}), "out: 6 tables, 3 trajectories, 3 images\n");
  const cv::Mat colours = cv::imread(path("out/camera/000000_0.000000000.png").string());
  ASSERT_EQ(colours.cols, 2);
  EXPECT_EQ(colours.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 255));
  EXPECT_EQ(colours.at<cv::Vec3b>(0, 1), cv::Vec3b(7, 0, 0));
  const cv::Mat counts =
      cv::imread(path("out/thermal/000000_0.000000000.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(counts.type(), CV_16UC1);
  EXPECT_EQ(counts.at<std::uint16_t>(0, 0), 0x1234);
  EXPECT_EQ(counts.at<std::uint16_t>(0, 1), 0xFF00);
  const cv::Mat depth =
      cv::imread(path("out/depth/000000_0.000000000.tiff").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(depth.type(), CV_32FC1);
  EXPECT_EQ(depth.at<float>(0, 0), 1.5F);
  EXPECT_THAT(lines(path("out/pose.tum")), ::testing::Contains("4.000000000 6 0 0 0 0 0 1"));
  EXPECT_THAT(lines(path("out/tf_base_link.tum")), ElementsAre("0.000000000 0 2 0 0 0 0 1"));
  EXPECT_TRUE(fs::exists(path("out/tf_camera.tum")));
}

TEST_F(BagCommand, ExportSaysWhatItCannotDo) {
  {
    bags::BagWriter writer(path("odd"));
    const auto known = writer.add_topic({.name = "/pose", .type = "geometry_msgs/msg/PoseStamped"});
    const auto unknown = writer.add_topic({.name = "/x", .type = "other_msgs/msg/X"});
    const std::array<std::byte, 5> data{};
    writer.write({.topic = known, .log_time = 1, .publish_time = 1, .data = data});
    writer.write({.topic = unknown, .log_time = 2, .publish_time = 2, .data = data});
  }
  EXPECT_THAT(error({"export", "odd", "-o", "out"}),
              AllOf(HasSubstr("/x: messages of other_msgs/msg/X (cdr) are not known here"),
                    HasSubstr("/pose: 1 messages are no geometry_msgs/msg/PoseStamped")));
}

}  // namespace
}  // namespace pipescout::bag_command
