// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "analysis/trial_state.h"
#include "decomposition/dense.h"
#include "decomposition/singular_values.h"
#include "dynamics/distributed_forces.h"
#include "linear/box_complementarity.h"
#include "linear/descent.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int max_steps = 200;
constexpr int max_unproductive_steps = 5;       // consecutive steps without the required contraction
constexpr double required_contraction = 0.9;    // of the length of Newton steps
constexpr int max_descent_steps = 100;          // pseudo-transient steps, used where Newton steps fail
constexpr double min_step_fraction = 1.0 / 64;  // of a Newton step, before it is rejected
// Singular values of A up to this (absolute, or relative to the largest) are rounding: directions without stiffness.
constexpr double zero_stiffness_tolerance = 1e-10;
// rad, or relative to the mechanism's length, a velocity or an input; the error is then of the order of its square.
constexpr double converged_step = 1e-9;
constexpr double max_rotation = 0.3;  // rad: limit on joint rotations per step, so that loops stay on their branch
constexpr double unlimited = std::numeric_limits<double>::infinity();
constexpr int max_shifts = 8;  // shorter and shorter steps of the descent
constexpr double shift_growth = 10;
constexpr double least_room = 1e-6;    // fraction of such a step up to a bound
constexpr double reached_share = 0.1;  // of the way to a bound that may be left where contact begins
constexpr int max_closures = 5;        // steps onto bounds that bring no contact to its bound
constexpr int max_releases = 50;       // of contacts that would pull, before the search gives up

// Orthonormal columns: the changes with which these rows vanish.
MatrixXd free_directions(const SingularValues& rows) {
  return rows.V.rightCols(rows.V.cols() - rows.rank(zero_stiffness_tolerance));
}

template <class Upper, class Lower>
MatrixXd stacked(const Upper& upper, const Lower& lower) {
  MatrixXd out(upper.rows() + lower.rows(), upper.cols());
  out << upper, lower;
  return out;
}

// Minimum-norm least-squares solution of A dx = -a.
VectorXd min_norm_step(const MatrixXd& A, const VectorXd& a) {
  const SingularValues svd(A);
  const double largest_stiffness = largest(svd.sigma);
  if (!(largest_stiffness > zero_stiffness_tolerance)) return VectorXd::Zero(A.cols());
  return svd.solve(-a, svd.rank(zero_stiffness_tolerance * std::max(1.0, 1 / largest_stiffness)));
}

// A change of the state: displacement, velocities, unknown inputs.
struct Step {
  VectorXd z, dv, du;
  Step operator*(double fraction) const { return {fraction * z, fraction * dv, fraction * du}; }
};

Step step_of(const TrialState& at, const VectorXd& unknowns) {
  return {at.displacement_jacobian * unknowns,
          at.velocity_change.size() > 0 ? VectorXd(at.velocity_change * unknowns) : VectorXd(),
          unknowns.tail(at.B.cols())};
}

double length_of(const TrialState& at, const VectorXd& unknowns) { return largest(unknowns.cwiseQuotient(at.sizes)); }

class EquilibriumSearch {
 public:
  explicit EquilibriumSearch(const EquilibriumProblem& of) : of_(of), steady_(of.request.steady), states_(of) {}

  Equilibrium run(const std::vector<double>& q, const std::vector<double>& cut_q, const std::vector<double>& v) {
    TrialState here{.q = q, .cut_q = cut_q, .v = v, .u = of_.u};
    if (!steady_) std::ranges::fill(here.v, 0);
    states_.evaluate(here);
    states_.touch(here);
    try {
      states_.differentiate(here);
    } catch (const NotDifferentiablePoint&) {
      const bool asked = steady_ || !of_.request.held.empty();
      if (asked || std::max(largest(here.vdot), largest(here.rates)) > equilibrium_rate_tolerance ||
          !here.is_on_bounds() || lets_go(here))
        throw;
      return result(here, Equilibrium::End::found);
    }
    if (!approach(here)) return result(here, Equilibrium::End::unreachable);
    if (of_.request.only_approach) return result(here, Equilibrium::End::found);
    const bool converged = iterate(here);
    if (!of_.request.solve_for.empty()) minimize_inputs(here);
    if (!here.is_on_bounds()) {  // contacts that are none
      std::ranges::fill(here.contacts, 0);
      states_.evaluate(here);
    } else if (here.is_balanced() && holds(here)) {
      return result(here, Equilibrium::End::found);
    }
    return result(here, converged ? Equilibrium::End::none_near : Equilibrium::End::not_converged);
  }

