// SPDX-License-Identifier: BSD-3-Clause
#include "check/fields.h"

#include <cmath>

#include "check/check.h"
#include "util/text.h"

namespace gelenk {
namespace {

void check_number(double x, const std::string& path, const Field& field, const std::string& unit, Faults& faults) {
  const std::size_t before = faults.count();
  check_finite(&x, 1, path, faults);
  if (faults.count() == before && !permits(field.range, x)) {
    faults.add(path, text::with_unit(text::number(x), unit), bound(field.range, unit));
  }
}

// Reports that alternative sets of fields of an element are mixed, or that none of them is given.
std::optional<ElementFault> fault_of_alternatives(std::span<const Field> fields, const void* element) {
  const std::vector<std::vector<std::string>> alternatives = alternatives_of(fields);
  if (alternatives.empty()) return {};
  std::vector<std::string> all;
  std::vector<std::string> expected;
  for (const std::vector<std::string>& alternative : alternatives) {
    all.insert(all.end(), alternative.begin(), alternative.end());
    expected.push_back(alternative.size() == 1 ? alternative[0] : text::some(alternative) + " (together or alone)");
  }
  std::vector<std::string> given;  // one field of each alternative that is used
  int last = 0;
  for (const Field& field : fields) {
    if (field.alternative == 0 || field.alternative == last || !is_given(field, element)) continue;
    given.emplace_back(field.name);
    last = field.alternative;
  }
  if (given.size() == 1) return {};
  return {{"", given.empty() ? "none of " + text::list(all) : text::list(given) + " together",
           alternatives.size() == 1 ? "one of them, or more" : "one of " + text::list(expected)}};
}

}  // namespace

void check_fields(std::span<const Field> fields, const void* element, const std::string& path,
                  const Coordinate& coordinate, Faults& faults) {
  for (const Field& field : fields) {
    const std::string where = path + "." + std::string(field.name);
    const std::string unit = spelled(unit_of(field, coordinate));
    switch (field.type) {
      case Field::Type::number:
        if (const double x = field.of<double>(element); !field.optional || std::isfinite(x)) {
          check_number(x, where, field, unit, faults);
        }
        break;
      case Field::Type::vector:
        for (int i = 0; i < 3; ++i) {
          const std::string component = where + "[" + std::to_string(i + 1) + "]";
          check_number(field.of<Eigen::Vector3d>(element)[i], component, field, unit, faults);
        }
        break;
      case Field::Type::numbers: {
        const auto& list = field.of<std::vector<double>>(element);
        check_finite(list.data(), list.size(), where, faults);
        break;
      }
      case Field::Type::direction:
        if (const double length = field.of<Direction>(element).along.norm(); !(std::abs(length - 1) < 1e-9)) {
          faults.add(where, "an axis of length " + text::number(length), "a unit vector");
        }
        break;
      case Field::Type::group:
        if (const void* there = field.in(element)) {
          check_fields(field.inner(), there, where, coordinate, faults);
        }
        break;
      case Field::Type::flag:
      case Field::Type::choice:
      case Field::Type::formula:
      case Field::Type::formulas:
        break;
    }
  }
}

void check_element(std::span<const Field> fields, const void* element, const std::string& path,
                   const Coordinate& coordinate, const std::function<std::optional<ElementFault>()>& own_fault,
                   Faults& faults) {
  const std::size_t before = faults.count();
  check_fields(fields, element, path, coordinate, faults);
  if (faults.count() > before) return;
  std::optional<ElementFault> fault = fault_of_alternatives(fields, element);
  if (!fault) fault = own_fault();
  if (fault) faults.add(path + (fault->field.empty() ? "" : "." + fault->field), fault->found, fault->expected);
}

}  // namespace gelenk
