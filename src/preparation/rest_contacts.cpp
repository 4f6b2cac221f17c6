// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/rest_contacts.h"

#include <algorithm>

#include "contact_geometry/contact_finder.h"
#include "event_driven/contact_equations.h"
#include "event_driven/force_margin.h"
#include "kinematics/loads.h"
#include "mechanism/mechanism.h"
#include "scene/touching_laws.h"

namespace gelenk {
namespace {

// Of the largest force: what an evaluation may miss of a law.
constexpr double law_rounding = 1e-10;

std::string name_of_body(const Scene& scene, int body) {
  return body < 0 ? std::string("ground") : scene.bodies[static_cast<std::size_t>(body)].name;
}

// Those with the core and with the tip.
std::pair<int, int> bodies_of(const Mechanism& mechanism, const ContactCandidate& candidate) {
  if (candidate.has_shapes()) {
    const auto& shapes = mechanism.shapes;
    return {shapes[static_cast<std::size_t>(candidate.core)].scene_body,
            shapes[static_cast<std::size_t>(candidate.tip)].scene_body};
  }
  if (candidate.is_given()) {
    const auto friction = std::ranges::find(mechanism.frictions, candidate.contact, &LinkFriction::contact);
    return {friction->body_a, friction->body_b};
  }
  const auto swing = std::ranges::find(mechanism.swings, candidate.contact, &Swing::contact);
  return {swing->body_a, swing->body_b};
}

// A torque is shown at its joint. p: the point of contact.
Eigen::Vector3d position_of(const Mechanism& mechanism, Dynamics& dynamics, const ContactCandidate& candidate,
                            const Eigen::Vector3d& p) {
  if (candidate.kind != ContactCandidate::Kind::swing) return p;
  const auto swing = std::ranges::find(mechanism.swings, candidate.contact, &Swing::contact);
  return swing->link_b == 0 ? swing->p_b : dynamics.readings().link_pose(swing->link_b).point(swing->p_b);
}

// What touches sticks if it has friction.
std::vector<CandidateMode> closed_where_it_touches(ContactEquations& equations, Dynamics& dynamics) {
  ContactCandidates& candidates = equations.candidates();
  candidates.read_motion(dynamics);
  std::vector<CandidateMode> out(static_cast<std::size_t>(candidates.count()));
  for (int i = 0; i < candidates.count(); ++i) {
    out[static_cast<std::size_t>(i)].closed =
        candidates.is_close(i) && candidates.gap(i) <= touch_tolerance && candidates.is_near(i);
  }
  return out;
}

std::vector<ForceCone> cones_of(const ContactEquations& equations) {
  std::vector<ForceCone> out;
  for (const ContactEquations::Entry& entry : equations.rows().entries) {
    if (!entry.is_given) out.push_back({.normal = entry.first});
    for (int group = 0; group < contact_groups; ++group) {
      const int row = entry.rows[static_cast<std::size_t>(group)];
      if (row >= 0)
        out.push_back({entry.first, row, entry.kept(group), equations.coefficient(entry.candidate, group, false)});
    }
  }
  return out;
}

bool obey(const ContactEquations& equations, const std::vector<ContactEquations::CandidateForce>& forces,
          double slack) {
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const int candidate = equations.rows().entries[i].candidate;
    if (forces[i].normal < -slack) return false;
    for (int group = 0; group < contact_groups; ++group) {
      const double most = equations.coefficient(candidate, group, false) * forces[i].normal;
      if (forces[i].held[static_cast<std::size_t>(group)] > most + slack) return false;
    }
  }
  return true;
}

}  // namespace

RestContacts rest_contacts(const Scene& scene, const EquilibriumProblem& of, Dynamics& dynamics, double* vdot) {
  RestContacts out;
  if (!of.mechanism.touches()) return out;
  ContactEquations equations(of.mechanism, dynamics, of.loads.contacts, true);
  equations.set_modes(closed_where_it_touches(equations, dynamics));
  // Pairs of shapes whose points are not located, and cylinders on their flat ends, have no candidates.
  if (const int closed = closed_contact(of.mechanism, dynamics.readings(), of.loads.contacts.size()); closed >= 0) {
    const bool is_known =
        std::ranges::any_of(equations.closed(), [&](int i) { return equations.candidates()[i].contact == closed; });
    if (!is_known) out.undefined = name_of_touching_law(scene, closed);
  }
  if (equations.closed().empty()) return out;
  equations.accelerate(vdot);
  const ContactEquations::Solution solved = equations.last_solution();
  const double size = solved.x.cwiseAbs().maxCoeff();
  const double slack = law_rounding * size;
  const auto* forces = &equations.forces();
  out.is_held = obey(equations, *forces, slack);
  if (!out.is_held) {
    // Prestress may be of any size.
    const ForceMargin found = force_margin(solved.x, redundant_multipliers(solved.G), cones_of(equations), size);
    out.is_held = found.margin >= -slack;
    forces = &equations.forces_of(found.x);
  }
  out.can_push = std::ranges::all_of(*forces, [&](const auto& of) { return of.normal >= -slack; });
  const double force = scene.units.size_of("N");
  const double length = scene.units.size_of("m");
  for (std::size_t i = 0; i < forces->size(); ++i) {
    const ContactEquations::CandidateForce& of_point = (*forces)[i];
    const ContactEquations::Entry& entry = equations.rows().entries[i];
    const ContactCandidate& candidate = equations.candidates()[entry.candidate];
    const bool core_is_first = candidate.sign > 0;
    RestPoint& point = out.points.emplace_back();
    point.contact = name_of_touching_law(scene, candidate.contact);
    const auto bodies = bodies_of(of.mechanism, candidate);
    point.first = name_of_body(scene, core_is_first ? bodies.first : bodies.second);
    point.second = name_of_body(scene, core_is_first ? bodies.second : bodies.first);
    point.position = length * of.mechanism.X_W0.point(position_of(of.mechanism, dynamics, candidate, entry.at.p));
    point.force = -candidate.sign * force * (of.mechanism.X_W0.R * of_point.force);
    const double normal = (candidate.turns() ? force * length : force) * of_point.normal;
    point.normal = candidate.is_given() ? 0 : normal;
    point.friction = (candidate.group_turns(0) ? force * length : force) * of_point.held[0];
    point.limit = std::max(0.0, equations.coefficient(entry.candidate, 0, false) * normal);
  }
  return out;
}

}  // namespace gelenk
