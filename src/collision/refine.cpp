// SPDX-License-Identifier: BSD-3-Clause
// From the points that an iteration has found to the features that touch, and their normal.
#include <Eigen/Geometry>
#include <algorithm>

#include "collision/convex.h"

namespace gelenk {
namespace {

// What a body contributes near the closest points: a vertex, or a circle of a cylinder, and if an edge or the side of a
// cylinder touches, its direction, to which the normal is perpendicular.
struct Feature {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  // vertex, or center of the circle
  const CylinderPose* circle = nullptr;
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  bool has_direction = false;

  // Point farthest in the direction d, and the derivative of this point by d, which is symmetric.
  Eigen::Vector3d support(const Eigen::Vector3d& d, Eigen::Matrix3d& curvature) const {
    if (circle == nullptr) return at;
    const double x = d.dot(circle->x);
    const double y = d.dot(circle->y);
    const double across = std::hypot(x, y);
    if (!(across > 0)) return at;
    const Eigen::Vector3d u = x / across * circle->x + y / across * circle->y;
    const Eigen::Vector3d tangent = x / across * circle->y - y / across * circle->x;
    curvature += circle->radius / across * tangent * tangent.transpose();
    return at + circle->radius * u;
  }
};

struct Features {
  static constexpr int most = 8;
  std::array<Feature, most> all;
  int count = 0;

  void add(const Feature& f) {
    if (count < most) all[static_cast<std::size_t>(count++)] = f;
  }
};

// Features of a body at the points found; n: outward.
Features features_of(const ConvexBody& body, const ClosestPoints& found, Support Difference::* of,
                     const Eigen::Vector3d& n) {
  Features out;
  if (const CylinderPose* cylinder = body.cylinder()) {
    const double along = n.dot(cylinder->axis);
    out.add({.at = cylinder->cap(along < 0 ? 0 : 1), .circle = cylinder});
    // Iterations end so close to the normal that its angle to the side is well below this.
    if (std::abs(along) < 0.05)
      out.add({.at = cylinder->center, .circle = cylinder, .along = cylinder->axis, .has_direction = true});
    return out;
  }
  for (int i = 0; i < found.count; ++i) {
    const Support& p = found.by[static_cast<std::size_t>(i)].*of;
    bool known = false;
    for (int k = 0; k < i; ++k) known = known || (found.by[static_cast<std::size_t>(k)].*of).vertex == p.vertex;
    if (known) continue;
    out.add({.at = p.p});
    for (int k = 0; k < i; ++k) {
      const Eigen::Vector3d edge = p.p - (found.by[static_cast<std::size_t>(k)].*of).p;
      const double length = edge.norm();
      if (length > 0) out.add({.at = p.p, .along = edge / length, .has_direction = true});
    }
  }
  return out;
}

class Refinement {
 public:
  Refinement(const ConvexBody& A, const ConvexBody& B, ClosestPoints& found)
      : A_(A), B_(B), found_(found), start_(found.n), best_(separation(A, B, found.n)) {}

  double best() const { return best_; }

  // Takes a direction if the bodies are separated farther along it: it is then closer to the
  // direction of contact.
  void propose(const Eigen::Vector3d& direction) {
    const double length = direction.norm();
    if (!(length > 0)) return;
    Eigen::Vector3d n = direction / length;
    if (n.dot(start_) < 0) n = -n;
    const double distance = separation(A_, B_, n);
    if (!(distance >= best_)) return;
    best_ = distance;
    found_.n = n;
  }

  // The normal of a pair of features.
  void propose(const Feature& a, const Feature& b) {
    if (a.has_direction && b.has_direction) {
      const Eigen::Vector3d cross = a.along.cross(b.along);
      // Of parallel edges this is only rounding errors.
      if (cross.norm() > 1e-9) return propose(cross);
    }
    const Eigen::Vector3d* along = a.has_direction ? &a.along : b.has_direction ? &b.along : nullptr;
    if (a.circle == nullptr && b.circle == nullptr) {
      const Eigen::Vector3d d = b.at - a.at;
      return propose(along == nullptr ? d : Eigen::Vector3d(d - d.dot(*along) * *along));
    }
    maximize(a, b, along);
  }

 private:
  // Newton's method for the largest separation of two features among all directions, or among those perpendicular to
  // one.
  void maximize(const Feature& a, const Feature& b, const Eigen::Vector3d* along) {
    Eigen::Vector3d n = start_;
    if (along != nullptr) n -= n.dot(*along) * *along;
    if (!(n.norm() > 0.1)) return;
    n.normalize();
    propose(n);
    for (int step = 0; step < 12; ++step) {
      Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();
      const Eigen::Vector3d d = b.support(-n, curvature) - a.support(n, curvature);
      const Eigen::Vector3d t = along != nullptr ? along->cross(n) : n.unitOrthogonal();
      const Eigen::Vector3d u = n.cross(t);
      // Negative Hessian of n . d on the unit sphere.
      const double s = n.dot(d);
      const double tt = t.dot(curvature * t) + s;
      const double tu = t.dot(curvature * u);
      const double uu = u.dot(curvature * u) + s;
      Eigen::Vector3d move;
      if (along != nullptr) {
        if (!(tt > 0)) return;
        move = t.dot(d) / tt * t;
      } else {
        const double determinant = tt * uu - tu * tu;
        if (!(tt > 0 && determinant > 0)) return;
        const double x = t.dot(d);
        const double y = u.dot(d);
        move = (uu * x - tu * y) / determinant * t + (tt * y - tu * x) / determinant * u;
      }
      const double length = move.norm();
      if (!(length > 1e-16)) break;
      if (length > 0.3) move *= 0.3 / length;
      n = (n + move).normalized();
      propose(n);
    }
  }

