// SPDX-License-Identifier: BSD-3-Clause
// Terms of a graph as a list of instructions on slots.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "expression/graph.h"
#include "lanes/frame.h"
#include "lanes/instruction.h"

namespace gelenk::lanes {

// Where terms that are known before a program runs are found: variables, and what other programs have computed.
using Slots = std::map<expression::Term, int>;
// A term, and the slot into which it is written.
using Output = std::pair<expression::Term, int>;

// Operations that have no lanes: the first one found, or nothing.
bool has_lookups(const expression::Graph& graph, const std::vector<expression::Term>& terms);

// Of instructions: those of the same kind together, for loops over lanes; or calls of functions first, for one lane, so
// that there is much arithmetic without calls.
enum class Order { alike, calls_first };

class Program {
 public:
  Program() = default;
  // Every variable on which the outputs depend is given. Constants, and what is temporary, get slots of the frame.
  Program(const expression::Graph& graph, const Slots& given, const std::vector<Output>& outputs, Frame& frame,
          Order order = Order::alike);

  // Once all programs of a frame are made: temporary slots follow those with a place.
  void place_temporaries(const Frame& frame);
  const std::vector<Instruction>& instructions() const { return instructions_; }
  bool empty() const { return instructions_.empty(); }

 private:
  std::vector<Instruction> instructions_;
};

}  // namespace gelenk::lanes
