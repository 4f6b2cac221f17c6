// SPDX-License-Identifier: BSD-3-Clause
#include "recording/recorded_tape.h"

#include <vector>

namespace gelenk::expression {

using recording::Recorded;

template <>
void Tape::evaluate(const Recorded* variables, Recorded* out, const bool*, Recorded*, const bool*) const {
  std::vector<Recorded> x(max_slots);
  for (const auto& [slot, index] : variables_) x[static_cast<std::size_t>(slot)] = variables[index];
  for (const auto& [slot, value] : constants_) x[static_cast<std::size_t>(slot)] = Recorded(value);
  for (const Instruction& i : instructions_) {
    const auto at = [&](std::size_t k) -> const Recorded& { return x[static_cast<std::size_t>(i.of[k])]; };
    const auto value = [&]() -> Recorded {
      switch (i.operation) {
        case Operation::add:
          return at(0) + at(1);
        case Operation::subtract:
          return at(0) - at(1);
        case Operation::multiply:
          return at(0) * at(1);
        case Operation::divide:
          return at(0) / at(1);
        case Operation::negate:
          return -at(0);
        case Operation::integer_power:
          return integer_power(at(0), i.index);
        case Operation::power:
          return Recorded::power(at(0), at(1));
        case Operation::atan2:
          return atan2(at(0), at(1));
        case Operation::choose:
          return Recorded::chosen(at(0), at(1), at(2));
        case Operation::lookup:
          throw recording::HiddenBranch();
        default:
          return Recorded::function(i.operation, at(0));
      }
    };
    x[static_cast<std::size_t>(i.to)] = value();
  }
  for (std::size_t k = 0; k < outputs_.size(); ++k) out[k] = x[static_cast<std::size_t>(outputs_[k])];
}

}  // namespace gelenk::expression
