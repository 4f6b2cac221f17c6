// SPDX-License-Identifier: BSD-3-Clause
// Implementation of Readings from the workspace of the kernels, for the scalar type of the algebra A.
#pragma once

#include <algorithm>
#include <vector>

#include "kinematics/force_modes.h"
#include "kinematics/load_kernels.h"
#include "kinematics/named_quantities.h"
#include "kinematics/output_kernels.h"
#include "kinematics/readings.h"
#include "kinematics/visit.h"

namespace gelenk {

// Base: Readings of A's scalar type, or a class derived from it.
template <class A, class Base>
class WithReadings : public Base {
 public:
  using T = typename A::Scalar;
  using Pose = typename SpatialAlgebra<T>::Pose;
  using Motion = typename SpatialAlgebra<T>::Motion;
  using Force = typename SpatialAlgebra<T>::Force;

  WithReadings(const Mechanism& mechanism, const Loads& loads)
      : mechanism_(mechanism),
        loads_(loads),
        model_(mechanism),
        ws_(model_),
        q_(mechanism.nq),
        v_(mechanism.nv),
        cut_reference_(mechanism.cut_nq),
        targets_(3 * mechanism.coordinate_rows.size()),
        signals_(loads.signals() == loads.first_named() ? 0 : static_cast<std::size_t>(loads.signals())) {}

  void cut_speeds(int cut, T* v) const override {
    T q[max_cut_nq] = {};
    counted_coordinates(cut, q);
    kernels::cut_speeds<A>(model_.cuts[cut], ws_.X_FM[cut], ws_.V_FM[cut], q, v);
  }
  void cut_accelerations(int cut, T* a) const override {
    T q[max_cut_nq] = {};
    T v[6];
    counted_coordinates(cut, q);
    kernels::cut_speeds<A>(model_.cuts[cut], ws_.X_FM[cut], ws_.V_FM[cut], q, v);
    kernels::cut_accelerations<A>(model_.cuts[cut], ws_, cut, q, v, a);
  }

  EnergyOf<T> energy() const override {
    EnergyOf<T> sum = kernels::energy(model_, loads_, ws_);
    for (int k = 0; k < model_.nv; ++k) sum.kinetic += loads_.added_inertia[k] * v_[k] * v_[k] / 2;
    sum.potential += loads_.tree.energy(q_.data());
    for (int c = 0; c < static_cast<int>(model_.cuts.size()); ++c) {
      if (loads_.cuts[c].stores_nothing()) continue;
      T q[max_cut_nq] = {};
      counted_coordinates(c, q);
      sum.potential += loads_.cuts[c].energy(q);
    }
    return sum;
  }

  void state_rates(const T* u, T* out) override {
    const T* const all = with_named(u);
    for (const Formula& rate : loads_.rates)
      *out++ = rate.reads_forces() ? T(0) : rate.value_among<T>(nullptr, all);  // Outputs has those of forces
  }
  void expression_values(const T* u, T* out) override {
    const T* const all = with_named(u);
    for (const Formula& value : loads_.values)
      *out++ = value.reads_forces() ? T(0) : value.value_among<T>(nullptr, all);
  }

