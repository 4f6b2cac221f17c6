// SPDX-License-Identifier: BSD-3-Clause
// DOP853 with its authors' error control (Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I) for a
// PinocchioModel. The coefficients are generated from SciPy at build time (dop853_table.h).
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "dop853_table.h"
#include "pinocchio_model.h"

class Dop853 {
 public:
  Dop853(PinocchioModel& model, double tolerance) : model_(model), n_(model.size()), tolerance_(tolerance) {
    stage_rates_.assign(dop853::stages + 1, VectorXd::Zero(2 * n_));
    vdot_.setZero(n_);
  }

  void start(double t, const VectorXd& q, const VectorXd& v, double step = 0) {
    t_ = t;
    y_.resize(2 * n_);
    y_ << q, v;
    step_ = step;
    state_rate(t_, y_, stage_rates_[0]);
    if (step_ <= 0) step_ = first_step();
  }
  VectorXd q() const { return y_.head(n_); }
  VectorXd v() const { return y_.tail(n_); }
  long steps() const { return steps_; }

  // Returns false if the step becomes too small or the evaluations too many.
  bool advance(double end) {
    while (t_ < end - 1e-12) {
      const double h = std::min(step_, end - t_);
      const double error = attempt(h);
      if (!(error < 1e30)) {
        step_ = 0.2 * h;
      } else {
        const double factor = error == 0 ? 6 : std::clamp(0.9 * std::pow(error, -1.0 / 8), 0.2, 6.0);
        if (error <= 1) {
          accept(h);
          // A truncated step does not change the proposed step size.
          step_ = h < step_ ? std::max(step_, factor * h) : factor * h;
        } else {
          step_ = h * std::min(factor, 1.0);
        }
      }
      if (step_ < 1e-13 || model_.evaluations() > 10'000'000) return false;
    }
    return true;
  }

 private:
  void state_rate(double t, const VectorXd& y, VectorXd& out) {
    q_ = y.head(n_);
    v_ = y.tail(n_);
    model_.acceleration(t, q_, v_, vdot_);
    out.head(n_) = v_;
    out.tail(n_) = vdot_;
  }
  double first_step() const {
    const double scale = std::sqrt(2.0 * n_) * tolerance_;
    const double size = y_.norm() / scale, rate = stage_rates_[0].norm() / scale;
    return std::min(1e-2, 0.01 * (size + 1e-5) / (rate + 1e-5) + 1e-6);
  }
  double attempt(double h) {
    for (int i = 1; i < dop853::stages; ++i) {
      between_ = y_;
      for (int j = 0; j < i; ++j) {
        if (dop853::A[i][j] != 0) between_ += h * dop853::A[i][j] * stage_rates_[j];
      }
      state_rate(t_ + h * dop853::C[i], between_, stage_rates_[i]);
    }
    next_ = y_;
    for (int j = 0; j < dop853::stages; ++j) {
      if (dop853::B[j] != 0) next_ += h * dop853::B[j] * stage_rates_[j];
    }
    state_rate(t_ + h, next_, stage_rates_[dop853::stages]);
    double fifth = 0, third = 0;
    for (int i = 0; i < 2 * n_; ++i) {
      const double scale = tolerance_ * (1 + std::max(std::fabs(y_[i]), std::fabs(next_[i])));
      double e5 = 0, e3 = 0;
      for (int j = 0; j <= dop853::stages; ++j) {
        e5 += dop853::E5[j] * stage_rates_[j][i];
        e3 += dop853::E3[j] * stage_rates_[j][i];
      }
      fifth += e5 * e5 / (scale * scale);
      third += e3 * e3 / (scale * scale);
    }
    return fifth == 0 && third == 0 ? 0 : h * fifth / std::sqrt((fifth + 0.01 * third) * 2 * n_);
  }
  void accept(double h) {
    t_ += h;
    ++steps_;
    y_ = next_;
    if (!model_.has_loops()) {
      stage_rates_[0].swap(stage_rates_[dop853::stages]);
      return;
    }
    VectorXd q = y_.head(n_), v = y_.tail(n_);
    model_.project(q, v);
    y_ << q, v;
    state_rate(t_, y_, stage_rates_[0]);
  }

  PinocchioModel& model_;
  int n_;
  double tolerance_, t_ = 0, step_ = 0;
  long steps_ = 0;
  std::vector<VectorXd> stage_rates_;
  VectorXd y_, next_, between_, q_, v_, vdot_;
};
