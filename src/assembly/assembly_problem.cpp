// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/assembly_problem.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "assembly/loop_groups.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;

// Of the constraint Jacobian [natural units]: a row without a larger one constrains nothing. Its rounding would count
// as a constraint and block possible motions.
constexpr double min_entry = 1e-12;

std::vector<int> not_fixed(const std::vector<bool>& fixed) {
  std::vector<int> out;
  for (int k = 0; k < static_cast<int>(fixed.size()); ++k) {
    if (!fixed[k]) out.push_back(k);
  }
  return out;
}

// Difference of two positions of one joint as a displacement along its velocities, for the user's or the mechanism's
// signs. Coordinates are subtracted; a quaternion gives the rotation vector from q0 to q, written in M.
void difference(int nq, int nv, const double* q, const double* q0, double* out) {
  const int plain = nq > nv ? nq - 4 : nq;
  for (int i = 0; i < plain; ++i) out[i] = q[i] - q0[i];
  if (nq == nv) return;
  const Eigen::Quaterniond Q(q[plain + 3], q[plain], q[plain + 1], q[plain + 2]);
  const Eigen::Quaterniond Q0(q0[plain + 3], q0[plain], q0[plain + 1], q0[plain + 2]);
  const Eigen::Vector3d turn = rotation_vector((Q0.inverse() * Q).toRotationMatrix());
  for (int i = 0; i < 3; ++i) out[plain + i] = turn[i];
}

// An angle within half a turn; other coordinates as they are.
double within_a_turn(double x, bool turns) { return turns ? std::remainder(x, 2 * std::numbers::pi) : x; }

using Entries = std::vector<Eigen::Triplet<double>>;

// Appends the rows of `all`, each times its factor, from row `first` on; if `packed`, rows with factor 0 are left out.
// Returns the number of the next row.
int add_rows(Entries& entries, int first, const SparseMatrix& all, const std::vector<double>& factors, bool packed) {
  std::vector<int> place(factors.size());
  int next = first;
  for (std::size_t r = 0; r < factors.size(); ++r) place[r] = packed && factors[r] == 0 ? -1 : next++;
  for (int k = 0; k < all.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator at(all, k); at; ++at) {
      const auto r = static_cast<std::size_t>(at.row());
      if (place[r] >= 0) entries.emplace_back(place[r], k, factors[r] * at.value());
    }
  }
  return next;
}

std::vector<double> as_factors(const std::vector<bool>& chosen) { return {chosen.begin(), chosen.end()}; }

std::vector<double> roots(const std::vector<double>& weights) {
  std::vector<double> out;
  for (const double weight : weights) out.push_back(std::sqrt(weight));
  return out;
}

// The matrix of these entries, reduced to the chosen ones of its n columns.
SparseMatrix matrix(const Entries& entries, int rows, int n, const std::vector<int>& chosen) {
  std::vector<int> place(static_cast<std::size_t>(n), -1);
  for (std::size_t k = 0; k < chosen.size(); ++k) place[static_cast<std::size_t>(chosen[k])] = static_cast<int>(k);
  Entries kept;
  for (const auto& entry : entries) {
    const int k = place[static_cast<std::size_t>(entry.col())];
    if (k >= 0) kept.emplace_back(entry.row(), k, entry.value());
  }
  SparseMatrix out(rows, static_cast<Eigen::Index>(chosen.size()));
  out.setFromTriplets(kept.begin(), kept.end());
  return out;
}

void append(VectorXd& top, const VectorXd& all, const std::vector<bool>& chosen) {
  const Eigen::Index old = top.size();
  top.conservativeResize(old + std::ranges::count(chosen, true));
  Eigen::Index next = old;
  for (int k = 0; k < static_cast<int>(chosen.size()); ++k) {
    if (chosen[k]) top[next++] = all[k];
  }
}

}  // namespace

