// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace pipescout::benchmarks {

/// Pinhole without skew and distortion, pixels.
struct VispCamera {
  unsigned int width = 0;
  unsigned int height = 0;
  double focal_length_u = 0;
  double focal_length_v = 0;
  double centre_u = 0;
  double centre_v = 0;
};

/// The peer of the rack benchmark: ViSP's generic model-based tracker, moving edges and KLT points
/// together. Its settings are in visp_tracker.cpp. Nothing here needs C++20, which ViSP's headers
/// do not compile as.
class VispTracker {
 public:
  /// `cao`: the content of a `.cao` model. Throws std::runtime_error when it cannot be handed over.
  VispTracker(const std::string& cao, const VispCamera& camera);
  ~VispTracker();
  VispTracker(const VispTracker&) = delete;
  VispTracker& operator=(const VispTracker&) = delete;

  /// Starts, or starts again, with an image taken at this pose. `grey`: height * width, row-major;
  /// it is not copied and must live until the next call.
  void start(const std::uint8_t* grey, const Eigen::Matrix4d& T_camera_rack);

  /// T_camera_rack of the next image; nothing when it says that it is lost. Images as in `start`.
  [[nodiscard]] std::optional<Eigen::Matrix4d> track(const std::uint8_t* grey);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::benchmarks
