// SPDX-License-Identifier: BSD-3-Clause
// Messages about contacts where derivatives are taken.
#include "preparation/report.h"
#include "scene/touching_laws.h"
#include "util/text.h"

namespace gelenk {

std::string describe_closed_contact(const Scene& scene, int contact, const std::string& what, double t) {
  return "t = " + text::rounded(t) + " s: " + path_of_touching_law(scene, contact) + " " + what;
}

std::string describe_contact_edge(const Scene& scene, const LawEdge& edge, double t) {
  const auto what = [&]() -> std::string {
    switch (edge.of) {
      case LawEdge::Of::normal_force:
        return "touches without a force, and any change of the state or the inputs may close or open it";
      case LawEdge::Of::impact:
        return "is about to be struck";
      case LawEdge::Of::friction:
        return "is between sticking and sliding, at the limit of its friction";
      case LawEdge::Of::feature:
        return "touches exactly at the end of a face or an edge, which it may leave";
      case LawEdge::Of::redundant_normal_forces:
        return "slides with a friction that depends on redundant normal forces, which the equations do not determine";
      case LawEdge::Of::redundant_prestress:
        return "is wedged among others: the equations do not determine how much they press, on which the accelerations "
               "beside this position depend";
      case LawEdge::Of::losses:
        return "is closed beside a gear or rack with losses, which depend on its force";
      case LawEdge::Of::prescribed_speed:
        return "sticks at rest in a mechanism of which a speed is prescribed, whose position is not known by its "
               "states";
    }
    return {};
  };
  return describe_closed_contact(scene, edge.contact, what() + ": derivatives do not exist there", t);
}

}  // namespace gelenk
