// SPDX-License-Identifier: Apache-2.0
// What is refused, in Release as well.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/geometry/so3.hpp"

namespace pipescout::geometry {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = std::numbers::pi;

const SO3& some_rotation() {
  static const SO3 r = SO3::exp({0.4, -1.3, 2.1});
  return r;
}

TEST(Rotation, RefusesMatricesThatAreNone) {
  const Eigen::Matrix3d r = some_rotation().matrix();
  EXPECT_THROW(static_cast<void>(SO3::from_matrix(-r)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(SO3::from_matrix(r * Eigen::Vector3d(1, 1, -1).asDiagonal())),
               std::invalid_argument);
  EXPECT_THROW(static_cast<void>(SO3::from_matrix(1.00001 * r)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(SO3::from_matrix(Eigen::Matrix3d::Zero())), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(SO3::from_matrix(Eigen::Matrix3d::Constant(1e300))),
               std::invalid_argument);
  for (int i = 0; i < 9; ++i) {
    for (const double bad : {kNaN, kInfinity, r(i) + 1e-5}) {
      Eigen::Matrix3d m = r;
      m(i) = bad;
      EXPECT_THROW(static_cast<void>(SO3::from_matrix(m)), std::invalid_argument) << bad;
    }
  }
}

TEST(Rotation, RefusesQuaternionsThatAreNotUnit) {
  const Eigen::Quaterniond q = some_rotation().quaternion();
  EXPECT_THROW(static_cast<void>(SO3::from_quaternion(Eigen::Quaterniond(0, 0, 0, 0))),
               std::invalid_argument);
  for (const double scale : {kNaN, kInfinity, 0.99, 1.01, -1.00001}) {
    const Eigen::Quaterniond bad(scale * q.w(), scale * q.x(), scale * q.y(), scale * q.z());
    EXPECT_THROW(static_cast<void>(SO3::from_quaternion(bad)), std::invalid_argument) << scale;
  }
  EXPECT_THROW(static_cast<void>(SO3::from_quaternion(Eigen::Quaterniond(1, kNaN, 0, 0))),
               std::invalid_argument);
}

TEST(Rotation, FromQuaternionKeepsTheRotationForBothSigns) {
  const Eigen::Quaterniond q = some_rotation().quaternion();
  const SO3 same = SO3::from_quaternion(Eigen::Quaterniond(-q.w(), -q.x(), -q.y(), -q.z()));
  EXPECT_GE(same.quaternion().w(), 0);
  EXPECT_LT((same.matrix() - some_rotation().matrix()).norm(), 1e-15);
}

TEST(Rotation, FromMatrixGivesTheNearestRotation) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const SO3 r = SO3::exp(3 * Eigen::Vector3d(uniform(engine), uniform(engine), uniform(engine)));
    // A symmetric factor is what polar decomposition takes off.
    Eigen::Matrix3d noise;
    for (double& value : noise.reshaped()) {
      value = 1e-7 * uniform(engine);
    }
    const Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity() + noise + noise.transpose();
    EXPECT_LT((SO3::from_matrix(r.matrix() * stretch).matrix() - r.matrix()).norm(), 1e-14);
  }
}

TEST(Rotation, FromMatrixIsExactAtHalfTurns) {
  for (int i = 0; i < 3; ++i) {
    const SO3 r = SO3::exp(kPi * Eigen::Vector3d::Unit(i));
    EXPECT_LT((SO3::from_matrix(r.matrix()).matrix() - r.matrix()).norm(), 1e-15);
  }
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -2) / 3;
  const SO3 r = SO3::exp(kPi * axis);
  EXPECT_NEAR(std::abs(SO3::from_matrix(r.matrix()).log().dot(axis)), kPi, 1e-14);
}

