// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "check/check.h"
#include "joint/registry.h"
#include "util/text.h"

namespace gelenk {
namespace {

constexpr double rounding = 1e-9;  // of the largest moment: figures in files are rounded
// Of the moment that the mass has about the origin of the body's frame: programs tell moments about the centre of mass
// as a difference of such moments, each exact to some 1e-16.
constexpr double difference_rounding = 1e-12;
// Sine of the angle between axes that are parallel: what it leaves of a moment is its square.
constexpr double parallel = 1e-6;

using Names = std::array<const char*, 3>;

// Moments about any three orthogonal axes, named: none negative, none larger than the two others together, up to slack.
std::string impossible(const Eigen::Vector3d& moments, double slack, const Names& names, const std::string& prefix) {
  const auto name = [&](int n) { return std::string(names[static_cast<std::size_t>(n)]); };
  for (int i = 0; i < 3; ++i) {
    if (moments[i] >= -slack) continue;
    return prefix + name(i) + " = " + text::rounded(moments[i]) + " kg m2 is negative; no rigid body has such moments";
  }
  for (int i = 0; i < 3; ++i) {
    const int j = i == 0 ? 1 : 0;
    const int k = i == 2 ? 1 : 2;
    const double sum = moments[j] + moments[k];
    if (moments[i] <= sum + slack) continue;
    return prefix + name(i) + " = " + text::rounded(moments[i]) + " exceeds " + name(j) + " + " + name(k) + " = " +
           text::rounded(sum) + " kg m2; no rigid body has such moments";
  }
  return {};
}

// The axis of the body's frame about which alone a moment is given; -1: there is none.
int only_axis(const Eigen::Matrix3d& I) {
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Matrix3d rest = I;
    rest(axis, axis) = 0;
    if (I(axis, axis) > 0 && rest.isZero(0)) return axis;
  }
  return -1;
}

enum class Turns { never, about_z, freely };

// How M of a joint may turn against F, in its canonical frames: seen at places that are not special.
Turns turns_of(const AnyJoint& joint) {
  Turns out = Turns::never;
  const int nv = kind_of(joint).nv;
  for (const double place : {0.3, 0.7}) {
    std::array<double, 7> q;
    for (std::size_t i = 0; i < q.size(); ++i) q[i] = place * static_cast<double>(i + 1);
    for (int k = 0; k < nv; ++k) {
      std::array<double, 6> v{};
      v[static_cast<std::size_t>(k)] = 1;
      const Eigen::Vector3d w =
          std::visit([&](const auto& j) { return j.template V_FM<Spatial>(q.data(), v.data()).w; }, joint);
      if (w.head<2>().norm() > 0) return Turns::freely;
      if (w.z() != 0) out = Turns::about_z;
    }
  }
  return out;
}

// What has none is told elsewhere.
bool has_its_axes(const Joint& joint) {
  const JointKind* kind = find_joint_kind(joint.type);
  return kind != nullptr && joint.axes.size() == static_cast<std::size_t>(kind->axes);
}

// Whether the joints on some way from the body to the ground let it turn about parallels to one axis alone.
class AxisSearch {
 public:
  explicit AxisSearch(const Scene& scene) {
    for (const Joint& joint : scene.joints) {
      joints_of_[joint.parent.body].push_back(&joint);
      if (joint.child.body != joint.parent.body) joints_of_[joint.child.body].push_back(&joint);
    }
  }

  bool operator()(const std::string& body, const Eigen::Vector3d& axis) const {
    std::map<std::string, Eigen::Vector3d> axes = {{body, axis}};  // by body reached, in its frame
    std::deque<std::string> open = {body};
    while (!open.empty()) {
      const std::string at = open.front();
      open.pop_front();
      const auto joints = joints_of_.find(at);
      if (joints == joints_of_.end()) continue;
      for (const Joint* joint : joints->second) {
        const std::string& other = joint->parent.body == at ? joint->child.body : joint->parent.body;
        if (axes.contains(other)) continue;
        const std::optional<Eigen::Vector3d> across = axis_across(*joint, at, axes.at(at));
        if (!across) continue;
        if (other == ground) return true;
        axes.emplace(other, *across);
        open.push_back(other);
      }
    }
    return false;
  }

