// SPDX-License-Identifier: BSD-3-Clause
#include "joint/rod.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Shorter rods have no direction to speak of [m].
constexpr double shortest = 1e-6;
// A universal joint lets a rod point everywhere if its axes and the rod are at right angles. Else a cone is left out
// about the axis on the neighbour, of this half angle at most [rad]: so near to gimbal lock no joint is used.
constexpr double blind_cone = 1e-3;
// A rod that passes the axis on the neighbour by less than this share of its way there goes straight across it.
constexpr double straight = 1e-6;

// In the plane the ends are hinges, in space universal and spherical joints.
template <class A, class Function>
decltype(auto) visit_end(const Rod::End& end, Function&& function) {
  using Any = std::conditional_t<A::planar, Revolute, Spherical>;
  using Result = std::invoke_result_t<Function, const Any&>;
  return std::visit(
      [&](const auto& joint) -> Result {
        if constexpr (A::planar == (std::decay_t<decltype(joint)>::planar == PlanarRole::normal)) {
          return function(joint);
        } else {
          __builtin_unreachable();  // make_rod() sees to it
        }
      },
      end);
}

// --- aim(): the coordinates with X_FM(q) d_M = d_F, for unit vectors; rod_in_M: d_M is fixed, else d_F ---

void aim(const Revolute&, bool, const Vector3d& d_M, const Vector3d& d_F, double* q) {
  q[0] = std::atan2(d_M.x() * d_F.y() - d_M.y() * d_F.x(), d_M.x() * d_F.x() + d_M.y() * d_F.y());
}

void aim(const Spherical&, bool, const Vector3d& d_M, const Vector3d& d_F, double* q) {
  quaternion::from_rotation<double>(Eigen::Quaterniond::FromTwoVectors(d_M, d_F).toRotationMatrix(), q);
}

// Between the two turns, Rot_x(phi_a) u = d_F and Rot_b(phi_b) d_M = u: u has the x component of d_F and the b
// component of d_M, which leaves it two z components, h and -h. h vanishes only where the rod lies along the axis on
// the neighbour, so a motion that keeps clear of it keeps to one sign. What goes straight across changes the sign; the
// angle about that axis then stays.
void aim(const Universal& joint, bool rod_in_M, const Vector3d& d_M, const Vector3d& d_F, double* q) {
  const double c = joint.cos_beta;
  const double s = joint.sin_beta;
  const Vector3d b(c, s, 0);
  const Vector3d g(s, -c, 0);  // b x z: x, y, z turned so that y lies along b
  const double u_x = d_F.x();
  const double u_b = b.dot(d_M);
  const double u_y = (u_b - c * u_x) / s;
  const double u_g = (u_x - c * u_b) / s;
  // 1 - u_x^2 - u_y^2, written so that nothing cancels near the axis on the neighbour.
  const double h2 = rod_in_M ? d_F.y() * d_F.y() + d_F.z() * d_F.z() - u_y * u_y
                             : g.dot(d_M) * g.dot(d_M) + d_M.z() * d_M.z() - u_g * u_g;
  const double last_z = rod_in_M ? std::cos(q[1]) * d_M.z() - std::sin(q[1]) * g.dot(d_M)
                                 : std::cos(q[0]) * d_F.z() - std::sin(q[0]) * d_F.y();
  const auto solution = [&](double u_z, double* out) {
    out[0] = std::atan2(d_F.z(), d_F.y()) - std::atan2(u_z, u_y);
    out[1] = std::atan2(u_g, u_z) - std::atan2(g.dot(d_M), d_M.z());
  };
  const double h = std::copysign(std::sqrt(std::max(0.0, h2)), last_z);
  const int about_neighbour = rod_in_M ? 0 : 1;
  double across[2];
  solution(-h, across);
  if (std::abs(std::remainder(across[about_neighbour] - q[about_neighbour], 2 * M_PI)) < straight) {
    std::copy_n(across, 2, q);
  } else {
    solution(h, q);
  }
}

// The same for a joint seen outwards: X(q) e_R = e_P, where R is the rod and P the neighbour.
template <class J>
void aim_outwards(const J& joint, const Vector3d& e_R, const Vector3d& e_P, double* q) {
  aim(joint, true, e_R, e_P, q);
}
template <class J>
void aim_outwards(const Reversed<J>& joint, const Vector3d& e_R, const Vector3d& e_P, double* q) {
  aim(static_cast<const J&>(joint), false, e_P, e_R, q);
}

Vector3d direction(const Spatial::Pose& X) { return X.p.normalized(); }
Vector3d direction(const Planar::Pose& X) { return Vector3d(X.px, X.py, 0).normalized(); }

