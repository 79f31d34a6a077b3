// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <limits>
#include <random>

#include "pipescout/linear_algebra/cholesky.hpp"
#include "pipescout/linear_algebra/products.hpp"
#include "pipescout/linear_algebra/semidefinite.hpp"
#include "pipescout/linear_algebra/symmetric_eigen.hpp"

namespace pipescout::linear_algebra {
namespace {

constexpr std::uint64_t kSeed = 17;

template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> any_matrix(std::mt19937_64& engine) {
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, Rows, Columns> m;
  for (double& element : m.reshaped()) {
    element = normal(engine);
  }
  return m;
}

/// Symmetric and positive definite, of deviations that differ.
template <int N>
Square<N> any_covariance(std::mt19937_64& engine) {
  const Square<N> m = any_matrix<N, N>(engine);
  const Vector<N> deviations = Vector<N>::LinSpaced(N, 0.01, 10);
  const Square<N> c = m * m.transpose() + 0.1 * Square<N>::Identity();
  return deviations.asDiagonal() * c * deviations.asDiagonal();
}

template <typename Size>
class CholeskyOfSize : public testing::Test {};
using CholeskySizes =
    testing::Types<std::integral_constant<int, 1>, std::integral_constant<int, 2>,
                   std::integral_constant<int, 3>, std::integral_constant<int, 4>,
                   std::integral_constant<int, 6>, std::integral_constant<int, 15>>;
TYPED_TEST_SUITE(CholeskyOfSize, CholeskySizes);

TYPED_TEST(CholeskyOfSize, IsEigensToTheBit) {
  constexpr int N = TypeParam::value;
  std::mt19937_64 engine(kSeed);
  const Square<N> a = any_covariance<N>(engine);
  const Vector<N> b = any_matrix<N, 1>(engine);
  const Eigen::LLT<Square<N>> expected(a);
  const Cholesky<N> actual(a);
  EXPECT_TRUE(actual.succeeded());
  EXPECT_EQ(actual.lower(), Square<N>(expected.matrixL()));
  EXPECT_EQ(actual.diagonal(), Vector<N>(expected.matrixLLT().diagonal()));
  EXPECT_EQ(actual.solve(b), Vector<N>(expected.solve(b)));
  EXPECT_EQ(actual.inverse(), Square<N>(expected.solve(Square<N>::Identity())));
  EXPECT_EQ(actual.whiten(b), Vector<N>(expected.matrixL().solve(b)));
  EXPECT_EQ(actual.inverse_lower(), Square<N>(expected.matrixL().solve(Square<N>::Identity())));
}

TYPED_TEST(CholeskyOfSize, DecomposesAndInverts) {
  constexpr int N = TypeParam::value;
  std::mt19937_64 engine(kSeed);
  const Square<N> a = any_covariance<N>(engine);
  const Cholesky<N> root(a);
  const Vector<N> b = any_matrix<N, 1>(engine);
  EXPECT_TRUE(a.isApprox(root.lower() * root.lower().transpose(), 1e-12));
  EXPECT_TRUE(b.isApprox(a * root.solve(b), 1e-9));
  EXPECT_TRUE(Square<N>::Identity().isApprox(a * root.inverse(), 1e-9));
  EXPECT_NEAR(root.whiten(b).squaredNorm(), b.dot(root.solve(b)), 1e-9 * b.dot(root.solve(b)));
  EXPECT_NEAR(root.log_determinant(), std::log(a.determinant()), 1e-9);
}

TYPED_TEST(CholeskyOfSize, RefusesWhatIsNotPositiveDefinite) {
  constexpr int N = TypeParam::value;
  Square<N> a = Square<N>::Identity();
  a(N - 1, N - 1) = -1;
  EXPECT_FALSE(Cholesky<N>(a).succeeded());
}

template <int N, int Columns>
void expect_solved() {
  std::mt19937_64 engine(kSeed);
  const Square<N> a = any_covariance<N>(engine);
  const Eigen::Matrix<double, N, Columns> b = any_matrix<N, Columns>(engine);
  const Eigen::Matrix<double, N, Columns> x = solve_semidefinite(a, b);
  EXPECT_EQ(x, (Eigen::Matrix<double, N, Columns>(a.ldlt().solve(b))));
  EXPECT_TRUE(b.isApprox(a * x, 1e-9));
}

TEST(Semidefinite, IsEigensToTheBit) {
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
  EXPECT_EQ(solve_semidefinite(a, Vector<2>(8, 3)), Vector<2>(2, 0));
}

TEST(Semidefinite, MahalanobisCountsDeviations) {
  const Square<3> covariance = Eigen::Vector3d(4, 9, 0.25).asDiagonal();
  EXPECT_DOUBLE_EQ(squared_mahalanobis<3>(covariance, {2, 6, 1.5}), 1.0 + 4.0 + 9.0);
}

template <int N>
void expect_eigen() {
  std::mt19937_64 engine(kSeed);
  const Square<N> a = any_covariance<N>(engine);
  const Eigen::SelfAdjointEigenSolver<Square<N>> expected(a);
  const SymmetricEigen<N> actual = symmetric_eigen(a);
  EXPECT_TRUE(actual.succeeded);
  EXPECT_EQ(actual.values, expected.eigenvalues());
  EXPECT_EQ(actual.vectors, expected.eigenvectors());
  EXPECT_TRUE(
      a.isApprox(actual.vectors * actual.values.asDiagonal() * actual.vectors.transpose(), 1e-12));
}

TEST(SymmetricEigen, IsEigensToTheBit) {
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
  std::mt19937_64 engine(kSeed);
  const Square<3> a = any_covariance<3>(engine);
  const SymmetricEigen<3> actual = symmetric_eigen_direct(a);
  EXPECT_TRUE(
      a.isApprox(actual.vectors * actual.values.asDiagonal() * actual.vectors.transpose(), 1e-7));
}

template <int Rows, int N>
void expect_propagated() {
  std::mt19937_64 engine(kSeed);
  const Square<N> p = any_covariance<N>(engine);
  const Eigen::Matrix<double, Rows, N> j = any_matrix<Rows, N>(engine);
  EXPECT_EQ(propagate(j, p), Square<Rows>(j * p * j.transpose()));
}

TEST(Products, AreEigensToTheBit) {
  expect_propagated<1, 15>();
  expect_propagated<3, 15>();
  expect_propagated<6, 15>();
  expect_propagated<15, 15>();
  expect_propagated<6, 6>();
  expect_propagated<3, 3>();
  std::mt19937_64 engine(kSeed);
  const Square<15> a = any_matrix<15, 15>(engine);
  const Square<15> b = any_matrix<15, 15>(engine);
  EXPECT_EQ(information_of(a), Square<15>(a.transpose() * a));
  EXPECT_EQ(product(a, b), Square<15>(a * b));
}

TEST(Products, InverseOfARegularMatrix) {
  std::mt19937_64 engine(kSeed);
  const Square<6> a = any_matrix<6, 6>(engine);
  EXPECT_EQ(inverse(a), Square<6>(a.inverse()));
  EXPECT_TRUE(Square<6>::Identity().isApprox(a * inverse(a), 1e-9));
}

}  // namespace
}  // namespace pipescout::linear_algebra
