// SPDX-License-Identifier: BSD-3-Clause
// What is computed for many lanes at once: numbers in slots, each of which holds one number per lane.
#pragma once

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

}  // namespace gelenk::lanes
