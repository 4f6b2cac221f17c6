// SPDX-License-Identifier: BSD-3-Clause
// Binds the names in expressions to the signals of an island (kinematics/loads.h).
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>

#include "kinematics/loads.h"
#include "scene/scene.h"

namespace gelenk {

// The scenes must outlive it.
class SignalBinder {
 public:
  // first_input: index of the first input of no element (scene/signals.h).
  SignalBinder(const Scene& scene, const ReducedScene& reduced, int first_input);

  // Number of the signals of the whole scene: its inputs and its clock. Element states of an island follow.
  int signals() const { return signals_; }
  // Binds the names of a formula of this island, the element states of which `loads` has; adds coordinates to `loads`.
  // Forces are no signals: their index is -1.
  void bind(Formula& formula, const Mechanism& mechanism, Loads& loads);

 private:
  struct Bound {
    int index = 0;
    double size = 1;
  };
  Bound find(std::string_view name, const Mechanism& mechanism, Loads& loads);

  const Scene& scene_;
  const ReducedScene& reduced_;
  int first_input_, signals_;
  std::unordered_map<std::string, std::string> force_units_;  // by name, once a formula names one
  // By name: an output of a sensor that several expressions name is computed once.
  std::unordered_map<std::string, std::shared_ptr<const NamedReading>> readings_;
};

}  // namespace gelenk
