// SPDX-License-Identifier: BSD-3-Clause
// Reads the tables that expressions look up.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "scene_file/reader.h"

namespace gelenk {
namespace {

using expression::Extrapolation;
using expression::Interpolation;
using expression::Table;

constexpr std::size_t max_table_points = 10'000;   // along one argument
constexpr std::size_t max_table_values = 100'000;  // of one table

std::vector<double> read_ascending(const Json& value, const std::string& path, Faults& faults) {
  const std::size_t size = value.is_array() ? value.size() : 0;
  if (size < 2 || size > max_table_points) {
    faults.add(path, shown(value), "a list of 2 to " + std::to_string(max_table_points) + " numbers");
    return {};
  }
  std::vector<double> out = read_list(value, path, faults, size, "").value_or(std::vector<double>());
  for (std::size_t i = 1; i < out.size(); ++i) {
    if (out[i] > out[i - 1]) continue;
    faults.add(path + "[" + std::to_string(i + 1) + "]", text::number(out[i]),
               "more than the number before, " + text::number(out[i - 1]));
    return {};
  }
  return out;
}

// All words that there are.
template <std::size_t n>
std::vector<std::string> words(const char* const (&names)[n]) {
  return {std::begin(names), std::end(names)};
}

template <class Kind, std::size_t n>
Kind read_kind(const Json& value, const std::string& path, const char* const (&names)[n], Kind otherwise,
               Faults& faults) {
  const std::string word = value.is_string() ? value.get<std::string>() : "";
  const auto* const at = std::ranges::find(names, word);
  if (at != std::end(names)) return static_cast<Kind>(at - std::begin(names));
  faults.add(path, shown(value),
             value.is_string() ? text::one_of(word, words(names), "words") : "one of " + text::list(words(names)));
  return otherwise;
}

void read_extrapolation(const Json& value, const std::string& path, Table::Data& data, Faults& faults) {
  const bool is_list = value.is_array() && value.size() == data.arguments();
  for (std::size_t k = 0; k < data.arguments(); ++k) {
    data.extrapolation[k] =
        read_kind(is_list ? value[k] : value, is_list ? path + "[" + std::to_string(k + 1) + "]" : path,
                  expression::extrapolations, Extrapolation::hold, faults);
  }
}

std::vector<double> read_values(const Json& value, const std::string& path, const Table::Data& data, Faults& faults) {
  const std::size_t rows = data.x.size();
  if (data.y.empty()) return read_list(value, path, faults, rows, "").value_or(std::vector<double>());
  const std::size_t columns = data.y.size();
  if (!value.is_array() || value.size() != rows) {
    faults.add(path, shown(value), "a list of " + std::to_string(rows) + " lists, one for each x");
    return {};
  }
  std::vector<double> out;
  for (std::size_t i = 0; i < rows; ++i) {
    const auto row = read_list(value[i], path + "[" + std::to_string(i + 1) + "]", faults, columns, "");
    if (row) out.insert(out.end(), row->begin(), row->end());
  }
  return out;
}

// The values at the last point of a periodic argument are those at the first one.
void check_periods(Table::Data& data, const std::string& path, Faults& faults) {
  constexpr double end_tolerance = 1e-12;  // relative: rounding of the decimal numbers in the file
  double largest = 0;
  for (const double x : data.values) largest = std::max(largest, std::abs(x));
  const std::size_t columns = std::max<std::size_t>(1, data.y.size());
  const std::size_t rows = data.x.size();
  const auto match = [&](std::size_t first, std::size_t last) {
    if (std::abs(data.values[last] - data.values[first]) <= end_tolerance * largest) {
      data.values[last] = data.values[first];
      return;
    }
    const std::string place =
        columns == 1 ? "[" + std::to_string(last + 1) + "]"
                     : "[" + std::to_string(last / columns + 1) + "][" + std::to_string(last % columns + 1) + "]";
    faults.add(path + place, text::number(data.values[last]),
               "the first value, " + text::number(data.values[first]) + ", since the table is periodic");
  };
  for (std::size_t j = 0; j < columns && data.is_periodic(0); ++j) match(j, (rows - 1) * columns + j);
  for (std::size_t i = 0; i < rows && data.is_periodic(1); ++i) match(i * columns, i * columns + columns - 1);
}

std::shared_ptr<const Table> read_table(const std::string& name, Fields& fields) {
  Faults& faults = fields.faults();
  Table::Data data;
  data.name = name;
  const std::size_t before = faults.count();
  const Json* const values = fields.require("values", "a list of numbers, or of a list for each x");
  if (const Json* x = fields.require("x", "a list of numbers, in ascending order"))
    data.x = read_ascending(*x, fields.path("x"), faults);
  if (const Json* y = fields.find("y")) data.y = read_ascending(*y, fields.path("y"), faults);
  if (const Json* by = fields.find("interpolation"))
    data.interpolation =
        read_kind(*by, fields.path("interpolation"), expression::interpolations, data.interpolation, faults);
  if (const Json* beyond = fields.find("extrapolation"))
    read_extrapolation(*beyond, fields.path("extrapolation"), data, faults);
  if (faults.count() == before && data.x.size() * std::max<std::size_t>(1, data.y.size()) > max_table_values) {
    faults.add(fields.path("values"), std::to_string(data.x.size()) + " times " + std::to_string(data.y.size()),
               "at most " + std::to_string(max_table_values) + " values");
  }
  if (faults.count() == before) data.values = read_values(*values, fields.path("values"), data, faults);
  if (faults.count() == before) check_periods(data, fields.path("values"), faults);
  return faults.count() == before ? std::make_shared<const Table>(std::move(data)) : nullptr;
}

}  // namespace

void read_tables(const Json& section, Reader& reader) {
  each_entry(section, "tables", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               SceneTable& table = reader.scene.tables.emplace_back();
               table.name = name;
               Fields fields(value, path, reader.faults, "a mapping with x, values");
               if (!fields.valid()) return;
               table.is = read_table(name, fields);
               if (const Json* text = fields.find("text"))
                 table.text = read_text(*text, fields.path("text"), reader.faults, "a text").value_or("");
               fields.done();
             });
}

}  // namespace gelenk
