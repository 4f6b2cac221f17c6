// SPDX-License-Identifier: BSD-3-Clause
// The equations that an integrator solves. With y = (q, v, z), z the states of elements, they are
// an ODE on a manifold, ydot = f(t, y); for some formulations also a DAE, F(t, x, xdot) = 0, whose unknowns x are y
// followed by multipliers.
#pragma once

#include <cmath>
#include <string>

#include "event/event_log.h"
#include "event/event_source.h"
#include "time_stepping/impulse_accuracy.h"

namespace gelenk {

// Equations whose velocities jump at the ends of steps: contacts, friction and limits act by impulses in each step,
// instead of by modes between events.
class ImpulseEquations {
 public:
  virtual ~ImpulseEquations() = default;

  // Whether shapes can touch; and whether that can also be by modes between located events.
  virtual bool are_required() const = 0;
  virtual bool may_be_located() const = 0;
  // Whether element states jump at events, which steps with impulses do not locate.
  virtual bool must_be_located() const = 0;
  // Call before all else, if steps are made with impulses.
  virtual void use(ImpulseAccuracy accuracy) = 0;
  // Whether the present steps are made with impulses; changes that at (t, y), after use(), or back.
  virtual bool are_used() const = 0;
  virtual void change_to(bool impulses, double t, const double* y) = 0;
  // Of the present way, since the start: counts of which differences are taken.
  struct Activity {
    int closed = 0;             // points of contact at present
    long changes = 0;           // steps in which points have opened or closed, begun or ceased to slide
    EventLog::Counts events{};  // located
  };
  virtual Activity activity() const = 0;
  // Whether modes can take over at y: nothing overlaps.
  virtual bool can_be_located_at(const double* y) = 0;
  // After located events were refused: whether contacts between shapes take part in that, and impulses can lead on;
  // then forgets the events since `before`.
  virtual bool take_over(const Activity& before) = 0;
  // Forgets the events since `before`, which are repeated.
  virtual void forget_events(const Activity& before) = 0;
  // To the log of events.
  virtual void report(const SchemeChange& change) = 0;
  // Call at the start of a run with steps of length h at (t, y): finds the forces there.
  virtual void start(double t, double h, const double* y) = 0;
  // Advances y from t by h, without projection. Returns false if it is not finite.
  virtual bool step(double t, double h, double* y) = 0;
  // The accelerations (nv) by all but impulses in the middle of the last step.
  virtual const double* smooth_accelerations() const = 0;
  // What the next step starts from, impulses and what slides: keeps it, returns to what was kept, and exchanges it for
  // that of a second run of the same equations, which begins as a copy.
  virtual void keep() = 0;
  virtual void return_to_kept() = 0;
  virtual void copy_to_second() = 0;
  virtual void exchange_with_second() = 0;
  // The highest circular frequency of vibrations at (t, y), of no contact [rad/s]: steps are stable up to 2 /
  // frequency. 0: unknown.
  virtual double highest_frequency(double t, const double* y) = 0;
};

class Equations {
 public:
  virtual ~Equations() = default;

  virtual int size() const = 0;
  virtual int coordinates() const = 0;  // nq: number of coordinates in y
  virtual int velocities() const = 0;   // nv; what follows in y are element states

  // ydot = f(t, y), size() numbers each. Returns false if not finite; a smaller step may help.
  virtual bool rhs(double t, const double* y, double* ydot) = 0;
  // Exact df/dy at (t, y), column-major. Returns false as rhs() does.
  virtual bool jacobian(double t, const double* y, double* J) = 0;
  // Whether the derivatives at the start of the present step are far from those of the last jacobian().
  virtual bool jacobian_is_outdated() { return false; }
  // Projects y onto the constraints by the smallest change in the mass metric. Returns false if that fails. For a DAE,
  // which satisfies them itself, only normalizes quaternions.
  virtual bool project(double t, double* y) = 0;
  // Whether project() reduces the errors to rounding level, far below any tolerance: multistep methods take differences
  // of former states.
  virtual void polish(bool /*on*/) {}
  // The latest time at which a step of variable length from t should end.
  virtual double end_of_step(double /*t*/) { return INFINITY; }
  // How far the state of the last rhs() or project() is from a singular configuration of the loops, where assembly
  // configurations meet: about 1 where they are farthest apart, 0 where they cannot be distinguished.
  virtual double singular_distance() const { return 1; }
  // Displaces q by dv, velocities times time.
  virtual void displace(double* q, const double* dv) const = 0;
  // Call when a step has been accepted; y satisfies the constraints.
  virtual void accepted(double t, const double* y) = 0;
  // The source of the events at which the equations change their form.
  virtual EventSource& modes() = 0;
  // Whether the evaluation budget is used up: an advance then ends after the current step.
  virtual bool budget_exhausted() const { return false; }

  // The same equations with velocities that jump; null: they are not available.
  virtual ImpulseEquations* impulses() { return nullptr; }

  // --- as a DAE; that of an ODE is xdot - f(t, x) = 0 ---
  virtual int multipliers() const { return 0; }  // 0: an ODE, for any integrator
  int unknowns() const { return size() + multipliers(); }
  // Differentiation index of unknown i (Hairer & Wanner II, sec. VII.1), which determines how its errors and its
  // equations in Newton's method scale with the step.
  virtual int index(int) const { return 1; }
  // r = F(t, x, xdot), unknowns() numbers each; row i < size() determines xdot[i]. Returns false as rhs() does.
  virtual bool residual(double t, const double* x, const double* xdot, double* r);
  // Exact dF/dx and dF/dxdot, column-major. Returns false as rhs() does.
  virtual bool residual_jacobians(double t, const double* x, const double* xdot, double* F_x, double* F_xdot);
  // Sets the multipliers that follow y, and xdot (0 for multipliers), from the accelerations of the index-1 form.
  // Returns false as rhs() does, or if they are not unique; see obstacle().
  virtual bool consistent(double t, double* x, double* xdot) { return rhs(t, x, xdot); }
  // Describes why the equations cannot be solved at y or near it; empty if unknown.
  virtual std::string obstacle(const double*) { return {}; }
};

}  // namespace gelenk
