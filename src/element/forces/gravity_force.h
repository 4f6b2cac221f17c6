// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "element/forces/force.h"

namespace gelenk {

// Gravity that depends on the position in the world: toward a center, mu/r^2, or by expressions for its components.
struct GravityField {
  static constexpr FormulaVariable variables[] = {{"x", "m"}, {"y", "m"}, {"z", "m"}};

  std::array<Formula, 3> law;
  double mu = std::numeric_limits<double>::quiet_NaN();  // m3/s2; NaN if not given
  Eigen::Vector3d center = Eigen::Vector3d::Zero();      // m

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&GravityField::law>({.name = "law",
                                   .unit = "m/s2",
                                   .text = "expressions of x, y, z in the world for the components of the acceleration",
                                   .settable = false,
                                   .alternative = 1,
                                   .variables = variables,
                                   .reads = FormulaReads::signals}),
        field<&GravityField::mu>({.name = "mu",
                                  .unit = "m3/s2",
                                  .text = "gravitational constant times the mass of a body at the center",
                                  .range = Range::positive,
                                  .optional = true,
                                  .settable = false,
                                  .alternative = 2}),
        field<&GravityField::center>(
            {.name = "center", .unit = "m", .text = "center of attraction in the world, for mu", .settable = false})};
    return all;
  }
  bool is_central() const { return std::isfinite(mu); }
};

// What it exerts on a body at its center of mass; not an element of scenes.
struct GravityForce {
  static constexpr Port ports[] = {{.kind = Port::Kind::point, .name = "body", .text = "Center of mass"}};

  GravityField field;
  double mass = 0;  // kg

  template <class Self, class Visit>
  static void each_formula(Self& self, Visit visit) {
    for (auto& formula : self.field.law) visit(formula);
  }

  template <class T, class At, class Use>
  void with_variables(const At* at, Use use) const {
    const Vector3<T> r = at[0].world_position();
    for (const Formula& formula : field.law) use(formula, r.data());
  }

  template <class At, class T>
  void act(At* at, const T* u) const {
    Vector3<T> g = Vector3<T>::Zero();
    if (field.is_central()) {
      const Vector3<T> d = at[0].world_position() - field.center.cast<T>();
      const T squared = d.squaredNorm();
      g = (T(-field.mu) / (squared * d.norm())) * d;
    } else {
      int k = 0;
      with_variables<T>(at, [&](const Formula& formula, const T* r) { g[k++] = formula.value_among(r, u); });
    }
    at[0].push(at[0].from_world(Vector3<T>(T(mass) * g)));
  }

  template <class T, class At>
  T energy(const At* at) const {
    if (!field.is_central()) return T(0);
    const Vector3<T> d = at[0].world_position() - field.center.cast<T>();
    return T(-field.mu * mass) / d.norm();
  }
};

}  // namespace gelenk
