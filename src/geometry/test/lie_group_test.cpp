// SPDX-License-Identifier: Apache-2.0
// One suite of properties for all groups. Each is tried at the angles where formulas change or
// break, and at random ones.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/LU>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "angle_series.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/geometry/so3.hpp"

namespace pipescout::geometry {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTolerance = 2e-13;  // per unit of length or of the entries involved

/// Norms of the rotation part at which something could break.
const std::vector<double>& edge_angles() {
  static const std::vector<double> angles{0,           5e-324,
                                          1e-160,      1e-12,
                                          1e-7,        1e-3,
                                          0.1,         std::nextafter(kSmallAngle, 0),
                                          kSmallAngle, std::nextafter(kSmallAngle, 2),
                                          2,           kPi - 1e-3,
                                          kPi - 1e-8,  std::nextafter(kPi, 0),
                                          kPi,         std::nextafter(kPi, 4),
                                          kPi + 1e-8,  4,
                                          5.5};
  return angles;
}

template <typename Group>
class LieGroup : public ::testing::Test {
 protected:
  using Tangent = typename Group::Tangent;
  using TangentMatrix = typename Group::TangentMatrix;
  static constexpr int kSize = Group::kDegreesOfFreedom;

  /// A tangent vector of that angle; the translation, if there is one, of some metres.
  static Tangent tangent(std::mt19937_64& engine, double angle) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    Tangent xi;
    for (double& value : xi) {
      value = 4 * uniform(engine);
    }
    Eigen::Vector3d axis;
    do {
      axis = {uniform(engine), uniform(engine), uniform(engine)};
    } while (axis.squaredNorm() > 1 || axis.squaredNorm() < 0.01);
    xi.template tail<3>() = angle * axis.normalized();
    return xi;
  }

  /// `property(xi, other)` for each edge angle of xi up to `largest` about several axes, then for
  /// random ones; the other tangent vector is random.
  template <typename Property>
  static void for_tangents(double largest, Property property) {
    std::mt19937_64 engine(20210);
    std::uniform_real_distribution<double> any(0, 6);
    for (const double angle : edge_angles()) {
      for (int i = 0; i < 6 && angle <= largest; ++i) {
        SCOPED_TRACE(angle);
        Tangent xi = tangent(engine, angle);
        if (i < 3) {
          xi.template tail<3>() = angle * Eigen::Vector3d::Unit(i);
        }
        property(xi, tangent(engine, any(engine)));
      }
    }
    EXPECT_TRUE(rc::check([&] {
      std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
      std::uniform_real_distribution<double> angle(0, largest);
      const double first = angle(random);
      const Tangent xi = tangent(random, first);
      property(xi, tangent(random, any(random)));
      RC_ASSERT(!::testing::Test::HasFailure());
    }));
  }

  static double scale(const Tangent& xi) { return 1 + xi.norm(); }

  static void expect_same(const Group& a, const Group& b, double tolerance) {
    EXPECT_LT((a.matrix() - b.matrix()).cwiseAbs().maxCoeff(), tolerance)
        << a.matrix() << "\nis not\n"
        << b.matrix();
  }
};

using Groups = ::testing::Types<SO3, SE3>;
TYPED_TEST_SUITE(LieGroup, Groups);

/// exp of the matrix sum of xi_i G_i with the generators of equation (6), by its power series.
Eigen::Matrix4d series_of_generators(const Vector6d& xi) {
  Eigen::Matrix<long double, 4, 4> a = Eigen::Matrix<long double, 4, 4>::Zero();
  a.topLeftCorner<3, 3>() = skew(xi.tail<3>()).cast<long double>();
  a.topRightCorner<3, 1>() = xi.head<3>().cast<long double>();
  constexpr int kHalvings = 6;
  a /= 1 << kHalvings;
  Eigen::Matrix<long double, 4, 4> term = Eigen::Matrix<long double, 4, 4>::Identity();
  Eigen::Matrix<long double, 4, 4> sum = term;
  for (int i = 1; i < 25; ++i) {
    term = (term * a / static_cast<long double>(i)).eval();
    sum += term;
  }
  for (int i = 0; i < kHalvings; ++i) {
    sum = (sum * sum).eval();
  }
  return sum.cast<double>();
}

