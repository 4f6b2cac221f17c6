// SPDX-License-Identifier: BSD-3-Clause
// Instructions of programs on one number per slot, with the bits that a lane of a block gets (lanes/kernels.h).
#pragma once

#include "lanes/instruction.h"

namespace gelenk::machine_code {

void run_one(const lanes::Instruction& instruction, double* memory);

}  // namespace gelenk::machine_code
