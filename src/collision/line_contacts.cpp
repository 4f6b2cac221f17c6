// SPDX-License-Identifier: BSD-3-Clause
#include "collision/line_contacts.h"

#include "collision/face_contacts.h"

namespace gelenk {
namespace {

// Features that touch at smaller angles to each other have no normal of their own.
constexpr double least_sine = 1e-6;
// Lines side by side: the sine of the angle up to which ends of one can rest on the other.
constexpr double side_by_side = 0.2;

Eigen::Vector3d aligned(const Eigen::Vector3d& n, const Eigen::Vector3d& with) {
  return n.dot(with) < 0 ? Eigen::Vector3d(-n) : n;
}

}  // namespace

void PointSink::add(const Eigen::Vector3d& x, bool on_first, const Eigen::Vector3d& n, double gap, int first,
                    int second) const {
  const Eigen::Vector3d middle = on_first ? Eigen::Vector3d(x + gap / 2 * n) : Eigen::Vector3d(x - gap / 2 * n);
  const int feature = exchanged_ ? pair_feature(second, first, count_B_) : pair_feature(first, second, count_B_);
  out_.add({middle, exchanged_ ? Eigen::Vector3d(-n) : n, gap, feature});
}

Line edge_line(const Solid& solid, int face, std::size_t place) {
  const std::span<const int> loop = solid.loop(face);
  const int from = loop[place];
  const int to = loop[(place + 1) % loop.size()];
  const Eigen::Vector3d a = solid.vertex(from);
  const Eigen::Vector3d b = solid.vertex(to);
  const double length = (b - a).norm();
  Line out{.center = (a + b) / 2, .along = (b - a) / length, .half = length / 2};
  out.ends[0] = from;
  out.ends[1] = to;
  out.middle = solid.edge_feature(solid.edge_at(face, place));
  return out;
}

Line side_line(const CylinderPose& cylinder) {
  Line out{.center = cylinder.center, .along = cylinder.axis, .half = cylinder.half, .radius = cylinder.radius};
  out.ends[0] = cylinder_feature::rim(0);
  out.ends[1] = cylinder_feature::rim(1);
  out.middle = cylinder_feature::side;
  return out;
}

void line_on_solid(const Line& line, const Solid& solid, const ClosestNormal& at, const PointSink& out) {
  const int face = solid.face_toward(-at.n);
  const Eigen::Vector3d normal = solid.normal(face);
  if (std::abs(line.along.dot(at.n)) > side_by_side) return;
  if (-normal.dot(at.n) > facing) {
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector3d end = line.end(i);
      const double gap = solid.height(face, normal, end) - line.radius;
      if (gap < at.least || !solid.covers(face, normal, end, line_slack * solid.size())) continue;
      out.add(end - line.radius * normal, true, -normal, gap, line.ends[i], solid.face_feature(face));
    }
  }
  for (std::size_t i = 0; i < solid.loop(face).size(); ++i) line_across_line(line, edge_line(solid, face, i), at, out);
}

void line_across_line(const Line& line, const Line& other, const ClosestNormal& at, const PointSink& out) {
  const Eigen::Vector3d cross = line.along.cross(other.along);
  const double sine = cross.norm();
  if (!(sine > least_sine)) return;
  const Eigen::Vector3d n = aligned(cross / sine, at.n);
  if (n.dot(at.n) < facing) return;
  const Eigen::Vector3d d = other.center - line.center;
  const double s = d.dot(other.along.cross(cross)) / (sine * sine);
  const double t = d.dot(line.along.cross(cross)) / (sine * sine);
  if (!line.has(s, -line_slack) || !other.has(t, -line_slack)) return;
  const double gap = n.dot(d) - line.radius - other.radius;
  if (gap < at.least) return;
  out.add(line.center + s * line.along + line.radius * n, true, n, gap, line.middle, other.middle);
}

