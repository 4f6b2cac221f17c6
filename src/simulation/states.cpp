// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/states.h"

#include "joint/registry.h"

namespace gelenk {

std::vector<StateVariable> states_behind(const Scene& scene, const std::vector<Signal>& outputs,
                                         const std::vector<int>& independent_coordinates) {
  std::vector<StateVariable> coordinates;
  std::vector<StateVariable> speeds;
  for (const int q : independent_coordinates) {
    const Signal& s = outputs[q];
    const JointKind& kind = *find_joint_kind(scene.joints[s.joint].type);
    const int first_speed = q - s.component + kind.nq;
    const int turns = kind.nq - 4;  // where a quaternion begins, and its three speeds
    if (!kind.has_quaternion() || s.component < turns) {
      const int v = first_speed + s.component;
      coordinates.push_back({q, v});
      speeds.push_back({v, v + kind.nv});
      continue;
    }
    coordinates.push_back({q, StateVariable::none});
    if (s.component != turns) continue;
    for (int v = first_speed + kind.nv - 3; v < first_speed + kind.nv; ++v) speeds.push_back({v, v + kind.nv});
  }
  coordinates.insert(coordinates.end(), speeds.begin(), speeds.end());
  return coordinates;
}

std::vector<bool> speeds_behind(const ReducedScene& reduced, const std::vector<Signal>& outputs, int island,
                                const std::vector<StateVariable>& states) {
  std::vector<bool> out(reduced.islands[island].nv, false);
  for (const StateVariable& state : states) {
    const Signal& signal = outputs[state.output];
    const JointPlace& place = reduced.joints[signal.joint];
    if (signal.level == 1 && place.island == island) out[place.iv + signal.component] = true;
  }
  return out;
}

}  // namespace gelenk
