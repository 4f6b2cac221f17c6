// SPDX-License-Identifier: BSD-3-Clause
// The linker directs this module's allocations here (option --wrap).
#include <cstddef>

#include "units.h"

namespace {
long count = 0;
}

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" {
void* __real_malloc(std::size_t size);
void* __real_calloc(std::size_t number, std::size_t size);
void* __real_realloc(void* old, std::size_t size);
int __real_posix_memalign(void** out, std::size_t alignment, std::size_t size);
void* __real__Znwm(std::size_t size);
void* __real__Znam(std::size_t size);

void* __wrap_malloc(std::size_t size) {
  ++count;
  return __real_malloc(size);
}
void* __wrap_calloc(std::size_t number, std::size_t size) {
  ++count;
  return __real_calloc(number, size);
}
void* __wrap_realloc(void* old, std::size_t size) {
  ++count;
  return __real_realloc(old, size);
}
int __wrap_posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  ++count;
  return __real_posix_memalign(out, alignment, size);
}
void* __wrap__Znwm(std::size_t size) {
  ++count;
  return __real__Znwm(size);
}
void* __wrap__Znam(std::size_t size) {
  ++count;
  return __real__Znam(size);
}
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

namespace native {
long allocations() { return count; }
}  // namespace native
