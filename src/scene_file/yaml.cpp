// SPDX-License-Identifier: BSD-3-Clause
// Reads YAML 1.2 with its core schema (specification, section 10.3.2): `1e-6` is a number, `yes` is not a boolean.
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <sstream>

#include "check/warnings.h"
#include "scene_file/read.h"
#include "scene_file/reader.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Limit of the number of values, since aliases can expand exponentially; a scene of 10 000 bodies has about 200 000.
constexpr std::size_t max_values = 5'000'000;

bool is_one_of(const std::string& s, std::initializer_list<const char*> words) {
  return std::ranges::any_of(words, [&](const char* word) { return s == word; });
}

// Returns the number of consecutive digits in this base from `at`.
std::size_t digits_of(std::string_view s, std::size_t at, int base) {
  const std::string_view known = std::string_view("0123456789abcdef").substr(0, static_cast<std::size_t>(base));
  std::size_t n = 0;
  while (at + n < s.size() && known.find(text::lower(s[at + n])) != known.npos) ++n;
  return n;
}

// Matches [-+]? ( [0-9]+ (\. [0-9]*)? | \. [0-9]+ ) ([eE] [-+]? [0-9]+)?
bool is_decimal(std::string_view s) {
  const auto sign = [&](std::size_t at) { return at < s.size() && (s[at] == '-' || s[at] == '+') ? at + 1 : at; };
  std::size_t at = sign(0);
  const std::size_t whole = digits_of(s, at, 10);
  at += whole;
  std::size_t fraction = 0;
  if (at < s.size() && s[at] == '.') {
    fraction = digits_of(s, at + 1, 10);
    at += 1 + fraction;
  }
  if (whole + fraction == 0) return false;
  if (at == s.size()) return true;
  if (s[at] != 'e' && s[at] != 'E') return false;
  at = sign(at + 1);
  const std::size_t exponent = digits_of(s, at, 10);
  return exponent > 0 && at + exponent == s.size();
}

// Returns the value of an octal (0o17) or hexadecimal (0xff) number, or null.
Json prefixed_number(const std::string& s) {
  const int base = s.starts_with("0o") ? 8 : s.starts_with("0x") ? 16 : 0;
  if (base == 0 || s.size() < 3 || digits_of(s, 2, base) != s.size() - 2) return nullptr;
  double value = 0;  // exact up to 2^53; all numbers of a scene become doubles anyway
  for (const char c : s.substr(2)) value = base * value + (c <= '9' ? c - '0' : text::lower(c) - 'a' + 10);
  return value;
}

double decimal(const std::string& s) {
  const char* first = s.data() + (s[0] == '+' ? 1 : 0);
  double value = 0;
  if (std::from_chars(first, s.data() + s.size(), value).ec == std::errc()) return value;
  return std::strtod(first, nullptr);  // out of range: infinity or zero in every locale
}

// Returns the value of a plain scalar according to its form.
Json resolved(const std::string& s) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (s.empty() || is_one_of(s, {"~", "null", "Null", "NULL"})) return nullptr;
  if (is_one_of(s, {"true", "True", "TRUE"})) return true;
  if (is_one_of(s, {"false", "False", "FALSE"})) return false;
  if (is_one_of(s, {".nan", ".NaN", ".NAN"})) return std::numeric_limits<double>::quiet_NaN();
  if (is_one_of(s, {".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"})) return infinity;
  if (is_one_of(s, {"-.inf", "-.Inf", "-.INF"})) return -infinity;
  if (is_decimal(s)) return decimal(s);
  const Json number = prefixed_number(s);
  return number.is_null() ? Json(s) : number;
}

class Converter {
 public:
  explicit Converter(Faults& faults) : faults_(faults) {}

  Json convert(const YAML::Node& node, const std::string& path, std::size_t level = 0) {
    if (++values_ > max_values) fail(path, "aliases that expand to more than 5000000 values", "a scene");
    if (level >= max_nesting) {
      fail(path, "more than " + std::to_string(max_nesting) + " levels of nesting", "a scene, which has at most seven");
    }
    if (node.IsScalar()) return node.Tag() == "!" ? Json(node.Scalar()) : resolved(node.Scalar());
    if (node.IsSequence()) return sequence(node, path, level);
    if (node.IsMap()) return mapping(node, path, level);
    return nullptr;
  }

 private:
  Json sequence(const YAML::Node& node, const std::string& path, std::size_t level) {
    Json out = Json::array();
    for (const auto& item : node) {
      out.push_back(convert(item, path + "[" + std::to_string(out.size() + 1) + "]", level + 1));
    }
    return out;
  }

  Json mapping(const YAML::Node& node, const std::string& path, std::size_t level) {
    Json out = Json::object();
    auto& entries = static_cast<Json::object_t::Container&>(out.get_ref<Json::object_t&>());
    std::set<std::string> seen;
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) {
        faults_.add(path, "a list or mapping as the name of a field", "a word");
        continue;
      }
      const std::string& key = entry.first.Scalar();
      const std::string inner = (path.empty() ? "" : path + ".") + text::printable(key);
      if (!seen.insert(key).second) {
        faults_.add(inner, "twice", "every name once");
        continue;
      }
      entries.emplace_back(key, convert(entry.second, inner, level + 1));
    }
    return out;
  }

  [[noreturn]] void fail(const std::string& path, const std::string& found, const std::string& expected) {
    faults_.add(path, found, expected);
    faults_.raise();
    std::abort();  // not reached: raise() throws
  }

  Faults& faults_;
  std::size_t values_ = 0;
};

// Event handler that ignores all events of a document.
struct IgnoreEvents final : YAML::EventHandler {
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

// Returns true if the file has one document. YAML::Load stops at the end of the first document, and YAML::LoadAll does
// not terminate on some malformed files (0.7: a closing bracket without an opening one), so that only the presence of a
// second document is tested.
bool one_document(const std::string& source) {
  std::istringstream stream(source);
  YAML::Parser parser(stream);
  IgnoreEvents events;
  return !parser.HandleNextDocument(events) || !parser.HandleNextDocument(events);
}

}  // namespace

Scene read_scene_yaml(std::string_view text, const std::string& file) {
  std::vector<std::string> warnings;
  return read_scene_yaml(text, file, warnings);
}

Scene read_scene_yaml(std::string_view text, const std::string& file, std::vector<std::string>& warnings) {
  check_size(text.size(), file);
  Faults faults(file);
  const std::size_t bad = text::first_not_utf8(text);
  if (bad != text.npos) faults.add("", "byte " + std::to_string(bad + 1) + " that is not UTF-8", "UTF-8 text");
  faults.raise();
  Json tree;
  try {
    const std::string source(text);
    if (!one_document(source)) faults.add("", "something after the end of the first YAML document", "one scene");
    faults.raise();
    tree = Converter(faults).convert(YAML::Load(source), "");
  } catch (const YAML::Exception& error) {
    const std::string place =
        error.mark.is_null() ? ""
                             : ":" + std::to_string(error.mark.line + 1) + ":" + std::to_string(error.mark.column + 1);
    throw SceneError({faults.file() + place + ": " + error.msg});
  }
  Scene scene = scene_from_tree(tree, file, faults);
  find_warnings(scene, faults);
  warnings.insert(warnings.end(), faults.warnings().begin(), faults.warnings().end());
  return scene;
}

}  // namespace gelenk
