// SPDX-License-Identifier: BSD-3-Clause
// Rates of element states that name forces, read as outputs are.
#pragma once

#include "formulation/rates_of_forces.h"
#include "kinematics/loads.h"
#include "outputs/outputs.h"

namespace gelenk {

class StateForceReader final : public ForceReader {
 public:
  // All must outlive it. island: its index.
  StateForceReader(const Outputs& outputs, int island, const Mechanism& mechanism, const Loads& loads,
                   StateReadings& readings)
      : outputs_(outputs), island_(island), mechanism_(mechanism), loads_(loads), readings_(readings) {}

  void read(const double* y, const double* vdot, const double* u, const double* forces, const int* modes,
            double* rates) override {
    read({.dynamics = readings_,
          .q = y,
          .v = y + mechanism_.nq,
          .vdot = vdot,
          .cut_q = nullptr,  // nothing that is named reads them: they are known with the position
          .signals = readings_.all_signals(u),
          .forces = forces,
          .modes = modes},
         rates);
  }
  void read(const Reading& reading, double* rates) const {
    outputs_.rates_of_forces(island_, loads_.rates, reading, rates);
  }

 private:
  const Outputs& outputs_;
  int island_;
  const Mechanism& mechanism_;
  const Loads& loads_;
  StateReadings& readings_;
};

}  // namespace gelenk
