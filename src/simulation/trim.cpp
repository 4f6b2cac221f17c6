// SPDX-License-Identifier: BSD-3-Clause
// Start at an equilibrium instead of at the start values, trim, and what keeps a position at rest.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "contact_geometry/contact_finder.h"
#include "preparation/report.h"
#include "preparation/rest_forces.h"
#include "scene/formulas.h"
#include "scene/natural_time.h"
#include "scene/touching_laws.h"
#include "simulation/simulation_impl.h"
#include "simulation/trim.h"

namespace gelenk {
namespace {

bool moves(const MotionLaw::Derivatives& target) { return target[1] != 0; }

// Whether a coordinate that is immobile has another value.
constexpr double immobile_tolerance = 1e-9;  // rad, or natural units of length

}  // namespace

EquilibriumProblem Simulation::Impl::at_rest(const Island& island,
                                             const std::vector<MotionLaw::Derivatives>& targets) const {
  const PreparedIsland& of = island.prepared();
  island.formulation().drives().go_to(time, island.reading().q);
  return {.mechanism = of.mechanism,
          .loads = island.loads(),
          .mobility = of.mobility,
          .outputs = *readings,
          .u = island.formulation().drives().u(),
          .targets = targets,
          .time = natural_time(given, scene.units)};
}

// The islands on which an input acts: those with bodies that move if there are any, since the others only follow.
std::vector<int> Simulation::Impl::mechanisms_of_input(int input) const {
  const std::vector<int>& all = islands_of_input[static_cast<std::size_t>(input)];
  std::vector<int> out;
  std::ranges::copy_if(all, std::back_inserter(out),
                       [this](int i) { return islands[static_cast<std::size_t>(i)]->prepared().mechanism.nv > 0; });
  return out.empty() ? all : out;
}

// The part of a request that concerns an island, in natural units.
EquilibriumRequest Simulation::Impl::part_of(const EquilibriumRequest& request, int island) const {
  EquilibriumRequest out{.steady = request.steady, .only_approach = request.only_approach};
  for (EquilibriumRequest::Held held : request.held) {
    if (readings->island(held.output) != island) continue;
    const Signal& signal = outputs[static_cast<std::size_t>(held.output)];
    held.value /= output_size[static_cast<std::size_t>(held.output)];
    out.held.push_back({held.output, held.value, signal.joint, signal.component, signal.level});
  }
  for (const auto& [input, size] : request.solve_for) {
    const std::vector<int> on = mechanisms_of_input(input);
    if (on.size() > 1)
      throw UsageError("the equilibrium cannot be solved for the input " +
                       inputs[static_cast<std::size_t>(input)].name +
                       ", which acts on several mechanisms that are not connected");
    if (on == std::vector{island}) out.solve_for.push_back({input, size / input_size[static_cast<std::size_t>(input)]});
  }
  for (const int output : request.accelerations) {
    if (readings->island(output) == island) out.accelerations.push_back(output);
  }
  return out;
}

// The outputs of the accelerations that an island's independent velocities have; request: to be held at 0, too.
std::vector<int> Simulation::Impl::independent_accelerations(int island, EquilibriumRequest* request) const {
  std::vector<int> out;
  for (const int state : states) {
    const Signal& signal = outputs[static_cast<std::size_t>(state)];
    if (signal.level != 1 || readings->island(state) != island) continue;
    out.push_back(signal.derivative);
    if (request == nullptr) continue;
    request->held.push_back({state, 0, signal.joint, signal.component, 1});
  }
  return out;
}

Equilibrium Simulation::Impl::found_from(const Island& island, const EquilibriumProblem& of,
                                         const std::vector<std::string>& coordinates) const {
  const double* q = island.reading().q;
  const double* v = island.reading().v;
  try {
    return find_equilibrium(of, {q, q + of.mechanism.nq}, island.formulation().revolutions().coordinates(),
                            {v, v + of.mechanism.nv});
  } catch (const NotDifferentiablePoint& fault) {
    throw NotDifferentiable(describe_undetermined(scene, fault, time, coordinates));
  } catch (const SingularMass& fault) {
    throw NotDifferentiable(describe_lost_inertia(time, fault.what()));
  }
}

// Adds the accelerations and the rates of the states of an island at what was found.
void Simulation::Impl::add_residuals(int island, const EquilibriumRequest& request, const Equilibrium& here,
                                     Trim& out) const {
  const Mechanism& mechanism = islands[static_cast<std::size_t>(island)]->prepared().mechanism;
  const std::vector<int> accelerations =
      request.steady ? request.accelerations : independent_accelerations(island, nullptr);
  for (std::size_t k = 0; k < accelerations.size(); ++k) {
    const Outputs::Entry entry = readings->entry(accelerations[k]);
    const double value = request.steady ? here.accelerations[static_cast<Eigen::Index>(k)]
                                        : entry.sign * here.vdot[entry.index - mechanism.nq - mechanism.nv];
    out.residual.emplace_back(accelerations[k], output_size[static_cast<std::size_t>(accelerations[k])] * value);
  }
  for (std::size_t output = 0; output < outputs.size(); ++output) {
    const Outputs::Entry entry = readings->entry(static_cast<int>(output));
    const bool is_state = outputs[output].section == sections::states && outputs[output].group == 0;
    if (!is_state || readings->island(static_cast<int>(output)) != island) continue;
    const double rate = here.rates[entry.index - mechanism.nq - 2 * mechanism.nv];
    out.residual.emplace_back(outputs[output].derivative, output_size[output] * rate);
  }
}

Trim Simulation::Impl::trim(const EquilibriumRequest& request) {
  // Where a state jumps, rates that vanish are no equilibrium, as of a relay.
  if (const ElementState* const state = first_with_resets(scene))
    throw UsageError("states." + state->name +
                     ".resets: there may be no equilibrium where states jump, none is searched for");
  if (const ElementState* const state = first_with_rate_of_forces(scene))
    throw UsageError("states." + state->name + ": its rate names forces, no equilibrium is searched for");
  Trim out;
  for (const EquilibriumRequest::Held& held : request.held) {
    const double natural = held.value / output_size[static_cast<std::size_t>(held.output)];
    if (readings->island(held.output) == Outputs::none &&
        std::abs(readings->constant(held.output) - natural) > immobile_tolerance)
      out.end = Equilibrium::End::unreachable;
  }
  std::vector<Equilibrium> found(islands.size());
  std::vector<int> order(islands.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_partition(
      order, [this](int i) { return islands[static_cast<std::size_t>(i)]->prepared().mechanism.nv > 0; });
  for (const int i : order) {
    const Island& island = *islands[static_cast<std::size_t>(i)];
    const Mechanism& mechanism = island.prepared().mechanism;
    const std::vector<MotionLaw::Derivatives> targets = island.targets();
    EquilibriumProblem of = at_rest(island, targets);
    of.request = part_of(request, i);
    if (!request.steady && std::ranges::any_of(targets, moves)) {
      of.request.steady = true;
      of.request.accelerations = independent_accelerations(i, &of.request);
    }
    out.is_driven = out.is_driven || mechanism.driven();
    const Equilibrium& here = found[static_cast<std::size_t>(i)] = found_from(island, of, names_of_coordinates(i));
    for (const EquilibriumRequest::UnknownInput& solved : of.request.solve_for)
      u.set(solved.input, here.u[static_cast<std::size_t>(solved.input)]);
    u.go_to(time);
    out.end = std::max(out.end, here.end);
    out.steps += here.steps;
    add_residuals(i, of.request, here, out);
  }
  if (out.end != Equilibrium::End::found) return out;
  for (std::size_t i = 0; i < islands.size(); ++i) {
    prepared.islands[i].start.q = std::move(found[i].q);
    prepared.islands[i].start.v = std::move(found[i].v);
    prepared.islands[i].cut_start = std::move(found[i].cut_q);
    std::copy(found[i].u.begin() + static_cast<std::ptrdiff_t>(u.signals()), found[i].u.end(),
              prepared.islands[i].states.begin());
  }
  make_islands();
  find_independent();
  return out;
}

Trim Simulation::trim(const EquilibriumRequest& request) {
  if (!impl_->initialized) throw UsageError("an equilibrium before initialize()");
  impl_->u.go_to(impl_->time);
  const Inputs before = impl_->u;
  Trim out;
  try {
    out = impl_->trim(request);
  } catch (...) {
    impl_->u = before;
    throw;
  }
  if (out.end != Equilibrium::End::found) impl_->u = before;
  impl_->runs = impl_->runs && out.end != Equilibrium::End::found;
  return out;
}

// The search does not know the forces of contacts.
void Simulation::Impl::refuse_touching_equilibrium() {
  for (const auto& island : islands) {
    island->realize(Stage::velocity);
    const int closed =
        closed_contact(island->prepared().mechanism, island->dynamics().readings(), touching_law_count(scene));
    if (closed < 0) continue;
    throw AssemblyError(path_of_touching_law(scene, closed) +
                        " is closed at the equilibrium found (solver.start: equilibrium), expected it to be open: the "
                        "search does not know the forces of contacts");
  }
}

void Simulation::Impl::start_at_equilibrium() {
  for (const auto& island : islands) {
    const std::vector<MotionLaw::Derivatives> targets = island->targets();
    const auto moving = std::ranges::find_if(targets, moves);
    if (moving == targets.end()) continue;
    const auto row = static_cast<std::size_t>(moving - targets.begin());
    throw AssemblyError(describe_moving_drive(scene, island->prepared().mechanism.coordinate_rows[row].constraint));
  }
  try {
    const Trim found = trim({});
    if (found.end == Equilibrium::End::found) return refuse_touching_equilibrium();
    const auto size = [&](const auto& of) {
      return std::abs(of.second / output_size[static_cast<std::size_t>(of.first)]);
    };
    const auto [output, value] = *std::ranges::max_element(found.residual, {}, size);
    throw AssemblyError(describe_no_equilibrium(scene, outputs[static_cast<std::size_t>(output)], value));
  } catch (const NotDifferentiable& fault) {
    throw AssemblyError(fault.what());
  }
}

RestForces Simulation::rest_forces() {
  if (!impl_->initialized) throw UsageError("forces at rest before initialize()");
  impl_->u.go_to(impl_->time);
  RestForces out;
  for (const auto& island : impl_->islands) {
    const std::vector<MotionLaw::Derivatives> targets = island->targets();
    const double* q = island->reading().q;
    out.add(impl_->scene, impl_->at_rest(*island, targets), {q, q + island->prepared().mechanism.nq},
            island->formulation().revolutions().coordinates());
  }
  return out;
}

}  // namespace gelenk