Eigen::Matrix4d expected_exponential(const SO3::Tangent& phi) {
  return series_of_generators((Vector6d() << Eigen::Vector3d::Zero(), phi).finished());
}
Eigen::Matrix4d expected_exponential(const SE3::Tangent& xi) {
  return series_of_generators(xi);
}

TYPED_TEST(LieGroup, IdentityIsTheOrigin) {
  using Vector = typename TypeParam::Tangent;
  this->expect_same(TypeParam{}, TypeParam::exp(Vector::Zero()), 1e-300);
  EXPECT_TRUE(TypeParam{}.log().isZero(0));
  EXPECT_TRUE(TypeParam::left_jacobian(Vector::Zero()).isIdentity(0));
  EXPECT_TRUE(TypeParam::right_jacobian_inverse(Vector::Zero()).isIdentity(0));
}

TYPED_TEST(LieGroup, ExponentialIsTheSeriesOfTheGenerators) {
  this->for_tangents(20, [](const auto& xi, const auto&) {
    const auto m = TypeParam::exp(xi).matrix();
    const Eigen::Matrix4d expected = expected_exponential(xi);
    EXPECT_LT((m - expected.topLeftCorner(m.rows(), m.cols())).cwiseAbs().maxCoeff(),
              kTolerance * (1 + xi.norm()));
  });
}

TYPED_TEST(LieGroup, ObeysTheLawsOfAGroup) {
  this->for_tangents(20, [this](const auto& xi, const auto& other) {
    const TypeParam a = TypeParam::exp(xi);
    const TypeParam b = TypeParam::exp(other);
    const TypeParam c = TypeParam::exp(0.3 * other - xi);
    const double tolerance = 10 * kTolerance;
    this->expect_same((a * b) * c, a * (b * c), tolerance);
    this->expect_same(a * a.inverse(), TypeParam{}, tolerance);
    this->expect_same(a.inverse() * a, TypeParam{}, tolerance);
    this->expect_same((a * b).inverse(), b.inverse() * a.inverse(), tolerance);
    this->expect_same(a * TypeParam{}, a, 1e-14);
    const Eigen::Vector3d p(1, -2, 3);
    EXPECT_LT(((a * b) * p - a * (b * p)).norm(), tolerance);
    EXPECT_LT((a * p - a.matrix().template topLeftCorner<3, 3>() * p - a * Eigen::Vector3d::Zero())
                  .norm(),
              tolerance);
  });
}

TYPED_TEST(LieGroup, LogarithmUndoesTheExponentialBelowPi) {
  this->for_tangents(kPi - 1e-9, [this](const auto& xi, const auto&) {
    EXPECT_LT((TypeParam::exp(xi).log() - xi).norm(), kTolerance * this->scale(xi));
  });
}

TYPED_TEST(LieGroup, LogarithmIsShortAndExactAtAnyAngle) {
  this->for_tangents(20, [this](const auto& xi, const auto&) {
    const TypeParam g = TypeParam::exp(xi);
    const auto back = g.log();
    EXPECT_LE(back.template tail<3>().norm(), kPi + 1e-15);
    this->expect_same(TypeParam::exp(back), g, 10 * kTolerance * this->scale(xi));
  });
}

TYPED_TEST(LieGroup, AdjointMovesATangentToTheOtherSide) {
  this->for_tangents(20, [this](const auto& xi, const auto& other) {
    const TypeParam g = TypeParam::exp(xi);
    const TypeParam h = TypeParam::exp(other);
    const double tolerance = 100 * kTolerance * this->scale(xi);
    this->expect_same(TypeParam::exp(g.adjoint() * other), g * h * g.inverse(), tolerance);
    EXPECT_LT(((g * h).adjoint() - g.adjoint() * h.adjoint()).norm(), tolerance);
  });
}

