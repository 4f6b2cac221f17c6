// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/assembly_problem.h"

#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<int> not_fixed(const std::vector<bool>& fixed) {
  std::vector<int> out;
  for (int k = 0; k < static_cast<int>(fixed.size()); ++k) {
    if (!fixed[k]) out.push_back(k);
  }
  return out;
}

// Difference of two coordinates of one joint as a displacement along its speeds, in user's or our signs alike:
// plain coordinates subtract; a quaternion gives the rotation vector, in M, from q0 to q.
void difference(int nq, int nv, const double* q, const double* q0, double* out) {
  const int plain = nq > nv ? nq - 4 : nq;
  for (int i = 0; i < plain; ++i) out[i] = q[i] - q0[i];
  if (nq == nv) return;
  const Eigen::Quaterniond Q(q[plain + 3], q[plain], q[plain + 1], q[plain + 2]);
  const Eigen::Quaterniond Q0(q0[plain + 3], q0[plain], q0[plain + 1], q0[plain + 2]);
  const Eigen::Vector3d turn = rotation_vector((Q0.inverse() * Q).toRotationMatrix());
  for (int i = 0; i < 3; ++i) out[plain + i] = turn[i];
}

double largest_given(const Wishes& wishes, const VectorXd& offset) {
  double out = 0;
  for (Eigen::Index k = 0; k < offset.size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (wishes.q_given[i] && !wishes.q_fixed[i]) out = std::max(out, std::abs(offset[k]));
  }
  return out;
}

MatrixXd columns(const MatrixXd& all, const std::vector<int>& chosen) {
  MatrixXd out(all.rows(), static_cast<Eigen::Index>(chosen.size()));
  for (Eigen::Index k = 0; k < out.cols(); ++k) out.col(k) = all.col(chosen[static_cast<std::size_t>(k)]);
  return out;
}

// Rows of `all` whose flag is set, appended below `top`.
void append_rows(MatrixXd& top, const MatrixXd& all, const std::vector<bool>& chosen) {
  for (int k = 0; k < static_cast<int>(chosen.size()); ++k) {
    if (!chosen[k]) continue;
    top.conservativeResize(top.rows() + 1, all.cols());
    top.row(top.rows() - 1) = all.row(k);
  }
}

void append(VectorXd& top, const VectorXd& all, const std::vector<bool>& chosen) {
  for (int k = 0; k < static_cast<int>(chosen.size()); ++k) {
    if (!chosen[k]) continue;
    top.conservativeResize(top.size() + 1);
    top[top.size() - 1] = all[k];
  }
}

}  // namespace

AssemblyProblem::AssemblyProblem(const Mechanism& mechanism, Dynamics& dynamics, const Wishes& tree, const Wishes& cuts)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      tree_(tree),
      cuts_(cuts),
      free_q_(not_fixed(tree.q_fixed)),
      free_v_(not_fixed(tree.v_fixed)),
      turns_(tree.turns) {
  const auto any = [](const std::vector<bool>& flags) { return std::ranges::find(flags, true) != flags.end(); };
  const auto some = [](const std::vector<double>& w) { return std::ranges::any_of(w, [](double x) { return x > 0; }); };
  for (const CoordinateRow& row : mechanism.coordinate_rows) {
    for (const CoordinateRow::Term& term : row.terms) {
      if (row.holds_position) turns_[term.v] = false;
    }
  }
  cuts_fixed_ = any(cuts.q_fixed);
  cut_wishes_ = cuts_fixed_ || any(cuts.v_fixed) || some(cuts.q_weight) || some(cuts.v_weight);
  const std::vector<bool> holds = mechanism.position_rows();
  for (int r = 0; r < mechanism.rows; ++r) {
    if (holds[r]) position_rows_.push_back(r);
  }
  for (const Link& link : mechanism.links) span_ = std::max(span_, link.X_PJ.p.norm());
  length_ = std::max(length_, span_);
  for (const Cut& cut : mechanism.cuts) span_ = std::max({span_, cut.X_AF.p.norm(), cut.X_BM.p.norm()});
  span_ = span_ > 0 ? 1.5 * span_ : 1;  // slides and flights reach somewhat beyond
}