AssemblyProblem::AssemblyProblem(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree,
                                 const InitialGuess& cuts, const std::vector<bool>* rows)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      tree_(tree),
      cuts_(cuts),
      free_q_(not_fixed(tree.q_fixed)),
      free_v_(not_fixed(tree.v_fixed)),
      turns_(tree.turns) {
  const auto any = [](const std::vector<bool>& flags) { return std::ranges::find(flags, true) != flags.end(); };
  const auto any_positive = [](const std::vector<double>& w) {
    return std::ranges::any_of(w, [](double x) { return x > 0; });
  };
  for (const CoordinateRow& row : mechanism.coordinate_rows) {
    for (const CoordinateRow::Term& term : row.terms) {
      if (row.holds_position) turns_[term.v] = false;
    }
  }
  cuts_fixed_ = any(cuts.q_fixed);
  cut_guesses_ = cuts_fixed_ || any(cuts.v_fixed) || any_positive(cuts.q_weight) || any_positive(cuts.v_weight);
  const std::vector<bool> holds = mechanism.position_rows();
  for (int r = 0; r < mechanism.rows; ++r) {
    if (holds[r] && (rows == nullptr || (*rows)[r])) position_rows_.push_back(r);
  }
  for (const Link& link : mechanism.links) span_ = std::max(span_, link.X_PJ.p.norm());
  length_ = std::max(length_, span_);
  for (const Cut& cut : mechanism.cuts) span_ = std::max({span_, cut.X_AF.p.norm(), cut.X_BM.p.norm()});
  span_ = span_ > 0 ? 1.5 * span_ : 1;
  place_.assign(static_cast<std::size_t>(mechanism.nv), -1);
  tree_weights_.resize(static_cast<Eigen::Index>(free_q_.size()));
  for (std::size_t k = 0; k < free_q_.size(); ++k) {
    place_[static_cast<std::size_t>(free_q_[k])] = static_cast<int>(k);
    tree_weights_[static_cast<Eigen::Index>(k)] = tree.q_weight[free_q_[k]];
  }
}

template <class Visit>
void AssemblyProblem::each_cut_speed(Visit visit) {
  for (int c = 0; c < static_cast<int>(mechanism_.cuts.size()); ++c) {
    const Cut& cut = mechanism_.cuts[c];
    const std::vector<int> moving = velocities_between(mechanism_, cut);
    cut_speeds_.resize(moving.size() * static_cast<std::size_t>(cut.nv));
    dynamics_.cut_speed_columns(c, cut_speeds_.data());
    const double* speed = cut_speeds_.data();
    for (const int k : moving) {
      for (int i = 0; i < cut.nv; ++i) visit(cut.iv + i, k, *speed++);
    }
  }
}

VectorXd AssemblyProblem::gap(const std::vector<double>& q) {
  dynamics_.set_position(q.data());
  const auto& Phi = dynamics_.Phi();
  VectorXd g(static_cast<Eigen::Index>(position_rows_.size()));
  for (Eigen::Index r = 0; r < g.size(); ++r) g[r] = Phi[position_rows_[static_cast<std::size_t>(r)]];
  if (cuts_fixed_) append(g, cut_offset(q), cuts_.q_fixed);
  return g;
}

// The constraint Jacobian at q. Rows that constrain nothing there are set to 0.
SparseMatrix AssemblyProblem::rows_at(const std::vector<double>& q) {
  dynamics_.set_position(q.data());
  SparseMatrix G = dynamics_.sparse_J();
  VectorXd row_max = VectorXd::Zero(G.rows());
  for (int k = 0; k < G.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator at(G, k); at; ++at)
      row_max[at.row()] = std::max(row_max[at.row()], std::abs(at.value()));
  }
  G.prune([&](Eigen::Index row, Eigen::Index, double) { return row_max[row] >= min_entry * length_; });
  return G;
}

SparseMatrix AssemblyProblem::gap_jacobian(const std::vector<double>& q) {
  const SparseMatrix J = rows_at(q);
  std::vector<double> holds(static_cast<std::size_t>(J.rows()), 0);
  for (const int r : position_rows_) holds[static_cast<std::size_t>(r)] = 1;
  Entries entries;
  int rows = add_rows(entries, 0, J, holds, true);
  if (cuts_fixed_) rows = add_rows(entries, rows, cut_columns(q), as_factors(cuts_.q_fixed), true);
  return matrix(entries, rows, mechanism_.nv, free_q_);
}

const Eigen::MatrixXd& AssemblyProblem::gap_columns(const std::vector<double>& q) {
  if (cuts_fixed_) return columns_ = Eigen::MatrixXd(gap_jacobian(q).transpose());
  dynamics_.set_position(q.data());
  const SparseRows& J = dynamics_.rows_of_J();
  columns_.setZero(static_cast<Eigen::Index>(free_q_.size()), static_cast<Eigen::Index>(position_rows_.size()));
  for (std::size_t k = 0; k < position_rows_.size(); ++k) {
    const int r = position_rows_[k];
    const double* values = J.values(r);
    const int n = J.entries(r);
    if (Eigen::Map<const VectorXd>(values, n).lpNorm<Eigen::Infinity>() < min_entry * length_) continue;
    for (int i = 0; i < n; ++i) {
      const int at = place_[static_cast<std::size_t>(J.columns(r)[i])];
      if (at >= 0) columns_(at, static_cast<Eigen::Index>(k)) = values[i];
    }
  }
  return columns_;
}

