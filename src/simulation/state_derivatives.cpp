// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/state_derivatives.h"

#include <algorithm>

#include "analysis/independent_columns.h"
#include "contact_geometry/contact_finder.h"
#include "preparation/report.h"
#include "preparation/start.h"
#include "scene/touching_laws.h"
#include "simulation/simulation_impl.h"
#include "util/text.h"

namespace gelenk {
namespace {

std::vector<bool> flags(const std::vector<int>& numbers, int n) {
  std::vector<bool> out(n, false);
  for (const int k : numbers) out[k] = true;
  return out;
}

using Sizes = Eigen::VectorXd;

Eigen::Map<const Sizes> sizes(const std::vector<double>& of) {
  return Eigen::Map<const Sizes>(of.data(), static_cast<Eigen::Index>(of.size()));
}

std::vector<int> numbers(const std::vector<bool>& flags) {
  std::vector<int> out;
  for (int k = 0; k < static_cast<int>(flags.size()); ++k) {
    if (flags[k]) out.push_back(k);
  }
  return out;
}

// The flags of coordinates, where of quaternions only those rotations are kept whose speeds are flagged.
std::vector<bool> rotations_of_speeds(const Scene& scene, const ReducedScene& reduced, int island,
                                      std::vector<bool> coordinates, const std::vector<bool>& speeds) {
  for (const int j : reduced.islands[island].joints) {
    const JointPlace& place = reduced.joints[j];
    const JointKind& kind = *find_joint_kind(scene.joints[j].type);
    if (place.role != JointPlace::Role::tree || !kind.has_quaternion()) continue;
    for (int k = place.iv + kind.nv - 3; k < place.iv + kind.nv; ++k) coordinates[k] = coordinates[k] && speeds[k];
  }
  return coordinates;
}

}  // namespace

void Simulation::Impl::find_independent() {
  independent = {};
  independent_by_island.clear();
  std::vector<std::vector<bool>> free_q;  // by island and velocity
  std::vector<std::vector<bool>> free_v;
  for (std::size_t i = 0; i < islands.size(); ++i) {
    const int nv = islands[i]->prepared().mechanism.nv;
    const auto wanted = preferred_velocities(scene, prepared.reduced, static_cast<int>(i));
    const Independent of = independent_of(static_cast<int>(i), wanted, wanted);
    free_q.push_back(flags(of.coordinates, nv));
    free_v.push_back(flags(of.speeds, nv));
    independent_by_island.push_back(of);
  }
  for (int i = 0; i < static_cast<int>(outputs.size()); ++i) {
    const Signal& s = outputs[i];
    if (s.section == sections::states && s.group == 0) independent.elements.push_back(i);
    if (s.level != 0 && s.level != 1) continue;
    const JointPlace& place = prepared.reduced.joints[s.joint];
    if (place.role != JointPlace::Role::tree) continue;
    // A quaternion is a state if any of its three rotations is independent; only those that are have an effect.
    const JointKind& kind = *find_joint_kind(scene.joints[s.joint].type);
    const int turns = kind.nv - 3;
    const bool quaternion = kind.is_of_quaternion(s.component);
    const auto first = free_q[place.island].begin() + place.iv + turns;
    const bool rotates = quaternion && std::find(first, first + 3, true) != first + 3;
    if (s.level == 0 && (quaternion ? rotates : free_q[place.island][place.iv + s.component]))
      independent.coordinates.push_back(i);
    if (s.level == 1 && (!quaternion || rotates) && free_v[place.island][place.iv + s.component])
      independent.speeds.push_back(i);
  }
  states = independent.states();
}

// The independent coordinates and velocities of an island, as far as possible the wanted ones; flags by velocity.
Independent Simulation::Impl::independent_of(int island, const std::vector<bool>& coordinates,
                                             const std::vector<bool>& speeds) const {
  const Island& of = *islands[island];
  const Mechanism& mechanism = of.prepared().mechanism;
  const MobilityAnalysis& mobility = of.prepared().mobility;
  const auto dynamics = make_dynamics(mechanism, of.loads());  // so that the run's own dynamics are not changed
  dynamics->set_max_rank(mobility.rank);
  // At a singular position the Jacobian does not show all dependencies.
  const bool singular = mobility.rank_start < mobility.rank && !mobility.generic_q.empty();
  dynamics->set_position((singular ? mobility.generic_q : prepared.islands[island].start.q).data());
  dynamics->factorize();
  return independent_at(mechanism, *dynamics, mobility, coordinates, speeds);
}

Eigen::VectorXd Simulation::Impl::sizes_of_states() const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(states.size()));
  for (std::size_t i = 0; i < states.size(); ++i) out[static_cast<Eigen::Index>(i)] = output_size[states[i]];
  return out;
}

