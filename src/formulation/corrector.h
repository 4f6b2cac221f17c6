// SPDX-License-Identifier: BSD-3-Clause
// Newton's method onto the constraints during a run: onto Phi = 0 and onto J v = b, with the factors at hand as long as
// they serve.
#pragma once

#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

// Each step is the least in the mass metric.
class Corrector {
 public:
  Corrector(const Mechanism& mechanism, Dynamics& dynamics);
  virtual ~Corrector() = default;

  // Each leaves `dynamics` there. False: not reached.
  bool close_position(double* q);
  bool close_velocity(double* v);

  // Its factors at the position of `dynamics`; what else is solved with afterwards keeps to these.
  void refactorize();
  // Other factors have been made at the position of `dynamics`, not by it.
  virtual void factors_changed() {}
  // They are made anew when next needed.
  void discard_factors() { has_factors_ = false; }
  bool has_factors() const { return has_factors_; }

  // By the factors at hand: dv takes the residual of the rows away.
  virtual void min_norm_displacement(const double* residual, double* dv) {
    dynamics_.min_norm_displacement(residual, dv);
  }
  // m: of the mechanism, and 1; rounding of a closed loop grows with it.
  double length() const { return length_; }

 protected:
  virtual void refactor() { dynamics_.factorize(); }
  // How many times the rounding may be left where it ends the progress earlier.
  virtual double slack() const { return 1e3; }

  const Mechanism& mechanism_;
  Dynamics& dynamics_;

 private:
  double rounding(const double* q) const;

  double length_;
  bool has_factors_ = false;
  std::vector<double> dv_;
};

}  // namespace gelenk
