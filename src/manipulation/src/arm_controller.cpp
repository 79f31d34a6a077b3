// SPDX-License-Identifier: Apache-2.0
#include "pipescout/manipulation/arm_controller.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "arm_inputs.hpp"
#include "joint_steps.hpp"
#include "pipescout/validation/check.hpp"
#include "resolved_rates.hpp"

namespace pipescout::manipulation {
namespace {

using Eigen::Vector3d;
using geometry::SO3;

constexpr double kNewBeginning = 1;    // s: the clock went back by more
constexpr double kLimitSlack = 1e-3;   // rad: beyond a limit, as encoders are read
constexpr double kArrived = 0.01;      // rad, of each joint
constexpr int kWayChecks = 200;        // postures on the way between ready and stow
constexpr int kGrowingSweeps = 3;      // after which a search sweeps by its whole amplitude
constexpr double kLeastUpright = 0.1;  // cosine between the plane's normal and the camera's y
constexpr double kLeastFacing = 0.3;   // sine between the plane's normal and where it looks

JointVector posture(const std::vector<double>& angles) {
  return Eigen::Map<const Eigen::VectorXd>(angles.data(), static_cast<Eigen::Index>(angles.size()));
}

Vector3d saturated(const Vector3d& v, double largest) {
  const double norm = v.norm();
  return norm > largest ? Vector3d(v * (largest / norm)) : v;
}

}  // namespace

class ArmController::Implementation {
 public:
  Implementation(ArmModel model, const ArmControllerParameters& parameters)
      : model_(std::move(model)),
        parameters_(checked(parameters, model_)),
        inputs_(parameters_),
        steps_(parameters_),
        ready_(posture(parameters_.ready)),
        stow_(posture(parameters_.stow)) {
    check_way();
    // Joint angles for a radian that the camera pitches by, when ready.
    const Jacobian jacobian = model_.camera_jacobian(ready_);
    if (model_.size() >= 6 && manipulability(jacobian) < parameters_.least_manipulability) {
      validation::refuse("ready: is singular, its manipulability ", manipulability(jacobian),
                         " is below ", parameters_.least_manipulability);
    }
    geometry::Vector6d pitching = geometry::Vector6d::Zero();
    pitching[3] = 1;
    sweep_ = rates_for(jacobian, pitching);
    T_base_ready_ = model_.T_base_camera(ready_);
  }

  ArmCommand step(double now, ArmRequest request) {
    if (!std::isfinite(now)) {
      return command_;
    }
    if (last_step_ && now<*last_step_&& * last_step_ - now> kNewBeginning) {
      reset();
    }
    if (last_step_ && now - *last_step_ < parameters_.period / 2) {
      return command_;
    }
    last_step_ = now;
    command_ = {};
    decide(now, request);
    if (!started_) {
      return command_;
    }
    follow_plane(now);
    const auto result = steps_.advance(model_, wanted_rates(now), at_);
    command_.commanded = true;
    command_.position = at_.position;
    command_.velocity = at_.velocity;
    command_.cuts = result.cuts;
    command_.clearance_cut = result.clearance_cut;
    command_.manipulability = manipulability(model_.camera_jacobian(at_.position));
    return command_;
  }

  void reset() noexcept {
    inputs_.forget();
    last_step_.reset();
    started_ = false;
    fault_ = ArmReason::kNone;
    without_pipe_since_.reset();
    sweeping_since_.reset();
    in_vain_ = false;
    moving_ = false;
    command_ = {};
  }

  ArmModel model_;
  ArmControllerParameters parameters_;
  internal::ArmInputs inputs_;

 private:
  static const ArmControllerParameters& checked(const ArmControllerParameters& parameters,
                                                const ArmModel& model) {
    parameters.validate(model.joints().size());
    for (const auto& [name, angles] :
         {std::pair("ready", &parameters.ready), std::pair("stow", &parameters.stow)}) {
      for (std::size_t i = 0; i < angles->size(); ++i) {
        const ArmJoint& joint = model.joints()[i];
        validation::check_within(std::string(name) + " of " + joint.name, (*angles)[i], joint.lower,
                                 joint.upper);
      }
    }
    return parameters;
  }

  void check_way() const {
    for (int i = 0; i <= kWayChecks; ++i) {
      const double share = i / double{kWayChecks};
      if (!steps_.clear(model_, ready_ + share * (stow_ - ready_))) {
        validation::refuse(
            i == 0 ? "ready" : "stow", i == 0 || i == kWayChecks ? "" : ": the way to it",
            ": the arm is closer to itself or the ground than ", parameters_.least_clearance, " m");
      }
    }
  }

