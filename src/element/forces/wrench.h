// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/forces/force.h"

namespace gelenk {

// A force and a torque on a body at a point, in the axes of the world or of the frame: constant values plus inputs.
struct Wrench {
  static constexpr std::string_view kind = "wrench";
  static constexpr std::string_view summary = "a force and a torque on a body at a point";
  static constexpr Port ports[] = {
      {.kind = Port::Kind::frame, .name = "", .text = "Where it acts", .on_ground = false}};
  static constexpr std::string_view axes[] = {"world", "body"};

  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // N
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // N m
  Choice frame = {0};                                // index in axes
  bool input = false;                                // whether inputs are added

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Wrench::force>({.name = "force", .unit = "N", .text = "constant force", .tunable = true}),
        field<&Wrench::torque>({.name = "torque", .unit = "N.m", .text = "constant torque", .tunable = true}),
        field<&Wrench::frame>({.name = "frame", .text = "axes in which the components are resolved", .words = axes}),
        field<&Wrench::input>({.name = "input", .text = "whether the inputs f and t are added"})};
    return all;
  }

  bool in_body() const { return frame.index == 1; }

  std::span<const SignalGroup> inputs() const {
    static constexpr SignalGroup in_world[] = {{"f", 3, "N", "additional force on {body}, resolved in the world"},
                                               {"t", 3, "N.m", "additional torque on {body}, resolved in the world"}};
    static constexpr SignalGroup in_own[] = {{"f", 3, "N", "additional force on {body}, resolved in the body"},
                                             {"t", 3, "N.m", "additional torque on {body}, resolved in the body"}};
    if (!input) return {};
    return in_body() ? in_own : in_world;
  }

  bool is_local() const { return in_body(); }

  template <class At, class T>
  void act(At* at, const T* u) const {
    Vector3<T> f = force.template cast<T>();
    Vector3<T> n = torque.template cast<T>();
    if (input) {
      f += Vector3<T>(u[0], u[1], u[2]);
      n += Vector3<T>(u[3], u[4], u[5]);
    }
    if (in_body()) return at[0].push_along(f, n);
    at[0].push(at[0].from_world(f), at[0].from_world(n));
  }

  // A wrench in the axes of the body rotates with it; one in the axes of the world is constant.
  template <class At>
  PortJacobians jacobians(const At* at, const double* u) const {
    PortJacobians out{.damped = false};
    if (!in_body()) return out;
    Eigen::Vector3d f = force;
    Eigen::Vector3d n = torque;
    if (input) {
      f += Eigen::Map<const Eigen::Vector3d>(u);
      n += Eigen::Map<const Eigen::Vector3d>(u + 3);
    }
    out.f_a = -cross_matrix<double>(at[0].turned(f));
    out.n_a = -cross_matrix<double>(at[0].turned(n));
    return out;
  }
};

}  // namespace gelenk
