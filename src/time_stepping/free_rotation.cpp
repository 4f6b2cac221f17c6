// SPDX-License-Identifier: BSD-3-Clause
#include "time_stepping/free_rotation.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "joint/registry.h"

namespace gelenk {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
// Newton's method doubles the digits: from the angle of a step of 1 rad, rounding is reached in five iterations.
constexpr int most_newton_steps = 12;

using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;

Vector three(const double* from) { return {from[0], from[1], from[2]}; }
void copy(const Vector& from, double* to) { std::copy_n(from.data(), 3, to); }

// Whether the last three velocities of a joint are the angular velocity of M in M, and the others, if any,
// translations along three axes of F: its orientation is a quaternion, and it is not reversed.
template <class Joint>
constexpr bool turns_in_M =
    Joint::nq == Joint::nv + 1 && (Joint::constant_S ? Joint::nv == 3 : Joint::shifts_in_F == 3);

// Links that no constraint equation and no other joint moves.
std::vector<bool> lone_links(const Mechanism& mechanism) {
  std::vector<bool> out(mechanism.links.size(), true);
  const auto exclude = [&](int link) { out[static_cast<std::size_t>(link)] = false; };
  for (const Link& link : mechanism.links) {
    if (link.parent >= 0) exclude(link.parent);
  }
  for (std::size_t i = 1; i < out.size(); ++i) {
    if (mechanism.links[i].parent != 0) out[i] = false;
  }
  for (const Cut& cut : mechanism.cuts) {
    exclude(cut.link_a);
    exclude(cut.link_b);
  }
  for (const CoordinateRow& row : mechanism.coordinate_rows) {
    for (const CoordinateRow::Term& term : row.terms) {
      for (std::size_t i = 1; i < out.size(); ++i) {
        const Link& link = mechanism.links[i];
        if (term.v >= link.iv && term.v < link.iv + link.nv) out[i] = false;
      }
    }
  }
  return out;
}

// tan(a) / a and its derivative with respect to a, over a.
struct TangentRatio {
  explicit TangentRatio(double a) {
    if (a < 1e-4) return;  // the errors are those of the next terms of the series, a^2/3 and 8 a^2/15
    value = std::tan(a) / a;
    derivative = value * value - (value - 1) / (a * a);
  }
  double value = 1;
  double derivative = 2.0 / 3;
};

// The displacement (1 + d/2 is the quaternion, up to its length) of a rotation.
Vector displacement(const Eigen::Quaterniond& rotation) { return 2 / rotation.w() * rotation.vec(); }

Eigen::Quaterniond rotation_by(const Vector& angle) {
  const double a = angle.norm() / 2;
  const double sine_ratio = a > 0 ? std::sin(a) / a : 1.0;
  Eigen::Quaterniond out;
  out.w() = std::cos(a);
  out.vec() = sine_ratio / 2 * angle;
  return out;
}

}  // namespace

FreeRotation::FreeRotation(const Mechanism& mechanism) : is_touched_(mechanism.links.size()) {
  const std::vector<bool> lone = lone_links(mechanism);
  for (std::size_t i = 1; i < lone.size(); ++i) {
    const Link& link = mechanism.links[i];
    const bool turns = std::visit([](const auto& j) { return turns_in_M<std::decay_t<decltype(j)>>; }, *link.joint);
    if (!lone[i] || !turns) continue;
    Body body;
    body.link = static_cast<int>(i);
    body.turns = link.iv + link.nv - 3;
    body.J = link.G.I;
    if (link.nv > 3) {
      body.shifts = link.iv;
      body.com = link.G.h / link.G.m;
      body.is_offset = !body.com.isZero(0);
      const Vector& c = body.com;
      body.J -= link.G.m * (c.squaredNorm() * Matrix::Identity() - c * c.transpose());
    }
    body.inverse = body.J.inverse();
    body.R_F0 = link.X_PJ.R.transpose();
    const double mean = body.J.trace() / 3;
    // Beyond rounding of the parallel axis theorem.
    const double rounding = 8 * epsilon * link.G.I.trace();
    body.has_gyroscopic = (body.J - mean * Matrix::Identity()).cwiseAbs().maxCoeff() > rounding;
    bodies_.push_back(body);
  }
}