  [[nodiscard]] JointVector rates_for(const Jacobian& jacobian,
                                      const geometry::Vector6d& twist) const {
    return internal::resolved_rates(jacobian, manipulability(jacobian), twist,
                                    {.rotation = parameters_.rotation_weight,
                                     .damping = parameters_.damping,
                                     .least_manipulability = parameters_.least_manipulability});
  }

  void become(ArmState state, ArmReason reason) {
    command_.state = state;
    command_.reason = reason;
  }

  /// Begins where the arm is found.
  void start() {
    at_ = {.position = inputs_.joints(), .velocity = JointVector::Zero(model_.size())};
    for (Eigen::Index i = 0; i < at_.position.size(); ++i) {
      const ArmJoint& joint = model_.joints()[static_cast<std::size_t>(i)];
      const double inside = std::clamp(at_.position[i], joint.lower, joint.upper);
      if (std::abs(at_.position[i] - inside) > kLimitSlack) {
        fault_ = ArmReason::kOutsideLimits;
        return;
      }
      at_.position[i] = inside;
    }
    if (!steps_.clear(model_, at_.position)) {
      fault_ = ArmReason::kTooClose;
      return;
    }
    started_ = true;
  }

  /// State and reason of this cycle: the first that applies.
  void decide(double now, ArmRequest request) {
    if (!inputs_.joints_known()) {
      return become(ArmState::kIdle, ArmReason::kNoJointReadings);
    }
    if (!started_ && fault_ == ArmReason::kNone && inputs_.joints_fresh(now)) {
      start();
    }
    if (started_ && (inputs_.joints() - at_.position).cwiseAbs().maxCoeff() >
                        parameters_.largest_following_error) {
      fault_ = ArmReason::kFollowingError;
    }
    if (fault_ != ArmReason::kNone) {
      return become(ArmState::kFault, fault_);
    }
    if (!inputs_.joints_fresh(now)) {
      return become(ArmState::kHolding, ArmReason::kStaleJointReadings);
    }
    if (request == ArmRequest::kStow) {
      without_pipe_since_.reset();
      sweeping_since_.reset();
      in_vain_ = false;
      return become(stow_state(), ArmReason::kToldToStow);
    }
    if (in_vain_) {
      return become(stow_state(), ArmReason::kSearchedInVain);
    }
    if (!inputs_.camera()) {
      return become(ArmState::kHolding, ArmReason::kNoIntrinsics);
    }
    if (parameters_.feed_forward && !inputs_.motion_fresh(now)) {
      return become(ArmState::kHolding, ArmReason::kStaleOdometry);
    }
    const bool fresh = inputs_.section_fresh(now);
    const bool tracked = inputs_.plane().known() && (inputs_.track() == TrackState::kLocked ||
                                                     inputs_.track() == TrackState::kCoasting);
    if (fresh && tracked) {
      without_pipe_since_.reset();
      sweeping_since_.reset();
      return become(ArmState::kTracking, ArmReason::kNone);
    }
    do_without_pipe(now, fresh);
  }

  void do_without_pipe(double now, bool fresh) {
    const bool never = !inputs_.plane().known();
    const ArmReason reason = never   ? ArmReason::kNoPipe
                             : fresh ? ArmReason::kPipeLost
                                     : ArmReason::kStaleTrack;
    without_pipe_since_ = without_pipe_since_.value_or(now);
    const double without = now - *without_pipe_since_;
    const double hold_time = never ? 0 : parameters_.hold_time;
    if (without < hold_time) {
      return become(ArmState::kHolding, reason);
    }
    if (without < hold_time + parameters_.search_time) {
      return become(ArmState::kSearching, reason);
    }
    in_vain_ = true;
    inputs_.forget_pipe();
    become(stow_state(), ArmReason::kSearchedInVain);
  }

  [[nodiscard]] bool arrived(const JointVector& posture) const {
    return (at_.position - posture).cwiseAbs().maxCoeff() < kArrived;
  }
  [[nodiscard]] ArmState stow_state() const {
    return arrived(stow_) ? ArmState::kStowed : ArmState::kStowing;
  }

  /// The vehicle moves on, and the plane with it.
  void follow_plane(double now) {
    if (!parameters_.feed_forward || !inputs_.plane().known() || !inputs_.motion_fresh(now)) {
      return;
    }
    const geometry::SE3 T_base_camera = model_.T_base_camera(at_.position);
    const VehicleMotion& motion = inputs_.motion();
    const Vector3d velocity =
        motion.velocity + motion.angular_rate.cross(T_base_camera.translation());
    const SO3 R_rest_base = *inputs_.R_rest_base(now);
    inputs_.plane().move(parameters_.period * (R_rest_base * velocity),
                         R_rest_base * (T_base_camera.rotation() * Vector3d::UnitZ()));
  }

