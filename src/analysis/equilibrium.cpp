// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/equilibrium.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "analysis/rest_pose.h"
#include "linear/box_complementarity.h"
#include "linear/descent.h"
#include "linear/singular_values.h"

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
constexpr double converged_step = 1e-9;  // rad or relative to length; the error is then of the order of its square
constexpr double max_rotation = 0.3;     // rad: limit on joint rotations per step, so that loops stay on their branch
constexpr double unlimited = std::numeric_limits<double>::infinity();
constexpr int max_shifts = 8;  // shorter and shorter steps of the descent
constexpr double shift_growth = 10;
constexpr double least_room = 1e-6;    // fraction of such a step up to a bound
constexpr double reached_share = 0.1;  // of the way to a bound that may be left where contact begins
constexpr int max_closures = 5;        // steps onto bounds that bring no contact to its bound
constexpr int max_releases = 50;       // of contacts that would pull, before the search gives up

// Orthonormal columns: the changes of the independent coordinates that leave all contacts at their bounds.
MatrixXd along_bounds(const SingularValues& contact_rows) {
  const Index rank = contact_rows.rank(zero_stiffness_tolerance);
  return contact_rows.V.rightCols(contact_rows.V.cols() - rank);
}

// Minimum-norm least-squares solution of A dx = -a.
VectorXd min_norm_step(const MatrixXd& A, const VectorXd& a) {
  const SingularValues svd(A);
  const double largest_stiffness = largest(svd.sigma);
  if (!(largest_stiffness > zero_stiffness_tolerance)) return VectorXd::Zero(A.cols());
  return svd.solve(-a, svd.rank(zero_stiffness_tolerance * std::max(1.0, 1 / largest_stiffness)));
}

class EquilibriumSearch {
 public:
  explicit EquilibriumSearch(const EquilibriumProblem& of) : time_scale_squared_(of.time * of.time), poses_(of) {}

  Equilibrium run(const std::vector<double>& q, const std::vector<double>& cut_q) {
    RestPose here{.q = q, .cut_q = cut_q};
    poses_.evaluate(here);
    poses_.touch(here);
    try {
      poses_.differentiate(here);
    } catch (const NotDifferentiablePoint&) {
      if (largest(here.vdot) > equilibrium_rate_tolerance || !here.is_on_bounds() || lets_go(here)) throw;
      return {std::move(here.q), std::move(here.cut_q)};
    }
    bool converged = here.a.size() == 0;
    double least = INFINITY;     // shortest Newton step since the last descent
    int unproductive_steps = 0;  // steps since then without contraction
    for (int i = 0; i < max_steps && !converged; ++i) {
      const VectorXd dx = newton(here, here.a);
      if (largest(dx) < converged_step) {
        converged = ends(here, dx);
        least = INFINITY;
        continue;
      }
      // Damped steps may oscillate between two poses if A is singular between them.
      const bool nearer = largest(dx) < required_contraction * least;
      unproductive_steps = nearer ? 0 : unproductive_steps + 1;
      if (nearer) least = largest(dx);
      if (unproductive_steps < max_unproductive_steps && damped_newton_step(here, dx)) continue;
      if (!descend_pseudo_transient(here)) break;
      least = INFINITY;
    }
    if (!here.is_on_bounds()) {  // contacts that are none
      std::ranges::fill(here.contacts, 0);
      poses_.evaluate(here);
      throw NoEquilibrium(here.vdot / time_scale_squared_);
    }
    if (!here.is_balanced()) throw NoEquilibrium(here.vdot / time_scale_squared_);
    return {std::move(here.q), std::move(here.cut_q)};
  }

 private:
  // Makes the last of Newton's steps; returns whether the search ends there, at an equilibrium or because nothing leads
  // on.
  bool ends(RestPose& here, const VectorXd& dx) {
    if (largest(dx) > 0) move(here, here.displacement_jacobian * dx);  // otherwise the position stays bitwise the same
    if (!here.is_on_bounds()) return !opens(here) && ++closures_ > max_closures;
    if (here.is_balanced() && (!lets_go(here) || ++releases_ > max_releases)) return true;
    return !descend_pseudo_transient(here);
  }

  // The step along the bounds, after that onto the bounds of all contacts, or a share of it.
  static VectorXd newton(const RestPose& at, const VectorXd& a, double share = 1) {
    if (at.contact_rows.rows() == 0) return min_norm_step(at.A, a);
    const SingularValues rows(at.contact_rows);
    const MatrixXd along = along_bounds(rows);
    VectorXd onto = rows.solve(share * at.contact_gaps, rows.rank(zero_stiffness_tolerance));
    if (along.cols() == 0) return onto;
    return onto + along * min_norm_step(at.A * along, a + at.A * onto);
  }

  // Makes Newton's step or a fraction of it; returns false if none is acceptable.
  bool damped_newton_step(RestPose& here, const VectorXd& dx) {
    double fraction = step_limit(poses_.joint_rotations(here, here.displacement_jacobian * dx));
    const double least = min_step_fraction * fraction;
    while (fraction >= least) {
      const auto is_acceptable = [&](const RestPose& there) {
        return largest(newton(here, there.vdot(here.speeds), 1 - fraction)) <= (1 - fraction / 4) * largest(dx);
      };
      if (move(here, here.displacement_jacobian * (fraction * dx), is_acceptable)) return true;
      fraction /= 2;
    }
    return false;
  }

