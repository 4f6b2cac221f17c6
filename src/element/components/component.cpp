// SPDX-License-Identifier: BSD-3-Clause
#include "element/components/component.h"

namespace gelenk {

std::string joined(ComponentEquations::Texts texts) {
  std::string out;
  for (const std::string_view text : texts) out += text;
  return out;
}

void ComponentEquations::signal(const Quantity& quantity, const Formula& given) {
  if (given.is_given()) {
    values.push_back({quantity, std::string(given.text()), true});
  } else {
    inputs.push_back(quantity);
  }
}

void ComponentEquations::state(const Quantity& quantity, Texts rate, double start, double nominal) {
  states.push_back({quantity, joined(rate), start, nominal});
}

void ComponentEquations::value(const Quantity& quantity, Texts value) { values.push_back({quantity, joined(value)}); }

void ComponentEquations::act(Texts value) {
  this->value({"{effort}", "{f}", "{torque} on joint {joint}"}, value);
  effort = "{effort}";
}

void ComponentEquations::pull(Texts value) {
  this->value({"f", "N", "force that pulls the points together"}, value);
  tension = "f";
}

}  // namespace gelenk
