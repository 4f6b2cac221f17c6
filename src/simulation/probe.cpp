// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/probe.h"

#include <algorithm>
#include <ctime>

#include "simulation/simulation_impl.h"

namespace gelenk {
namespace {

// CPU time of this thread [s].
double cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

Equations& Probe::equations(int island) {
  if (!impl_.initialized) throw UsageError("equations before initialize()");
  return *impl_.islands.at(island)->equations_;
}

const std::vector<double>& Probe::state(int island) const { return impl_.islands.at(island)->y_; }

Jacobians Probe::residual_jacobians(int island, const std::vector<double>& x, bool by_duals) const {
  const Island& of = *impl_.islands.at(island);
  const Mechanism& m = of.prepared().mechanism;
  const std::size_t needed = m.nq + 2 * m.nv + m.rows;
  if (x.size() < needed) {
    throw UsageError("x: found " + std::to_string(x.size()) + " numbers, expected " + std::to_string(needed));
  }
  const double* const v = x.data() + m.nq;
  const std::vector<double>& u = of.formulation().drives().u();
  const auto dynamics = make_dynamics(m, of.loads());  // so that the run's own dynamics are not changed
  dynamics->set_cut_reference(of.formulation().revolutions().coordinates().data());
  dynamics->set_targets(with_two_derivatives(of.targets()).data());
  dynamics->set_position(x.data());
  dynamics->set_velocity(v);
  Jacobians out;
  out.of_inputs = true;
  dynamics->differentiate(u.data(), static_cast<int>(u.size()), v + m.nv, out, v + m.nv + m.nv, by_duals);
  return out;
}

double Probe::evaluation_cost() {
  if (!impl_.initialized) throw UsageError("a measurement before initialize()");
  double sum = 0;
  const double budget = std::max(4e-4, 0.02 / static_cast<double>(std::max<std::size_t>(1, impl_.islands.size())));
  for (const auto& island : impl_.islands) sum += evaluation_cost(*island, budget);
  return sum;
}

std::vector<RecordedProblem> Probe::record_cone_problems(double end) {
  if (!impl_.initialized) throw UsageError("a recording before initialize()");
  std::vector<RecordedProblem> out;
  const auto record = [&](std::vector<RecordedProblem>* to) {
    for (const auto& island : impl_.islands) island->equations_->contacts().steps().record(to);
  };
  struct Off {
    const decltype(record)& set;
    ~Off() { set(nullptr); }
  } off{record};
  record(&out);
  simulation_.step_to(end);
  return out;
}

// The smallest of several measurements. budget: approximate measuring time [s].
double Probe::evaluation_cost(Island& of, double budget) {
  if (of.mechanism().nv == 0) return 0;
  of.forget_outputs();
  std::vector<double> ydot(of.y_.size());
  // Alternating between two states defeats the caching of results at the same state.
  std::vector<double> nearby = of.y_;
  for (double& y : nearby) y += 1e-9;
  const auto time_of = [&](int calls) {
    const double begin = cpu_time();
    for (int i = 0; i < calls; ++i) of.equations_->rhs(of.time_, (i % 2 == 0 ? nearby : of.y_).data(), ydot.data());
    return (cpu_time() - begin) / calls;
  };
  const long before = of.dynamics_->evaluations();
  // Twenty blocks, each long compared with the resolution of the clock and short compared with interruptions.
  double least = std::max(time_of(1), 1e-9);
  const int calls = static_cast<int>(std::clamp(budget / 20 / least, 1.0, 1e5));
  for (int i = 0; i < 20 && i * calls * least < budget; ++i) least = std::min(least, time_of(calls));
  of.evaluations_before_ += of.dynamics_->evaluations() - before;
  return least;
}

}  // namespace gelenk
