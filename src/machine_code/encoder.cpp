// SPDX-License-Identifier: BSD-3-Clause
#include "machine_code/encoder.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "machine_code/assembler_x86_64.h"

namespace gelenk::machine_code {
namespace {

using lanes::Code;
using lanes::Instruction;
using Arithmetic = AssemblerX86_64::Arithmetic;
using Place = AssemblerX86_64::Place;

constexpr int registers = AssemblerX86_64::registers;
constexpr int never = std::numeric_limits<int>::max();
constexpr int nothing = -1;

int slots_of(std::span<const Instruction> program) {
  int out = 0;
  for (const Instruction& i : program) {
    lanes::each_operand(i, [&](int slot) { out = std::max(out, slot + 1); });
    out = std::max({out, i.to + 1, i.code == Code::sine_cosine ? i.b + 1 : 0});
  }
  return out;
}

// When the number that is in a slot after an instruction is read next: for its operands and its result.
struct NextUses {
  std::array<int, 4> operands{never, never, never, never};
  int result = never;
};

std::vector<NextUses> next_uses(std::span<const Instruction> program, int slots) {
  std::vector<int> next(static_cast<std::size_t>(slots), never);
  std::vector<NextUses> out(program.size());
  for (std::size_t k = program.size(); k-- > 0;) {
    const Instruction& i = program[k];
    const auto write = [&](int slot) { return std::exchange(next[static_cast<std::size_t>(slot)], never); };
    // What is overwritten is not read later, also if it is an operand.
    out[k].result = write(i.to);
    if (i.code == Code::sine_cosine) write(i.b);
    std::size_t n = 0;
    lanes::each_operand(i, [&](int slot) { out[k].operands[n++] = next[static_cast<std::size_t>(slot)]; });
    lanes::each_operand(i, [&](int slot) { next[static_cast<std::size_t>(slot)] = static_cast<int>(k); });
  }
  return out;
}

class Encoder {
 public:
  Encoder(std::span<const Instruction> program, int fixed)
      : program_(program),
        fixed_(fixed),
        slots_(static_cast<std::size_t>(slots_of(program))),
        uses_(next_uses(program, static_cast<int>(slots_.size()))) {}

  Encoded encode(std::span<const Part> parts);

 private:
  struct Slot {
    int reg = nothing;      // that holds its number
    bool in_memory = true;  // whether the slot does, too
    int next = never;       // the instruction that reads it next
    int reads = 0;          // still to come in the present instruction
  };
  struct Register {
    int slot = nothing;  // of which it holds the number
    bool locked = false;
  };

  Slot& at(int slot) { return slots_[static_cast<std::size_t>(slot)]; }
  Register& in(int reg) { return registers_[static_cast<std::size_t>(reg)]; }
  bool is_needed(const Slot& slot) const { return slot.reads > 0 || slot.next != never; }

  void begin(const Instruction& i, const NextUses& uses);
  void execute(const Instruction& i);
  int value(const Instruction& i);
  int allocate();
  void free(int reg);
  void write_back(int reg);
  int in_register(int slot);
  Place operand(int slot);
  int owned(int slot);
  int owned_constant(double value);
  int product(int a, int b);
  int scaled(double k, int a);
  int combined(Arithmetic operation, int reg, int with);
  void release(int reg) { in(reg).locked = false; }
  void define(int slot, int reg, int next);
  void end_part();