TEST(Rotation, RollPitchYawIsThatOfRep103) {
  const SO3 r = SO3::from_roll_pitch_yaw({0.1, -0.2, 0.3});
  const SO3 expected = SO3::exp({0, 0, 0.3}) * SO3::exp({0, -0.2, 0}) * SO3::exp({0.1, 0, 0});
  EXPECT_LT((r.matrix() - expected.matrix()).norm(), 1e-15);
  EXPECT_THROW(static_cast<void>(SO3::from_roll_pitch_yaw({kNaN, 0, 0})), std::invalid_argument);
}

TEST(Rotation, RollPitchYawComesBack) {
  std::mt19937_64 engine(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d angles(kPi * uniform(engine), 0.499 * kPi * uniform(engine),
                                 kPi * uniform(engine));
    EXPECT_LT((SO3::from_roll_pitch_yaw(angles).roll_pitch_yaw() - angles).norm(), 1e-12);
  }
}

TEST(Rotation, RollPitchYawKeepsTheRotationNextToGimbalLock) {
  for (const double off : {0.0, 1e-16, 1e-15, 1e-12, 1e-9, 1e-8, 1e-6, 1e-3}) {
    for (const double sign : {-1.0, 1.0}) {
      for (const double yaw : {-3.0, -0.5, 0.0, 2.0}) {
        const SO3 r = SO3::from_roll_pitch_yaw({1.2, sign * (kPi / 2 - off), yaw});
        const Eigen::Vector3d angles = r.roll_pitch_yaw();
        EXPECT_LE(angles.cwiseAbs().maxCoeff(), kPi);
        EXPECT_LE(std::abs(angles.y()), kPi / 2);
        const SO3 again = SO3::from_roll_pitch_yaw(angles);
        EXPECT_LT((again.matrix() - r.matrix()).norm(), 1e-13) << sign << ' ' << off;
      }
    }
  }
  EXPECT_EQ(SO3::about_y(kPi / 2).roll_pitch_yaw().x(), 0);
}

TEST(Rotation, SkewIsTheCrossProduct) {
  const Eigen::Vector3d a(1, -2, 3);
  const Eigen::Vector3d b(0.5, 4, -1);
  EXPECT_EQ(skew(a) * b, a.cross(b));
  EXPECT_EQ(unskew(skew(a)), a);
  EXPECT_LT(unskew(Eigen::Matrix3d(Eigen::Vector3d(1, 2, 3).asDiagonal())).norm(), 1e-300);
}

TEST(RigidMotion, RefusesWhatIsNone) {
  const SE3 t(some_rotation(), {1, 2, 3});
  for (int i = 0; i < 16; ++i) {
    for (const double bad : {kNaN, kInfinity, t.matrix()(i) + 1e-3}) {
      const bool translation = i >= 12 && i < 15;
      if (translation && std::isfinite(bad)) {
        continue;
      }
      Eigen::Matrix4d m = t.matrix();
      m(i) = bad;
      EXPECT_THROW(static_cast<void>(SE3::from_matrix(m)), std::invalid_argument)
          << i << ' ' << bad;
    }
  }
  for (int i = 0; i < 3; ++i) {
    Eigen::Vector3d p(1, 2, 3);
    p(i) = kNaN;
    EXPECT_THROW(SE3(some_rotation(), p), std::invalid_argument);
    p(i) = kInfinity;
    EXPECT_THROW(SE3(some_rotation(), p), std::invalid_argument);
  }
  EXPECT_LT((SE3::from_matrix(t.matrix()).matrix() - t.matrix()).norm(), 1e-15);
}

TEST(RigidMotion, MovesPointsAsItsMatrix) {
  const SE3 t(some_rotation(), {1, 2, 3});
  const Eigen::Vector3d p(-4, 0.5, 7);
  EXPECT_LT((t * p - (t.matrix() * p.homogeneous()).head<3>()).norm(), 1e-14);
  EXPECT_LT((t.inverse() * (t * p) - p).norm(), 1e-14);
}

}  // namespace
}  // namespace pipescout::geometry
