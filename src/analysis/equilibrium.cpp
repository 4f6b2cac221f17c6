// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/equilibrium.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "analysis/independent_columns.h"
#include "assembly/loop_closure.h"
#include "linear/descent.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int most_steps = 200;
constexpr int most_in_vain = 5;  // steps by which those to come do not become shorter by this factor
constexpr double progress = 0.9;
constexpr int most_falls = 100;        // steps downhill, where Newton's lead nowhere
constexpr double shortest = 1.0 / 64;  // of a step, before it is given up
// Singular values of A up to this, or this share of the largest, are rounding: of directions that nothing holds.
constexpr double unheld = 1e-10;
constexpr double settled_step = 1e-9;  // rad or of the mechanism's length: the error after it is its square
constexpr double longest_turn = 0.3;   // rad: what a step may turn a joint by, so that loops stay on their branch

// Whether speed i of a joint is that of a turn. Rods turn at both ends.
template <class Joint>
bool is_turn(const Joint& joint, int i) {
  return std::visit(
      [i](const auto& j) {
        if constexpr (requires { j.v_names; }) return j.v_names[static_cast<std::size_t>(i)].unit == "rad/s";
        return true;
      },
      joint);
}

// A pose at rest, closed. Its independent coordinates are those that tell the others best there: the acceleration of
// another one would vanish at its dead centre, too, whatever the rest does.
struct Place {
  std::vector<double> q, cut_q;
  VectorXd vdot{};  // of all speeds, in the mechanism's own time as what follows
  // From differentiate() on:
  std::vector<int> speeds{};               // the independent ones
  VectorXd a{};                            // their accelerations
  MatrixXd A{};                            // the slopes of a by the independent coordinates
  MatrixXd by_coordinates{}, by_speeds{};  // displacements of all by independent coordinates; speeds of all by such
  MatrixXd ways{};                         // the independent coordinates' rates by the independent speeds
};

bool stands(const Place& at) {
  const VectorXd terms = at.A.cwiseAbs().rowwise().sum();
  return (at.a.array().abs() <= equilibrium_rate_tolerance + equilibrium_rounding_tolerance * terms.array()).all();
}

class Finder {
 public:
  explicit Finder(const AtRest& of)
      : of_(of),
        mechanism_(of.mechanism),
        dynamics_(make_dynamics(of.mechanism, of.loads)),
        still_(mechanism_.nv, 0.0),
        square_(of.time * of.time) {
    dynamics_->set_max_rank(of.mobility.rank);
    dynamics_->set_targets(with_two_derivatives(of.targets).data());
  }

  Rest run(const std::vector<double>& q, const std::vector<double>& cut_q) {
    Place here{.q = q, .cut_q = cut_q};
    stand(here);
    try {
      differentiate(here);
    } catch (const NotDifferentiablePoint&) {
      if (largest(here.vdot) > equilibrium_rate_tolerance) throw;
      return {std::move(here.q), std::move(here.cut_q)};
    }
    bool settled = here.a.size() == 0;
    double least = INFINITY;  // of Newton's steps since the last fall
    int in_vain = 0;          // steps since then
    for (int i = 0; i < most_steps && !settled; ++i) {
      const VectorXd dx = newton(here, here.a);
      if (largest(dx) < settled_step) {
        if (largest(dx) > 0) {  // else it stands where it stood, to the bit
          if (auto there = beside(here, here.by_coordinates * dx)) here = std::move(*there);
        }
        settled = stands(here) || !fall(here);
        continue;
      }
      // Shortened steps go on to and fro where A is singular between two poses.
      const bool nearer = largest(dx) < progress * least;
      in_vain = nearer ? 0 : in_vain + 1;
      if (nearer) least = largest(dx);
      if (in_vain < most_in_vain && shortened(here, dx)) continue;
      if (!fall(here)) break;
      least = INFINITY;
    }
    if (!stands(here)) throw NoEquilibrium(here.vdot / square_);
    return {std::move(here.q), std::move(here.cut_q)};
  }

