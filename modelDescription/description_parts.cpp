// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/description_parts.h"

#include <algorithm>

#include "modelDescription/capabilities.h"
#include "modelDescription/units.h"
#include "scene/natural_time.h"

namespace gelenk {
namespace {

void write_unit(XmlWriter& w, const std::string& unit) {
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
std::vector<Structure::Unknown> unknowns_of(const std::set<int>& indices, const std::vector<Knowns>& dependencies,
                                            std::size_t all) {
  const std::size_t longest =
      lists_are_readable(indices, dependencies, all) ? std::max(all - 1, short_list) : short_list;
  std::vector<Structure::Unknown> out;
  for (const int index : indices) {
    const std::vector<int>& on = *dependencies[static_cast<std::size_t>(index)];
    out.push_back({index, on.size() <= longest ? &on : nullptr});
  }
  return out;
}

}  // namespace

const char* name_of(Causality causality) {
  switch (causality) {
    case Causality::input:
      return "input";
    case Causality::output:
      return "output";
    case Causality::parameter:
      return "parameter";
    case Causality::independent:
      return "independent";
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

Structure::Structure(const Catalog& catalog, const std::vector<Knowns>& dependencies)
    : dependencies_(dependencies), initial_dependencies_(initial_dependencies_of(catalog, dependencies)) {
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
  outputs_ = unknowns_of(outputs, dependencies_, knowns);
  derivatives_ = unknowns_of(derivatives, dependencies_, knowns);
  // Almost all parameters affect everything, so long lists would carry no information.
  initial_ = unknowns_of(initial, initial_dependencies_, short_list + 1);
}

void write_units(XmlWriter& w, const Catalog& catalog, const std::vector<bool>& is_shown) {
  std::set<std::string> used;
  for (std::size_t i = 0; i < is_shown.size(); ++i) {
    const std::string& unit = catalog.variables()[i].unit;
    if (is_shown[i] && !unit.empty()) used.insert(unit);
  }
  w.open(1, "UnitDefinitions").inside();
  for (const std::string& unit : used) write_unit(w, unit);
  w.close(1, "UnitDefinitions");
}

void write_log_categories(XmlWriter& w) {
  w.open(1, "LogCategories").inside();
  for (const LogCategory& c : log_categories) {
    w.open(2, "Category").attribute("name", c.name).attribute("description", c.description).end();
  }
  w.close(1, "LogCategories");
}

void write_metadata(XmlWriter& w, const Scene& scene) {
  Metadata metadata = scene.metadata;
  if (metadata.description.empty()) metadata.description = "Multibody plant " + scene.name;
  for (const MetadataKey& key : metadata_keys) {
    if (const std::string text = on_one_line(metadata.*key.text); !text.empty()) w.attribute(key.name, text);
  }
}

void write_default_experiment(XmlWriter& w, const Scene& scene) {
  w.open(1, "DefaultExperiment").attribute("startTime", 0).attribute("stopTime", scene.experiment.stop);
  w.attribute("tolerance", scene.experiment.tolerance).attribute("stepSize", scene.experiment.step).end();
}

void write_order(XmlWriter& w, int depth, const Scene& scene, const FmuFacts& facts) {
  const UnitSystem units = natural_units(scene);
  w.open(depth, "Order").attribute("states", facts.order).attribute("length", units.length);
  w.attribute("mass", units.mass).attribute("time", natural_time(scene, units)).end();
}

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

}  // namespace gelenk
