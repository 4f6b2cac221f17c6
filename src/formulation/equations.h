// SPDX-License-Identifier: BSD-3-Clause
// What an integrator sees of a mechanism. With y = (q, v) an ODE on a manifold, ydot = f(t, y); of some formulations
// also a DAE, F(t, x, xdot) = 0, whose unknowns x are y and multipliers after it.
#pragma once

#include <string>

#include "event/event_source.h"

namespace gelenk {

class Equations {
 public:
  virtual ~Equations() = default;

  virtual int size() const = 0;
  virtual int coordinates() const = 0;  // nq: how many of y are q

  // ydot = f(t, y), size() numbers each. False: not finite here; a smaller step may help.
  virtual bool rhs(double t, const double* y, double* ydot) = 0;
  // Exact df/dy at (t, y), column-major. False: as rhs.
  virtual bool jacobian(double t, const double* y, double* J) = 0;
  // Takes y back onto the constraints by the least change in the mass metric. False: not reached. Of a DAE, which holds
  // them itself: makes quaternions unit again.
  virtual bool project(double t, double* y) = 0;
  // Whether project() leaves rounding alone from now on, or what is small beside any tolerance: multistep methods take
  // differences of the states they have been through.
  virtual void polish(bool /*on*/) {}
  // q <- q moved by dv, speeds times time.
  virtual void displace(double* q, const double* dv) const = 0;
  // A step has been accepted; y is on the constraints.
  virtual void accepted(double t, const double* y) = 0;
  // What changes the equations' form.
  virtual EventSource& modes() = 0;
  // Whether the evaluations allowed are used up: an advance then ends after the step it is in.
  virtual bool budget_exhausted() const { return false; }

  // --- as a DAE; that of an ODE is xdot - f(t, x) = 0 ---
  virtual int multipliers() const { return 0; }  // none: an ODE, for any integrator
  int unknowns() const { return size() + multipliers(); }
  // Differentiation index of unknown i (Hairer & Wanner II, sec. VII.1): how its errors and its part in Newton's
  // equations go with the step.
  virtual int index(int) const { return 1; }
  // r = F(t, x, xdot), unknowns() numbers each; row i < size() is what determines xdot[i]. False: as rhs.
  virtual bool residual(double t, const double* x, const double* xdot, double* r);
  // Exact dF/dx and dF/dxdot, column-major. False: as rhs.
  virtual bool residual_jacobians(double t, const double* x, const double* xdot, double* F_x, double* F_xdot);
  // Fills in the multipliers behind y, and xdot (that of multipliers: 0), from the accelerations of index 1 there.
  // False: as rhs, or there are none; see obstacle().
  virtual bool consistent(double t, double* x, double* xdot) { return rhs(t, x, xdot); }
  // Why the equations cannot be solved at y, or near it, in words; empty: nothing is known.
  virtual std::string obstacle(const double*) { return {}; }
};

}  // namespace gelenk