VectorXd AssemblyProblem::gap(const std::vector<double>& q) {
  dynamics_.set_position(q.data());
  const auto& Phi = dynamics_.Phi();
  VectorXd g(static_cast<Eigen::Index>(position_rows_.size()));
  for (Eigen::Index r = 0; r < g.size(); ++r) g[r] = Phi[position_rows_[static_cast<std::size_t>(r)]];
  if (cuts_fixed_) append(g, cut_offset(q), cuts_.q_fixed);
  return g;
}

// The rows of the loops at q. Those that forbid nothing there are 0, not the rounding that is left of them: taken for
// rows it would hold still what can move.
MatrixXd AssemblyProblem::rows_at(const std::vector<double>& q) {
  dynamics_.set_position(q.data());
  dynamics_.factorise();
  MatrixXd G = dynamics_.J();
  for (Eigen::Index r = 0; r < G.rows() && G.cols() > 0; ++r) {
    if (G.row(r).lpNorm<Eigen::Infinity>() < 1e-12 * length_) G.row(r).setZero();
  }
  return G;
}

MatrixXd AssemblyProblem::gap_jacobian(const std::vector<double>& q) {
  MatrixXd G = rows_at(q)(position_rows_, Eigen::all);
  if (cuts_fixed_) append_rows(G, cut_columns(q), cuts_.q_fixed);
  return columns(G, free_q_);
}

VectorXd AssemblyProblem::distance(const std::vector<double>& q) {
  const VectorXd tree = tree_offset(q);
  VectorXd d(mechanism_.nv + (cut_wishes_ ? mechanism_.cut_nv : 0));
  for (int k = 0; k < mechanism_.nv; ++k) d[k] = std::sqrt(tree_.q_weight[k]) * tree[k];
  if (!cut_wishes_) return d;
  const VectorXd cut = cut_offset(q);
  for (int k = 0; k < mechanism_.cut_nv; ++k) d[mechanism_.nv + k] = std::sqrt(cuts_.q_weight[k]) * cut[k];
  return d;
}

MatrixXd AssemblyProblem::distance_jacobian(const std::vector<double>& q) {
  const int rows = mechanism_.nv + (cut_wishes_ ? mechanism_.cut_nv : 0);
  MatrixXd T = MatrixXd::Zero(rows, mechanism_.nv);
  for (int k = 0; k < mechanism_.nv; ++k) T(k, k) = std::sqrt(tree_.q_weight[k]);
  if (cut_wishes_) {
    const MatrixXd& C = cut_columns(q);
    for (int k = 0; k < mechanism_.cut_nv; ++k) T.row(mechanism_.nv + k) = std::sqrt(cuts_.q_weight[k]) * C.row(k);
  }
  return columns(T, free_q_);
}

AssemblyProblem::Speeds AssemblyProblem::speeds(const std::vector<double>& q) {
  const int nv = mechanism_.nv;
  Speeds out;
  out.v.assign(nv, 0);
  VectorXd fixed = VectorXd::Zero(nv);
  for (int k = 0; k < nv; ++k) {
    if (tree_.v_fixed[k]) fixed[k] = out.v[k] = tree_.v[k];
  }
  MatrixXd G = rows_at(q);
  MatrixXd T = MatrixXd::Zero(nv, nv);
  out.d0.resize(nv);
  for (int k = 0; k < nv; ++k) {
    const double root = std::sqrt(tree_.v_weight[k]);
    T(k, k) = root;
    out.d0[k] = root * (fixed[k] - tree_.v[k]);
  }
  dynamics_.set_velocity(fixed.data());
  const std::vector<double>& rates = dynamics_.row_rates();
  out.g0 = Eigen::Map<const VectorXd>(rates.data(), static_cast<Eigen::Index>(rates.size()));
  if (cut_wishes_) {
    const MatrixXd& C = cut_columns(q);
    const VectorXd offset = C * fixed - Eigen::Map<const VectorXd>(cuts_.v.data(), mechanism_.cut_nv);
    append_rows(G, C, cuts_.v_fixed);
    append(out.g0, offset, cuts_.v_fixed);
    T.conservativeResize(nv + mechanism_.cut_nv, nv);
    out.d0.conservativeResize(nv + mechanism_.cut_nv);
    for (int k = 0; k < mechanism_.cut_nv; ++k) {
      const double root = std::sqrt(cuts_.v_weight[k]);
      T.row(nv + k) = root * C.row(k);
      out.d0[nv + k] = root * offset[k];
    }
  }
  out.G = columns(G, free_v_);
  out.T = columns(T, free_v_);
  return out;
}

