// SPDX-License-Identifier: BSD-3-Clause
// `projection`: the index-1 form
//   qdot = N v,   [M J^T; J 0] [vdot; lambda] = [tau - h; gamma],
// with q and v put back on Phi = 0, J v = 0 after every accepted step by the smallest correction in the mass
// metric (Eich 1993; Blajer 2002), so that neither drifts. Factors of the last evaluation are reused. Through singular
// positions the accelerations in the weak direction are carried on from before (projection.cpp).
#pragma once

#include <vector>

#include "dynamics/dynamics.h"
#include "formulation/ode_system.h"

namespace gelenk {

class Projection final : public OdeSystem {
 public:
  // u: the inputs, read at every evaluation.
  Projection(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<double>& u);

  int size() const override { return nq_ + nv_; }
  int coordinates() const override { return nq_; }
  bool rhs(double t, const double* y, double* ydot) override;
  bool jacobian(double t, const double* y, double* J) override;
  void displace(double* q, const double* dv) const override { dynamics_.displace(q, dv); }
  bool project(double t, double* y) override;
  void accepted(double t, const double* y) override;

  // The two halves of project(). Both leave `dynamics` at the projected state.
  bool project_position(double* q);
  bool project_velocity(double* v);

  // Coordinates of the cut joints with their angles counted through all turns; cut_nq numbers.
  const std::vector<double>& cut_coordinates() const { return cut_q_; }
  // Starts counting: angles nearest to the numbers given.
  void count_from(const std::vector<double>& cut_q, double t, const double* y);

 private:
  double rounding(const double* q) const;
  void count_turns(double t, const double* y);
  void factorise();
  double slack() const;
  const double* expected(double t);
  void remember(double t);

  // Accelerations at the last times at which the rows were sound, for the passage of singular positions.
  static constexpr int memory = 6;
  int remembered_ = 0;
  double times_[memory] = {};
  std::vector<double> accelerations_[memory];
  std::vector<double> expected_, u_seen_;
  double soundest_ = 0;    // largest pivot ratio seen
  bool sound_ = true;      // the last factors are not near a singular position
  bool rigorous_ = false;  // weak directions are corrected in full

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  const std::vector<double>& u_;
  int nq_, nv_;
  double length_;  // m: rounding of a closed loop grows with it
  bool factors_ = false;
  std::vector<double> dv_, ydot_;
  Slopes slopes_;
  std::vector<double> cut_q_, cut_v_, cut_v_last_;
  double last_time_ = 0;
};

}  // namespace gelenk
