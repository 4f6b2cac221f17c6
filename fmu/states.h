// SPDX-License-Identifier: BSD-3-Clause
// FMU states: saving, restoring, serialization. Each function is one of FMI, in all versions, whose name is given for
// messages.
#pragma once

#include <cstddef>

#include "fmu/status.h"

namespace gelenk {

// A state of this instance is overwritten and its memory reused. Any other pointer is replaced by a new state, since
// some masters do not initialize it.
Status get_state(void* instance, const char* function, void** state) noexcept;
Status set_state(void* instance, const char* function, void* state) noexcept;
Status free_state(void* instance, const char* function, void** state) noexcept;
Status get_serialized_size(void* instance, const char* function, void* state, std::size_t* size) noexcept;
Status serialize_state(void* instance, const char* function, void* state, char* bytes, std::size_t size) noexcept;
Status deserialize_state(void* instance, const char* function, const char* bytes, std::size_t size,
                         void** state) noexcept;

}  // namespace gelenk
