// SPDX-License-Identifier: BSD-3-Clause
// `projection`: the index-1 form
//   qdot = N v,   [M J^T; J 0] [vdot; lambda] = [tau - h; gamma],
// with q and v put back on Phi = 0, J v = 0 after every accepted step by the smallest correction in the mass
// metric (Eich 1993; Blajer 2002), so that neither drifts. Factors of the last evaluation are reused. Through singular
// positions the accelerations in the weak direction are carried on from before.
#include <algorithm>
#include <cmath>

#include "formulation/branch_acceleration.h"
#include "formulation/formulation.h"

namespace gelenk {
namespace {

// Passing a singular position (a change point, a dead centre). Beside it the weak direction's part of vdot is a
// quotient of two numbers that vanish together, and what is left of rounding and of the step's error in it moves the
// mechanism onto another branch; smaller steps only land nearer. So, as shares of the soundest pivot ratio seen:
constexpr double near_fraction = 0.5;     // below it the accelerations of accepted steps are remembered
constexpr double regular_fraction = 0.1;  // below it no more: now they are extrapolated ...
constexpr double spacing = 0.05;          // ... from shares that are apart by this, for the polynomial to reach far
constexpr double most_weak = 0.02;        // ... and near and below a share of weak_share() they stand in along the weak
constexpr double least_weak = 0.001;      //     direction; the less, the better they are known
constexpr double unknown_weak = 0.003;    //     nothing tells how well
constexpr double row_noise = 1e-14;
constexpr double lost_share = 1e-5;  // below this even the weak direction is rounding
constexpr double most_magnified = 1e4;
// With these N-four-bars of 1, 2, 10 and 40 windows keep to their branch for 20 s (56 passages) within 3e-7 m at
// tolerances 1e-6 to 1e-10; three times as large or small serve nearly as well.

// Of the rows' errors, relative to the mechanism's size, where nothing else is left. At 8e-16 an engine with six loops
// takes a hundred times the steps of cvode at 1e-10.
constexpr double row_rounding = 3e-16;

// The share below which accelerations that are expected with this error stand in. What the rows say there is wrong by
// row_noise / share^3: rounding moves a state off its branch by 1e-16 / share, its velocities by that over the share
// again, and so on.
double weak_fraction(double error, double size) {
  if (!(error * most_weak * most_weak * most_weak > row_noise * size)) return most_weak;
  return std::max(least_weak, std::cbrt(row_noise * size / error));
}

// Corrects by the least step in the mass metric, along weak directions only as far as these are sound.
class WeakRowCorrector final : public Corrector {
 public:
  // soundest: largest pivot ratio known before the run.
  WeakRowCorrector(const Mechanism& mechanism, Dynamics& dynamics, double best_pivot_ratio)
      : Corrector(mechanism, dynamics), best_known_pivot_ratio_(best_pivot_ratio) {}

  // The last factors are not near a singular position.
  bool sound() const { return sound_; }
  // Of the soundest seen.
  double share() const { return dynamics_.pivot_ratio() / best_pivot_ratio_; }
  bool below(double share) const { return dynamics_.pivot_ratio() < share * best_pivot_ratio_; }
  // Where a run begins: whether that is beside a singular position, as far as is known from before it.
  void judge_start() {
    if (!(dynamics_.pivot_ratio() < regular_fraction * best_known_pivot_ratio_)) return;
    best_pivot_ratio_ = std::max(best_pivot_ratio_, best_known_pivot_ratio_);
    update_singularity_status();
  }
  void update_singularity_status() {
    sound_ = !below(regular_fraction);
    set_weak(sound_ ? 0 : unknown_weak);
  }
  void factors_changed() override { update_singularity_status(); }
  void set_weak(double share) {
    if (!rigorous_ || share == 0) dynamics_.set_singular_threshold(share * best_pivot_ratio_);
  }
  // A long step may have left more along a weak direction than may stay.
  bool close_rigorously(double* q, double* v) {
    rigorous_ = true;
    dynamics_.set_singular_threshold(0);
    refactor();
    const bool closed = close_position(q) && close_velocity(v);
    rigorous_ = false;
    return closed;
  }
  void serialize(Archive& archive) { archive.serialize(best_pivot_ratio_); }

 private:
  void refactor() override {
    dynamics_.factorize();
    best_pivot_ratio_ = std::max(best_pivot_ratio_, dynamics_.pivot_ratio());
    update_singularity_status();
  }
  // Along weak directions what is left is small by itself, and leads back where the rows are sound again.
  double slack() const override { return sound_ ? Corrector::slack() : 1e8; }

