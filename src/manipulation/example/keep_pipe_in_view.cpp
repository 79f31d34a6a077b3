// SPDX-License-Identifier: Apache-2.0
// An arm that follows its commands turns its camera towards a pipe that is seen 40 pixels too low.
#include <iostream>
#include <string>
#include <vector>

#include "pipescout/manipulation/arm_controller.hpp"

using namespace pipescout::manipulation;

int main() {
  ArmControllerParameters parameters;
  parameters.feed_forward = false;  // the vehicle stands still
  ArmController controller(ArmModel(camera_arm_urdf(), "base_link", "camera_optical_frame"),
                           parameters);
  controller.set_camera(pipescout::geometry::Camera(
      {.width = 320, .height = 240, .focal_length = 722, .centre_u = 159.5, .centre_v = 119.5}));
  std::vector<std::string> names;
  for (const ArmJoint& joint : controller.model().joints()) {
    names.push_back(joint.name);
  }
  std::vector<double> positions = parameters.ready;
  ArmCommand command;
  for (int i = 0; i < 100; ++i) {
    const double now = 0.01 * i;  // s
    controller.observe({.time = now, .names = names, .positions = positions}, now);
    PipeSection pipe{.time = now, .state = TrackState::kLocked, .width = 320, .height = 240};
    pipe.u = 159.5;
    pipe.v = i < 20 ? 159.5 : 119.5;
    pipe.length = 320;
    controller.observe(pipe, now);
    command = controller.step(now, ArmRequest::kTrack);
    positions.assign(command.position.begin(), command.position.end());
    std::cout << now << " s: " << to_string(command.state) << ", " << command.position.transpose()
              << " rad\n";
  }
  return command.state == ArmState::kTracking ? 0 : 1;
}