 private:
  // The axis, in the body on the other side of the joint; none: the joint lets it turn about others.
  static std::optional<Eigen::Vector3d> axis_across(const Joint& joint, const std::string& from,
                                                    const Eigen::Vector3d& axis) {
    if (!has_its_axes(joint)) return {};
    const bool from_parent = joint.parent.body == from;
    const AnyJoint kind = joint.is;
    const Eigen::Matrix3d R_UC = canonical_rotation(kind, joint.axes);
    const Eigen::Matrix3d& here = (from_parent ? joint.parent : joint.child).X_BF.R;
    const Eigen::Matrix3d& there = (from_parent ? joint.child : joint.parent).X_BF.R;
    const Eigen::Vector3d along = (here * R_UC).transpose() * axis;  // in F as in M
    const Turns turns = turns_of(kind);
    if (turns == Turns::freely || (turns == Turns::about_z && along.head<2>().norm() > parallel)) return {};
    return there * R_UC * along;
  }

  std::map<std::string, std::vector<const Joint*>> joints_of_;
};

// Why no rigid body has this inertia about its centre of mass, beyond rounding; empty: one may have it. Of a body whose
// mass is 0 too: the moments of something as light as one likes.
std::string impossible_inertia(double mass, const Eigen::Vector3d& com, const Eigen::Matrix3d& I) {
  const double largest = I.cwiseAbs().maxCoeff();
  if (largest == 0) return {};
  const double slack =
      std::max(rounding * I.diagonal().cwiseAbs().maxCoeff(), difference_rounding * std::abs(mass) * com.squaredNorm());
  std::string fault = impossible(I.diagonal(), slack, {"xx", "yy", "zz"}, "");
  if (!fault.empty()) return fault;
  // Scaled, so that products of tiny or huge numbers stay in range.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(I / largest, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d principal = solver.eigenvalues() * largest;
  return impossible(principal, std::max(slack, rounding * principal.cwiseAbs().maxCoeff()), {"I1", "I2", "I3"},
                    "principal moment ");
}

// The ground and the bodies that joints without freedom hold to it.
std::set<std::string> welded_to_ground(const Scene& scene) {
  std::map<std::string, std::vector<std::string>> neighbours;
  for (const Joint& joint : scene.joints) {
    const JointKind* kind = find_joint_kind(joint.type);
    if (kind == nullptr || kind->nv > 0) continue;
    neighbours[joint.parent.body].push_back(joint.child.body);
    neighbours[joint.child.body].push_back(joint.parent.body);
  }
  std::set<std::string> out = {ground};
  std::deque<std::string> open = {ground};
  while (!open.empty()) {
    for (const std::string& other : neighbours[open.front()]) {
      if (out.insert(other).second) open.push_back(other);
    }
    open.pop_front();
  }
  return out;
}

}  // namespace

void check_inertias(const Scene& scene, Faults& faults, bool partial) {
  const std::set<std::string> still = welded_to_ground(scene);
  std::optional<AxisSearch> turns_only_about;  // made when asked for
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
    if (still.contains(body.name)) continue;  // nothing depends on it
    std::string fault = impossible_inertia(body.mass, body.com, I);
    if (fault.empty()) continue;
    if (const int axis = only_axis(I); axis >= 0) {
      if (!turns_only_about) turns_only_about.emplace(scene);
      if (partial || (*turns_only_about)(body.name, Eigen::Vector3d::Unit(axis))) continue;
      fault += std::string(", and joints let this one turn about more than its ") + "xyz"[axis] + " axis";
    }
    faults.add(path, fault);
  }
}

}  // namespace gelenk
