// SPDX-License-Identifier: BSD-3-Clause
// The equations evaluated by the kernels that simulations run.
#include <cstddef>
#include <memory>

#include "dynamics/dynamics.h"
#include "dynamics/switching_forces.h"
#include "equations/scene_equations.h"

namespace gelenk {

EquationValues TracedScene::values(const std::vector<double>& q, const std::vector<double>& v,
                                   const std::vector<double>& u) const {
  EquationValues out;
  out.potential = immobile_energy_;
  const std::size_t nv = equations_.v.size();
  out.M.assign(nv * nv, 0);
  out.J.assign(equations_.rows.size() * nv, 0);
  for (std::size_t i = 0; i < arguments_.size(); ++i) add_values(i, q.data(), v.data(), u.data(), out);
  return out;
}

void TracedScene::add_values(std::size_t island, const double* q, const double* v, const double* u,
                             EquationValues& out) const {
  const IslandArguments& of = arguments_[island];
  const PreparedIsland& prepared = prepared_.islands[island];
  const Loads& loads = loads_[island];
  const std::size_t n = of.v_sign.size();
  const auto rows = static_cast<std::size_t>(prepared.mechanism.rows);
  std::vector<double> own_q(of.q_sign);
  std::vector<double> own_v(of.v_sign);
  for (std::size_t k = 0; k < own_q.size(); ++k) own_q[k] *= q[static_cast<std::size_t>(of.q) + k];
  for (std::size_t k = 0; k < n; ++k) own_v[k] *= v[static_cast<std::size_t>(of.v) + k];
  std::vector<double> targets = this->targets(island, u);
  std::vector<double> signals = this->signals(island, u);
  signals.resize(static_cast<std::size_t>(loads.signals()));

  const std::unique_ptr<Dynamics> dynamics = make_dynamics(prepared.mechanism, loads);
  dynamics->set_cut_reference(prepared.cut_start.data());
  dynamics->set_targets(targets.data());
  dynamics->set_position(own_q.data());
  dynamics->set_velocity(own_v.data());
  std::vector<int> modes(of.slides.size());
  dynamics->switching_forces().sides(modes.data());
  for (std::size_t k = 0; k < modes.size(); ++k) {
    if (!of.slides[k]) modes[k] = 0;
  }
  if (!modes.empty()) dynamics->switching_forces().hold(modes.data());
  std::vector<double> M(n * n);
  std::vector<double> f(n);
  dynamics->assemble(signals.data(), M.data(), f.data());
  const Eigen::Map<const RowMatrix> J = dynamics->J();
  const std::size_t all = equations_.v.size();
  const auto first = static_cast<std::size_t>(of.v);
  for (std::size_t k = 0; k < n; ++k) {
    out.h.push_back(-of.v_sign[k] * f[k]);
    for (std::size_t i = 0; i < n; ++i)
      out.M[(first + k) * all + first + i] = of.v_sign[k] * of.v_sign[i] * M[k * n + i];
    for (std::size_t r = 0; r < rows; ++r)
      out.J[(static_cast<std::size_t>(of.row) + r) * all + first + k] =
          of.v_sign[k] * J(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(k));
  }
  out.gamma.insert(out.gamma.end(), dynamics->gamma().begin(), dynamics->gamma().end());
  out.Phi.insert(out.Phi.end(), dynamics->Phi().begin(), dynamics->Phi().end());
  out.rate.insert(out.rate.end(), dynamics->row_rates().begin(), dynamics->row_rates().end());
  std::vector<double> qdot(own_q.size());
  dynamics->qdot_from_v(own_q.data(), own_v.data(), qdot.data());
  for (std::size_t k = 0; k < qdot.size(); ++k) out.qdot.push_back(of.q_sign[k] * qdot[k]);
  dynamics->readings().set_root_poses();
  const Energy energy = dynamics->readings().energy();
  out.kinetic += energy.kinetic;
  out.potential += energy.potential;
  std::vector<double> rates(loads.rates.size());
  dynamics->readings().state_rates(signals.data(), rates.data());
  out.rates.insert(out.rates.end(), rates.begin(), rates.end());

  dynamics->factorize();
  std::vector<double> vdot(n);
  dynamics->solve(signals.data(), vdot.data());
  dynamics->set_acceleration(vdot.data());
  for (std::size_t k = 0; k < n; ++k) out.vdot.push_back(of.v_sign[k] * vdot[k]);
  out.lambda.insert(out.lambda.end(), dynamics->lambda().begin(), dynamics->lambda().end());
}

}  // namespace gelenk
