// SPDX-License-Identifier: BSD-3-Clause
#include "touch/touch_decision.h"

#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Of friction that reaches its limit, this fraction counts as slipping, so that what breaks away at the same instant
// does so together; and what the solution of a cone problem may be short of a limit.
constexpr double break_away_fraction = 1e-9;
constexpr double limit_fraction = 1e-10;
// Relative accelerations of what breaks away at this instant are larger than this fraction of the largest.
constexpr double least_acceleration = 1e-12;
// Normal forces below this fraction of the largest are none.
constexpr double least_force = 1e-9;
// Errors of accelerations relative to the largest: of a solution of the cone problem, and where one is checked.
constexpr double cone_tolerance = 1e-13;
constexpr double acceleration_tolerance = 1e-8;
// Repetitions with the friction of what slides, which follows from the normal forces.
constexpr int most_repetitions = 200;
constexpr int most_iterations = 500;
// The energy that an impact may gain by rounding, relative to what it exchanges.
constexpr double energy_rounding = 1e-12;
constexpr int most_bisections = 40;

Cone cone_of(const TouchEquations::Entry& entry, const std::array<double, contact_groups>& coefficients) {
  Cone cone;
  cone.first = entry.first;
  cone.tangential = entry.rows[0] < 0 ? 0 : 2;
  cone.spin = entry.rows[1] < 0 ? 0 : 1;
  cone.roll = entry.rows[2] < 0 ? 0 : 2;
  cone.friction = coefficients[0];
  cone.spinning = coefficients[1];
  cone.rolling = coefficients[2];
  return cone;
}

void symmetrize(Eigen::MatrixXd& G) { G = Eigen::MatrixXd((G + G.transpose()) / 2); }

}  // namespace

ContactImpact::ContactImpact(TouchEquations& touch, const std::vector<int>& spots, const double* v, double slow) {
  touch.build(spots, touch.modes(), false, rows_);
  touch.respond(rows_.R, Z_);
  G_ = rows_.R * Z_;
  symmetrize(G_);
  speeds_ = rows_.R * Eigen::Map<const VectorXd>(v, rows_.R.cols()) + rows_.demanded;
  approach_.setZero(static_cast<Index>(spots.size()));
  restitution_.setZero(approach_.size());
  x_.setZero(speeds_.size());
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const TouchEquations::Entry& entry = rows_.entries[i];
    const auto at = static_cast<Index>(i);
    approach_[at] = speeds_[entry.first];
    if (approach_[at] < -slow) restitution_[at] = touch.law(entry.spot).restitution;
    std::array<double, contact_groups> coefficients{};
    for (int g = 0; g < contact_groups; ++g) {
      const bool slips = entry.slip[static_cast<std::size_t>(g)].norm() > slow;
      coefficients[static_cast<std::size_t>(g)] = touch.coefficient(entry.spot, g, slips);
    }
    cones_.push_back(cone_of(entry, coefficients));
  }
}

bool ContactImpact::solve(ConeSolver& solver, double part) {
  VectorXd b = speeds_;
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    const auto at = static_cast<Index>(i);
    b[cones_[i].first] += part * restitution_[at] * std::min(0.0, approach_[at]);
  }
  const double fastest = b.cwiseAbs().maxCoeff();
  ConeOptions options;
  options.tolerance = cone_tolerance * fastest;
  options.max_iterations = most_iterations;
  const DenseConeOperator G(G_);
  const std::span<const double> right(b.data(), static_cast<std::size_t>(b.size()));
  const ConeResult result = solver.solve({G, right, cones_, true}, options, x_.data());
  return result.residual <= acceleration_tolerance * fastest;
}

// That the impulses add.
double ContactImpact::energy() const {
  const double before = x_.dot(speeds_);
  const double change = x_.dot(G_ * x_) / 2;
  const double added = before + change;
  return added > energy_rounding * (std::abs(before) + change) ? added : 0;
}

// Where Newton's law would add energy, as it may with friction (Kane & Levinson 1985), restitution is reduced.
bool ContactImpact::solve(ConeSolver& solver) {
  x_.setZero();
  if (!solve(solver, 1)) return false;
  if (energy() <= 0) return true;
  double low = 0;
  double high = 1;
  for (int k = 0; k < most_bisections; ++k) {
    const double middle = (low + high) / 2;
    (solve(solver, middle) && energy() <= 0 ? low : high) = middle;
  }
  return solve(solver, low);
}

VectorXd ContactImpact::rebounds() const {
  const VectorXd after = speeds_ + G_ * x_;
  VectorXd out(approach_.size());
  for (std::size_t i = 0; i < cones_.size(); ++i) out[static_cast<Index>(i)] = after[cones_[i].first];
  return out;
}

VectorXd ContactImpact::accelerations(const double* vdot) const {
  VectorXd out(approach_.size());
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    const int row = cones_[i].first;
    out[static_cast<Index>(i)] =
        rows_.R.row(row).dot(Eigen::Map<const VectorXd>(vdot, rows_.R.cols())) + rows_.rates[row];
  }
  return out;
}

