// SPDX-License-Identifier: BSD-3-Clause
// The part of Kinematics that is read from the workspace of the kernels, or needs no more than the model.
#pragma once

#include <algorithm>
#include <vector>

#include "kinematics/coordinate_kernels.h"
#include "kinematics/coordinate_rows.h"
#include "kinematics/kernels.h"
#include "kinematics/visit.h"
#include "kinematics/with_readings.h"

namespace gelenk {

template <class A, class Base>
class WithKinematics : public WithReadings<A, Base> {
 public:
  WithKinematics(const Mechanism& mechanism, const Loads& loads)
      : WithReadings<A, Base>(mechanism, loads), qdot_is_v_(std::ranges::all_of(model_.links, [](const auto& link) {
          return link.constant_subspace || link.nv == 0;
        })) {}

  const std::vector<double>& targets() const override { return this->targets_; }
  const std::vector<double>& Phi() const override { return ws_.Phi; }
  bool row_is_angle(int row) const override { return kernels::row_is_angle(model_, row, ws_); }
  const std::vector<double>& row_rates() const override { return ws_.rate; }
  const std::vector<double>& gamma() const override { return ws_.gamma; }
  Eigen::SparseMatrix<double> sparse_J() override { return this->rows_of_J().matrix(model_.nv); }

  void cut_coordinates(int cut, double* q) const override {
    visit_joint<A>(model_.cuts[cut].joint, [&](const auto& joint) { joint.template coordinates<A>(ws_.X_FM[cut], q); });
  }
  void cut_speed_columns(int cut, double* columns) const override {
    double q[max_cut_nq] = {};
    this->counted_coordinates(cut, q);
    kernels::cut_speed_columns(model_, ws_, cut, q, columns);
  }
  Pose3 cut_pose(int cut) const override { return kernels::pose3<A>(ws_.X_FM[cut], 0); }

  void qdot_from_v(const double* q, const double* v, double* qdot) const override {
    qdot_is_v_ ? void(std::copy_n(v, model_.nv, qdot)) : kernels::coordinate_rates(model_, q, v, qdot);
  }
  void displace(double* q, const double* dv) const override { kernels::displace(model_, qdot_is_v_, q, dv); }
  void normalize(double* q) const override {
    if (!qdot_is_v_) kernels::normalize(model_, q);
  }

 protected:
  using WithReadings<A, Base>::model_;
  using WithReadings<A, Base>::ws_;

 private:
  bool qdot_is_v_;  // for all joints
};

}  // namespace gelenk
