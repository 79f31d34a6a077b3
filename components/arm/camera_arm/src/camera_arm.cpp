// SPDX-License-Identifier: Apache-2.0
#include "pipescout/camera_arm/camera_arm.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "arm_messages.hpp"
#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout {

namespace {

using manipulation::ArmCommand;
using manipulation::ArmController;
using manipulation::ArmModel;
using manipulation::ArmReason;
using manipulation::ArmRequest;
using manipulation::InputVerdict;

double seconds(Time time) {
  return to_seconds(time.time_since_epoch());
}

}  // namespace

CameraArm::CameraArm(ComponentOptions options)
    : Component(std::move(options)), declared_(parameters()) {}

CameraArm::~CameraArm() = default;

CallbackReturn CameraArm::on_configure() {
  settings_ = declared_.read();
  controller_.emplace(
      ArmModel(settings_->urdf, settings_->base_frame, settings_->camera_frame, settings_->model),
      settings_->controller);
  calibration_.reset();
  request_ = ArmRequest::kTrack;
  cycles_ = 0;

  command_publisher_ =
      create_publisher(topics::kArmCommand, {.events = {.matched = awaited_.on_matched()}});
  state_publisher_ =
      create_publisher(topics::kArmState, {.events = {.matched = awaited_.on_matched()}});
  if (settings_->publish_tf) {
    tf_publisher_ = create_publisher(topics::kTf);
  }
  stow_service_ = create_service<SetBool>(
      "~/stow", [this](const SetBool::Request& request, SetBool::Response& response) {
        response.success = is_commandable(response.message);
        if (response.success) {
          request_ = request.data ? ArmRequest::kStow : ArmRequest::kTrack;
        }
      });
  reset_service_ = create_service<Trigger>(
      "~/reset", [this](const Trigger::Request&, Trigger::Response& response) {
        response.success = is_commandable(response.message);
        if (response.success) {
          controller_->reset();
        }
      });
  awaited_.watch({command_publisher_.untyped(), state_publisher_.untyped()},
                 [this] { subscribe(); });
  cycle_timer_ = create_timer(from_seconds(settings_->controller.period), [this] { cycle(); });
  return CallbackReturn::kSuccess;
}

void CameraArm::subscribe() {
  joint_subscription_ = create_subscription(
      topics::kJointStates, [this](const JointState& message) { on_joint_states(message); });
  camera_info_subscription_ = create_subscription(
      topics::kThermalCameraInfo, [this](const CameraInfo& message) { on_camera_info(message); });
  odometry_subscription_ = create_subscription(
      topics::kOdometryFiltered, [this](const Odometry& message) { on_odometry(message); });
  track_subscription_ = create_subscription(
      topics::kPipeTrack, [this](const PipeTrack& message) { on_track(message); });
}

CallbackReturn CameraArm::on_activate() {
  // What was commanded before it was inactive, or what others commanded since, is not where it is.
  controller_->reset();
  told_.reset();
  return CallbackReturn::kSuccess;
}

CallbackReturn CameraArm::on_cleanup() {
  awaited_.stop();
  cycle_timer_.reset();
  stow_service_ = {};
  reset_service_ = {};
  joint_subscription_ = {};
  track_subscription_ = {};
  odometry_subscription_ = {};
  camera_info_subscription_ = {};
  command_publisher_ = {};
  state_publisher_ = {};
  tf_publisher_ = {};
  controller_.reset();
  return CallbackReturn::kSuccess;
}

bool CameraArm::is_commandable(std::string& refusal) const {
  if (state() == LifecycleState::kActive) {
    return true;
  }
  // It would move later, when nobody expects it any more.
  refusal = "the component is " + std::string(to_string(state())) + "; activate it first";
  return false;
}

void CameraArm::count(const char* input, InputVerdict verdict) {
  if (verdict != InputVerdict::kTaken && verdict != InputVerdict::kPartial &&
      verdict != InputVerdict::kOfOthers) {
    report_fault(counter(input, verdict),
                 std::string(input) + " is not used: " + to_string(verdict));
  }
}

