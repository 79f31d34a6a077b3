// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/first_pose.hpp"

#include <stdexcept>
#include <string>

#include "first_pose_across.hpp"
#include "first_pose_evidence.hpp"
#include "first_pose_search.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::rack_vision {

using validation::check_above;
using validation::check_within;

void FirstPoseHint::validate() const {
  const auto check = [](const std::string& name, const std::optional<Value>& part, double largest) {
    if (part) {
      check_within("FirstPoseHint." + name + ".value", part->value, -largest, largest);
      check_above("FirstPoseHint." + name + ".standard_deviation", part->standard_deviation, 0,
                  1e6);
    }
  };
  check("x", x, 1e6);
  check("y", y, 1e6);
  check("z", z, 1e6);
  check("heading", heading, 100);
}

void FirstPoseParameters::validate() const {
  check_above("FirstPoseParameters.smallest_height", smallest_height, 0, 1000);
  check_above("FirstPoseParameters.largest_height", largest_height, smallest_height, 1000);
  check_within("FirstPoseParameters.largest_beside", largest_beside, 0, 1000);
  check_above("FirstPoseParameters.largest_tilt", largest_tilt, 0, 1.2);
  check_above("FirstPoseParameters.typical_tilt", typical_tilt, 0, 10);
  check_above("FirstPoseParameters.edge_sigma", edge_sigma, 0, 20);
  check_above("FirstPoseParameters.shortest_segment", shortest_segment, 0, 1000);
  check_within("FirstPoseParameters.smallest_matches", static_cast<double>(smallest_matches), 3,
               2 * kMaxPipes);
  check_within("FirstPoseParameters.smallest_score", smallest_score, 0.01, 0.99);
  check_above("FirstPoseParameters.smallest_evidence", smallest_evidence, 0, 1e6);
  check_above("FirstPoseParameters.rival_margin", rival_margin, 0, 1e6);
  check_above("FirstPoseParameters.largest_deviation", largest_deviation, 0, 10);
  check_above("FirstPoseParameters.unknown_along", unknown_along, 0, 1e5);
}

FirstPoseFinder::FirstPoseFinder(const FirstPoseParameters& parameters) : parameters_(parameters) {
  parameters_.validate();
}

void FirstPoseFinder::check(const RackModel& model) {
  (void)internal::pipe_circles(internal::RackOutline(model, {}));
}

FirstPose FirstPoseFinder::find(const ImageView& image, const RackModel& model, PipeOffsets offsets,
                                const geometry::Camera& camera, const FirstPoseHint& hint) const {
  hint.validate();
  if (!image.valid()) {
    throw std::invalid_argument("FirstPoseFinder: the image has no pixels, or its rows overlap");
  }
  const geometry::CameraParameters& size = camera.parameters();
  if (image.width != size.width || image.height != size.height) {
    throw std::invalid_argument("FirstPoseFinder: the image is " + std::to_string(image.width) +
                                " x " + std::to_string(image.height) +
                                ", the camera's calibration is for " + std::to_string(size.width) +
                                " x " + std::to_string(size.height));
  }
  if (!offsets.empty() && offsets.size() != model.pipes.size()) {
    throw std::invalid_argument("FirstPoseFinder: " + std::to_string(offsets.size()) +
                                " offsets for " + std::to_string(model.pipes.size()) + " pipes");
  }
  const internal::RackOutline rack(model, offsets);
  return internal::search_first_pose(parameters_, rack, image, camera, hint);
}

const char* to_string(FirstPoseStatus status) noexcept {
  switch (status) {
    case FirstPoseStatus::kFound:
      return "found";
    case FirstPoseStatus::kAmbiguous:
      return "ambiguous";
    case FirstPoseStatus::kNotEnoughEdges:
      return "not enough edges";
  }
  return "unknown";
}

}  // namespace pipescout::rack_vision
