// SPDX-License-Identifier: BSD-3-Clause
// How loop constraints meet an integrator: what all formulations share, and which there are. Most make an ODE of
//   M vdot + h + J^T lambda = tau,   Phi = 0,   J v = b,   J vdot = gamma;
// they differ in the accelerations they take and in what keeps the state near Phi = 0, J v = b. Two leave it a DAE
// (with_multipliers.h). Outputs (accelerations, reactions) are those of the equations above at the state reached,
// whatever the formulation.
#pragma once

#include <climits>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "dynamics/dynamics.h"
#include "event/event_log.h"
#include "event/singularity_monitor.h"
#include "formulation/corrector.h"
#include "formulation/drives.h"
#include "formulation/equations.h"
#include "formulation/modes.h"
#include "formulation/revolution_counter.h"
#include "formulation/row_domain.h"
#include "util/archive.h"

namespace gelenk {

struct FormulationOptions {
  double step = 1e-3;           // s: of fixed-step methods or between outputs
  double baumgarte_alpha = 0;   // 1/s; 0: chosen from the step
  double baumgarte_beta = 0;    // 1/s; likewise
  int corrections = 0;          // of projection after each step; 0: until closed
  double best_pivot_ratio = 0;  // largest pivot ratio known of the rows (MobilityAnalysis); 0: none is
};

// What a formulation works with; all but the options outlives it.
struct FormulationContext {
  const Mechanism& mechanism;
  Dynamics& dynamics;
  Inputs& inputs;  // taken at every evaluation to its time
  EventLog& events;
  FormulationOptions options{};
};

class Formulation : public Equations {
 public:
  explicit Formulation(const FormulationContext& context);

  int size() const final { return mechanism_.nq + mechanism_.nv; }
  int coordinates() const final { return mechanism_.nq; }
  bool rhs(double t, const double* y, double* ydot) override;
  bool jacobian(double t, const double* y, double* J) override;
  std::string obstacle(const double* y) override;
  void displace(double* q, const double* dv) const final { dynamics_.displace(q, dv); }
  // Unless a formulation says otherwise: quaternions are made unit again, no more.
  bool project(double t, double* y) override;
  void accepted(double t, const double* y) override;
  bool budget_exhausted() const final { return dynamics_.evaluations() >= last_evaluation_; }
  EventSource& modes() final { return modes_; }

  // From now on: calls of solve and assemble until budget_exhausted(); LONG_MAX: without end.
  void set_evaluation_budget(long evaluations);
  // The run begins at (t, y), or anew. cut_q: the cut joints' angles are those nearest to these.
  virtual void start(const std::vector<double>& cut_q, double t, const double* y);
  // The inputs have jumped at (t, y), where the run stands.
  virtual void inputs_changed(double /*t*/, const double* /*y*/) {}
  // Takes y onto the constraints where these have jumped, by the least change in the mass metric: of speeds, an impact.
  // False: not reached.
  bool project_onto_constraints(double t, double* y);
  // vdot for outputs, at a state accepted at t; `dynamics` is left there, velocities and accelerations included.
  void output_accelerations(double t, const double* y, double* vdot);
  // What it carries from one step to the next. The factors are not among it: they are made anew afterwards, in the run
  // that wrote the record as in the one that reads it.
  virtual void serialize(Archive& archive);

  Drives& drives() { return drives_; }
  const RevolutionCounter& revolutions() const {
    return revolutions_;
  }  // of the cut joints, at the state accepted last
  const SingularityMonitor& singularity_monitor() const {
    return singularity_monitor_;
  }                                              // of singular positions since the start
  long jacobians() const { return jacobian_count_; }  // made since construction

 protected:
  // From state y on, the inputs at t. False: as rhs.
  bool evaluate(double t, const double* y, double* ydot);
  // Whether accelerate() leaves factors of the rows, which tell singular positions.
  virtual bool factorizes_constraints() const { return true; }
  // vdot at (t, y); `dynamics` is at its position, without velocities. False: as rhs.
  virtual bool accelerate(double t, const double* y, double* vdot);
  // vdot where `dynamics` stands, by the factors at hand.
  virtual void solve(double t, double* vdot);
  // Rows nq.. of df/dy into `out` (size() x size()), from slopes_ at the state of the last accelerate(); vdot: found
  // there.
  virtual void differentiate(const double* vdot, Eigen::Map<Eigen::MatrixXd>& out);
  // out (nq..) <- the slopes of vdot when J vdot = gamma is solved for exactly, from slopes_, with the last factors.
  void acceleration_jacobian(Eigen::Map<Eigen::MatrixXd>& out);
  void count_jacobian() { ++jacobian_count_; }
  virtual Corrector& corrector() { return corrector_; }

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  Drives drives_;
  Jacobians jacobians_;

 private:
  std::string dead_center();

  EventLog& events_;
  Corrector corrector_;
  Modes modes_;
  RowDomain row_domain_;
  RevolutionCounter revolutions_;
  SingularityMonitor singularity_monitor_;
  long jacobian_count_ = 0;
  long last_evaluation_ = LONG_MAX;
  std::vector<double> dv_, ydot_;
};

struct FormulationKind {
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<Formulation> (*make)(const FormulationContext& context);
};

// All formulations that can be named in a scene (registry.cpp), the default first; names as in scene/words.h.
std::span<const FormulationKind> formulation_kinds();

// Throws std::out_of_range for an unknown name.
std::unique_ptr<Formulation> make_formulation(std::string_view name, const FormulationContext& context);

// One per file.
std::unique_ptr<Formulation> make_projection(const FormulationContext& context);
std::unique_ptr<Formulation> make_baumgarte(const FormulationContext& context);
std::unique_ptr<Formulation> make_udwadia_kalaba(const FormulationContext& context);
std::unique_ptr<Formulation> make_penalty(const FormulationContext& context);
std::unique_ptr<Formulation> make_augmented_lagrangian(const FormulationContext& context);
std::unique_ptr<Formulation> make_independent(const FormulationContext& context);
std::unique_ptr<Formulation> make_index3(const FormulationContext& context);
std::unique_ptr<Formulation> make_stabilized_index2(const FormulationContext& context);

}  // namespace gelenk
