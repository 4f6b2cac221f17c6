// SPDX-License-Identifier: BSD-3-Clause
#include "element/constraints/relation.h"

#include <string>

namespace gelenk {

std::optional<ElementFault> Relation::fault(const Coordinate&) const {
  const std::string field = gives_coordinate() ? "gives" : "zero";
  const Formula& of = relation();
  const std::string found = text::quoted(std::string(of.text()));
  for (const std::string& name : of.signal_names()) {
    if (name.find('.') == name.npos)
      return {{field, text::quoted(name) + " in " + found, "coordinates of joints and constants only"}};
  }
  if (of.signal_names().empty()) return {{field, found, "an expression that names coordinates of joints"}};
  if (has_kinks(of) || of.branches() > 0)
    return {{field, found, "a smooth relation, without abs, min, max, if and tables: its accelerations would jump"}};
  return {};
}

}  // namespace gelenk
