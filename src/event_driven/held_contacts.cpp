// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/held_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact_geometry/feature_states.h"
#include "decomposition/singular_values.h"
#include "event_driven/force_margin.h"
#include "kinematics/loads.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Of the largest entry: effects that are rounding.
constexpr double no_effect = 1e-9;
// Speeds up to this are rest [natural units].
constexpr double no_speed = 1e-9;
// Iterations for friction of joints that follows the forces of contacts (ContactMotion::add_to).
constexpr int most_load_iterations = 40;
constexpr double settled_forces = 1e-13;

// The inverse of what forces along the rows N do to these, zero in directions in which they do nothing.
MatrixXd inverse_response(const ContactEquations::RowMatrix& N, const ContactEquations::RowMatrix& Z) {
  MatrixXd G = N.lazyProduct(Z);
  for (Index i = 0; i < G.rows(); ++i) {
    // What locked joints or constraint equations do not permit to move has a response that is rounding.
    if (std::abs(G(i, i)) > 1e-12 * N.row(i).norm() * Z.col(i).norm()) continue;
    G.row(i).setZero();
    G.col(i).setZero();
  }
  const SingularValues found(G);
  const Index rank = found.rank(redundancy);
  return found.V.leftCols(rank) * found.sigma.head(rank).cwiseInverse().asDiagonal() *
         found.U.leftCols(rank).transpose();
}

Vector3<Dual> dual(const Vector3d& x) { return x.cast<Dual>(); }

void put(const Dual& from, Index row, MatrixXd& to) {
  to.row(row) = from.derivatives().head(to.cols()).matrix().transpose();
}

}  // namespace

HeldContacts::HeldContacts(const Mechanism& mechanism, Dynamics& dynamics, const Loads& loads)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      loads_(loads),
      laws_(loads.contacts),
      equations_(mechanism, dynamics, laws_, true),
      least_norm_(redundancy) {}

void HeldContacts::hold(const ContactHold& how) {
  laws_ = loads_.contacts;
  for (ContactLaw& law : laws_) {
    if (how.without_friction) law.sliding_friction = law.static_friction = law.rolling = law.spinning = 0;
  }
  const auto all = static_cast<std::size_t>(equations_.candidates().count());
  equations_.set_modes(how.modes.empty() ? std::vector<CandidateMode>(all) : how.modes);
}

void HeldContacts::set_point(const double* v, const double* u, double* vdot) {
  const auto apply_present = [&] {
    wrenches_.assign(mechanism_.links.size(), Spatial::Force{});
    add_wrenches(equations_, equations_.forces_of(equations_.last_solution().x), wrenches_);
    dynamics_.switching_forces().contact_rows().apply_forces(wrenches_.data(), nullptr);
    dynamics_.solve(u, vdot);
  };
  equations_.accelerate(vdot);
  apply_present();
  LoadDependence& loads = dynamics_.switching_forces().loads();
  double change = loads.empty() ? 0 : INFINITY;
  for (int k = 0; k < most_load_iterations && change > settled_forces; ++k) {
    change = equations_.accelerate(vdot, true);
    apply_present();
  }
  const ContactEquations::Rows& rows = equations_.rows();
  const ContactEquations::Solution solved = equations_.last_solution();
  R_ = rows.R;
  x_ = solved.x;
  B_ = rows.R;
  for (std::size_t i = 0; i < rows.entries.size() && rows.any_moves(); ++i)
    B_.row(rows.entries[i].first) += rows.D.row(static_cast<Index>(i));
  const double fastest = Eigen::Map<const VectorXd>(v, mechanism_.nv).cwiseAbs().maxCoeff();
  closing_ = rows.R;
  if (!(fastest <= no_speed) || !rows.demanded.isZero(0)) {
    closing_.resize(static_cast<Index>(rows.entries.size()), mechanism_.nv);
    for (std::size_t i = 0; i < rows.entries.size(); ++i)
      closing_.row(static_cast<Index>(i)) = rows.R.row(rows.entries[i].first);
  }
  equations_.respond(closing_, closing_responses_);
  closing_inverse_ = inverse_response(closing_, closing_responses_);
  equations_.respond(R_, stopping_responses_);
  stopping_inverse_ = inverse_response(R_, stopping_responses_);
  find_redundant_forces();
}

void HeldContacts::withdraw() { dynamics_.switching_forces().contact_rows().apply_forces(nullptr, nullptr); }

