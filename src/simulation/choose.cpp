// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/choose.h"

#include <cmath>

namespace gelenk {
namespace {

// Explicit methods of order 6 to 8 are stable for steps up to about 4 / rate.
constexpr double stable_reach = 4;
// Steps over the experiment that stability alone may ask of an explicit method: with more, IDA's dearer but longer
// steps win (stiff flyball governor, 10 s).
constexpr double bearable_steps = 2500;

double norm(const std::vector<double>& x) {
  double sum = 0;
  for (const double value : x) sum += value * value;
  return std::sqrt(sum);
}

// Largest |eigenvalue| of d vdot / d v at y [1/s]: dampers' rates. Stiff springs alone oscillate, and their
// oscillation has to be followed by any method.
double fastest_decay(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& y,
                     const std::vector<double>& u) {
  const int nv = mechanism.nv;
  const double* v0 = y.data() + mechanism.nq;
  std::vector<double> v(nv), f0(nv), f(nv), x(nv);
  dynamics.set_position(y.data());
  dynamics.factorise();
  dynamics.set_velocity(v0);
  dynamics.solve(u.data(), f0.data());
  for (int k = 0; k < nv; ++k) x[k] = 1 + 0.3 * k / nv;
  const double h = 1e-6 * std::max(1.0, norm(std::vector<double>(v0, v0 + nv)));
  double rate = 0;
  for (int i = 0; i < 20; ++i) {
    const double size = norm(x);
    if (!(size > 0)) return 0;
    for (int k = 0; k < nv; ++k) v[k] = v0[k] + h * x[k] / size;
    dynamics.set_velocity(v.data());
    dynamics.solve(u.data(), f.data());
    for (int k = 0; k < nv; ++k) x[k] = (f[k] - f0[k]) / h;
    rate = norm(x);
  }
  return rate;
}

}  // namespace

std::string choose_integrator(const Scene& scene, const Mechanism& mechanism, Dynamics& dynamics,
                              const std::vector<double>& y, const std::vector<double>& u) {
  if (scene.solver.integrator != "auto") return scene.solver.integrator;
  const double rate = fastest_decay(mechanism, dynamics, y, u);
  return rate * scene.experiment.stop > stable_reach * bearable_steps ? "ida" : "erk";
}

}  // namespace gelenk
