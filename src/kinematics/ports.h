// SPDX-License-Identifier: BSD-3-Clause
// The ports of forces on links, in the workspace of the kernels.
#pragma once

#include "kinematics/kernels.h"
#include "kinematics/loads.h"

namespace gelenk::kernels::inline detail {

template <class T>
Vector3<T> cast(const Eigen::Vector3d& a) {
  return {T(a.x()), T(a.y()), T(a.z())};
}

template <class T>
Vector3<T> point(const typename SpatialAlgebra<T>::Pose& X, const Attachment& at) {
  return X.point(cast<T>(at.p));
}
template <class T>
Vector3<T> point(const typename PlanarAlgebra<T>::Pose& X, const Attachment& at) {
  return {X.px + X.c * T(at.p.x()) - X.s * T(at.p.y()), X.py + X.s * T(at.p.x()) + X.c * T(at.p.y()),
          T(at.height + at.p.z())};
}

template <class T>
Vector3<T> to_root(const typename SpatialAlgebra<T>::Pose& X, const Vector3<T>& a_L) {
  return X.R * a_L;
}
template <class T>
Vector3<T> to_root(const typename PlanarAlgebra<T>::Pose& X, const Vector3<T>& a_L) {
  return {X.c * a_L.x() - X.s * a_L.y(), X.s * a_L.x() + X.c * a_L.y(), a_L.z()};
}
template <class T>
Vector3<T> to_link(const typename SpatialAlgebra<T>::Pose& X, const Vector3<T>& a_0) {
  return X.R.transpose() * a_0;
}
template <class T>
Vector3<T> to_link(const typename PlanarAlgebra<T>::Pose& X, const Vector3<T>& a_0) {
  return {X.c * a_0.x() + X.s * a_0.y(), X.c * a_0.y() - X.s * a_0.x(), a_0.z()};
}

template <class T>
Vector3<T> point_velocity(const typename SpatialAlgebra<T>::Motion& V, const Attachment& at) {
  return V.v + V.w.cross(cast<T>(at.p));
}
template <class T>
Vector3<T> point_velocity(const typename PlanarAlgebra<T>::Motion& V, const Attachment& at) {
  return {V.x - V.w * T(at.p.y()), V.y + V.w * T(at.p.x()), T(0)};
}

// Adds the force f and the torque n at a point of a link to F; all in the link's axes, F about its origin.
template <class T>
void apply(const Attachment& at, const Vector3<T>& f, const Vector3<T>& n, typename SpatialAlgebra<T>::Force& F) {
  F.n += n + cast<T>(at.p).cross(f);
  F.f += f;
}
template <class T>
void apply(const Attachment& at, const Vector3<T>& f, const Vector3<T>& n, typename PlanarAlgebra<T>::Force& F) {
  F.n += n.z() + T(at.p.x()) * f.y() - T(at.p.y()) * f.x();
  F.x += f.x();
  F.y += f.y();
}

// The same without a torque.
template <class T>
void apply(const Attachment& at, const Vector3<T>& f, typename SpatialAlgebra<T>::Force& F) {
  F.n += cast<T>(at.p).cross(f);
  F.f += f;
}
template <class T>
void apply(const Attachment& at, const Vector3<T>& f, typename PlanarAlgebra<T>::Force& F) {
  F.n += T(at.p.x()) * f.y() - T(at.p.y()) * f.x();
  F.x += f.x();
  F.y += f.y();
}

template <class T>
Vector3<T> angular_velocity(const typename SpatialAlgebra<T>::Motion& V) {
  return V.w;
}
template <class T>
Vector3<T> angular_velocity(const typename PlanarAlgebra<T>::Motion& V) {
  return {T(0), T(0), V.w};
}

// A force's port (element/forces/force.h), in the root's axes. W: Workspace<A>, or const.
template <class A, class W>
class PortOn {
 public:
  using T = typename A::Scalar;

  PortOn() = default;
  PortOn(const Attachment& at, const Loads& loads, W& ws) : at_(&at), loads_(&loads), ws_(&ws) {}

  Vector3<T> p() const { return point<T>(X(), *at_); }
  Vector3<T> v() const { return to_root<T>(X(), point_velocity<T>(ws_->V[at_->link], *at_)); }
  Vector3<T> w() const { return to_root<T>(X(), angular_velocity<T>(ws_->V[at_->link])); }
  Vector3<T> turned(const Vector3<T>& x) const { return to_root<T>(X(), Vector3<T>(at_->R.cast<T>() * x)); }
  Vector3<T> own(const Vector3<T>& x) const { return at_->R.transpose().cast<T>() * to_link<T>(X(), x); }
  Vector3<T> from_world(const Vector3<T>& x) const { return loads_->R_0W.cast<T>() * x; }

  Vector3<T> to_world(const Vector3<T>& x) const { return loads_->R_0W.transpose().cast<T>() * x; }
  Vector3<T> world_position() const { return to_world(p()) + loads_->p_W0.cast<T>(); }

  void push(const Vector3<T>& f) { apply<T>(*at_, to_link<T>(X(), f), F()); }
  void push(const Vector3<T>& f, const Vector3<T>& n) { apply<T>(*at_, to_link<T>(X(), f), to_link<T>(X(), n), F()); }
  void push_along(const Vector3<T>& f, const Vector3<T>& n) {
    const Matrix3<T> R = at_->R.cast<T>();
    apply<T>(*at_, Vector3<T>(R * f), Vector3<T>(R * n), F());
  }

 private:
  const typename A::Pose& X() const { return ws_->X_0L[at_->link]; }
  typename A::Force& F() { return ws_->F_ext[at_->link]; }

  const Attachment* at_ = nullptr;
  const Loads* loads_ = nullptr;
  W* ws_ = nullptr;
};

}  // namespace gelenk::kernels::inline detail
