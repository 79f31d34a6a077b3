// SPDX-License-Identifier: Apache-2.0
#include "thin_qr.hpp"

#include <Eigen/QR>

namespace pipescout::rack_vision {

ThinQr::ThinQr(const Eigen::MatrixXd& a) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> factors(a);
  q = factors.householderQ() * Eigen::MatrixXd::Identity(a.rows(), a.cols());
  r = factors.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>();
}

}  // namespace pipescout::rack_vision