  // Pseudo-transient continuation: implicit Euler on dq/dt = v': (s - A) dq = v', with s above all eigenvalues of A,
  // which are those of -M^-1 K, so that dq lowers the potential energy. Returns false if that makes no progress.
  bool descend_pseudo_transient(RestPose& here) {
    const bool repeated = descent_steps_ > 0;  // Newton's steps have led uphill again: descend to the minimum
    bool moved = false;
    for (; descent_steps_ < max_descent_steps; ++descent_steps_) {
      const MatrixXd A = here.A * here.coordinate_rates;
      const double max_real_part = A.eigenvalues().real().maxCoeff();
      const bool stable = max_real_part < -zero_stiffness_tolerance * std::max(1.0, A.lpNorm<Eigen::Infinity>());
      if (here.is_balanced() || (stable && moved && !repeated)) return moved;
      const double size = largest(here.a);
      double shift = 2 * std::max(max_real_part, 0.0) + size;
      VectorXd step;
      for (int k = 0; k < max_shifts; ++k) {
        const MatrixXd shifted = shift * MatrixXd::Identity(A.rows(), A.cols()) - A;
        const VectorXd z = here.velocity_jacobian * shifted.partialPivLu().solve(here.a);
        step = step_limit(poses_.joint_rotations(here, z)) * z;
        // Where a contact ends, the motion begins away from the bound, but a long step may lead back to it.
        if (room(here, step, 1).fraction > least_room) break;
        shift *= shift_growth;
      }
      const std::vector<int> contacts = here.contacts;
      const bool meets_bound = room(here, step, unlimited).lock >= 0;
      if (!move(here, step)) return moved;
      // A constant force that does not depend on the coordinates, and that no limit will ever balance.
      if (largest(here.a) == size && here.contacts == contacts && !meets_bound) return false;
      moved = true;
    }
    return moved;
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
  Room room(const RestPose& here, const VectorXd& z, double limit) {
    Room out{limit};
    for (int i = 0; i < poses_.locks(); ++i) {
      if (here.contacts[static_cast<std::size_t>(i)] != 0) continue;
      const double speed = poses_.forces().speed(i, z.data());
      const int side = speed > 0 ? 1 : -1;
      const double left = std::max(0.0, -here.depth(i, side).depth);
      if (left < out.fraction * std::abs(speed)) out = {left / std::abs(speed), i, side};
    }
    return out;
  }

  // Displaces `here` by z, or up to the first bound, where contact begins. Returns false, and leaves it unchanged, if
  // closing the loops fails, derivatives do not exist there, or the step is not acceptable.
  template <class Accept>
  bool move(RestPose& here, const VectorXd& z, Accept is_acceptable) {
    const Room to = room(here, z, 1);
    auto there = poses_.closed_neighbor(here, to.fraction * z);
    if (!there) return false;
    try {
      if (to.lock >= 0 && there->depth(to.lock, to.side).depth >= reached_share * here.depth(to.lock, to.side).depth) {
        there->contacts[static_cast<std::size_t>(to.lock)] = to.side;
        poses_.evaluate(*there);
      } else if (!is_acceptable(*there)) {
        return false;
      }
      poses_.touch(*there);
      poses_.differentiate(*there);
    } catch (const NotDifferentiablePoint&) {
      return false;
    } catch (const SingularMass&) {
      return false;
    }
    here = std::move(*there);
    return true;
  }
  bool move(RestPose& here, const VectorXd& z) {
    return move(here, z, [](const RestPose&) { return true; });
  }

  // Ends the contacts that cannot be closed, where a loop does not reach several bounds at once, and returns whether
  // there are any.
  bool opens(RestPose& here) {
    bool any = false;
    for (int i = 0; i < poses_.locks(); ++i) {
      int& side = here.contacts[static_cast<std::size_t>(i)];
      if (side == 0 || here.depth(i, side).depth > -converged_step) continue;
      side = 0;
      any = true;
    }
    if (any) {
      poses_.evaluate(here);
      poses_.differentiate(here);
    }
    return any;
  }

  // Ends the contacts that would have to pull, and returns whether there are any.
  bool lets_go(RestPose& here) {
    std::vector<int> locks;
    for (int i = 0; i < poses_.locks(); ++i) {
      if (here.contacts[static_cast<std::size_t>(i)] != 0) locks.push_back(i);
    }
    if (locks.empty()) return false;
    poses_.evaluate(here);
    const auto n = static_cast<Index>(locks.size());
    VectorXd x(n);
    VectorXd lower = VectorXd::Zero(n);
    VectorXd upper = VectorXd::Zero(n);
    for (Index i = 0; i < n; ++i) {
      const auto lock = static_cast<std::size_t>(locks[static_cast<std::size_t>(i)]);
      x[i] = poses_.forces().holding_forces().values()[lock];
      (here.contacts[lock] > 0 ? lower : upper)[i] = here.contacts[lock] > 0 ? -unlimited : unlimited;
    }
    MatrixXd W;
    VectorXd scale;
    poses_.forces().compliance(locks, W, scale);
    const VectorXd motion = solve_in_box(W, W * x, lower, upper).r * time_scale_squared_;
    bool any = false;
    for (Index i = 0; i < n; ++i) {
      if (std::abs(motion[i]) <= equilibrium_rate_tolerance) continue;
      here.contacts[static_cast<std::size_t>(locks[static_cast<std::size_t>(i)])] = 0;
      any = true;
    }
    if (any) {
      poses_.evaluate(here);
      poses_.differentiate(here);
    }
    return any;
  }

  double time_scale_squared_;  // s2
  RestPoses poses_;
  int descent_steps_ = 0, releases_ = 0, closures_ = 0;
};

}  // namespace

Equilibrium find_equilibrium(const EquilibriumProblem& of, const std::vector<double>& q,
                             const std::vector<double>& cut_q) {
  return EquilibriumSearch(of).run(q, cut_q);
}

}  // namespace gelenk