  double best_known_pivot_ratio_;
  double best_pivot_ratio_ = 0;  // pivot ratio seen in the run, or known where it begins beside a singular position
  bool sound_ = true;
  bool rigorous_ = false;  // weak directions are corrected in full
};

class Projection final : public Formulation {
 public:
  explicit Projection(const FormulationContext& context)
      : Formulation(context),
        corrections_(context.options.corrections),
        move_(mechanism_.nv),
        rows_(mechanism_, dynamics_, context.options.best_pivot_ratio),
        expected_(mechanism_.nv),
        before_(mechanism_.nv),
        after_(mechanism_.nv),
        seen_(context.inputs) {
    jacobians_.of_rows = false;
    for (const Link& link : mechanism_.links) finest_ += row_rounding * link.X_PJ.p.norm();
    for (auto& acceleration : accelerations_) acceleration.resize(mechanism_.nv);
  }
  bool project(double t, double* y) override;
  void polish(bool on) override { polishing_ = on; }
  void accepted(double t, const double* y) override;
  void start(const std::vector<double>& cut_q, double t, const double* y) override;
  void inputs_changed(double t, const double* y) override;
  void serialize(Archive& archive) override;

 private:
  Corrector& corrector() override { return rows_; }
  void solve(double t, double* vdot) override;
  const double* expected(double t);
  double lagrange(double t, int first, double* weights) const;
  void add_jump(double t);
  void launch(double t, const double* y);
  void remember(double t);
  bool min_norm_displacement(double* q, double* v);
  bool close(double* y);

  int corrections_;
  double finest_ = 0;         // m or rad: of the mechanism's size
  std::vector<double> move_;  // by a correction
  WeakRowCorrector rows_;

