// SPDX-License-Identifier: BSD-3-Clause
// What is computed for many lanes at once: numbers in slots, each of which holds one number per lane.
#pragma once

#include <array>
#include <cstddef>

#include "expression/graph.h"

namespace gelenk::lanes {

// k: a constant, equal in all lanes. A product and the sum of which it is a part are one instruction, rounded twice:
// the product is neither written nor read. No fused multiply-add: processors without it must give the same bits.
enum class Code : unsigned char {
  copy,                        // a
  add,                         // a + b
  subtract,                    // a - b
  multiply,                    // a b
  divide,                      // a / b
  negate,                      // -a
  add_constant,                // a + k
  subtract_from_constant,      // k - a
  scale,                       // k a
  divide_constant,             // k / a
  multiply_add,                // a b + c
  multiply_subtract,           // a b - c
  subtract_multiply,           // c - a b
  multiply_add_multiply,       // a b + c d
  multiply_subtract_multiply,  // a b - c d
  scale_add,                   // k a + c
  scale_subtract,              // k a - c
  subtract_scale,              // c - k a
  sine,
  cosine,
  sine_cosine,  // to: sin a, b: cos a
  square_root,
  choose,    // a > 0 ? b : c
  function,  // of a, and b if it has two arguments
};

struct Instruction {
  Code code = Code::copy;
  expression::Operation function = expression::Operation::constant;
  int to = 0, a = 0, b = 0, c = 0, d = 0;  // slots
  double k = 0;
};

// Whether an instruction is a call of a function, rather than arithmetic.
inline bool calls_function(Code code) {
  return code == Code::sine || code == Code::cosine || code == Code::sine_cosine || code == Code::function;
}

inline int operand_count(const Instruction& i) {
  switch (i.code) {
    case Code::copy:
    case Code::negate:
    case Code::add_constant:
    case Code::subtract_from_constant:
    case Code::scale:
    case Code::divide_constant:
    case Code::sine:
    case Code::cosine:
    case Code::sine_cosine:
    case Code::square_root:
      return 1;
    case Code::multiply_add:
    case Code::multiply_subtract:
    case Code::subtract_multiply:
    case Code::choose:
      return 3;
    case Code::multiply_add_multiply:
    case Code::multiply_subtract_multiply:
      return 4;
    case Code::function:
      return i.b >= 0 ? 2 : 1;
    default:
      return 2;
  }
}

inline bool has_third_alone(const Instruction& i) {
  return i.code == Code::scale_add || i.code == Code::scale_subtract || i.code == Code::subtract_scale;
}

// use(slot) for each slot that an instruction reads.
template <class Of, class Use>
void each_operand(Of& i, Use use) {
  constexpr std::array of{&Instruction::a, &Instruction::b, &Instruction::c, &Instruction::d};
  for (int k = 0; k < operand_count(i); ++k) {
    const bool is_third = has_third_alone(i) && k == 1;
    use(i.*of[static_cast<std::size_t>(is_third ? 2 : k)]);
  }
}

}  // namespace gelenk::lanes
