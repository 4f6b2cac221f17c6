// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "check/check.h"
#include "decomposition/dense.h"
#include "joint/registry.h"
#include "util/text.h"

namespace gelenk {
namespace {

constexpr double moment_tolerance = 1e-9;  // relative to the largest moment: numbers in files are rounded
// Relative to the moment of the mass about the origin of the body's frame: programs compute moments about the center of
// mass as a difference of such moments, each accurate to about 1e-16.
constexpr double parallel_axis_tolerance = 1e-12;
// Axes are parallel if the sine of their angle is below this; its effect on a moment is quadratic.
constexpr double parallel_sine_limit = 1e-6;

using AxisNames = std::array<const char*, 3>;

// Checks that no moment about three orthogonal axes is negative or exceeds the sum of the other two by more than
// `tolerance` [kg m2]. Returns a description of the violation, or an empty text.
std::string impossible(const Eigen::Vector3d& moments, double tolerance, const AxisNames& names,
                       const std::string& prefix) {
  const auto name = [&](int n) { return std::string(names[static_cast<std::size_t>(n)]); };
  for (int i = 0; i < 3; ++i) {
    if (moments[i] >= -tolerance) continue;
    return prefix + name(i) + " = " + text::rounded(moments[i]) + " kg m2 is negative; no rigid body has such moments";
  }
  for (int i = 0; i < 3; ++i) {
    const int j = i == 0 ? 1 : 0;
    const int k = i == 2 ? 1 : 2;
    const double sum = moments[j] + moments[k];
    if (moments[i] <= sum + tolerance) continue;
    return prefix + name(i) + " = " + text::rounded(moments[i]) + " exceeds " + name(j) + " + " + name(k) + " = " +
           text::rounded(sum) + " kg m2; no rigid body has such moments";
  }
  return {};
}

// Returns the axis of a tensor J n n^T in the body's frame, or nothing if it has another form.
std::optional<Eigen::Vector3d> single_moment_axis(const Eigen::Matrix3d& I) {
  const double largest = I.cwiseAbs().maxCoeff();
  const SymmetricEigen principal(I / largest);
  if (principal.values.head<2>().cwiseAbs().maxCoeff() > moment_tolerance * principal.values[2]) return {};
  return principal.vectors.col(2);
}

std::string axis_text(const Eigen::Vector3d& axis) {
  for (int i = 0; i < 3; ++i) {
    if (std::abs(axis[i]) > 1 - moment_tolerance) return std::string(1, "xyz"[i]) + " axis";
  }
  const Eigen::Vector3d n = axis.sum() < 0 ? Eigen::Vector3d(-axis) : axis;  // either direction is meant
  return "axis [" + text::rounded(n.x()) + ", " + text::rounded(n.y()) + ", " + text::rounded(n.z()) + "]";
}

enum class Rotation { none, about_z, general };

// Returns how a joint permits M to rotate in F, in its canonical frames; evaluated at two generic positions.
Rotation rotation_of(const AnyJoint& joint) {
  Rotation out = Rotation::none;
  const int nv = kind_of(joint).nv;
  for (const double place : {0.3, 0.7}) {
    std::array<double, 7> q;
    for (std::size_t i = 0; i < q.size(); ++i) q[i] = place * static_cast<double>(i + 1);
    for (int k = 0; k < nv; ++k) {
      std::array<double, 6> v{};
      v[static_cast<std::size_t>(k)] = 1;
      const Eigen::Vector3d w =
          std::visit([&](const auto& j) { return j.template V_FM<Spatial>(q.data(), v.data()).w; }, joint);
      if (w.head<2>().norm() > 0) return Rotation::general;
      if (w.z() != 0) out = Rotation::about_z;
    }
  }
  return out;
}

// Joints with a wrong number of axes are reported elsewhere.
bool has_its_axes(const Joint& joint) {
  const JointKind* kind = find_joint_kind(joint.type);
  return kind != nullptr && joint.axes.size() == static_cast<std::size_t>(kind->axes);
}

// Tests whether a body rotates about one axis only in its carrier, which may move in any way. What the carrier does
// about other axes then involves no inertia of the body: it is a rotor of which one moment is given.
class AxisSearch {
 public:
  explicit AxisSearch(const Scene& scene) {
    for (const Joint& joint : scene.joints) {
      joints_of_[joint.parent.body].push_back(&joint);
      if (joint.child.body != joint.parent.body) joints_of_[joint.child.body].push_back(&joint);
    }
  }

  bool operator()(const std::string& body, const Eigen::Vector3d& axis) const {
    std::map<std::string, Eigen::Vector3d> axes = {{body, axis}};  // of what does not rotate in it, in its own frame
    std::deque<std::string> open = {body};
    while (!open.empty()) {
      const std::string at = open.front();
      open.pop_front();
      const auto joints = joints_of_.find(at);
      if (joints == joints_of_.end()) continue;
      for (const Joint* joint : joints->second) {
        const std::string& other = joint->parent.body == at ? joint->child.body : joint->parent.body;
        if (axes.contains(other) || !has_its_axes(*joint)) continue;
        const Across across = across_joint(*joint, at, axes.at(at));
        if (across.rotation == Rotation::general) continue;
        if (across.rotation == Rotation::about_z) {
          if (reaches_ground(other, axes)) return true;
          continue;
        }
        if (other == ground) return true;
        axes.emplace(other, across.axis);
        open.push_back(other);
      }
    }
    return false;
  }

