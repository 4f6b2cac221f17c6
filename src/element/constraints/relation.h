// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "element/constraints/constraint.h"
#include "util/text.h"

namespace gelenk {

// A relation between coordinates of joints that the user writes: q_joint = f, or f = 0, of coordinates, or of rates, in
// which it is linear.
struct Relation {
  static constexpr std::string_view kind = "relation";
  static constexpr std::string_view summary = "a relation between coordinates of joints, or between their rates";
  static constexpr Port ports[] = {{.kind = Port::Kind::joint,
                                    .name = "joint",
                                    .text = "Joint whose force is the output; that which the relation gives",
                                    .fits = [](const JointKind& kind) { return kind.nq == 1 && kind.nv == 1; }}};

  Formula gives, zero;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Relation::gives>({.name = "gives",
                                 .unit = "{q}",
                                 .text = "expression of coordinates of other joints for that of `joint`",
                                 .settable = false,
                                 .alternative = 1,
                                 .reads = FormulaReads::signals}),
        field<&Relation::zero>(
            {.name = "zero",
             .unit = "1",
             .text = "expression of coordinates of joints that is 0; or of their rates, linear in these",
             .settable = false,
             .alternative = 2,
             .reads = FormulaReads::signals})};
    return all;
  }
  static constexpr SignalGroup outputs[] = {{"{effort}", 0, "{f}", "{torque} of the relation on joint {joint}"}};

  const Formula& relation() const { return gives.is_given() ? gives : zero; }
  bool gives_coordinate() const { return gives.is_given(); }
  std::optional<ElementFault> fault(const Coordinate&) const;
  template <class Seen>
  auto output(const Seen& seen, int, int) const {
    return seen.coordinate_force();
  }
};

// A constraint that an expression of coordinates relates.
template <class C>
concept Relates = requires(const C& c) { c.relation(); };

}  // namespace gelenk
