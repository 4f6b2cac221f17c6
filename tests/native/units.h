// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <vector>

namespace native {

using Numbers = std::vector<double>;
using Table = std::vector<Numbers>;

// Calls of malloc and operator new in this module so far.
long allocations();

void bind_cones(nanobind::module_& m);
void bind_box_complementarity(nanobind::module_& m);
void bind_contacts(nanobind::module_& m);
void bind_descent(nanobind::module_& m);
void bind_expressions(nanobind::module_& m);
void bind_factors(nanobind::module_& m);
void bind_files(nanobind::module_& m);
void bind_lanes(nanobind::module_& m);
void bind_laws(nanobind::module_& m);
void bind_rotations(nanobind::module_& m);
void bind_shapes(nanobind::module_& m);
void bind_step_memory(nanobind::module_& m);
void bind_whitened_rows(nanobind::module_& m);
void bind_sweep_and_prune(nanobind::module_& m);
void bind_times(nanobind::module_& m);

}  // namespace native
