// SPDX-License-Identifier: BSD-3-Clause
// The rates of element states that name forces or accelerations, which are known when the accelerations are.
#pragma once

#include <functional>
#include <vector>

#include "event_driven/event_modes.h"
#include "formulation/contact_motion.h"
#include "formulation/drives.h"

namespace gelenk {

class ForceReader {
 public:
  virtual ~ForceReader() = default;

  // Writes these rates to `rates`, by element state, and leaves the others. The dynamics are at y = (q, v, element
  // states), after set_acceleration(vdot) and set_root_poses(). u: the signals; forces, modes: of all forces with
  // modes.
  virtual void read(const double* y, const double* vdot, const double* u, const double* forces, const int* modes,
                    double* rates) = 0;
};

class RatesOfForces {
 public:
  // All must outlive it.
  RatesOfForces(Dynamics& dynamics, Drives& drives, EventModes& modes, ContactMotion& contacts, int velocities)
      : dynamics_(dynamics), drives_(drives), modes_(modes), contacts_(contacts), vdot_(velocities) {}

  // reader: must outlive it.
  void read_by(ForceReader& reader) { reader_ = &reader; }
  bool any() const { return reader_ != nullptr; }
  // Adds these rates to `rates`; `dynamics` is at y, and has the solution of its accelerations vdot. solve: finds them
  // again, with the forces of closed contacts as loads.
  void add(const double* y, const double* vdot, const std::function<void(double* vdot)>& solve, double* rates);

 private:
  Dynamics& dynamics_;
  Drives& drives_;
  EventModes& modes_;
  ContactMotion& contacts_;
  ForceReader* reader_ = nullptr;  // null: there are none
  std::vector<double> vdot_;
};

}  // namespace gelenk
