// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/friction_loads.h"

#include "decomposition/singular_values.h"
#include "kinematics/switching_force.h"
#include "mechanism/mechanism.h"
#include "scene/scene.h"

namespace gelenk {

void check_loads_of_friction(const Scene& scene, const Loads& loads, const Mechanism& mechanism,
                             const PreparedIsland& island, Dynamics& dynamics) {
  SwitchingForces& forces = dynamics.switching_forces();
  const int rank = island.mobility.rank;
  if (forces.loads().empty() || rank >= mechanism.rows) return;
  dynamics.set_position(island.start.q.data());
  dynamics.factorize();
  const SingularValues svd(dynamics.J());
  for (int k = rank; k < svd.U.cols(); ++k) {
    const int friction = forces.loads().affected_by(Eigen::VectorXd(svd.U.col(k)).data());
    if (friction < 0) continue;
    const std::string& joint = scene.joints[switching_forces_of(loads)[static_cast<std::size_t>(friction)].joint].name;
    throw SceneError({(scene.file.empty() ? "" : scene.file + ": ") + "joints." + joint +
                      ".friction.bearing: found a force that redundant constraint equations leave undetermined; "
                      "expected joints with more degrees of freedom in the loop, or 'reaction: least_norm'"});
  }
}

}  // namespace gelenk