 private:
  // The least dx with A dx = -a, or nearest to it.
  static VectorXd newton(const Place& at, const VectorXd& a) {
    Eigen::BDCSVD<MatrixXd> svd(at.A, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const double stiffest = largest(svd.singularValues());
    if (!(stiffest > unheld)) return VectorXd::Zero(at.A.cols());
    svd.setThreshold(unheld * std::max(1.0, 1 / stiffest));
    return svd.solve(-a);
  }

  // Newton's step or a part of it.
  bool shortened(Place& here, const VectorXd& dx) {
    double part = bearable(turns(here, here.by_coordinates * dx));
    const double least = shortest * part;
    while (part >= least) {
      const auto enough = [&](const Place& there) {
        return largest(newton(here, there.vdot(here.speeds))) <= (1 - part / 4) * largest(dx);
      };
      if (auto there = beside(here, here.by_coordinates * (part * dx), enough)) {
        here = std::move(*there);
        return true;
      }
      part /= 2;
    }
    return false;
  }

  // Implicit Euler on dq/dt = v': (s - A) dq = v', with s above all eigenvalues of A, which are those of -M^-1 K: so dq
  // lowers the potential energy. False: that leads nowhere.
  bool fall(Place& here) {
    const bool again = falls_ > 0;  // from where Newton's steps have led up once more: down to the bottom
    bool moved = false;
    for (; falls_ < most_falls; ++falls_) {
      const MatrixXd A = here.A * here.ways;
      const double steepest = A.eigenvalues().real().maxCoeff();
      const bool stable = steepest < -unheld * std::max(1.0, A.lpNorm<Eigen::Infinity>());
      if (stands(here) || (stable && moved && !again)) return moved;
      const double size = largest(here.a);
      const MatrixXd slowed = (2 * std::max(steepest, 0.0) + size) * MatrixXd::Identity(A.rows(), A.cols()) - A;
      const VectorXd z = here.by_speeds * slowed.partialPivLu().solve(here.a);
      auto there = beside(here, bearable(turns(here, z)) * z);
      if (!there) return moved;
      const bool same = largest(there->a) == size;  // a constant force that no coordinate changes
      here = std::move(*there);
      if (same) return false;
      moved = true;
    }
    return moved;
  }

  // By what a displacement turns joints [rad].
  VectorXd turns(const Place& here, const VectorXd& z) {
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

  // The part of a step that turns no joint by more than is good.
  static double bearable(const VectorXd& turns) {
    const double most = largest(turns);
    return most > longest_turn ? longest_turn / most : 1;
  }

  // The pose that closes next to `here` displaced by z; none where that fails, derivatives do not exist there, or it is
  // not good enough.
  template <class Enough>
  std::optional<Place> beside(const Place& here, const VectorXd& z, Enough enough) {
    Place there{.q = here.q, .cut_q = here.cut_q};
    dynamics_->displace(there.q.data(), z.data());
    if (!close_rows(mechanism_, *dynamics_, there.q)) return {};
    try {
      stand(there);
      if (!enough(there)) return {};
      differentiate(there);
    } catch (const NotDifferentiablePoint&) {
      return {};
    } catch (const SingularMass&) {
      return {};
    }
    return there;
  }
  std::optional<Place> beside(const Place& here, const VectorXd& z) {
    return beside(here, z, [](const Place&) { return true; });
  }

  void stand(Place& at) {
    dynamics_->set_cut_reference(at.cut_q.data());
    dynamics_->set_position(at.q.data());
    dynamics_->factorize();
    dynamics_->set_velocity(still_.data());
    at.vdot.resize(mechanism_.nv);
    dynamics_->solve(of_.u.data(), at.vdot.data());
    at.vdot *= square_;
    for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) count_turns(c, at.cut_q);
  }

  // Angles of a cut joint are those next to where they were.
  void count_turns(int c, std::vector<double>& cut_q) const {
    const Cut& cut = mechanism_.cuts[static_cast<std::size_t>(c)];
    double found[max_cut_nq];
    std::copy_n(cut_q.data() + cut.iq, cut.nq, found);
    dynamics_->cut_coordinates(c, found);
    for (int i = 0; i < cut.nq; ++i) {
      double& q = cut_q[cut.iq + i];
      q = cut.turns[static_cast<std::size_t>(i)] ? q + std::remainder(found[i] - q, 2 * std::numbers::pi) : found[i];
    }
  }

  // Where dynamics_ stands.
  void differentiate(Place& at) {
    const int nv = mechanism_.nv;
    const std::vector<bool> any(static_cast<std::size_t>(nv), false);
    const Independent by = independent_at(mechanism_, *dynamics_, of_.mobility, any, any);
    ConstrainedSensitivity tangent(mechanism_, of_.loads, of_.mobility, by, static_cast<int>(of_.u.size()));
    tangent.set_point(at.q.data(), still_.data(), of_.u.data(), at.cut_q.data(), of_.targets);
    const auto n = static_cast<Index>(by.coordinates.size());
    const auto m = static_cast<Index>(by.speeds.size());
    MatrixXd dq = MatrixXd::Zero(mechanism_.nq, n + m);
    MatrixXd dv = MatrixXd::Zero(nv, n + m);
    for (Index k = 0; k < n; ++k) {
      const VectorXd z = VectorXd::Unit(nv, by.coordinates[static_cast<std::size_t>(k)]);
      dynamics_->qdot_from_v(at.q.data(), z.data(), dq.col(k).data());
    }
    for (Index k = 0; k < m; ++k) dv(by.speeds[static_cast<std::size_t>(k)], n + k) = 1;
    const MatrixXd moved = tangent.state_derivative(dq, dv, MatrixXd::Zero(static_cast<Index>(of_.u.size()), n + m)).y;
    at.speeds = by.speeds;
    at.a = at.vdot(by.speeds);
    at.A = square_ * moved.bottomRows(nv)(by.speeds, Eigen::seqN(0, n));
    at.by_coordinates = displacements(mechanism_, at.q.data(), moved.topLeftCorner(mechanism_.nq, n));
    at.by_speeds = moved.block(mechanism_.nq, n, nv, m);
    at.ways = at.by_speeds(by.coordinates, Eigen::all);
  }

  const AtRest& of_;
  const Mechanism& mechanism_;
  std::unique_ptr<Dynamics> dynamics_;
  std::vector<double> still_;  // speeds
  double square_;              // s2, of the mechanism's own time
  int falls_ = 0;
};

}  // namespace

Rest find_rest(const AtRest& of, const std::vector<double>& q, const std::vector<double>& cut_q) {
  return Finder(of).run(q, cut_q);
}

}  // namespace gelenk
