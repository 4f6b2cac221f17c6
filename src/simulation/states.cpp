// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/states.h"

#include "joint/kinds.h"

namespace gelenk {

std::vector<StateVariable> states_of(const Scene& scene, const std::vector<Signal>& outputs,
                                     const IndependentOutputs& independent) {
  std::vector<StateVariable> out;
  for (const int q : independent.coordinates) {
    const Signal& s = outputs[q];
    const JointKind& kind = *find_joint_kind(scene.joints[s.joint].type);
    const bool of_quaternion = kind.has_quaternion() && s.component >= kind.nq - 4;
    out.push_back({q, of_quaternion ? StateVariable::none : q + kind.nq});
  }
  for (const int v : independent.speeds) {
    out.push_back({v, v + find_joint_kind(scene.joints[outputs[v].joint].type)->nv});
  }
  return out;
}

std::vector<bool> speeds_of(const Scene& scene, const ReducedScene& reduced, const std::vector<Signal>& outputs,
                            int island, int level, const std::vector<int>& among) {
  std::vector<bool> out(reduced.islands[island].nv, false);
  for (const int i : among) {
    const Signal& signal = outputs[i];
    const JointPlace& place = reduced.joints[signal.joint];
    if (place.island != island || signal.level != level) continue;
    const JointKind& kind = *find_joint_kind(scene.joints[signal.joint].type);
    const int turns = kind.nq - 4;  // where a quaternion begins, and its three speeds
    if (level == 1 || !kind.has_quaternion() || signal.component < turns) {
      out[place.iv + signal.component] = true;
    } else if (signal.component == turns) {
      for (int k = kind.nv - 3; k < kind.nv; ++k) out[place.iv + k] = true;
    }
  }
  return out;
}

}  // namespace gelenk
