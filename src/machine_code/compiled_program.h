// SPDX-License-Identifier: BSD-3-Clause
// A program on one number per slot: as machine code where there is an encoder for the processor and the system permits
// it, otherwise instruction by instruction, with the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lanes/instruction.h"
#include "machine_code/executable_memory.h"

namespace gelenk::machine_code {

// Whether there is an encoder for this processor; the system may refuse what it makes.
#if defined(__x86_64__) || defined(_M_X64)
inline constexpr bool has_encoder = true;
#else
inline constexpr bool has_encoder = false;
#endif

// Instructions without calls from the first one on, then calls.
struct Part {
  std::size_t first = 0, calls = 0, end = 0;
};

class CompiledProgram {
 public:
  CompiledProgram() = default;
  // fixed: slots from here on are temporary, and not needed when the program has run.
  CompiledProgram(std::span<const lanes::Instruction> program, int fixed);

  // memory: one number per slot.
  void run(double* memory) const;
  bool empty() const { return instructions_.empty(); }
  // Whether arithmetic runs as machine code.
  bool is_encoded() const { return !code_.empty(); }

 private:
  std::vector<lanes::Instruction> instructions_;
  std::vector<Part> parts_;
  std::vector<std::size_t> entries_;  // of the parts, in the code
  ExecutableMemory code_;
};

}  // namespace gelenk::machine_code
