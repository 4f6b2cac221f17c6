// SPDX-License-Identifier: BSD-3-Clause
// What all integrators offer. One instance belongs to one simulation.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "formulation/equations.h"
#include "util/archive.h"

namespace gelenk {

struct IntegratorOptions {
  double tolerance = 1e-6;  // relative; absolute per unit of y
  double step = 1e-3;       // s, of fixed-step methods
  double rho_inf = 0.8;     // of generalized-alpha and hht: spectral radius at infinite frequency, 0 to 1 (hht: 1/2)
};

// The step asked for could not be made; says why and how far it came.
class IntegrationError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Integrator {
 public:
  virtual ~Integrator() = default;

  // Begins anew at (t, y).
  virtual void restart(double t, const double* y) = 0;
  // The inputs have jumped since the last advance.
  virtual void inputs_changed() {}
  // Whether steps go beyond events, which whoever has them made looks for; at first they end there.
  virtual void pass_events(bool /*on*/) {}
  // Advances to `end` > t exactly, or to the end of the first step after which the system's evaluations are
  // budget_exhausted(); writes the state there to y and returns the time. Throws IntegrationError and leaves y alone;
  // restart() is due then.
  virtual double advance(double end, double* y) = 0;
  // Likewise, but for at least one step and no more than `most`, where the method can stop between: returns the time
  // reached, of which y is the state.
  virtual double advance_some(double end, double* y, long /*most*/) { return advance(end, y); }

  // Steps are no finer with a tolerance below this. 0: they always are.
  virtual double finest_tolerance() const { return 0; }

  // Makes some steps towards `end`, so that what they need of the heap is there; y is written over. Exceptions as of
  // advance(). Where it stands afterwards is not said.
  virtual void warm_up(double end, double* y) { advance_some(end, y, 2); }
  // A multistep method's history, or the factors of a Newton matrix that serves again, cannot be written down: a past.
  // What such a method will do is known from where it had none, and from what it was asked for since.
  // Whether it ever has one; whether the next advance gives it one; whether it has one.
  virtual bool may_have_history() const { return will_have_history(); }
  virtual bool will_have_history() const { return false; }
  virtual bool has_history() const { return false; }
  // Has none from here on; (t, y) is where it stands.
  virtual void discard_history(double t, const double* y) { restart(t, y); }
  // What it carries from one communication point to the next besides (t, y) and its past, after restart() there when
  // reading. Not to be written while it has one.
  virtual void serialize(Archive& archive) { archive.serialize(steps_, rejected_); }

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

// All integrators that can be named in a scene (registry.cpp).
std::span<const IntegratorKind> integrator_kinds();

// Throws std::out_of_range for an unknown name.
std::unique_ptr<Integrator> make_integrator(std::string_view name, Equations& system, const IntegratorOptions& options);

// One per file.
std::unique_ptr<Integrator> make_automatic(Equations& system, const IntegratorOptions& options);
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

// Tells a run that gets nowhere from one that is long: a window of steps must take it some way towards the end.
class StallDetector {
 public:
  StallDetector(double start, double end) : least_(1e-4 * (end - start)), mark_(start) {}
  // Call after each step. Empty, or why to give up.
  std::string step_to(double t);

 private:
  static constexpr int window = 20000;  // steps; some tens of milliseconds for a small mechanism
  double least_, mark_;
  int count_ = 0;
};

// When to try another way again: after each failure later, up to a longest wait.
class Backoff {
 public:
  // factor: by which a failure makes the wait longer; longest: in calls of due().
  Backoff(int factor, int longest) : factor_(factor), longest_(longest) {}
  // Counts a chance for a trial; whether to take it.
  bool due() {
    if (waiting_ > 0) --waiting_;
    return waiting_ == 0;
  }
  // What due() would say.
  bool near() const { return waiting_ <= 1; }
  void succeeded() { wait_ = 1; }
  void serialize(Archive& archive) { archive.serialize(wait_, waiting_); }
  void failed() { waiting_ = wait_ = std::min(factor_ * wait_, longest_); }

 private:
  int factor_, longest_;
  int wait_ = 1, waiting_ = 1;
};

// "t = 1.2031 s: ..." as integrators begin their messages.
std::string at_time(double t);

// Throws IntegrationError: what stands in the way of the equations at y where they know it, otherwise `why`.
[[noreturn]] void refuse(Equations& system, double t, const double* y, const std::string& why);

}  // namespace gelenk
