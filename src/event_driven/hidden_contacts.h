// SPDX-License-Identifier: BSD-3-Clause
// Shapes that touch and separate within a step, of which the indicators at its ends show nothing. For each pair that is
// apart at both ends, gaps g0 and g1, a step of length h is safe if
//
//   g0 + g1 > h V,   or   sqrt(g0) + sqrt(g1) >= h sqrt(A / 2):
//
// with the bound V of the speed of all points of one shape, seen from the other one, the gap cannot have closed and
// opened again; nor with the bound A of its second derivative: g >= (1 - s) g0 + s g1 - h^2 A s (1 - s) / 2, s from 0
// to
// 1. Sharp features have none, as the nearest ones change. But two convex solids are apart while a plane fixed to one
// of them separates them, and the distance of each corner of the other one from it does have such a bound. Planes
// normal to the gaps at the ends are tried. All bounds are estimated from the motion at the ends. A step that is not
// safe is looked into: positions between its ends are interpolated (cubic Hermite), and it is halved until the parts
// are safe or show a penetration. Where the smallest parts are not safe, the step is made up to there, which makes them
// smaller.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "dynamics/dynamics.h"
#include "event_driven/contact_equations.h"

namespace gelenk {

class HiddenContacts {
 public:
  // All must outlive it.
  HiddenContacts(const Mechanism& mechanism, Dynamics& dynamics, ContactEquations& contact_equations);

  // Call where a step begins, after ContactCandidates::read_motion() there.
  void begin();
  // The earliest time found at which something touches within a step from (t0, y0), the state at begin(), to (t1, y1)
  // [s]; infinite: nothing does. What remains closed, and sharp features of pairs of which others are closed, are not
  // looked at. `dynamics` is left at the position and velocity of y1.
  double find(double t0, const double* y0, double t1, const double* y1);

 private:
  static constexpr int most_halvings = 10;
  // How two shapes are apart.
  struct Gap {
    double size = 0;    // m; infinite: not looked at
    Pose3 X;            // with sharp features: of the tip's link in the core's
    Eigen::Vector3d n;  // with sharp features: normal of the gap, from the core to the tip, in the core's link
  };
  // Bounds of the motion of one shape of a pair as seen from the other one within a step.
  struct Bounds {
    double speed = 0;         // V [m/s]
    double acceleration = 0;  // A [m/s2], of the points of the shape
  };
  struct Pair {
    int core_link = 0, tip_link = 0;
    Eigen::Vector3d core_center, tip_center;  // origins of the frames of the shapes in their links [m]
    bool tip_is_smaller = true;
    bool is_apart = false;  // it has no gap: friction of a joint
    double curvature = 0;   // 1/m, of the surfaces together; 0: that of planes
    // Of a plane, in its link, of a swing times what makes distances angles; zero: otherwise.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    std::vector<Tip> core, tip;                         // with sharp features: the corners, in the links of the shapes
    Gap gaps[2];                                        // at the ends
    ContactCandidates::Approach core_at[2], tip_at[2];  // at the ends; of shapes without sharp features the smaller one
    Bounds core_bounds, tip_bounds;                     // the same
    double error_bound = 0;                             // m: of the interpolated gap

    bool is_sharp() const { return !tip.empty(); }
    // Whether the motion of this shape is looked at: that of the smaller one, with sharp features of both.
    bool moves_tip() const { return is_sharp() || tip_is_smaller; }
    bool moves_core() const { return is_sharp() || !tip_is_smaller; }
  };
  // Gaps at a time within the step.
  struct Sample {
    double s = 0;           // fraction of the step
    std::vector<Gap> gaps;  // by pair
  };

  void gap(int pair, Gap& out) const;
  void read(int pair, int end);
  Bounds bound(const Pair& pair, const ContactCandidates::Approach& a, const ContactCandidates::Approach& b) const;
  bool is_safe(const Pair& pair, const Gap& a, const Gap& b, double h) const;
  static bool stays_apart(const Pair& pair, const Gap& at, const Gap& a, const Gap& b, double h);
  bool is_safe(const Sample& a, const Sample& b) const;
  void look_at(double s, Sample& out);
  bool separates(const Sample& a, const Sample& b) const;
  double search(const Sample& a, const Sample& b, int halvings);
  bool may_touch(const Sample& a, const Sample& at, const Sample& b) const;

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  ContactEquations& contact_equations_;
  std::vector<Pair> pairs_;
  std::vector<int> unsafe_;  // pairs of the present step
  Sample first_, last_;
  std::vector<Sample> samples_;  // by number of halvings
  int samples_left_ = 0;
  // The motion of the coordinates in the step.
  double h_ = 0;  // s
  const double* q0_ = nullptr;
  const double* q1_ = nullptr;
  std::vector<double> qdot0_, qdot1_, q_;
};

}  // namespace gelenk
