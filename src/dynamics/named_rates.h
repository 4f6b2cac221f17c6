// SPDX-License-Identifier: BSD-3-Clause
// The rates, along the motion, of what expressions name of it: coordinates of any joint, their rates, and outputs of
// sensors. By dual numbers, since what is beyond the tree has no other derivatives.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "derivatives/residual_evaluator.h"
#include "dynamics/dynamics.h"
#include "math/dual.h"

namespace gelenk {

class NamedRates {
 public:
  NamedRates(const Mechanism& mechanism, const Loads& loads)
      : evaluator_(make_residual_evaluator<Dual>(mechanism, loads)),
        first_(loads.first_named()),
        qdot_(static_cast<std::size_t>(mechanism.nq)),
        q_(qdot_.size()),
        v_(static_cast<std::size_t>(mechanism.nv)),
        u_(static_cast<std::size_t>(first_)),
        targets_(3 * mechanism.coordinate_rows.size()),
        count_(loads.named.size()) {}

  // At this state. vdot: the accelerations, or null: the rates of what depends on velocities are then NaN.
  void find(const Kinematics& of, const std::vector<double>& q, const std::vector<double>& v, const double* vdot,
            const double* cut_reference, double* out) {
    of.qdot_from_v(q.data(), v.data(), qdot_.data());
    for (std::size_t i = 0; i < q_.size(); ++i) q_[i] = along(q[i], qdot_[i]);
    for (std::size_t k = 0; k < v_.size(); ++k) v_[k] = along(v[k], vdot == nullptr ? NAN : vdot[k]);
    evaluator_->set_cut_reference(cut_reference);
    evaluator_->set_targets(targets_.data());
    evaluator_->set_position(q_.data());
    evaluator_->set_velocity(v_.data());
    const Dual* const all = evaluator_->all_signals(u_.data());
    for (std::size_t i = 0; i < count_; ++i) out[i] = all[first_ + static_cast<int>(i)].derivatives()[0];
  }

 private:
  static Dual along(double value, double rate) {
    Dual out(value);
    out.derivatives()[0] = rate;
    return out;
  }

  std::unique_ptr<ResidualEvaluator<Dual>> evaluator_;
  int first_;
  std::vector<double> qdot_;
  std::vector<Dual> q_, v_, u_, targets_;
  std::size_t count_;
};

}  // namespace gelenk
