// SPDX-License-Identifier: BSD-3-Clause
// Reads the sections parameters, outputs, assembly, experiment and solver.
#include <cmath>
#include <limits>

#include "check/check.h"
#include "scene/settable.h"
#include "scene/words.h"
#include "scene_file/reader.h"
#include "util/text.h"

namespace gelenk {

namespace {

// Reads a list of names; entries that are not text become empty names.
std::vector<std::string> read_names(const Json& list, const std::string& path, Faults& faults, std::string_view what) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < list.size(); ++i) {
    out.push_back(read_text(list[i], path + "[" + std::to_string(i + 1) + "]", faults, what).value_or(""));
  }
  return out;
}

}  // namespace

void read_parameters(const Json& section, Reader& reader) {
  if (section.is_string() && section.get<std::string>() == "all") {
    for (const Settable& number : settables(reader.scene)) {
      if (number.path != "gravity") reader.scene.parameters.push_back(number.path);  // always a parameter
    }
    return;
  }
  if (!section.is_array()) {
    reader.faults.add("parameters", shown(section), "a list of paths such as crank.mass, or all");
    return;
  }
  reader.scene.parameters = read_names(section, "parameters", reader.faults, "a path such as crank.mass");
}

void read_outputs(const Json& section, Reader& reader) {
  constexpr const char* expected =
      "a list of names and patterns of outputs such as [A.phi, 'B.*']; omit `outputs` to include all";
  if (!section.is_array() || section.empty()) {
    reader.faults.add("outputs", section.is_array() ? "an empty list" : shown(section), expected);
    return;
  }
  reader.scene.outputs = read_names(section, "outputs", reader.faults, "the name of an output, or a pattern");
}

void read_assembly(const Json& section, Reader& reader) {
  Fields fields(section, "assembly", reader.faults, "a mapping with tolerance");
  AssemblySettings& assembly = reader.scene.assembly;
  assembly.tolerance = fields.number("tolerance", assembly.tolerance, "", Range::not_negative);
  fields.done();
}

void read_experiment(const Json& section, Reader& reader) {
  Fields fields(section, "experiment", reader.faults, "a mapping with stop, step, tolerance");
  Experiment& experiment = reader.scene.experiment;
  experiment.stop = fields.number("stop", experiment.stop, "s", Range::positive);
  experiment.step = fields.number("step", experiment.step, "s", Range::positive);
  experiment.tolerance = fields.number("tolerance", experiment.tolerance, "", Range::positive);
  fields.done();
}

namespace {

// Reads {planar: false, ...}; `all` applies to the reductions that are not named.
void read_reductions(const Json& section, Solver& solver, Faults& faults) {
  Fields fields(section, "solver.reductions", faults, "a mapping from names of reductions to true or false");
  const bool all = fields.flag("all", true);
  for (int i = 0; i < reduction_count; ++i) solver.reductions[i] = fields.flag(words::reductions[i], all);
  fields.done();
}

void read_left_out(const Json& section, Reader& reader) {
  Fields fields(section, "solver.left_out", reader.faults, "a mapping with length, travel, mass");
  OmittedSizes& sizes = reader.scene.left_out.emplace();
  sizes.length = fields.number("length", 0, "m", Range::not_negative);
  sizes.travel = fields.number("travel", 0, "m", Range::not_negative);
  sizes.mass = fields.number("mass", 0, "kg", Range::not_negative);
  fields.done();
}

// Reads an integer in the range, which the type Integer of FMI can hold.
void read_count(const Json& value, const std::string& path, IntRange range, int& count, Faults& faults) {
  const double x = value.is_number() ? value.get<double>() : -1;
  if (x >= range.min && x <= range.max && x == std::floor(x)) {
    count = static_cast<int>(x);
  } else {
    faults.add(path, shown(value),
               "a whole number from " + std::to_string(range.min) + " to " + std::to_string(range.max));
  }
}

}  // namespace

void read_solver(const Json& section, Reader& reader) {
  Fields fields(section, "solver", reader.faults, "a mapping with formulation, integrator, step, reductions");
  Solver& solver = reader.scene.solver;
  solver.formulation = fields.choice("formulation", words::formulations, solver.formulation);
  solver.integrator = fields.choice("integrator", words::integrators, solver.integrator);
  solver.start = fields.choice("start", words::starts, solver.start);
  solver.equations = fields.choice("equations", words::equations, solver.equations);
  solver.step = fields.number("step", solver.step, "s", Range::not_negative);
  const auto count = [&](const char* field, IntRange range, int& value) {
    if (const Json* given = fields.find(field)) read_count(*given, fields.path(field), range, value, reader.faults);
  };
  count("max_evaluations", words::max_evaluations, solver.max_evaluations);
  count("max_events", words::max_events, solver.max_events);
  count("corrections", words::corrections, solver.corrections);
  solver.cone_tolerance = fields.number("cone_tolerance", solver.cone_tolerance, "", Range::positive);
  solver.rho_inf = fields.number("rho_inf", solver.rho_inf, "", Range::not_negative);
  solver.baumgarte_alpha = fields.number("baumgarte_alpha", solver.baumgarte_alpha, "1/s", Range::not_negative);
  solver.baumgarte_beta = fields.number("baumgarte_beta", solver.baumgarte_beta, "1/s", Range::not_negative);
  if (const Json* reductions = fields.find("reductions")) read_reductions(*reductions, solver, reader.faults);
  if (const Json* left_out = fields.find("left_out")) read_left_out(*left_out, reader);
  fields.done();
}

}  // namespace gelenk