void ContactImpact::apply(double* v) const { Eigen::Map<VectorXd>(v, Z_.rows()) += Z_ * x_; }

ContactDecision::ContactDecision(TouchEquations& touch)
    : touch_(touch), solver_(make_cone_solver(cone_solver_kinds().front().name)) {}

// What has let go has no force, at first.
void ContactDecision::set_cones(const std::vector<Trigger>& triggered) {
  cones_.clear();
  for (std::size_t i = 0; i < rows_.entries.size(); ++i) {
    const TouchEquations::Entry& entry = rows_.entries[i];
    std::array<double, contact_groups> coefficients{};
    for (int group = 0; group < contact_groups; ++group) {
      const auto g = static_cast<std::size_t>(group);
      coefficients[g] = touch_.coefficient(entry.spot, group, slides_[i][g]);
      if (triggered[static_cast<std::size_t>(entry.spot)].groups[g]) coefficients[g] *= 1 - break_away_fraction;
    }
    const Cone cone = cone_of(entry, coefficients);
    if (opens_[i] == 0) {
      cones_.push_back(cone);
    } else {
      for (int k = 0; k < cone.size(); ++k) cones_.push_back(Cone::within(cone.first + k, 0, 0));
    }
  }
}

// normal: the normal forces from which the friction of what slides follows.
void ContactDecision::solve_cones(const VectorXd& normal) {
  const VectorXd b = b_ + C_ * normal;
  ConeOptions options;
  options.tolerance = cone_tolerance * scale_;
  options.max_iterations = most_iterations;
  const DenseConeOperator G(G_);
  const std::span<const double> right(b.data(), static_cast<std::size_t>(b.size()));
  solver_->solve({G, right, cones_, true}, options, x_.data());
}

std::vector<SpotMode> ContactDecision::modes_of_solution(const std::vector<SpotMode>& tentative,
                                                         const std::vector<Trigger>& triggered) const {
  std::vector<SpotMode> next = tentative;
  const VectorXd normal = normal_forces();
  const double largest = std::max(0.0, normal.maxCoeff());
  const VectorXd a = G_ * x_ + C_ * normal + b_;
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    const TouchEquations::Entry& entry = rows_.entries[i];
    SpotMode& mode = next[static_cast<std::size_t>(spots_[i])];
    const double n = x_[entry.first];
    mode.closed = n > least_force * largest || (opens_[i] == 0 && a[entry.first] <= limit_fraction * scale_);
    if (!mode.closed) continue;
    for (int group = 0; group < contact_groups; ++group) {
      const auto g = static_cast<std::size_t>(group);
      if (entry.rows[g] < 0) continue;
      mode.groups[g].moves = false;
      mode.groups[g].direction.setZero();
      const bool is_triggered = triggered[static_cast<std::size_t>(entry.spot)].groups[g];
      if (n > least_force * largest) find_motion(i, group, a, is_triggered, mode);
    }
  }
  return next;
}

// Whether friction of a group is at its limit, and what moves against it.
void ContactDecision::find_motion(std::size_t i, int group, const VectorXd& a, bool is_triggered,
                                  SpotMode& mode) const {
  const TouchEquations::Entry& entry = rows_.entries[i];
  const auto g = static_cast<std::size_t>(group);
  const auto part = x_.segment(entry.rows[g], entry.kept(group));
  const double limit = touch_.coefficient(entry.spot, group, slides_[i][g]) * x_[entry.first];
  const double size = part.norm();
  if (!(size >= limit * (1 - 2 * break_away_fraction) && size > 0)) return;
  // Redundant forces may be at their limits although nothing moves.
  const double along = -part.dot(a.segment(entry.rows[g], entry.kept(group))) / size;
  if (!(along > (is_triggered ? least_acceleration : limit_fraction) * scale_)) return;
  mode.groups[g].moves = true;
  for (Index k = 0; k < part.size(); ++k)
    mode.groups[g].direction -= part[k] / size * entry.axes.col((group == 1 ? 0 : 1) + k);
}

VectorXd ContactDecision::normal_forces() const {
  VectorXd out(static_cast<Index>(spots_.size()));
  for (std::size_t i = 0; i < spots_.size(); ++i) out[static_cast<Index>(i)] = x_[rows_.entries[i].first];
  return out;
}

// The closed contact with the most negative normal force; -1: none.
int ContactDecision::most_pulling() const {
  double largest = 0;
  const auto& forces = touch_.forces();
  for (const auto& force : forces) largest = std::max(largest, std::abs(force.normal));
  double least = -acceleration_tolerance * largest;
  int out = -1;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    if (!(forces[i].normal < least)) continue;
    least = forces[i].normal;
    out = touch_.closed()[i];
  }
  return out;
}

