// SPDX-License-Identifier: BSD-3-Clause
#include "linear/box_complementarity.h"

#include "units.h"

namespace nb = nanobind;

namespace native {
namespace {

Eigen::VectorXd vector(const Numbers& of) {
  return Eigen::Map<const Eigen::VectorXd>(of.data(), static_cast<Eigen::Index>(of.size()));
}
Numbers list(const Eigen::VectorXd& of) { return {of.begin(), of.end()}; }

}  // namespace

// W: rows of a square matrix. Returns x, r and whether a solution was found.
void bind_box_complementarity(nb::module_& m) {
  m.def(
      "solve_in_box",
      [](const Table& W, const Numbers& b, const Numbers& lower, const Numbers& upper) {
        Eigen::MatrixXd matrix(b.size(), b.size());
        for (std::size_t i = 0; i < W.size(); ++i) matrix.row(static_cast<Eigen::Index>(i)) = vector(W[i]).transpose();
        const gelenk::BoxSolution found = gelenk::solve_in_box(matrix, vector(b), vector(lower), vector(upper));
        return std::pair(std::pair(list(found.x), list(found.r)), found.found);
      },
      nb::arg("W"), nb::arg("b"), nb::arg("lower"), nb::arg("upper"));
}

}  // namespace native
