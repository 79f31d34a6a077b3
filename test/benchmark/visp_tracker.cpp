// SPDX-License-Identifier: Apache-2.0
#include "visp_tracker.hpp"

#include <unistd.h>
#include <visp3/core/vpMath.h>
#include <visp3/mbt/vpMbGenericTracker.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <stdexcept>

namespace pipescout::benchmarks {
namespace {

vpHomogeneousMatrix to_visp(const Eigen::Matrix4d& pose) {
  vpHomogeneousMatrix result;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      result[static_cast<unsigned int>(row)][static_cast<unsigned int>(column)] = pose(row, column);
    }
  }
  return result;
}

Eigen::Matrix4d from_visp(const vpHomogeneousMatrix& pose) {
  Eigen::Matrix4d result;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      result(row, column) = pose[static_cast<unsigned int>(row)][static_cast<unsigned int>(column)];
    }
  }
  return result;
}

/// A file that is gone with the object: ViSP takes models from files only.
class ModelFile {
 public:
  explicit ModelFile(const std::string& cao) : name_("/tmp/pipescout-rack-XXXXXX.cao") {
    constexpr int kSuffix = 4;
    const int descriptor = mkstemps(name_.data(), kSuffix);
    if (descriptor < 0) {
      throw std::runtime_error("cannot make a file in /tmp");
    }
    close(descriptor);
    std::ofstream out(name_);
    out << cao;
    if (!out.flush()) {
      throw std::runtime_error("cannot write " + name_);
    }
  }
  ~ModelFile() { unlink(name_.c_str()); }
  ModelFile(const ModelFile&) = delete;
  ModelFile& operator=(const ModelFile&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  std::string name_;
};

}  // namespace

/// Settings: those of ViSP's own examples, but for what made it better on images of the benchmark's
/// kind, of other seeds. Shadows and stripes on the ground run beside the contours of the pipes, so
/// edges are searched near by only (range 5 pixels instead of 8), with the smallest mask and the
/// lower threshold that goes with it and with dark pipes, and points weigh five times as much as
/// edges. Worn paint is faint texture: the quality of points may be lower (0.01 instead of 0.015);
/// a larger window (10 pixels instead of 5) makes up for it, and fewer levels of the pyramid for
/// the time. The settings of the examples took as long and were two to five times as wrong.
class VispTracker::Implementation {
 public:
  Implementation(const std::string& cao, const VispCamera& camera)
      : width_(camera.width),
        height_(camera.height),
        tracker_(1, vpMbGenericTracker::EDGE_TRACKER | vpMbGenericTracker::KLT_TRACKER) {
    vpMe edges;
    edges.setMaskSize(3);
    edges.setMaskNumber(180);
    edges.setRange(5);
    edges.setThreshold(3000);
    edges.setMu1(0.5);
    edges.setMu2(0.5);
    edges.setSampleStep(4);
    tracker_.setMovingEdge(edges);

    vpKltOpencv points;
    points.setMaxFeatures(300);
    points.setWindowSize(10);
    points.setQuality(0.01);
    points.setMinDistance(10);
    points.setHarrisFreeParameter(0.01);
    points.setBlockSize(3);
    points.setPyramidLevels(2);
    tracker_.setKltOpencv(points);
    tracker_.setKltMaskBorder(5);
    tracker_.setFeatureFactors(
        {{vpMbGenericTracker::EDGE_TRACKER, 1.0}, {vpMbGenericTracker::KLT_TRACKER, 5.0}});

    tracker_.setCameraParameters(vpCameraParameters(camera.focal_length_u, camera.focal_length_v,
                                                    camera.centre_u, camera.centre_v));
    tracker_.setAngleAppear(vpMath::rad(70));
    tracker_.setAngleDisappear(vpMath::rad(80));
    tracker_.setNearClippingDistance(0.1);
    tracker_.setFarClippingDistance(100.0);
    tracker_.setClipping(tracker_.getClipping() | vpMbtPolygon::FOV_CLIPPING);
    tracker_.setDisplayFeatures(false);

    const ModelFile file(cao);
    // It reports what it reads in the midst of our table.
    std::cout.setstate(std::ios::failbit);
    tracker_.loadModel(file.name());
    std::cout.clear();
  }

  void start(const std::uint8_t* grey, const Eigen::Matrix4d& T_camera_rack) {
    take(grey);
    tracker_.initFromPose(image_, to_visp(T_camera_rack));
  }

  std::optional<Eigen::Matrix4d> track(const std::uint8_t* grey) {
    take(grey);
    try {
      tracker_.track(image_);
    } catch (const vpException&) {
      return {};
    }
    vpHomogeneousMatrix pose;
    tracker_.getPose(pose);
    return from_visp(pose);
  }

 private:
  void take(const std::uint8_t* grey) {
    // It only reads the pixels, but has no type that says so.
    image_.init(const_cast<std::uint8_t*>(grey), height_, width_, false);
  }

  unsigned int width_;
  unsigned int height_;
  vpMbGenericTracker tracker_;
  vpImage<unsigned char> image_;
};

VispTracker::VispTracker(const std::string& cao, const VispCamera& camera)
    : implementation_(std::make_unique<Implementation>(cao, camera)) {}
VispTracker::~VispTracker() = default;

void VispTracker::start(const std::uint8_t* grey, const Eigen::Matrix4d& T_camera_rack) {
  implementation_->start(grey, T_camera_rack);
}

std::optional<Eigen::Matrix4d> VispTracker::track(const std::uint8_t* grey) {
  return implementation_->track(grey);
}

}  // namespace pipescout::benchmarks
