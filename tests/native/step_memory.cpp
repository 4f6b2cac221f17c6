// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/step_memory.h"

#include <cstdint>
#include <cstdlib>
#include <memory>

#include "units.h"

namespace native {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using gelenk::StepMemory;

// Blocks are numbers for Python.
std::uintptr_t number(void* block) { return reinterpret_cast<std::uintptr_t>(block); }
void* block(std::uintptr_t number) { return reinterpret_cast<void*>(number); }

// Serves the thread only within a call of take() or keep(), lest Python be served, too.
class Owner {
 public:
  std::uintptr_t take(std::size_t n) const {
    const StepMemory::InUse in_use(memory_.get());
    return number(StepMemory::take(n));
  }
  bool keep(std::uintptr_t of) const {
    const StepMemory::InUse in_use(memory_.get());
    return StepMemory::keep(block(of));
  }
  void go() { memory_.reset(); }

 private:
  std::unique_ptr<StepMemory> memory_ = std::make_unique<StepMemory>();
};

}  // namespace

void bind_step_memory(nb::module_& m) {
  nb::class_<Owner>(m, "StepMemory")
      .def(nb::init<>())
      .def("take", &Owner::take, "n"_a)
      .def("keep", &Owner::keep, "block"_a)
      .def("go", &Owner::go);
  m.def("step_memory_size", [](std::uintptr_t of) { return StepMemory::size(block(of)); });
  m.def("step_memory_release", [](std::uintptr_t of) { return StepMemory::release(block(of)); });
  m.def("step_memory_take_unused", [] { return number(StepMemory::take(8)); });
  m.def("heap_block", [] { return number(std::malloc(64)); });
  m.def("free_heap_block", [](std::uintptr_t of) { std::free(block(of)); });
  m.def("filled", [](std::uintptr_t of, std::size_t n) {
    auto* const bytes = static_cast<unsigned char*>(block(of));
    for (std::size_t i = 0; i < n; ++i) bytes[i] = static_cast<unsigned char>(i % 251);
    for (std::size_t i = 0; i < n; ++i) {
      if (bytes[i] != i % 251) return false;
    }
    return true;
  });
}

}  // namespace native