  std::span<const Instruction> program_;
  int fixed_;
  std::vector<Slot> slots_;
  std::vector<NextUses> uses_;
  std::array<Register, registers> registers_{};
  AssemblerX86_64 code_;
};

void Encoder::begin(const Instruction& i, const NextUses& uses) {
  for (Register& reg : registers_) reg.locked = false;
  std::size_t n = 0;
  lanes::each_operand(i, [&](int slot) {
    ++at(slot).reads;
    at(slot).next = uses.operands[n++];
  });
}

// The number of a register in the slot to which it belongs, if it is still needed there.
void Encoder::write_back(int reg) {
  const int number = in(reg).slot;
  Slot& slot = at(number);
  if (slot.in_memory || (number >= fixed_ && !is_needed(slot))) return;
  code_.store(number, reg);
  slot.in_memory = true;
}

void Encoder::free(int reg) {
  if (in(reg).slot == nothing) return;
  write_back(reg);
  at(in(reg).slot).reg = nothing;
  in(reg).slot = nothing;
}

// A register for a new number, locked: an empty one, or that of which the number is needed last.
int Encoder::allocate() {
  int best = nothing;
  int latest = -1;
  for (int reg = 0; reg < registers; ++reg) {
    if (in(reg).locked) continue;
    const int slot = in(reg).slot;
    int next = never;
    if (slot != nothing) next = at(slot).reads > 0 ? 0 : at(slot).next;
    // Of those that are not needed again, one that need not be written.
    const bool is_better = next > latest || (next == latest && slot == nothing);
    if (best == nothing || is_better) {
      best = reg;
      latest = next;
    }
  }
  free(best);
  in(best).locked = true;
  return best;
}

int Encoder::in_register(int slot) {
  Slot& of = at(slot);
  --of.reads;
  if (of.reg == nothing) {
    const int reg = allocate();
    code_.load(reg, AssemblerX86_64::in_slot(slot));
    of.reg = reg;
    in(reg).slot = slot;
  }
  in(of.reg).locked = true;
  return of.reg;
}

// Where an instruction can read the number of a slot.
Place Encoder::operand(int slot) {
  Slot& of = at(slot);
  if (of.reg == nothing && of.reads == 1 && of.next == never) {
    --of.reads;
    return AssemblerX86_64::in_slot(slot);
  }
  return AssemblerX86_64::in_register(in_register(slot));
}

// A register with the number of a slot that may be overwritten.
int Encoder::owned(int slot) {
  Slot& of = at(slot);
  --of.reads;
  if (of.reg == nothing) {
    const int reg = allocate();
    code_.load(reg, AssemblerX86_64::in_slot(slot));
    return reg;
  }
  if (!is_needed(of)) {
    const int reg = of.reg;
    write_back(reg);
    of.reg = nothing;
    in(reg) = {nothing, true};
    return reg;
  }
  const bool was_locked = std::exchange(in(of.reg).locked, true);
  const int copy = allocate();
  code_.load(copy, AssemblerX86_64::in_register(of.reg));
  in(of.reg).locked = was_locked;
  return copy;
}

int Encoder::owned_constant(double value) {
  const int reg = allocate();
  code_.load(reg, code_.constant(value));
  return reg;
}

// reg <- reg op the number of a slot.
int Encoder::combined(Arithmetic operation, int reg, int with) {
  const Place place = operand(with);
  code_.arithmetic(operation, reg, place);
  if (place.kind == Place::Kind::reg) release(place.number);
  return reg;
}

int Encoder::product(int a, int b) {
  // In the register of a number that is not needed again.
  if (at(a).reg == nothing || (at(a).next != never && at(b).reg != nothing)) std::swap(a, b);
  if (a == b) {
    const Place place = operand(b);
    if (place.kind == Place::Kind::reg) release(place.number);
    const int reg = owned(a);
    code_.arithmetic(Arithmetic::multiply, reg, AssemblerX86_64::in_register(reg));
    return reg;
  }
  return combined(Arithmetic::multiply, owned(a), b);
}

int Encoder::scaled(double k, int a) {
  const int reg = owned(a);
  code_.arithmetic(Arithmetic::multiply, reg, code_.constant(k));
  return reg;
}

// A locked register with the result.
// NOLINTNEXTLINE(readability-function-cognitive-complexity,readability-function-size): a line for each kind
int Encoder::value(const Instruction& i) {
  const auto with_constant = [&](Arithmetic operation, int reg) {
    code_.arithmetic(operation, reg, code_.constant(i.k));
    return reg;
  };
  // other op product, in the register of the other one
  const auto minus = [&](int reg, int other) {
    const int out = owned(other);
    code_.arithmetic(Arithmetic::subtract, out, AssemblerX86_64::in_register(reg));
    release(reg);
    return out;
  };
  const auto joined = [&](Arithmetic operation) {
    const int first = product(i.a, i.b);
    const int second = product(i.c, i.d);
    code_.arithmetic(operation, first, AssemblerX86_64::in_register(second));
    release(second);
    return first;
  };
  switch (i.code) {
    case Code::copy:
      return owned(i.a);
    case Code::add:
      return at(i.a).reg == nothing ? combined(Arithmetic::add, owned(i.b), i.a)
                                    : combined(Arithmetic::add, owned(i.a), i.b);
    case Code::subtract:
      return combined(Arithmetic::subtract, owned(i.a), i.b);
    case Code::multiply:
      return product(i.a, i.b);
    case Code::divide:
      return combined(Arithmetic::divide, owned(i.a), i.b);
    case Code::negate: {
      const int reg = owned(i.a);
      code_.flip_sign(reg);
      return reg;
    }
    case Code::add_constant:
      return with_constant(Arithmetic::add, owned(i.a));
    case Code::subtract_from_constant:
      return combined(Arithmetic::subtract, owned_constant(i.k), i.a);
    case Code::scale:
      return scaled(i.k, i.a);
    case Code::divide_constant:
      return combined(Arithmetic::divide, owned_constant(i.k), i.a);
    case Code::multiply_add:
      return combined(Arithmetic::add, product(i.a, i.b), i.c);
    case Code::multiply_subtract:
      return combined(Arithmetic::subtract, product(i.a, i.b), i.c);
    case Code::subtract_multiply:
      return minus(product(i.a, i.b), i.c);
    case Code::multiply_add_multiply:
      return joined(Arithmetic::add);
    case Code::multiply_subtract_multiply:
      return joined(Arithmetic::subtract);
    case Code::scale_add:
      return combined(Arithmetic::add, scaled(i.k, i.a), i.c);
    case Code::scale_subtract:
      return combined(Arithmetic::subtract, scaled(i.k, i.a), i.c);
    case Code::subtract_scale:
      return minus(scaled(i.k, i.a), i.c);
    case Code::square_root: {
      const int reg = owned(i.a);
      code_.arithmetic(Arithmetic::square_root, reg, AssemblerX86_64::in_register(reg));
      return reg;
    }
    case Code::choose: {
      const int first = in_register(i.b);
      const int out = owned(i.c);
      const int zero = allocate();
      const int of = in_register(i.a);
      code_.clear(zero);
      code_.move_if_greater(of, zero, out, first);
      return out;
    }
    default:
      return nothing;  // calls
  }
}

// A register becomes that of a slot.
void Encoder::define(int slot, int reg, int next) {
  Slot& of = at(slot);
  if (of.reg != nothing) in(of.reg).slot = nothing;
  of = {reg, false, next, 0};
  in(reg) = {slot, false};
  if (next == never) free(reg);
}

void Encoder::end_part() {
  for (int reg = 0; reg < registers; ++reg) {
    in(reg).locked = false;
    free(reg);
  }
}

Encoded Encoder::encode(std::span<const Part> parts) {
  Encoded out;
  for (const Part& part : parts) {
    out.entries.push_back(code_.size());
    if (part.first < part.calls) code_.begin_function();
    for (std::size_t k = part.first; k < part.calls; ++k) {
      begin(program_[k], uses_[k]);
      define(program_[k].to, value(program_[k]), uses_[k].result);
    }
    if (part.first < part.calls) {
      end_part();
      code_.end_function();
    }
    // Calls read and write slots.
    for (std::size_t k = part.calls; k < part.end; ++k) {
      std::size_t n = 0;
      lanes::each_operand(program_[k], [&](int slot) { at(slot).next = uses_[k].operands[n++]; });
      at(program_[k].to) = {nothing, true, uses_[k].result, 0};
    }
  }
  out.code = std::move(code_).finished();
  return out;
}

}  // namespace

Encoded encode(std::span<const Instruction> program, std::span<const Part> parts, int fixed) {
  return Encoder(program, fixed).encode(parts);
}

}  // namespace gelenk::machine_code
