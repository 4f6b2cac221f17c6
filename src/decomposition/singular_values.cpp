// SPDX-License-Identifier: BSD-3-Clause
#include "decomposition/singular_values.h"

#include <Eigen/SVD>

namespace gelenk {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SingularValues::SingularValues(const MatrixXd& J) {
  if (J.size() == 0) {
    U.setIdentity(J.rows(), J.rows());
    V.setIdentity(J.cols(), J.cols());
    return;
  }
  const Eigen::JacobiSVD<MatrixXd> svd(J, Eigen::ComputeFullU | Eigen::ComputeFullV);
  U = svd.matrixU();
  V = svd.matrixV();
  sigma = svd.singularValues();
}

Index SingularValues::rank(double fraction) const {
  return sigma.size() > 0 ? (sigma.array() > fraction * sigma[0]).count() : 0;
}

VectorXd SingularValues::solve(const VectorXd& b, Index rank, double damping) const {
  VectorXd along = U.leftCols(rank).transpose() * b;
  for (Index k = 0; k < rank; ++k) {
    const double divisor = sigma[k] * sigma[k] + damping;
    along[k] = divisor > 0 ? along[k] * sigma[k] / divisor : 0;
  }
  return V.leftCols(rank) * along;
}

MatrixXd weak_rows(const MatrixXd& J, double threshold) {
  if (J.rows() == 0) return {};
  if (J.cols() == 0) return MatrixXd::Identity(J.rows(), J.rows());
  const SingularValues svd(J);
  return svd.U.rightCols(J.rows() - svd.rank(threshold));
}

}  // namespace gelenk
