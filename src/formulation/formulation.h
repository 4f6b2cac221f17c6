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
#include "event/passages.h"
#include "formulation/equations.h"
#include "formulation/inputs.h"
#include "formulation/targets.h"
#include "formulation/turns.h"
#include "math/record.h"

namespace gelenk {

struct FormulationOptions {
  double step = 1e-3;          // s: of fixed-step methods or between outputs
  double baumgarte_alpha = 0;  // 1/s; 0: chosen from the step
  double baumgarte_beta = 0;   // 1/s; likewise
  int corrections = 0;         // of projection after each step; 0: until closed
  double soundest = 0;         // largest pivot ratio known of the rows (Structure); 0: none is
};

class Formulation : public Equations {
 public:
  // u: the inputs, taken at every evaluation to its time.
  Formulation(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u);

  int size() const final { return nq_ + nv_; }
  int coordinates() const final { return nq_; }
  bool rhs(double t, const double* y, double* ydot) final;
  bool jacobian(double t, const double* y, double* J) final;
  std::string obstacle(const double* y) override;
  void displace(double* q, const double* dv) const final { dynamics_.displace(q, dv); }
  // Unless a formulation says otherwise: quaternions are made unit again, no more.
  bool project(double t, double* y) override;
  void accepted(double t, const double* y) override;
  // Two for each stop, at its upper and its lower bound: positive where it pushes.
  int indicators() const final { return 2 * static_cast<int>(sides_.size()); }
  void indicator_values(const double* y, double* g, double* gdot) final;
  void hold_mode(double t, const bool* positive) final;
  double left_mode() const final { return left_mode_; }
  void found_event(double t, int indicator, bool positive) final;
  std::string too_many_events() const final;

  // From now on: calls of solve and assemble until spent(); LONG_MAX: without end.
  void allow(long evaluations);
  bool spent() const final { return dynamics_.evaluations() >= last_evaluation_; }

  // Takes the inputs, and the rows that change with time, to t.
  void go_to(double t);
  // The same where the run stands, for outputs: of the motion that has led there (Inputs::rate).
  void go_to_outputs(double t);
  // What a coordinate row is to be at t, where the run stands (Targets::derivatives).
  MotionLaw::Derivatives target(int row, double t) const { return targets_.derivatives(row, t, inputs_); }

  // vdot for outputs, at a state accepted at t; dynamics_ is left there, velocities and accelerations included.
  void output_accelerations(double t, const double* y, double* vdot);

  // Takes y onto the constraints where these have jumped, by the least change in the mass metric: of speeds, an impact.
  // False: not reached.
  bool meet(double t, double* y);
  // s and ds/dt of each coordinate row at t.
  void drives_at(double t, std::vector<double>& out);

  // What it carries from one step to the next. The factors are not among it: they are made anew afterwards, in the run
  // that wrote the record as in the one that reads it.
  virtual void exchange(Record& record);

  long jacobians() const { return jacobians_; }  // made since construction
  EventLog& events() { return events_; }
  const EventLog& events() const { return events_; }
  // Singular positions since the start.
  const Passages& passages() const { return passages_; }

  // Of the cut joints, at the state accepted last.
  const std::vector<double>& cut_coordinates() const { return turns_.coordinates(); }
  const std::vector<double>& cut_speeds() const { return turns_.speeds(); }
  // The run begins at (t, y), or anew. cut_q: the cut joints' angles are those nearest to these.
  virtual void start(const std::vector<double>& cut_q, double t, const double* y);
  // The inputs have jumped at (t, y), where the run stands.
  virtual void inputs_changed(double /*t*/, const double* /*y*/) {}

 protected:
  // The state at which rhs(y) evaluates; size() numbers. nullptr: none found near y.
  virtual const double* state_for(const double* y) { return y; }
  // Whether accelerate() leaves factors of the rows, which tell singular positions.
  virtual bool factorises_rows() const { return true; }
  // vdot at (t, y); dynamics_ is at its position, without velocities. False: as rhs.
  virtual bool accelerate(double t, const double* y, double* vdot);
  // Rows nq.. of df/dy into `out` (size() x size()), from slopes_ at the state of the last accelerate(); vdot: found
  // there.
  virtual void differentiate(const double* vdot, Eigen::Map<Eigen::MatrixXd>& out);
  // out (nq..) <- the slopes of vdot when J vdot = gamma is solved for exactly, from slopes_, with the last factors.
  void solve_slopes(Eigen::Map<Eigen::MatrixXd>& out);
  // From the slopes of f at state_for(y) to those at y.
  virtual void chain(Eigen::Map<Eigen::MatrixXd>&) {}