std::vector<std::string> Simulation::Impl::names_of_coordinates(int island) const {
  std::vector<std::string> out;
  for (const int q : independent.coordinates) {
    if (prepared.reduced.joints[outputs[q].joint].island == island) out.push_back(outputs[q].name);
  }
  return out;
}

namespace {

void check_size(const char* what, std::size_t found, std::size_t expected) {
  if (found == expected) return;
  throw UsageError(std::string(what) + ": found " + std::to_string(found) + " numbers, expected " +
                   std::to_string(expected));
}

}  // namespace

const IndependentOutputs& StateDerivatives::independent() const { return impl_.independent; }
const std::vector<int>& StateDerivatives::states() const { return impl_.states; }

void StateDerivatives::take_states(const IndependentOutputs& chosen) {
  Simulation::Impl& s = impl_;
  if (!s.initialized) throw UsageError("states cannot be chosen before initialize()");
  const IndependentOutputs independent{chosen.coordinates, chosen.speeds, s.independent.elements};
  if (s.independent == independent) return;
  for (const auto* outputs : {&independent.coordinates, &independent.speeds}) {
    for (const int i : *outputs) {
      const Signal& signal = s.outputs.at(i);
      const bool of_tree = signal.level >= 0 && signal.level == (outputs == &independent.coordinates ? 0 : 1) &&
                           s.prepared.reduced.joints[signal.joint].role == JointPlace::Role::tree;
      if (!of_tree) throw UsageError(signal.name + " cannot be a state: its joint closes a loop or is immobile");
    }
  }
  s.sensitivity.reset();
  s.independent = independent;
  s.states = independent.states();
  for (int i = 0; i < static_cast<int>(s.islands.size()); ++i) {
    const auto wanted = [&](int level, const std::vector<int>& among) {
      return speeds_of(s.scene, s.prepared.reduced, s.outputs, i, level, among);
    };
    const std::vector<bool> speeds = wanted(1, independent.speeds);
    std::vector<bool> coordinates = wanted(0, independent.coordinates);
    // More than there are: of some quaternions only the rotations are meant of which the speeds are states.
    const PreparedIsland& island = s.islands[i]->prepared();
    if (std::ranges::count(coordinates, true) > island.mechanism.nv - island.mobility.position_rank)
      coordinates = rotations_of_speeds(s.scene, s.prepared.reduced, i, coordinates, speeds);
    // Besides these it may contain rotations of a quaternion that is not a state as a whole.
    Independent found = s.independent_of(i, coordinates, speeds);
    const auto keep = [](std::vector<int>& of, const std::vector<bool>& required) {
      const std::vector<int> all = numbers(required);
      if (!std::ranges::includes(of, all)) of = all;
    };
    keep(found.coordinates, coordinates);
    keep(found.speeds, speeds);
    s.independent_by_island[i] = found;
  }
}

void StateDerivatives::prepare() {
  Simulation::Impl& s = impl_;
  if (!s.initialized) throw UsageError("derivatives cannot be computed before initialize()");
  if (s.sensitivity) return;
  s.sensitivity = std::make_unique<Sensitivity>(s.prepared.reduced, s.islands, *s.readings, s.outputs, s.states,
                                                s.independent_by_island, s.u);
}

// Throws if a contact is closed of which derivatives are not known. in_time: those of outputs along the motion.
void StateDerivatives::refuse_closed_contacts(bool in_time) {
  Simulation::Impl& s = impl_;
  for (const auto& island : s.islands) {
    const ContactMotion& contacts = island->formulation().contacts();
    const bool has_modes = contacts.located() != nullptr && !contacts.are_used();
    if (has_modes && !in_time) continue;
    island->realize(Stage::velocity);
    const int closed =
        closed_contact(island->prepared().mechanism, island->dynamics().readings(), touching_law_count(s.scene));
    if (closed < 0) continue;
    const std::string why = has_modes ? "is closed: time derivatives of outputs exist for open contacts only"
                                      : "is closed in time steps, in which contacts have no modes: derivatives exist "
                                        "for open contacts only, or with located events";
    throw NotDifferentiable(describe_closed_contact(s.scene, closed, why, s.time));
  }
}

