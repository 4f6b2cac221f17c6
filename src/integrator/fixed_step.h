// SPDX-License-Identifier: BSD-3-Clause
// Base class of fixed-step methods: equal steps from one communication point to the next, each projected.
#pragma once

#include <vector>

#include "event/locator.h"
#include "integrator/integrator.h"

namespace gelenk {

class FixedStep : public Integrator, private Stepping {
 public:
  void restart(double t, const double* y) override;
  void serialize(Archive& archive) override;
  double advance(double end, double* y) final;
  double advance_some(double end, double* y, long max_steps) final;

 protected:
  FixedStep(Equations& system, const IntegratorOptions& options);

  // Advances y_ from t to t + h, without projection.
  virtual void make_step(double t, double h) = 0;
  // Whether steps end at events.
  virtual bool locates_events() const { return true; }
  // Computes k_ = f(t, y). Throws IntegrationError if it is not finite.
  void evaluate(double t, const double* y);

  Equations& system_;
  int n_;
  std::vector<double> y_, k_;

 private:
  // Relative motions slower than this have no direction of their own [natural units of speed]: larger than with
  // adaptive steps, since errors are not controlled.
  static constexpr double no_direction = 1e-6;

  // Whether steps follow from rates at their start, so that stability limits them.
  virtual bool is_explicit() const { return true; }

  double time() const final { return t_; }
  const double* state() const final { return y_.data(); }
  Step step_towards(double end) final;
  void go_to(double t, const double* y) final { restart(t, y); }
  void stop_at(double /*end*/) final {}
  EventSource::SlowSliding slow_sliding() const final {
    return {.directed_from = no_direction, .is_explicit = is_explicit()};
  }
  void step_by_events(double end);
  void take_step(double t, double h, double end);

  Locator locator_;
  std::string error_;  // message of a step that failed
  double step_;
  double t_ = 0;
};

}  // namespace gelenk
