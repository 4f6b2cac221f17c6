// SPDX-License-Identifier: BSD-3-Clause
#include "bindings.h"

NB_MODULE(_core, m) {
  m.doc() = "The compiled core of Gelenk: scenes, simulations, FMU export. Use the package gelenk, which wraps it.";
  gelenk::bind_errors(m);
  gelenk::bind_scene(m);
  gelenk::bind_parameters(m);
  gelenk::bind_simulation(m);
  gelenk::bind_pictures(m);
  gelenk::bind_inspection(m);
  gelenk::bind_equations(m);
  gelenk::bind_lane_batch(m);
  gelenk::bind_assemblies(m);
  gelenk::bind_fmu(m);
  gelenk::bind_fmu_log(m);
  gelenk::bind_cones(m);
  gelenk::bind_joints(m);
  gelenk::bind_elements(m);
}
