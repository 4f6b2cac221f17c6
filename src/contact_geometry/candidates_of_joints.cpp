// SPDX-License-Identifier: BSD-3-Clause
// Candidates without shapes: laws of joints that are contacts to the equations.
#include "contact_geometry/contact_candidates.h"
#include "mechanism/mechanism.h"

namespace gelenk {

ContactCandidate& ContactCandidates::add_without_shapes(ContactCandidate::Kind kind, int core_link, int tip_link,
                                                        int contact) {
  Pair& pair = pairs_.emplace_back();
  pair.first = count();
  pair.core_link = core_link;
  pair.tip_link = tip_link;
  pair.core.setZero();
  pair.tip.setZero();
  ContactCandidate& candidate = candidates_.emplace_back();
  candidate.kind = kind;
  candidate.core = candidate.tip = -1;
  candidate.core_link = core_link;
  candidate.tip_link = tip_link;
  candidate.pair = static_cast<int>(pairs_.size()) - 1;
  candidate.contact = contact;
  candidate.size = 1;
  candidate.center.setZero();
  candidate.way.setZero();
  candidate.R_belt.setIdentity();
  links_.push_back(core_link);
  links_.push_back(tip_link);
  return candidate;
}

void ContactCandidates::add_swing(const Swing& swing) {
  ContactCandidate& candidate =
      add_without_shapes(ContactCandidate::Kind::swing, swing.link_a, swing.link_b, swing.contact);
  candidate.core_axis = swing.axis_a;
  candidate.tip_axis = swing.axis_b;
  candidate.swing = swing.angle;
}

void ContactCandidates::add_friction(const LinkFriction& friction) {
  ContactCandidate& candidate =
      add_without_shapes(ContactCandidate::Kind::friction, friction.link_a, friction.link_b, friction.contact);
  candidate.core_axis = friction.R_a.col(2);
  candidate.tip_axis = friction.R_b.col(2);
  candidate.center = friction.p_b;
  candidate.tangential = friction.dimension;
  candidate.is_moment = friction.turns;
}

}  // namespace gelenk
