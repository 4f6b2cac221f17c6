// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/export/picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fmu/export/outline.h"
#include "joint/kinds.h"
#include "scene/name_index.h"
#include "simulation/start_report.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr Color paper = {255, 255, 255};
constexpr Color ink = {38, 50, 64};
constexpr Color metal = {200, 216, 232};
constexpr Color metal_edge = {84, 116, 148};
constexpr Color earth = {130, 130, 130};
constexpr Color wire = {176, 98, 30};
constexpr Color drive = {214, 72, 48};
constexpr double margin = 40;                   // pixels
constexpr std::size_t max_labeled_joints = 12;  // with more joints the names would overlap

std::vector<Pose3> poses_of(Simulation& simulation) {
  std::vector<Pose3> out;
  for (std::size_t b = 0; b < simulation.scene().bodies.size(); ++b) {
    out.push_back(simulation.body_pose(static_cast<int>(b)));
  }
  return out;
}

constexpr double text_margin = 4;  // pixels

// Whether a joint is drawn: one with six degrees of freedom constrains nothing.
bool constrains(const Joint& joint) { return find_joint_kind(joint.type)->nv < 6; }

// Whether a force is drawn: one between two bodies.
bool is_between_bodies(const Force& force) { return force.frames.size() == 2; }

// The view: directions of the picture's axes in the world frame.
struct View {
  Vector3d right{1, 0, 0}, up{0, 0, 1};

  Vector2d of(const Vector3d& p_W) const { return {right.dot(p_W), -up.dot(p_W)}; }
};

View view_of(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  Vector3d up = scene.gravity.norm() > 0 ? Vector3d(-scene.gravity.normalized()) : Vector3d::UnitZ();
  const auto& islands = StartReport(simulation).prepared().reduced.islands;
  const bool planar = !islands.empty() && simulation.size().planar;
  Vector3d towards = planar ? Vector3d(islands.front().X_W0.R.col(2)) : Vector3d(0.5, -0.8, 0.45);
  if (std::abs(up.dot(towards.normalized())) > 0.99)
    up = std::abs(towards.y()) < 0.9 ? Vector3d::UnitY() : Vector3d::UnitZ();
  View view;
  view.up = (up - up.dot(towards) / towards.squaredNorm() * towards).normalized();
  view.right = view.up.cross(towards.normalized());
  Eigen::Index largest = 0;
  view.right.cwiseAbs().maxCoeff(&largest);
  if (view.right[largest] < 0) view.right = -view.right;
  return view;
}

// Corners of the convex hull of points, in order (Andrew's monotone chain).
std::vector<Vector2d> hull(std::vector<Vector2d> points) {
  // In pixels; without rounding, points in line above each other would be in the order of their rounding errors.
  for (Vector2d& p : points) p = (1e6 * p).array().round() / 1e6;
  std::ranges::sort(
      points, [](const Vector2d& a, const Vector2d& b) { return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()); });
  std::vector<Vector2d> out;
  for (int side = 0; side < 2; ++side) {
    const std::size_t begin = out.size();
    for (const Vector2d& p : points) {
      const auto turns = [&](const Vector2d& a, const Vector2d& b) {
        return (b - a).x() * (p - a).y() - (b - a).y() * (p - a).x() <= 1e-9;
      };
      while (out.size() >= begin + 2 && turns(out[out.size() - 2], out.back())) out.pop_back();
      out.push_back(p);
    }
    out.pop_back();
    std::ranges::reverse(points);
  }
  return out;
}

// The convex hull, or its two ends if it is too thin for a polygon.
std::vector<Vector2d> thick_hull(const std::vector<Vector2d>& points) {
  constexpr double min_width = 6;  // pixels
  std::vector<Vector2d> corners = hull(points);
  if (corners.size() < 3) return corners;
  std::pair ends(corners[0], corners[1]);
  for (const Vector2d& a : corners) {
    for (const Vector2d& b : corners) {
      if ((b - a).norm() > (ends.second - ends.first).norm()) ends = {a, b};
    }
  }
  const Vector2d along = (ends.second - ends.first).normalized();
  const bool is_thin = std::ranges::all_of(corners, [&](const Vector2d& p) {
    const Vector2d d = p - ends.first;
    return std::abs(along.x() * d.y() - along.y() * d.x()) < min_width;
  });
  return is_thin ? std::vector<Vector2d>{ends.first, ends.second} : corners;
}

