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

// Items of enumerations have types of their own in FMI 3.0.
std::string type_of_choice(const Variable& v) { return "Gelenk." + v.name; }

bool is_for_exchange(const FmuFacts& facts) { return facts.event_indicators.has_value(); }

void write_interfaces(XmlWriter& w, const FmuFacts& facts) {
  if (is_for_exchange(facts)) {
    w.open(1, "ModelExchange").attribute("modelIdentifier", facts.model_identifier);
    w.attribute("needsCompletedIntegratorStep", true);
    for (const Capability& c : fmi3_capabilities) {
      if (c.of_both) w.attribute(c.name, c.supported);
    }
    w.end();
  }
  w.open(1, "CoSimulation").attribute("modelIdentifier", facts.model_identifier);
  for (const Capability& c : fmi3_capabilities) w.attribute(c.name, c.supported);
  w.attribute("maxOutputDerivativeOrder", max_output_derivative_order).end();
}

void write_type_of_choice(XmlWriter& w, const Variable& v, const Parameter& choice) {
  w.open(2, "EnumerationType").attribute("name", type_of_choice(v)).inside();
  for (std::size_t i = 0; i < choice.items.size(); ++i) {
    w.open(3, "Item").attribute("name", choice.items[i]).attribute("value", static_cast<int>(i) + 1);
    w.attribute("description", choice.item_summaries[i]).end();
  }
  w.close(2, "EnumerationType");
}

void write_fmi3_types(XmlWriter& w, const Catalog& catalog, const std::vector<bool>& is_shown) {
  std::set<std::string> written;
  w.open(1, "TypeDefinitions").inside();
  for (std::size_t i = 0; i < is_shown.size(); ++i) {
    const Variable& v = catalog.variables()[i];
    if (!is_shown[i]) continue;
    if (v.type == ParameterType::enumeration)
      write_type_of_choice(w, v, catalog.parameters()[static_cast<std::size_t>(v.index)]);
    if (v.type != ParameterType::real || v.type_name.empty() || !written.insert(v.type_name).second) continue;
    w.open(2, "Float64Type").attribute("name", v.type_name);
    w.attribute("quantity", quantity(v.unit)).attribute("unit", v.unit);
    if (!v.display_unit.empty()) w.attribute("displayUnit", v.display_unit);
    w.end();
  }
  w.close(1, "TypeDefinitions");
}

const char* element_of(ParameterType type) {
  switch (type) {
    case ParameterType::real:
      return "Float64";
    case ParameterType::boolean:
      return "Boolean";
    case ParameterType::integer:
      return "Int32";
    case ParameterType::enumeration:
      break;
  }
  return "Enumeration";
}

// reinit: whether events change the variable, a state.
void write_real(XmlWriter& w, const Variable& v, bool reinit) {
  if (!v.type_name.empty()) w.attribute("declaredType", v.type_name);
  if (!v.unit.empty()) w.attribute("unit", v.unit);
  if (!v.display_unit.empty()) w.attribute("displayUnit", v.display_unit);
  if (std::isfinite(v.min)) w.attribute("min", v.min);
  if (std::isfinite(v.max)) w.attribute("max", v.max);
  if (v.nominal > 0) w.attribute("nominal", v.nominal);
  if (v.start) w.attribute("start", *v.start);
  if (v.derivative_of >= 0) w.attribute("derivative", v.derivative_of);
  if (reinit) w.attribute("reinit", true);
}

void write_fmi3_variable(XmlWriter& w, const Variable& v, std::size_t value_reference, bool reinit) {
  w.open(2, element_of(v.type)).attribute("name", v.name);
  w.attribute("valueReference", static_cast<int>(value_reference)).attribute("description", v.description);
  w.attribute("causality", name_of(v.causality)).attribute("variability", name_of(v.variability));
  if (v.causality == Causality::parameter) w.attribute("initial", "exact");
  if (v.causality == Causality::output || v.causality == Causality::local) w.attribute("initial", "calculated");
  switch (v.type) {
    case ParameterType::real:
      write_real(w, v, reinit);
      break;
    case ParameterType::boolean:
      w.attribute("start", v.start == 1.0);
      break;
    case ParameterType::enumeration:
      w.attribute("declaredType", type_of_choice(v));
      [[fallthrough]];
    case ParameterType::integer:
      w.attribute("min", static_cast<int>(v.min)).attribute("max", static_cast<int>(v.max));
      w.attribute("start", static_cast<int>(v.start.value_or(v.min)));
  }
  w.end();
}