  // Accelerations at the last times at which the rows were sound.
  static constexpr int memory = 8;
  int remembered_ = 0;
  bool launched_ = false;  // the first of them is that of the branch on which the run has begun
  double times_[memory] = {};
  double shares_[memory] = {};  // pivot ratios there
  std::vector<double> accelerations_[memory];
  std::vector<double> expected_, before_, after_;
  Inputs seen_;  // inputs of the accelerations remembered
  bool polishing_ = false;
};

void Projection::start(const std::vector<double>& cut_q, double t, const double* y) {
  remembered_ = 0;
  launched_ = false;
  Formulation::start(cut_q, t, y);
  launch(t, y);
}

// In or beside a singular position, from which nothing is remembered, the accelerations of the branch stand in.
void Projection::launch(double t, const double* y) {
  if (mechanism_.cuts.empty() || mechanism_.rows == 0 || mechanism_.driven()) return;
  dynamics_.set_position(y);
  rows_.refactorize();
  rows_.judge_start();
  if (rows_.sound()) return;
  if (!BranchAcceleration(mechanism_, dynamics_)
           .find(y, y + mechanism_.nq, drives_.u().data(), accelerations_[0].data()))
    return;
  remembered_ = 1;
  launched_ = true;
  times_[0] = t;
  seen_ = drives_.inputs();
  dynamics_.set_position(y);
  rows_.refactorize();
  shares_[0] = rows_.share();
}

void Projection::inputs_changed(double t, const double* y) {
  if (!launched_ || remembered_ != 1 || times_[0] != t) return;
  drives_.go_to(t);
  remembered_ = 0;
  launch(t, y);
}

void Projection::serialize(Archive& archive) {
  Formulation::serialize(archive);
  rows_.serialize(archive);
  archive.serialize_in_range(remembered_, 0, memory);
  archive.serialize(launched_);
  if (remembered_ == 0) return;
  seen_.serialize(archive);
  for (int i = 0; i < remembered_; ++i) {
    archive.serialize(times_[i], shares_[i], accelerations_[i]);
  }
}

void Projection::solve(double t, double* vdot) {
  const double* known = expected(t);
  dynamics_.solve(drives_.u().data(), vdot, known);
  // Where the last pivot is rounding, so is the direction along which to follow.
  if (known != nullptr && rows_.below(lost_share)) std::copy_n(known, mechanism_.nv, vdot);
}

// Weights by which the accelerations remembered from `first` on make the polynomial's value at t; returns the sum of
// their absolute values.
double Projection::lagrange(double t, int first, double* weights) const {
  double sum = 0;
  for (int i = first; i < remembered_; ++i) {
    weights[i] = 1;
    for (int j = first; j < remembered_; ++j) {
      if (j != i) weights[i] *= (t - times_[j]) / (times_[i] - times_[j]);
    }
    sum += std::abs(weights[i]);
  }
  return sum;
}

// The accelerations that those remembered lead to, by a polynomial in time through as many of the latest as do not
// magnify their rounding too much; null: nothing is known.
const double* Projection::expected(double t) {
  if (rows_.sound() || remembered_ == 0) return nullptr;
  double weights[memory];
  double fewer[memory] = {};
  int first = 0;
  while (lagrange(t, first, weights) > most_magnified) ++first;  // one alone magnifies nothing
  if (first + 1 < remembered_) lagrange(t, first + 1, fewer);
  double error = 0;
  double size = 0;
  for (int k = 0; k < mechanism_.nv; ++k) {
    double sum = 0;
    double without = 0;
    for (int i = first; i < remembered_; ++i) {
      sum += weights[i] * accelerations_[i][k];
      if (i > first) without += fewer[i] * accelerations_[i][k];
    }
    expected_[k] = sum;
    error = std::max(error, std::abs(sum - without));
    size = std::max(size, std::abs(sum));
  }
  const bool told = first + 1 < remembered_;
  rows_.set_weak(told ? weak_fraction(error, size) : unknown_weak);
  if (drives_.inputs() != seen_) add_jump(t);
  return expected_.data();
}

// The inputs are no longer those functions of time: what that changes. Errors of the state, which near a singular
// position become large in vdot, are the same before and after, and cancel.
void Projection::add_jump(double t) {
  seen_.go_to(t);
  dynamics_.solve(seen_.now().data(), before_.data());
  dynamics_.solve(drives_.u().data(), after_.data());
  for (int k = 0; k < mechanism_.nv; ++k) expected_[k] += after_[k] - before_[k];
}

// Where `dynamics` stands: at the state accepted at t.
void Projection::remember(double t) {
  drives_.go_to(t);
  rows_.refactorize();
  if (!rows_.sound()) return;
  if (drives_.inputs() != seen_) {
    remembered_ = 0;
    launched_ = false;
    seen_ = drives_.inputs();
  }
  if (remembered_ > 0 && t <= times_[remembered_ - 1]) return;
  const double share = rows_.share();
  // The last one gives way to a later one as long as it stands too near to the one before.
  const bool crowded = remembered_ > 1 && std::abs(share - shares_[remembered_ - 2]) < spacing;
  if (crowded) --remembered_;
  if (remembered_ == memory) {
    std::rotate(times_, times_ + 1, times_ + memory);
    std::rotate(shares_, shares_ + 1, shares_ + memory);
    std::rotate(accelerations_, accelerations_ + 1, accelerations_ + memory);
    --remembered_;
  }
  times_[remembered_] = t;
  shares_[remembered_] = share;
  dynamics_.solve(drives_.u().data(), accelerations_[remembered_].data());
  ++remembered_;
}

// So many corrections with the factors at hand, whatever is left: each costs the same.
bool Projection::min_norm_displacement(double* q, double* v) {
  dynamics_.normalize(q);
  dynamics_.set_position(q);
  for (int i = 0; i < corrections_; ++i) {
    rows_.min_norm_displacement(dynamics_.Phi().data(), move_.data());
    dynamics_.displace(q, move_.data());
    dynamics_.set_position(q);
  }
  dynamics_.set_velocity(v);
  for (int i = 0; i < corrections_; ++i) {
    rows_.min_norm_displacement(dynamics_.row_rates().data(), move_.data());
    for (int k = 0; k < mechanism_.nv; ++k) v[k] += move_[k];
    dynamics_.set_velocity(v);
  }
  return std::ranges::all_of(dynamics_.row_rates(), [](double rate) { return std::isfinite(rate); });
}

// Newton's method stops where the gap is some tens of roundings, and so leaves anything from none to that. Divided by a
// short lever it is what multistep methods meet as noise in their error estimates, magnified by differences of order
// six. Where there is more than rounding, one more correction, with the factors at hand, takes it away.
bool Projection::close(double* y) {
  if (!rows_.close_position(y)) return false;
  double* v = y + mechanism_.nq;
  const bool polishes = (polishing_ || !rows_.sound()) && rows_.has_factors() && mechanism_.rows > 0;
  const auto left = [](const std::vector<double>& gaps) {
    double most = 0;
    for (const double gap : gaps) most = std::max(most, std::abs(gap));
    return most;
  };
  if (polishes && left(dynamics_.Phi()) > finest_) {
    if (!rows_.sound()) rows_.refactorize();
    rows_.min_norm_displacement(dynamics_.Phi().data(), move_.data());
    dynamics_.displace(y, move_.data());
    dynamics_.set_position(y);
  }
  if (!rows_.close_velocity(v)) return false;
  double speed = 1;
  for (int k = 0; k < mechanism_.nv; ++k) speed = std::max(speed, std::abs(v[k]));
  if (polishes && left(dynamics_.row_rates()) > finest_ * speed) {
    rows_.min_norm_displacement(dynamics_.row_rates().data(), move_.data());
    for (int k = 0; k < mechanism_.nv; ++k) v[k] += move_[k];
  }
  return true;
}

bool Projection::project(double t, double* y) {
  drives_.go_to(t);
  if (corrections_ > 0 && mechanism_.rows > 0) return min_norm_displacement(y, y + mechanism_.nq);
  if (!rows_.sound()) rows_.update_singularity_status();  // the last accelerations had a weak share of their own
  if (close(y)) return true;
  return !rows_.sound() && rows_.close_rigorously(y, y + mechanism_.nq);
}

void Projection::accepted(double t, const double* y) {
  Formulation::accepted(t, y);
  if (mechanism_.cuts.empty() || mechanism_.rows == 0) return;
  if (rows_.below(near_fraction)) remember(t);
}

}  // namespace

std::unique_ptr<Formulation> make_projection(const FormulationContext& context) {
  return std::make_unique<Projection>(context);
}

}  // namespace gelenk