void HeldContacts::close(MatrixXd& displacements) const {
  displacements -= closing_responses_ * (closing_inverse_ * (closing_ * displacements));
}

void HeldContacts::stop(const MatrixXd& kept, MatrixXd& dv) const {
  dv -= stopping_responses_ * (stopping_inverse_ * kept);
}

// What a closed candidate keeps and exerts.
template <class T>
struct HeldContacts::Placed {
  using Motion = typename SpatialAlgebra<T>::Motion;

  CandidateStateOf<T> at;
  Motion V, A;                      // of the tip's link relative to the core's, about the root frame
  std::array<Vector3<T>, 2> along;  // tangential axes
  Vector3<T> belt, belt_rate;
  const ContactEquations::Entry& entry;
  const ContactCandidate& candidate;

  // Of component k of a group.
  Vector3<T> axis(int group, int k) const {
    if (group == 1) return at.n;
    if (entry.kept(group) == 3) return Vector3<T>(entry.axis(group, k).template cast<T>());
    return along[static_cast<std::size_t>(k)];
  }
  Vector3<T> velocity() const { return V.v + V.w.cross(at.p) + belt; }
  // The components of `kept` along the rows of a group, if it has any.
  void put_kept(int group, const Vector3<T>& kept, MatrixXd& out) const {
    const int first = entry.rows[static_cast<std::size_t>(group)];
    for (int k = 0; first >= 0 && k < entry.kept(group); ++k) put(axis(group, k).dot(kept), first + k, out);
  }
  Vector3<T> slip(int group) const {
    Vector3<T> of = candidate.group_turns(group) ? V.w : velocity();
    if (entry.kept(group) == 3) return of;
    const Vector3<T> normal = of.dot(at.n) * at.n;
    return group == 1 ? normal : Vector3<T>(of - normal);
  }
};

// accelerates: with accelerations.
template <class T>
HeldContacts::Placed<T> HeldContacts::placed(const ResidualEvaluator<T>& of, const ContactEquations::Entry& entry,
                                             bool accelerates) const {
  const ContactCandidate& candidate = equations_.candidates()[entry.candidate];
  using Motion = typename SpatialAlgebra<T>::Motion;
  features::PairMotion<T> motion;
  Motion A_tip, A_core;
  const auto read = [&](int link, auto& X, Motion& V, Motion& A) {
    if (link == 0) return;
    X = of.link_pose(link);
    V = X.to_parent(of.link_velocity(link));
    if (accelerates) A = X.to_parent(of.link_acceleration(link));
  };
  read(candidate.tip_link, motion.tip, motion.V_tip, A_tip);
  read(candidate.core_link, motion.core, motion.V_core, A_core);
  const typename features::PairMotion<T>::Pose X_LS{candidate.X_LS.R.template cast<T>(),
                                                    candidate.X_LS.p.template cast<T>()};
  motion.S = motion.core * X_LS;
  Placed<T> out{.at = features::state(candidate, motion),
                .V = motion.V_tip - motion.V_core,
                .A = A_tip - A_core,
                .along = {},
                .belt = Vector3<T>::Zero(),
                .belt_rate = Vector3<T>::Zero(),
                .entry = entry,
                .candidate = candidate};
  // They remain perpendicular to the normal.
  for (Index k = 0; k < 2; ++k) {
    const Vector3<T> axis = entry.axes.col(1 + k).template cast<T>();
    out.along[static_cast<std::size_t>(k)] = axis - axis.dot(out.at.n) * out.at.n;
  }
  const Vector3d& belt = equations_.law(entry.candidate).belt_velocity;
  if (belt.isZero(0)) return out;
  const bool of_tip = candidate.sign > 0;
  const Vector3d in_link = candidate.sign * (candidate.R_belt * belt);
  out.belt = (of_tip ? motion.tip : motion.core).R * Vector3<T>(in_link.template cast<T>());
  out.belt_rate = (of_tip ? motion.V_tip : motion.V_core).w.cross(out.belt);
  return out;
}

MatrixXd HeldContacts::kept_speeds(const ResidualEvaluator<Dual>& of, Index directions) {
  MatrixXd out(R_.rows(), directions);
  for (const ContactEquations::Entry& entry : equations_.rows().entries) {
    const Placed<Dual> here = placed(of, entry, false);
    const Vector3<Dual> velocity = here.velocity();
    const Vector3<Dual> along_normal = here.candidate.turns() ? here.V.w : Vector3<Dual>(velocity - here.belt);
    put(entry.is_given ? Dual(0) : here.at.n.dot(along_normal), entry.first, out);
    for (int group = 0; group < contact_groups; ++group) {
      const Vector3<Dual>& kept = here.candidate.group_turns(group) ? here.V.w : velocity;
      here.put_kept(group, kept, out);
    }
  }
  return out;
}