// The rod's angular velocity, against the neighbour at its first joint, when its far end, d from there, moves with V:
// d x v / |d|^2, and about d what the joint asks for. All in the rod's frame.
template <class A, class J>
typename A::Motion turning(const J& first, const double* q, const Vector3d& d, const typename A::Motion& V) {
  typename A::Motion out;
  if constexpr (A::planar) {
    out.w = (d.x() * V.y - d.y() * V.x) / (d.x() * d.x() + d.y() * d.y());
  } else {
    const Vector3d e = d.normalized();
    Vector3d n;  // what the joint does not turn about
    if constexpr (J::nv == 2) {
      static constexpr double about_a[] = {1, 0};
      static constexpr double about_b[] = {0, 1};
      n = first.template V_FM<A>(q, about_a).w.cross(first.template V_FM<A>(q, about_b).w);
    } else {
      // The shortest way from where e was at first to e: the velocity has nothing along the sum of both.
      n = first.template X_FM<A>(q).R.transpose() * e + e;
    }
    out.w = d.cross(V.v) / d.squaredNorm();
    const double along = n.dot(e);
    if (along != 0) out.w -= n.dot(out.w) / along * e;
  }
  return out;
}

int nq_of(const Rod::End& end) {
  return std::visit([](const auto& joint) { return joint.nq; }, end);
}
int nv_of(const Rod::End& end) {
  return std::visit([](const auto& joint) { return joint.nv; }, end);
}

template <class A>
typename A::Pose pose_of(const Rod::End& end, const double* q) {
  return visit_end<A>(end, [&](const auto& joint) { return joint.template X_FM<A>(q); });
}
template <class A>
typename A::Motion velocity_of(const Rod::End& end, const double* q, const double* v) {
  return visit_end<A>(end, [&](const auto& joint) { return joint.template V_FM<A>(q, v); });
}
template <class A>
typename A::Motion bias_of(const Rod::End& end, const double* q, const double* v) {
  return visit_end<A>(end, [&](const auto& joint) { return joint.template bias<A>(q, v); });
}

}  // namespace

int Rod::first_nq() const { return nq_of(first); }
int Rod::first_nv() const { return nv_of(first); }
int Rod::nq() const { return nq_of(first) + nq_of(second); }
int Rod::nv() const { return nv_of(first) + nv_of(second); }
bool Rod::spins() const { return first_nv() == 3; }

template <class A>
typename A::Pose Rod::rod_pose(const double* q) const {
  return pose_of<A>(first, q);
}

template <class A>
typename A::Motion Rod::rod_velocity(const double* q, const double* v) const {
  return velocity_of<A>(first, q, v);
}

template <class A>
typename A::Pose Rod::X_FM(const double* q) const {
  return pose_of<A>(first, q) * pose_in<A>(X_12) * pose_of<A>(second, q + first_nq());
}

template <class A>
typename A::Motion Rod::V_FM(const double* q, const double* v) const {
  const double* q_2 = q + first_nq();
  const typename A::Motion far = pose_in<A>(X_12).to_child(velocity_of<A>(first, q, v));
  return pose_of<A>(second, q_2).to_child(far) + velocity_of<A>(second, q_2, v + first_nv());
}

template <class A>
typename A::Motion Rod::bias(const double* q, const double* v) const {
  const double* q_2 = q + first_nq();
  const double* v_2 = v + first_nv();
  const auto outwards = [&](const typename A::Motion& V) {
    return pose_of<A>(second, q_2).to_child(pose_in<A>(X_12).to_child(V));
  };
  return outwards(bias_of<A>(first, q, v)) +
         A::cross(outwards(velocity_of<A>(first, q, v)), velocity_of<A>(second, q_2, v_2)) +
         bias_of<A>(second, q_2, v_2);
}

template <class A>
typename A::Force Rod::effort(const double* q, const double* tau) const {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, A::dimension, max_nv>;
  Matrix S(int{A::dimension}, nv());
  for (int k = 0; k < nv(); ++k) {
    double unit[max_nv] = {};
    unit[k] = 1;
    const typename A::Motion V = V_FM<A>(q, unit);
    if constexpr (A::planar) {
      S.col(k) << V.w, V.x, V.y;
    } else {
      S.col(k) << V.w, V.v;
    }
  }
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_nv, max_nv>;
  using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_nv, 1>;
  const Column along = Eigen::Map<const Eigen::VectorXd>(tau, nv());
  const Square gram = S.transpose() * S;
  const Column x = gram.ldlt().solve(along);
  const Eigen::Matrix<double, A::dimension, 1> F = S * x;
  if constexpr (A::planar) {
    return {F[0], F[1], F[2]};
  } else {
    return {F.template head<3>(), F.template tail<3>()};
  }
}

