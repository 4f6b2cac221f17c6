// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/equilibrium.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "analysis/independent_columns.h"
#include "assembly/loop_closure.h"
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

// A closed position at zero velocity. Its independent coordinates are those that determine the others best there: the
// acceleration of another one would vanish at its dead center, too, regardless of the other joints.
struct RestPose {
  std::vector<double> q, cut_q;
  VectorXd vdot{};  // of all velocities, in the mechanism's time scale, as are the members below
  // Set by differentiate():
  std::vector<int> speeds{};         // indices of the independent velocities
  VectorXd a{};                      // their accelerations
  MatrixXd A{};                      // Jacobian of a with respect to the independent coordinates
  MatrixXd displacement_jacobian{};  // displacements of all by independent coordinates
  MatrixXd velocity_jacobian{};      // all velocities by independent velocities
  MatrixXd coordinate_rates{};       // rates of the independent coordinates by independent velocities
};

bool is_equilibrium(const RestPose& at) {
  const VectorXd terms = at.A.cwiseAbs().rowwise().sum();
  return (at.a.array().abs() <= equilibrium_rate_tolerance + equilibrium_rounding_tolerance * terms.array()).all();
}

class EquilibriumSearch {
 public:
  explicit EquilibriumSearch(const EquilibriumProblem& of)
      : of_(of),
        mechanism_(of.mechanism),
        dynamics_(make_dynamics(of.mechanism, of.loads)),
        zero_velocity_(mechanism_.nv, 0.0),
        time_scale_squared_(of.time * of.time) {
    dynamics_->set_max_rank(of.mobility.rank);
    dynamics_->set_targets(with_two_derivatives(of.targets).data());
  }

  Equilibrium run(const std::vector<double>& q, const std::vector<double>& cut_q) {
    RestPose here{.q = q, .cut_q = cut_q};
    evaluate(here);
    try {
      differentiate(here);
    } catch (const NotDifferentiablePoint&) {
      if (largest(here.vdot) > equilibrium_rate_tolerance) throw;
      return {std::move(here.q), std::move(here.cut_q)};
    }
    bool converged = here.a.size() == 0;
    double least = INFINITY;     // shortest Newton step since the last descent
    int unproductive_steps = 0;  // steps since then without contraction
    for (int i = 0; i < max_steps && !converged; ++i) {
      const VectorXd dx = newton(here, here.a);
      if (largest(dx) < converged_step) {
        if (largest(dx) > 0) {  // otherwise the position stays bitwise the same
          if (auto there = closed_neighbor(here, here.displacement_jacobian * dx)) here = std::move(*there);
        }
        converged = is_equilibrium(here) || !descend_pseudo_transient(here);
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
    if (!is_equilibrium(here)) throw NoEquilibrium(here.vdot / time_scale_squared_);
    return {std::move(here.q), std::move(here.cut_q)};
  }

 private:
  // Minimum-norm least-squares solution of A dx = -a.
  static VectorXd newton(const RestPose& at, const VectorXd& a) {
    const SingularValues svd(at.A);
    const double largest_stiffness = largest(svd.sigma);
    if (!(largest_stiffness > zero_stiffness_tolerance)) return VectorXd::Zero(at.A.cols());
    return svd.solve(-a, svd.rank(zero_stiffness_tolerance * std::max(1.0, 1 / largest_stiffness)));
  }

  // Makes Newton's step or a fraction of it; returns false if none is acceptable.
  bool damped_newton_step(RestPose& here, const VectorXd& dx) {
    double fraction = step_limit(joint_rotations(here, here.displacement_jacobian * dx));
    const double least = min_step_fraction * fraction;
    while (fraction >= least) {
      const auto is_acceptable = [&](const RestPose& there) {
        return largest(newton(here, there.vdot(here.speeds))) <= (1 - fraction / 4) * largest(dx);
      };
      if (auto there = closed_neighbor(here, here.displacement_jacobian * (fraction * dx), is_acceptable)) {
        here = std::move(*there);
        return true;
      }
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
      if (is_equilibrium(here) || (stable && moved && !repeated)) return moved;
      const double size = largest(here.a);
      const MatrixXd shifted = (2 * std::max(max_real_part, 0.0) + size) * MatrixXd::Identity(A.rows(), A.cols()) - A;
      const VectorXd z = here.velocity_jacobian * shifted.partialPivLu().solve(here.a);
      auto there = closed_neighbor(here, step_limit(joint_rotations(here, z)) * z);
      if (!there) return moved;
      const bool unchanged = largest(there->a) == size;  // a constant force that does not depend on the coordinates
      here = std::move(*there);
      if (unchanged) return false;
      moved = true;
    }
    return moved;
  }

  // Rotations of the joints by a displacement [rad].
  VectorXd joint_rotations(const RestPose& here, const VectorXd& z) {
    std::vector<double> out;
    const auto add = [&](const auto& joint, int nv, const double* v) {
      for (int i = 0; i < nv; ++i) {
        if (is_turn(joint, i)) out.push_back(v[i]);
      }
    };
    for (const Link& link : mechanism_.links) add(link.joint, link.nv, z.data() + link.iv);
    dynamics_->set_position(here.q.data());
    dynamics_->set_velocity(z.data());
    double v[max_cut_nv];
    for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) {
      dynamics_->readings().cut_speeds(c, v);
      add(mechanism_.cuts[static_cast<std::size_t>(c)].joint, mechanism_.cuts[static_cast<std::size_t>(c)].nv, v);
    }
    return Eigen::Map<const VectorXd>(out.data(), static_cast<Index>(out.size()));
  }

  // The fraction of a step that rotates no joint by more than max_rotation.
  static double step_limit(const VectorXd& joint_rotations) {
    const double largest_rotation = largest(joint_rotations);
    return largest_rotation > max_rotation ? max_rotation / largest_rotation : 1;
  }

  // The closed position next to `here` displaced by z; empty if closing fails, derivatives do not exist there, or it is
  // not acceptable.
  template <class Accept>
  std::optional<RestPose> closed_neighbor(const RestPose& here, const VectorXd& z, Accept is_acceptable) {
    RestPose there{.q = here.q, .cut_q = here.cut_q};
    dynamics_->displace(there.q.data(), z.data());
    if (!close_rows(mechanism_, *dynamics_, there.q)) return {};
    try {
      evaluate(there);
      if (!is_acceptable(there)) return {};
      differentiate(there);
    } catch (const NotDifferentiablePoint&) {
      return {};
    } catch (const SingularMass&) {
      return {};
    }
    return there;
  }
  std::optional<RestPose> closed_neighbor(const RestPose& here, const VectorXd& z) {
    return closed_neighbor(here, z, [](const RestPose&) { return true; });
  }

  void evaluate(RestPose& at) {
    dynamics_->set_cut_reference(at.cut_q.data());
    dynamics_->set_position(at.q.data());
    dynamics_->factorize();
    dynamics_->set_velocity(zero_velocity_.data());
    at.vdot.resize(mechanism_.nv);
    dynamics_->solve(of_.u.data(), at.vdot.data());
    at.vdot *= time_scale_squared_;
    for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) unwrap_angles(c, at.cut_q);
  }

