// SPDX-License-Identifier: BSD-3-Clause
// The parts of the Python module gelenk._core, one file each.
#pragma once

#include <nanobind/nanobind.h>

namespace gelenk {

void bind_cones(nanobind::module_& m);
void bind_errors(nanobind::module_& m);
void bind_scene(nanobind::module_& m);
void bind_parameters(nanobind::module_& m);
void bind_signals(nanobind::module_& m);
void bind_simulation(nanobind::module_& m);
void bind_pictures(nanobind::module_& m);
void bind_inspection(nanobind::module_& m);
void bind_assemblies(nanobind::module_& m);
void bind_fmu(nanobind::module_& m);
void bind_fmu_log(nanobind::module_& m);
void bind_lane_batch(nanobind::module_& m);
void bind_equations(nanobind::module_& m);
void bind_elements(nanobind::module_& m);
void bind_joints(nanobind::module_& m);
void bind_rods(nanobind::module_& joints);

}  // namespace gelenk
