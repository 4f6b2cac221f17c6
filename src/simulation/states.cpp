// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/states.h"

#include "joint/kinds.h"

namespace gelenk {

std::vector<bool> speeds_of(const Scene& scene, const ReducedScene& reduced, const std::vector<Signal>& outputs,
                            int island, int level, const std::vector<int>& among) {
  std::vector<bool> out(reduced.islands[island].nv, false);
  for (const int i : among) {
    const Signal& signal = outputs[i];
    const JointPlace& place = reduced.joints[signal.joint];
    if (place.island != island || signal.level != level) continue;
    const JointKind& kind = *find_joint_kind(scene.joints[signal.joint].type);
    const int turns = kind.nq - 4;  // where a quaternion begins, and its three speeds
    if (level == 1 || !kind.is_of_quaternion(signal.component)) {
      out[place.iv + signal.component] = true;
    } else if (signal.component == turns) {
      for (int k = kind.nv - 3; k < kind.nv; ++k) out[place.iv + k] = true;
    }
  }
  return out;
}

}  // namespace gelenk
