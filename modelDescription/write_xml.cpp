// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/write_xml.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "modelDescription/capabilities.h"
#include "modelDescription/dependencies.h"
#include "modelDescription/fingerprint.h"
#include "modelDescription/units.h"
#include "scene/natural_time.h"
#include "util/text.h"

namespace gelenk {
namespace {

const char* name_of(Causality causality) {
  switch (causality) {
    case Causality::input:
      return "input";
    case Causality::output:
      return "output";
    case Causality::parameter:
      return "parameter";
    case Causality::local:
      break;
  }
  return "local";
}

const char* name_of(Variability variability) {
  switch (variability) {
    case Variability::continuous:
      return "continuous";
    case Variability::discrete:
      return "discrete";
    case Variability::tunable:
      return "tunable";
    case Variability::fixed:
      break;
  }
  return "fixed";
}

const char* name_of(bool value) { return value ? "true" : "false"; }

class Writer {
 public:
  Writer& open(int depth, std::string_view element) {
    text_.append(2 * static_cast<std::size_t>(depth), ' ').append("<").append(element);
    return *this;
  }
  Writer& attribute(std::string_view name, std::string_view value) {
    text_.append(" ").append(name).append("=\"").append(escaped(value)).append("\"");
    return *this;
  }
  Writer& attribute(std::string_view name, double value) { return attribute(name, text::number(value)); }
  Writer& attribute(std::string_view name, int value) { return attribute(name, std::to_string(value)); }
  Writer& attribute(std::string_view name, bool value) { return attribute(name, name_of(value)); }
  Writer& attribute(std::string_view name, const char* value) { return attribute(name, std::string_view(value)); }
  void end() { text_.append("/>\n"); }
  void inside() { text_.append(">\n"); }
  void close(int depth, std::string_view element) {
    text_.append(2 * static_cast<std::size_t>(depth), ' ').append("</").append(element).append(">\n");
  }
  void raw(std::string_view text) { text_.append(text); }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

void write_capabilities(Writer& w, const FmuFacts& facts) {
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

void write_unit(Writer& w, const std::string& unit) {
  w.open(2, "Unit").attribute("name", unit).inside();
  w.open(3, "BaseUnit");
  const UnitExponents exponents = unit_exponents(unit);
  for (std::size_t i = 0; i < exponents.size(); ++i) {
    if (exponents[i] != 0) w.attribute(base_units[i], exponents[i]);
  }
  w.end();
  for (const DisplayUnit& d : display_units(unit)) {
    w.open(3, "DisplayUnit").attribute("name", d.name).attribute("factor", d.factor).end();
  }
  w.close(2, "Unit");
}

void write_units(Writer& w, const Catalog& catalog) {
  std::set<std::string> used;
  for (const Variable& v : catalog.variables()) {
    if (!v.unit.empty() && !v.hidden) used.insert(v.unit);
  }
  w.open(1, "UnitDefinitions").inside();
  for (const std::string& unit : used) write_unit(w, unit);
  w.close(1, "UnitDefinitions");
}

void write_types(Writer& w, const Catalog& catalog) {
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
void write_choices(Writer& w, const Catalog& catalog) {
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
void write_annotations(Writer& w, const Scene& scene, const Catalog& catalog, const FmuFacts& facts) {
  w.open(1, "VendorAnnotations").inside();
  w.open(2, "Tool").attribute("name", "Gelenk").inside();
  w.open(3, "Model").inside();
  const UnitSystem units = natural_units(scene);
  w.open(4, "Order").attribute("states", facts.order).attribute("length", units.length);
  w.attribute("mass", units.mass).attribute("time", natural_time(scene, units)).end();
  write_choices(w, catalog);
  w.close(3, "Model");
  w.close(2, "Tool");
  w.close(1, "VendorAnnotations");
}

void write_log_categories(Writer& w) {
  w.open(1, "LogCategories").inside();
  for (const LogCategory& c : log_categories) {
    w.open(2, "Category").attribute("name", c.name).attribute("description", c.description).end();
  }
  w.close(1, "LogCategories");
}

// For each variable its position in modelDescription.xml, from 1, as FMI counts; 0: hidden.
using PlacesInFile = std::vector<int>;

PlacesInFile places_in_file(const Catalog& catalog) {
  PlacesInFile out;
  int next = 1;
  for (const Variable& v : catalog.variables()) out.push_back(v.hidden ? 0 : next++);
  return out;
}

void write_type(Writer& w, const Variable& v, const PlacesInFile& places) {
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

void write_variable(Writer& w, const Variable& v, std::size_t value_reference, const PlacesInFile& places) {
  w.open(2, "ScalarVariable").attribute("name", v.name);
  w.attribute("valueReference", static_cast<int>(value_reference)).attribute("description", v.description);
  w.attribute("causality", name_of(v.causality)).attribute("variability", name_of(v.variability));
  if (v.causality == Causality::parameter) w.attribute("initial", "exact");
  if (v.causality == Causality::output || v.causality == Causality::local) w.attribute("initial", "calculated");
  w.inside();
  write_type(w, v, places);
  w.close(2, "ScalarVariable");
}

// An omitted list of dependencies means all of them. Complete lists are therefore omitted if they are long. For large
// coupled models, whose lists would grow quadratically, all long lists are omitted.
constexpr std::size_t short_list = 64;         // dependencies
constexpr std::size_t max_listed = 1'000'000;  // dependencies, in all long lists together

bool lists_are_readable(const std::set<int>& indices, const std::vector<Knowns>& dependencies, std::size_t all) {
  std::size_t sum = 0;
  for (const int index : indices) {
    const std::size_t size = dependencies[static_cast<std::size_t>(index)]->size();
    if (size > short_list && size < all) sum += size;
  }
  return sum <= max_listed;
}

// dependencies: by variable. all: how many knowns make up a list that can be left out.
void write_unknowns(Writer& w, std::string_view element, const std::set<int>& indices,
                    const std::vector<Knowns>& dependencies, std::size_t all, const PlacesInFile& places) {
  if (indices.empty()) return;
  const std::size_t longest =
      lists_are_readable(indices, dependencies, all) ? std::max(all - 1, short_list) : short_list;
  w.open(2, element).inside();
  for (const int index : indices) {
    w.open(3, "Unknown").attribute("index", places[static_cast<std::size_t>(index)]);
    const std::vector<int>& on = *dependencies[static_cast<std::size_t>(index)];
    if (on.size() <= longest) {
      std::string text;
      for (const int known : on)
        text += (text.empty() ? "" : " ") + std::to_string(places[static_cast<std::size_t>(known)]);
      w.attribute("dependencies", text);
    }
    w.end();
  }
  w.close(2, element);
}

void write_structure(Writer& w, const Catalog& catalog, const std::vector<Knowns>& dependencies,
                     const PlacesInFile& places) {
  std::set<int> outputs;
  std::size_t knowns = catalog.states().size();
  for (std::size_t i = 0; i < catalog.variables().size(); ++i) {
    if (catalog.variables()[i].causality == Causality::output) outputs.insert(static_cast<int>(i));
    knowns += catalog.variables()[i].causality == Causality::input ? 1 : 0;
  }
  std::set<int> derivatives;
  std::set<int> initial = outputs;
  for (const State& state : catalog.states()) {
    derivatives.insert(state.derivative);
    initial.insert({state.variable, state.derivative});
  }
  w.open(1, "ModelStructure").inside();
  write_unknowns(w, "Outputs", outputs, dependencies, knowns, places);
  write_unknowns(w, "Derivatives", derivatives, dependencies, knowns, places);
  // Almost all parameters affect everything, so long lists would carry no information.
  write_unknowns(w, "InitialUnknowns", initial, initial_dependencies_of(catalog, dependencies), short_list + 1, places);
  w.close(1, "ModelStructure");
}

void write_metadata(Writer& w, const Scene& scene) {
  Metadata metadata = scene.metadata;
  if (metadata.description.empty()) metadata.description = "Multibody plant " + scene.name;
  for (const MetadataKey& key : metadata_keys) {
    if (const std::string text = on_one_line(metadata.*key.text); !text.empty()) w.attribute(key.name, text);
  }
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= ' ') out += c;
    }
  }
  return out;
}

std::string on_one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::ranges::replace_if(text, [](char c) { return c == '\n' || c == '\t'; }, ' ');
  return text;
}

std::string write_model_description(const Scene& scene, const Catalog& catalog, const std::vector<Knowns>& dependencies,
                                    const FmuFacts& facts) {
  Writer w;
  w.raw("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
  w.open(0, "fmiModelDescription").attribute("fmiVersion", "2.0").attribute("modelName", scene.name);
  w.attribute("guid", facts.guid);
  write_metadata(w, scene);
  w.attribute("generationTool", "Gelenk " + std::string(gelenk_version()));
  w.attribute("variableNamingConvention", "structured")
      .attribute("numberOfEventIndicators", facts.event_indicators.value_or(0));
  w.inside();
  write_capabilities(w, facts);
  write_units(w, catalog);
  write_types(w, catalog);
  write_log_categories(w);
  w.open(1, "DefaultExperiment").attribute("startTime", 0).attribute("stopTime", scene.experiment.stop);
  w.attribute("tolerance", scene.experiment.tolerance).attribute("stepSize", scene.experiment.step).end();
  write_annotations(w, scene, catalog, facts);
  w.open(1, "ModelVariables").inside();
  const PlacesInFile places = places_in_file(catalog);
  for (std::size_t i = 0; i < catalog.variables().size(); ++i) {
    if (!catalog.variables()[i].hidden) write_variable(w, catalog.variables()[i], i, places);
  }
  w.close(1, "ModelVariables");
  write_structure(w, catalog, dependencies, places);
  w.close(0, "fmiModelDescription");
  return w.take();
}

}  // namespace gelenk
