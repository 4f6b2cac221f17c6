// SPDX-License-Identifier: BSD-3-Clause
// What an integrator sees of a mechanism: an ODE on a manifold. y = (q, v).
#pragma once

namespace gelenk {

class OdeSystem {
 public:
  virtual ~OdeSystem() = default;
  virtual int size() const = 0;
  virtual int coordinates() const = 0;  // nq: how many of y are q

  // ydot = f(t, y), size() numbers each. False: not finite here; a smaller step may help.
  virtual bool rhs(double t, const double* y, double* ydot) = 0;
  // Exact df/dy at (t, y), column-major. False: as rhs.
  virtual bool jacobian(double t, const double* y, double* J) = 0;
  // Takes y back onto the constraints by the least change in the mass metric. False: not reached.
  virtual bool project(double t, double* y) = 0;
  // q <- q moved by dv, speeds times time.
  virtual void displace(double* q, const double* dv) const = 0;
  // A step has been accepted; y is on the constraints.
  virtual void accepted(double t, const double* y) = 0;
};

}  // namespace gelenk
