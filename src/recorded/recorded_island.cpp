// SPDX-License-Identifier: BSD-3-Clause
#include "recorded/recorded_island.h"

#include <cstddef>
#include <type_traits>
#include <variant>

#include "derivatives/residual_evaluator.h"
#include "element/constraints/cut_joint.h"
#include "kinematics/coordinate_rows.h"
#include "kinematics/friction_loads.h"
#include "kinematics/kernels.h"
#include "kinematics/load_kernels.h"
#include "math/choose.h"
#include "recorded/recorded_algebra.h"
#include "recorded/recorded_forces.h"

namespace gelenk {
namespace {

using Numbers = RecordedIsland::Numbers;

Numbers zeros(std::size_t count) { return Numbers(count, Recorded(0)); }

std::size_t at(int row, int column, int columns) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
}

template <class A>
void record_matrices(const Mechanism& mechanism, const Loads& loads, RecordedIsland& island) {
  const Model<A> model(mechanism);
  Workspace<A> ws(model);
  kernels::positions(model, island.q.data(), ws);
  kernels::loop_positions(model, ws);
  kernels::coordinate_row_positions(model, island.q.data(), island.targets, ws);
  for (std::size_t c = 0; c < model.cuts.size(); ++c) {
    const auto note = [&](const auto& constraint) {
      if constexpr (requires { constraint.template distance_from_undefined<Recorded>(ws.X_FM[c]); })
        island.distances.push_back(constraint.template distance_from_undefined<Recorded>(ws.X_FM[c]));
    };
    visit_joint<A>(model.cuts[c].joint, [&](const auto& joint) {
      if constexpr (std::is_same_v<std::decay_t<decltype(joint)>, AnyBodyConstraint>) std::visit(note, joint.is);
    });
  }
  const int nv = model.nv;
  FullMatrix M(model);
  kernels::mass_matrix(model, ws, M);
  island.M = zeros(at(nv, 0, nv));
  for (int k = 0; k < nv; ++k) {
    const std::vector<int>& columns = M.columns[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < columns.size(); ++i) {
      Recorded& lower = island.M[at(k, columns[i], nv)];
      lower = M.rows[static_cast<std::size_t>(k)][i];
      if (columns[i] == k) lower += Recorded(loads.added_inertia[static_cast<std::size_t>(k)]);
      island.M[at(columns[i], k, nv)] = lower;
    }
  }
  FullRows J(model);
  kernels::loop_jacobian(model, ws, J);
  island.J = zeros(at(model.rows, 0, nv));
  for (int r = 0; r < static_cast<int>(J.columns.size()); ++r) {
    const std::vector<int>& columns = J.columns[static_cast<std::size_t>(r)];
    for (std::size_t i = 0; i < columns.size(); ++i)
      island.J[at(r, columns[i], nv)] += J.all[J.first[static_cast<std::size_t>(r)] + i];
  }
  kernels::each_coordinate_row(model, [&](const CoordinateRow& row, std::size_t i, std::size_t k) {
    for (const CoordinateRow::Term& term : row.terms)
      island.J[at(model.first_coordinate_row + static_cast<int>(i), term.v, nv)] +=
          kernels::factor_of(row, term, k++, ws);
  });
}

// Forces with modes along tree joints, which are 0 in mode 0: on the given sides, or else friction in the direction of
// the speed.
void add_switching(const Loads& loads, const Recorded* u, RecordedIsland& island) {
  std::size_t next = 0;
  loads.tree.each_switching([&](const auto& force) {
    const std::size_t index = next++;
    if (island.sides.empty() && !Sticks<std::decay_t<decltype(force.element)>>) return;
    const auto v = static_cast<std::size_t>(force.v);
    const Recorded side = island.sides.empty() ? Recorded(force.sign) * island.v[v] : island.sides[index];
    const auto in = [&](int held) { return force.held(held, island.q.data(), island.v.data(), u); };
    island.h[v] -= choose(
        side, [&] { return in(1); }, [&] { return choose(-side, [&] { return in(-1); }, [] { return Recorded(0); }); });
  });
}

int forces_with_modes(const Loads& loads) {
  int count = loads.tree.switching_count();
  for (const JointLoads& cut : loads.cuts) count += cut.switching_count();
  return count;
}

}  // namespace

void record(const Mechanism& mechanism, const Loads& loads, const std::vector<double>& cut_reference,
            RecordedIsland& island) {
  const auto evaluator = make_residual_evaluator<Recorded>(mechanism, loads);
  const std::vector<int> modes(static_cast<std::size_t>(forces_with_modes(loads)), 0);
  evaluator->hold(modes.data());
  evaluator->set_cut_reference(cut_reference.data());
  evaluator->set_targets(island.targets.data());
  evaluator->set_position(island.q.data());
  evaluator->set_velocity(island.v.data());
  const Numbers vdot = zeros(island.v.size());
  const Numbers lambda = zeros(static_cast<std::size_t>(mechanism.rows));
  evaluator->set_acceleration(island.signals.data(), vdot.data(), lambda.data());
  island.h = evaluator->force_residual();
  for (const Recorded& c : evaluator->acceleration_residual()) island.gamma.push_back(-c);
  island.Phi = evaluator->Phi();
  island.rate = evaluator->row_rates();
  island.qdot = evaluator->qdot();
  const EnergyOf<Recorded> energy = evaluator->energy();
  island.kinetic = energy.kinetic;
  island.potential = energy.potential;
  island.rates = zeros(loads.rates.size());
  evaluator->state_rates(island.signals.data(), island.rates.data());
  add_switching(loads, evaluator->all_signals(island.signals.data()), island);
  if (mechanism.planar) return record_matrices<PlanarAlgebra<Recorded>>(mechanism, loads, island);
  record_matrices<SpatialAlgebra<Recorded>>(mechanism, loads, island);
}

std::vector<int> forces_with_hidden_branches(const Mechanism& mechanism, const Loads& loads,
                                             const RecordedIsland& island) {
  const auto found = [&]<class A> {
    const Model<A> model(mechanism);
    Workspace<A> ws(model);
    kernels::positions(model, island.q.data(), ws);
    kernels::root_poses(model, all_links(mechanism), ws);
    kernels::velocities(model, island.q.data(), island.v.data(), kernels::root_acceleration<A>(loads), ws);
    return kernels::hidden_branches(loads, island.signals.data(), ws);
  };
  return mechanism.planar ? found.operator()<PlanarAlgebra<Recorded>>() : found.operator()<SpatialAlgebra<Recorded>>();
}

std::vector<int> friction_by_loads(const Mechanism& mechanism, const Loads& loads) {
  std::vector<int> out;
  const auto add = [&](const std::vector<FrictionLoad>& all) {
    for (const FrictionLoad& load : all) {
      if (out.empty() || out.back() != load.force) out.push_back(load.force);
    }
  };
  if (mechanism.planar) {
    add(friction_loads(Model<Planar>(mechanism), loads));
  } else {
    add(friction_loads(Model<Spatial>(mechanism), loads));
  }
  return out;
}

}  // namespace gelenk