MatrixXd HeldContacts::kept_accelerations(const ResidualEvaluator<Dual>& of, Index directions) {
  MatrixXd out(R_.rows(), directions);
  for (const ContactEquations::Entry& entry : equations_.rows().entries) {
    const Placed<Dual> here = placed(of, entry, true);
    const Vector3<Dual>& n = here.at.n;
    const Vector3<Dual> at_point = here.A.v + here.A.w.cross(here.at.p) + here.V.w.cross(here.at.p_dot);
    const Dual turning = n.dot(here.A.w) + here.at.n_dot.dot(here.V.w);
    const Dual along_normal = here.candidate.turns()
                                  ? turning
                                  : n.dot(at_point) + here.at.n_dot.dot(Vector3<Dual>(here.velocity() - here.belt));
    put(entry.is_given ? Dual(0) : along_normal, entry.first, out);
    const Vector3<Dual> with_belt = at_point + here.belt_rate - here.belt.dot(n) * here.at.n_dot;
    here.put_kept(0, here.candidate.group_turns(0) ? here.A.w : with_belt, out);
    here.put_kept(2, here.A.w, out);
    if (entry.rows[1] >= 0) put(turning, entry.rows[1], out);
  }
  return out;
}

HeldContacts::Exerted<Dual> HeldContacts::exerted(const ContactEquations::Entry& entry, const Placed<Dual>& here,
                                                  const MatrixXd& dx) const {
  const auto multiplier = [&](Index row) {
    Dual out(x_[row]);
    out.derivatives().head(dx.cols()) = dx.row(row).transpose().array();
    return out;
  };
  const Dual normal = multiplier(entry.first);
  Exerted<Dual> out{Vector3<Dual>::Zero(), Vector3<Dual>::Zero()};
  if (!entry.is_given) (here.candidate.turns() ? out.moment : out.force) = normal * here.at.n;
  for (int group = 0; group < contact_groups; ++group) {
    const auto g = static_cast<std::size_t>(group);
    Vector3<Dual>& on = here.candidate.group_turns(group) ? out.moment : out.force;
    for (int k = 0; entry.rows[g] >= 0 && k < entry.kept(group); ++k)
      on += multiplier(entry.rows[g] + k) * here.axis(group, k);
    if (entry.moving[g] < 0) continue;
    Vector3<Dual> direction = dual(entry.along[g]);
    if (entry.slip[g].norm() > rest_speed) {
      const Vector3<Dual> slip = here.slip(group);
      direction = slip / features::length(slip);
    }
    on -= Dual(equations_.coefficient(entry.candidate, group, true)) * normal * direction;
  }
  return out;
}

// Of other multipliers.
HeldContacts::Exerted<double> HeldContacts::exerted(const ContactEquations::Entry& entry, const VectorXd& x) const {
  const double normal = x[entry.first];
  Exerted<double> out{Vector3d::Zero(), Vector3d::Zero()};
  const ContactCandidate& candidate = equations_.candidates()[entry.candidate];
  if (!entry.is_given) (candidate.turns() ? out.moment : out.force) = normal * entry.at.n;
  for (int group = 0; group < contact_groups; ++group) {
    const auto g = static_cast<std::size_t>(group);
    Vector3d& on = candidate.group_turns(group) ? out.moment : out.force;
    for (int k = 0; entry.rows[g] >= 0 && k < entry.kept(group); ++k) on += x[entry.rows[g] + k] * entry.axis(group, k);
    if (entry.moving[g] >= 0) on -= equations_.coefficient(entry.candidate, group, true) * normal * entry.along[g];
  }
  return out;
}

