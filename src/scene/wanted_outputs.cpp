// SPDX-License-Identifier: BSD-3-Clause
#include "scene/wanted_outputs.h"

#include <algorithm>
#include <set>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "scene/settable.h"
#include "scene/signals.h"
#include "util/text.h"

namespace gelenk {
namespace {

constexpr std::string_view special = "*?[";

bool is_pattern(std::string_view text) { return text.find_first_of(special) != std::string_view::npos; }

// Returns the position behind the bracketed set that begins at `at`, or `at` if the set is not closed. A leading ] is a
// member of the set.
std::size_t end_of_set(std::string_view pattern, std::size_t at) {
  std::size_t i = at + 1;
  if (i < pattern.size() && pattern[i] == '!') ++i;
  const std::size_t close = pattern.find(']', i + 1);
  return close == std::string_view::npos ? at : close + 1;
}

// Returns true if the set, given with its brackets, has the character.
bool in_set(std::string_view set, char c) {
  set = set.substr(1, set.size() - 2);
  const bool without = set.front() == '!';
  if (without) set.remove_prefix(1);
  bool found = false;
  for (std::size_t i = 0; i < set.size(); ++i) {
    const bool range = i + 2 < set.size() && set[i + 1] == '-';
    found = found || (range ? set[i] <= c && c <= set[i + 2] : set[i] == c);
    if (range) i += 2;
  }
  return found != without;
}

// Glob matching with backtracking to the last star only, which is sufficient: it can always take more characters.
bool matches(std::string_view pattern, std::string_view name) {
  std::size_t p = 0;
  std::size_t n = 0;
  std::size_t star = std::string_view::npos;
  std::size_t taken = 0;  // end of what the last star has taken
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      taken = n;
      continue;
    }
    const std::size_t end = p < pattern.size() && pattern[p] == '[' ? end_of_set(pattern, p) : p;
    const bool matched = end > p              ? in_set(pattern.substr(p, end - p), name[n])
                         : p < pattern.size() ? pattern[p] == '?' || pattern[p] == name[n]
                                              : false;
    if (matched) {
      p = std::max(end, p + 1);
      ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++taken;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

// A name split at its index: "tip.r[2]" has base "tip.r" and index "2"; without an index, that is empty.
struct Indexed {
  std::string_view base, index;
  explicit Indexed(std::string_view name) : base(name) {
    const std::size_t open = name.rfind('[');
    if (open == std::string_view::npos || name.back() != ']') return;
    base = name.substr(0, open);
    index = name.substr(open + 1, name.size() - open - 2);
  }
};

bool is_any(std::string_view index) { return index == "*" || index == "?"; }

std::string owner_of(std::string_view name) { return std::string(name.substr(0, name.find('.'))); }

// Explains why an entry selects no output.
class Explainer {
 public:
  explicit Explainer(const Scene& scene, const std::vector<Signal>& outputs) : scene_(scene) {
    for (const Signal& s : outputs) {
      names_.push_back(s.name);
      if (owners_.empty() || owners_.back() != owner_of(s.name)) owners_.push_back(owner_of(s.name));
    }
    for (const Signal& s : input_signals(scene)) inputs_.insert(s.name);
    for (const Signal& s : diagnostic_signals()) diagnostics_.insert(s.name);
  }

  std::string explain(const std::string& entry) const {
    const std::string found = "found " + text::quoted(entry);
    if (entry.empty()) return "found nothing, expected the name of an output, or a pattern";
    if (inputs_.contains(entry)) {
      return found + ", an input, expected an output (an input is always included with the part it acts on)";
    }
    if (diagnostics_.contains(entry))
      return found + ", a diagnostic, expected an output (diagnostics are always included)";
    const std::string owner = owner_of(entry);
    if (const std::string body = of_body(entry, owner); !body.empty()) return found + body;
    if (is_parameter(entry)) {
      return found + ", a parameter, expected an output (a parameter is always included with the part it belongs to)";
    }
    const auto is_of_owner = [&](const std::string& input) { return input.starts_with(owner + "."); };
    if (entry == owner && !has_outputs(owner) && std::ranges::any_of(inputs_, is_of_owner)) {
      return found +
             ", which has inputs only, expected an output (an input is always included with the part it acts on)";
    }
    const std::string expected = is_pattern(entry)
                                     ? ", a pattern that matches no output, expected one that matches at least one"
                                     : ", expected an output";
    return found + expected + hint(entry, owner);
  }

 private:
  bool has_outputs(const std::string& owner) const { return std::ranges::find(owners_, owner) != owners_.end(); }

  // Explains that bodies have parameters but no outputs.
  std::string of_body(const std::string& entry, const std::string& owner) const {
    const bool whole = entry == owner || entry == owner + ".*";
    const bool body = owner == ground || std::ranges::find(scene_.bodies, owner, &Body::name) != scene_.bodies.end();
    if (!whole || !body || has_outputs(owner)) return {};
    std::vector<std::string> joints;
    for (const Joint& joint : scene_.joints) {
      if ((joint.parent.body == owner || joint.child.body == owner) && has_outputs(joint.name)) {
        joints.push_back(joint.name + ".*");
      }
    }
    return ", a body, which has no outputs of its own, expected those of its joints" +
           (joints.empty() ? "" : ": " + text::some(joints));
  }

  // Returns true for fields of elements, settings and start values.
  bool is_parameter(const std::string& entry) const {
    const std::string base(Indexed(entry).base);
    if (base.starts_with("solver.") || base == "gravity") return true;
    if (base.ends_with(".m") || base.ends_with(".fixed") || base.ends_with("_start")) return !is_pattern(base);
    const std::vector<Settable> all = settables(scene_);
    return std::ranges::find(all, base, &Settable::path) != all.end();
  }

  std::string hint(const std::string& entry, const std::string& owner) const {
    const auto array = std::ranges::find_if(names_, [&](const std::string& n) { return n.starts_with(entry + "["); });
    if (array != names_.end()) return "; did you mean '" + entry + "[*]'?";
    if (has_outputs(owner) && entry == owner) return "; did you mean '" + owner + ".*'?";
    if (!is_pattern(entry)) {
      const std::string near = text::nearest(entry, names_);
      if (!near.empty()) return "; did you mean '" + near + "'?";
    }
    if (!is_pattern(owner) && !has_outputs(owner)) {
      const std::string near = text::nearest(owner, owners_);
      if (!near.empty()) return "; did you mean '" + near + (entry == owner ? ".*" : entry.substr(owner.size())) + "'?";
    }
    return names_.size() <= 12 ? "; there are " + text::list(names_) : "";
  }

  const Scene& scene_;
  std::vector<std::string> names_, owners_;
  std::unordered_set<std::string> inputs_, diagnostics_;
};

// Calls take(entry, output) for each output that an entry selects.
template <class Take>
void each_match(const std::vector<Signal>& outputs, const std::vector<std::string>& entries, Take take) {
  std::unordered_map<std::string_view, std::size_t> number;
  for (std::size_t i = 0; i < outputs.size(); ++i) number.emplace(outputs[i].name, i);
  for (std::size_t e = 0; e < entries.size(); ++e) {
    if (const auto exact = number.find(entries[e]); exact != number.end()) {
      take(e, exact->second);
    } else if (is_pattern(entries[e])) {
      for (std::size_t i = 0; i < outputs.size(); ++i) {
        if (output_matches(entries[e], outputs[i].name)) take(e, i);
      }
    }
  }
}

}  // namespace

bool output_matches(std::string_view pattern, std::string_view name) {
  if (pattern == name || matches(pattern, name)) return true;
  const Indexed of_pattern(pattern);
  const Indexed of_name(name);
  if (of_pattern.index.empty() || of_name.index.empty() || !matches(of_pattern.base, of_name.base)) return false;
  if (is_any(of_pattern.index)) return true;
  const std::string_view set = pattern.substr(of_pattern.base.size());
  return of_name.index.size() == 1 && of_pattern.index != "!" && in_set(set, of_name.index.front());
}

std::vector<bool> wanted_outputs(const Scene& scene) {
  const std::vector<Signal> outputs = output_signals(scene);
  std::vector<bool> wanted(outputs.size(), scene.outputs.empty());
  each_match(outputs, scene.outputs, [&](std::size_t, std::size_t output) { wanted[output] = true; });
  return wanted;
}

std::vector<std::string> faults_of_outputs(const Scene& scene, const std::vector<std::string>& outputs) {
  const std::vector<Signal> signals = output_signals(scene);
  std::vector<bool> matched(outputs.size(), false);
  each_match(signals, outputs, [&](std::size_t entry, std::size_t) { matched[entry] = true; });
  const Explainer explainer(scene, signals);
  std::set<std::string_view> seen;
  std::vector<std::string> faults;
  for (std::size_t e = 0; e < outputs.size(); ++e) {
    const bool again = !seen.insert(outputs[e]).second;
    faults.push_back(!matched[e] ? explainer.explain(outputs[e])
                     : again     ? "found " + text::quoted(outputs[e]) + " again, expected every entry once"
                                 : "");
  }
  return faults;
}

}  // namespace gelenk
