// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/trial_state.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/independent_columns.h"
#include "assembly/loop_closure.h"
#include "element/constraints/cut_joint.h"
#include "kinematics/force_modes.h"
#include "kinematics/loads.h"
#include "kinematics/switching_force.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double rest_tolerance = 1e-9;  // relative to the largest speed

// Whether velocity i of a joint is an angular velocity. Rods rotate at both ends.
template <class Joint>
bool is_turn(const Joint& joint, int i) {
  return std::visit(
      [i](const auto& j) {
        if constexpr (requires { j.v_names; }) return j.v_names[static_cast<std::size_t>(i)].unit == "rad/s";
        return true;
      },
      joint);
}

double largest_speed(const std::vector<double>& v) {
  double out = 0;
  for (const double x : v) out = std::max(out, std::abs(x));
  return out;
}

// Changes of position, velocities and inputs, a column each.
struct Directions {
  MatrixXd dq, dv, du;
};

// Derivatives of outputs of joints in these directions. moved: those of (q, v, vdot).
MatrixXd derivatives_of(const std::vector<int>& outputs, const Outputs& readings, ConstrainedSensitivity& sensitivity,
                        const Directions& along, const MatrixXd& moved) {
  const Index columns = moved.cols();
  MatrixXd out = MatrixXd::Zero(static_cast<Index>(outputs.size()), columns);
  bool all_known = true;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const Outputs::Entry entry = readings.entry(outputs[i]);
    all_known = all_known && entry.index != Outputs::none;
    if (entry.index != Outputs::none) out.row(static_cast<Index>(i)) = entry.sign * moved.row(entry.index);
  }
  for (Index first = 0; first < columns && !all_known; first += dual_directions) {
    const Index width = std::min<Index>(dual_directions, columns - first);
    const auto some = [&](const MatrixXd& of) -> MatrixXd { return of.middleCols(first, width); };
    CarriedState<Dual>& at = sensitivity.directional_derivative(some(along.dq), some(along.dv), some(along.du));
    const ReadingOf<Dual> reading{.dynamics = *at.equations,
                                  .q = at.q.data(),
                                  .v = at.v.data(),
                                  .vdot = at.vdot.data(),
                                  .cut_q = at.equations->cut_coordinates().data()};
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      out.row(static_cast<Index>(i)).segment(first, width) =
          readings.value(outputs[i], reading).derivatives().head(width).matrix().transpose();
    }
  }
  return out;
}

}  // namespace

bool TrialState::is_on_bounds() const {
  for (int i = 0; i < static_cast<int>(contacts.size()); ++i) {
    const int side = contacts[i];
    if (side != 0 && std::abs(depth(i, side).depth) > depth(i, side).tolerance) return false;
  }
  return true;
}

bool TrialState::is_balanced() const {
  const Index states = rates.size();
  VectorXd terms = A.cwiseAbs() * sizes.head(A.cols());
  terms += B.rightCols(states).cwiseAbs() * sizes.tail(states);
  return (a.array().abs() <= equilibrium_rate_tolerance + equilibrium_rounding_tolerance * terms.array()).all();
}

MatrixXd TrialState::by_velocities() const {
  const Index states = rates.size();
  MatrixXd out(A.rows(), coordinate_rates.cols() + states);
  out << A * coordinate_rates, B.rightCols(states);
  return out;
}

MatrixXd TrialState::held_by_velocities() const {
  const Index velocities = coordinate_rates.cols();
  MatrixXd out = MatrixXd::Zero(hold_rows.rows(), velocities + rates.size());
  if (out.rows() > 0) out.leftCols(velocities) = hold_rows.leftCols(A.cols()) * coordinate_rates;
  return out;
}

