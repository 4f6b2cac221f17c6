// SPDX-License-Identifier: BSD-3-Clause
// The equations of motion for dual numbers and power series (math/dual.h, math/series.h), as residuals
//   r = M(q) vdot + h(q, v) + J(q)^T lambda - tau(q, v, u)     (nv)
//   c = J(q) vdot - gamma(q, v)                                (rows)
// and all quantities from which outputs are read. After construction no function allocates memory.
#pragma once

#include <memory>
#include <vector>

#include "kinematics/readings.h"

namespace gelenk {

struct Loads;
struct Mechanism;

template <class T>
class ResidualEvaluator : public Readings<T> {
 public:
  // See Kinematics::set_targets; effective from the next set_position().
  virtual void set_targets(const T* targets) = 0;
  // Holds the forces with modes in these (JointLoads::add), read at each evaluation; null: in those of the state.
  virtual void hold(const int* sides) = 0;
  // Applies these wrenches to the links besides the loads (ContactRows::apply_forces), read at each evaluation; null:
  // none.
  virtual void apply_forces(const typename Readings<T>::Force* wrenches) = 0;
  // --- to be called in this order; each uses the results of the earlier ones, and any may be called again ---
  virtual void set_position(const T* q) = 0;
  virtual void set_velocity(const T* v) = 0;
  // u: the inputs of the scene and its clock, and the element states.
  virtual void set_acceleration(const T* u, const T* vdot, const T* lambda) = 0;

  // u, followed by what expressions name of the motion (kinematics/loads.h); after set_velocity.
  virtual const T* all_signals(const T* u) = 0;

  // Sets the coordinates of cut joints with full revolutions; cut_nq numbers.
  virtual void set_cut_reference(const double* q) = 0;

  virtual const std::vector<T>& Phi() const = 0;                    // after set_position
  virtual const std::vector<T>& row_rates() const = 0;              // J v - b, after set_velocity
  virtual const std::vector<T>& qdot() const = 0;                   // N v, after set_velocity
  virtual const std::vector<T>& force_residual() const = 0;         // r, after set_acceleration
  virtual const std::vector<T>& acceleration_residual() const = 0;  // c, after set_acceleration
  // Coordinates of all cut joints with full revolutions, after set_position; overwritten by the next call.
  virtual const std::vector<T>& cut_coordinates() = 0;
};

// T: Dual or Series.
template <class T>
std::unique_ptr<ResidualEvaluator<T>> make_residual_evaluator(const Mechanism& mechanism, const Loads& loads);

}  // namespace gelenk
