// SPDX-License-Identifier: BSD-3-Clause
#include "units.h"

NB_MODULE(native_units, m) {
  native::bind_box_complementarity(m);
  native::bind_cones(m);
  native::bind_contacts(m);
  native::bind_descent(m);
  native::bind_expressions(m);
  native::bind_factors(m);
  native::bind_files(m);
  native::bind_lanes(m);
  native::bind_laws(m);
  native::bind_rotations(m);
  native::bind_shapes(m);
  native::bind_step_memory(m);
  native::bind_whitened_rows(m);
  native::bind_sweep_and_prune(m);
  native::bind_times(m);
}