TrialStates::TrialStates(const EquilibriumProblem& of)
    : of_(of),
      mechanism_(of.mechanism),
      dynamics_(make_dynamics(of.mechanism, of.loads)),
      unknown_(of.request.solve_for),
      sides_(forces().count(), mode_of_state),
      borne_(static_cast<std::size_t>(forces().locks()), false),
      time_(of.time),
      time_squared_(of.time * of.time) {
  dynamics_->set_max_rank(of.mobility.rank);
  dynamics_->set_targets(with_two_derivatives(of.targets).data());
  for (int k = 0; k < of.loads.states(); ++k) unknown_.push_back({.input = of.loads.first_state + k, .size = 1});
  if (of.request.solve_for.empty()) return;
  const std::vector<SwitchingForce> places = switching_forces_of(of.loads);
  for (int i = 0; i < locks(); ++i) {
    const int limit = forces().lock(i).limit;
    if (limit < 0) continue;
    const SwitchingForce& at = places[static_cast<std::size_t>(limit)];
    borne_[static_cast<std::size_t>(i)] = std::ranges::any_of(of.request.held, [&](const auto& held) {
      return held.order == 0 && held.joint == at.joint && held.component == at.component;
    });
  }
}

bool TrialStates::rests(int lock, const TrialState& at) {
  if (!of_.request.steady) return true;
  return std::abs(forces().speed(lock, at.v.data())) * time_ <= rest_tolerance * (1 + largest_speed(at.v) * time_);
}

bool TrialStates::sticks(int lock, const TrialState& at) {
  if (forces().hold_coordinate(lock)) return forces().lock(lock).latch >= 0;
  return friction_holds_ && forces().lock(lock).friction >= 0 && forces().sticking_limit(lock).largest() > 0 &&
         at.slips[lock] == 0 && rests(lock, at);
}

// Enters the modes of the state.
void TrialStates::hold(const TrialState& at) {
  if (locks() == 0) return;
  const std::span<double> inputs = forces().inputs();  // on which latches depend
  std::copy_n(at.u.begin(), std::min(inputs.size(), at.u.size()), inputs.begin());
  for (int i = 0; i < locks(); ++i) {
    const SwitchingForces::Lock& lock = forces().lock(i);
    if (lock.latch >= 0) sides_[static_cast<std::size_t>(lock.latch)] = forces().engagement(i) > 0 ? 1 : 0;
    int side = friction_holds_ ? at.slips[i] : mode_released;
    if (!rests(i, at)) side = forces().speed(i, at.v.data()) > 0 ? 1 : -1;
    if (!(forces().sticking_limit(i).largest() > 0)) side = mode_released;
    for (const int law : forces().lock(i).frictions) sides_[static_cast<std::size_t>(law)] = side;
    if (lock.limit >= 0) sides_[static_cast<std::size_t>(lock.limit)] = at.contacts[i];
  }
  forces().hold(sides_.data());
}

// The targets under the inputs of this state.
std::vector<MotionLaw::Derivatives> TrialStates::targets(const TrialState& at) const {
  std::vector<MotionLaw::Derivatives> out = of_.targets;
  for (std::size_t row = 0; row < out.size(); ++row) {
    const CoordinateRow& of = mechanism_.coordinate_rows[row];
    for (std::size_t order = 0; order < 3 && of.follows_signals; ++order)
      out[row][order] = of_.loads.motion(row, order, at.u.data());
    of.for_inputs([&](int input, int order) {
      const auto i = static_cast<std::size_t>(input);
      out[row][static_cast<std::size_t>(order)] += at.u[i] - of_.u[i];
    });
  }
  return out;
}

// Makes the velocities satisfy the constraint equations, by the smallest change in the mass metric.
void TrialStates::move_consistently(TrialState& at) {
  if (locks() > 0) forces().hold(nullptr);
  dynamics_->set_position(at.q.data());
  dynamics_->factorize();
  VectorXd dv(mechanism_.nv);
  for (int i = 0; i < 2 && mechanism_.rows > 0; ++i) {  // the second time removes the rounding of the first
    dynamics_->set_velocity(at.v.data());
    dynamics_->min_norm_displacement(dynamics_->row_rates().data(), dv.data());
    for (int k = 0; k < mechanism_.nv; ++k) at.v[k] += dv[k];
  }
}

