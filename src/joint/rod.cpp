// SPDX-License-Identifier: BSD-3-Clause
#include "joint/rod.h"

#include <cmath>

#include "joint/rod_impl.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

// Minimum length of a rod [m]; the direction of a shorter one is not well defined.
constexpr double min_length = 1e-6;
// With a universal joint a rod reaches all directions if its two axes, and the axis on the rod and the rod, are at
// right angles. Otherwise it does not reach a cone about the axis on the neighbor. Maximum half angle of this cone
// [rad]; no joint is used so close to gimbal lock.
constexpr double max_unreachable_angle = 1e-3;

}  // namespace

int Rod::first_nq() const { return rods::nq_of(first); }
int Rod::first_nv() const { return rods::nv_of(first); }
int Rod::nq() const { return rods::nq_of(first) + rods::nq_of(second); }
int Rod::nv() const { return rods::nv_of(first) + rods::nv_of(second); }
bool Rod::has_free_spin() const { return first_nv() == 3; }

GELENK_INSTANTIATE(Planar)
GELENK_INSTANTIATE(Spatial)

namespace {

// Returns the half angle [rad], if small, of the cone that a rod along e cannot reach. reversed: F is on the rod.
double unreachable_angle(const Revolute&, bool, const Vector3d&) { return 0; }
double unreachable_angle(const Spherical&, bool, const Vector3d&) { return 0; }
double unreachable_angle(const Universal& joint, bool reversed, const Vector3d& e) {
  const double on_rod = reversed ? e.x() : joint.cos_beta * e.x() + joint.sin_beta * e.y();
  return std::abs(joint.cos_beta) + std::abs(on_rod);
}

// Returns the joint as an end of a rod along e, or nothing if the rod could not reach all directions. at_second: as the
// second end, which must not determine the rod's rotation about its own axis.
std::optional<Rod::End> end_of(const AnyJoint& any, bool reversed, bool planar, const Vector3d& e, bool at_second) {
  return std::visit(
      [&](const auto& joint) -> std::optional<Rod::End> {
        using J = std::decay_t<decltype(joint)>;
        constexpr bool hinge = std::is_same_v<J, Revolute>;
        constexpr bool universal = std::is_same_v<J, Universal>;
        if constexpr (hinge || universal || std::is_same_v<J, Spherical>) {
          if (planar != hinge || (universal && at_second) ||
              unreachable_angle(joint, reversed, e) > max_unreachable_angle) {
            return {};
          }
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
  Pose3 X = X_12;
  if (planar) X.p.z() = 0;
  const double length = X.p.norm();
  if (length < min_length) return {};
  const Vector3d e = X.p / length;
  const auto at_first = end_of(first, first_reversed, planar, e, false);
  const auto at_second = end_of(second, second_reversed, planar, e, true);
  if (!at_first || !at_second) return {};
  return Rod{.first = *at_first, .second = *at_second, .X_12 = X, .length = length};
}

}  // namespace gelenk
