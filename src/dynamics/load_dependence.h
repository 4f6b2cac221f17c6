// SPDX-License-Identifier: BSD-3-Clause
// Friction that depends on forces of the mechanism, which depend on it, as those see it who decide on modes.
#pragma once

namespace gelenk {

class LoadDependence {
 public:
  virtual ~LoadDependence() = default;

  virtual bool empty() const = 0;
  // Whether the friction with this index depends on loads.
  virtual bool acts_on(int force) const = 0;
  // Keeps this friction as it was at the last solve(), in motion and at rest: the equations of motion are linear then.
  virtual void freeze(bool on) = 0;
  // The loads along a line, such as those of gears, whose sign matters: friction has a kink where it changes. Those of
  // the last solve(), by which event indicators they are; while signs are held, beyond zero by rounding.
  virtual int signed_count() const = 0;
  virtual void indicators(double* g) const = 0;
  // Holds their signs, also beyond zero; null: they are those of the loads.
  virtual void hold_signs(const bool* positive) = 0;
  // Of the last solve(): the index, among all forces with modes, of a friction that is not unique, or does not exist,
  // because it depends on loads too much; -1: none.
  virtual int undetermined() const = 0;
  // Says so of the last solve(), as where forces that depend on friction have not been found.
  virtual void set_undetermined() = 0;
  // Of the last solve(): the index, among all forces with modes, of the only friction with loads that slips, if it is
  // that of a mesh which grows faster with its load than the motion can yield, so that it stops at once; -1: none.
  virtual int seized() const = 0;
  // Of the last solve(): the index of a friction in motion whose load along a line is zero, so that the slightest
  // change gives it either sign, and derivatives do not exist; -1: none.
  virtual int unloaded() const = 0;
  // The index of a friction of which these multipliers alone, of size 1, change the load; -1: none.
  virtual int affected_by(const double* multipliers) = 0;
};

// Keeps friction as it was at the last solve() during its lifetime.
class FrozenLoads {
 public:
  explicit FrozenLoads(LoadDependence& loads) : loads_(loads) { loads_.freeze(true); }
  ~FrozenLoads() { loads_.freeze(false); }
  FrozenLoads(const FrozenLoads&) = delete;
  FrozenLoads& operator=(const FrozenLoads&) = delete;

 private:
  LoadDependence& loads_;
};

}  // namespace gelenk