std::vector<double> AssemblyProblem::displaced(const std::vector<double>& q, const VectorXd& step) const {
  std::vector<double> dv(mechanism_.nv, 0);
  for (std::size_t k = 0; k < free_q_.size(); ++k) dv[free_q_[k]] = step[static_cast<Eigen::Index>(k)];
  std::vector<double> out = q;
  dynamics_.displace(out.data(), dv.data());
  return out;
}

void AssemblyProblem::unwind(std::vector<double>& q) const {
  for (const Link& link : mechanism_.links) {
    for (int i = 0; i < link.nv; ++i) {
      const int k = link.iv + i;
      if (tree_.q_fixed[k] || !turns_[k]) continue;
      double& angle = q[link.iq + i];
      angle -= 2 * M_PI * std::round((angle - tree_.q[link.iq + i]) / (2 * M_PI));
    }
  }
}

std::vector<double> AssemblyProblem::scattered(std::mt19937& random) const {
  std::uniform_real_distribution<double> within(-1, 1);
  std::normal_distribution<double> normal;
  std::vector<double> q = tree_.q;
  for (const Link& link : mechanism_.links) {
    const int plain = link.nq > link.nv ? link.nq - 4 : link.nq;
    for (int i = 0; i < plain; ++i) {
      if (!tree_.q_fixed[link.iv + i]) q[link.iq + i] = within(random) * (tree_.turns[link.iv + i] ? M_PI : span_);
    }
    if (plain == link.nq || tree_.q_fixed[link.iv + plain]) continue;
    Eigen::Map<Eigen::Vector4d> Q(q.data() + link.iq + plain);
    do {
      for (double& x : Q) x = normal(random);
    } while (Q.norm() < 0.1);
    Q.normalize();
  }
  return q;
}

double AssemblyProblem::apart(const std::vector<double>& a, const std::vector<double>& b) const {
  double out = 0;
  double d[6];
  for (const Link& link : mechanism_.links) {
    if (link.parent < 0) continue;
    difference(link.nq, link.nv, a.data() + link.iq, b.data() + link.iq, d);
    for (int i = 0; i < link.nv; ++i) {
      out = std::max(out, std::abs(turns_[link.iv + i] ? std::remainder(d[i], 2 * M_PI) : d[i]));
    }
  }
  return out;
}

double AssemblyProblem::moved(const std::vector<double>& q) {
  const double in_tree = largest_given(tree_, tree_offset(q));
  return cut_wishes_ ? std::max(in_tree, largest_given(cuts_, cut_offset(q))) : in_tree;
}

VectorXd AssemblyProblem::tree_offset(const std::vector<double>& q) const {
  VectorXd d(mechanism_.nv);
  for (const Link& link : mechanism_.links) {
    if (link.parent < 0) continue;
    difference(link.nq, link.nv, q.data() + link.iq, tree_.q.data() + link.iq, d.data() + link.iv);
  }
  return d;
}

VectorXd AssemblyProblem::cut_offset(const std::vector<double>& q) {
  dynamics_.set_position(q.data());
  VectorXd d = VectorXd::Zero(mechanism_.cut_nv);
  for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) {
    const Cut& cut = mechanism_.cuts[c];
    if (cut.is_rod()) continue;  // no wishes there
    double found[max_cut_nq];
    std::copy_n(cuts_.q.data() + cut.iq, cut.nq, found);
    dynamics_.cut_coordinates(c, found);
    difference(cut.nq, cut.nv, found, cuts_.q.data() + cut.iq, d.data() + cut.iv);
    for (int i = 0; i < cut.nv && cut.nq == cut.nv; ++i) {
      // A cut joint's angle is known within a turn.
      if (cut.turns[i]) d[cut.iv + i] = std::remainder(d[cut.iv + i], 2 * M_PI);
    }
  }
  return d;
}

const MatrixXd& AssemblyProblem::cut_columns(const std::vector<double>& q) {
  dynamics_.set_position(q.data());
  C_.resize(mechanism_.cut_nv, mechanism_.nv);
  std::vector<double> unit(mechanism_.nv, 0);
  for (int k = 0; k < mechanism_.nv; ++k) {
    unit[k] = 1;
    dynamics_.set_velocity(unit.data());
    for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) {
      dynamics_.cut_speeds(c, C_.col(k).data() + mechanism_.cuts[c].iv);
    }
    unit[k] = 0;
  }
  return C_;
}

}  // namespace gelenk