 private:
  Equilibrium result(const TrialState& at, Equilibrium::End end) const {
    const double square = of_.time * of_.time;
    return {end, steps_, at.q, at.cut_q, at.v, at.u, at.vdot / square, at.accelerations / square, at.rates / of_.time};
  }

  static bool holds(const TrialState& at) { return largest(at.hold_gaps) <= converged_step; }

  // Returns whether the last step had length zero and nothing leads on.
  bool iterate(TrialState& here) {
    bool converged = here.a.size() == 0;
    double least = INFINITY;     // shortest Newton step since the last descent
    int unproductive_steps = 0;  // steps since then without contraction
    for (int i = 0; i < max_steps && !converged; ++i) {
      const VectorXd dx = newton(here, here.a);
      const double length = length_of(here, dx);
      if (length < converged_step) {
        converged = ends(here, dx);
        least = INFINITY;
        continue;
      }
      // Damped steps may oscillate between two poses if A is singular between them.
      const bool nearer = length < required_contraction * least;
      unproductive_steps = nearer ? 0 : unproductive_steps + 1;
      if (nearer) least = length;
      if (unproductive_steps < max_unproductive_steps && damped_newton_step(here, dx)) continue;
      if (!descend_pseudo_transient(here)) break;
      least = INFINITY;
    }
    return converged;
  }

  // Makes the last of Newton's steps; returns whether the search ends there, at an equilibrium or because nothing leads
  // on.
  bool ends(TrialState& here, const VectorXd& dx) {
    if (largest(dx) > 0) move(here, step_of(here, dx));  // otherwise the position stays bitwise the same
    if (!here.is_on_bounds()) return !opens(here) && ++closures_ > max_closures;
    if (here.is_balanced() && holds(here)) {
      if (!lets_go(here) || ++releases_ > max_releases) return true;
      if (steady_) return false;
    }
    return !descend_pseudo_transient(here);
  }

  // Moves to the values held, without regard to forces, within limits, in steps that remain on the branch; returns
  // false if that fails.
  bool approach(TrialState& here) {
    approaches_ = true;
    for (int i = 0; i < max_steps && !holds(here); ++i) {
      const Step step = step_of(here, onto_held_values(here));
      const double limit = step_limit(states_.joint_rotations(here, step.z));
      double fraction = limit;
      while (!move(here, step * fraction)) {
        fraction /= 2;
        if (fraction < min_step_fraction * limit) return false;
      }
      if (limit == 1) --steps_;  // which Newton's method would make as well
    }
    approaches_ = false;
    if (!holds(here)) return false;
    if (of_.request.held.empty() && !steady_) return true;
    if (steady_) states_.hold_friction();
    std::ranges::fill(here.contacts, 0);
    states_.evaluate(here);
    states_.touch(here);
    states_.differentiate(here);
    return true;
  }

  // The smallest change that leads to the values held, and along the limits that it would cross: these are in contact.
  VectorXd onto_held_values(TrialState& here) {
    std::ranges::fill(here.contacts, 0);
    MatrixXd rows = here.hold_rows;
    VectorXd gaps = here.hold_gaps;
    while (true) {
      const SingularValues found(rows);
      const VectorXd dx = found.solve(gaps, found.rank(zero_stiffness_tolerance));
      const Room met = room(here, here.displacement_jacobian * dx, least_room);
      if (met.lock < 0) return dx;
      here.contacts[static_cast<std::size_t>(met.lock)] = met.side;
      rows = stacked(rows, states_.limit_row(here, met.lock));
      gaps.conservativeResize(rows.rows());
      gaps[rows.rows() - 1] = -met.side * here.depth(met.lock, met.side).depth;
    }
  }

  // The step along the bounds and values held, after that onto them, or a share of it.
  static VectorXd newton(const TrialState& at, const VectorXd& a, double share = 1) {
    MatrixXd J(at.A.rows(), at.A.cols() + at.B.cols());
    J << at.A, at.B;
    if (at.contact_rows.rows() + at.hold_rows.rows() == 0) return min_norm_step(J, a);
    const SingularValues rows(stacked(at.contact_rows, at.hold_rows));
    const MatrixXd along = free_directions(rows);
    VectorXd onto = rows.solve(share * stacked(at.contact_gaps, at.hold_gaps), rows.rank(zero_stiffness_tolerance));
    if (along.cols() == 0) return onto;
    return onto + along * min_norm_step(J * along, a + J * onto);
  }