 private:
  struct Across {
    Rotation rotation;     // about_z: about the axis
    Eigen::Vector3d axis;  // in the body on the other side
  };

  static Across across_joint(const Joint& joint, const std::string& from, const Eigen::Vector3d& axis) {
    const bool from_parent = joint.parent.body == from;
    const AnyJoint& kind = *joint.is;
    const Eigen::Matrix3d R_UC = canonical_rotation(kind, joint.axes);
    const Eigen::Matrix3d& here = (from_parent ? joint.parent : joint.child).X_BF.R;
    const Eigen::Matrix3d& there = (from_parent ? joint.child : joint.parent).X_BF.R;
    const Eigen::Vector3d along = (here * R_UC).transpose() * axis;  // the same in F and M
    Rotation rotation = rotation_of(kind);
    if (rotation == Rotation::about_z && along.head<2>().norm() > parallel_sine_limit) rotation = Rotation::general;
    return {rotation, there * R_UC * along};
  }

  // Whether a body is held without the help of those that belong to the rotor: it carries them, not they it.
  bool reaches_ground(const std::string& body, const std::map<std::string, Eigen::Vector3d>& rotor) const {
    std::set<std::string> reached = {body};
    std::deque<std::string> open = {body};
    while (!open.empty()) {
      const std::string at = open.front();
      open.pop_front();
      if (at == ground) return true;
      const auto joints = joints_of_.find(at);
      if (joints == joints_of_.end()) continue;
      for (const Joint* joint : joints->second) {
        const std::string& other = joint->parent.body == at ? joint->child.body : joint->parent.body;
        if (!rotor.contains(other) && reached.insert(other).second) open.push_back(other);
      }
    }
    return false;
  }

  std::map<std::string, std::vector<const Joint*>> joints_of_;
};

// Returns why no rigid body has this inertia about its center of mass, beyond round-off, or an empty text. Also applies
// to bodies of mass 0, as the limit of arbitrarily light ones.
std::string impossible_inertia(double mass, const Eigen::Vector3d& com, const Eigen::Matrix3d& I) {
  const double largest = I.cwiseAbs().maxCoeff();
  if (largest == 0) return {};
  const double tolerance = std::max(moment_tolerance * I.diagonal().cwiseAbs().maxCoeff(),
                                    parallel_axis_tolerance * std::abs(mass) * com.squaredNorm());
  std::string fault = impossible(I.diagonal(), tolerance, {"xx", "yy", "zz"}, "");
  if (!fault.empty()) return fault;
  // Scaled, so that products of very small or large numbers neither underflow nor overflow.
  const Eigen::Vector3d principal = symmetric_eigenvalues(I / largest) * largest;
  return impossible(principal, std::max(tolerance, moment_tolerance * principal.cwiseAbs().maxCoeff()),
                    {"I1", "I2", "I3"}, "principal moment ");
}

// Returns the ground and all bodies that are welded to it.
std::set<std::string> welded_to_ground(const Scene& scene) {
  std::map<std::string, std::vector<std::string>> neighbors;
  for (const Joint& joint : scene.joints) {
    const JointKind* kind = find_joint_kind(joint.type);
    if (kind == nullptr || kind->nv > 0) continue;
    neighbors[joint.parent.body].push_back(joint.child.body);
    neighbors[joint.child.body].push_back(joint.parent.body);
  }
  std::set<std::string> out = {ground};
  std::deque<std::string> open = {ground};
  while (!open.empty()) {
    for (const std::string& other : neighbors[open.front()]) {
      if (out.insert(other).second) open.push_back(other);
    }
    open.pop_front();
  }
  return out;
}

}  // namespace

void check_inertias(const Scene& scene, Faults& faults, bool partial) {
  const std::set<std::string> on_ground = welded_to_ground(scene);
  std::optional<AxisSearch> rotates_only_about;  // created at first use
  for (const Body& body : scene.bodies) {
    const std::string path = "bodies." + text::printable(body.name) + ".inertia";
    const Eigen::Matrix3d& I = body.inertia;
    if (!I.allFinite()) {
      const std::array<double, 6> entries = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
      check_finite(entries.data(), entries.size(), path, faults);
      continue;
    }
    const double largest = I.cwiseAbs().maxCoeff();
    if (largest > 1e300) {
      faults.add(path, text::number(largest) + " kg m2", "at most 1e300 kg m2");
      continue;
    }
    if (on_ground.contains(body.name)) continue;  // its inertia has no effect
    std::string fault = impossible_inertia(body.mass, body.com, I);
    if (fault.empty()) continue;
    if (const std::optional<Eigen::Vector3d> axis = single_moment_axis(I)) {
      if (!rotates_only_about) rotates_only_about.emplace(scene);
      if (partial || (*rotates_only_about)(body.name, *axis)) continue;
      fault += ", and no joint lets the body rotate about its " + axis_text(*axis) + " only";
    }
    faults.add(path, fault);
  }
}

}  // namespace gelenk
