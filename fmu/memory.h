// SPDX-License-Identifier: BSD-3-Clause
// What happens when memory runs out: memory.cpp stands before malloc.
#pragma once

namespace gelenk {

// While it lives, this thread gets from a reserve what malloc refuses, and the call that noticed nothing is refused at
// its end: some destructors ask for memory themselves (those of the JSON library list what they hold), and an
// exception out of one would end the host's process; SUNDIALS does not survive what it could make by half only. With
// the reserve used up, allocations fail as usual.
class MemoryReserve {
 public:
  MemoryReserve();
  ~MemoryReserve();
  MemoryReserve(const MemoryReserve&) = delete;
  MemoryReserve& operator=(const MemoryReserve&) = delete;

  // Something came from the reserve.
  bool drawn() const;

 private:
  bool open_before_, drawn_before_;  // of a call around this one: a logger may call
};

}  // namespace gelenk