TYPED_TEST(LieGroup, JacobiansAreTheNumericOnes) {
  constexpr double kStep = 1e-4;
  this->for_tangents(5.5, [this](const auto& xi, const auto&) {
    using Vector = typename TypeParam::Tangent;
    typename TypeParam::TangentMatrix left;
    typename TypeParam::TangentMatrix right;
    const TypeParam inverse = TypeParam::exp(xi).inverse();
    // Five points: an error of the order of kStep^4.
    const auto slope = [](const auto& f) {
      return Vector((8 * (f(kStep) - f(-kStep)) - (f(2 * kStep) - f(-2 * kStep))) / (12 * kStep));
    };
    for (int i = 0; i < this->kSize; ++i) {
      const Vector d = Vector::Unit(i);
      left.col(i) =
          slope([&](double s) { return Vector((TypeParam::exp(xi + s * d) * inverse).log()); });
      right.col(i) =
          slope([&](double s) { return Vector((inverse * TypeParam::exp(xi + s * d)).log()); });
    }
    EXPECT_LT((TypeParam::left_jacobian(xi) - left).cwiseAbs().maxCoeff(), 1e-10 * this->scale(xi));
    EXPECT_LT((TypeParam::right_jacobian(xi) - right).cwiseAbs().maxCoeff(),
              1e-10 * this->scale(xi));
  });
}

TYPED_TEST(LieGroup, InverseJacobiansAreTheNumericOnes) {
  constexpr double kStep = 1e-4;
  this->for_tangents(kPi - 1e-3, [this](const auto& xi, const auto&) {
    using Vector = typename TypeParam::Tangent;
    typename TypeParam::TangentMatrix left;
    typename TypeParam::TangentMatrix right;
    const TypeParam g = TypeParam::exp(xi);
    const auto slope = [](const auto& f) {
      return Vector((8 * (f(kStep) - f(-kStep)) - (f(2 * kStep) - f(-2 * kStep))) / (12 * kStep));
    };
    for (int i = 0; i < this->kSize; ++i) {
      const Vector d = Vector::Unit(i);
      left.col(i) = slope([&](double s) { return Vector((TypeParam::exp(s * d) * g).log()); });
      right.col(i) = slope([&](double s) { return Vector((g * TypeParam::exp(s * d)).log()); });
    }
    EXPECT_LT((TypeParam::left_jacobian_inverse(xi) - left).cwiseAbs().maxCoeff(),
              1e-10 * this->scale(xi));
    EXPECT_LT((TypeParam::right_jacobian_inverse(xi) - right).cwiseAbs().maxCoeff(),
              1e-10 * this->scale(xi));
  });
}

TYPED_TEST(LieGroup, JacobiansBelongTogether) {
  this->for_tangents(5.5, [this](const auto& xi, const auto&) {
    const auto left = TypeParam::left_jacobian(xi);
    const auto right = TypeParam::right_jacobian(xi);
    const double tolerance = 100 * kTolerance * this->scale(xi);
    EXPECT_TRUE((left * TypeParam::left_jacobian_inverse(xi)).isIdentity(tolerance));
    EXPECT_TRUE((right * TypeParam::right_jacobian_inverse(xi)).isIdentity(tolerance));
    EXPECT_LT((TypeParam::exp(xi).adjoint() * right - left).cwiseAbs().maxCoeff(), tolerance);
  });
}

TYPED_TEST(LieGroup, ExponentialRefusesWhatIsNotFinite) {
  using Vector = typename TypeParam::Tangent;
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity()}) {
    for (int i = 0; i < this->kSize; ++i) {
      Vector xi = Vector::Zero();
      xi(i) = bad;
      EXPECT_THROW(static_cast<void>(TypeParam::exp(xi)), std::invalid_argument);
    }
  }
  const Vector huge = Vector::Constant(1e200);
  EXPECT_THROW(static_cast<void>(TypeParam::exp(huge)), std::invalid_argument);
}

TYPED_TEST(LieGroup, AMillionProductsStayInTheGroup) {
  std::mt19937_64 engine(7);
  std::vector<TypeParam> steps;
  for (int i = 0; i < 64; ++i) {
    auto xi = this->tangent(engine, 0.05 * i);
    xi *= 0.1;
    steps.push_back(TypeParam::exp(xi));
  }
  TypeParam g;
  for (int i = 0; i < 1'000'000; ++i) {
    g = g * steps[static_cast<std::size_t>(i % 64)];
  }
  const Eigen::Matrix3d r = g.matrix().template topLeftCorner<3, 3>();
  EXPECT_LT((r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_NEAR(r.determinant(), 1, 1e-15);
}

}  // namespace
}  // namespace pipescout::geometry