void line_ends_on_line(const Line& line, const Line& other, const ClosestNormal& at, double slack,
                       const PointSink& out) {
  if (line.along.cross(other.along).norm() > side_by_side) return;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d end = line.end(i);
    const double t = other.coordinate(end);
    const Eigen::Vector3d d = other.center + t * other.along - end;
    const double distance = d.norm();
    if (!other.has(t, slack) || !(distance > 0) || d.dot(at.n) < facing * distance) continue;
    const double gap = distance - line.radius - other.radius;
    if (gap >= at.least) out.add(end + line.radius / distance * d, true, d / distance, gap, line.ends[i], other.middle);
  }
}

void line_ends_on_cap(const Line& line, const CylinderPose& cylinder, const ClosestNormal& at, const PointSink& out) {
  const int end = -at.n.dot(cylinder.axis) < 0 ? 0 : 1;
  const Eigen::Vector3d normal = end == 0 ? Eigen::Vector3d(-cylinder.axis) : cylinder.axis;
  if (-normal.dot(at.n) < facing || std::abs(line.along.dot(at.n)) > side_by_side) return;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d d = line.end(i) - cylinder.cap(end);
    const double gap = normal.dot(d) - line.radius;
    if (gap < at.least || normal.cross(d).norm() > cylinder.radius * (1 + line_slack)) continue;
    out.add(line.end(i) - line.radius * normal, true, -normal, gap, line.ends[i], cylinder_feature::cap(end));
  }
}

// p on the rim and q on the line with p - q perpendicular to the tangents of both, from where they cross in the plane
// of the rim.
void rim_across_line(const CylinderPose& cylinder, int end, const Line& line, const ClosestNormal& at,
                     const PointSink& out) {
  const Eigen::Vector3d c = cylinder.cap(end);
  const Eigen::Vector3d& e = line.along;
  const Eigen::Vector2d e2(e.dot(cylinder.x), e.dot(cylinder.y));
  const Eigen::Vector2d q2((line.center - c).dot(cylinder.x), (line.center - c).dot(cylinder.y));
  const double a = e2.squaredNorm();
  const double b = e2.dot(q2);
  const double root = b * b - a * (q2.squaredNorm() - cylinder.radius * cylinder.radius);
  if (!(root > 0) || !(a > 0.5)) return;
  for (const double sign : {-1.0, 1.0}) {
    const Eigen::Vector2d start = q2 + (-b + sign * std::sqrt(root)) / a * e2;
    double phi = std::atan2(start.y(), start.x());
    Eigen::Vector3d tangent;
    Eigen::Vector3d p;
    for (int step = 0; step < 20; ++step) {
      const Eigen::Vector3d u = std::cos(phi) * cylinder.x + std::sin(phi) * cylinder.y;
      tangent = -std::sin(phi) * cylinder.x + std::cos(phi) * cylinder.y;
      p = c + cylinder.radius * u;
      const Eigen::Vector3d off = (p - line.center) - e.dot(p - line.center) * e;
      const Eigen::Vector3d across = tangent - e.dot(tangent) * e;
      const double derivative = cylinder.radius * across.squaredNorm() - off.dot(u);
      const double move = -off.dot(tangent) / derivative;
      if (!(std::abs(move) < 0.5)) return;
      phi += move;
      if (std::abs(move) < 1e-15) break;
    }
    const Eigen::Vector3d cross = tangent.cross(e);
    // Where the line is nearly tangent to the rim both crossings are about to merge.
    if (cross.norm() < 0.01) continue;
    const Eigen::Vector3d n = aligned(cross.normalized(), at.n);
    const double gap = n.dot(line.center - p) - line.radius;
    const double t = line.coordinate(p);
    if (n.dot(at.n) < facing || gap < at.least || !line.has(t, -line_slack)) continue;
    out.add(p, true, n, gap, cylinder_feature::crossing(end, sign > 0), line.middle);
  }
}

