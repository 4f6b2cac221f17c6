// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/shared_loads_of_contacts.h"

#include <algorithm>
#include <cmath>

#include "contact_geometry/contact_finder.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool any_is_held(SwitchingForces& forces) {
  return std::ranges::any_of(forces.holding_forces().values(), [](double x) { return x != 0; });
}

// Whether closed contacts have redundant forces.
bool are_redundant(const ContactEquations& equations) {
  if (equations.closed().empty()) return false;
  if (!equations.are_unique()) return true;
  for (std::size_t i = 0; i < equations.closed().size(); ++i) {
    if (is_blocked(equations, i)) return true;
  }
  return false;
}

SharedLoads::Point point_of(const ContactEquations& equations, const ContactEquations::Entry& entry) {
  return {.contact = equations.candidates()[entry.candidate].contact,
          .normal = entry.first,
          .first = std::max(entry.rows[0], 0),
          .size = entry.rows[0] >= 0 ? entry.kept(0) : 0,
          .coefficient = equations.coefficient(entry.candidate, 0, false),
          .slides = entry.any_moves()};
}

// The forces of all locks, in columns, that generalized ones cause.
MatrixXd holding_forces_of(const MatrixXd& generalized, const Mechanism& mechanism, Dynamics& dynamics) {
  std::vector<double> right(static_cast<std::size_t>(std::max(1, mechanism.rows)));
  std::vector<double> found(static_cast<std::size_t>(dynamics.switching_forces().locks()));
  MatrixXd out(static_cast<Index>(found.size()), generalized.cols());
  for (Index k = 0; k < generalized.cols(); ++k) {
    VectorXd force = generalized.col(k);
    std::ranges::fill(right, 0.0);
    std::ranges::fill(found, 0.0);
    dynamics.solve_linear(force.data(), right.data(), nullptr, found.data());
    out.col(k) = Eigen::Map<const VectorXd>(found.data(), out.rows());
  }
  return out;
}

// With the locks and their present forces, but no points and no multipliers.
SharedLoads begin(SwitchingForces& forces) {
  SharedLoads out;
  for (int i = 0; i < forces.locks(); ++i) {
    out.locks.push_back(i);
    out.may.push_back(largest_holding_forces(forces, i));
  }
  const std::vector<double>& held = forces.holding_forces().values();
  out.held = Eigen::Map<const VectorXd>(held.data(), static_cast<Index>(held.size()));
  return out;
}

std::optional<SharedLoad> shared_by_closed(const ContactEquations& equations, const Mechanism& mechanism,
                                           Dynamics& dynamics) {
  if (!are_redundant(equations)) return std::nullopt;
  SharedLoads of = begin(dynamics.switching_forces());
  const ContactEquations::Rows& rows = equations.rows();
  const ContactEquations::Solution solved = equations.last_solution();
  for (const ContactEquations::Entry& entry : rows.entries) {
    if (!entry.is_given) of.points.push_back(point_of(equations, entry));
  }
  of.x = solved.x;
  of.directions = directions_without_effect(solved.G);
  of.effects = solved.responses * of.directions;
  of.largest_effect = solved.responses.cwiseAbs().maxCoeff();
  ContactEquations::RowMatrix B = rows.R;
  for (std::size_t i = 0; i < rows.entries.size() && rows.any_moves(); ++i)
    B.row(rows.entries[i].first) += rows.D.row(static_cast<Index>(i));
  of.joints = holding_forces_of(B.transpose() * of.directions, mechanism, dynamics);
  return find_shared_load(of);
}

// What touches and slides without a force is open where a joint bears all of its load.
std::vector<int> touching_without_force(ContactEquations& equations, Dynamics& dynamics,
                                        std::vector<CandidateMode>& modes) {
  ContactCandidates& candidates = equations.candidates();
  candidates.read_motion(dynamics);
  std::vector<int> touching;
  for (int i = 0; i < candidates.count(); ++i) {
    const bool touches = candidates.is_close(i) && candidates.gap(i) <= touch_tolerance && candidates.is_near(i);
    if (!modes[static_cast<std::size_t>(i)].closed && touches && !candidates[i].is_given()) touching.push_back(i);
  }
  ContactEquations::Rows rows;
  equations.build(touching, modes, false, rows);
  std::vector<int> out;
  for (const ContactEquations::Entry& entry : rows.entries) {
    if (std::abs(entry.at.rate) > rest_speed) continue;
    CandidateMode& mode = modes[static_cast<std::size_t>(entry.candidate)];
    bool slides = false;
    for (std::size_t g = 0; g < contact_groups; ++g) {
      const double speed = entry.slip[g].norm();
      mode.groups[g].moves = entry.rows[g] >= 0 && speed > rest_speed;
      if (mode.groups[g].moves) mode.groups[g].direction = entry.slip[g] / speed;
      slides = slides || mode.groups[g].moves;
    }
    if (slides) out.push_back(entry.candidate);
  }
  return out;
}

std::optional<SharedLoad> shared_by_open(ContactEquations& equations, const Mechanism& mechanism, Dynamics& dynamics) {
  std::vector<CandidateMode> modes = equations.modes();
  const std::vector<int> touching = touching_without_force(equations, dynamics, modes);
  if (touching.empty()) return std::nullopt;
  ContactEquations::Rows rows;
  equations.build(touching, modes, true, rows);
  ContactEquations::RowMatrix B(static_cast<Index>(touching.size()), rows.R.cols());
  for (Index i = 0; i < B.rows(); ++i)
    B.row(i) = rows.R.row(rows.entries[static_cast<std::size_t>(i)].first) + rows.D.row(i);
  ContactEquations::RowMatrix Z;
  equations.respond(B, Z);
  for (Index i = 0; i < B.rows(); ++i) {
    const ContactEquations::Entry& entry = rows.entries[static_cast<std::size_t>(i)];
    const auto normal = rows.R.row(entry.first);
    if (!is_blocked(normal.dot(Z.col(i)), normal.norm(), Z.col(i).norm())) continue;
    SharedLoads of = begin(dynamics.switching_forces());
    of.points.push_back({.contact = equations.candidates()[entry.candidate].contact, .slides = true});
    of.x = VectorXd::Zero(1);
    of.directions = MatrixXd::Ones(1, 1);
    of.effects = Z.col(i);
    of.largest_effect = Z.cwiseAbs().maxCoeff();
    of.joints = holding_forces_of(B.row(i).transpose(), mechanism, dynamics);
    if (const auto found = find_shared_load(of)) return found;
  }
  return std::nullopt;
}

}  // namespace

std::optional<SharedLoad> find_shared_load(ContactEquations& equations, const Mechanism& mechanism,
                                           Dynamics& dynamics) {
  if (dynamics.switching_forces().locks() == 0 || !any_is_held(dynamics.switching_forces())) return std::nullopt;
  if (const auto found = shared_by_closed(equations, mechanism, dynamics)) return found;
  return shared_by_open(equations, mechanism, dynamics);
}

}  // namespace gelenk
