// SPDX-License-Identifier: BSD-3-Clause
#include "batch/pivots_of_scene.h"

#include <Eigen/Core>
#include <utility>

#include "decomposition/dense.h"

namespace gelenk {
namespace {

RowMatrix matrix(const std::vector<double>& of, std::size_t columns) {
  return Eigen::Map<const RowMatrix>(of.data(), static_cast<Eigen::Index>(of.size() / columns),
                                     static_cast<Eigen::Index>(columns));
}

// Newton's method onto Phi = 0; false: it does not converge.
bool close(const TracedScene& scene, const std::vector<double>& v, const std::vector<double>& u,
           std::vector<double>& q) {
  constexpr int most_iterations = 20;
  constexpr double closed = 1e-12;  // m or rad
  for (int i = 0; i < most_iterations; ++i) {
    const EquationValues values = scene.values(q, v, u);
    const Eigen::Map<const Eigen::VectorXd> Phi(values.Phi.data(), static_cast<Eigen::Index>(values.Phi.size()));
    if (Phi.lpNorm<Eigen::Infinity>() < closed) return true;
    const Eigen::VectorXd dv = -least_norm_solution(matrix(values.J, v.size()), Phi);
    if (!(dv.lpNorm<Eigen::Infinity>() < 10)) return false;
    const EquationValues moved = scene.values(q, {dv.begin(), dv.end()}, u);
    for (std::size_t k = 0; k < q.size(); ++k) q[k] += moved.qdot[k];
  }
  return false;
}

}  // namespace

PivotsOfScene pivots_of(const TracedScene& scene) {
  const SceneEquations& equations = scene.equations();
  PivotsOfScene out;
  for (const EquationArgument& of : equations.q) out.q.push_back(of.start);
  for (const EquationArgument& of : equations.u) out.u.push_back(of.start);
  if (equations.rows.empty()) return out;
  const std::vector<double> rest(equations.v.size(), 0);
  std::vector<std::vector<double>> positions;
  std::vector<RowMatrix> J;
  for (std::vector<double>& q : positions_around(out.q)) {
    if (!close(scene, rest, out.u, q)) continue;
    const EquationValues values = scene.values(q, rest, out.u);
    J.push_back(equilibrated(matrix(values.M, rest.size()), matrix(values.J, rest.size())));
    positions.push_back(std::move(q));
  }
  std::size_t usual = 0;
  static_cast<Pivots&>(out) = choose_pivots(J, static_cast<int>(equations.rows.size()), usual);
  if (!positions.empty()) out.q = positions[usual];
  return out;
}

}  // namespace gelenk
