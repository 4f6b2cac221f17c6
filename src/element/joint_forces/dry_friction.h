// SPDX-License-Identifier: BSD-3-Clause
// What laws of dry friction have in common, which are set-valued: at rest, in the mode 0, the equations of motion
// determine the force (dynamics/locked_coordinates.h); 1 and -1 are motion with positive and negative speed. The
// friction of a coordinate is the sum of its laws, which share one mode. A law derives from DryFriction<itself> and has
//
//   sticking_limit(q, u)        largest size of the force that keeps the coordinate at rest [N m, N]
//   friction(side, q, v, u)     size of the force in motion in this mode, smooth where a step continues beyond its end
//   slipping_limit(q, u)        the size in a motion that begins; optional
//   depends_on_position         if it does; otherwise q may be NaN in these functions
#pragma once

#include <array>
#include <cmath>

#include "element/joint_forces/coordinate_force.h"

namespace gelenk {

template <class Law>
struct DryFriction {
  static constexpr bool depends_on_position = false;

  static constexpr SignalGroup outputs[] = {
      {"{effort}", 0, "{f}", "dry friction on {joint}.{coordinate}, in its direction"},
      {"mode", 0, "1",
       "1, -1: {joint}.{coordinate} slips in its positive, negative direction; 0: friction or a limit keeps it at "
       "rest"}};

  double slipping_limit(double q, const double* u) const { return law().friction(1, q, 0.0, u); }

  template <class T>
  T held(int side, const T& q, const T& v, const T* u) const {
    if (side != 1 && side != -1) return T(0);
    return T(-side) * law().friction(side, q, v, u);
  }
  template <class T>
  int side(const T&, const T& v) const {
    return v > T(0) ? 1 : v < T(0) ? -1 : 0;
  }
  template <class T>
  T effort(const T& q, const T& v, const T* u) const {
    return held(side(q, v), q, v, u);
  }
  // The event indicators in a mode: of motion with positive and with negative speed. a: the acceleration. x: the force
  // that keeps the coordinate at rest, in mode 0. limits: how large it may be against motion in either direction.
  void indicators(int side, double v, double a, double x, const std::array<double, 2>& limits, double* g,
                  double* gdot) const {
    g[0] = side > 0 ? v : side < 0 ? -1 : -x - limits[0];
    g[1] = side < 0 ? -v : side > 0 ? -1 : x - limits[1];
    gdot[0] = side > 0 ? a : NAN;
    gdot[1] = side < 0 ? -a : NAN;
  }
  // For each indicator, the texts of the events at which this motion ends at rest, and at which it begins.
  static constexpr std::string_view events[2][2] = {
      {"{joint}.{coordinate} sticks", "{joint}.{coordinate} slips in its positive direction"},
      {"{joint}.{coordinate} sticks", "{joint}.{coordinate} slips in its negative direction"}};

 private:
  const Law& law() const { return static_cast<const Law&>(*this); }
};

}  // namespace gelenk