const Eigen::MatrixXd& AssemblyProblem::cut_distance_columns(const std::vector<double>& q) {
  const auto free = static_cast<Eigen::Index>(free_q_.size());
  cut_columns_.setZero(free, cut_guesses_ ? mechanism_.cut_nv : 0);
  if (!cut_guesses_) return cut_columns_;
  dynamics_.set_position(q.data());
  each_cut_speed([&](int i, int velocity, double speed) {
    const int at = place_[static_cast<std::size_t>(velocity)];
    if (at >= 0) cut_columns_(at, i) = std::sqrt(cuts_.q_weight[i]) * speed;
  });
  return cut_columns_;
}

VectorXd AssemblyProblem::distance(const std::vector<double>& q) {
  const VectorXd tree = tree_offset(q);
  VectorXd d(mechanism_.nv + (cut_guesses_ ? mechanism_.cut_nv : 0));
  for (int k = 0; k < mechanism_.nv; ++k) d[k] = std::sqrt(tree_.q_weight[k]) * tree[k];
  if (cut_guesses_) d.tail(mechanism_.cut_nv) = cut_distance(q);
  return d;
}

VectorXd AssemblyProblem::tree_distance(const std::vector<double>& q) const {
  const VectorXd tree = tree_offset(q);
  VectorXd d = tree_weights_.cwiseSqrt();
  for (std::size_t k = 0; k < free_q_.size(); ++k) d[static_cast<Eigen::Index>(k)] *= tree[free_q_[k]];
  return d;
}

VectorXd AssemblyProblem::cut_distance(const std::vector<double>& q) {
  if (!cut_guesses_) return {};
  VectorXd d = cut_offset(q);
  for (int k = 0; k < mechanism_.cut_nv; ++k) d[k] *= std::sqrt(cuts_.q_weight[k]);
  return d;
}

SparseMatrix AssemblyProblem::distance_jacobian(const std::vector<double>& q) {
  Entries entries;
  for (int k = 0; k < mechanism_.nv; ++k) entries.emplace_back(k, k, std::sqrt(tree_.q_weight[k]));
  int rows = mechanism_.nv;
  if (cut_guesses_) rows = add_rows(entries, rows, cut_columns(q), roots(cuts_.q_weight), false);
  return matrix(entries, rows, mechanism_.nv, free_q_);
}

AssemblyProblem::VelocityEquations AssemblyProblem::velocity_equations(const std::vector<double>& q) {
  const int nv = mechanism_.nv;
  VelocityEquations out;
  out.v.assign(nv, 0);
  VectorXd fixed = VectorXd::Zero(nv);
  for (int k = 0; k < nv; ++k) {
    if (tree_.v_fixed[k]) fixed[k] = out.v[k] = tree_.v[k];
  }
  const SparseMatrix J = rows_at(q);
  Entries G;
  Entries T;
  int rows = add_rows(G, 0, J, std::vector<double>(static_cast<std::size_t>(J.rows()), 1), false);
  int distances = nv;
  out.d0.resize(nv);
  for (int k = 0; k < nv; ++k) {
    const double root = std::sqrt(tree_.v_weight[k]);
    T.emplace_back(k, k, root);
    out.d0[k] = root * (fixed[k] - tree_.v[k]);
  }
  out.given = tree_.v_given;
  dynamics_.set_velocity(fixed.data());
  const std::vector<double>& rates = dynamics_.row_rates();
  out.g0 = Eigen::Map<const VectorXd>(rates.data(), static_cast<Eigen::Index>(rates.size()));
  if (cut_guesses_) {
    const SparseMatrix C = cut_columns(q);
    const VectorXd offset = C * fixed - Eigen::Map<const VectorXd>(cuts_.v.data(), mechanism_.cut_nv);
    rows = add_rows(G, rows, C, as_factors(cuts_.v_fixed), true);
    append(out.g0, offset, cuts_.v_fixed);
    distances = add_rows(T, distances, C, roots(cuts_.v_weight), false);
    out.given.insert(out.given.end(), cuts_.v_given.begin(), cuts_.v_given.end());
    out.d0.conservativeResize(distances);
    for (int k = 0; k < mechanism_.cut_nv; ++k) out.d0[nv + k] = std::sqrt(cuts_.v_weight[k]) * offset[k];
  }
  out.G = matrix(G, rows, nv, free_v_);
  out.T = matrix(T, distances, nv, free_v_);
  return out;
}