// Whether a spot is accelerated as its mode permits. relative: by row.
bool ContactDecision::obeys(std::size_t i, const SpotMode& mode, const VectorXd& relative) const {
  const TouchEquations::Entry& entry = rows_.entries[i];
  const double tolerance = acceleration_tolerance * scale_;
  if (!mode.closed) return !(relative[entry.first] < -tolerance);
  for (int group = 0; group < contact_groups; ++group) {
    const auto g = static_cast<std::size_t>(group);
    if (entry.rows[g] < 0 || !mode.groups[g].moves) continue;
    double along = 0;
    for (Index k = 0; k < entry.kept(group); ++k)
      along += relative[entry.rows[g] + k] * entry.axes.col((group == 1 ? 0 : 1) + k).dot(mode.groups[g].direction);
    if (along < -tolerance) return false;
  }
  return true;
}

// Whether accelerations in these modes obey the laws. pulls: see most_pulling().
bool ContactDecision::check(const double* vdot, const std::vector<SpotMode>& next, int& pulls) {
  touch_.set_modes(next);
  VectorXd a = Eigen::Map<const VectorXd>(vdot, rows_.R.cols());
  touch_.accelerate(a.data());
  pulls = most_pulling();
  if (pulls >= 0 || !a.allFinite()) return false;
  const VectorXd relative = rows_.R * a + rows_.rates;
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    if (!obeys(i, next[static_cast<std::size_t>(spots_[i])], relative)) return false;
  }
  return true;
}

// Drops closed contacts that would pull until none does.
bool ContactDecision::refine(const double* vdot, std::vector<SpotMode>& next) {
  for (std::size_t k = 0; k <= spots_.size(); ++k) {
    int pulls = -1;
    if (check(vdot, next, pulls)) return true;
    if (pulls < 0) return false;
    next[static_cast<std::size_t>(pulls)].closed = false;
  }
  return false;
}

// Static friction that does not hold becomes sliding friction, which may be less; returns whether it is.
bool ContactDecision::let_slide(const std::vector<SpotMode>& tentative, const std::vector<SpotMode>& next) {
  bool changed = false;
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    const int spot = spots_[i];
    const auto at = static_cast<std::size_t>(spot);
    for (std::size_t g = 0; g < contact_groups; ++g) {
      const bool begins = next[at].closed && next[at].groups[g].moves && !tentative[at].groups[g].moves;
      if (!begins || slides_[i][g]) continue;
      slides_[i][g] = true;
      const int group = static_cast<int>(g);
      changed = changed || touch_.coefficient(spot, group, true) != touch_.coefficient(spot, group, false);
    }
    if (opens_[i] == 0) continue;
    const double leaving = (G_ * x_ + C_ * normal_forces() + b_)[rows_.entries[i].first];
    if (leaving >= -acceleration_tolerance * scale_) continue;
    opens_[i] = 0;
    changed = true;
  }
  return changed;
}

ContactDecision::Outcome ContactDecision::decide(const std::vector<int>& spots, const std::vector<Trigger>& triggered,
                                                 const double* vdot, std::vector<SpotMode>& next) {
  const std::vector<SpotMode> tentative = next;
  spots_ = spots;
  touch_.build(spots, tentative, true, rows_);
  TouchEquations::RowMatrix Z;
  touch_.respond(rows_.R, Z);
  G_ = rows_.R * Z;
  symmetrize(G_);
  C_.setZero(rows_.R.rows(), static_cast<Index>(spots.size()));
  if (rows_.any_moves()) {
    touch_.respond(rows_.D, Z);
    C_ = rows_.R * Z;
  }
  const Eigen::Map<const VectorXd> free(vdot, rows_.R.cols());
  b_ = rows_.R * free + rows_.rates;
  scale_ = std::max(b_.cwiseAbs().maxCoeff(), (rows_.R.cwiseAbs() * free.cwiseAbs()).maxCoeff());
  slides_.assign(spots.size(), {});
  opens_.assign(spots.size(), 0);
  for (std::size_t i = 0; i < spots.size(); ++i) {
    opens_[i] = triggered[static_cast<std::size_t>(spots[i])].leaves ? 1 : 0;
  }
  x_.setZero(b_.size());
  VectorXd normal = VectorXd::Zero(static_cast<Index>(spots.size()));
  Outcome outcome = Outcome::none;
  for (int k = 0; k < most_repetitions; ++k) {
    set_cones(triggered);
    solve_cones(normal);
    next = modes_of_solution(tentative, triggered);
    if (let_slide(tentative, next)) continue;
    if (refine(vdot, next)) return Outcome::found;
    const VectorXd before = normal;
    normal = normal_forces();
    if (!normal.allFinite()) break;
    if ((normal - before).cwiseAbs().maxCoeff() > limit_fraction * normal.cwiseAbs().maxCoeff()) continue;
    outcome = Outcome::ambiguous;
    break;
  }
  return outcome;
}

}  // namespace gelenk