// The links and the contacts of the scene of which the sum of forces is redundant.
void HeldContacts::find_redundant_forces() {
  redundant_ = redundant_multipliers(equations_.last_solution().G);
  redundant_links_.assign(mechanism_.links.size(), false);
  redundant_contacts_.assign(laws_.size(), false);
  for (Index k = 0; k < redundant_.cols(); ++k) {
    std::vector<Spatial::Force> on_links(mechanism_.links.size());
    std::vector<Vector3d> of_contacts(laws_.size(), Vector3d::Zero());
    for (const ContactEquations::Entry& entry : equations_.rows().entries) {
      const ContactCandidate& candidate = equations_.candidates()[entry.candidate];
      const Exerted<double> on = exerted(entry, redundant_.col(k));
      const Spatial::Force wrench{on.moment + entry.at.p.cross(on.force), on.force};
      on_links[static_cast<std::size_t>(candidate.tip_link)] += wrench;
      on_links[static_cast<std::size_t>(candidate.core_link)] -= wrench;
      of_contacts[static_cast<std::size_t>(candidate.contact)] +=
          candidate.sign * (candidate.turns() ? on.moment : on.force);
    }
    for (std::size_t i = 1; i < on_links.size(); ++i) {
      const double size = std::max(on_links[i].f.cwiseAbs().maxCoeff(), on_links[i].n.cwiseAbs().maxCoeff());
      redundant_links_[i] = redundant_links_[i] || size > no_effect;
    }
    for (std::size_t i = 0; i < of_contacts.size(); ++i)
      redundant_contacts_[i] = redundant_contacts_[i] || of_contacts[i].cwiseAbs().maxCoeff() > no_effect;
  }
}

void HeldContacts::apply(ResidualEvaluator<Dual>& of, const MatrixXd& dx, bool shows_redundant) {
  using Force = typename SpatialAlgebra<Dual>::Force;
  dual_wrenches_.assign(mechanism_.links.size(), Force{});
  forces_.assign(laws_.size(), Vector3<Dual>::Zero());
  for (const ContactEquations::Entry& entry : equations_.rows().entries) {
    const Placed<Dual> here = placed(of, entry, false);
    const ContactCandidate& candidate = equations_.candidates()[entry.candidate];
    const Exerted<Dual> on = exerted(entry, here, dx);
    const Force wrench{on.moment + here.at.p.cross(on.force), on.force};
    dual_wrenches_[static_cast<std::size_t>(candidate.tip_link)] += wrench;
    dual_wrenches_[static_cast<std::size_t>(candidate.core_link)] -= wrench;
    forces_[static_cast<std::size_t>(candidate.contact)] -=
        Dual(candidate.sign) * (candidate.turns() ? on.moment : on.force);
  }
  const auto undetermine = [](Vector3<Dual>& x) {
    for (Dual& component : x) component.derivatives().setConstant(std::numeric_limits<double>::quiet_NaN());
  };
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    if (redundant_contacts_[i]) undetermine(forces_[i]);
  }
  for (std::size_t i = 0; i < dual_wrenches_.size() && shows_redundant; ++i) {
    if (!redundant_links_[i]) continue;
    undetermine(dual_wrenches_[i].f);
    undetermine(dual_wrenches_[i].n);
  }
  of.apply_forces(dual_wrenches_.data());
}

VectorXd HeldContacts::change_of_forces(const VectorXd& a, const VectorXd& kept) {
  const ContactEquations::Solution solved = equations_.last_solution();
  VectorXd right = -kept - R_ * a;
  for (Index i = 0; i < right.size(); ++i) {
    if (solved.G(i, i) == 0) right[i] = 0;  // blocked by joints (drop_blocked)
  }
  VectorXd out;
  least_norm_.solve_weighted(solved.G, right, solved.weights, out);
  return out;
}

int HeldContacts::contact_of(const VectorXd& redundant) const {
  const auto presses = [&](const ContactEquations::Entry& entry) {
    return std::abs(redundant[entry.first]) > no_effect * redundant.cwiseAbs().maxCoeff();
  };
  const auto& entries = equations_.rows().entries;
  const auto entry = std::ranges::find_if(entries, presses);
  return equations_.candidates()[(entry == entries.end() ? entries.front() : *entry).candidate].contact;
}

int HeldContacts::ambiguous_contact() const {
  const ContactEquations::RowMatrix& Z = equations_.last_solution().responses;
  if (redundant_.cols() == 0) return -1;
  const MatrixXd effect = Z * redundant_;
  if (!(effect.cwiseAbs().maxCoeff() > no_effect * Z.cwiseAbs().maxCoeff())) return -1;
  for (const ContactEquations::Entry& entry : equations_.rows().entries) {
    if (entry.any_moves() && redundant_.row(entry.first).cwiseAbs().maxCoeff() > no_effect)
      return equations_.candidates()[entry.candidate].contact;
  }
  return -1;
}

}  // namespace gelenk