  const ConvexBody& A_;
  const ConvexBody& B_;
  ClosestPoints& found_;
  Eigen::Vector3d start_;
  double best_;
};

// Normals of flat parts that are nearly perpendicular to n.
template <class Propose>
void flat_normals(const ConvexBody& body, const Eigen::Vector3d& n, const Propose& propose) {
  constexpr double nearly = 0.99;
  if (const CylinderPose* cylinder = body.cylinder()) {
    if (std::abs(n.dot(cylinder->axis)) > nearly) propose(cylinder->axis);
  } else if (const Solid* solid = body.solid()) {
    const Eigen::Vector3d normal = solid->normal(solid->face_toward(n));
    if (normal.dot(n) > nearly) propose(normal);
  }
}

// The part of a body that touches: a point, an edge or line through a point, or something flat.
struct Touching {
  enum class Kind { point, line, flat };
  Kind kind = Kind::flat;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
};

Touching touching(const ConvexBody& body, const ClosestPoints& found, Support Difference::* of,
                  const Eigen::Vector3d& n) {
  Touching out{.p = body.support(n).p};
  if (const CylinderPose* cylinder = body.cylinder()) {
    if (n.cross(cylinder->axis).norm() <= flat_cap) return out;
    out.kind = std::abs(n.dot(cylinder->axis)) <= flat_cap ? Touching::Kind::line : Touching::Kind::point;
    out.along = cylinder->axis;
    return out;
  }
  std::array<const Support*, 3> distinct{};
  std::size_t count = 0;
  for (int i = 0; i < found.count; ++i) {
    const Support& s = found.by[static_cast<std::size_t>(i)].*of;
    bool known = false;
    for (std::size_t k = 0; k < count; ++k) known = known || distinct[k]->vertex == s.vertex;
    if (!known) distinct[count++] = &s;
  }
  if (count == 3) return out;
  out.p = distinct[0]->p;
  out.kind = count == 1 ? Touching::Kind::point : Touching::Kind::line;
  if (count == 2) out.along = (distinct[1]->p - out.p).normalized();
  return out;
}

// The points that touch. A facet of an iteration can be part of a larger flat one, in which the weights mean nothing;
// points and edges are exact.
void set_points(const ConvexBody& A, const ConvexBody& B, ClosestPoints& found) {
  using Kind = Touching::Kind;
  const Touching a = touching(A, found, &Difference::a, found.n);
  const Touching b = touching(B, found, &Difference::b, -found.n);
  const Eigen::Vector3d between = found.distance * found.n;
  const Eigen::Vector3d cross = a.along.cross(b.along);
  if (a.kind == Kind::point) {
    found.a = a.p;
    found.b = a.p + between;
  } else if (b.kind == Kind::point) {
    found.a = b.p - between;
    found.b = b.p;
  } else if (a.kind == Kind::line && b.kind == Kind::line && cross.norm() > 1e-9) {
    const Eigen::Vector3d d = b.p - a.p;
    found.a = a.p + d.dot(b.along.cross(cross)) / cross.squaredNorm() * a.along;
    found.b = found.a + between;
  } else {
    // Anywhere within both flat parts, on their planes.
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (int i = 0; i < found.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      middle += found.weights[k] / 2 * (found.by[k].a.p + found.by[k].b.p);
    }
    found.a = middle + found.n.dot(a.p - middle) * found.n;
    found.b = found.a + between;
  }
}

}  // namespace

void refine(const ConvexBody& A, const ConvexBody& B, ClosestPoints& found) {
  Refinement refinement(A, B, found);
  const Features of_A = features_of(A, found, &Difference::a, found.n);
  const Features of_B = features_of(B, found, &Difference::b, -found.n);
  for (int i = 0; i < of_A.count; ++i)
    for (int k = 0; k < of_B.count; ++k)
      refinement.propose(of_A.all[static_cast<std::size_t>(i)], of_B.all[static_cast<std::size_t>(k)]);
  const Eigen::Vector3d n = found.n;
  const auto propose = [&](const Eigen::Vector3d& normal) { refinement.propose(normal); };
  flat_normals(A, n, propose);
  flat_normals(B, -n, propose);
  for (int i = 0; i < of_A.count; ++i)
    for (int k = 0; k < i; ++k)
      refinement.propose(
          of_A.all[static_cast<std::size_t>(i)].along.cross(of_A.all[static_cast<std::size_t>(k)].along));
  for (int i = 0; i < of_B.count; ++i)
    for (int k = 0; k < i; ++k)
      refinement.propose(
          of_B.all[static_cast<std::size_t>(i)].along.cross(of_B.all[static_cast<std::size_t>(k)].along));
  found.distance = refinement.best();
  set_points(A, B, found);
}

}  // namespace gelenk
