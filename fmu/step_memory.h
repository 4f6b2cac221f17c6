// SPDX-License-Identifier: BSD-3-Clause
// Memory that an instance takes when it has been initialized, and from which its steps are served: events, impacts and
// contacts need some for a while, and a call of the heap may take any time. Each block is found and given back in a
// bounded number of operations.
#pragma once

#include <cstddef>

namespace gelenk {

class StepMemory {
 public:
  // Without memory for it, or with more instances than it is meant for, steps use the heap.
  StepMemory();
  // What the library keeps beyond the instance remains valid.
  ~StepMemory();
  StepMemory(const StepMemory&) = delete;
  StepMemory& operator=(const StepMemory&) = delete;

  // During its lifetime, this thread is served from it; null: from the heap.
  class InUse {
   public:
    explicit InUse(const StepMemory* memory);
    ~InUse();
    InUse(const InUse&) = delete;
    InUse& operator=(const InUse&) = delete;

   private:
    void** in_use_;  // by this thread
    void* before_;   // of an enclosing call: a logger may call FMI functions
  };

  // Null: nothing is in use, or it is too small.
  static void* take(std::size_t n) noexcept;
  // How many bytes a block has room for; 0: it is from elsewhere.
  static std::size_t size(const void* block) noexcept;
  // Returns false if the block is from elsewhere.
  static bool release(void* block) noexcept;
  // Keeps a block of the heap, of before the steps, until the instance is freed. Returns false if nothing is in use, or
  // it has been too small: then blocks of the heap come and go.
  static bool keep(void* block) noexcept;

 private:
  void* region_ = nullptr;
};

}  // namespace gelenk
