// SPDX-License-Identifier: BSD-3-Clause
// A simulation as Python holds it.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <mutex>
#include <string>

#include "simulation/simulation.h"

namespace gelenk {

// A simulation with a mutex. Steps run without the interpreter's lock, so another Python thread may call meanwhile; it
// waits here. The interpreter's lock is released before the mutex is locked, since the other order could deadlock.
class SharedSimulation {
 public:
  explicit SharedSimulation(const Scene& scene) : simulation_(scene) {}

  template <class Function>
  auto with(Function&& function) {
    const nanobind::gil_scoped_release release;
    const std::scoped_lock lock(mutex_);
    return function(simulation_);
  }

  // Access without lock, for data that do not change after construction.
  const Simulation& fixed() const { return simulation_; }

 private:
  Simulation simulation_;
  std::mutex mutex_;
};

// Throws IndexError.
inline void check_index(int index, std::size_t size) {
  if (index < 0 || static_cast<std::size_t>(index) >= size) {
    throw nanobind::index_error(
        ("index: found " + std::to_string(index) + ", expected less than " + std::to_string(size)).c_str());
  }
}

// Runs over many communication points: a method of Simulation, and the class Batch (runs.cpp).
void bind_runs(nanobind::module_& m, nanobind::class_<SharedSimulation>& simulation);

// Equilibria: methods of Simulation, and their tolerances (equilibria.cpp).
void bind_equilibria(nanobind::module_& m, nanobind::class_<SharedSimulation>& simulation);
// Simulations at given states: methods of Simulation, and follow_all() (placement.cpp).
void bind_placement(nanobind::module_& m, nanobind::class_<SharedSimulation>& simulation);
// Many instances that are stepped together: the class Fleet (fleet.cpp).
void bind_fleet(nanobind::module_& m);

}  // namespace gelenk
