// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/estimation/wheel_drive.hpp"
#include "pipescout/estimator_sources/named_source.hpp"
#include "pipescout/estimator_sources/source_input.hpp"
#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/geometry/se3.hpp"

/// Measurements of a recording, whatever file they came from. Times in seconds of one clock.
namespace pipescout::estimate {

enum class Kind { kImu, kOdometer, kGps, kFurther };
/// "imu", "odometer", "gps", "further source".
[[nodiscard]] const char* to_string(Kind kind) noexcept;

struct ImuRow {
  double time = 0;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< m/s^2, in the frame of the sensor
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();   ///< rad/s
};

struct OdometerRow {
  double time = 0;
  double speed = 0;                  ///< m/s, forwards positive
  std::optional<double> yaw_rate{};  ///< rad/s, to the left positive
};

struct GpsRow {
  double time = 0;
  geometry::GeodeticPosition place{};
  bool has_height = true;
  /// m^2, east, north, up; nothing if the recording does not state a usable one.
  std::optional<Eigen::Matrix3d> covariance{};
};

/// A message of a further source: of a topic, or made of a row of a file.
struct FurtherRow {
  double time = 0;
  SourceMessage message{};
};

/// One topic or file. Rows of its kind, by rising time; where it is a further source, too, its
/// messages.
struct Stream {
  Kind kind = Kind::kImu;
  std::string name;   ///< of the topic, or of the source in the mapping
  std::string type;   ///< ROS type, or the file
  std::string frame;  ///< of the sensor; of an odometer, that of the moving body
  std::vector<ImuRow> imu;
  std::vector<OdometerRow> odometer;
  std::vector<GpsRow> gps;
  std::string message_type;  ///< of `further`, as ROS 2 names it
  std::vector<FurtherRow> further;
  /// What was refused or replaced: a sentence with the field, and the number of messages.
  std::map<std::string, std::size_t> faults;

  /// Of its kind.
  [[nodiscard]] std::size_t rows() const noexcept {
    return kind == Kind::kFurther ? further.size() : imu.size() + odometer.size() + gps.size();
  }
  /// Adds `offset`, s, to the time of each row.
  void shift(double offset) noexcept;
};

struct Mount {
  std::string parent;
  geometry::SE3 T_parent_child{};
};

struct Recording {
  std::vector<Stream> streams;
  std::map<std::string, Mount> mounts;  ///< static transforms, by child frame
  std::vector<std::string> remarks;     ///< sentences for the report
  double origin = 0;  ///< s since 1970 or of the recording's clock, added to times

  /// A sentence for each fault of each stream.
  [[nodiscard]] std::vector<std::string> faults() const;
  [[nodiscard]] const Stream* find(const std::string& name, Kind kind) const noexcept;
  /// One that has messages for a further source; null: none.
  [[nodiscard]] const Stream* find_further(const std::string& name) const noexcept;
  /// Pose of `child` in `parent`; nothing if the static transforms do not connect them.
  [[nodiscard]] std::optional<geometry::SE3> mounting(const std::string& parent,
                                                      const std::string& child) const;
};

using Progress = std::function<void(const std::string& what, double share)>;

/// Reads a bag with ordinary ROS topics. `wheels`: joints of sensor_msgs/JointState that are
/// wheels; without them such topics are named and not used. `further`: sources whose messages are
/// kept; topics that only they could use are named otherwise. Faults of single messages are counted
/// in the streams; a bag that is cut short gives what can be read, and a remark. Throws BagError
/// for what is no bag.
[[nodiscard]] Recording read_bag(const std::filesystem::path& bag,
                                 const std::optional<estimation::WheelDriveParameters>& wheels,
                                 const std::vector<NamedSource>& further, const Progress& progress);

/// Reads the CSV files of a folder. `mapping` is a YAML file with a list `sources`
/// (docs/estimate.md). Throws YamlError for the mapping, std::runtime_error for files.
[[nodiscard]] Recording read_csv_folder(const std::filesystem::path& folder,
                                        const std::string& mapping);

// Checks of single rows, the same for bags and CSV files. Each adds the row, or counts why not.
void add_imu(Stream& stream, const ImuRow& row);
void add_odometer(Stream& stream, const OdometerRow& row);
/// `row.covariance` may be anything that the recording holds: an unusable one is removed.
void add_gps(Stream& stream, GpsRow row);
/// Only its time is checked: numbers are for the estimator to refuse.
void add_further(Stream& stream, double time, SourceMessage message);

/// How a topic or file that only a further source can use is used: a sentence.
[[nodiscard]] std::string about_further(const std::string& name, const std::string& message_type);

/// Sorts by time, removes repeated stamps, frozen gyros and fixes far from all others, and makes
/// times relative to the first one.
void finish(Recording& recording);

}  // namespace pipescout::estimate
