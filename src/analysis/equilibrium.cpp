// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/equilibrium.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double still = 1e-9;        // rad/s2, m/s2: a tenth of what gelenk.linearize calls an equilibrium
constexpr double longest_step = 0.4;  // rad or m
constexpr double closed = 1e-13;      // relative to the mechanism's size
constexpr int most_steps = 200;

class Finder {
 public:
  Finder(const Mechanism& mechanism, const Loads& loads, const Structure& structure, const Independent& independent,
         const std::vector<double>& cut_q, const std::vector<double>& u,
         const std::vector<MotionLaw::Derivatives>& targets)
      : mechanism_(mechanism),
        independent_(independent),
        cut_q_(cut_q),
        u_(u),
        targets_(targets),
        tangent_(mechanism, loads, structure, independent, static_cast<int>(u.size())),
        dynamics_(make_dynamics(mechanism, loads)),
        rest_(mechanism.nv, 0.0) {
    dynamics_->limit_rank(structure.rank);
    dynamics_->set_targets(with_two_derivatives(targets).data());
    for (const Link& link : mechanism.links) size_ += link.X_PJ.p.norm();
  }

  Rest run(const std::vector<double>& q) {
    Rest out{q};
    VectorXd a = accelerations(out.q);
    double damping = 1e-3;
    while (a.size() > 0 && a.lpNorm<Eigen::Infinity>() > still) {
      if (out.steps++ == most_steps) give_up(a);
      const Slopes at = slopes(out.q);
      const MatrixXd square = at.A.transpose() * at.A;
      const double scale = std::max(square.diagonal().maxCoeff(), 1e-12);
      bool better = false;
      for (int k = 0; k < 16 && !better; ++k) {
        MatrixXd damped = square;
        damped.diagonal().array() += damping * scale;
        VectorXd step = -damped.ldlt().solve(at.A.transpose() * a);
        const double longest = step.lpNorm<Eigen::Infinity>();
        if (longest > longest_step) step *= longest_step / longest;
        std::vector<double> next = moved(out.q, at.dq * step);
        const VectorXd a_next = close(next) ? accelerations(next) : VectorXd::Constant(a.size(), INFINITY);
        better = a_next.norm() < a.norm() * (1 - 1e-9);
        damping = better ? damping / 10 : std::max(damping, 1e-12) * 4;
        if (!better) continue;
        out.q = std::move(next);
        a = a_next;
      }
      if (!better) give_up(a);
    }
    return out;
  }

 private:
  struct Slopes {
    MatrixXd A;   // of the independent accelerations, by the independent coordinates
    MatrixXd dq;  // of all coordinates
  };

  // Of the independent speeds, at rest.
  VectorXd accelerations(const std::vector<double>& q) {
    std::vector<double> vdot(mechanism_.nv);
    dynamics_->set_cut_reference(cut_q_.data());
    dynamics_->set_position(q.data());
    dynamics_->factorise();
    dynamics_->set_velocity(rest_.data());
    dynamics_->solve(u_.data(), vdot.data());
    VectorXd out(static_cast<Index>(independent_.speeds.size()));
    for (Index k = 0; k < out.size(); ++k) out[k] = vdot[independent_.speeds[static_cast<std::size_t>(k)]];
    return out;
  }

  Slopes slopes(const std::vector<double>& q) {
    const auto n = static_cast<Index>(independent_.coordinates.size());
    const auto m = static_cast<Index>(independent_.speeds.size());
    Slopes out{MatrixXd(m, n), MatrixXd(mechanism_.nq, n)};
    tangent_.stand(q.data(), rest_.data(), u_.data(), cut_q_.data(), targets_);
    for (Index first = 0; first < n; first += dual_directions) {
      const Index width = std::min<Index>(dual_directions, n - first);
      MatrixXd dq(mechanism_.nq, width);
      for (Index k = 0; k < width; ++k) {
        VectorXd z = VectorXd::Zero(mechanism_.nv);
        z[independent_.coordinates[static_cast<std::size_t>(first + k)]] = 1;
        dynamics_->rate(q.data(), z.data(), dq.col(k).data());
      }
      const Carried<Dual>& at =
          tangent_.move(dq, MatrixXd::Zero(mechanism_.nv, width), MatrixXd::Zero(static_cast<Index>(u_.size()), width));
      for (Index k = 0; k < width; ++k) {
        for (Index i = 0; i < m; ++i) {
          out.A(i, first + k) = at.vdot[independent_.speeds[static_cast<std::size_t>(i)]].slope()[k];
        }
        for (Index i = 0; i < mechanism_.nq; ++i) out.dq(i, first + k) = at.q[static_cast<std::size_t>(i)].slope()[k];
      }
    }
    return out;
  }

  std::vector<double> moved(const std::vector<double>& q, const VectorXd& dq) const {
    std::vector<double> out = q;
    for (Index i = 0; i < dq.size(); ++i) out[static_cast<std::size_t>(i)] += dq[i];
    dynamics_->normalise(out.data());
    return out;
  }

  bool close(std::vector<double>& q) {
    std::vector<double> dv(mechanism_.nv);
    for (int i = 0; i < 20; ++i) {
      dynamics_->set_position(q.data());
      double gap = 0;
      for (const double Phi : dynamics_->Phi()) gap = std::max(gap, std::abs(Phi));
      if (gap <= closed * size_) return true;
      dynamics_->factorise();
      dynamics_->correct(dynamics_->Phi().data(), dv.data());
      dynamics_->displace(q.data(), dv.data());
    }
    return false;
  }

  [[noreturn]] void give_up(const VectorXd& a) const {
    Index k = 0;
    a.cwiseAbs().maxCoeff(&k);
    throw NoEquilibrium(independent_.speeds[static_cast<std::size_t>(k)], a[k]);
  }

  const Mechanism& mechanism_;
  const Independent& independent_;
  const std::vector<double>& cut_q_;
  const std::vector<double>& u_;
  const std::vector<MotionLaw::Derivatives>& targets_;
  Tangent tangent_;
  std::unique_ptr<Dynamics> dynamics_;
  std::vector<double> rest_;  // speeds
  double size_ = 1;           // m
};

}  // namespace

Rest find_rest(const Mechanism& mechanism, const Loads& loads, const Structure& structure,
               const Independent& independent, const std::vector<double>& q, const std::vector<double>& cut_q,
               const std::vector<double>& u, const std::vector<MotionLaw::Derivatives>& targets) {
  return Finder(mechanism, loads, structure, independent, cut_q, u, targets).run(q);
}

}  // namespace gelenk
