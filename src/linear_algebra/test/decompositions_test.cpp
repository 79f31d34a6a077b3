// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "pipescout/linear_algebra/cholesky.hpp"
#include "pipescout/linear_algebra/products.hpp"
#include "pipescout/linear_algebra/semidefinite.hpp"
#include "pipescout/linear_algebra/symmetric_eigen.hpp"

namespace pipescout::linear_algebra {
namespace {

constexpr std::uint64_t kSeed = 17;

/// Sizes are known at run time only, so that what the test itself needs of Eigen is compiled once.
Eigen::MatrixXd any_matrix(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937_64 engine(kSeed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd m(rows, columns);
  for (double& element : m.reshaped()) {
    element = normal(engine);
  }
  return m;
}

/// Symmetric and positive definite, of deviations that differ.
Eigen::MatrixXd any_covariance(Eigen::Index size) {
  const Eigen::MatrixXd m = any_matrix(size, size);
  const Eigen::VectorXd deviations = Eigen::VectorXd::LinSpaced(size, 0.01, 10);
  const Eigen::MatrixXd c = m * m.transpose() + 0.1 * Eigen::MatrixXd::Identity(size, size);
  return deviations.asDiagonal() * c * deviations.asDiagonal();
}

void expect_near(const Eigen::MatrixXd& actual, const Eigen::MatrixXd& expected,
                 double relative = 1e-9) {
  EXPECT_TRUE(actual.isApprox(expected, relative)) << actual << "\nis not\n" << expected;
}

void expect_unit(const Eigen::MatrixXd& actual) {
  expect_near(actual, Eigen::MatrixXd::Identity(actual.rows(), actual.cols()));
}

template <typename Size>
class CholeskyOfSize : public testing::Test {};
using CholeskySizes =
    testing::Types<std::integral_constant<int, 1>, std::integral_constant<int, 2>,
                   std::integral_constant<int, 3>, std::integral_constant<int, 4>,
                   std::integral_constant<int, 6>, std::integral_constant<int, 15>>;
TYPED_TEST_SUITE(CholeskyOfSize, CholeskySizes);

TYPED_TEST(CholeskyOfSize, DecomposesAndInverts) {
  constexpr int N = TypeParam::value;
  const Eigen::MatrixXd a = any_covariance(N);
  const Eigen::MatrixXd b = any_matrix(N, 1);
  const Cholesky<N> root{Square<N>(a)};
  EXPECT_TRUE(root.succeeded());
  const Eigen::MatrixXd lower = root.lower();
  expect_near(lower * lower.transpose(), a);
  EXPECT_TRUE(lower.isLowerTriangular());
  expect_near(Eigen::VectorXd(root.diagonal()), lower.diagonal());
  expect_near(a * Eigen::MatrixXd(root.solve(b)), b);
  expect_unit(a * Eigen::MatrixXd(root.inverse()));
  expect_near(lower * Eigen::MatrixXd(root.whiten(b)), b);
  expect_unit(lower * Eigen::MatrixXd(root.inverse_lower()));
  EXPECT_NEAR(root.log_determinant(), 2 * std::log(lower.diagonal().prod()), 1e-9);
}

TYPED_TEST(CholeskyOfSize, RefusesWhatIsNotPositiveDefinite) {
  constexpr int N = TypeParam::value;
  Square<N> a = Square<N>::Identity();
  a(N - 1, N - 1) = -1;
  EXPECT_FALSE(Cholesky<N>(a).succeeded());
}

template <int N>
void expect_columns_whitened() {
  const Eigen::MatrixXd b = any_matrix(N, 15);
  const Cholesky<N> root{Square<N>(any_covariance(N))};
  expect_near(Eigen::MatrixXd(root.lower()) *
                  Eigen::MatrixXd(root.whiten_columns(Eigen::Matrix<double, N, 15>(b))),
              b);
}

TEST(Cholesky, WhitensColumns) {
  expect_columns_whitened<1>();
  expect_columns_whitened<3>();
  expect_columns_whitened<6>();
}

TEST(Cholesky, IsEigensToTheBit) {
  const Square<3> a = any_covariance(3);
  const Vector<3> b = any_matrix(3, 1);
  const Eigen::LLT<Square<3>> expected(a);
  const Cholesky<3> actual(a);
  EXPECT_EQ(actual.lower(), Square<3>(expected.matrixL()));
  EXPECT_EQ(actual.solve(b), Vector<3>(expected.solve(b)));
}

template <int N, int Columns>
void expect_solved() {
  const Eigen::MatrixXd a = any_covariance(N);
  const Eigen::MatrixXd b = any_matrix(N, Columns);
  const Eigen::MatrixXd x = solve_semidefinite<N, Columns>(a, b);
  expect_near(a * x, b);
}

TEST(Semidefinite, Solves) {
  expect_solved<2, 1>();
  expect_solved<3, 1>();
  expect_solved<3, 3>();
  expect_solved<3, 6>();
  expect_solved<6, 1>();
  expect_solved<6, 6>();
  expect_solved<9, 1>();
  expect_solved<12, 6>();
}

TEST(Semidefinite, LeavesOutWhatASingularMatrixDoesNotReach) {
  const Square<2> a = Eigen::Vector2d(4, 0).asDiagonal();
  EXPECT_EQ((solve_semidefinite<2, 1>(a, {8, 3})), Vector<2>(2, 0));
}

TEST(Semidefinite, MahalanobisCountsDeviations) {
  const Square<3> covariance = Eigen::Vector3d(4, 9, 0.25).asDiagonal();
  EXPECT_DOUBLE_EQ(squared_mahalanobis<3>(covariance, {2, 6, 1.5}), 1.0 + 4.0 + 9.0);
}

template <int N>
void expect_eigen() {
  const Eigen::MatrixXd a = any_covariance(N);
  const SymmetricEigen<N> eigen = symmetric_eigen<N>(a);
  EXPECT_TRUE(eigen.succeeded);
  const Eigen::MatrixXd vectors = eigen.vectors;
  const Eigen::VectorXd values = eigen.values;
  expect_unit(vectors.transpose() * vectors);
  expect_near(vectors * values.asDiagonal() * vectors.transpose(), a);
  EXPECT_TRUE(std::is_sorted(values.begin(), values.end()));
}

TEST(SymmetricEigen, Diagonalises) {
  expect_eigen<2>();
  expect_eigen<3>();
  expect_eigen<6>();
}

TEST(SymmetricEigen, SaysThatItDoesNotConverge) {
  Square<3> a = Square<3>::Identity();
  a(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(symmetric_eigen(a).succeeded);
}

TEST(SymmetricEigen, ClosedFormAgreesToHalfTheDigits) {
  const Eigen::MatrixXd a = any_covariance(3);
  const SymmetricEigen<3> eigen = symmetric_eigen_direct(a);
  const Eigen::MatrixXd vectors = eigen.vectors;
  expect_near(vectors * Eigen::VectorXd(eigen.values).asDiagonal() * vectors.transpose(), a, 1e-7);
}

template <int Rows, int N>
void expect_propagated() {
  const Eigen::MatrixXd p = any_covariance(N);
  const Eigen::MatrixXd j = any_matrix(Rows, N);
  expect_near(propagate<Rows, N>(j, p), j * p * j.transpose(), 1e-12);
}

TEST(Products, AreThoseOfMatrices) {
  expect_propagated<1, 15>();
  expect_propagated<3, 15>();
  expect_propagated<6, 15>();
  expect_propagated<15, 15>();
  expect_propagated<6, 6>();
  expect_propagated<3, 3>();
  const Eigen::MatrixXd a = any_matrix(15, 15);
  const Eigen::MatrixXd b = any_covariance(15);
  expect_near(information_of<15>(a), a.transpose() * a, 1e-12);
  expect_near(product<15>(a, b), a * b, 1e-12);
}

TEST(Products, InverseOfARegularMatrix) {
  const Eigen::MatrixXd a = any_matrix(6, 6);
  expect_unit(a * Eigen::MatrixXd(inverse<6>(a)));
}

}  // namespace
}  // namespace pipescout::linear_algebra
