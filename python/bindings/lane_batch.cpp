// SPDX-License-Identifier: BSD-3-Clause
#include "batch/lane_batch.h"

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bindings.h"

namespace nb = nanobind;
using gelenk::LaneBatch;
using gelenk::LaneStop;
using gelenk::Scene;
using namespace nb::literals;

namespace {

using LaneRows = nb::ndarray<nb::numpy, double, nb::ndim<2>>;

// Without the lanes that complete the last block.
LaneRows lane_rows(double* data, std::size_t count, const LaneBatch& batch) {
  return {data, {count, static_cast<std::size_t>(batch.lanes())}, {}, {batch.stride(), 1}};
}

}  // namespace

void gelenk::bind_lane_batch(nb::module_& m) {
  nb::class_<LaneStop>(m, "LaneStop", "A lane that has stopped.")
      .def_ro("lane", &LaneStop::lane)
      .def_ro("time", &LaneStop::time, "At which it remains [s].")
      .def_prop_ro("text", &LaneStop::text, "Why.");
  nb::class_<LaneBatch>(m, "LaneBatch", "Many instances of one scene, stepped together.")
      .def(nb::init<const Scene&, int, double, const std::vector<std::string>&>(), "scene"_a, "lanes"_a, "step"_a,
           "parameters"_a, nb::call_guard<nb::gil_scoped_release>())
      .def("set", &LaneBatch::set, "values"_a, "threads"_a, nb::call_guard<nb::gil_scoped_release>(),
           "Set values by parameter, by lane, and put all lanes to their starts.")
      .def("reset", &LaneBatch::reset, "Put all lanes to their starts.")
      .def("start_as",
           nb::overload_cast<const std::vector<int>&, const LaneBatch&, const std::vector<int>&>(&LaneBatch::start_as),
           "lanes"_a, "source"_a, "of"_a,
           "Put lanes to the starts of lanes of another batch, of the same scene with the same parameters.")
      .def("advance", &LaneBatch::advance, "count"_a, "threads"_a, nb::call_guard<nb::gil_scoped_release>(),
           "Make so many steps.")
      .def_prop_ro("lanes", &LaneBatch::lanes)
      .def_prop_ro("step", &LaneBatch::step)
      .def_prop_ro("time", &LaneBatch::time)
      .def_prop_ro("coordinates", &LaneBatch::coordinates)
      .def_prop_ro("velocities", &LaneBatch::velocities)
      .def_prop_ro("inputs", &LaneBatch::inputs)
      .def_prop_ro("element_states", &LaneBatch::element_states)
      .def_prop_ro("reads_time", &LaneBatch::reads_time)
      .def_prop_ro("stopped", &LaneBatch::stopped, "The lanes that have stopped.")
      .def_prop_ro("evaluations", &LaneBatch::evaluations, "Evaluations of the equations of motion, by all lanes.")
      .def_prop_ro("operations", &LaneBatch::operations, "Operations of an evaluation.")
      .def_prop_ro("slots", &LaneBatch::slots, "Numbers that a lane needs in a step.")
      .def(
          "state",
          [](LaneBatch& batch) {
            const std::size_t count =
                batch.coordinates().size() + batch.velocities().size() + batch.element_states().size();
            return lane_rows(batch.state(), count, batch);
          },
          nb::rv_policy::reference_internal, "Coordinates, velocities and element states, by lane.")
      .def(
          "input", [](LaneBatch& batch) { return lane_rows(batch.input(), batch.inputs().size(), batch); },
          nb::rv_policy::reference_internal, "Inputs, by lane.");
  m.def("lane_instructions", &gelenk::lanes::instruction_set, "The vector instructions that batches use.");
  m.def("use_all_lane_instructions", &gelenk::lanes::use_all_instructions, "on"_a,
        "For tests: whether batches use those that not every processor has.");
}
