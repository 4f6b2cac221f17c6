// SPDX-License-Identifier: BSD-3-Clause
// The interface to forces along tree joints and cut joints that have modes (element/coordinate_force.h): stops, and
// joint friction, which can keep its coordinate at rest ("lock" it).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gelenk {

class Branching {
 public:
  virtual ~Branching() = default;

  // --- all forces with modes ---
  virtual int count() const = 0;
  // The mode of each force at the current state; count() numbers.
  virtual void sides(int* sides) const = 0;
  // Event indicators at the current state, two per force, whose zeros are the changes of mode, and their rates.
  // Friction is in its held mode, at rest with the forces of the last solve().
  virtual void indicators(double* g, double* gdot) const = 0;
  // Holds the forces in these modes (or JointLoads::of_state, JointLoads::released) in the equations and in
  // differentiate(); `sides` is read at each evaluation. null: they are in the modes of the state, and nothing is
  // locked.
  virtual void hold(const int* sides) = 0;

  // --- friction, by lock: values have the user's signs ---
  virtual int locks() const = 0;
  virtual int force_of(int lock) const = 0;           // its index in all forces with modes
  virtual double sticking_limit(int lock) const = 0;  // element/coordinate_force.h
  virtual double slipping_limit(int lock) const = 0;
  virtual double speed(int lock, const double* v) const = 0;  // of its coordinate; or its acceleration, from vdot
  // The forces in the last solve() that keep coordinates at rest; 0 for others. Where several are redundant, those of
  // least norm.
  virtual const std::vector<double>& holding_forces() const = 0;
  // Whether all held coordinates can be held independently of each other.
  virtual bool is_redundant() const = 0;
  // The accelerations of the coordinates of these locks (rows) per force along them (columns), all released, with the
  // factors of the last solve(). Allocates.
  virtual void compliance(const std::vector<int>& locks, Eigen::MatrixXd& W) = 0;
  // Changes v by the least amount in the mass metric that stops the locked coordinates.
  virtual void stop(double* v) = 0;
};

}  // namespace gelenk
