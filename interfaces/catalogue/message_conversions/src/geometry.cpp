// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/geometry.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>
#include <string>

#include "pipescout/validation/number_text.hpp"

namespace pipescout {
namespace {

constexpr double kNormTolerance = 1e-3;
constexpr double kSymmetryTolerance = 1e-6;

void require_finite(const char* field, double value) {
  if (!std::isfinite(value)) {
    throw std::invalid_argument(std::string(field) + " is " + validation::number_text(value) +
                                "; it must be finite");
  }
}

geometry::SO3 rotation(const geometry_msgs::msg::Quaternion& message, const std::string& field) {
  require_finite((field + ".x").c_str(), message.x);
  require_finite((field + ".y").c_str(), message.y);
  require_finite((field + ".z").c_str(), message.z);
  require_finite((field + ".w").c_str(), message.w);
  Eigen::Quaterniond q(message.w, message.x, message.y, message.z);
  const double norm = q.norm();
  if (std::abs(norm - 1) > kNormTolerance) {
    throw std::invalid_argument(field + " has a norm of " + validation::number_text(norm) +
                                "; it must be 1");
  }
  q.coeffs() /= norm;
  return geometry::SO3::from_quaternion(q);
}

}  // namespace

geometry_msgs::msg::Pose to_message(const geometry::SE3& pose) {
  geometry_msgs::msg::Pose message;
  message.position.x = pose.translation().x();
  message.position.y = pose.translation().y();
  message.position.z = pose.translation().z();
  const Eigen::Quaterniond& q = pose.rotation().quaternion();
  message.orientation.x = q.x();
  message.orientation.y = q.y();
  message.orientation.z = q.z();
  message.orientation.w = q.w();
  return message;
}

geometry::SE3 from_message(const geometry_msgs::msg::Pose& message) {
  const auto& p = message.position;
  const auto& o = message.orientation;
  require_finite("position.x", p.x);
  require_finite("position.y", p.y);
  require_finite("position.z", p.z);
  return {rotation(o, "orientation"), {p.x, p.y, p.z}};
}

geometry_msgs::msg::Transform transform_message(const geometry::SE3& pose) {
  const geometry_msgs::msg::Pose same = to_message(pose);
  geometry_msgs::msg::Transform message;
  message.translation.x = same.position.x;
  message.translation.y = same.position.y;
  message.translation.z = same.position.z;
  message.rotation = same.orientation;
  return message;
}

geometry::SE3 from_message(const geometry_msgs::msg::Transform& message) {
  const auto& t = message.translation;
  require_finite("translation.x", t.x);
  require_finite("translation.y", t.y);
  require_finite("translation.z", t.z);
  return {rotation(message.rotation, "rotation"), {t.x, t.y, t.z}};
}

std::array<double, 36> to_message(const geometry::Matrix6d& covariance) {
  std::array<double, 36> message{};
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      message[static_cast<std::size_t>(6 * row + column)] = covariance(row, column);
    }
  }
  return message;
}

geometry::Matrix6d covariance_from_message(const std::array<double, 36>& covariance) {
  geometry::Matrix6d result;
  for (std::size_t i = 0; i < covariance.size(); ++i) {
    require_finite(("covariance[" + std::to_string(i) + "]").c_str(), covariance[i]);
    result(static_cast<int>(i) / 6, static_cast<int>(i) % 6) = covariance[i];
  }
  for (int i = 0; i < 6; ++i) {
    if (!(result(i, i) > 0)) {
      throw std::invalid_argument("covariance[" + std::to_string(7 * i) + "] is " +
                                  validation::number_text(result(i, i)) +
                                  "; a variance must be above 0");
    }
    for (int j = 0; j < i; ++j) {
      if (std::abs(result(i, j) - result(j, i)) >
          kSymmetryTolerance * std::sqrt(result(i, i) * result(j, j))) {
        throw std::invalid_argument("covariance is not symmetric at [" + std::to_string(6 * i + j) +
                                    "]");
      }
    }
  }
  result = 0.5 * (result + result.transpose()).eval();
  if (Eigen::LLT<geometry::Matrix6d>(result).info() != Eigen::Success) {
    throw std::invalid_argument("covariance is not positive definite");
  }
  return result;
}

}  // namespace pipescout