  // Makes Newton's step or a fraction of it; returns false if none is acceptable.
  bool damped_newton_step(TrialState& here, const VectorXd& dx) {
    const Step step = step_of(here, dx);
    double fraction = step_limit(states_.joint_rotations(here, step.z));
    const double least = min_step_fraction * fraction;
    while (fraction >= least) {
      const auto is_acceptable = [&](const TrialState& there) {
        const VectorXd next = newton(here, states_.accelerations(here, there), 1 - fraction);
        return length_of(here, next) <= (1 - fraction / 4) * length_of(here, dx);
      };
      if (move(here, step * fraction, is_acceptable)) return true;
      fraction /= 2;
    }
    return false;
  }

  // Pseudo-transient continuation: implicit Euler on dq/dt = v': (s - A) dq = v', with s above all eigenvalues of A,
  // which are those of -M^-1 K, so that dq lowers the potential energy. Returns false if that makes no progress. What
  // is held stays to first order. Element states take part by their rates. A steady motion does not minimize a
  // potential.
  bool descend_pseudo_transient(TrialState& here) {
    if (steady_) return false;
    const bool repeated = descent_steps_ > 0;  // Newton's steps have led uphill again: descend to the minimum
    bool moved = false;
    for (; descent_steps_ < max_descent_steps; ++descent_steps_) {
      const MatrixXd free = free_directions(SingularValues(here.held_by_velocities()));
      if (free.cols() == 0) return moved;
      const MatrixXd A = free.transpose() * here.by_velocities() * free;
      const VectorXd a = free.transpose() * here.a;
      const double max_real_part = eigenvalues(A).real().maxCoeff();
      const bool stable = max_real_part < -zero_stiffness_tolerance * std::max(1.0, A.lpNorm<Eigen::Infinity>());
      const bool balanced = here.hold_rows.rows() == 0 ? here.is_balanced() : largest(a) <= equilibrium_rate_tolerance;
      if (balanced || (stable && moved && !repeated)) return moved;
      const double size = largest(here.a);
      double shift = 2 * std::max(max_real_part, 0.0) + largest(a);
      Step step;
      for (int k = 0; k < max_shifts; ++k) {
        const MatrixXd shifted = shift * MatrixXd::Identity(A.rows(), A.cols()) - A;
        const VectorXd dx = free * solution(shifted, a);
        const VectorXd z = here.velocity_jacobian * dx.head(here.velocity_jacobian.cols());
        const double limit = step_limit(states_.joint_rotations(here, z));
        step.z = limit * z;
        step.du = VectorXd::Zero(here.B.cols());
        step.du.tail(here.rates.size()) = limit * dx.tail(here.rates.size());
        // Where a contact ends, the motion begins away from the bound, but a long step may lead back to it.
        if (room(here, step.z, 1).fraction > least_room) break;
        shift *= shift_growth;
      }
      const std::vector<int> contacts = here.contacts;
      const bool meets_bound = room(here, step.z, unlimited).lock >= 0;
      if (!move(here, step)) return moved;
      // A constant force that does not depend on the coordinates, and that no limit will ever balance.
      if (largest(here.a) == size && here.contacts == contacts && !meets_bound) return false;
      moved = true;
    }
    return moved;
  }

  // Replaces the inputs by those of least norm with the same effect here.
  void minimize_inputs(TrialState& here) {
    VectorXd u(static_cast<Index>(of_.request.solve_for.size()));
    for (Index k = 0; k < u.size(); ++k) {
      const EquilibriumRequest::UnknownInput& unknown = of_.request.solve_for[static_cast<std::size_t>(k)];
      u[k] = here.u[static_cast<std::size_t>(unknown.input)] / unknown.size;
    }
    const MatrixXd by_inputs = here.B.leftCols(u.size());
    const SingularValues B(by_inputs);
    const VectorXd change = B.solve(by_inputs * u, B.rank(zero_stiffness_tolerance)) - u;
    if (largest(change) <= 1e-12 * largest(u)) return;
    VectorXd unknowns = VectorXd::Zero(here.sizes.size());
    unknowns.segment(here.A.cols(), u.size()) = change;
    move(here, step_of(here, unknowns));
  }

  // The fraction of a step that rotates no joint by more than max_rotation.
  static double step_limit(const VectorXd& joint_rotations) {
    const double largest_rotation = largest(joint_rotations);
    return largest_rotation > max_rotation ? max_rotation / largest_rotation : 1;
  }

