// SPDX-License-Identifier: BSD-3-Clause
// Messages about limits of ball joints at the start.
#include "contact_geometry/contact_finder.h"
#include "preparation/report.h"
#include "scene/touching_laws.h"
#include "util/text.h"

namespace gelenk {

std::vector<std::string> describe_violated_swings(const Scene& scene, const Mechanism& mechanism, Dynamics& dynamics,
                                                  const double* q) {
  if (mechanism.swings.empty()) return {};
  dynamics.set_position(q);
  dynamics.readings().set_root_poses();
  ContactFinder finder(mechanism, touching_law_count(scene));
  const std::vector<double>& gaps = finder.smallest_gaps(dynamics.readings());
  std::vector<std::string> out;
  for (const Swing& swing : mechanism.swings) {
    const double gap = gaps[static_cast<std::size_t>(swing.contact)];
    if (gap >= -touch_tolerance) continue;
    out.push_back((scene.file.empty() ? "" : scene.file + ": ") + path_of_touching_law(scene, swing.contact) +
                  ".swing: found a start with a swing " + text::with_unit(text::rounded(-gap), "rad") +
                  " beyond it, expected one within the limit");
  }
  return out;
}

}  // namespace gelenk
