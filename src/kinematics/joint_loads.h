// SPDX-License-Identifier: BSD-3-Clause
// Forces along joint coordinates, in the form in which the kernels read them.
#pragma once

#include <array>
#include <optional>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

#include "element/joint_forces/registry.h"
#include "element/kinds.h"
#include "element/motors/registry.h"
#include "kinematics/force_modes.h"
#include "kinematics/lists.h"

namespace gelenk {

// A force along a joint coordinate. Its element uses the user's coordinate: sign times the mechanism's.
template <class F>
struct AlongCoordinate {
  F element;
  int q = 0, v = 0;
  double sign = 1;
  int input = 0;                  // index of its first input in the scene
  int joint = -1, component = 0;  // joint of the scene, and which of its coordinates
  int owner = -1;                 // motor of the scene, or component if it is an expression; -1: the joint

  // The inputs of the element, by their indices in the scene.
  bool has_formula() const {
    if constexpr (HasFormula<F>) return element.formula().is_given();
    return false;
  }
  int input_count() const {
    if constexpr (HasFormula<F>) {
      if (has_formula()) return static_cast<int>(element.formula().signals().size());
    }
    return count_of(own_inputs(element));
  }
  int input_at(int k) const {
    if constexpr (HasFormula<F>) {
      if (has_formula()) return element.formula().signals()[static_cast<std::size_t>(k)];
    }
    return input + k;
  }
  // Calls use(own) with the inputs of the element. u: all inputs of the scene.
  template <class T, class Use>
  auto with_inputs(const T* u, Use use) const {
    if constexpr (HasFormula<F>) {
      if (has_formula()) return with_named_inputs(u, use);
    }
    return use(u + input);
  }
  // The signals that an expression names, into `named`, which it returns.
  [[gnu::noinline]] const double* take_named(const double* u, double* named) const {
    if constexpr (HasFormula<F>) element.formula().take_signals(u, named);
    return named;
  }
  // Not inline, so that what names nothing remains short.
  template <class T, class Use>
  [[gnu::noinline]] auto with_named_inputs(const T* u, const Use& use) const {
    std::array<T, Formula::max_signals> signals;
    element.formula().take_signals(u, signals.data());
    return use(signals.data());
  }

  // Generalized force [N m, N], in the mechanism's sign. u: all inputs of the scene.
  template <class T>
  T effort(const T* at, const T* speed, const T* u) const {
    return with_inputs(u, [&](const T* own) { return along(at, speed, own); });
  }
  // own: the inputs of the element.
  template <class T>
  T along(const T* at, const T* speed, const T* own) const {
    return T(sign) * element.effort(T(T(sign) * at[q]), T(T(sign) * speed[v]), own);
  }
  // The same on a given branch (element/joint_forces/coordinate_force.h).
  template <class T>
  T held(int side, const T* at, const T* speed, const T* u) const {
    return with_inputs(u, [&](const T* own) {
      return T(T(sign) * element.held(side, T(T(sign) * at[q]), T(T(sign) * speed[v]), own));
    });
  }
  // The branch on which the state is.
  template <class T>
  int side(const T* at, const T* speed) const {
    return element.side(T(T(sign) * at[q]), T(T(sign) * speed[v]));
  }
};

namespace detail {

template <class F>
struct Plain {
  using type = F;
};
template <class F>
struct Plain<std::optional<F>> {
  using type = F;
};

// A tuple with a list for each kind of element.
template <class Any, class Tuple>
struct Lists;
template <class... Motor, class... Force>
struct Lists<std::variant<Motor...>, std::tuple<Force...>> {
  using type =
      std::tuple<std::vector<AlongCoordinate<Motor>>..., std::vector<AlongCoordinate<typename Plain<Force>::type>>...>;
};

}  // namespace detail

// Motors, springs, dampers and stops along joints: of the whole tree, or of one cut joint (then the indices are
// relative to those of the joint).
struct JointLoads {
  using Lists = detail::Lists<AnyMotor::variant, JointForces::tuple>::type;
  Lists lists;

  bool empty() const { return all_empty(lists); }
  bool stores_nothing() const;  // no element has potential energy
  // Adds the generalized forces to tau. u: all inputs of the scene. sides: the modes in which the forces with modes are
  // held, or null: each is in that of the state.
  template <class T>
  void add(const T* q, const T* v, const T* u, T* tau, const int* sides = nullptr) const {
    each_list(lists, [&](const auto& list) {
      for (const auto& force : list) {
        if constexpr (Switches<std::decay_t<decltype(force.element)>>) {
          const int held = sides == nullptr ? mode_of_state : *sides++;
          tau[force.v] += force.held(held == mode_of_state ? force.side(q, v) : held, q, v, u);
        } else {
          tau[force.v] += force.effort(q, v, u);
        }
      }
    });
  }
  // Potential energy [J].
  template <class T>
  T energy(const T* q) const {
    T sum(0);
    each_list(lists, [&](const auto& list) {
      for (const auto& force : list) {
        const auto& element = force.element;
        if constexpr (requires { element.energy(q[0]); }) sum += element.energy(T(T(force.sign) * q[force.q]));
      }
    });
    return sum;
  }
  // Number of forces with branches.
  int switching_count() const {
    int n = 0;
    each_switching([&](const auto&) { ++n; });
    return n;
  }
  bool has_branches() const { return switching_count() > 0; }
  // Calls visit(force) for each force with an expression.
  template <class Visit>
  void each_formula(Visit&& visit) const {
    each_list(lists, [&](const auto& list) {
      for (const auto& force : list) {
        if constexpr (HasFormula<std::decay_t<decltype(force.element)>>) {
          if (force.has_formula()) visit(force);
        }
      }
    });
  }
  bool has_formulas() const {
    bool any = false;
    each_formula([&](const auto&) { any = true; });
    return any;
  }
  // Calls visit(force) for each force with branches.
  template <class Visit>
  void each_switching(Visit&& visit) const {
    each_list(lists, [&](const auto& list) {
      for (const auto& force : list) {
        if constexpr (Switches<std::decay_t<decltype(force.element)>>) visit(force);
      }
    });
  }
};

}  // namespace gelenk
