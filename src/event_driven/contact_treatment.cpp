// SPDX-License-Identifier: BSD-3-Clause
// What contacts do where derivatives are taken: the part of ContactModes for linear models and sensitivities.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "decomposition/singular_values.h"
#include "event_driven/contact_modes.h"
#include "event_driven/force_margin.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::Map;
using Eigen::VectorXd;

// Of the sum of normal forces: forces this close to the end of their law are at it.
constexpr double edge_fraction = 1e-9;
// Accelerations [natural units], relative to the largest, that are rounding.
constexpr double acceleration_rounding = 1e-9;

// What else constrains the mechanism so that a closed contact has no derivatives.
std::optional<LawEdge::Of> obstacle_beside(const std::vector<CoordinateRow>& rows, bool at_rest) {
  if (std::ranges::any_of(rows, &CoordinateRow::has_losses)) return LawEdge::Of::losses;
  if (at_rest && !std::ranges::all_of(rows, &CoordinateRow::holds_position)) return LawEdge::Of::prescribed_speed;
  return {};
}

// Without a normal force there is no friction either.
LawEdge::Of edge_by(double normal_force, double least) {
  return normal_force > least ? LawEdge::Of::friction : LawEdge::Of::normal_force;
}

bool sticks_on_face(const ContactEquations::Entry& entry, const ContactCandidate& of) {
  return entry.rows[0] >= 0 && of.kind == ContactCandidate::Kind::corner;
}

}  // namespace

ContactHold ContactModes::held(FrictionTreatment friction) const {
  ContactHold out{.modes = contact_equations_.modes(), .without_friction = friction == FrictionTreatment::off};
  for (CandidateMode& mode : out.modes) {
    for (CandidateMode::Group& group : mode.groups) {
      if (!mode.closed) continue;
      if (friction == FrictionTreatment::locked) group = {};
      // Without a direction it has no force.
      if (friction == FrictionTreatment::sliding && !group.moves) group = {.moves = true};
    }
  }
  return out;
}

LawEdge ContactModes::edge(double t, const double* y) {
  if (!any()) return {};
  equations_.accelerations_at(t, y, vdot_.data());
  const double rest = slow(y + mechanism_.nq);
  if (LawEdge out = edge_of_closed(rest); out.contact >= 0) return out;
  go_to(y);
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    if (mode_of(i).closed || !may_touch(i)) continue;
    const double rate = contact_equations_.candidates().state(i).rate;
    if (rate > rest) continue;
    const int contact = contact_equations_.candidates()[i].contact;
    if (rate < -rest) return {contact, LawEdge::Of::impact};
    if (may_close(i)) return {contact, LawEdge::Of::normal_force};
  }
  return {};
}

// After accelerations_at(): of what is closed.
LawEdge ContactModes::edge_of_closed(double rest) {
  if (contact_equations_.closed().empty()) return {};
  const ContactEquations::Solution solved = contact_equations_.last_solution();
  const Eigen::MatrixXd redundant = redundant_multipliers(solved.G);
  // Where nothing can move, no point of contact leaves its feature, as of boxes that are stacked exactly.
  const bool nothing_moves =
      solved.G.cols() - redundant.cols() == mechanism_.nv - dynamics_.rank() &&
      std::ranges::all_of(contact_equations_.rows().entries, &ContactEquations::Entry::is_at_rest);
  std::vector<ForceCone> cones;
  std::vector<int> contacts;
  double sum = 0;
  for (const ContactEquations::Entry& entry : contact_equations_.rows().entries) {
    const int contact = contact_equations_.candidates()[entry.candidate].contact;
    if (std::abs(entry.at.rate) > rest) return {contact, LawEdge::Of::impact};
    if (const auto of = obstacle_beside(mechanism_.coordinate_rows, entry.is_at_rest())) return {contact, *of};
    sum += std::abs(solved.x[entry.first]);
    if (!entry.is_given) {
      cones.push_back({.normal = entry.first});
      contacts.push_back(contact);
    }
    for (int group = 0; group < contact_groups; ++group) {
      const auto g = static_cast<std::size_t>(group);
      if (entry.moving[g] >= 0 && entry.slip[g].norm() <= rest) return {contact, LawEdge::Of::friction};
      if (entry.rows[g] < 0) continue;
      cones.push_back({entry.first, entry.rows[g], entry.kept(group),
                       contact_equations_.coefficient(entry.candidate, group, false)});
      contacts.push_back(contact);
    }
    const bool may_leave = !nothing_moves && !sticks_on_face(entry, contact_equations_.candidates()[entry.candidate]);
    if (may_leave && contact_equations_.candidates().margin(entry.candidate) <= touch_tolerance)
      return {contact, LawEdge::Of::feature};
  }
  if (cones.empty()) return {};
  const ForceMargin least = force_margin(solved.x, redundant, cones, edge_fraction * sum);
  if (least.margin >= edge_fraction * sum && sum > 0) return {};
  return {contacts[least.cone], edge_by(least.x[cones[least.cone].normal], edge_fraction * sum)};
}

// After accelerations_at() and go_to(): whether a candidate that touches without a force does not leave, and would have
// one after a change of the state.
bool ContactModes::may_close(int candidate) {
  ContactEquations::Rows& rows = updated_rows_;
  const int only[] = {candidate};
  contact_equations_.build(only, contact_equations_.modes(), true, rows);
  const Eigen::RowVectorXd n = rows.R.row(0);
  const Map<const VectorXd> a(vdot_.data(), mechanism_.nv);
  const double leaving = n * a + rows.rates[0];
  const double size = 1 + a.cwiseAbs().maxCoeff();
  if (leaving > acceleration_rounding * size) return false;
  // What the others keep may permit it no motion.
  ContactEquations::RowMatrix N = n;
  ContactEquations::RowMatrix Z;
  contact_equations_.respond(N, Z);
  const double free = (N * Z)(0, 0);
  if (contact_equations_.closed().empty()) return free > redundancy * n.squaredNorm();
  contact_equations_.build(contact_equations_.closed(), contact_equations_.modes(), true, rows);
  ContactEquations::RowMatrix Z_R;
  contact_equations_.respond(rows.R, Z_R);
  const Eigen::MatrixXd G = rows.R * Z_R;
  const SingularValues found(G);
  const VectorXd x = found.solve(rows.R * Z, found.rank(redundancy));
  const double left = free - (N * Z_R * x)(0, 0);
  return left > acceleration_rounding * free;
}

}  // namespace gelenk
