// SPDX-License-Identifier: BSD-3-Clause
#include "scene_file/element_fields.h"

#include <algorithm>
#include <utility>

#include "check/check.h"
#include "scene_file/frames.h"
#include "util/text.h"

namespace gelenk {
namespace {

std::string unit_for_people(const Field& field, const Coordinate& coordinate) {
  return spelled(unit_of(field, coordinate));
}

std::vector<std::string> words_of(const Field& field) { return {field.words.begin(), field.words.end()}; }

std::vector<std::string> field_names(std::span<const Field> fields) {
  std::vector<std::string> names;
  for (const Field& field : fields) names.emplace_back(field.name);
  return names;
}

// Reads a list of at least field.min_count numbers.
std::vector<double> read_numbers(const Json& value, const std::string& path, Faults& faults, const Field& field,
                                 const Coordinate& coordinate) {
  const std::size_t min_size = field.min_count;
  if (!value.is_array() || value.size() < min_size) {
    faults.add(path, shown(value),
               min_size == 1 ? "a list of numbers" : "a list of " + std::to_string(min_size) + " numbers or more");
    return {};
  }
  std::vector<double> out;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto number =
        read_number(value[i], path + "[" + std::to_string(i + 1) + "]", faults, spelled(unit_of(field, coordinate, i)));
    if (number) out.push_back(*number);
  }
  return out;
}

std::string expected_of(const Field& field, const Coordinate& coordinate) {
  if (field.type == Field::Type::choice) return "one of " + text::list(words_of(field));
  const std::string unit = unit_for_people(field, coordinate);
  const std::string in_unit = unit.empty() ? "" : " in " + unit;
  if (field.type == Field::Type::formula || field.type == Field::Type::formulas) {
    std::vector<std::string> names;
    for (const FormulaVariable& variable : variables_of(field, coordinate)) {
      if (!variable.name.empty()) names.emplace_back(variable.name);
    }
    if (field.reads != FormulaReads::nothing) {
      std::erase(names, "t");  // that of motions
      names.insert(names.end(), {"t", "inputs", "states", "coordinates of joints"});
    }
    if (field.reads == FormulaReads::forces) names.emplace_back("forces");
    return "an expression of " + text::list(names) + in_unit;
  }
  return (field.type == Field::Type::numbers ? "a list of numbers" : "a number") + in_unit;
}

void read_choice(const Json& value, const std::string& path, Faults& faults, const Field& field, Choice& choice) {
  const std::vector<std::string> words = words_of(field);
  if (!value.is_string()) return faults.add(path, shown(value), expected_of(field, {}));
  const auto& word = value.get_ref<const std::string&>();
  const auto found = std::ranges::find(words, word);
  if (found == words.end()) return faults.add(path, text::quoted(word), text::one_of(word, words, "words"));
  choice.index = static_cast<int>(found - words.begin());
}

FormulaBounds bounds_of(Range range) {
  FormulaBounds out;
  if (range == Range::not_negative || range == Range::fraction) out.lower = 0;
  if (range == Range::fraction || range == Range::at_most_one) out.upper = 1;
  return out;
}

void read_formula(const Json& value, const std::string& path, Faults& faults, const Field& field,
                  const Coordinate& coordinate, const FormulaNames& names, Formula& formula) {
  if (!value.is_string() && !value.is_number()) return faults.add(path, shown(value), expected_of(field, coordinate));
  const std::string text = value.is_number() ? text::number(value.get<double>()) : value.get<std::string>();
  try {
    formula = Formula(text, variables_of(field, coordinate), names, field.reads, bounds_of(field.range));
  } catch (const expression::SyntaxError& error) {
    faults.add(path, text::quoted(text), expected_of(field, coordinate) + "; " + with_caret(error, text));
  }
}

// Of those that are given; null if none is.
Json texts_of(std::span<const Formula> formulas) {
  Json out;
  for (const Formula& formula : formulas) {
    if (formula.is_given()) out.push_back(std::string(formula.text()));
  }
  return out;
}

}  // namespace

