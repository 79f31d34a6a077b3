// SPDX-License-Identifier: Apache-2.0
#include "banded_information.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>
#include <stdexcept>

namespace pipescout::odometry {
namespace {

TEST(BandedInformation, SolvesAndInvertsAsTheFullMatrixDoes) {
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> uniform(0.1, 2.0);
  for (const std::size_t bandwidth : {1U, 2U, 5U}) {
    constexpr std::size_t kSize = 30;
    BandedInformation banded(kSize, bandwidth);
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(kSize, kSize);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(kSize);
    banded.observe(3, 2.0, 0.5);
    full(3, 3) += 0.5;
    right(3) += 1.0;
    for (std::size_t i = 0; i < kSize; ++i) {
      for (std::size_t j = i + 1; j <= std::min(i + bandwidth, kSize - 1); ++j) {
        const double value = uniform(engine);
        const double weight = uniform(engine);
        banded.observe_difference(i, j, value, weight);
        Eigen::VectorXd row = Eigen::VectorXd::Zero(kSize);
        row(static_cast<Eigen::Index>(i)) = -1.0;
        row(static_cast<Eigen::Index>(j)) = 1.0;
        full += weight * row * row.transpose();
        right += weight * value * row;
      }
    }
    const Eigen::MatrixXd inverse = full.inverse();
    const Eigen::VectorXd expected = inverse * right;
    const std::vector<double> x = banded.solve();
    for (std::size_t i = 0; i < kSize; ++i) {
      EXPECT_NEAR(x[i], expected(static_cast<Eigen::Index>(i)), 1e-9);
      for (std::size_t j = i; j <= std::min(i + bandwidth, kSize - 1); ++j) {
        EXPECT_NEAR(banded.covariance(i, j),
                    inverse(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)), 1e-9);
      }
    }
  }
}

TEST(BandedInformation, RefusesWhatHasNoSolution) {
  BandedInformation free(3, 1);
  free.observe_difference(0, 1, 1.0, 1.0);
  EXPECT_THROW((void)free.solve(), std::domain_error);
}

}  // namespace
}  // namespace pipescout::odometry
