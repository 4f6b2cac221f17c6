// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gelenk {

// A contact of the scene whose force is at the edge of its law, where derivatives do not exist.
struct LawEdge {
  enum class Of {
    normal_force,             // it touches without a force
    impact,                   // it touches with a velocity towards the other shape
    friction,                 // it sticks with as much friction as it can exert, or is about to stick
    feature,                  // its point is at the end of a face or an edge
    redundant_normal_forces,  // it slides, and the equations do not determine its share of the normal forces
    redundant_prestress,      // the accelerations nearby depend on forces that the equations do not determine
    losses,                   // it is closed beside a gear or rack with losses, which depend on its force
    prescribed_speed          // it sticks at rest, and a constraint prescribes a speed without a position
  };
  int contact = -1;  // -1: there is none
  Of of = Of::normal_force;
};

}  // namespace gelenk
