// SPDX-License-Identifier: BSD-3-Clause
// The formulations of constrained motion: their common base class and registry. Most form an ODE from
//   M vdot + h + J^T lambda = tau,   Phi = 0,   J v = b,   J vdot = gamma;
// they differ in the accelerations and in how the state is kept near Phi = 0, J v = b. Two keep it a DAE
// (with_multipliers.h). Outputs (accelerations, reactions) are those of the equations above at the state reached,
// whichever formulation is used.
#pragma once

#include <climits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dynamics/dynamics.h"
#include "event/event_log.h"
#include "event/singularity_monitor.h"
#include "event_driven/event_modes.h"
#include "event_driven/mode_equations.h"
#include "event_driven/run_counts.h"
#include "formulation/constraint_projector.h"
#include "formulation/contact_motion.h"
#include "formulation/differences.h"
#include "formulation/drives.h"
#include "formulation/equations.h"
#include "formulation/rates_of_forces.h"
#include "formulation/revolution_counter.h"
#include "formulation/row_domain.h"
#include "nonsmooth/law_audit.h"
#include "nonsmooth/limit_correction.h"
#include "util/archive.h"

namespace gelenk {

class RecordedMotion;

struct FormulationOptions {
  double step = 1e-3;             // s: of fixed-step methods, or between outputs
  double baumgarte_alpha = 0;     // 1/s; 0: chosen from the step
  double baumgarte_beta = 0;      // 1/s; 0: equal to alpha
  int corrections = 0;            // projection iterations after each step; 0: until converged
  bool locates_contacts = false;  // contacts of shapes change at events, not in steps
  // Largest pivot ratio of the constraint Jacobian that is known where a run starts (MobilityAnalysis); must outlive
  // the formulation; null: unknown.
  const double* best_pivot_ratio = nullptr;
};

// The objects that a formulation refers to; all but the options must outlive it.
struct FormulationContext {
  const Mechanism& mechanism;
  Dynamics& dynamics;
  Inputs& inputs;  // set to the time of each evaluation
  EventLog& events;
  const Loads& loads;
  FormulationOptions options{};
  RecordedMotion* program = nullptr;  // of the equations; null: they are not evaluated by one
};

class Formulation : public Equations, private ModeEquations {
 public:
  explicit Formulation(const FormulationContext& context);

  int size() const final { return drives_.motion_size() + drives_.states(); }
  int coordinates() const final { return mechanism_.nq; }
  int velocities() const final { return mechanism_.nv; }
  bool rhs(double t, const double* y, double* ydot) override;
  bool jacobian(double t, const double* y, double* J) override;
  std::string obstacle(const double* y) override;
  // By default only normalizes quaternions.
  bool project(double t, double* y) override;
  void accepted(double t, const double* y) override;
  ContactMotion* impulses() final { return &contacts_; }
  bool budget_exhausted() const final { return dynamics_.evaluations() >= last_evaluation_; }
  EventModes& modes() final { return modes_; }
  // Those of the equations, not of the integrator.
  RunCounts mode_counts();
  ContactMotion& contacts() { return contacts_; }

  // Limits the number of solutions of the equations of motion from now on; LONG_MAX: unlimited.
  void set_evaluation_budget(long evaluations);
  // Starts or restarts the run at (t, y). cut_q: the angles of the cut joints are unwrapped to the nearest values.
  virtual void start(const std::vector<double>& cut_q, double t, const double* y);
  // Call when inputs have changed discontinuously at (t, y), the present state of the run.
  virtual void inputs_changed(double t, const double* y);
  // Projects y onto the constraints after a discontinuity, by the smallest change in the mass metric; for velocities
  // this is an impact. keeps_limits: no coordinate is pushed beyond its limits. Returns false if that fails.
  bool project_onto_constraints(double t, double* y, bool keeps_limits);
  // vdot (nv) for outputs, at a state accepted at t; `dynamics` is left there, including velocities and accelerations.
  void output_accelerations(double t, const double* y, double* vdot);
  // Whether friction, a limit or a closed contact holds something in the present modes; not those of friction that
  // depends on loads, of which redundant forces are one choice of many.
  bool holds_by_modes() const;
  // Of time steps, or of the forces of the last output_accelerations(), needed if holds_by_modes(), at the same state.
  LawAudit law_audit(double t, const double* y);
  // Saves or restores the data carried from one step to the next. Factors are not included: each step computes them
  // before it uses them.
  virtual void serialize(Archive& archive);

  Drives& drives() { return drives_; }
  RatesOfForces& rates_of_forces() { return rates_of_forces_; }
  // Full turns of the cut joints at the last accepted state.
  RevolutionCounter& revolutions() { return revolutions_; }

