// SPDX-License-Identifier: BSD-3-Clause
// The interface of all integrators. Each instance belongs to one simulation.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "event/event_source.h"
#include "formulation/equations.h"
#include "util/archive.h"

namespace gelenk {

struct IntegratorOptions {
  double tolerance = 1e-6;        // relative; absolute for components of y below 1
  double step = 1e-3;             // s, of fixed-step methods
  double cone_tolerance = 1e-11;  // moreau-jean: see Solver
  double rho_inf = 0.8;  // generalized-alpha and hht: spectral radius at infinite frequency, 0 to 1 (hht: 1/2 to 1)
};

// Thrown if a step cannot be made; the message states the cause and the time reached.
class IntegrationError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// No method could continue: see EventSource::refusal().
class RefusedMotion : public IntegrationError {
  using IntegrationError::IntegrationError;
};

class Integrator {
 public:
  virtual ~Integrator() = default;

  // Starts or restarts at (t, y).
  virtual void restart(double t, const double* y) = 0;
  // Call at the start of each communication step, though not where it continues after having been cut short.
  virtual void begin() {}
  // Call if inputs have changed discontinuously since the last advance.
  virtual void inputs_changed() {}
  // Call if the equations at the present time are not to the bit those at the end of the last advance, although inputs
  // have not jumped: a derivative from there is not used again.
  virtual void inputs_touched() {}
  // Whether steps may extend across events, which the caller then locates; by default they end there.
  virtual void pass_events(bool /*on*/) {}
  // Advances to `end` > t [s] exactly, or to the end of the first step after which the evaluation budget of the system
  // is exhausted; writes the state there to y and returns the time. Throws IntegrationError and leaves y unchanged;
  // restart() must follow.
  virtual double advance(double end, double* y) = 0;
  // The same for at least one step and at most max_steps, if the method can stop in between: returns the time reached;
  // y is the state there.
  virtual double advance_some(double end, double* y, long /*max_steps*/) { return advance(end, y); }

  // What its steps must be bounded for (EventSource::longest_step); by default nothing.
  virtual EventSource::SlowSliding slow_sliding() const { return {.followed_from = 0}; }
  // Tolerance below which steps do not become smaller; 0: there is none.
  virtual double finest_tolerance() const { return 0; }

  // Makes some steps towards `end` so that the memory they need is allocated; overwrites y. Throws as advance() does.
  // The state afterwards is unspecified.
  virtual void warm_up(double end, double* y) { advance_some(end, y, 2); }
  // The history of a multistep method, or the factors of a Newton matrix that is reused, cannot be saved. The future of
  // such a method follows from its last state without a history and the calls since.
  // may_have_history(): whether the method ever has one; will_have_history(): whether the next advance creates one;
  // has_history(): whether there is one now.
  virtual bool may_have_history() const { return will_have_history(); }
  virtual bool will_have_history() const { return false; }
  virtual bool has_history() const { return false; }
  // Discards the history; (t, y) is the present state.
  virtual void discard_history(double t, const double* y) { restart(t, y); }
  // Saves or restores all data carried between communication points in addition to (t, y) and the history; when
  // reading, after restart() there. Saving has no effect on the run, and must not be done while there is a history.
  virtual void serialize(Archive& archive) { archive.serialize(steps_, rejected_); }

  // Where `auto` has made steps with impulses.
  struct SteppedTime {
    int parts = 0;                                          // 0: nowhere
    SchemeChange::Cause cause = SchemeChange::Cause::none;  // of the first part
    double from = 0, to = 0;                                // s: start of the first, end of the last part
    double time = 0;                                        // s: sum of all parts
    double error = 0;  // the largest estimated error of positions [rad, natural units of length]
  };
  virtual SteppedTime stepped_time() const { return {}; }

  long steps() const { return steps_; }
  long rejected_steps() const { return rejected_; }

 protected:
  long steps_ = 0;
  long rejected_ = 0;
};

struct IntegratorKind {
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<Integrator> (*make)(Equations& system, const IntegratorOptions& options);
};

// All integrators (registry.cpp); names as in scene/words.h.
std::span<const IntegratorKind> integrator_kinds();

// Throws std::out_of_range for an unknown name.
std::unique_ptr<Integrator> make_integrator(std::string_view name, Equations& system, const IntegratorOptions& options);

// One function per integrator.
std::unique_ptr<Integrator> make_automatic(Equations& system, const IntegratorOptions& options);
// `auto` with contacts: located events with the given method, or steps with impulses, as event/scheme_watch.h decides.
std::unique_ptr<Integrator> make_contact_scheme(std::unique_ptr<Integrator> between_events, Equations& system,
                                                const IntegratorOptions& options);
// Of a mechanism without degrees of freedom; the other one where these steps fail.
std::unique_ptr<Integrator> make_kinematic_steps(Equations& system, std::unique_ptr<Integrator> general);
std::unique_ptr<Integrator> make_moreau_jean(Equations& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_rk4(Equations& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_cvode(Equations& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_cvode_adams(Equations& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_dirk(Equations& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_euler(Equations& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_erk(Equations& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_ida(Equations& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_generalized_alpha(Equations& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_hht(Equations& system, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_newmark(Equations& system, const IntegratorOptions& options);

// Detects a run that makes no progress: a window of steps must advance the time by some fraction of the interval.
class StallDetector {
 public:
  StallDetector(double start, double end) : min_advance_(1e-4 * (end - start)), mark_(start) {}
  // Call after each step to t [s]. Returns why to give up; otherwise empty.
  std::string step_to(double t);

 private:
  static constexpr int window = 20000;  // steps; some tens of milliseconds of computing time for a small mechanism
  double min_advance_, mark_;
  int count_ = 0;
};

// Decides when to try an alternative again: the wait grows after each failure, up to a maximum.
class Backoff {
 public:
  // factor: by which a failure multiplies the wait; max_wait: in calls of due().
  Backoff(int factor, int max_wait) : factor_(factor), max_wait_(max_wait) {}
  // Counts an opportunity for a trial; returns whether to make it.
  bool due() {
    if (waiting_ > 0) --waiting_;
    return waiting_ == 0;
  }
  // Whether the next due() will return true.
  bool near() const { return waiting_ <= 1; }
  void succeeded() { wait_ = 1; }
  void serialize(Archive& archive) { archive.serialize(wait_, waiting_); }
  void failed() { waiting_ = wait_ = std::min(factor_ * wait_, max_wait_); }

 private:
  int factor_, max_wait_;
  int wait_ = 1, waiting_ = 1;
};

// "t = 1.2031 s: ", the prefix of the messages of integrators.
std::string at_time(double t);

// Throws IntegrationError with the obstacle that the equations report at y, otherwise with `why`.
[[noreturn]] void refuse(Equations& system, double t, const double* y, const std::string& why);

}  // namespace gelenk
