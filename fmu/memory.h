// SPDX-License-Identifier: BSD-3-Clause
// Behavior when memory runs out; memory.cpp replaces malloc or, on Windows and macOS, operator new.
#pragma once

namespace gelenk {

// During its lifetime, if malloc fails, this thread gets memory from a reserve, and the FMI call returns an error at
// its end. Otherwise allocation failures could not be handled: some destructors allocate (those of the JSON library
// list their contents), where an exception would terminate the host's process, and SUNDIALS does not survive partly
// created objects. If the reserve is exhausted, allocations fail as usual.
class MemoryReserve {
 public:
  MemoryReserve();
  ~MemoryReserve();
  MemoryReserve(const MemoryReserve&) = delete;
  MemoryReserve& operator=(const MemoryReserve&) = delete;

  // Whether memory was taken from the reserve.
  bool was_used() const;

 private:
  void* use_;                       // by this thread
  bool open_before_, used_before_;  // of an enclosing call: a logger may call FMI functions
};

}  // namespace gelenk
