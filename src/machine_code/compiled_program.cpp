// SPDX-License-Identifier: BSD-3-Clause
#include "machine_code/compiled_program.h"

#include <utility>

#include "machine_code/encoder.h"
#include "machine_code/one_lane.h"

namespace gelenk::machine_code {
namespace {

std::vector<Part> parts_of(std::span<const lanes::Instruction> program) {
  std::vector<Part> out;
  std::size_t k = 0;
  while (k < program.size()) {
    Part part{k, k, k};
    while (k < program.size() && !lanes::calls_function(program[k].code)) ++k;
    part.calls = k;
    while (k < program.size() && lanes::calls_function(program[k].code)) ++k;
    part.end = k;
    out.push_back(part);
  }
  return out;
}

}  // namespace

CompiledProgram::CompiledProgram(std::span<const lanes::Instruction> program, int fixed)
    : instructions_(program.begin(), program.end()), parts_(parts_of(program)) {
  if constexpr (has_encoder) {
    Encoded encoded = encode(instructions_, parts_, fixed);
    entries_ = std::move(encoded.entries);
    code_ = ExecutableMemory(encoded.code);
  }
}

void CompiledProgram::run(double* memory) const {
  const lanes::Instruction* const all = instructions_.data();
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const Part& part = parts_[p];
    if (part.first < part.calls) {
      if (code_.empty()) {
        for (std::size_t k = part.first; k < part.calls; ++k) run_one(all[k], memory);
      } else {
        using Function = void (*)(double*);
        reinterpret_cast<Function>(code_.at(entries_[p]))(memory);
      }
    }
    for (std::size_t k = part.calls; k < part.end; ++k) run_one(all[k], memory);
  }
}

}  // namespace gelenk::machine_code
