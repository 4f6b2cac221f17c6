// SPDX-License-Identifier: BSD-3-Clause
// Programs on blocks of lanes. Each lane gets the bits that it would get alone, in any block, at any place of it, on
// any processor: operations are those of IEEE 754 and not contracted, and sines and cosines are computed here.
#pragma once

#include <span>
#include <string_view>

#include "lanes/instruction.h"

namespace gelenk::lanes {

// Lanes of a block: the loops over them have this length when they are compiled. Few, so that the slots of a program
// remain in the first cache; enough that loops take longer than finding out which one is next.
inline constexpr int lanes_per_block = 32;

// memory: the slots, lanes_per_block numbers each, aligned to 64 bytes.
void run(std::span<const Instruction> program, double* memory);

// The vector instructions that run() uses on this processor: "avx2", or "baseline".
std::string_view instruction_set();
// For tests: whether run() uses those that not every processor has.
void use_all_instructions(bool on);

}  // namespace gelenk::lanes
