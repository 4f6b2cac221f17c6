// SPDX-License-Identifier: BSD-3-Clause
// How many evaluations of the equations of motion an advance may take.
#pragma once

#include <climits>

namespace gelenk {

// What one advance is permitted.
struct Allowance {
  long evaluations = LONG_MAX;
  // Also ends it where its progress since the last review would need `hopeless` times as many.
  bool at_pace = false;
};

class EvaluationBudget {
 public:
  // Between reviews of the progress: enough for a singular configuration, an event or a series of impacts, a part of a
  // second even in the scenes that cost most.
  static constexpr long between_reviews = 50'000;
  static constexpr double hopeless = 10;

  // From time t [s] and after `now` evaluations to `end` [s].
  void begin(const Allowance& allowed, long now, double t, double end) {
    last_ = allowed.evaluations < LONG_MAX - now ? now + allowed.evaluations : LONG_MAX;
    hopeless_ = hopeless * static_cast<double>(allowed.evaluations);
    begun_ = now;
    end_ = end;
    time_ = t;
    next_review_ = allowed.at_pace ? now + between_reviews : LONG_MAX;
  }
  // A step has ended at t [s].
  void reached(long now, double t) {
    if (now < next_review_) return;
    const auto used = static_cast<double>(now - (next_review_ - between_reviews));
    if ((end_ - t) * used > (hopeless_ - static_cast<double>(now - begun_)) * (t - time_)) last_ = now;
    time_ = t;
    next_review_ = now + between_reviews;
  }
  bool is_exhausted(long now) const { return now >= last_; }

 private:
  long last_ = LONG_MAX, next_review_ = LONG_MAX, begun_ = 0;
  double hopeless_ = 0, end_ = 0, time_ = 0;
};

}  // namespace gelenk