template <class A>
void Rod::speeds(const double* q, const typename A::Motion& V, double* v) const {
  const double* q_2 = q + first_nq();
  const typename A::Pose X_2 = pose_of<A>(second, q_2);
  const typename A::Pose on_rod = pose_in<A>(X_12);
  typename A::Pose turn = on_rod;
  if constexpr (A::planar) {
    turn.px = turn.py = 0;
  } else {
    turn.p.setZero();
  }
  const typename A::Motion far = X_2.to_parent(V);  // of M at the second joint, in the rod's axes there
  visit_end<A>(first, [&](const auto& joint) {
    const typename A::Motion of_rod = turning<A>(joint, q, X_12.p, turn.to_parent(far));
    joint.template speeds<A>(q, of_rod, v);
    const typename A::Motion rest = X_2.to_child(far - on_rod.to_child(of_rod));
    visit_end<A>(second, [&](const auto& other) { other.template speeds<A>(q_2, rest, v + joint.nv); });
  });
}

template <class A>
void Rod::coordinates(const typename A::Pose& X_FM, double* q) const {
  visit_end<A>(first, [&](const auto& joint) { aim_outwards(joint, X_12.p.normalized(), direction(X_FM), q); });
  const typename A::Pose X_2 = (pose_of<A>(first, q) * pose_in<A>(X_12)).inverse() * X_FM;
  visit_end<A>(second, [&](const auto& joint) { joint.template coordinates<A>(X_2, q + first_nq()); });
}

#define GELENK_INSTANTIATE(A)                                                   \
  template A::Pose Rod::rod_pose<A>(const double*) const;                       \
  template A::Motion Rod::rod_velocity<A>(const double*, const double*) const;  \
  template A::Pose Rod::X_FM<A>(const double*) const;                           \
  template A::Motion Rod::V_FM<A>(const double*, const double*) const;          \
  template A::Motion Rod::bias<A>(const double*, const double*) const;          \
  template A::Force Rod::effort<A>(const double*, const double*) const;         \
  template void Rod::speeds<A>(const double*, const A::Motion&, double*) const; \
  template void Rod::coordinates<A>(const A::Pose&, double*) const;
GELENK_INSTANTIATE(Planar)
GELENK_INSTANTIATE(Spatial)
#undef GELENK_INSTANTIATE

namespace {

// Half angle of the cone that a rod along e cannot reach [rad, small]; reversed: F lies on the rod.
double unreached(const Revolute&, bool, const Vector3d&) { return 0; }
double unreached(const Spherical&, bool, const Vector3d&) { return 0; }
double unreached(const Universal& joint, bool reversed, const Vector3d& e) {
  const double on_rod = reversed ? e.x() : joint.cos_beta * e.x() + joint.sin_beta * e.y();
  return std::abs(joint.cos_beta) + std::abs(on_rod);
}

// The joint as an end of a rod that reaches every direction; at_second: as the end that need not hold it.
std::optional<Rod::End> end_of(const AnyJoint& any, bool reversed, bool planar, const Vector3d& e, bool at_second) {
  return std::visit(
      [&](const auto& joint) -> std::optional<Rod::End> {
        using J = std::decay_t<decltype(joint)>;
        constexpr bool hinge = std::is_same_v<J, Revolute>;
        constexpr bool universal = std::is_same_v<J, Universal>;
        if constexpr (hinge || universal || std::is_same_v<J, Spherical>) {
          if (planar != hinge || (universal && at_second) || unreached(joint, reversed, e) > blind_cone) return {};
          if (reversed) return Reversed<J>{joint};
          return joint;
        } else {
          return {};
        }
      },
      any);
}

}  // namespace

std::optional<Rod> make_rod(const AnyJoint& first, bool first_reversed, const AnyJoint& second, bool second_reversed,
                            const Pose3& X_12, bool planar) {
  Rod rod;
  rod.X_12 = X_12;
  if (planar) rod.X_12.p.z() = 0;
  rod.length = rod.X_12.p.norm();
  if (rod.length < shortest) return {};
  const Vector3d e = rod.X_12.p / rod.length;
  const auto at_first = end_of(first, first_reversed, planar, e, false);
  const auto at_second = end_of(second, second_reversed, planar, e, true);
  if (!at_first || !at_second) return {};
  rod.first = *at_first;
  rod.second = *at_second;
  return rod;
}

CutJoint cut_joint(const AnyJoint& joint) {
  return std::visit([](const auto& j) { return CutJoint(j); }, joint);
}

}  // namespace gelenk
