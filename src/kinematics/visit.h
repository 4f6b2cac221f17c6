// SPDX-License-Identifier: BSD-3-Clause
// Calls a function with the joint in a variant; kinds that the algebra A does not support are not instantiated.
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
          unreachable();  // planar mechanisms have planar joints only (reduce())
        }
      },
      joint);
}

}  // namespace gelenk
