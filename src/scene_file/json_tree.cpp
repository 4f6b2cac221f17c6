// SPDX-License-Identifier: BSD-3-Clause
#include "scene_file/json_tree.h"

#include <algorithm>
#include <array>
#include <deque>
#include <limits>
#include <unordered_set>
#include <utility>

#include "scene/scene.h"
#include "scene_file/read.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Many programs write NaN and Infinity, which are syntax errors for the JSON library. To report them with their path,
// as other invalid numbers are, each is replaced before parsing by an otherwise unused string of the same length (so
// that columns remain correct), and converted back to a number in the tree.
//
// A NUL between values ends the text for the JSON library, ignoring the rest. It is replaced by another control
// character, which is reported as a syntax error.
struct NotFinite {
  std::string_view word, placeholder;
  double value;
};
constexpr std::array<NotFinite, 3> not_finite = {{
    {"NaN", "\"\x7f\"", std::numeric_limits<double>::quiet_NaN()},
    {"Infinity", "\"\x7f\x7f\x7f\x7f\x7f\x7f\"", std::numeric_limits<double>::infinity()},
    {"-Infinity", "\"\x7f\x7f\x7f\x7f\x7f\x7f\x7f\"", -std::numeric_limits<double>::infinity()},
}};

std::string with_placeholders(std::string_view text) {
  std::string out(text);
  bool in_string = false;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (in_string && out[i] == '\\') {
      ++i;
    } else if (out[i] == '"') {
      in_string = !in_string;
    } else if (!in_string && out[i] == '\0') {
      out[i] = '\x01';
    } else if (!in_string) {
      for (const NotFinite& n : not_finite) {
        if (text.substr(i, n.word.size()) != n.word) continue;
        out.replace(i, n.word.size(), n.placeholder);
        i += n.word.size() - 1;
        break;
      }
    }
  }
  return out;
}

// Returns "line:column" of a byte, both counted from 1; columns are characters, not bytes.
std::string line_and_column(std::string_view text, std::size_t byte) {
  std::size_t line = 1;
  std::size_t column = 1;
  for (std::size_t i = 0; i < std::min(byte, text.size()); ++i) {
    if (text[i] == '\n') {
      ++line;
      column = 1;
    } else if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) {
      ++column;
    }
  }
  return std::to_string(line) + ":" + std::to_string(column);
}

// Builds the tree from the parser's events.
class TreeBuilder final : public nlohmann::json_sax<Json> {
 public:
  TreeBuilder(std::string_view text, const std::string& file, Faults& faults)
      : text_(text), file_(file), faults_(faults) {}

  Json take() { return std::move(root_); }

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t&) override { return put(value); }
  bool binary(binary_t&) override { return false; }  // does not occur in JSON text

  bool string(string_t& value) override {
    for (const NotFinite& n : not_finite) {
      if (value == n.placeholder.substr(1, n.placeholder.size() - 2)) return put(n.value);
    }
    return put(std::move(value));
  }

  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    Level& level = levels_.back();
    level.name = name;
    level.skip = !level.names.insert(name).second;
    if (level.skip) faults_.add(path(), "twice", "every name once");
    return true;
  }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override {
    const std::size_t byte = position > 0 ? position - 1 : 0;
    throw SceneError({file_ + ":" + line_and_column(text_, byte) + ": " + explained(byte, error)});
  }

 private:
  struct Level {
    Json* container;
    std::string name;                       // name of the entry being read, in a mapping
    bool skip = false;                      // the name occurs a second time
    std::unordered_set<std::string> names;  // seen so far
    Json dropped;                           // receives skipped values
  };

  std::string explained(std::size_t byte, const nlohmann::detail::exception& error) const {
    if (error.id == 406)
      return "found a number larger than 1.8e308, expected a number in the range of double precision";
    const std::string found = byte < text_.size() ? text::quoted(text_.substr(byte, 1)) : "the end of the file";
    constexpr std::string_view marker = "; expected ";
    const std::string_view words = error.what();
    const std::size_t at = words.find(marker);
    const std::string_view expected = at == words.npos ? "well-formed JSON" : words.substr(at + marker.size());
    return "found " + found + ", expected " +
           (expected == "string literal" ? "a name in double quotes" : std::string(expected)) + advice(byte);
  }

  // Returns a hint about syntax that other formats permit but JSON does not.
  std::string advice(std::size_t byte) const {
    if (byte >= text_.size()) return "; a bracket, brace or quote is not closed";
    const char c = text_[byte];
    const std::size_t before = text_.substr(0, byte).find_last_not_of(" \t\r\n");
    if ((c == '}' || c == ']') && before != text_.npos && text_[before] == ',')
      return "; leave out the comma before it";
    if (c == '/' || c == '#') return "; JSON has no comments";
    if (c == '\'') return "; JSON requires double quotes";
    return {};
  }

  std::string path() const {
    std::string out;
    for (const Level& level : levels_) {
      if (level.container->is_array()) {
        const bool innermost = &level == &levels_.back();  // its next element has not been added yet
        out += "[" + std::to_string(level.container->size() + (innermost ? 1 : 0)) + "]";
      } else {
        out += (out.empty() ? "" : ".") + text::printable(level.name);
      }
    }
    return out;
  }

  template <class Value>
  bool put(Value&& value) {
    slot(std::forward<Value>(value));
    return true;
  }

  // Appends to the innermost container without searching for the name, so that large mappings take linear time.
  Json* slot(Json value) {
    if (levels_.empty()) {
      root_ = std::move(value);
      return &root_;
    }
    Level& level = levels_.back();
    if (level.container->is_array()) {
      level.container->push_back(std::move(value));
      return &level.container->back();
    }
    if (level.skip) {
      level.dropped = std::move(value);
      return &level.dropped;
    }
    auto& entries = static_cast<Json::object_t::Container&>(level.container->get_ref<Json::object_t&>());
    entries.emplace_back(level.name, std::move(value));
    return &entries.back().second;
  }

  bool open(Json empty) {
    if (levels_.size() >= max_nesting) {
      faults_.add(text::printable(path()), "more than " + std::to_string(max_nesting) + " levels of nesting",
                  "a scene, which has at most seven");
      faults_.raise();
    }
    Json* container = slot(std::move(empty));
    levels_.push_back({container, {}, false, {}, {}});
    return true;
  }

  bool close() {
    levels_.pop_back();
    return true;
  }

  std::string_view text_;
  const std::string& file_;
  Faults& faults_;
  Json root_;
  std::deque<Level> levels_;  // not a vector: addresses of levels must remain valid
};

}  // namespace

void check_size(std::size_t bytes, const std::string& file) {
  if (bytes <= max_scene_bytes) return;
  throw SceneError({file + ": found " + std::to_string(bytes / 1'000'000) + " MB, expected a scene of at most " +
                    std::to_string(max_scene_bytes / 1'000'000) + " MB"});
}

Json parse_json(std::string_view text, const std::string& file, Faults& faults) {
  check_size(text.size(), file);
  const std::string source = with_placeholders(text);
  TreeBuilder builder(text, file, faults);
  Json::sax_parse(source, &builder);
  return builder.take();
}

}  // namespace gelenk