void rim_on_line(const CylinderPose& cylinder, int end, const Line& line, const ClosestNormal& at, double slack,
                 const PointSink& out) {
  if (cylinder.axis.cross(line.along).norm() > side_by_side) return;
  // The largest separation among normals perpendicular to the line, by Newton's method.
  Eigen::Vector3d n = at.n - at.n.dot(line.along) * line.along;
  n.normalize();
  Eigen::Vector3d p;
  for (int step = 0; step < 20; ++step) {
    const double x = n.dot(cylinder.x);
    const double y = n.dot(cylinder.y);
    const double across = std::hypot(x, y);
    if (!(across > 0.5)) return;
    p = cylinder.cap(end) + cylinder.radius * (x / across * cylinder.x + y / across * cylinder.y);
    const Eigen::Vector3d tangent = x / across * cylinder.y - y / across * cylinder.x;
    const Eigen::Vector3d t = line.along.cross(n);
    const Eigen::Vector3d d = line.center - p;
    const double along_tangent = t.dot(tangent);
    const double curvature = cylinder.radius / across * along_tangent * along_tangent + n.dot(d);
    const double move = t.dot(d) / curvature;
    if (!(std::abs(move) < 0.5)) return;
    n = (n + move * t).normalized();
    if (std::abs(move) < 1e-15) break;
  }
  const double gap = n.dot(line.center - p) - line.radius;
  if (n.dot(at.n) < facing || gap < at.least || !line.has(line.coordinate(p), slack)) return;
  out.add(p, true, n, gap, cylinder_feature::rim(end), line.middle);
}

void rim_across_rim(const CylinderPose& A, int end_A, const CylinderPose& B, int end_B, const ClosestNormal& at,
                    const PointSink& out) {
  const Eigen::Vector3d a = A.cap(end_A);
  const Eigen::Vector3d b = B.cap(end_B);
  // Both circles in the plane of A.
  const Eigen::Vector2d d((b - a).dot(A.x), (b - a).dot(A.y));
  const double distance = d.norm();
  if (!(distance > 1e-3 * std::min(A.radius, B.radius))) return;
  const double x = (distance * distance + A.radius * A.radius - B.radius * B.radius) / (2 * distance);
  const double y2 = A.radius * A.radius - x * x;
  if (!(y2 > 0)) return;
  for (const double sign : {-1.0, 1.0}) {
    const Eigen::Vector2d start = (x * d + sign * std::sqrt(y2) * Eigen::Vector2d(-d.y(), d.x())) / distance;
    double phi = std::atan2(start.y(), start.x());
    const Eigen::Vector3d at_start = a + start.x() * A.x + start.y() * A.y - b;
    double psi = std::atan2(at_start.dot(B.y), at_start.dot(B.x));
    Eigen::Vector3d p, q, tangent_A, tangent_B;
    bool found = false;
    for (int step = 0; step < 20 && !found; ++step) {
      const Eigen::Vector3d u = std::cos(phi) * A.x + std::sin(phi) * A.y;
      const Eigen::Vector3d w = std::cos(psi) * B.x + std::sin(psi) * B.y;
      tangent_A = -std::sin(phi) * A.x + std::cos(phi) * A.y;
      tangent_B = -std::sin(psi) * B.x + std::cos(psi) * B.y;
      p = a + A.radius * u;
      q = b + B.radius * w;
      const Eigen::Vector3d between = p - q;
      Eigen::Matrix2d J;
      J << A.radius - between.dot(u), -B.radius * tangent_B.dot(tangent_A), A.radius * tangent_A.dot(tangent_B),
          -B.radius - between.dot(w);
      const Eigen::Vector2d residual(between.dot(tangent_A), between.dot(tangent_B));
      const double determinant = J.determinant();
      if (!(std::abs(determinant) > 1e-6 * A.radius * B.radius)) break;
      const Eigen::Vector2d move(-(J(1, 1) * residual.x() - J(0, 1) * residual.y()) / determinant,
                                 -(J(0, 0) * residual.y() - J(1, 0) * residual.x()) / determinant);
      if (!(move.norm() < 0.5)) break;
      phi += move.x();
      psi += move.y();
      found = move.norm() < 1e-14;
    }
    const Eigen::Vector3d cross = tangent_A.cross(tangent_B);
    if (!found || cross.norm() < 0.01) continue;
    const Eigen::Vector3d n = aligned(cross.normalized(), at.n);
    const double gap = n.dot(q - p);
    if (n.dot(at.n) < facing || gap < at.least) continue;
    out.add(p, true, n, gap, cylinder_feature::crossing(end_A, sign > 0), cylinder_feature::rim(end_B));
  }
}

}  // namespace gelenk
