// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/export/write_page.h"

#include <algorithm>
#include <utility>

#include "formulation/inputs.h"
#include "inspection/inspection.h"
#include "modelDescription/fingerprint.h"
#include "modelDescription/write_xml.h"
#include "util/text.h"

namespace gelenk {
namespace {

constexpr const char* style =
    "body{font:16px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;width:100%}th,td{text-align:left;padding:.2em .6em;border-bottom:1px solid #ddd}"
    "td:first-child{font-family:monospace;white-space:nowrap}"
    "iframe{width:100%;height:28em;border:1px solid #ddd}figure{margin:1em 0}svg{max-width:100%;height:auto}";

std::string start_text(const Variable& v, const Catalog& catalog) {
  if (!v.start) return {};
  if (v.type == ParameterType::boolean) return *v.start != 0 ? "true" : "false";
  std::string number = text::number(*v.start);
  if (v.type != ParameterType::enumeration) return number;
  const auto& items = catalog.parameters()[static_cast<std::size_t>(v.index)].items;
  const auto item = static_cast<std::size_t>(*v.start) - 1;
  return item < items.size() ? number + " " + items[item] : number;
}

std::string range_text(const Variable& v) {
  const bool bounded_below = v.min > -std::numeric_limits<double>::infinity();
  const bool bounded_above = v.max < std::numeric_limits<double>::infinity();
  if (v.type == ParameterType::boolean || (!bounded_below && !bounded_above)) return {};
  return (bounded_below ? text::number(v.min) + " …" : "…") + (bounded_above ? " " + text::number(v.max) : "");
}

void add_table(std::string& page, const char* heading, Causality causality, const Catalog& catalog,
               bool of_joints = false) {
  const auto& variables = catalog.variables();
  const auto belongs = [&](const Variable& v) {
    const bool of_joint = v.causality == Causality::local && v.source == Source::output;
    return !v.hidden && v.causality == causality && of_joint == of_joints;
  };
  if (std::ranges::none_of(variables, belongs)) return;
  const bool settable = causality == Causality::input || causality == Causality::parameter;
  page += std::string("<h2>") + heading + "</h2>\n<table>\n<tr><th>name</th><th>unit</th>";
  page += settable ? "<th>start</th><th>allowed</th>" : "";
  page += "<th>meaning</th></tr>\n";
  for (const Variable& v : variables) {
    if (!belongs(v)) continue;
    page += "<tr><td>" + escaped(v.name) + "</td><td>" + escaped(v.unit == "1" ? "" : v.unit) + "</td>";
    if (settable) {
      page += "<td>" + escaped(start_text(v, catalog)) + "</td><td>" + escaped(range_text(v)) + "</td>";
    }
    page +=
        "<td>" + escaped(v.description) + (v.variability == Variability::tunable ? "; tunable" : "") + "</td></tr>\n";
  }
  page += "</table>\n";
}

std::string counted(int n, const std::string& one) { return std::to_string(n) + " " + one + (n == 1 ? "" : "s"); }
std::string degrees_of_freedom(int n) {
  return std::to_string(n) + (n == 1 ? " degree of freedom" : " degrees of freedom");
}

void add_reductions(std::string& page, const Inspection& report) {
  const ModelSize& before = report.described;
  const ModelSize& after = report.reduced;
  page += "<h2>The model</h2>\n<table>\n<tr><th></th><th>as described</th><th>as computed</th></tr>\n";
  const auto row = [&](const char* what, int a, int b) {
    page += std::string("<tr><td>") + what + "</td><td>" + std::to_string(a) + "</td><td>" + std::to_string(b) +
            "</td></tr>\n";
  };
  row("moving bodies", before.bodies, after.bodies);
  row("coordinates", before.coordinates, after.coordinates);
  row("velocities", before.speeds, after.speeds);
  row("constraint equations", before.rows, after.rows);
  row("islands (integrated separately)", before.islands, after.islands);
  row("islands computed in a plane", 0, after.planar_islands);
  page += "</table>\n<p>Reductions and their results:</p>\n<ul>\n";
  for (const ReductionReport& reduction : report.reductions) {
    for (const std::string& note : reduction.notes) {
      page += "<li>" + escaped(reduction.name) + ": " + escaped(note) + "</li>\n";
    }
    if (!reduction.on) page += "<li>" + escaped(reduction.name) + ": switched off in the scene</li>\n";
  }
  page += "</ul>\n<p>" + degrees_of_freedom(report.reduced.degrees_of_freedom) +
          "; Gruebler's count (6 for each body, less what is constrained) gives " +
          std::to_string(report.counted_degrees_of_freedom) + ".";
  for (const std::string& cause : report.mobility) page += " " + escaped(cause) + ".";
  page += "</p>\n";
}

std::string figures(const PageContents& contents) {
  std::string out;
  if (contents.has_view) {
    out +=
        "<figure>\n<iframe src=\"view.html\" title=\"The mechanism in three dimensions\"></iframe>\n<figcaption>The "
        "mechanism at the start. Drag to turn it, scroll to zoom; <a href=\"view.html\">view.html</a> shows it in a "
        "window of its own. <code>gelenk view</code> shows the FMU in motion.</figcaption>\n</figure>\n";
  }
  out += "<figure>\n" + write_svg(contents.picture) + "<figcaption>";
  out += contents.has_view ? "The same as a drawing." : "The mechanism at the start.";
  out += " Red joints are driven by motors.";
  if (!contents.has_view) {
    out += " This FMU has no view in three dimensions; <code>gelenk view</code> shows it, in motion.";
  }
  return out + "</figcaption>\n</figure>\n";
}

std::string steps_of_fmi2() {
  return "<p>During a step an input is constant, or follows the time derivatives of order 1 to " +
         std::to_string(Inputs::highest_order) +
         " that were set with fmi2SetRealInputDerivatives; afterwards it is held at the value reached. A step that "
         "requires more than solver.max_evaluations evaluations ends early with fmi2Discard: fmi2GetRealStatus "
         "returns the time reached, from which the next step continues.</p>\n";
}

std::string steps_of_fmi3() {
  return "<p>During a step an input is constant; prescribed motions continue smoothly. A step that requires more than "
         "solver.max_evaluations evaluations returns early if the importer allows this, and otherwise with "
         "fmi3Discard: "
         "lastSuccessfulTime is the time reached, from which the next step continues.</p>\n";
}

// What the scene says about itself.
std::string about(const Metadata& metadata) {
  std::string out;
  if (!metadata.description.empty()) out += "<p>" + escaped(on_one_line(metadata.description)) + "</p>\n";
  constexpr std::pair<const char*, std::string Metadata::*> facts[] = {{"Author", &Metadata::author},
                                                                       {"Version", &Metadata::version},
                                                                       {"Copyright", &Metadata::copyright},
                                                                       {"License", &Metadata::license}};
  for (const auto& [title, text] : facts) {
    const std::string line = on_one_line(metadata.*text);
    if (!line.empty()) out += std::string("<p>") + title + ": " + escaped(line) + "</p>\n";
  }
  return out;
}

}  // namespace

std::string write_documentation(Simulation& simulation, const Catalog& catalog, const PageContents& contents) {
  const Scene& scene = simulation.scene();
  const ModelSize& size = simulation.size();
  const std::string name = escaped(scene.name);
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>" + name +
                     "</title>\n<style>" + style + "</style>\n</head>\n<body>\n<h1>" + name + "</h1>\n";
  page += about(scene.metadata) + "<p>Multibody plant with " + std::to_string(size.bodies) +
          (size.bodies == 1 ? " moving body: " : " moving bodies: ") + counted(size.coordinates, "coordinate") + ", " +
          std::to_string(size.speeds) + (size.speeds == 1 ? " velocity" : " velocities") + ", " +
          counted(size.rows, "constraint equation") + " of rank " + std::to_string(size.rank) + ", so " +
          degrees_of_freedom(size.degrees_of_freedom) + "; " +
          (size.planar ? "the mechanism is planar" : "the mechanism is spatial") + ".</p>\n";
  page += "<p>" + std::string(contents.version == FmiVersion::fmi2 ? "FMI 2.0" : "FMI 3.0") +
          " FMU for co-simulation. The communication step size is arbitrary; " + text::number(scene.experiment.step) +
          " s is suggested. Parameters can be set until the end of initialization, tunable ones also between steps. "
          "All values are in SI units. Angles are in radians and count full turns.</p>\n";
  page += contents.version == FmiVersion::fmi2 ? steps_of_fmi2() : steps_of_fmi3();
  page += figures(contents);
  add_table(page, "Inputs", Causality::input, catalog);
  add_table(page, "Outputs", Causality::output, catalog);
  add_table(page, "States that are not outputs, and their derivatives", Causality::local, catalog, true);
  add_table(page, "Parameters", Causality::parameter, catalog);
  add_table(page, "Diagnostics", Causality::local, catalog);
  if (!contents.left_out.empty()) page += "<p>Part of the scene was " + escaped(contents.left_out) + ".</p>\n";
  add_reductions(page, inspect(simulation, scene));
  page += "<p>Generated by Gelenk " + escaped(gelenk_version()) +
          ". The scene, which viewers may read, is in <code>resources/scene.json</code>, the licenses of the software "
          "in the runtime are in "
          "<a href=\"licenses/\">licenses</a>.</p>\n</body>\n</html>\n";
  return page;
}

}  // namespace gelenk