void TrialStates::evaluate(TrialState& at) {
  at.contacts.resize(static_cast<std::size_t>(locks()));
  at.slips.resize(static_cast<std::size_t>(locks()));
  if (!unknown_.empty()) dynamics_->set_targets(with_two_derivatives(targets(at)).data());
  dynamics_->set_cut_reference(at.cut_q.data());
  if (of_.request.steady) move_consistently(at);
  hold(at);
  dynamics_->set_position(at.q.data());
  dynamics_->factorize();
  dynamics_->set_velocity(at.v.data());
  at.vdot.resize(mechanism_.nv);
  dynamics_->solve(at.u.data(), at.vdot.data());
  at.rates.resize(of_.loads.states());
  dynamics_->readings().state_rates(at.u.data(), at.rates.data());
  at.rates *= time_;
  for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) unwrap_angles(c, at.cut_q);
  read(at);
  at.vdot *= time_squared_;
  at.depths.clear();
  for (int i = 0; i < locks(); ++i) at.depths.push_back({forces().depth(i, 1), forces().depth(i, -1)});
}

// Reads the values held and the accelerations requested.
void TrialStates::read(TrialState& at) {
  const EquilibriumRequest& request = of_.request;
  if (!request.accelerations.empty()) dynamics_->set_acceleration(at.vdot.data());
  const Reading reading{dynamics_->readings(), at.q.data(), at.v.data(), at.vdot.data(), at.cut_q.data()};
  at.hold_gaps.resize(static_cast<Index>(request.held.size()));
  for (std::size_t i = 0; i < request.held.size(); ++i) {
    const EquilibriumRequest::Held& held = request.held[i];
    const double gap = held.value - of_.outputs.value(held.output, reading);
    at.hold_gaps[static_cast<Index>(i)] = held.order == 0 ? gap : time_ * gap;
  }
  at.accelerations.resize(static_cast<Index>(request.accelerations.size()));
  for (std::size_t i = 0; i < request.accelerations.size(); ++i) {
    at.accelerations[static_cast<Index>(i)] = time_squared_ * of_.outputs.value(request.accelerations[i], reading);
  }
}

VectorXd TrialStates::accelerations(const TrialState& here, const TrialState& there) const {
  VectorXd out = of_.request.steady ? there.accelerations : VectorXd(there.vdot(here.speeds));
  out.conservativeResize(out.size() + there.rates.size());
  out.tail(there.rates.size()) = there.rates;
  return out;
}

// Unwraps the angles of a cut joint: they are continued from their previous values.
void TrialStates::unwrap_angles(int c, std::vector<double>& cut_q) const {
  const Cut& cut = mechanism_.cuts[static_cast<std::size_t>(c)];
  double found[max_cut_nq];
  std::copy_n(cut_q.data() + cut.iq, cut.nq, found);
  dynamics_->cut_coordinates(c, found);
  for (int i = 0; i < cut.nq; ++i) {
    double& q = cut_q[cut.iq + i];
    q = cut.is_angle[static_cast<std::size_t>(i)] ? q + std::remainder(found[i] - q, 2 * std::numbers::pi) : found[i];
  }
}