 protected:
  // Evaluates f at y with the present inputs. Returns false as rhs() does.
  bool evaluate(double t, const double* y, double* ydot);
  // vdot at the present state of `dynamics`, with the present factors.
  virtual void solve(double t, double* vdot);
  // Adds the rates of element states that name forces to `rates`, by state; `dynamics` is at y. vdot: the accelerations
  // there, of which `dynamics` has the solution; null: they are found.
  void add_rates_of_forces(double t, const double* y, const double* vdot, double* rates);
  // Derivatives of f by differences, where those of jacobians_ do not suffice (differences.h).
  bool differentiate_by_differences(double t, const double* y, const double* ydot, int first_row,
                                    const Eigen::Ref<Eigen::MatrixXd>& out, const DifferenceTaken& taken = {});
  // Rows of vdot of df/dy if J vdot = gamma is satisfied exactly, from jacobians_ and the last factors.
  void acceleration_jacobian(Eigen::Map<Eigen::MatrixXd>& out);
  void count_jacobian() { ++jacobian_count_; }
  virtual ConstraintProjector& projector() { return projector_; }

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  Drives drives_;
  Jacobians jacobians_;

 private:
  // Evaluates f at y with the present inputs by the program that is returned; null: there is none for this state.
  virtual const RecordedMotion* evaluate_by_program(const double* /*y*/, double* /*ydot*/) { return nullptr; }
  // Whether accelerate() factorizes the constraint Jacobian, and whether it leaves its solution in `dynamics`.
  virtual bool factorizes_constraints() const { return true; }
  virtual bool leaves_solution() const { return true; }
  // vdot (nv) at (t, y); `dynamics` is at its position, without velocities. Returns false as rhs() does.
  virtual bool accelerate(double t, const double* y, double* vdot);
  // Rows of vdot of df/dy into `out` (size() x size()), at the state of the last accelerate(); uses jacobians_.
  virtual void differentiate(const double* vdot, Eigen::Map<Eigen::MatrixXd>& out);
  bool jacobian_is_outdated() final;
  void displace(double* q, const double* dv) const final { dynamics_.displace(q, dv); }
  void mode_changed() override {}
  bool bring_inputs(double t, const double* y) final;
  bool loads_move() const final { return drives_.inputs().moving() || mechanism_.driven(); }
  bool has_breaks() const final { return drives_.has_breaks(); }
  double next_break(double t) final { return drives_.next_break(t); }
  void begin_stretch(double from, double to) final { drives_.begin_stretch(from, to); }
  void accelerations_at(double t, const double* y, double* vdot) final;
  void rates_at(double t, const double* y, double* ydot) final;
  void add_other_rates(double t, const double* y, double* ydot, bool has_solution);
  // The effect of closed contacts on the vdot of the last solve().
  void add_contacts(double t, double* vdot) {
    if (contacts_.touches()) contacts_.add_to(vdot, [&](double* again) { solve(t, again); });
  }
  void output_touched_accelerations(double t, const double* y, double* vdot);
  bool jacobian_by_differences(double t, const double* y, Eigen::Map<Eigen::MatrixXd>& out);
  void solve_at(double t, const double* y, double* vdot);
  bool keep_limits(double t, double* y);

  EventLog& events_;
  ConstraintProjector projector_;
  EventModes modes_;
  LimitCorrection limits_;
  ContactMotion contacts_;
  RowDomain row_domain_;
  RevolutionCounter revolutions_;
  SingularityMonitor singularity_monitor_;
  long jacobian_count_ = 0;
  long traced_count_ = 0;
  long last_evaluation_ = LONG_MAX;
  bool takes_differences_ = false;
  bool by_kernels_ = false;     // evaluations leave `dynamics` at their state
  bool reads_outputs_ = false;  // targets are as outputs show them
  std::vector<double> dv_, ydot_;
  RowMatrix by_states_, no_rows_;  // workspace
  RatesOfForces rates_of_forces_;
};

struct FormulationKind {
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<Formulation> (*make)(const FormulationContext& context);
};

// All formulations, the default first (registry.cpp); names as in scene/words.h.
std::span<const FormulationKind> formulation_kinds();

// Throws std::out_of_range for an unknown name.
std::unique_ptr<Formulation> make_formulation(std::string_view name, const FormulationContext& context);

// One function per file.
std::unique_ptr<Formulation> make_projection(const FormulationContext& context);
std::unique_ptr<Formulation> make_baumgarte(const FormulationContext& context);
std::unique_ptr<Formulation> make_udwadia_kalaba(const FormulationContext& context);
std::unique_ptr<Formulation> make_penalty(const FormulationContext& context);
std::unique_ptr<Formulation> make_augmented_lagrangian(const FormulationContext& context);
std::unique_ptr<Formulation> make_independent(const FormulationContext& context);
std::unique_ptr<Formulation> make_index3(const FormulationContext& context);
std::unique_ptr<Formulation> make_stabilized_index2(const FormulationContext& context);

}  // namespace gelenk