  // Unwraps the angles of a cut joint: they are continued from their previous values.
  void unwrap_angles(int c, std::vector<double>& cut_q) const {
    const Cut& cut = mechanism_.cuts[static_cast<std::size_t>(c)];
    double found[max_cut_nq];
    std::copy_n(cut_q.data() + cut.iq, cut.nq, found);
    dynamics_->cut_coordinates(c, found);
    for (int i = 0; i < cut.nq; ++i) {
      double& q = cut_q[cut.iq + i];
      q = cut.is_angle[static_cast<std::size_t>(i)] ? q + std::remainder(found[i] - q, 2 * std::numbers::pi) : found[i];
    }
  }

  // Derivatives at the present position of dynamics_.
  void differentiate(RestPose& at) {
    const int nv = mechanism_.nv;
    const std::vector<bool> any(static_cast<std::size_t>(nv), false);
    const Independent by = independent_at(mechanism_, *dynamics_, of_.mobility, any, any);
    ConstrainedSensitivity sensitivity(mechanism_, of_.loads, of_.mobility, by, static_cast<int>(of_.u.size()));
    sensitivity.set_point(at.q.data(), zero_velocity_.data(), of_.u.data(), at.cut_q.data(), of_.targets);
    const auto n = static_cast<Index>(by.coordinates.size());
    const auto m = static_cast<Index>(by.speeds.size());
    MatrixXd dq = MatrixXd::Zero(mechanism_.nq, n + m);
    MatrixXd dv = MatrixXd::Zero(nv, n + m);
    for (Index k = 0; k < n; ++k) {
      const VectorXd z = VectorXd::Unit(nv, by.coordinates[static_cast<std::size_t>(k)]);
      dynamics_->qdot_from_v(at.q.data(), z.data(), dq.col(k).data());
    }
    for (Index k = 0; k < m; ++k) dv(by.speeds[static_cast<std::size_t>(k)], n + k) = 1;
    const MatrixXd moved =
        sensitivity.state_derivative(dq, dv, MatrixXd::Zero(static_cast<Index>(of_.u.size()), n + m)).y;
    at.speeds = by.speeds;
    at.a = at.vdot(by.speeds);
    at.A = time_scale_squared_ * moved.bottomRows(nv)(by.speeds, Eigen::seqN(0, n));
    at.displacement_jacobian = displacements(mechanism_, at.q.data(), moved.topLeftCorner(mechanism_.nq, n));
    at.velocity_jacobian = moved.block(mechanism_.nq, n, nv, m);
    at.coordinate_rates = at.velocity_jacobian(by.coordinates, Eigen::all);
  }

  const EquilibriumProblem& of_;
  const Mechanism& mechanism_;
  std::unique_ptr<Dynamics> dynamics_;
  std::vector<double> zero_velocity_;
  double time_scale_squared_;  // s2
  int descent_steps_ = 0;
};

}  // namespace

Equilibrium find_equilibrium(const EquilibriumProblem& of, const std::vector<double>& q,
                             const std::vector<double>& cut_q) {
  return EquilibriumSearch(of).run(q, cut_q);
}

}  // namespace gelenk