void write_fmi3_unknowns(XmlWriter& w, std::string_view element, const std::vector<Structure::Unknown>& unknowns) {
  for (const Structure::Unknown& unknown : unknowns) {
    w.open(2, element).attribute("valueReference", unknown.variable);
    if (unknown.dependencies != nullptr) {
      std::string text;
      for (const int known : *unknown.dependencies) text += (text.empty() ? "" : " ") + std::to_string(known);
      w.attribute("dependencies", text);
    }
    w.end();
  }
}

// Event indicators are variables, too; their value references follow those of the catalog.
void write_event_indicators(XmlWriter& w, int first, int count) {
  for (int i = 0; i < count; ++i) {
    w.open(2, "Float64").attribute("name", "event_indicators[" + std::to_string(i + 1) + "]");
    w.attribute("valueReference", first + i);
    w.attribute("description", "event indicator of model exchange; 0 with co-simulation");
    w.attribute("causality", "local").attribute("variability", "continuous").attribute("initial", "calculated").end();
  }
}

void write_fmi3_structure(XmlWriter& w, const Structure& structure, int first_indicator, int indicators) {
  w.open(1, "ModelStructure").inside();
  write_fmi3_unknowns(w, "Output", structure.outputs());
  write_fmi3_unknowns(w, "ContinuousStateDerivative", structure.derivatives());
  write_fmi3_unknowns(w, "InitialUnknown", structure.initial_unknowns());
  for (int i = 0; i < indicators; ++i)
    w.open(2, "EventIndicator").attribute("valueReference", first_indicator + i).end();
  w.close(1, "ModelStructure");
}

void write_fmi3_annotations(XmlWriter& w, const Scene& scene, const FmuFacts& facts) {
  w.open(1, "Annotations").inside();
  w.open(2, "Annotation").attribute("type", "Gelenk").inside();
  write_order(w, 3, scene, facts);
  w.close(2, "Annotation");
  w.close(1, "Annotations");
}

}  // namespace

std::string write_fmi3_description(const Scene& scene, const Catalog& catalog, const std::vector<Knowns>& dependencies,
                                   const FmuFacts& facts) {
  XmlWriter w;
  w.raw("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
  w.open(0, "fmiModelDescription").attribute("fmiVersion", "3.0").attribute("modelName", scene.name);
  w.attribute("instantiationToken", facts.guid);
  write_metadata(w, scene);
  w.attribute("generationTool", "Gelenk " + std::string(gelenk_version()));
  w.attribute("variableNamingConvention", "structured").inside();
  std::vector<bool> is_shown;
  for (const Variable& v : catalog.variables()) is_shown.push_back(!v.hidden || v.source == Source::time);
  write_interfaces(w, facts);
  write_units(w, catalog, is_shown);
  write_fmi3_types(w, catalog, is_shown);
  write_log_categories(w);
  write_default_experiment(w, scene);
  w.open(1, "ModelVariables").inside();
  std::vector<bool> reinit(is_shown.size(), false);
  if (is_for_exchange(facts)) {
    for (const State& state : catalog.states()) reinit[static_cast<std::size_t>(state.variable)] = true;
  }
  for (std::size_t i = 0; i < is_shown.size(); ++i) {
    if (is_shown[i]) write_fmi3_variable(w, catalog.variables()[i], i, reinit[i]);
  }
  const int first_indicator = static_cast<int>(is_shown.size());
  const int indicators = facts.event_indicators.value_or(0);
  write_event_indicators(w, first_indicator, indicators);
  w.close(1, "ModelVariables");
  write_fmi3_structure(w, Structure(catalog, dependencies), first_indicator, indicators);
  write_fmi3_annotations(w, scene, facts);
  w.close(0, "fmiModelDescription");
  return w.take();
}

}  // namespace gelenk
