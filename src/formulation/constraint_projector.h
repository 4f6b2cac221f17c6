// SPDX-License-Identifier: BSD-3-Clause
// Projection onto the constraints during a run: Newton's method for Phi = 0 and for J v = b, reusing factors as long as
// it converges.
#pragma once

#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

// Each correction is the smallest in the mass metric.
class ConstraintProjector {
 public:
  ConstraintProjector(const Mechanism& mechanism, Dynamics& dynamics);
  virtual ~ConstraintProjector() = default;

  // Project the coordinates q (nq) or the velocities v (nv) and leave `dynamics` there. Return false if the iteration
  // does not converge.
  bool close_position(double* q);
  bool close_velocity(double* v);

  // Factorizes at the position of `dynamics`; later solutions use these factors.
  void refactorize();
  // Call if `dynamics` has been factorized at its position by another object.
  virtual void factors_changed() {}
  // New factors are computed when next needed.
  void discard_factors() { has_factors_ = false; }
  bool has_factors() const { return has_factors_; }

  // With the present factors: the smallest displacement dv (nv) that removes the residual of the constraint equations.
  virtual void min_norm_displacement(const double* residual, double* dv) {
    dynamics_.min_norm_displacement(residual, dv);
  }
  // m: length of the mechanism plus 1; the rounding error of closed loops is proportional to it.
  double length() const { return length_; }

 protected:
  // Factors of the present position have been found otherwise.
  void has_other_factors() { has_factors_ = true; }
  virtual void refactor() { dynamics_.factorize(); }
  // Factor on the rounding error up to which a stalled iteration counts as converged.
  virtual double slack() const { return 1e3; }
  // Ratio of successive errors of an iteration above which its factors are renewed.
  virtual double renewal_ratio() const { return 0.1; }
  // Sum of the corrections of an iteration [m, rad] beyond which lies another assembly.
  virtual double most_corrected() const;

  const Mechanism& mechanism_;
  Dynamics& dynamics_;

 private:
  double rounding(const double* q) const;

  double length_;
  bool has_factors_ = false;
  std::vector<double> dv_;
};

}  // namespace gelenk
