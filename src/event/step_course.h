// SPDX-License-Identifier: BSD-3-Clause
// Event indicators over one step, interpolated from their values at its ends.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include "event/cubic.h"
#include "event/event_source.h"
#include "util/archive.h"

namespace gelenk {

// An indicator this close to zero is zero: the rounding of coordinates and velocities of order 1 [natural units]. What
// crosses zero slowly passes it so soon that its sign would be that of rounding.
inline constexpr double indicator_rounding = 4 * std::numeric_limits<double>::epsilon();

class StepCourse {
 public:
  explicit StepCourse(EventSource& source);

  std::size_t size() const { return g_.size(); }
  // Set the start and the end of the step; begin() returns whether y has changed (EventSource::recall_mode).
  bool begin(double t, double* y);
  void end(double t, const double* y);

  // During its lifetime the zero of indicator i is searched for, in steps that become as short as rounding: near the
  // start of one that leaves zero slowly its sign counts, however small it is.
  class Search {
   public:
    Search(StepCourse& course, std::size_t i) : course_(course) { course_.searched_ = i; }
    ~Search() { course_.searched_ = none; }
    Search(const Search&) = delete;
    Search& operator=(const Search&) = delete;

   private:
    StepCourse& course_;
  };

  double start() const { return start_t_; }           // s
  double end() const { return t_; }                   // s
  const bool* mode() const { return before_.get(); }  // flags of the indicators that are positive at its start
  double at_start(std::size_t i) const { return start_g_[i]; }
  // With the sign of positive(i), also where the indicator is exactly zero.
  double at_end(std::size_t i) const;
  double rate_at_end(std::size_t i) const { return gdot_[i]; }
  bool positive(std::size_t i) const { return after_[i]; }  // at its end
  bool changed(std::size_t i) const { return after_[i] != before_[i]; }
  bool any_changed() const;

  // s: zero of indicator i, which has changed its sign, by the cubic through its values and rates at both ends, or
  // linear if rates are unknown.
  double zero(std::size_t i) const;
  // s: earliest time at which one of the first indicators with the same sign at both ends may have reached zero;
  // infinite: none.
  double touch(std::size_t count) const;

  // Where the step began.
  void serialize(Archive& archive);

 private:
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  Cubic cubic(std::size_t i) const;

  EventSource& source_;
  std::size_t searched_ = none;
  double start_t_ = 0, t_ = 0;  // s
  std::vector<double> start_g_, start_gdot_, g_, gdot_;
  std::unique_ptr<bool[]> before_, after_;  // by indicator: positive at the start, at the end
};

}  // namespace gelenk