class PictureBuilder {
 public:
  explicit PictureBuilder(Simulation& simulation)
      : scene_(simulation.scene()), numbers_(scene_), poses_(poses_of(simulation)), view_(view_of(simulation)) {
    find_marks();
    fit();
  }

  Picture run() {
    for (const BodyShape& shape : scene_.ground_shapes) draw_ground_shape(shape);
    for (const Joint& joint : scene_.joints) {
      if (!constrains(joint)) continue;
      draw_ground(joint.parent);
      draw_ground(joint.child);
    }
    for (const Force& force : scene_.forces) {
      if (!is_between_bodies(force)) continue;
      draw_ground(force.frames[0]);
      draw_ground(force.frames[1]);
    }
    for (const std::size_t b : from_back_to_front()) draw_body(b);
    for (const Force& force : scene_.forces) draw_force(force);
    for (const Joint& joint : scene_.joints) draw_joint(joint);
    draw_gravity();
    return std::move(picture_);
  }

 private:
  Vector3d in_world(const BodyFrame& frame) const {
    const int b = numbers_.body(frame.body);
    return b < 0 ? frame.X_BF.p : poses_[static_cast<std::size_t>(b)].point(frame.X_BF.p);
  }

  // Collects, for each body, its center of mass and the points at which joints and forces act.
  void find_marks() {
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) marks_.push_back({poses_[b].point(scene_.bodies[b].com)});
    const auto mark = [&](const BodyFrame& frame) {
      const int b = numbers_.body(frame.body);
      if (b >= 0) marks_[static_cast<std::size_t>(b)].push_back(in_world(frame));
    };
    for (const Joint& joint : scene_.joints) {
      if (!constrains(joint)) continue;
      mark(joint.parent);
      mark(joint.child);
    }
    for (const Force& force : scene_.forces) {
      if (!is_between_bodies(force)) continue;
      mark(force.frames[0]);
      mark(force.frames[1]);
    }
  }

  // Chooses scale and origin such that everything is in the picture.
  void fit() {
    constexpr double far = std::numeric_limits<double>::infinity();
    Vector2d least(far, far);
    Vector2d most(-far, -far);
    const auto include = [&](const Vector3d& p_W) {
      least = least.cwiseMin(view_.of(p_W));
      most = most.cwiseMax(view_.of(p_W));
    };
    for (const std::vector<Vector3d>& of_body : marks_) std::ranges::for_each(of_body, include);
    const auto include_shape = [&](const BodyShape& shape, const Pose3& X_WB) {
      for (const std::vector<Vector3d>& face : outline(shape, X_WB).faces) std::ranges::for_each(face, include);
    };
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      for (const BodyShape& shape : scene_.bodies[b].shapes) include_shape(shape, poses_[b]);
    }
    for (const BodyShape& shape : scene_.ground_shapes) include_shape(shape, Pose3());
    if (least.x() <= most.x()) extent_ = (most - least).norm();
    for (const BodyShape& shape : scene_.ground_shapes) {
      if (!kind_of(*shape.is).bounded) std::ranges::for_each(piece_of(shape), include);
    }
    for (const Joint& joint : scene_.joints) {
      if (constrains(joint)) include(in_world(joint.parent));
    }
    for (const Force& force : scene_.forces) {
      if (!is_between_bodies(force)) continue;
      include(in_world(force.frames[0]));
      include(in_world(force.frames[1]));
    }
    if (!(least.x() <= most.x())) return;  // nothing to draw
    const Vector2d room(picture_.width - 2 * margin, picture_.height - 2 * margin);
    const Vector2d size = most - least;
    scale_ = std::min(room.x() / std::max(size.x(), 1e-9), room.y() / std::max(size.y(), 1e-9));
    if (size.norm() < 1e-9) scale_ = 1;
    origin_ = Vector2d(picture_.width, picture_.height) / 2 - scale_ * (least + most) / 2;
  }

  Vector2d on_paper(const Vector3d& p_W) const { return origin_ + scale_ * view_.of(p_W); }

  void line(std::vector<Vector2d> points, double width, Color color) {
    picture_.shapes.push_back({Shape::Kind::line, std::move(points), 0, width, color, color});
  }
  void disc(const Vector2d& at, double radius, Color edge, Color fill) {
    picture_.shapes.push_back({Shape::Kind::disc, {at}, radius, 2, edge, fill});
  }
  void polygon(std::vector<Vector2d> points, Color edge, Color fill) {
    picture_.shapes.push_back({Shape::Kind::polygon, std::move(points), 0, 2, edge, fill});
  }

  void draw_ground(const BodyFrame& frame) {
    if (frame.body != ground) return;
    const Vector2d at = on_paper(in_world(frame));
    polygon({at, at + Vector2d(-11, 18), at + Vector2d(11, 18)}, earth, {232, 232, 232});
    line({at + Vector2d(-17, 19), at + Vector2d(17, 19)}, 3, earth);
    for (int i = 0; i < 5; ++i) {
      const Vector2d top = at + Vector2d(-10 + 6.5 * i, 20);
      line({top, top + Vector2d(-6, 7)}, 1.5, earth);
    }
  }

  // Beside a point, to its right; at the right edge, to its left. No label is cut off.
  void label(const Vector2d& at, const Vector2d& offset, const std::string& text) {
    const double width = text_width(text);
    Vector2d place = at + offset;
    if (place.x() + width > picture_.width - text_margin) place.x() = at.x() - offset.x() - width;
    place.x() = std::max(std::min(place.x(), picture_.width - text_margin - width), text_margin);
    place.y() = std::clamp(place.y(), text_margin + font_size, picture_.height - text_margin);
    picture_.labels.push_back({place, text});
  }

  Outline outline(const BodyShape& shape, const Pose3& X_WB) const {
    return outline_of(*shape.is, X_WB * shape.X_BS, view_.right, view_.up);
  }

  // A square piece of the surface of a half-space, below the middle of the bodies.
  std::vector<Vector3d> piece_of(const BodyShape& half_space) const {
    const Pose3& X = half_space.X_BS;
    Vector3d middle = Vector3d::Zero();
    for (const std::vector<Vector3d>& of_body : marks_) middle += of_body.front() / static_cast<double>(marks_.size());
    const Vector3d local = X.R.transpose() * (middle - X.p);
    constexpr double share = 0.45;  // half its edge relative to the extent of the rest
    const double half = share * extent_;
    std::vector<Vector3d> out;
    for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
      out.push_back(X.point({local.x() + half * x, local.y() + half * y, 0}));
    return out;
  }

  void draw_outline(const Outline& of, Color edge, Color fill) {
    for (const std::vector<Vector3d>& face : of.faces) {
      std::vector<Vector2d> corners;
      for (const Vector3d& p : face) corners.push_back(on_paper(p));
      corners = hull(std::move(corners));
      if (corners.size() > 2) polygon(std::move(corners), of.lines.empty() ? edge : fill, fill);
    }
    for (const auto& ends : of.lines) line({on_paper(ends[0]), on_paper(ends[1])}, 2, edge);
  }

  void draw_ground_shape(const BodyShape& shape) {
    constexpr Color stone = {232, 232, 232};
    if (kind_of(*shape.is).bounded) {
      draw_outline(outline(shape, Pose3()), earth, stone);
      return;
    }
    std::vector<Vector2d> corners;
    for (const Vector3d& p : piece_of(shape)) corners.push_back(on_paper(p));
    polygon(thick_hull(corners), earth, stone);
  }

  // The numbers of the bodies, those with a center of mass farther from the viewer first; without shapes, in the
  // order of the scene.
  std::vector<std::size_t> from_back_to_front() const {
    std::vector<std::size_t> out(scene_.bodies.size());
    for (std::size_t b = 0; b < out.size(); ++b) out[b] = b;
    const Vector3d towards = view_.right.cross(view_.up);
    const bool any = std::ranges::any_of(scene_.bodies, [](const Body& body) { return !body.shapes.empty(); });
    const auto depth = [&](std::size_t b) { return any ? towards.dot(marks_[b].front()) : 0.0; };
    std::ranges::sort(out,
                      [&](std::size_t a, std::size_t b) { return std::pair(depth(a), a) < std::pair(depth(b), b); });
    return out;
  }

  void draw_body(std::size_t b) {
    const Vector2d center = on_paper(poses_[b].point(scene_.bodies[b].com));
    if (scene_.bodies[b].shapes.empty()) {
      draw_links(b);
    } else {
      for (const BodyShape& shape : scene_.bodies[b].shapes) draw_outline(outline(shape, poses_[b]), metal_edge, metal);
    }
    disc(center, 2, ink, ink);
    if (scene_.joints.size() <= max_labeled_joints) label(center, Vector2d(6, 16), scene_.bodies[b].name);
  }

  // A body without shapes: what connects its marks.
  void draw_links(std::size_t b) {
    std::vector<Vector2d> points;
    for (const Vector3d& p_W : marks_[b]) {
      const Vector2d at = on_paper(p_W);
      if (std::ranges::none_of(points, [&](const Vector2d& other) { return (other - at).norm() < 2; })) {
        points.push_back(at);
      }
    }
    const std::vector<Vector2d> corners = thick_hull(points);
    if (points.size() == 1) {
      disc(points.front(), 16, metal_edge, metal);
    } else if (corners.size() > 2) {
      polygon(corners, metal_edge, metal);
    } else {
      line(corners, 9, metal_edge);
      line(corners, 5, metal);
    }
  }

  void draw_force(const Force& force) {
    if (!is_between_bodies(force)) return;
    const Vector2d from = on_paper(in_world(force.frames[0]));
    const Vector2d to = on_paper(in_world(force.frames[1]));
    const Vector2d along = to - from;
    if (along.norm() < 1) return;
    const Vector2d aside = 7 * Vector2d(-along.y(), along.x()) / along.norm();
    std::vector<Vector2d> points = {from, from + 0.2 * along};
    for (int i = 0; i < 8; ++i) points.emplace_back(from + (0.225 + 0.075 * i) * along + (i % 2 == 0 ? 1 : -1) * aside);
    points.emplace_back(from + 0.8 * along);
    points.push_back(to);
    line(std::move(points), 2, wire);
  }

  void draw_joint(const Joint& joint) {
    if (!constrains(joint)) return;
    const Vector2d at = on_paper(in_world(joint.child));
    const Vector2d from = on_paper(in_world(joint.parent));
    if ((at - from).norm() > 1) line({from, at}, 2, ink);
    const bool driven =
        std::ranges::any_of(scene_.motors, [&](const Motor& motor) { return motor.joints.front() == joint.name; });
    const JointKind& kind = *find_joint_kind(joint.type);
    const Color fill = driven ? drive : kind.nv == 0 ? ink : paper;
    const bool slides = kind.nv > 0 && kind.q[0].unit == "m";
    if (slides || kind.nv == 0) {
      const double half = slides ? 7 : 3;
      polygon({at + Vector2d(-half, -half), at + Vector2d(half, -half), at + Vector2d(half, half),
               at + Vector2d(-half, half)},
              ink, fill);
    } else {
      disc(at, 6, ink, fill);
    }
    if (scene_.joints.size() <= max_labeled_joints) label(at, Vector2d(9, -9), joint.name);
  }

  void draw_gravity() {
    const Vector2d pull = view_.of(scene_.gravity);
    if (pull.norm() < 1e-9) return;
    const Vector2d along = 30 * pull.normalized();
    const Vector2d aside(-along.y() / 6, along.x() / 6);
    const Vector2d from(24, 20);
    line({from, from + 0.8 * along}, 2, earth);
    polygon({from + along, from + 0.7 * along + aside, from + 0.7 * along - aside}, earth, earth);
    label(from, Vector2d(8, 12), "g");
  }

  const Scene& scene_;
  NameIndex numbers_;
  std::vector<Pose3> poses_;                  // by body
  std::vector<std::vector<Vector3d>> marks_;  // by body, in the world
  View view_;
  Picture picture_;
  double scale_ = 1;   // pixels per meter
  double extent_ = 1;  // m, the diagonal of what is drawn without half-spaces
  Vector2d origin_ = Vector2d(240, 180);
};

}  // namespace

Picture draw(Simulation& simulation) { return PictureBuilder(simulation).run(); }

}  // namespace gelenk