void read_field(const Json& value, const std::string& path, Faults& faults, const Field& field, void* element,
                const Coordinate& coordinate, const FormulaNames& names) {
  const std::string unit = unit_for_people(field, coordinate);
  switch (field.type) {
    case Field::Type::number: {
      auto& x = field.of<double>(element);
      x = read_number(value, path, faults, unit, field.range).value_or(x);
      return;
    }
    case Field::Type::vector: {
      auto& x = field.of<Eigen::Vector3d>(element);
      const auto list = read_list(value, path, faults, 3, unit, field.range);
      if (list) x = Eigen::Vector3d((*list)[0], (*list)[1], (*list)[2]);
      return;
    }
    case Field::Type::direction: {
      auto& x = field.of<Direction>(element);
      x.along = read_direction(value, path, faults).value_or(x.along);
      return;
    }
    case Field::Type::numbers:
      field.of<std::vector<double>>(element) = read_numbers(value, path, faults, field, coordinate);
      return;
    case Field::Type::flag:
      if (!value.is_boolean()) return faults.add(path, shown(value), "true or false");
      field.of<bool>(element) = value.get<bool>();
      return;
    case Field::Type::choice:
      return read_choice(value, path, faults, field, field.of<Choice>(element));
    case Field::Type::formula:
      return read_formula(value, path, faults, field, coordinate, names, field.of<Formula>(element));
    case Field::Type::formulas: {
      const std::span<Formula> all = formulas_of(field, element);
      if (!value.is_array() || value.size() != all.size())
        return faults.add(path, shown(value), "a list of 3: each " + expected_of(field, coordinate));
      for (std::size_t i = 0; i < all.size(); ++i)
        read_formula(value[i], path + "[" + std::to_string(i + 1) + "]", faults, field, coordinate, names, all[i]);
      return;
    }
    case Field::Type::group: {
      Fields inner(value, path, faults, "a mapping with " + text::list(field_names(field.inner())));
      if (!inner.valid()) return;
      field.emplace(element);
      read_fields(inner, field.inner(), field.in(element), coordinate, names);
      inner.done();
    }
  }
}

void read_fields(Fields& from, std::span<const Field> fields, void* element, const Coordinate& coordinate,
                 const FormulaNames& names) {
  for (const Field& field : fields) {
    const std::string name(field.name);
    const Json* value = field.required ? from.require(name, expected_of(field, coordinate)) : from.find(name);
    if (value != nullptr) read_field(*value, from.path(name), from.faults(), field, element, coordinate, names);
  }
}

void write_fields(Json& to, std::span<const Field> fields, const void* element) {
  for (const Field& field : fields) {
    Json& value = to[std::string(field.name)];
    switch (field.type) {
      case Field::Type::number:
        if (const double x = field.of<double>(element); std::isfinite(x)) value = x;
        break;
      case Field::Type::vector:
        value = numbers_of(field.of<Eigen::Vector3d>(element));
        break;
      case Field::Type::direction:
        value = numbers_of(field.of<Direction>(element).along);
        break;
      case Field::Type::numbers:
        if (const auto& list = field.of<std::vector<double>>(element); !list.empty()) value = numbers_of(list);
        break;
      case Field::Type::flag:
        value = field.of<bool>(element);
        break;
      case Field::Type::choice:
        if (const int i = field.of<Choice>(element).index; i != Choice::none) {
          value = std::string(field.words[static_cast<std::size_t>(i)]);
        }
        break;
      case Field::Type::formula:
        if (const auto& formula = field.of<Formula>(element); formula.is_given()) value = std::string(formula.text());
        break;
      case Field::Type::formulas:
        value = texts_of(formulas_of(field, element));
        break;
      case Field::Type::group:
        if (const void* there = field.in(element)) {
          write_fields(value, field.inner(), there);
        }
    }
    if (value.is_null()) to.erase(std::string(field.name));
  }
}

}  // namespace gelenk
