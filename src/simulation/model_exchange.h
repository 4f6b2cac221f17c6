// SPDX-License-Identifier: BSD-3-Clause
// A simulation whose states an integrator outside advances: rates, event indicators and events instead of steps. Steps
// are those that the integrator declares completed. States may be set in any order: results depend on these states, the
// time, the inputs, and on where the present step began.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "simulation/simulation.h"
#include "util/archive.h"

namespace gelenk {

class ExchangedIsland;

class ModelExchange {
 public:
  // Why a scene cannot be run so, as the end of a sentence; empty: it can.
  static std::string refusal(const Scene& scene);
  // The scene with the formulation whose equations are those of states that satisfy the constraints.
  static Scene prepared(Scene scene);
  // The number of event indicators of a scene, which is assembled.
  static int indicators_of(const Scene& scene);

  // of: of a prepared scene, after initialize(); outlives this. states: those of StateDerivatives, in the wanted order.
  ModelExchange(Simulation& of, std::vector<int> states);
  ~ModelExchange();
  ModelExchange(ModelExchange&&) noexcept;
  ModelExchange& operator=(ModelExchange&&) = delete;

  std::span<const double> states() const { return x_; }  // SI units, as all that follows
  double time() const { return time_; }                  // s
  int indicators() const;

  // Throw UsageError for a number that is not finite.
  void set_time(double t);
  void set_state(std::size_t state, double value);
  void set_states(std::span<const double> x);
  // Call if an input has been set.
  void inputs_changed() { has_rates_ = false; }

  // At the present states, time and inputs. Throw StepError where these states do not determine the mechanism.
  std::span<const double> rates();
  void indicator_values(double* z);
  // Brings the simulation there, so that its outputs and derivatives can be read.
  void show();

  // The integrator has completed a step, which ends here. Returns whether an event must happen before the next one.
  bool complete_step();
  struct Event {
    bool states_changed = false;
    double next_time = INFINITY;  // s, of the next one that is known
  };
  // What happens here: impacts, changes of modes, jumps of inputs, kinks of functions of time. Throws StepError; all is
  // then as before.
  Event pass_event();

  // Instead of Simulation::serialize().
  void serialize(Archive& archive);

 private:
  template <class Body>
  void attempt(Body body);
  void place();
  std::string describe_lost(ExchangedIsland& island) const;
  void save(Archive& archive);

  Simulation& simulation_;
  std::vector<int> states_;  // outputs
  std::vector<std::unique_ptr<ExchangedIsland>> islands_;
  std::vector<double> x_, xdot_;
  double time_ = 0;
  bool is_placed_ = false, is_shown_ = false, has_rates_ = false;
  Archive before_;
};

}  // namespace gelenk
