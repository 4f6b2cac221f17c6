// SPDX-License-Identifier: BSD-3-Clause
#include "inspection/inspection.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "scene/words.h"

namespace nb = nanobind;
using gelenk::Inspection;
using gelenk::MovedFrame;
using gelenk::ReductionReport;
using gelenk::RedundantRow;

void gelenk::bind_inspection(nb::module_& m) {
  nb::class_<RedundantRow>(m, "RedundantRow", "A loop-closure equation that is redundant at every position.")
      .def_ro("joint", &RedundantRow::joint)
      .def_ro("motion", &RedundantRow::motion, "The motion that it prevents, in the joint's frame.");
  nb::class_<ReductionReport>(m, "ReductionReport", "Result of one reduction.")
      .def_ro("name", &ReductionReport::name)
      .def_ro("on", &ReductionReport::on)
      .def_ro("changed", &ReductionReport::changed, "Whether it made the model smaller.")
      .def_ro("notes", &ReductionReport::notes, "Sentences; empty: not applicable.");
  nb::class_<MovedFrame>(m, "MovedFrame",
                         "A joint's frame in a body, moved so that loops with rounded dimensions close.")
      .def_ro("joint", &MovedFrame::joint)
      .def_ro("body", &MovedFrame::body)
      .def_ro("turn", &MovedFrame::turn, "Angle by which it was rotated [rad].")
      .def_ro("shift", &MovedFrame::shift, "Distance by which it was shifted [m].");
  nb::class_<Inspection>(m, "Inspection", "Report on the reductions of a scene.")
      .def_ro("described", &Inspection::described)
      .def_ro("reduced", &Inspection::reduced)
      .def_ro("reductions", &Inspection::reductions)
      .def_ro("redundant_rows", &Inspection::redundant_rows)
      .def_ro("undetermined_reactions", &Inspection::undetermined_reactions)
      .def_ro("counted_degrees_of_freedom", &Inspection::counted_degrees_of_freedom)
      .def_ro("initial_degrees_of_freedom", &Inspection::initial_degrees_of_freedom)
      .def_ro("moved_frames", &Inspection::moved_frames)
      .def_ro("mobility", &Inspection::mobility)
      .def_ro("left_out", &Inspection::left_out, "Clause on parts that no requested output depends on; empty: none.");
  m.def("reduction_names", [] { return words::reductions; }, "The names of all reductions.");
}
