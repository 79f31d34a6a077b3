// SPDX-License-Identifier: Apache-2.0
#include "pipescout/linear_algebra/products.hpp"

#include <Eigen/LU>

namespace pipescout::linear_algebra {

template <int Rows, int N>
Square<Rows> propagate(const Eigen::Matrix<double, Rows, N>& jacobian,
                       const Square<N>& covariance) {
  return jacobian * covariance * jacobian.transpose();
}

template <int N>
Square<N> information_of(const Square<N>& rows) {
  return rows.transpose() * rows;
}

template <int N>
Square<N> product(const Square<N>& a, const Square<N>& b) {
  return a * b;
}

template <int N>
Square<N> inverse(const Square<N>& a) {
  return a.inverse();
}

template Square<1> propagate<1, 15>(const Eigen::Matrix<double, 1, 15>&, const Square<15>&);
template Square<3> propagate<3, 15>(const Eigen::Matrix<double, 3, 15>&, const Square<15>&);
template Square<6> propagate<6, 15>(const Eigen::Matrix<double, 6, 15>&, const Square<15>&);
template Square<15> propagate<15, 15>(const Square<15>&, const Square<15>&);
template Square<6> propagate<6, 6>(const Square<6>&, const Square<6>&);
template Square<3> propagate<3, 3>(const Square<3>&, const Square<3>&);
template Square<15> information_of<15>(const Square<15>&);
template Square<15> product<15>(const Square<15>&, const Square<15>&);
template Square<6> inverse<6>(const Square<6>&);

}  // namespace pipescout::linear_algebra
