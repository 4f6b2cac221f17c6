// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/hidden_kinks.h"

#include <algorithm>
#include <cmath>

#include "dynamics/law_kinks.h"

namespace gelenk {
namespace {

constexpr int fewest_places = 8;
constexpr int most_places = 128;
// The distance between places is that of so many more in a step: no period that is a round part of a step has all of
// them in the same phase.
constexpr double uneven = 0.2360679774997897;
// Second difference of a smooth function from one place to the next, in units of how much it may differ in between from
// a straight line: 8; half of that for safety.
constexpr double straightness = 4;

}  // namespace

HiddenKinks::HiddenKinks(Dynamics& dynamics, ModeEquations& equations, int nq, int size)
    : dynamics_(dynamics), kinks_(dynamics.kinks()), equations_(equations), nq_(nq), course_(dynamics, size) {
  for (auto& distances : distances_) distances.resize(static_cast<std::size_t>(kinks_.count()));
}

double HiddenKinks::first(double t0, const double* y0, double t1, const double* y1) {
  course_.set_ends(y0, y1);
  double place = search(t0, t1);
  if (std::isfinite(place)) {  // along straight lines from y0 to y1; rates are needed to be sure
    equations_.rates_at(t0, y0, course_.rates(0));
    equations_.rates_at(t1, y1, course_.rates(1));
    course_.use_rates(t1 - t0);
    place = search(t0, t1);
  }
  go_to(t1, y1);
  return std::isfinite(place) ? t0 + place * (t1 - t0) : INFINITY;
}

// With as many places as the conditions need.
double HiddenKinks::search(double t0, double t1) {
  for (int places = fewest_places; places <= most_places; places *= 2) {
    const Found found = look(places, t0, t1);
    if (std::isfinite(found.place) || !found.is_doubtful) return found.place;
  }
  return INFINITY;
}

HiddenKinks::Found HiddenKinks::look(int places, double t0, double t1) {
  Found out{.place = INFINITY};
  for (int k = 1; k <= places; ++k) {
    const double s = k / (places + uneven);
    go_to(t0 + s * (t1 - t0), course_.at(s));
    std::ranges::rotate(distances_, distances_.begin() + 1);
    std::vector<double>& here = distances_.back();
    kinks_.distances(here.data());
    if (std::ranges::any_of(here, [](double d) { return d < 0; }) && kinks_.are_passed()) return {.place = s};
    out.is_doubtful = out.is_doubtful || (k > 2 && may_change_between());
  }
  return out;
}

bool HiddenKinks::may_change_between() const {
  const auto& [before, middle, after] = distances_;
  for (std::size_t i = 0; i < middle.size(); ++i) {
    const double bend = std::abs(before[i] - 2 * middle[i] + after[i]);
    if (std::min({before[i], middle[i], after[i]}) < bend / straightness) return true;
  }
  return false;
}

void HiddenKinks::go_to(double t, const double* y) {
  equations_.bring_inputs(t, y);
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + nq_);
}

}  // namespace gelenk
