// SPDX-License-Identifier: BSD-3-Clause
// A simulation that begins again and again, as the first of many runs whose scenes differ in masses and loads alone.
//
// What a run takes before its first step is mostly the same in all of them: names are checked, the scene is reduced,
// loops are closed, memory is allocated. Here all of this is done once, and what depends on the numbers is done for
// each run, by the same functions, so that a run has the same bits as one of a new simulation.
#pragma once

#include <functional>
#include <memory>

#include "simulation/simulation.h"

namespace gelenk {

class RepeatedStart {
 public:
  // simulation: before its inputs are set and it is initialized. It must outlive this object, and be used by one at a
  // time.
  explicit RepeatedStart(Simulation& simulation);
  ~RepeatedStart();

  // Call after initialize(), before anything else.
  void keep();
  // Whether other runs may begin here, unless their numbers are of another kind.
  bool is_possible() const;
  // Begins a run. change: sets those numbers of the scene, which was given in SI units, of which
  // Parameter::keeps_positions is set, the same ones in all runs, and returns whether they are valid. set_inputs: sets
  // the inputs that are not at their start values. Returns false if a run of this scene may begin otherwise, or not at
  // all: then it needs a new simulation, and this one may only begin other runs.
  bool begin(const std::function<bool(Scene&)>& change, const std::function<void()>& set_inputs);

 private:
  struct Kept;

  bool take_numbers();
  bool take_loads();
  void begin_islands();
  bool starts_within_limits() const;

  Simulation& simulation_;
  std::unique_ptr<Kept> kept_;
};

}  // namespace gelenk
