// SPDX-License-Identifier: BSD-3-Clause
#include "linear/box_complementarity.h"

#include "linear/least_load.h"
#include "linear/least_norm.h"
#include "units.h"

namespace nb = nanobind;

namespace native {
namespace {

Eigen::VectorXd vector(const Numbers& of) {
  return Eigen::Map<const Eigen::VectorXd>(of.data(), static_cast<Eigen::Index>(of.size()));
}
Numbers list(const Eigen::VectorXd& of) { return {of.begin(), of.end()}; }

Eigen::MatrixXd square(const Table& rows) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd out(n, n);
  for (Eigen::Index i = 0; i < n; ++i) out.row(i) = vector(rows[static_cast<std::size_t>(i)]).transpose();
  return out;
}

}  // namespace

// W: rows of a square matrix. Returns x, r and whether a solution was found.
void bind_box_complementarity(nb::module_& m) {
  m.def(
      "solve_in_box",
      [](const Table& W, const Numbers& b, const Numbers& lower, const Numbers& upper) {
        const gelenk::BoxSolution found = gelenk::solve_in_box(square(W), vector(b), vector(lower), vector(upper));
        return std::pair(std::pair(list(found.x), list(found.r)), found.found);
      },
      nb::arg("W"), nb::arg("b"), nb::arg("lower"), nb::arg("upper"));
  m.def(
      "least_load",
      [](const Table& W, const Numbers& b, const Numbers& lower, const Numbers& upper) {
        Eigen::VectorXd x;
        gelenk::least_load(square(W), vector(b), vector(lower), vector(upper), x);
        return list(x);
      },
      nb::arg("W"), nb::arg("b"), nb::arg("lower"), nb::arg("upper"));
  m.def(
      "least_norm",
      [](const Table& G, const Numbers& r, double threshold) {
        gelenk::LeastNormSolver solver(threshold);
        Eigen::VectorXd x;
        solver.solve(square(G), vector(r), x);
        return list(x);
      },
      nb::arg("G"), nb::arg("r"), nb::arg("threshold"));
}

}  // namespace native
