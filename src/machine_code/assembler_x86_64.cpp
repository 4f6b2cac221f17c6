// SPDX-License-Identifier: BSD-3-Clause
#include "machine_code/assembler_x86_64.h"

#include <algorithm>

namespace gelenk::machine_code {

void AssemblerX86_64::word(std::int32_t value) {
  const auto bits = static_cast<std::uint32_t>(value);
  for (int shift = 0; shift < 32; shift += 8) byte(static_cast<int>((bits >> shift) & 0xff));
}

AssemblerX86_64::Place AssemblerX86_64::constant_of(std::uint64_t bits, bool is_mask) {
  const std::pair<std::uint64_t, bool> wanted(bits, is_mask);
  const auto found = std::ranges::find(constants_, wanted);
  const auto number = static_cast<int>(found - constants_.begin());
  if (found == constants_.end()) constants_.push_back(wanted);
  return {Place::Kind::constant, number};
}

AssemblerX86_64::Place AssemblerX86_64::constant(double value) {
  return constant_of(std::bit_cast<std::uint64_t>(value), false);
}

AssemblerX86_64::Place AssemblerX86_64::sign_mask() { return constant_of(std::uint64_t{1} << 63, true); }

// prefix, REX for registers from 8 on, 0F, operation, ModRM.
void AssemblerX86_64::scalar(int prefix, int operation, int reg, Place operand) {
  const bool is_register = operand.kind == Place::Kind::reg;
  byte(prefix);
  const int rex = 0x40 | (reg >= 8 ? 4 : 0) | (is_register && operand.number >= 8 ? 1 : 0);
  if (rex != 0x40) byte(rex);
  bytes({0x0f, operation});
  const int of_register = (reg & 7) << 3;
  if (is_register) return byte(0xc0 | of_register | (operand.number & 7));
  if (operand.kind == Place::Kind::constant) {  // relative to the next instruction
    byte(of_register | 5);
    references_.emplace_back(code_.size(), operand.number);
    return word(0);
  }
  const int offset = 8 * operand.number;
  if (offset < 128) {
    byte(0x40 | of_register | base);
    return byte(offset);
  }
  byte(0x80 | of_register | base);
  word(offset);
}

void AssemblerX86_64::load(int to, Place from) {
  if (from.kind == Place::Kind::reg) {
    if (from.number != to) scalar(0x66, 0x28, to, from);  // movapd
    return;
  }
  scalar(0xf2, 0x10, to, from);  // movsd
}

void AssemblerX86_64::move_if_greater(int x, int y, int to, int from) {
  scalar(0x66, 0x2e, x, in_register(y));  // ucomisd
  bytes({0x76, 0});                       // jbe: also where they cannot be compared
  const std::size_t after = code_.size();
  load(to, in_register(from));
  code_[after - 1] = static_cast<std::uint8_t>(code_.size() - after);
}

std::vector<std::uint8_t> AssemblerX86_64::finished() && {
  while (code_.size() % 16 != 0) byte(0xcc);
  // Masks first, which must be aligned.
  std::vector<std::size_t> place(constants_.size());
  for (const bool masks : {true, false}) {
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      if (constants_[k].second != masks) continue;
      place[k] = code_.size();
      for (int half = 0; half < (masks ? 2 : 1); ++half) {
        for (int shift = 0; shift < 64; shift += 8) byte(static_cast<int>((constants_[k].first >> shift) & 0xff));
      }
    }
  }
  for (const auto& [at, number] : references_) {
    const auto distance = static_cast<std::uint32_t>(place[static_cast<std::size_t>(number)] - (at + 4));
    for (int k = 0; k < 4; ++k)
      code_[at + static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(distance >> (8 * k));
  }
  return std::move(code_);
}

}  // namespace gelenk::machine_code
