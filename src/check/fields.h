// SPDX-License-Identifier: BSD-3-Clause
// The fields of an element, checked one by one and together.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "element/element.h"
#include "scene/faults.h"

namespace gelenk {

// Faults for what is not finite or out of its field's range.
void check_fields(std::span<const Field> fields, const void* element, const std::string& path,
                  const Coordinate& coordinate, Faults& faults);
// These, else one for ways to give the numbers that are mixed or all missing, else the element's own.
void check_element(std::span<const Field> fields, const void* element, const std::string& path,
                   const Coordinate& coordinate, const std::function<std::optional<ElementFault>()>& own_fault,
                   Faults& faults);

}  // namespace gelenk
