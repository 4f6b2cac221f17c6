// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/hidden_changes.h"

#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

constexpr int most_places = 128;
// The distance between places is that of so many more in a step: no period that is a round part of a step has all of
// them in the same phase.
constexpr double uneven = 0.2360679774997897;
// Second differences up to this are rounding [natural units].
constexpr double rounding = 1e-10;
// Second difference of a smooth function from one place to the next, in units of how much it may differ in between from
// a straight line: 8; half of that for safety.
constexpr double straightness = 4;

}  // namespace

double HiddenChanges::first(ModeProbe& probe, int fewest, double t0, const double* y0, double t1, const double* y1) {
  for (auto& distances : distances_) distances.resize(probe.count());
  course_.set_ends(y0, y1);
  double place = search(probe, fewest, t0, t1);
  if (std::isfinite(place)) {  // along straight lines from y0 to y1; rates are needed to be sure
    equations_.rates_at(t0, y0, course_.rates(0));
    equations_.rates_at(t1, y1, course_.rates(1));
    course_.use_rates(t1 - t0);
    place = search(probe, fewest, t0, t1);
  }
  return std::isfinite(place) ? t0 + place * (t1 - t0) : INFINITY;
}

// With as many places as the distances need.
double HiddenChanges::search(ModeProbe& probe, int fewest, double t0, double t1) {
  for (int places = fewest; places <= most_places; places *= 2) {
    const Found found = look(probe, places, t0, t1);
    if (std::isfinite(found.place) || !found.is_doubtful) return found.place;
  }
  return INFINITY;
}

HiddenChanges::Found HiddenChanges::look(ModeProbe& probe, int places, double t0, double t1) {
  Found out{.place = INFINITY};
  for (int k = 1; k <= places; ++k) {
    const double s = k / (places + uneven);
    std::ranges::rotate(distances_, distances_.begin() + 1);
    std::vector<double>& here = distances_.back();
    probe.distances(t0 + s * (t1 - t0), course_.at(s), here.data());
    if (std::ranges::any_of(here, [](double d) { return d < 0; }) && probe.is_beyond(here.data())) return {.place = s};
    out.is_doubtful = out.is_doubtful || (k > 2 && may_change_between());
  }
  return out;
}

bool HiddenChanges::may_change_between() const {
  const auto& [before, middle, after] = distances_;
  for (std::size_t i = 0; i < middle.size(); ++i) {
    const double bend = std::abs(before[i] - 2 * middle[i] + after[i]);
    if (bend > rounding && std::min({before[i], middle[i], after[i]}) < bend / straightness) return true;
  }
  return false;
}

}  // namespace gelenk
