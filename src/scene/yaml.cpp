// SPDX-License-Identifier: BSD-3-Clause
// YAML 1.2 by its core schema (section 10.3.2 of its specification): `1e-6` is a number, `yes` is not a boolean.
#include <yaml-cpp/yaml.h>

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <regex>

#include "scene/read.h"
#include "scene/reader.h"
#include "scene/text.h"

namespace gelenk {
namespace {

constexpr std::size_t most_values = 5'000'000;  // aliases can repeat each other; a scene of 10 000 bodies has some 200 000

bool is_one_of(const std::string& s, std::initializer_list<const char*> words) {
  return std::ranges::any_of(words, [&](const char* word) { return s == word; });
}

// A plain scalar, by what it looks like.
Json resolved(const std::string& s) {
  static const std::regex decimal(R"([-+]?[0-9]+)");
  static const std::regex octal("0o[0-7]+");
  static const std::regex hexadecimal("0x[0-9a-fA-F]+");
  static const std::regex floating(R"([-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?)");
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (s.empty() || is_one_of(s, {"~", "null", "Null", "NULL"})) return nullptr;
  if (is_one_of(s, {"true", "True", "TRUE"})) return true;
  if (is_one_of(s, {"false", "False", "FALSE"})) return false;
  if (is_one_of(s, {".nan", ".NaN", ".NAN"})) return std::numeric_limits<double>::quiet_NaN();
  if (is_one_of(s, {".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"})) return infinity;
  if (is_one_of(s, {"-.inf", "-.Inf", "-.INF"})) return -infinity;
  if (s.size() > 400) return s;  // no number is so long; std::regex would recurse
  const bool whole = std::regex_match(s, decimal);
  const int base = whole ? 10 : std::regex_match(s, octal) ? 8 : std::regex_match(s, hexadecimal) ? 16 : 0;
  if (base != 0) {
    const char* first = s.data() + (whole ? (s[0] == '+' ? 1 : 0) : 2);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(first, s.data() + s.size(), value, base);
    if (error == std::errc() && end == s.data() + s.size()) return value;
    if (!whole) return s;
  }
  if (!whole && !std::regex_match(s, floating)) return s;
  const char* first = s.data() + (s[0] == '+' ? 1 : 0);
  double value = 0;
  if (std::from_chars(first, s.data() + s.size(), value).ec == std::errc()) return value;
  return std::strtod(first, nullptr);  // out of range: infinity or zero, whatever the decimal point is called here
}

class Converter {
 public:
  explicit Converter(Faults& faults) : faults_(faults) {}

  Json convert(const YAML::Node& node, const std::string& path, std::size_t level = 0) {
    if (++values_ > most_values) fail(path, "aliases that stand for more than 5000000 values", "a scene");
    if (level >= deepest_level) {
      fail(path, "more than " + std::to_string(deepest_level) + " levels of nesting", "a scene, which has seven");
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
    std::abort();  // not reached: there is a fault
  }

  Faults& faults_;
  std::size_t values_ = 0;
};

}  // namespace

Scene read_scene_yaml(std::string_view text, const std::string& file) {
  Faults faults(file);
  Json tree;
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(std::string(text));
    if (documents.size() > 1) {
      faults.add("", std::to_string(documents.size()) + " documents", "one scene");
      faults.raise();
    }
    if (!documents.empty()) tree = Converter(faults).convert(documents.front(), "");
  } catch (const YAML::Exception& error) {
    const std::string place =
        error.mark.is_null() ? "" : ":" + std::to_string(error.mark.line + 1) + ":" + std::to_string(error.mark.column + 1);
    throw SceneError({faults.file() + place + ": " + error.msg});
  }
  return scene_from_tree(tree, file, faults);
}

}  // namespace gelenk
