// SPDX-License-Identifier: BSD-3-Clause
// Points whose friction has a limit that is given: of joints along several velocities together.
#pragma once

#include "complementarity/cone.h"
#include "contact_geometry/contact_finder.h"
#include "element/contacts/contact.h"

namespace gelenk {

// The axes of the rows of a point in columns: of a contact the normal first, of friction those of its components.
inline Eigen::Matrix3d axes_of(const NearPoint& point) {
  Eigen::Matrix3d axes = contact_axes(point.normal);
  if (point.given == 2) axes.col(0).swap(axes.col(2));
  return axes;
}

// Its cone in a step of length h, with static friction.
inline Cone cone_of(const NearPoint& point, const ContactLaw& law, int first, double h) {
  if (point.given > 0) return Cone::ball(first, point.given, h * law.static_friction * law.given_normal);
  return Cone::contact(first, law.static_friction, law.spinning, law.rolling);
}
inline void set_coefficient(Cone& cone, const ContactLaw& law, double h, double coefficient) {
  (cone.is_ball ? cone.radius : cone.friction) = cone.is_ball ? h * coefficient * law.given_normal : coefficient;
}
inline bool has_coefficient(const Cone& cone, const ContactLaw& law, double h, double coefficient) {
  return cone.is_ball ? cone.radius == h * coefficient * law.given_normal : cone.friction == coefficient;
}

// The vector with these components along the axes of a ball, and back.
inline Eigen::Vector3d in_space(const Cone& ball, const Eigen::Matrix3d& axes, const double* x) {
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  for (int k = 0; k < ball.tangential; ++k) out += axes.col(k) * x[k];
  return out;
}
inline void write_components(const Cone& ball, const Eigen::Matrix3d& axes, const Eigen::Vector3d& of, double* x) {
  for (int k = 0; k < ball.tangential; ++k) x[k] = axes.col(k).dot(of);
}

}  // namespace gelenk
