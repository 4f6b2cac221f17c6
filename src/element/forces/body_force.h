// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/forces/force.h"

namespace gelenk {

// A force and a torque on a body at a point, as expressions of the position of the point in the world and of its
// velocity and the angular velocity of the body, in the axes of the world or of the frame.
struct BodyForce {
  static constexpr std::string_view kind = "body_force";
  static constexpr std::string_view summary = "a force and a torque on a body at a point by expressions";
  static constexpr Port ports[] = {
      {.kind = Port::Kind::frame, .name = "", .text = "Where it acts", .on_ground = false}};
  static constexpr std::string_view axes[] = {"world", "body"};
  static constexpr FormulaVariable variables[] = {{"x", "m"},      {"y", "m"},      {"z", "m"},
                                                  {"vx", "m/s"},   {"vy", "m/s"},   {"vz", "m/s"},
                                                  {"wx", "rad/s"}, {"wy", "rad/s"}, {"wz", "rad/s"}};

  std::array<Formula, 3> force, torque;
  Choice frame = {0};  // index in axes: of the components, of vx, ... and wx, ...

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&BodyForce::force>({.name = "force",
                                  .unit = "N",
                                  .text = "expressions for the components of the force",
                                  .settable = false,
                                  .variables = variables,
                                  .reads = FormulaReads::signals}),
        field<&BodyForce::torque>({.name = "torque",
                                   .unit = "N.m",
                                   .text = "expressions for the components of the torque",
                                   .settable = false,
                                   .variables = variables,
                                   .reads = FormulaReads::signals}),
        field<&BodyForce::frame>(
            {.name = "frame", .text = "axes of the components, of vx, vy, vz and of wx, wy, wz", .words = axes})};
    return all;
  }

  bool in_body() const { return frame.index == 1; }

  template <class Self, class Visit>
  static void each_formula(Self& self, Visit visit) {
    for (auto& formula : self.force) visit(formula);
    for (auto& formula : self.torque) visit(formula);
  }

  template <class T, class At, class Use>
  void with_variables(const At* at, Use use) const {
    const Vector3<T> r = at[0].world_position();
    const Vector3<T> v = in_body() ? at[0].own(at[0].v()) : at[0].to_world(at[0].v());
    const Vector3<T> w = in_body() ? at[0].own(at[0].w()) : at[0].to_world(at[0].w());
    const std::array<T, 9> variables{r[0], r[1], r[2], v[0], v[1], v[2], w[0], w[1], w[2]};
    for (const Formula& formula : force) use(formula, variables.data());
    for (const Formula& formula : torque) use(formula, variables.data());
  }

  template <class At, class T>
  void act(At* at, const T* u) const {
    std::array<T, 6> components;
    std::size_t k = 0;
    with_variables<T>(at, [&](const Formula& formula, const T* variables) {
      components[k++] = formula.is_given() ? formula.value_among(variables, u) : T(0);
    });
    const Vector3<T> f(components[0], components[1], components[2]);
    const Vector3<T> n(components[3], components[4], components[5]);
    if (in_body()) return at[0].push_along(f, n);
    at[0].push(at[0].from_world(f), at[0].from_world(n));
  }
};

}  // namespace gelenk
