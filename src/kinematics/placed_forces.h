// SPDX-License-Identifier: BSD-3-Clause
// Forces on links by kind, in the form in which the kernels read them. Included only by what depends on their kinds:
// files named *_by_kind.
#pragma once

#include <algorithm>
#include <array>
#include <tuple>
#include <variant>
#include <vector>

#include "element/forces/gravity_force.h"
#include "element/forces/registry.h"
#include "kinematics/forces.h"
#include "kinematics/lists.h"

namespace gelenk {

// A force and the frames on which it acts.
template <class F>
struct PlacedForce {
  static constexpr std::size_t ports = std::size(F::ports);

  F element;
  std::array<Attachment, ports> at;
  int input = 0;   // index of its first input in the scene
  int force = -1;  // index in the scene

  // The inputs of the element, by their indices in the scene.
  std::vector<int> inputs() const {
    std::vector<int> out;
    if constexpr (HasFormulas<F>) {
      F::each_formula(element, [&](const Formula& formula) {
        for (const int signal : formula.signals()) {
          if (std::ranges::find(out, signal) == out.end()) out.push_back(signal);
        }
      });
    } else {
      for (int i = 0; i < count_of(own_inputs(element)); ++i) out.push_back(input + i);
    }
    return out;
  }
  // Where act() finds its inputs among all of the scene.
  int first_input() const { return HasFormulas<F> ? 0 : input; }
};

namespace detail {

// Those of elements, and gravity that depends on the position.
template <class Any>
struct ForceLists;
template <class... F>
struct ForceLists<std::variant<F...>> {
  using type = std::tuple<std::vector<PlacedForce<F>>..., std::vector<PlacedForce<GravityForce>>>;
};

}  // namespace detail

struct PlacedForces {
  detail::ForceLists<AnyForce::variant>::type lists;
};

}  // namespace gelenk