  /// rad/s, before limits.
  JointVector wanted_rates(double now) {
    switch (command_.state) {
      case ArmState::kTracking:
        return track(now);
      case ArmState::kSearching:
        return search(now);
      case ArmState::kStowing:
      case ArmState::kStowed:
        return rates_to(stow_);
      case ArmState::kIdle:
      case ArmState::kHolding:
      case ArmState::kFault:
        break;
    }
    return JointVector::Zero(model_.size());
  }

  [[nodiscard]] JointVector rates_to(const JointVector& posture) const {
    const JointVector rates = parameters_.rotation_gain * (posture - at_.position);
    const double fastest = rates.cwiseAbs().maxCoeff();
    return fastest > parameters_.move_speed
               ? JointVector(rates * (parameters_.move_speed / fastest))
               : rates;
  }

  JointVector search(double now) {
    if (!sweeping_since_ && arrived(ready_)) {
      sweeping_since_ = now;
    }
    if (!sweeping_since_) {
      return rates_to(ready_);
    }
    const double sweeps = (now - *sweeping_since_) / parameters_.search_period;
    const double growth = std::min(1.0, (std::floor(sweeps) + 1) / kGrowingSweeps);
    const double pitch =
        growth * parameters_.search_amplitude * std::sin(2 * std::numbers::pi * sweeps);
    JointVector goal = ready_ + pitch * sweep_;
    for (Eigen::Index i = 0; i < goal.size(); ++i) {
      const ArmJoint& joint = model_.joints()[static_cast<std::size_t>(i)];
      goal[i] = std::clamp(goal[i], joint.lower, joint.upper);
    }
    return rates_to(goal);
  }

  JointVector track(double now) {
    const geometry::SE3 T_base_camera = model_.T_base_camera(at_.position);
    const Jacobian jacobian = model_.camera_jacobian(at_.position);
    const SO3 R_camera_base = T_base_camera.rotation().inverse();
    const internal::PipePlane& plane = inputs_.plane();
    const double turn = std::clamp(inputs_.view().turn, -parameters_.turn, parameters_.turn);

    // What was commanded a period ago is done a response time after that: what is wrong with it is
    // what the vehicle, which turns on, makes of it then.
    const double done = now - parameters_.period + parameters_.response_time;
    const SO3 R_base_rest = inputs_.R_rest_base(done)->inverse();
    const Vector3d normal = R_base_rest * plane.normal();
    const Vector3d forward =
        T_base_ready_.rotation() * Vector3d(std::sin(turn_), 0, std::cos(turn_));
    if (normal.cross(forward).norm() < kLeastFacing) {
      // The pipe is straight above or below what the camera may look along.
      become(ArmState::kHolding, ArmReason::kPipeLost);
      return JointVector::Zero(model_.size());
    }
    const SO3 R_base_target = internal::looking_along(normal, forward);
    const SO3 R_camera_target = R_camera_base * R_base_target;
    report(R_camera_target, turn);
    if (!has_to_move()) {
      return JointVector::Zero(model_.size());
    }
    // After an end of the pipe, as far as it may, and back when both are out of view.
    turn_ +=
        parameters_.period * parameters_.position_gain * (inputs_.view().turn != 0 ? turn : -turn_);
    turn_ = std::clamp(turn_, -parameters_.turn, parameters_.turn);

    geometry::Vector6d twist;
    twist.tail<3>() =
        saturated(parameters_.rotation_gain * R_camera_target.log(), parameters_.correction_rate);
    if (parameters_.feed_forward) {
      twist.tail<3>() += R_camera_target * target_rate(R_base_target, T_base_camera, normal);
      command_.feed_forward = true;
    }
    const Vector3d place = T_base_ready_.translation() +
                           reach_for(plane.range()) * (R_base_target * Vector3d::UnitZ());
    twist.head<3>() =
        R_camera_base * saturated(parameters_.position_gain * (place - T_base_camera.translation()),
                                  parameters_.correction_rate);
    return rates_for(jacobian, twist);
  }