  Pose link_pose(int link) const override { return kernels::pose3<A>(ws_.X_0L[link], height(link)); }
  Motion link_velocity(int link) const override { return kernels::motion3<A>(ws_.V[link]); }
  Motion link_acceleration(int link) const override {
    // Gravity is an acceleration of the root.
    return kernels::motion3<A>(ws_.A_full[link] - ws_.X_0L[link].to_child(ws_.A_full[0]));
  }
  Pose rod_pose(int cut) const override {
    const auto& c = model_.cuts[cut];
    const RodState state = rod_state(cut);
    const double z = mechanism_.planar ? mechanism_.cuts[cut].X_AF.p.z() : 0;
    return kernels::pose3<A>(ws_.X_0L[c.link_a] * c.X_AF * state.X_FR, height(c.link_a) + z);
  }
  Motion rod_velocity(int cut) const override {
    const auto& c = model_.cuts[cut];
    const RodState state = rod_state(cut);
    return kernels::motion3<A>(state.X_FR.to_child(c.X_AF.to_child(ws_.V[c.link_a])) + state.V_FR);
  }
  Force tree_reaction(int link) const override { return kernels::force3<A>(ws_.F[link]); }
  Force cut_reaction(int cut) const override { return kernels::force3<A>(kernels::cut_reaction(model_, ws_, cut)); }
  T contact_force(int cut, int i) const override { return -ws_.lambda[model_.cuts[cut].first_row + i]; }
  T coordinate_force(int row) const override {
    const T& lambda = ws_.lambda[model_.first_coordinate_row + row];
    const CoordinateRow& of = model_.coordinate_rows[row];
    if (!of.relation) return -lambda;
    std::size_t first = 0;
    for (int i = 0; i < row; ++i) first += model_.coordinate_rows[i].terms.size();
    return -lambda * ws_.factors[first] * T(of.terms.front().factor);
  }
  void switching_forces(const T* u, const int* sides, const T* holding, T* out) const override {
    T* first = out;
    kernels::each_switching(model_, loads_, ws_, q_.data(), v_.data(), cut_reference_.data(),
                            [&](const auto& force, const T* q, const T* v) {
                              const int side = *sides == mode_of_state ? force.side(q, v) : *sides;
                              *out++ = T(force.sign) * force.held(side, q, v, u) + *holding++;
                              ++sides;
                            });
    for (const T& friction : loaded_friction_) *first++ += friction;
  }
  Pose plane_pose(int cut) const override {
    const auto& c = model_.cuts[cut];
    return kernels::pose3<A>(ws_.X_0L[c.link_a] * c.X_AF, 0);  // contacts are spatial
  }
  Pose pose_on_plane(int cut) const override { return kernels::pose3<A>(ws_.X_FM[cut], 0); }

 protected:
  struct RodState {
    typename A::Pose X_FR;
    typename A::Motion V_FR;
  };
  RodState rod_state(int cut) const {
    T q[max_cut_nq] = {};
    T v[max_cut_nv] = {};
    counted_coordinates(cut, q);
    kernels::cut_speeds<A>(model_.cuts[cut], ws_.X_FM[cut], ws_.V_FM[cut], q, v);
    const Rod& rod = std::get<Rod>(model_.cuts[cut].joint);
    return {rod.rod_pose<A>(q), rod.rod_velocity<A>(q, v)};
  }

  void counted_coordinates(int cut, T* q) const {
    kernels::counted_cut_coordinates<A>(model_.cuts[cut], ws_.X_FM[cut], cut_reference_.data() + model_.cuts[cut].iq,
                                        q);
  }

  // All signals: u followed by the coordinates and the outputs of sensors that expressions name; u itself if there are
  // none. After set_velocity.
  const T* with_named(const T* u) {
    if (signals_.empty()) return u;
    std::copy_n(u, loads_.first_named(), signals_.begin());
    kernels::named_quantities(model_, loads_, ws_, q_.data(), v_.data(), cut_reference_.data(), *this,
                              signals_.data() + loads_.first_named());
    return signals_.data();
  }

  double height(int link) const { return mechanism_.planar ? mechanism_.heights[link] : 0; }

  const Mechanism& mechanism_;
  const Loads& loads_;
  Model<A> model_;
  Workspace<A> ws_;
  std::vector<T> q_, v_;               // the current state
  std::vector<double> cut_reference_;  // of cut joints, with full revolutions
  std::vector<T> targets_;             // of the coordinate constraints: s, s', s''
  // By force with modes: the friction in motion that depends on loads, in the user's sign; empty if there is none.
  std::vector<T> loaded_friction_;

 private:
  std::vector<T> signals_;  // if expressions name coordinates or outputs of sensors
};

}  // namespace gelenk
