// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/forces/force.h"

namespace gelenk {

// A force along the line between two points, as an expression of their distance and its rate. It pulls where it is
// positive.
struct LineForce {
  static constexpr std::string_view kind = "line_force";
  static constexpr std::string_view summary = "a force along the line between two points by an expression";
  static constexpr Port ports[] = {{.kind = Port::Kind::point, .name = "from", .text = "One end"},
                                   {.kind = Port::Kind::point, .name = "to", .text = "The other end"}};
  static constexpr FormulaVariable variables[] = {{"length", "m"}, {"rate", "m/s"}};

  Formula tension;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&LineForce::tension>({.name = "tension",
                                    .unit = "N",
                                    .text = "expression of length, rate, t and inputs for the force that pulls",
                                    .required = true,
                                    .settable = false,
                                    .variables = variables,
                                    .reads = FormulaReads::signals})};
    return all;
  }

  template <class Self, class Visit>
  static void each_formula(Self& self, Visit visit) {
    visit(self.tension);
  }

  // Calls use(formula, variables) for each expression.
  template <class T, class At, class Use>
  void with_variables(const At* at, Use use) const {
    const Vector3<T> d = at[1].p() - at[0].p();
    const T length = d.norm();
    if (length == T(0)) return;  // reported by undefined()
    const std::array<T, 2> variables{length, d.dot(at[1].v() - at[0].v()) / length};
    use(tension, variables.data());
  }

  template <class At, class T>
  void act(At* at, const T* u) const {
    with_variables<T>(at, [&](const Formula& formula, const T* variables) {
      const Vector3<T> d = at[1].p() - at[0].p();
      const Vector3<T> f = (formula.value_among(variables, u) / variables[0]) * d;
      at[0].push(f);
      at[1].push(-f);
    });
  }

  template <class At>
  bool undefined(const At* at) const {
    return coincide(at);
  }
};

}  // namespace gelenk
