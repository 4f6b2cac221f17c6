// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/formulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "event_driven/contact_modes.h"
#include "event_driven/mode_changes.h"
#include "formulation/recorded_motion.h"
#include "kinematics/loads.h"

namespace gelenk {
namespace {

// Sets a flag during its lifetime, also where that is ended by an exception.
class Raised {
 public:
  explicit Raised(bool& flag) : flag_(flag) { flag_ = true; }
  ~Raised() { flag_ = false; }
  Raised(const Raised&) = delete;
  Raised& operator=(const Raised&) = delete;

 private:
  bool& flag_;
};

bool locates_contacts(const FormulationContext& context) {
  return context.options.locates_contacts && context.mechanism.touches();
}

// Branch-free: zero times NaN or infinity is NaN.
bool all_finite(const double* x, int n) {
  double zero = 0;
  for (int i = 0; i < n; ++i) zero += 0 * x[i];
  return zero == 0;
}

}  // namespace

Formulation::Formulation(const FormulationContext& context)
    : mechanism_(context.mechanism),
      dynamics_(context.dynamics),
      drives_(mechanism_, dynamics_, context.inputs, context.loads),
      events_(context.events),
      projector_(mechanism_, dynamics_),
      modes_({mechanism_, dynamics_, context.loads, *this, events_, locates_contacts(context)}),
      limits_(dynamics_.switching_forces()),
      contacts_({mechanism_, dynamics_, context.loads, drives_, modes_.locks(), context.events}, modes_,
                locates_contacts(context)),
      row_domain_(mechanism_, dynamics_),
      revolutions_(mechanism_, dynamics_),
      dv_(mechanism_.nv),
      rates_of_forces_(dynamics_, drives_, modes_, contacts_, mechanism_.nv) {}

RunCounts Formulation::mode_counts() {
  RunCounts out{modes_.locks().counts()};
  out.jacobians = jacobian_count_;
  out.traced = traced_count_;
  out.singular_positions = singularity_monitor_.count();
  contacts_.count(out);
  return out;
}

void Formulation::inputs_changed(double /*t*/, const double* /*y*/) {
  if (contacts_.are_used()) return;
  modes_.changes().inputs_jumped();
}

bool Formulation::rhs(double t, const double* y, double* ydot) {
  if (!all_finite(y, size())) return false;
  drives_.go_to(t, y);
  const bool by_program = !takes_differences_ && !by_kernels_ && !singularity_monitor_.is_followed();
  const RecordedMotion* const program = by_program ? evaluate_by_program(y, ydot) : nullptr;
  // Kernels know what becomes of a quotient of zeros, such as the direction of a spring without length.
  if (program == nullptr || !all_finite(ydot, size())) return evaluate(t, y, ydot);
  modes_.watch_motion(t, y);
  singularity_monitor_.expect(program->usual_pivot_ratio());
  dynamics_.count_evaluations(1);
  ++traced_count_;
  return true;
}

bool Formulation::evaluate(double t, const double* y, double* ydot) {
  const double* v = y + mechanism_.nq;
  double* vdot = ydot + mechanism_.nq;
  dynamics_.set_position(y);
  if (!row_domain_.is_defined()) return false;
  // What is evaluated for differences is beside the motion.
  if (!takes_differences_) modes_.watch(t, v);
  if (!accelerate(t, y, vdot)) return false;
  if (!modes_.locks().empty() && dynamics_.switching_forces().loads().undetermined() >= 0) return false;
  if (!takes_differences_) modes_.watch_forces(t);
  if (mechanism_.rows > 0 && factorizes_constraints()) singularity_monitor_.observe(t, dynamics_.pivot_ratio());
  add_other_rates(t, y, ydot, leaves_solution());
  return all_finite(ydot, size());
}

bool Formulation::project_onto_constraints(double t, double* y, bool keeps_limits) {
  drives_.go_to(t, y);
  dynamics_.normalize(y);
  dynamics_.set_position(y);
  if (keeps_limits) limits_.begin(y + mechanism_.nq);
  const LockModes::State modes = modes_.locks().state();
  if (!modes_.locks().empty()) modes_.locks().release(true);  // friction exerts no impulses, and latches do
  projector().refactorize();  // an impact is no small correction, so former factors are not accurate enough
  // The smallest change in the mass metric, whichever method corrects rounding errors afterwards.
  dynamics_.min_norm_displacement(dynamics_.Phi().data(), dv_.data());
  dynamics_.displace(y, dv_.data());
  if (!projector().close_position(y) || (keeps_limits && !keep_limits(t, y))) return false;
  projector().refactorize();
  double* v = y + mechanism_.nq;
  dynamics_.set_velocity(v);
  dynamics_.min_norm_displacement(dynamics_.row_rates().data(), dv_.data());
  for (int k = 0; k < mechanism_.nv; ++k) v[k] += dv_[k];
  if (!projector().close_velocity(v)) return false;
  if (keeps_limits && !limits_.empty()) {
    accelerations_at(t, y, dv_.data());
    limits_.correct_velocity({v, dv_.size()});
    projector().refactorize();
    dynamics_.set_velocity(v);
    if (!projector().close_velocity(v)) return false;
  }
  if (contacts_.are_used()) return true;
  if (!keeps_limits) {
    modes_.start(t, y);
  } else {
    modes_.changes().restart(t, y, modes, estimated_over(drives_.inputs()));
  }
  return true;
}

// Where constraint equations leave it no choice, a coordinate remains beyond its limit.
bool Formulation::keep_limits(double t, double* y) {
  constexpr int most_corrections = 20;  // Newton's method; what one limit pushes may meet another one
  for (int i = 0; i < most_corrections && !limits_.empty(); ++i) {
    accelerations_at(t, y, dv_.data());
    if (!limits_.correct_position(dv_)) break;
    dynamics_.displace(y, dv_.data());
    dynamics_.set_position(y);
    projector().refactorize();
    if (!projector().close_position(y)) return false;
  }
  return true;
}

void Formulation::set_evaluation_budget(long evaluations) {
  const long now = dynamics_.evaluations();
  last_evaluation_ = evaluations < LONG_MAX - now ? now + evaluations : LONG_MAX;
}

bool Formulation::accelerate(double t, const double* y, double* vdot) {
  projector().refactorize();
  dynamics_.set_velocity(y + mechanism_.nq);
  solve(t, vdot);
  add_contacts(t, vdot);
  return true;
}

void Formulation::solve(double /*t*/, double* vdot) { dynamics_.solve(drives_.u().data(), vdot); }

bool Formulation::jacobian(double t, const double* y, double* J) {
  const int nq = mechanism_.nq;
  ydot_.resize(size());
  count_jacobian();
  const Raised leaves_dynamics_there(by_kernels_);
  if (!rhs(t, y, ydot_.data())) return false;
  Eigen::Map<Eigen::MatrixXd> out(J, size(), size());
  if (contacts_.located() != nullptr && !contacts_.located()->equations().closed().empty())
    return jacobian_by_differences(t, y, out);
  differentiate(ydot_.data() + nq, out);
  out.topLeftCorner(nq, nq) = jacobians_.qdot_q;
  out.block(0, nq, nq, mechanism_.nv) = jacobians_.qdot_v;
  out.topRightCorner(nq, drives_.states()).setZero();
  jacobians_.put_rates(drives_.first_state(), out.bottomRows(drives_.states()));
  // Motions that follow states make all accelerations depend on these.
  const int first_row = drives_.targets_follow_states() ? 0 : drives_.motion_size();
  if ((rates_of_forces_.any() || first_row == 0) &&
      !differentiate_by_differences(t, y, nullptr, first_row, out.bottomRows(size() - first_row)))
    return false;
  return out.allFinite();
}

bool Formulation::jacobian_is_outdated() {
  return contacts_.located() != nullptr && contacts_.located()->equations().slides_otherwise();
}

// The present state is y. Newton's methods, which use it, need no exact derivatives, but those of slow sliding, which
// are stiff.
bool Formulation::jacobian_by_differences(double t, const double* y, Eigen::Map<Eigen::MatrixXd>& out) {
  ContactEquations& contact_equations = contacts_.located()->equations();
  contact_equations.begin_differences(size(), ydot_.data() + mechanism_.nq, modes_.since_step_began(t));
  const bool is_finite = differentiate_by_differences(t, y, ydot_.data(), 0, out, [&](Eigen::Index k, double step) {
    contact_equations.record_difference(static_cast<int>(k), step);
  });
  contact_equations.end_differences(out.middleRows(mechanism_.nq, mechanism_.nv));
  return is_finite && out.allFinite();
}

void Formulation::differentiate(const double* vdot, Eigen::Map<Eigen::MatrixXd>& out) {
  dynamics_.differentiate(drives_.u().data(), drives_.count(), vdot, jacobians_);
  acceleration_jacobian(out);
}

// With r = 0 and c = 0 along the solution, [M J^T; J 0] d(vdot, lambda) = -(dr, dc). Overwrites jacobians_.r.
void Formulation::acceleration_jacobian(Eigen::Map<Eigen::MatrixXd>& out) {
  dynamics_.solve_linear_columns(jacobians_.r.data(), jacobians_.c.data(), drives_.motion_size());
  out.block(mechanism_.nq, 0, mechanism_.nv, drives_.motion_size()) = -jacobians_.r;
  if (drives_.states() == 0) return;
  by_states_ = jacobians_.r_u.middleCols(drives_.first_state(), drives_.states());
  no_rows_.setZero(mechanism_.rows, drives_.states());
  dynamics_.solve_linear_columns(by_states_.data(), no_rows_.data(), drives_.states());
  out.block(mechanism_.nq, drives_.motion_size(), mechanism_.nv, drives_.states()) = -by_states_;
}

bool Formulation::project(double, double* y) {
  dynamics_.normalize(y);
  return true;
}

void Formulation::accepted(double t, const double* y) {
  if (!mechanism_.cuts.empty()) revolutions_.count(t, y);
  if (mechanism_.rows == 0) return;
  const long before = singularity_monitor_.count();
  singularity_monitor_.accepted(t);
  if (singularity_monitor_.count() > before) events_.add({singularity_monitor_.last(), Event::singular_position});
}

void Formulation::accelerations_at(double t, const double* y, double* vdot) {
  reads_outputs_ ? drives_.go_to_outputs(t, y) : drives_.go_to(t, y);
  solve_at(t, y, vdot);
}

void Formulation::rates_at(double t, const double* y, double* ydot) {
  accelerations_at(t, y, ydot + mechanism_.nq);
  add_other_rates(t, y, ydot, true);
}

// Those of coordinates and of element states.
void Formulation::add_other_rates(double t, const double* y, double* ydot, bool has_solution) {
  dynamics_.qdot_from_v(y, y + mechanism_.nq, ydot);
  if (drives_.states() == 0) return;
  double* const rates = ydot + drives_.motion_size();
  dynamics_.readings().state_rates(drives_.u().data(), rates);
  add_rates_of_forces(t, y, has_solution ? ydot + mechanism_.nq : nullptr, rates);
}

void Formulation::add_rates_of_forces(double t, const double* y, const double* vdot, double* rates) {
  if (!rates_of_forces_.any()) return;
  if (vdot == nullptr) {
    dynamics_.factorize();
    projector().factors_changed();
    dynamics_.solve(drives_.u().data(), dv_.data());
    vdot = dv_.data();
  }
  rates_of_forces_.add(y, vdot, [&](double* again) { solve(t, again); }, rates);
}

bool Formulation::differentiate_by_differences(double t, const double* y, const double* ydot, int first_row,
                                               const Eigen::Ref<Eigen::MatrixXd>& out, const DifferenceTaken& taken) {
  const Raised beside(takes_differences_);
  return gelenk::differentiate([&](const double* at, double* rates) { return Formulation::rhs(t, at, rates); }, y, ydot,
                               first_row, out, taken);
}

bool Formulation::bring_inputs(double t, const double* y) {
  drives_.go_to(t, y);
  return drives_.bring_signals(y);
}

// Does not use the factors of the projector: reading outputs must not change the run.
void Formulation::solve_at(double t, const double* y, double* vdot) {
  dynamics_.set_position(y);
  dynamics_.factorize();
  projector().factors_changed();
  dynamics_.set_velocity(y + mechanism_.nq);
  solve(t, vdot);
  add_contacts(t, vdot);
}

void Formulation::output_accelerations(double t, const double* y, double* vdot) {
  if (contacts_.are_used()) {
    drives_.go_to_outputs(t, y);
    const ImpulseSteps::AppliedForces forces(contacts_.steps(), y);
    solve_at(t, y, vdot);
    return modes_.outputs().record(contacts_.steps().lock_forces());
  }
  if (contacts_.located() != nullptr) return output_touched_accelerations(t, y, vdot);
  const ModePreview preview(modes_, t, y);
  drives_.go_to_outputs(t, y);
  solve_at(t, y, vdot);
  modes_.outputs().record();
  if (!dynamics_.switching_forces().is_redundant()) return;
  solve_at(t, y, vdot);
  modes_.outputs().apply();
}

// Contact forces are applied as loads, so that reactions show them.
void Formulation::output_touched_accelerations(double t, const double* y, double* vdot) {
  ContactOutputs& touched = contacts_.located()->outputs();
  const ModePreview preview(modes_, t, y);
  drives_.go_to_outputs(t, y);
  solve_at(t, y, vdot);
  {
    const Raised reading(reads_outputs_);
    modes_.changes().record_outputs(t, y);
  }
  dynamics_.switching_forces().contact_rows().apply_forces(touched.wrenches(), nullptr);
  solve_at(t, y, vdot);
  modes_.outputs().record();
  if (dynamics_.switching_forces().is_redundant()) {
    solve_at(t, y, vdot);
    modes_.outputs().apply();
  }
  dynamics_.switching_forces().contact_rows().apply_forces(nullptr, nullptr);
}

bool Formulation::holds_by_modes() const {
  if (contacts_.are_used() || !dynamics_.switching_forces().loads().empty()) return false;
  const bool touches = contacts_.located() != nullptr && !contacts_.located()->equations().closed().empty();
  return touches || modes_.locks().any_at_rest();
}

LawAudit Formulation::law_audit(double t, const double* y) {
  LawAudit out = contacts_.law_audit(t, {y + mechanism_.nq, dv_.size()});
  if (!holds_by_modes()) return out;
  if (contacts_.located() != nullptr) out = contacts_.located()->outputs().audit();
  if (!modes_.locks().any_at_rest()) return out;
  dynamics_.set_position(y);
  out.add(audit_locks(dynamics_.switching_forces(), modes_.outputs().forces(), y + mechanism_.nq, mechanism_.nv));
  return out;
}

void Formulation::start(const std::vector<double>& cut_q, double t, const double* y) {
  drives_.go_to(t, y);
  revolutions_.count_from(cut_q, t, y);
  singularity_monitor_.restart(t);
  contacts_.start();
  if (contacts_.are_used()) {
    modes_.release();
  } else {
    modes_.start(t, y);
  }
}

void Formulation::serialize(Archive& archive) {
  revolutions_.serialize(archive);
  if (mechanism_.rows > 0) singularity_monitor_.serialize(archive);
  events_.serialize(archive);
  modes_.serialize(archive);
  contacts_.serialize(archive);
  archive.serialize(jacobian_count_, traced_count_);
  if (!archive.reading()) return;
  takes_differences_ = false;
  projector().discard_factors();
}

}  // namespace gelenk
