// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

#include "scene/check.h"
#include "scene/frames.h"
#include "scene/text.h"

namespace gelenk {
namespace {

constexpr double rounding = 1e-9;  // of the largest moment: figures in files are rounded

// Moments about any three orthogonal axes: none negative, none larger than the two others together.
// names: of the axes, as "xx".
bool possible(const Eigen::Vector3d& moments, const std::array<const char*, 3>& names, const std::string& prefix,
              const std::string& path, Faults& faults) {
  const double slack = rounding * moments.cwiseAbs().maxCoeff();
  for (int i = 0; i < 3; ++i) {
    if (moments[i] < -slack) {
      faults.add(path, prefix + names[static_cast<std::size_t>(i)] + " = " + text::rounded(moments[i]) +
                           " kg m2 is negative; no rigid body has such moments");
      return false;
    }
  }
  for (int i = 0; i < 3; ++i) {
    const int j = i == 0 ? 1 : 0;
    const int k = i == 2 ? 1 : 2;
    const double sum = moments[j] + moments[k];
    if (moments[i] <= sum + slack) continue;
    const auto name = [&](int n) { return std::string(names[static_cast<std::size_t>(n)]); };
    faults.add(path, prefix + name(i) + " = " + text::rounded(moments[i]) + " exceeds " + name(j) + " + " + name(k) +
                         " = " + text::rounded(sum) + " kg m2; no rigid body has such moments");
    return false;
  }
  return true;
}

void check_inertia(const Body& body, const std::string& path, Faults& faults) {
  const Eigen::Matrix3d& I = body.inertia;
  if (!I.allFinite()) {
    const std::array<double, 6> entries = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
    return check_finite(entries.data(), entries.size(), path, faults);
  }
  if (body.mass == 0 && !I.isZero(0)) {
    return faults.add(path, "moments of a body whose mass is 0 kg", "zeros");
  }
  const double largest = I.cwiseAbs().maxCoeff();
  if (largest == 0) return;
  if (largest > 1e300) return faults.add(path, text::number(largest) + " kg m2", "at most 1e300 kg m2");
  if (!possible(I.diagonal(), {"xx", "yy", "zz"}, "", path, faults)) return;
  // Scaled, so that products of tiny or huge numbers stay in range.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(I / largest, Eigen::EigenvaluesOnly);
  possible(solver.eigenvalues() * largest, {"I1", "I2", "I3"}, "principal moment ", path, faults);
}

}  // namespace

void check_bodies(const Scene& scene, Faults& faults, bool partial) {
  for (const Body& body : scene.bodies) {
    const std::string path = "bodies." + text::printable(body.name);
    if (!partial || !std::isnan(body.mass)) check_finite(&body.mass, 1, path + ".mass", faults);
    if (body.mass < 0) faults.add(path + ".mass", text::number(body.mass) + " kg", "0 kg or more");
    check_finite(body.com.data(), 3, path + ".com", faults);
    check_inertia(body, path + ".inertia", faults);
    if (body.pose) check_frame({.body = ground, .X_BF = *body.pose}, scene, path + ".pose", faults, partial);
  }
}

}  // namespace gelenk