std::vector<double> AssemblyProblem::displaced(const std::vector<double>& q, const VectorXd& step) const {
  std::vector<double> dv(mechanism_.nv, 0);
  for (std::size_t k = 0; k < free_q_.size(); ++k) dv[free_q_[k]] = step[static_cast<Eigen::Index>(k)];
  std::vector<double> out = q;
  dynamics_.displace(out.data(), dv.data());
  return out;
}

bool AssemblyProblem::unwind(std::vector<double>& q) const {
  bool changed = false;
  for (const Link& link : mechanism_.links) {
    for (int i = 0; i < link.nv; ++i) {
      const int k = link.iv + i;
      if (tree_.q_fixed[k] || !turns_[k]) continue;
      double& angle = q[link.iq + i];
      const double turns = std::round((angle - tree_.q[link.iq + i]) / (2 * std::numbers::pi));
      angle -= 2 * std::numbers::pi * turns;
      changed = changed || turns != 0;
    }
  }
  return changed;
}

double AssemblyProblem::separation(const std::vector<double>& a, const std::vector<double>& b) const {
  double out = 0;
  double d[6];
  for (const Link& link : mechanism_.links) {
    if (link.parent < 0) continue;
    difference(link.nq, link.nv, a.data() + link.iq, b.data() + link.iq, d);
    for (int i = 0; i < link.nv; ++i) {
      out = std::max(out, std::abs(within_a_turn(d[i], turns_[link.iv + i])));
    }
  }
  return out;
}

template <class Visit>
void AssemblyProblem::each_change(const std::vector<double>& q, Visit visit) {
  const VectorXd tree = tree_offset(q);
  for (int k = 0; k < mechanism_.nv; ++k) visit(tree_, k, tree[k]);
  if (!cut_guesses_) return;
  const VectorXd cut = cut_offset(q);
  for (int k = 0; k < mechanism_.cut_nv; ++k) visit(cuts_, k, cut[k]);
}

AssemblyProblem::Largest AssemblyProblem::moved(const std::vector<double>& q) {
  Largest out;
  each_change(q, [&](const InitialGuess& of, int k, double change) {
    if (of.q_fixed[k]) return;
    if (of.q_given[k]) out.given = std::max(out.given, std::abs(change));
    if (of.q_weight[k] > 0) out.any = std::max(out.any, std::abs(change));
  });
  return out;
}

AssemblyProblem::Squared AssemblyProblem::squared_distance(const std::vector<double>& q) {
  Squared out;
  each_change(q, [&](const InitialGuess& of, int k, double change) {
    (of.q_given[k] ? out.given : out.other) += of.q_weight[k] * change * change;
  });
  return out;
}

AssemblyProblem::Squared AssemblyProblem::squared_tree_distance(const std::vector<double>& q) const {
  const VectorXd tree = tree_offset(q);
  Squared out;
  for (const int k : free_q_) (tree_.q_given[k] ? out.given : out.other) += tree_.q_weight[k] * tree[k] * tree[k];
  return out;
}

std::vector<double> AssemblyProblem::changes_by_rank(const std::vector<double>& q) {
  std::vector<std::pair<int, double>> ranked;
  each_change(q, [&](const InitialGuess& of, int k, double change) {
    if (of.q_weight[k] > 0 || of.q_fixed[k])
      ranked.emplace_back(of.rank[k], of.user_sign[k] * within_a_turn(change, of.turns[k]));
  });
  std::ranges::stable_sort(ranked, {}, &std::pair<int, double>::first);
  std::vector<double> out;
  for (const auto& [rank, change] : ranked) out.push_back(change);
  return out;
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
    if (cut.is_rod()) continue;  // rods have no guesses
    double found[max_cut_nq];
    std::copy_n(cuts_.q.data() + cut.iq, cut.nq, found);
    dynamics_.cut_coordinates(c, found);
    difference(cut.nq, cut.nv, found, cuts_.q.data() + cut.iq, d.data() + cut.iv);
    // A cut joint's angle is known within a turn.
    for (int i = 0; i < cut.nv && cut.nq == cut.nv; ++i) d[cut.iv + i] = within_a_turn(d[cut.iv + i], cut.is_angle[i]);
  }
  return d;
}

// Velocities of the cut joints per tree velocity, cut_nv x nv.
SparseMatrix AssemblyProblem::cut_columns(const std::vector<double>& q) {
  dynamics_.set_position(q.data());
  Entries entries;
  each_cut_speed([&](int i, int velocity, double speed) { entries.emplace_back(i, velocity, speed); });
  SparseMatrix out(mechanism_.cut_nv, mechanism_.nv);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

}  // namespace gelenk
