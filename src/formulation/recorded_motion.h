// SPDX-License-Identifier: BSD-3-Clause
// The equations of motion as a program (recorded/equation_program.h), which evaluates them in place of the kernels
// where it can.
#pragma once

#include <memory>
#include <vector>

#include "formulation/constraint_projector.h"
#include "formulation/drives.h"
#include "recorded/equation_program.h"
#include "util/archive.h"

namespace gelenk {

class RecordedMotion {
 public:
  RecordedMotion(const Mechanism& mechanism, const Loads& loads, Dynamics& dynamics)
      : mechanism_(mechanism), loads_(loads), dynamics_(dynamics) {}

  // Records the equations for a run that begins at y, with the present targets. Pivots are chosen there, or near it if
  // that is a singular configuration. Leaves `dynamics` at y, and with no row as weak. Without effect where a body can
  // move without inertia.
  void record(const std::vector<double>& cut_reference, const double* y, const Drives& drives);
  // Call when numbers of the loads or inertias have changed: the kernels evaluate until the next record(), so that no
  // step has to wait for that.
  void loads_changed() { is_current_ = is_used_ = false; }

  // ydot at y, and factors there for displace(); false: the kernels have to evaluate. sides: the held modes of all
  // forces with modes, of which none holds anything at rest.
  bool evaluate(const double* y, const double* u, const int* sides, double* ydot) {
    return is_used_ && program_->evaluate({y, u, dynamics_.targets().data(), sides}, ydot);
  }
  void displace(const double* residual, double* dv) { program_->displace(residual, dv); }
  bool is_used() const { return is_used_; }
  double pivot_fraction() const { return program_->pivot_fraction(); }
  // Pivot ratio of the constraint Jacobian (Dynamics::pivot_ratio()) where pivots have their usual size; 0: unknown.
  double usual_pivot_ratio() const { return usual_pivot_ratio_; }
  void serialize(Archive& archive, const std::vector<double>& cut_reference);

 private:
  void choose(const std::vector<double>& cut_reference, const double* y, const Drives& drives);
  bool agrees(ConstraintProjector& projector, std::vector<double>& at, const Drives& drives);
  void make(const std::vector<double>& cut_reference, const Pivots& pivots);

  const Mechanism& mechanism_;
  const Loads& loads_;
  Dynamics& dynamics_;
  std::unique_ptr<EquationProgram> program_;
  bool is_current_ = false;  // made with the present numbers
  bool is_used_ = false;
  double usual_pivot_ratio_ = 0;
  Pivots pivots_;
};

}  // namespace gelenk