  // The fraction of a displacement, at most `limit`, at which the first coordinate meets a bound, and its lock; -1:
  // none does.
  struct Room {
    double fraction;
    int lock = -1;
    int side = 0;
  };
  Room room(const TrialState& here, const VectorXd& z, double limit) {
    Room out{limit};
    for (int i = 0; i < states_.locks(); ++i) {
      if (here.contacts[static_cast<std::size_t>(i)] != 0 || !states_.may_touch(i)) continue;
      if ((approaches_ || steady_) && states_.forces().lock(i).one_way) continue;  // it bounds the speed
      const double speed = states_.forces().speed(i, z.data());
      const int side = speed > 0 ? 1 : -1;
      const double left = std::max(0.0, -here.depth(i, side).depth);
      if (left < out.fraction * std::abs(speed)) out = {left / std::abs(speed), i, side};
    }
    return out;
  }

  // Makes a step, or up to the first bound, where contact begins. Returns false, and leaves `here` unchanged, if
  // closing the loops fails, derivatives do not exist there, or the step is not acceptable.
  template <class Accept>
  bool move(TrialState& here, const Step& step, Accept is_acceptable) {
    const Room to = room(here, step.z, 1);
    auto there = states_.closed_neighbor(here, to.fraction * step.z, to.fraction * step.dv, to.fraction * step.du);
    if (!there) return false;
    try {
      if (to.lock >= 0 && there->depth(to.lock, to.side).depth >= reached_share * here.depth(to.lock, to.side).depth) {
        there->contacts[static_cast<std::size_t>(to.lock)] = to.side;
        states_.evaluate(*there);
      } else if (!is_acceptable(*there)) {
        return false;
      }
      states_.touch(*there);
      states_.differentiate(*there);
    } catch (const NotDifferentiablePoint&) {
      return false;
    } catch (const SingularMass&) {
      return false;
    }
    here = std::move(*there);
    ++steps_;
    return true;
  }
  bool move(TrialState& here, const Step& step) {
    return move(here, step, [](const TrialState&) { return true; });
  }

  void renew(TrialState& here) {
    states_.evaluate(here);
    states_.differentiate(here);
  }

  // Ends the contacts that cannot be closed, where a loop does not reach several bounds at once, and returns whether
  // there are any.
  bool opens(TrialState& here) {
    bool any = false;
    for (int i = 0; i < states_.locks(); ++i) {
      int& side = here.contacts[static_cast<std::size_t>(i)];
      if (side == 0 || here.depth(i, side).depth > -converged_step) continue;
      side = 0;
      any = true;
    }
    if (any) renew(here);
    return any;
  }

  // Ends the contacts that would have to pull, lets slip what friction cannot keep at rest in a steady motion, and
  // returns whether there are any.
  bool lets_go(TrialState& here) {
    std::vector<int> locks;
    for (int i = 0; i < states_.locks(); ++i) {
      if (here.contacts[static_cast<std::size_t>(i)] != 0 || states_.sticks(i, here)) locks.push_back(i);
    }
    if (locks.empty()) return false;
    states_.evaluate(here);
    HoldingBounds bounds = holding_bounds(states_.forces(), locks, here.contacts);
    if (!steady_) {  // without friction
      bounds.lower = (bounds.lower.array() == -unlimited).select(bounds.lower, 0.0);
      bounds.upper = (bounds.upper.array() == unlimited).select(bounds.upper, 0.0);
    }
    const std::vector<double>& forces = states_.forces().holding_forces().values();
    const VectorXd x = Eigen::Map<const VectorXd>(forces.data(), states_.locks())(locks);
    MatrixXd W;
    VectorXd scale;
    states_.forces().compliance(locks, W, scale);
    const VectorXd motion = solve_in_box(W, W * x, bounds.lower, bounds.upper).r * of_.time * of_.time;
    bool any = false;
    for (Index i = 0; i < motion.size(); ++i) {
      if (std::abs(motion[i]) <= equilibrium_rate_tolerance) continue;
      const auto lock = static_cast<std::size_t>(locks[static_cast<std::size_t>(i)]);
      here.contacts[lock] = 0;
      here.slips[lock] = motion[i] > 0 ? -1 : 1;
      any = true;
    }
    if (any) renew(here);
    return any;
  }

  const EquilibriumProblem& of_;
  bool steady_;
  TrialStates states_;
  bool approaches_ = false;
  int steps_ = 0, descent_steps_ = 0, releases_ = 0, closures_ = 0;
};

}  // namespace

Equilibrium find_equilibrium(const EquilibriumProblem& of, const std::vector<double>& q,
                             const std::vector<double>& cut_q, const std::vector<double>& v) {
  return EquilibriumSearch(of).run(q, cut_q, v);
}

}  // namespace gelenk