void TrialStates::differentiate(TrialState& at) {
  const int nv = mechanism_.nv;
  const EquilibriumRequest& request = of_.request;
  const std::vector<bool> any(static_cast<std::size_t>(nv), false);
  const Independent by = independent_at(mechanism_, *dynamics_, of_.mobility, any, any);
  ConstrainedSensitivity sensitivity(mechanism_, of_.loads, of_.mobility, by, static_cast<int>(of_.u.size()));
  if (locks() > 0) sensitivity.hold(sides_);
  sensitivity.set_point(at.q.data(), at.v.data(), at.u.data(), at.cut_q.data(), targets(at));
  const auto n = static_cast<Index>(by.coordinates.size());
  const auto m = static_cast<Index>(by.speeds.size());
  const auto inputs = static_cast<Index>(unknown_.size());
  Directions along{MatrixXd::Zero(mechanism_.nq, n + m + inputs), MatrixXd::Zero(nv, n + m + inputs),
                   MatrixXd::Zero(static_cast<Index>(of_.u.size()), n + m + inputs)};
  for (Index k = 0; k < n; ++k) {
    const VectorXd z = VectorXd::Unit(nv, by.coordinates[static_cast<std::size_t>(k)]);
    dynamics_->qdot_from_v(at.q.data(), z.data(), along.dq.col(k).data());
  }
  const double speed = request.steady ? 1 / time_ : 1;  // of a unit of the unknowns
  for (Index k = 0; k < m; ++k) along.dv(by.speeds[static_cast<std::size_t>(k)], n + k) = speed;
  for (Index k = 0; k < inputs; ++k) {
    const EquilibriumRequest::UnknownInput& unknown = unknown_[static_cast<std::size_t>(k)];
    along.du(unknown.input, n + m + k) = unknown.size;
  }
  const MovedState all_moved = sensitivity.state_derivative(along.dq, along.dv, along.du);
  const MatrixXd& moved = all_moved.y;
  at.speeds = by.speeds;
  at.a = accelerations(at, at);
  at.velocity_jacobian = moved.block(mechanism_.nq, n, nv, m);
  at.coordinate_rates = at.velocity_jacobian(by.coordinates, Eigen::all);
  const Index x = request.steady ? n + m : n;
  const auto of_unknowns = [&](const MatrixXd& from) {
    MatrixXd out(from.rows(), x + inputs);
    out << from.leftCols(x), from.rightCols(inputs);
    return out;
  };
  const auto outputs_moved = [&](const std::vector<int>& outputs) {
    return of_unknowns(derivatives_of(outputs, of_.outputs, sensitivity, along, moved));
  };
  MatrixXd A =
      time_squared_ * (request.steady ? outputs_moved(request.accelerations)
                                      : of_unknowns(moved.middleRows(mechanism_.nq + nv, nv)(by.speeds, Eigen::all)));
  if (const Index states = at.rates.size(); states > 0) {
    A.conservativeResize(A.rows() + states, Eigen::NoChange);
    A.bottomRows(states) = time_ * of_unknowns(all_moved.state_rates);
  }
  at.A = A.leftCols(x);
  at.B = A.rightCols(inputs);
  find_sizes(at);
  at.displacement_jacobian = of_unknowns(displacements(mechanism_, at.q.data(), moved.topRows(mechanism_.nq)));
  if (request.steady) at.velocity_change = of_unknowns(moved.middleRows(mechanism_.nq, nv));
  std::vector<int> outputs;
  for (const EquilibriumRequest::Held& held : request.held) outputs.push_back(held.output);
  at.hold_rows = outputs_moved(outputs);
  for (std::size_t i = 0; i < request.held.size(); ++i) {
    if (request.held[i].order == 1) at.hold_rows.row(static_cast<Index>(i)) *= time_;
  }
  find_contact_rows(at);
}

// The sizes of the unknowns: coordinates, velocities where the motion is steady, inputs.
void TrialStates::find_sizes(TrialState& at) const {
  const Index coordinates = at.A.cols();
  const auto speeds = static_cast<Index>(of_.request.steady ? at.speeds.size() : 0);
  at.sizes.setOnes(coordinates + at.B.cols());
  for (Index k = 0; k < speeds; ++k) {
    const int speed = at.speeds[static_cast<std::size_t>(k)];
    at.sizes[coordinates - speeds + k] += time_ * std::abs(at.v[speed]);
  }
  for (Index k = 0; k < at.B.cols(); ++k) {
    const EquilibriumRequest::UnknownInput& unknown = unknown_[static_cast<std::size_t>(k)];
    at.sizes[coordinates + k] += std::abs(at.u[static_cast<std::size_t>(unknown.input)] / unknown.size);
  }
}

