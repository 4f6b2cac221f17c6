// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <set>

#include "modelDescription/capabilities.h"
#include "modelDescription/description_parts.h"
#include "modelDescription/fingerprint.h"
#include "modelDescription/units.h"
#include "modelDescription/write_xml.h"

namespace gelenk {
namespace {

void write_capabilities(XmlWriter& w, const FmuFacts& facts) {
  if (facts.event_indicators) {
    w.open(1, "ModelExchange").attribute("modelIdentifier", facts.model_identifier);
    w.attribute("completedIntegratorStepNotNeeded", false);
    for (const Capability& c : capabilities) {
      if (c.of_both) w.attribute(c.name, c.supported);
    }
    w.end();
  }
  w.open(1, "CoSimulation").attribute("modelIdentifier", facts.model_identifier);
  for (const Capability& c : capabilities) w.attribute(c.name, c.supported);
  w.attribute("maxOutputDerivativeOrder", max_output_derivative_order).end();
}

void write_types(XmlWriter& w, const Catalog& catalog) {
  std::set<std::string> written;
  w.open(1, "TypeDefinitions").inside();
  for (const Variable& v : catalog.variables()) {
    if (v.hidden || v.type != ParameterType::real || v.type_name.empty() || !written.insert(v.type_name).second)
      continue;
    w.open(2, "SimpleType").attribute("name", v.type_name).inside();
    w.open(3, "Real").attribute("quantity", quantity(v.unit)).attribute("unit", v.unit);
    if (!v.display_unit.empty()) w.attribute("displayUnit", v.display_unit);
    w.end();
    w.close(2, "SimpleType");
  }
  w.close(1, "TypeDefinitions");
}

// The names of the items of enumerations, for programs; for readers they are in the descriptions.
void write_choices(XmlWriter& w, const Catalog& catalog) {
  for (const Variable& v : catalog.variables()) {
    if (v.type != ParameterType::enumeration) continue;
    w.open(4, "Choice").attribute("variable", v.name).inside();
    const Parameter& choice = catalog.parameters()[static_cast<std::size_t>(v.index)];
    for (std::size_t i = 0; i < choice.items.size(); ++i) {
      w.open(5, "Item").attribute("name", choice.items[i]).attribute("value", static_cast<int>(i) + 1);
      w.attribute("description", choice.item_summaries[i]).end();
    }
    w.close(4, "Choice");
  }
}

// The schema of FMI permits one element per tool here.
void write_annotations(XmlWriter& w, const Scene& scene, const Catalog& catalog, const FmuFacts& facts) {
  w.open(1, "VendorAnnotations").inside();
  w.open(2, "Tool").attribute("name", "Gelenk").inside();
  w.open(3, "Model").inside();
  write_order(w, 4, scene, facts);
  write_choices(w, catalog);
  w.close(3, "Model");
  w.close(2, "Tool");
  w.close(1, "VendorAnnotations");
}

// For each variable its position in modelDescription.xml, from 1, as FMI counts; 0: hidden.
using PlacesInFile = std::vector<int>;

PlacesInFile places_in_file(const Catalog& catalog) {
  PlacesInFile out;
  int next = 1;
  for (const Variable& v : catalog.variables()) out.push_back(v.hidden ? 0 : next++);
  return out;
}

void write_type(XmlWriter& w, const Variable& v, const PlacesInFile& places) {
  switch (v.type) {
    case ParameterType::real:
      w.open(3, "Real");
      if (!v.type_name.empty()) w.attribute("declaredType", v.type_name);
      if (!v.unit.empty()) w.attribute("unit", v.unit);
      if (!v.display_unit.empty()) w.attribute("displayUnit", v.display_unit);
      if (std::isfinite(v.min)) w.attribute("min", v.min);
      if (std::isfinite(v.max)) w.attribute("max", v.max);
      if (v.nominal > 0) w.attribute("nominal", v.nominal);
      if (v.start) w.attribute("start", *v.start);
      if (v.derivative_of >= 0) w.attribute("derivative", places[static_cast<std::size_t>(v.derivative_of)]);
      break;
    case ParameterType::boolean:
      w.open(3, "Boolean").attribute("start", v.start == 1.0);
      break;
    case ParameterType::integer:
    case ParameterType::enumeration:  // Maestro rejects FMI's Enumeration, libcosim ignores it
      w.open(3, "Integer").attribute("min", static_cast<int>(v.min)).attribute("max", static_cast<int>(v.max));
      w.attribute("start", static_cast<int>(v.start.value_or(v.min)));
      break;
  }
  w.end();
}

void write_variable(XmlWriter& w, const Variable& v, std::size_t value_reference, const PlacesInFile& places) {
  w.open(2, "ScalarVariable").attribute("name", v.name);
  w.attribute("valueReference", static_cast<int>(value_reference)).attribute("description", v.description);
  w.attribute("causality", name_of(v.causality)).attribute("variability", name_of(v.variability));
  if (v.causality == Causality::parameter) w.attribute("initial", "exact");
  if (v.causality == Causality::output || v.causality == Causality::local) w.attribute("initial", "calculated");
  w.inside();
  write_type(w, v, places);
  w.close(2, "ScalarVariable");
}

void write_unknowns(XmlWriter& w, std::string_view element, const std::vector<Structure::Unknown>& unknowns,
                    const PlacesInFile& places) {
  if (unknowns.empty()) return;
  w.open(2, element).inside();
  for (const Structure::Unknown& unknown : unknowns) {
    w.open(3, "Unknown").attribute("index", places[static_cast<std::size_t>(unknown.variable)]);
    if (unknown.dependencies != nullptr) {
      std::string text;
      for (const int known : *unknown.dependencies)
        text += (text.empty() ? "" : " ") + std::to_string(places[static_cast<std::size_t>(known)]);
      w.attribute("dependencies", text);
    }
    w.end();
  }
  w.close(2, element);
}

void write_structure(XmlWriter& w, const Structure& structure, const PlacesInFile& places) {
  w.open(1, "ModelStructure").inside();
  write_unknowns(w, "Outputs", structure.outputs(), places);
  write_unknowns(w, "Derivatives", structure.derivatives(), places);
  write_unknowns(w, "InitialUnknowns", structure.initial_unknowns(), places);
  w.close(1, "ModelStructure");
}

}  // namespace

std::string write_fmi2_description(const Scene& scene, const Catalog& catalog, const std::vector<Knowns>& dependencies,
                                   const FmuFacts& facts) {
  XmlWriter w;
  w.raw("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
  w.open(0, "fmiModelDescription").attribute("fmiVersion", "2.0").attribute("modelName", scene.name);
  w.attribute("guid", facts.guid);
  write_metadata(w, scene);
  w.attribute("generationTool", "Gelenk " + std::string(gelenk_version()));
  w.attribute("variableNamingConvention", "structured")
      .attribute("numberOfEventIndicators", facts.event_indicators.value_or(0));
  w.inside();
  std::vector<bool> is_shown;
  for (const Variable& v : catalog.variables()) is_shown.push_back(!v.hidden);
  write_capabilities(w, facts);
  write_units(w, catalog, is_shown);
  write_types(w, catalog);
  write_log_categories(w);
  write_default_experiment(w, scene);
  write_annotations(w, scene, catalog, facts);
  w.open(1, "ModelVariables").inside();
  const PlacesInFile places = places_in_file(catalog);
  for (std::size_t i = 0; i < catalog.variables().size(); ++i) {
    if (is_shown[i]) write_variable(w, catalog.variables()[i], i, places);
  }
  w.close(1, "ModelVariables");
  write_structure(w, Structure(catalog, dependencies), places);
  w.close(0, "fmiModelDescription");
  return w.take();
}

}  // namespace gelenk
