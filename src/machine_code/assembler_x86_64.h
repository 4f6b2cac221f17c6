// SPDX-License-Identifier: BSD-3-Clause
// Instructions of x86-64 on double-precision numbers in SSE2 registers (Intel 64 and IA-32 Architectures Software
// Developer's Manual, volume 2).
#pragma once

#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

namespace gelenk::machine_code {

class AssemblerX86_64 {
 public:
  // The register that holds the address of the numbers when a function is called: its first argument.
#ifdef _WIN32
  static constexpr int base = 1;       // rcx
  static constexpr int registers = 6;  // xmm0 to xmm5; functions preserve the others
#else
  static constexpr int base = 7;  // rdi
  static constexpr int registers = 16;
#endif

  // Of the operations on two operands: destination <- destination op source.
  enum class Arithmetic : std::uint8_t {
    square_root = 0x51,
    add = 0x58,
    multiply = 0x59,
    subtract = 0x5c,
    divide = 0x5e
  };

  // Where a number is: in a register, in memory at base + 8 * slot, or a constant among those after the code.
  struct Place {
    enum class Kind : std::uint8_t { reg, slot, constant } kind = Kind::reg;
    int number = 0;
  };
  static Place in_register(int number) { return {Place::Kind::reg, number}; }
  static Place in_slot(int number) { return {Place::Kind::slot, number}; }
  Place constant(double value);
  // The constant with the sign bit alone, in both halves of a register.
  Place sign_mask();

  // A target of indirect calls.
  void begin_function() { bytes({0xf3, 0x0f, 0x1e, 0xfa}); }  // endbr64
  void end_function() { byte(0xc3); }                         // ret
  void arithmetic(Arithmetic operation, int to, Place from) {
    scalar(0xf2, static_cast<std::uint8_t>(operation), to, from);
  }
  void load(int to, Place from);
  void store(int slot, int from) { scalar(0xf2, 0x11, from, in_slot(slot)); }
  void flip_sign(int x) { scalar(0x66, 0x57, x, sign_mask()); }
  void clear(int x) { scalar(0x66, 0x57, x, in_register(x)); }
  // to <- x > y ? from : to. Three registers.
  void move_if_greater(int x, int y, int to, int from);

  std::size_t size() const { return code_.size(); }
  // With the constants; no more instructions can follow.
  std::vector<std::uint8_t> finished() &&;

 private:
  void byte(int value) { code_.push_back(static_cast<std::uint8_t>(value)); }
  void bytes(std::initializer_list<int> values) {
    for (const int value : values) byte(value);
  }
  void word(std::int32_t value);
  void scalar(int prefix, int operation, int reg, Place operand);
  Place constant_of(std::uint64_t bits, bool is_mask);

  std::vector<std::uint8_t> code_;
  std::vector<std::pair<std::uint64_t, bool>> constants_;  // bits; whether as a mask of 16 bytes
  std::vector<std::pair<std::size_t, int>> references_;    // where the distance to which constant is written
};

}  // namespace gelenk::machine_code