void FreeRotation::set_first_half(double h, const double* v0, double* dq) {
  std::fill(is_touched_.begin(), is_touched_.end(), false);
  for (const Body& body : bodies_) {
    const Vector angle = h / 2 * three(v0 + body.turns);
    copy(displacement(rotation_by(angle)), dq + body.turns);
  }
}

FreeRotation::Turns FreeRotation::turns_of(const Body& body, double h, const Vector& w0, const Vector& w1) const {
  const Eigen::Quaterniond to_start = rotation_by(h / 2 * w0).conjugate();
  const bool conserves = body.has_gyroscopic && !is_touched(body);
  return {to_start, conserves ? to_start * rotation_by(h / 2 * (w0 + w1)) : rotation_by(h / 2 * w1)};
}

void FreeRotation::set_rest(double h, const double* v0, const double* v1, const Readings<double>& readings,
                            double* dq) const {
  for (const Body& body : bodies_) {
    const Vector w0 = three(v0 + body.turns), w1 = three(v1 + body.turns);
    const Turns turns = turns_of(body, h, w0, w1);
    copy(displacement(turns.to_end), dq + body.turns);
    if (!body.is_offset || is_touched(body)) continue;
    // The center of mass moves with its mean velocity.
    const Vector& c = body.com;
    const Vector turned =
        h / 2 * (turns.to_start * w0.cross(c) + turns.to_end * w1.cross(c)) - (turns.to_end * c - turns.to_start * c);
    const Vector shift = body.R_FM(readings) * turned;
    for (int i = 0; i < 3; ++i) dq[body.shifts + i] += shift[i];
  }
}

// The mean angular velocity wm that solves 2 J (wm - w0) + h k wm x J wm = other, by Newton's method from wm. Returns
// false if the body turns by more than `most` [rad].
bool FreeRotation::Body::solve(double h, const Vector& w0, const Vector& other, double most, Vector& wm) const {
  double last = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < most_newton_steps; ++iteration) {
    const double angle = h * wm.norm();
    if (!(angle <= most)) return false;
    const TangentRatio k(angle / 2);
    const Vector Jw = J * wm, cross = wm.cross(Jw);
    const Vector r = 2 * (J * (wm - w0)) - other + h * k.value * cross;
    const Matrix K = 2 * J + h * k.value * (cross_matrix<double>(wm) * J - cross_matrix<double>(Jw)) +
                     h * h * h / 4 * k.derivative * cross * wm.transpose();
    const Vector step = K.inverse() * r;
    const double size = step.norm();
    if (size >= last && iteration > 2) return true;  // rounding
    wm -= step;
    if (size <= 2 * epsilon * wm.norm()) return true;
    last = size;
  }
  return false;
}

bool FreeRotation::balance(double h, const double* v0, const double* vm, double most, const Readings<double>& readings,
                           double* vdot) const {
  for (const Body& body : bodies_) {
    if (is_touched(body) || !(body.has_gyroscopic || body.is_offset)) continue;
    const Matrix& J = body.J;
    const Vector w0 = three(v0 + body.turns), at = three(vm + body.turns), a = three(vdot + body.turns);
    Vector wm = at, a_new = a;
    if (body.has_gyroscopic) {
      const Vector before = at.cross(J * at);
      if (!body.solve(h, w0, h * (J * a + before), most, wm)) return false;
      a_new += body.inverse * (before - TangentRatio(h * wm.norm() / 2).value * wm.cross(J * wm));
      copy(a_new, vdot + body.turns);
    }
    if (!body.is_offset) continue;
    // The origin moves such that the center of mass has the acceleration that it had.
    const Vector& c = body.com;
    const Vector w1 = w0 + h * a_new;
    const Turns turns = turns_of(body, h, w0, w1);
    const Vector turned = turns.to_end * w1.cross(c) - turns.to_start * w0.cross(c);
    const Vector shift = body.R_FM(readings) * (a.cross(c) + at.cross(at.cross(c)) - turned / h);
    for (int i = 0; i < 3; ++i) vdot[body.shifts + i] += shift[i];
  }
  return true;
}

}  // namespace gelenk
