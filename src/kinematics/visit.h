// SPDX-License-Identifier: BSD-3-Clause
// Calls a function on the joint behind a variant, leaving out kinds that have no place in the algebra A.
#pragma once

#include <type_traits>
#include <utility>
#include <variant>

#include "joint/registry.h"
#include "util/unreachable.h"

namespace gelenk {

template <class A, class Variant, class Function>
decltype(auto) visit_joint(const Variant& joint, Function&& function) {
  using Result = std::invoke_result_t<Function, const Revolute&>;
  return std::visit(
      [&](const auto& j) -> Result {
        if constexpr (supports_algebra<A, std::decay_t<decltype(j)>>) {
          return function(j);
        } else {
          unreachable();  // compile() makes planar mechanisms of planar joints only
        }
      },
      joint);
}

}  // namespace gelenk
