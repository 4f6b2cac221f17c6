// SPDX-License-Identifier: BSD-3-Clause
// Forces on links by kind, in the form in which the kernels read them. Included only by what depends on their kinds:
// files named *_by_kind.
#pragma once

#include <array>
#include <tuple>
#include <variant>
#include <vector>

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
};

namespace detail {

template <class Any>
struct ForceLists;
template <class... F>
struct ForceLists<std::variant<F...>> {
  using type = std::tuple<std::vector<PlacedForce<F>>...>;
};

}  // namespace detail

struct PlacedForces {
  detail::ForceLists<AnyForce::variant>::type lists;
};

}  // namespace gelenk