  // Newton's method onto Phi = 0, and onto J v = b; leaves dynamics_ there. False: not reached.
  bool close_position(double* q);
  bool close_velocity(double* v);
  // How many times the rounding may be left where it ends the progress earlier.
  virtual double slack() const { return 1e3; }
  // Its factors at the position of dynamics_, and its step; the least in the mass metric unless overridden.
  virtual void refactor() { dynamics_.factorise(); }
  // Of factors just made: whether rows are weak there.
  virtual void judge() {}
  virtual void correction(const double* residual, double* dv) { dynamics_.correct(residual, dv); }

  void count_jacobian() { ++jacobians_; }
  // refactor(), remembered. What else is solved with afterwards keeps to these factors.
  void renew_factors();
  // vdot to be followed where rows are weak (dynamics.h), or null.
  virtual const double* expected(double) { return nullptr; }
  // Whether the factors at hand hold no direction of the rows that are weak.
  virtual bool rank_is_lost() const { return dynamics_.pivot_ratio() == 0; }
  // vdot where dynamics_ stands, by the factors at hand.
  void solve(double t, double* vdot);

  Eigen::Map<const RowMatrix> J() const { return dynamics_.J(); }
  int rows() const { return mechanism_.rows; }
  int inputs() const { return static_cast<int>(u_.size()); }

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  Inputs& inputs_;
  const std::vector<double>& u_;  // at the time that was evaluated last
  int nq_, nv_;
  bool factors_ = false;  // refactor() has been called
  Slopes slopes_;

 private:
  double rounding(const double* q) const;
  void watch(double t, const double* y);
  bool rows_are_defined() const;
  std::string dead_centre();

  Targets targets_;
  TurnCounter turns_;
  Passages passages_;
  EventLog events_;
  long jacobians_ = 0;
  long last_evaluation_ = LONG_MAX;
  std::vector<int> delicate_;         // cuts whose rows are not defined everywhere
  std::vector<int> sides_, present_;  // branches that are held, and those of a state
  bool held_ = false;                 // they are
  double held_from_ = 0;              // s
  double left_mode_ = INFINITY;       // s
  double length_;                     // m: rounding of a closed loop grows with it
  std::vector<double> dv_, ydot_;
};

struct FormulationKind {
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<Formulation> (*make)(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u,
                                       const FormulationOptions& options);
};

// All formulations that can be named in a scene (registry.cpp), the default first; names as in scene/words.h.
std::span<const FormulationKind> formulation_kinds();

// Throws std::out_of_range for an unknown name.
std::unique_ptr<Formulation> make_formulation(std::string_view name, const Mechanism& mechanism, Dynamics& dynamics,
                                              Inputs& u, const FormulationOptions& options);

// One per file.
std::unique_ptr<Formulation> make_projection(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u,
                                             const FormulationOptions& options);
std::unique_ptr<Formulation> make_baumgarte(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u,
                                            const FormulationOptions& options);
std::unique_ptr<Formulation> make_udwadia_kalaba(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u,
                                                 const FormulationOptions& options);
std::unique_ptr<Formulation> make_penalty(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u,
                                          const FormulationOptions& options);
std::unique_ptr<Formulation> make_augmented_lagrangian(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u,
                                                       const FormulationOptions& options);
std::unique_ptr<Formulation> make_independent(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u,
                                              const FormulationOptions& options);
std::unique_ptr<Formulation> make_index3(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u,
                                         const FormulationOptions& options);
std::unique_ptr<Formulation> make_stabilized_index2(const Mechanism& mechanism, Dynamics& dynamics, Inputs& u,
                                                    const FormulationOptions& options);

}  // namespace gelenk