template <class Evaluate>
auto StateDerivatives::differentiate(Evaluate evaluate) {
  Simulation::Impl& s = impl_;
  prepare();
  try {
    s.u.go_to(s.time);
    return evaluate(*s.sensitivity);
  } catch (const NotDifferentiablePoint& fault) {
    if (fault.reason() == NotDifferentiablePoint::What::mode) {
      const Island& island = *s.islands[static_cast<std::size_t>(s.sensitivity->faulty_island())];
      throw NotDifferentiable(describe_mode_boundary(s.scene, island.loads(), fault.force(), s.time));
    }
    if (fault.reason() == NotDifferentiablePoint::What::contact)
      throw NotDifferentiable(describe_contact_edge(s.scene, {fault.force(), fault.edge()}, s.time));
    throw NotDifferentiable(
        describe_undetermined(s.scene, fault, s.time, s.names_of_coordinates(s.sensitivity->faulty_island())));
  } catch (const SingularMass& fault) {
    throw NotDifferentiable(describe_lost_inertia(s.time, fault.what()));
  }
}

Linearization StateDerivatives::linearize(FrictionTreatment friction) {
  refuse_closed_contacts(false);
  Linearization out = differentiate([&](Sensitivity& s) { return s.linearize(friction); });
  const Simulation::Impl& s = impl_;
  if (s.scene.units.is_si() && s.scene.states.empty()) return out;
  const Sizes x = s.sizes_of_states();
  const Sizes u = sizes(s.input_size);
  const Sizes y = sizes(s.output_size);
  out.A = x.asDiagonal() * out.A * x.cwiseInverse().asDiagonal();
  out.B = x.asDiagonal() * out.B * u.cwiseInverse().asDiagonal();
  out.C = y.asDiagonal() * out.C * x.cwiseInverse().asDiagonal();
  out.D = y.asDiagonal() * out.D * u.cwiseInverse().asDiagonal();
  out.xdot = x.cwiseProduct(out.xdot);
  return out;
}

DirectionalDerivative StateDerivatives::directional_derivative(const std::vector<double>& dx,
                                                               const std::vector<double>& du) {
  check_size("dx", dx.size(), impl_.states.size());
  check_size("du", du.size(), impl_.u.count());
  const Simulation::Impl& s = impl_;
  const auto natural = [](const std::vector<double>& si, const Sizes& of) {
    std::vector<double> out = si;
    for (std::size_t i = 0; i < out.size(); ++i) out[i] /= of[static_cast<Eigen::Index>(i)];
    return out;
  };
  const Sizes x = s.sizes_of_states();
  const std::vector<double> along_x = natural(dx, x);
  const std::vector<double> along_u = natural(du, sizes(s.input_size));
  refuse_closed_contacts(false);
  DirectionalDerivative out = differentiate([&](Sensitivity& of) { return of.along(along_x, along_u); });
  out.outputs = sizes(s.output_size).asDiagonal() * out.outputs;
  out.rates = x.asDiagonal() * out.rates;
  out.xdot = x.cwiseProduct(out.xdot);
  return out;
}

Eigen::MatrixX2d StateDerivatives::output_derivatives(const std::vector<double>& udot,
                                                      const std::vector<double>& uddot) {
  const Inputs& u = impl_.u;
  const auto known = [&](const char* name, const std::vector<double>& given, int order) {
    if (!given.empty()) check_size(name, given.size(), u.count());
    std::vector<double> rates(given);
    for (std::size_t i = 0; i < rates.size(); ++i) rates[i] /= impl_.input_size[i];
    for (auto i = static_cast<int>(given.size()); i < static_cast<int>(u.count()); ++i) {
      rates.push_back(u.rate(i, order));
    }
    if (u.has_clock()) rates.push_back(order == 1 ? 1 : 0);
    return rates;
  };
  const std::vector<double> first = known("udot", udot, 1);
  const std::vector<double> second = known("uddot", uddot, 2);
  refuse_closed_contacts(true);
  const Eigen::MatrixX2d out = differentiate([&](Sensitivity& s) { return s.in_time(first, second); });
  return sizes(impl_.output_size).asDiagonal() * out;
}

}  // namespace gelenk
