// SPDX-License-Identifier: BSD-3-Clause
// The states of a simulation, and derivatives by them and by time.
#include <algorithm>

#include "simulation/report.h"
#include "simulation/simulation_impl.h"
#include "simulation/start.h"

namespace gelenk {

void Simulation::Impl::find_independent() {
  independent.clear();
  independent_by_island.clear();
  std::vector<std::vector<bool>> is_free;  // by island, speed
  for (std::size_t i = 0; i < islands.size(); ++i) {
    const Mechanism& mechanism = islands[i]->mechanism();
    const auto speeds =
        independent_of(static_cast<int>(i), preferred_speeds(scene, prepared.reduced, static_cast<int>(i)));
    is_free.emplace_back(mechanism.nv, false);
    for (const int k : speeds) is_free[i][k] = true;
    independent_by_island.push_back(speeds);
  }
  for (int i = 0; i < static_cast<int>(outputs.size()); ++i) {
    const Signal& s = outputs[i];
    if (s.level != 0) continue;
    const JointPlace& place = prepared.reduced.joints[s.joint];
    if (place.role != JointPlace::Role::tree) continue;
    // A quaternion counts if all three turns are free.
    const JointKind& kind = *find_joint_kind(scene.joints[s.joint].type);
    const bool quaternion = kind.has_quaternion() && s.component >= kind.nq - 4;
    const int first = place.iv + (quaternion ? kind.nv - 3 : s.component);
    const int last = quaternion ? first + 2 : first;
    const std::vector<bool>& of_island = is_free[place.island];
    if (of_island[first] && of_island[last] && of_island[(first + last) / 2]) independent.push_back(i);
  }
  states = states_behind(scene, outputs, independent);
}

// prefer: by speed of the island, those wanted among them.
std::vector<int> Simulation::Impl::independent_of(int island, const std::vector<bool>& prefer) const {
  const Island& of = *islands[island];
  const Structure& structure = of.structure();
  const auto dynamics = make_dynamics(of.mechanism(), of.loads());  // the run's own stays as it is
  dynamics->limit_rank(structure.rank);
  // A singular start tells too little of what depends on what.
  const bool singular = structure.rank_start < structure.rank && !structure.idle_q.empty();
  const std::vector<double>& q = singular ? structure.idle_q : prepared.islands[island].start.q;
  return independent_speeds(of.mechanism(), *dynamics, q, structure.rank, prefer);
}

std::vector<std::string> Simulation::Impl::names_of_coordinates(int island) const {
  std::vector<std::string> out;
  for (const int q : independent) {
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

const std::vector<int>& Simulation::independent_coordinates() const { return impl_->independent; }
const std::vector<StateVariable>& Simulation::states() const { return impl_->states; }

void Simulation::take_states(const std::vector<int>& independent_coordinates) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("states before initialize()");
  if (s.independent == independent_coordinates) return;
  for (const int q : independent_coordinates) {
    const Signal& signal = s.outputs.at(q);
    const bool of_tree = signal.level == 0 && s.prepared.reduced.joints[signal.joint].role == JointPlace::Role::tree;
    if (!of_tree) throw UsageError(signal.name + " is no state: its joint closes a loop or cannot move");
  }
  s.sensitivity.reset();
  s.independent = independent_coordinates;
  s.states = states_behind(s.scene, s.outputs, s.independent);
  for (int i = 0; i < static_cast<int>(s.islands.size()); ++i) {
    const std::vector<bool> wanted = speeds_behind(s.prepared.reduced, s.outputs, i, s.states);
    std::vector<int> all;
    for (int k = 0; k < static_cast<int>(wanted.size()); ++k) {
      if (wanted[k]) all.push_back(k);
    }
    // Beside them may stand turns of a quaternion that is no state as a whole.
    const std::vector<int> found = s.independent_of(i, wanted);
    s.independent_by_island[i] = std::ranges::includes(found, all) ? found : all;
  }
}

template <class Ask>
auto Simulation::differentiate(Ask ask) {
  Impl& s = *impl_;
  if (!s.initialized) throw UsageError("a derivative before initialize()");
  if (!s.sensitivity) {
    s.sensitivity = std::make_unique<Sensitivity>(s.prepared.reduced, s.islands, *s.readings, s.outputs, s.states,
                                                  s.independent_by_island, s.u.now());
  }
  try {
    s.u.go_to(s.time);
    return ask(*s.sensitivity);
  } catch (const Undetermined& fault) {
    throw NotDifferentiable(
        describe_undetermined(fault.reason(), s.time, s.names_of_coordinates(s.sensitivity->faulty_island())));
  } catch (const SingularMass& fault) {
    throw NotDifferentiable(describe_lost_inertia(s.time, fault.what()));
  }
}

Linearization Simulation::linearize() {
  return differentiate([](Sensitivity& s) { return s.linearize(); });
}

Slope Simulation::slope_along(const std::vector<double>& dx, const std::vector<double>& du) {
  check_size("dx", dx.size(), impl_->states.size());
  check_size("du", du.size(), impl_->u.count());
  return differentiate([&](Sensitivity& s) { return s.along(dx, du); });
}

Eigen::MatrixX2d Simulation::output_derivatives(const std::vector<double>& udot, const std::vector<double>& uddot) {
  const Inputs& u = impl_->u;
  const auto known = [&](const char* name, const std::vector<double>& given, int order) {
    if (!given.empty()) check_size(name, given.size(), u.count());
    std::vector<double> rates(given);
    for (auto i = static_cast<int>(given.size()); i < static_cast<int>(u.count()); ++i) {
      rates.push_back(u.rate(i, order));
    }
    return rates;
  };
  const std::vector<double> first = known("udot", udot, 1);
  const std::vector<double> second = known("uddot", uddot, 2);
  return differentiate([&](Sensitivity& s) { return s.in_time(first, second); });
}

}  // namespace gelenk
