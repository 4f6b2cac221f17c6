// SPDX-License-Identifier: BSD-3-Clause
// The kernels, instantiated for numbers that record.
#include "derivatives/residual_evaluator_impl.h"
#include "kinematics/coordinate_rows.h"
#include "kinematics/load_kernels_impl.h"
#include "kinematics/loop_kernels_impl.h"
#include "kinematics/model_impl.h"
#include "kinematics/output_kernels_impl.h"
#include "kinematics/tree_kernels_impl.h"
#include "recorded/recorded_algebra.h"
#include "recorded/recorded_island.h"

namespace gelenk {

template struct Model<PlanarAlgebra<Recorded>>;
template struct Model<SpatialAlgebra<Recorded>>;
template struct Workspace<PlanarAlgebra<Recorded>>;
template struct Workspace<SpatialAlgebra<Recorded>>;
template std::unique_ptr<ResidualEvaluator<Recorded>> make_residual_evaluator(const Mechanism&, const Loads&);

namespace kernels {

#define GELENK_INSTANTIATE(A)                                                        \
  template void root_poses(const Model<A>&, const std::vector<int>&, Workspace<A>&); \
  template void mass_matrix(const Model<A>&, Workspace<A>&, FullMatrix&);            \
  template void loop_jacobian(const Model<A>&, const Workspace<A>&, FullRows&);
GELENK_INSTANTIATE(PlanarAlgebra<Recorded>)
GELENK_INSTANTIATE(SpatialAlgebra<Recorded>)
#undef GELENK_INSTANTIATE

}  // namespace kernels

namespace {

template <class Compute>
bool has_hidden_branches(Compute compute) {
  try {
    compute();
  } catch (const recording::HiddenBranch&) {
    return true;
  }
  return false;
}

template <class A>
HiddenAtJoints hidden_at_joints(const Mechanism& mechanism, const Loads& loads,
                                const std::vector<double>& cut_reference, const RecordedIsland& island) {
  HiddenAtJoints out;
  const Recorded* const q = island.q.data();
  const Recorded* const v = island.v.data();
  const Recorded* const u = island.signals.data();
  each_list(loads.tree.lists, [&](const auto& list) {
    for (const auto& force : list) {
      const auto compute = [&] {
        if constexpr (Switches<std::decay_t<decltype(force.element)>>) {
          force.held(1, q, v, u);
        } else {
          force.effort(q, v, u);
        }
      };
      if (has_hidden_branches(compute)) out.elements.push_back({force.joint, force.component});
    }
  });
  const Model<A> model(mechanism);
  Workspace<A> ws(model);
  kernels::positions(model, q, ws);
  kernels::velocities(model, q, v, kernels::root_acceleration<A>(loads), ws);
  for (int c = 0; c < static_cast<int>(model.cuts.size()); ++c) {
    const auto& cut = model.cuts[static_cast<std::size_t>(c)];
    const auto compute = [&] {
      auto& X_FM = ws.X_FM[static_cast<std::size_t>(c)];
      X_FM = kernels::pose_around<A>(cut, ws);
      Row<A> rows[6];
      kernels::kept_rows<A>(cut, X_FM, rows);
      Recorded bias[6];
      kernels::add_rows_bias<A>(cut, X_FM, {}, bias);
      const JointLoads& on = loads.cuts[static_cast<std::size_t>(c)];
      if (on.empty()) return;
      const auto at = kernels::counted_cut_motion(model, ws, c, cut_reference.data());
      Recorded tau[6];
      const std::vector<int> modes(static_cast<std::size_t>(on.switching_count()), 0);
      on.add(at.q.data(), at.v.data(), u, tau, modes.data());
    };
    if (has_hidden_branches(compute)) out.cuts.push_back(c);
  }
  kernels::each_coordinate_row(model, [&](const CoordinateRow& row, std::size_t i, std::size_t) {
    Recorded factors[RelationLaw::most_terms];
    if (row.relation && has_hidden_branches([&] { kernels::relation_value(row, q, factors); }))
      out.coordinate_rows.push_back(static_cast<int>(i));
  });
  for (std::size_t k = 0; k < loads.rates.size(); ++k) {
    if (has_hidden_branches([&] { loads.rates[k].value_among<Recorded>(nullptr, u); }))
      out.states.push_back(static_cast<int>(k));
  }
  return out;
}

}  // namespace

HiddenAtJoints joints_with_hidden_branches(const Mechanism& mechanism, const Loads& loads,
                                           const std::vector<double>& cut_reference, const RecordedIsland& island) {
  if (mechanism.planar) return hidden_at_joints<PlanarAlgebra<Recorded>>(mechanism, loads, cut_reference, island);
  return hidden_at_joints<SpatialAlgebra<Recorded>>(mechanism, loads, cut_reference, island);
}

}  // namespace gelenk