void CameraArm::on_camera_info(const CameraInfo& message) {
  if (calibration_ && same_calibration(*calibration_, message)) {
    return;
  }
  try {
    controller_->set_camera(geometry::Camera(from_message(message)));
    calibration_ = message;
  } catch (const std::invalid_argument& error) {
    report_fault("camera_info.refused", std::string("calibration refused: ") + error.what());
  }
}

void CameraArm::on_joint_states(const JointState& message) {
  if (message.name.size() != message.position.size()) {
    report_fault("joint_states.position.size",
                 "joint_states has " + std::to_string(message.name.size()) + " names and " +
                     std::to_string(message.position.size()) + " positions");
    return;
  }
  const InputVerdict verdict =
      controller_->observe({.time = pipescout::seconds(message.header.stamp),
                            .names = message.name,
                            .positions = message.position},
                           seconds(now()));
  count("joint_states", verdict);
  if (verdict == InputVerdict::kTaken && settings_->publish_tf) {
    publish_transform(message.header.stamp);
  }
}

void CameraArm::publish_transform(const builtin_interfaces::msg::Time& last) {
  const ArmModel& arm = controller_->model();
  const auto [time, q] = controller_->joints().value();
  geometry_msgs::msg::TransformStamped transform;
  // Of joints in several messages the time may be that of another one.
  transform.header.stamp =
      pipescout::seconds(last) == time ? last : to_message(Time(from_seconds(time)));
  transform.header.frame_id = settings_->base_frame;
  transform.child_frame_id = settings_->camera_frame;
  transform.transform = transform_message(arm.T_base_camera(q));
  auto told = std::make_unique<TFMessage>();
  told->transforms.push_back(std::move(transform));
  tf_publisher_.publish(std::move(told));
}

void CameraArm::on_track(const PipeTrack& message) {
  count("track", controller_->observe(pipe_section(message), seconds(now())));
}

void CameraArm::on_odometry(const Odometry& message) {
  if (message.header.frame_id != settings_->map_frame ||
      message.child_frame_id != settings_->base_frame) {
    report_fault("odometry.header.frame_id", "odometry is in frame '" + message.child_frame_id +
                                                 "' in '" + message.header.frame_id +
                                                 "', not of '" + settings_->base_frame + "' in '" +
                                                 settings_->map_frame + "'");
    return;
  }
  count("odometry", controller_->observe(vehicle_motion(message), seconds(now())));
}

void CameraArm::cycle() {
  const Time stamp = now();
  const ArmCommand command = controller_->step(seconds(stamp), request_);
  ++cycles_;
  if (command.commanded) {
    command_publisher_.publish(std::make_unique<JointTrajectory>(
        trajectory_message(command, controller_->model().joints(), stamp,
                           from_seconds(settings_->controller.period))));
  }
  auto state = std::make_unique<ArmState>(state_message(command, controller_->model().joints()));
  state->header.stamp = to_message(stamp);
  state->header.frame_id = settings_->base_frame;
  state_publisher_.publish(std::move(state));
  tell(command);
}

void CameraArm::tell(const ArmCommand& command) {
  std::string unseen;
  for (const std::string& name : controller_->unseen_joints()) {
    unseen += (unseen.empty() ? "" : ", ") + name;
  }
  diagnostics().set_value("joints_without_readings", unseen);
  if (told_ && told_->state == command.state && told_->reason == command.reason) {
    return;
  }
  const std::string state = manipulation::to_string(command.state);
  const std::string reason =
      command.reason == ArmReason::kNone ? "" : manipulation::to_string(command.reason);
  const std::string text = reason.empty() ? state : state + ": " + reason;
  diagnostics().set_value("state", state);
  diagnostics().set_value("reason", reason);
  if (command.state == manipulation::ArmState::kFault) {
    diagnostics().set_status(DiagnosticLevel::kError, text);
    logger().error("the arm has come to rest: " + reason);
  } else {
    diagnostics().set_status(DiagnosticLevel::kOk, text);
    logger().info("the arm is " + text);
  }
  told_ = command;
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::CameraArm)
