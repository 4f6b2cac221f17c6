// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <set>
#include <string_view>
#include <unordered_map>

#include "check/check.h"
#include "scene/settable.h"
#include "util/text.h"

namespace gelenk {
namespace {

// A path split at its index: "crank.com[2]" has base "crank.com" and index "2"; without an index, that is empty.
struct Split {
  std::string base, index;
};

Split split(const std::string& path) {
  const std::size_t open = path.find('[');
  if (open == std::string::npos || path.back() != ']') return {path, ""};
  return {path.substr(0, open), path.substr(open + 1, path.size() - open - 2)};
}

bool index_fits(const std::string& index, int size) {
  for (int i = 1; i <= size; ++i) {
    if (index == std::to_string(i)) return true;
  }
  return false;
}

// Returns the expected paths: the fields of the owner ("crank") if it exists, else a general description.
std::string expected(const Split& path, const std::vector<Settable>& all) {
  const std::string owner = path.base.substr(0, path.base.find('.'));
  std::vector<std::string> fields;
  std::vector<std::string> owners;
  for (const Settable& s : all) {
    const std::string name = s.path.substr(0, s.path.find('.'));
    if (name == owner) fields.push_back(s.path);
    if (owners.empty() || owners.back() != name) owners.push_back(name);
  }
  if (!fields.empty()) return text::one_of(path.base, fields, "fields");
  const std::string near = text::nearest(owner, owners);
  return "gravity or a field of a body, joint, motor, force or constraint" +
         (near.empty() ? "" : "; did you mean '" + near + "'?");
}

}  // namespace

void check_parameters(const Scene& scene, Faults& faults, const SuspectNames& suspect_names) {
  if (scene.parameters.empty()) return;
  const std::vector<Settable> all = settables(scene);
  std::unordered_map<std::string_view, const Settable*> named;
  for (const Settable& settable : all) named.emplace(settable.path, &settable);
  std::set<std::string> seen;
  for (std::size_t i = 0; i < scene.parameters.size(); ++i) {
    const std::string& parameter = scene.parameters[i];
    const std::string path = "parameters[" + std::to_string(i + 1) + "]";
    const Split given = split(parameter);
    if (parameter.empty() || suspect_names.contains(given.base.substr(0, given.base.find('.')))) continue;
    const auto entry = named.find(given.base);
    const Settable* found = entry == named.end() ? nullptr : entry->second;
    if (found == nullptr) {
      faults.add(path, text::quoted(parameter), expected(given, all));
    } else if (!given.index.empty() && found->size == 1) {
      faults.add(path, text::quoted(parameter), found->path + ", which is a scalar");
    } else if (!given.index.empty() && !index_fits(given.index, found->size)) {
      faults.add(path, text::quoted(parameter), "an index from 1 to " + std::to_string(found->size));
    } else if (!seen.insert(parameter).second || (!given.index.empty() && seen.contains(given.base))) {
      faults.add(path, text::quoted(parameter) + " again", "every parameter once");
    }
  }
}

}  // namespace gelenk