  /// rad/s, of the wanted camera against the base, in its own axes: it stays level and on the pipe
  /// while the vehicle turns and moves. About its y axis it turns with the vehicle.
  [[nodiscard]] Vector3d target_rate(const SO3& R_base_target, const geometry::SE3& T_base_camera,
                                     const Vector3d& normal) const {
    const VehicleMotion& motion = inputs_.motion();
    const Vector3d velocity =
        motion.velocity + motion.angular_rate.cross(T_base_camera.translation());
    const Vector3d turning = R_base_target.inverse() * motion.angular_rate;
    return {velocity.dot(normal) / inputs_.plane().range() - turning.x(), 0, -turning.z()};
  }

  /// m, forwards of where it is held when ready.
  [[nodiscard]] double reach_for(double range) const {
    const double too_far = std::max(0.0, range - parameters_.farthest);
    const double too_near = std::max(0.0, parameters_.nearest - range);
    return std::clamp(too_far - too_near, -parameters_.reach, parameters_.reach);
  }

  void report(const SO3& R_camera_target, double turn) {
    const geometry::CameraParameters& camera = inputs_.camera()->parameters();
    const Vector3d normal = R_camera_target * Vector3d::UnitY();
    command_.range = inputs_.plane().range();
    if (normal.y() < kLeastUpright) {
      return;  // the pipe stands so steeply in the image that it has no row
    }
    command_.error_u = camera.focal_length * std::tan(turn);
    command_.error_v = -camera.focal_length * camera.aspect_ratio * normal.z() / normal.y();
    command_.error_angle = std::atan(-normal.x() / normal.y());
  }

  /// The paper's rule, from the last image.
  bool has_to_move() {
    if (parameters_.centring == Centring::kAlways) {
      return true;
    }
    const double offset = inputs_.view().offset;
    moving_ = moving_ ? offset > parameters_.centred_share : offset > 0.5 - parameters_.edge_share;
    return moving_;
  }

  internal::JointSteps steps_;
  JointVector ready_;
  JointVector stow_;
  JointVector sweep_;
  geometry::SE3 T_base_ready_;

  std::optional<double> last_step_;
  bool started_ = false;
  ArmReason fault_ = ArmReason::kNone;
  std::optional<double> without_pipe_since_;
  std::optional<double> sweeping_since_;
  bool in_vain_ = false;
  bool moving_ = false;
  double turn_ = 0;  // rad, about the camera's y axis, from where it looks when ready
  internal::Commanded at_;
  ArmCommand command_;
};

ArmController::ArmController(ArmModel model, const ArmControllerParameters& parameters)
    : implementation_(std::make_unique<Implementation>(std::move(model), parameters)) {}
ArmController::ArmController(ArmController&&) noexcept = default;
ArmController& ArmController::operator=(ArmController&&) noexcept = default;
ArmController::~ArmController() = default;

void ArmController::set_camera(const geometry::Camera& camera) {
  implementation_->inputs_.set_camera(camera);
}
InputVerdict ArmController::observe(const JointReadings& readings, double now) {
  return implementation_->inputs_.observe(implementation_->model_, readings, now);
}
InputVerdict ArmController::observe(const PipeSection& section, double now) {
  return implementation_->inputs_.observe(section, now);
}
InputVerdict ArmController::observe(const VehicleMotion& motion, double now) {
  return implementation_->inputs_.observe(motion, now);
}
std::optional<std::pair<double, JointVector>> ArmController::joints() const {
  const internal::ArmInputs& inputs = implementation_->inputs_;
  return inputs.joints_known() ? std::optional(std::pair(inputs.joints_time(), inputs.joints()))
                               : std::nullopt;
}
std::vector<std::string> ArmController::unseen_joints() const {
  std::vector<std::string> names;
  const std::vector<ArmJoint>& joints = implementation_->model_.joints();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (!implementation_->inputs_.joint_seen(i)) {
      names.push_back(joints[i].name);
    }
  }
  return names;
}
ArmCommand ArmController::step(double now, ArmRequest request) {
  return implementation_->step(now, request);
}
void ArmController::reset() noexcept {
  implementation_->reset();
}
const ArmModel& ArmController::model() const noexcept {
  return implementation_->model_;
}
const ArmControllerParameters& ArmController::parameters() const noexcept {
  return implementation_->parameters_;
}
const ArmController::Counts& ArmController::joint_counts() const noexcept {
  return implementation_->inputs_.joint_counts;
}
const ArmController::Counts& ArmController::section_counts() const noexcept {
  return implementation_->inputs_.section_counts;
}
const ArmController::Counts& ArmController::motion_counts() const noexcept {
  return implementation_->inputs_.motion_counts;
}

}  // namespace pipescout::manipulation
