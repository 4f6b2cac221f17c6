// SPDX-License-Identifier: BSD-3-Clause
// Arithmetic instructions as machine code for x86-64. Numbers are kept in registers as long as there are any: a slot is
// read when its number is first needed, and written when its register is needed for another number, or at the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lanes/instruction.h"
#include "machine_code/compiled_program.h"

namespace gelenk::machine_code {

struct Encoded {
  std::vector<std::uint8_t> code;
  std::vector<std::size_t> entries;  // by part: the offset of the function that executes its arithmetic
};

// fixed: slots from here on are temporary.
Encoded encode(std::span<const lanes::Instruction> program, std::span<const Part> parts, int fixed);

}  // namespace gelenk::machine_code
