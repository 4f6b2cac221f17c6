// SPDX-License-Identifier: BSD-3-Clause
// Checks of the fields of an element, each one and in combination.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "element/element.h"
#include "scene/faults.h"

namespace gelenk {

// Adds an error for each number that is not finite or outside the range of its field.
void check_fields(std::span<const Field> fields, const void* element, const std::string& path,
                  const Coordinate& coordinate, Faults& faults);
// Adds the errors of check_fields(); if there are none, an error for alternative fields that are mixed or all missing;
// if there is none either, the error returned by own_fault().
void check_element(std::span<const Field> fields, const void* element, const std::string& path,
                   const Coordinate& coordinate, const std::function<std::optional<ElementFault>()>& own_fault,
                   Faults& faults);

}  // namespace gelenk
