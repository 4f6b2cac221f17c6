// SPDX-License-Identifier: BSD-3-Clause
#include "dynamics/derivatives.h"

#include <algorithm>
#include <numeric>

#include "dynamics/kernels.h"
#include "dynamics/load_kernels.h"
#include "dynamics/output_kernels.h"
#include "dynamics/visit.h"
#include "math/dual.h"

namespace gelenk {
namespace {

template <class A>
using Over = std::conditional_t<A::planar, PlanarAlgebra<Dual>, SpatialAlgebra<Dual>>;

void copy(const double* from, std::vector<Dual>& to) { std::copy_n(from, to.size(), to.begin()); }

}  // namespace

template <class A>
struct Differentiator<A>::Impl {
  using D = Over<A>;

  Impl(const Mechanism& mechanism, const Loads& given, int inputs)
      : loads(given),
        model(mechanism),
        ws(model),
        links(mechanism.links.size() - 1),
        q(model.nq),
        v(model.nv),
        u(inputs),
        vdot(model.nv),
        tau(model.nv),
        rows(model.rows),
        qdot(model.nq) {
    std::iota(links.begin(), links.end(), 1);
  }

  // Runs the residuals for the directions seeded in q, v, u.
  void run(const Point& at) {
    kernels::positions(model, q.data(), ws);
    kernels::root_poses(model, links, ws);
    kernels::loop_positions(model, ws);
    kernels::velocities(model, q.data(), v.data(), kernels::root_acceleration<D>(loads), ws);
    kernels::loop_velocities(model, ws);
    kernels::link_loads(model, loads, u.data(), ws);
    kernels::cut_loads(model, loads, u.data(), at.cut_reference, ws);
    std::copy_n(at.lambda, ws.lambda.size(), ws.lambda.begin());
    kernels::accelerations(model, vdot.data(), ws);
    kernels::loop_accelerations(model, ws, rows.data());
    // accelerations() leaves in ws.F what each joint transmits; along its motions that is drives and springs.
    std::ranges::fill(tau, Dual(0));
    loads.tree.add(q.data(), v.data(), u.data(), tau.data());
    for (std::size_t i = 1; i < model.links.size(); ++i) {
      const auto& link = model.links[i];
      for (int k = link.iv; k < link.iv + link.nv; ++k) tau[k] = D::dot(ws.S[k], ws.F[i]) - tau[k];
      visit_joint<D>(link.joint,
                     [&](const auto& j) { j.rate(q.data() + link.iq, v.data() + link.iv, qdot.data() + link.iq); });
    }
  }

  // Seeds n directions of `in` from `first` on, runs, and hands out their slopes as columns.
  template <class Take>
  void sweep(const Point& at, std::vector<Dual>& in, Take take) {
    for (int first = 0; first < static_cast<int>(in.size()); first += dual_directions) {
      const int n = std::min(dual_directions, static_cast<int>(in.size()) - first);
      for (int k = 0; k < n; ++k) in[first + k].slope()[k] = 1;
      run(at);
      for (int k = 0; k < n; ++k) {
        take(first + k, k);
        in[first + k].slope()[k] = 0;
      }
    }
  }

  static void column(const std::vector<Dual>& from, int k, Eigen::MatrixXd& to, int c) {
    for (std::size_t i = 0; i < from.size(); ++i) to(static_cast<Eigen::Index>(i), c) = from[i].slope()[k];
  }

  const Loads& loads;
  Model<D> model;
  Workspace<D> ws;
  std::vector<int> links;
  std::vector<Dual> q, v, u, vdot, tau, rows, qdot;
};

template <class A>
Differentiator<A>::Differentiator(const Mechanism& mechanism, const Loads& loads, int inputs)
    : impl_(std::make_unique<Impl>(mechanism, loads, inputs)) {}
template <class A>
Differentiator<A>::~Differentiator() = default;

template <class A>
void Differentiator<A>::operator()(const Point& at, Slopes& out) {
  Impl& d = *impl_;
  const int nq = d.model.nq;
  const int nv = d.model.nv;
  const int rows = d.model.rows;
  out.r_q.resize(nv, nq);
  out.r_v.resize(nv, nv);
  out.r_u.resize(nv, static_cast<Eigen::Index>(d.u.size()));
  out.c_q.resize(rows, nq);
  out.c_v.resize(rows, nv);
  out.Phi_q.resize(rows, nq);
  out.rate_q.resize(rows, nq);
  out.qdot_q.resize(nq, nq);
  out.qdot_v.resize(nq, nv);
  copy(at.q, d.q);
  copy(at.v, d.v);
  copy(at.u, d.u);
  copy(at.vdot, d.vdot);
  d.sweep(at, d.q, [&](int c, int k) {
    Impl::column(d.tau, k, out.r_q, c);
    Impl::column(d.rows, k, out.c_q, c);
    Impl::column(d.ws.Phi, k, out.Phi_q, c);
    Impl::column(d.ws.rate, k, out.rate_q, c);
    Impl::column(d.qdot, k, out.qdot_q, c);
  });
  d.sweep(at, d.v, [&](int c, int k) {
    Impl::column(d.tau, k, out.r_v, c);
    Impl::column(d.rows, k, out.c_v, c);
    Impl::column(d.qdot, k, out.qdot_v, c);
  });
  d.sweep(at, d.u, [&](int c, int k) { Impl::column(d.tau, k, out.r_u, c); });
}

template class Differentiator<Planar>;
template class Differentiator<Spatial>;

}  // namespace gelenk
