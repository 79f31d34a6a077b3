// SPDX-License-Identifier: Apache-2.0
#include "pipescout/manipulation/arm_model.hpp"

#include <algorithm>
#include <cmath>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <limits>
#include <stdexcept>

#include "arm_description.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::manipulation {
namespace {

using Eigen::Vector3d;

/// Eigen's view on KDL's rows.
Eigen::Matrix3d matrix(const KDL::Rotation& rotation) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data);
}

Vector3d vector(const KDL::Vector& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

class ArmModel::Implementation {
 public:
  explicit Implementation(internal::ArmDescription description)
      : arm_(std::move(description)),
        position_(arm_.chain),
        velocity_(arm_.chain),
        angles_(arm_.chain.getNrOfJoints()),
        jacobian_(arm_.chain.getNrOfJoints()),
        frames_(arm_.chain.getNrOfSegments()),
        placed_(arm_.bodies.size()) {
    double length = 0;
    for (unsigned i = 0; i < arm_.chain.getNrOfSegments(); ++i) {
      length += arm_.chain.getSegment(i).getFrameToTip().p.Norm();
    }
    for (std::size_t b = 0; b < arm_.bodies.size(); ++b) {
      const internal::Capsule& capsule = arm_.bodies[b].capsule;
      reach_ = std::max(reach_,
                        length + capsule.radius + std::max(capsule.from.norm(), capsule.to.norm()));
      for (std::size_t a = 0; a < b; ++a) {
        if (arm_.bodies[b].joint - arm_.bodies[a].joint >= 2) {
          pairs_.emplace_back(a, b);
        }
      }
    }
  }

  [[nodiscard]] const std::vector<ArmJoint>& joints() const { return arm_.joints; }
  [[nodiscard]] double reach() const { return reach_; }

  geometry::SE3 camera(const JointVector& q) {
    solve(q);
    const KDL::Frame& at = frames_.back();
    return {geometry::SO3::from_matrix(matrix(at.M)), vector(at.p)};
  }

  Jacobian jacobian(const JointVector& q) {
    solve(q);
    velocity_.JntToJac(angles_, jacobian_);
    const Eigen::Matrix3d R_camera_base = matrix(frames_.back().M).transpose();
    Jacobian result(6, q.size());
    result.topRows<3>().noalias() = R_camera_base * jacobian_.data.topRows<3>();
    result.bottomRows<3>().noalias() = R_camera_base * jacobian_.data.bottomRows<3>();
    return result;
  }

  Clearance clearance(const JointVector& q, double ground) {
    solve(q);
    Clearance result{.self = std::numeric_limits<double>::infinity(),
                     .plane = std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0; i < arm_.bodies.size(); ++i) {
      const internal::ChainBody& body = arm_.bodies[i];
      placed_[i] = body.capsule;
      if (body.segment > 0) {
        const KDL::Frame& at = frames_[body.segment - 1];
        const Eigen::Matrix3d R = matrix(at.M);
        placed_[i].from = R * body.capsule.from + vector(at.p);
        placed_[i].to = R * body.capsule.to + vector(at.p);
      }
      if (body.joint > 0) {
        const double lowest = std::min(placed_[i].from.z(), placed_[i].to.z());
        result.plane = std::min(result.plane, lowest - placed_[i].radius - ground);
      }
    }
    for (const auto& [a, b] : pairs_) {
      result.self = std::min(result.self, internal::distance(placed_[a], placed_[b]));
    }
    return result;
  }

 private:
  void solve(const JointVector& q) {
    if (q.size() != angles_.data.size() || !q.allFinite()) {
      throw std::invalid_argument("q: is not " + std::to_string(angles_.data.size()) +
                                  " finite angles");
    }
    angles_.data = q;
    position_.JntToCart(angles_, frames_);
  }

  internal::ArmDescription arm_;
  KDL::ChainFkSolverPos_recursive position_;  // keeps a reference to the chain in arm_
  KDL::ChainJntToJacSolver velocity_;         // likewise
  KDL::JntArray angles_;
  KDL::Jacobian jacobian_;
  std::vector<KDL::Frame> frames_;  // after each segment, in the base
  std::vector<internal::Capsule> placed_;
  double reach_ = 0;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;  // bodies that may hit each other
};

void ArmModelOptions::validate() const {
  validation::require("mesh_radius", mesh_radius, mesh_radius >= 0 && mesh_radius <= 10, "[0, 10]");
  validation::require("continuous_velocity", continuous_velocity,
                      continuous_velocity > 0 && continuous_velocity <= 100, "(0, 100]");
}

ArmModel::ArmModel(std::string_view urdf, const std::string& base_link,
                   const std::string& camera_link, const ArmModelOptions& options)
    : implementation_(std::make_unique<Implementation>(
          internal::parse_arm(urdf, base_link, camera_link, options))) {}
ArmModel::ArmModel(ArmModel&&) noexcept = default;
ArmModel& ArmModel::operator=(ArmModel&&) noexcept = default;
ArmModel::~ArmModel() = default;

const std::vector<ArmJoint>& ArmModel::joints() const noexcept {
  return implementation_->joints();
}
Eigen::Index ArmModel::size() const noexcept {
  return static_cast<Eigen::Index>(implementation_->joints().size());
}
double ArmModel::reach() const noexcept {
  return implementation_->reach();
}
geometry::SE3 ArmModel::T_base_camera(const JointVector& q) const {
  return implementation_->camera(q);
}
Jacobian ArmModel::camera_jacobian(const JointVector& q) const {
  return implementation_->jacobian(q);
}
Clearance ArmModel::clearance(const JointVector& q, double ground) const {
  return implementation_->clearance(q, ground);
}

double manipulability(const Jacobian& jacobian) noexcept {
  if (jacobian.cols() < 6) {
    return 0;
  }
  const geometry::Matrix6d square = jacobian * jacobian.transpose();
  return std::sqrt(std::max(0.0, square.determinant()));
}

}  // namespace pipescout::manipulation