void TrialStates::find_contact_rows(TrialState& at) {
  std::vector<int> held;
  for (int i = 0; i < locks(); ++i) {
    if (at.contacts[i] != 0 || sticks(i, at)) held.push_back(i);
  }
  at.contact_rows.resize(static_cast<Index>(held.size()), at.sizes.size());
  at.contact_gaps.setZero(at.contact_rows.rows());
  for (Index row = 0; row < at.contact_gaps.size(); ++row) {
    const int lock = held[static_cast<std::size_t>(row)];
    const int side = at.contacts[lock];
    at.contact_rows.row(row) = limit_row(at, lock);
    if (side != 0) at.contact_gaps[row] = -side * at.depth(lock, side).depth;
  }
}

Eigen::RowVectorXd TrialStates::limit_row(const TrialState& at, int lock) {
  Eigen::RowVectorXd out(at.displacement_jacobian.cols());
  for (Index k = 0; k < out.size(); ++k) out[k] = forces().speed(lock, at.displacement_jacobian.col(k).data());
  return out;
}

std::optional<TrialState> TrialStates::closed_neighbor(const TrialState& here, const VectorXd& z, const VectorXd& dv,
                                                       const VectorXd& du) {
  TrialState there{.q = here.q, .cut_q = here.cut_q, .v = here.v, .u = here.u};
  there.contacts = here.contacts;
  there.slips = here.slips;
  for (Index k = 0; k < dv.size(); ++k) there.v[k] += dv[k];
  for (Index k = 0; k < du.size(); ++k) {
    const EquilibriumRequest::UnknownInput& unknown = unknown_[static_cast<std::size_t>(k)];
    there.u[static_cast<std::size_t>(unknown.input)] += unknown.size * du[k];
  }
  if (du.size() > 0) dynamics_->set_targets(with_two_derivatives(targets(there)).data());
  dynamics_->displace(there.q.data(), z.data());
  if (!close_rows(mechanism_, *dynamics_, there.q)) return {};
  try {
    evaluate(there);
  } catch (const SingularMass&) {
    return {};
  }
  return there;
}

bool TrialStates::touch(TrialState& at) {
  bool any = false;
  for (int i = 0; i < locks(); ++i) {
    for (const int side : {1, -1}) {
      const SwitchingForces::Depth& depth = at.depth(i, side);
      if (at.contacts[i] != 0 || depth.depth < -depth.tolerance || !may_touch(i)) continue;
      if (forces().lock(i).one_way && !rests(i, at)) continue;
      at.contacts[i] = side;
      any = true;
    }
  }
  if (any) evaluate(at);
  return any;
}

VectorXd TrialStates::joint_rotations(const TrialState& here, const VectorXd& z) {
  std::vector<double> out;
  const auto add = [&](const auto& joint, int nv, const double* v) {
    for (int i = 0; i < nv; ++i) {
      if (is_turn(joint, i)) out.push_back(v[i]);
    }
  };
  for (const Link& link : mechanism_.links) add(*link.joint, link.nv, z.data() + link.iv);
  dynamics_->set_position(here.q.data());
  dynamics_->set_velocity(z.data());
  double v[max_cut_nv];
  for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) {
    dynamics_->readings().cut_speeds(c, v);
    add(*mechanism_.cuts[static_cast<std::size_t>(c)].joint, mechanism_.cuts[static_cast<std::size_t>(c)].nv, v);
  }
  return Eigen::Map<const VectorXd>(out.data(), static_cast<Index>(out.size()));
}

}  // namespace gelenk
