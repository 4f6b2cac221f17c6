// SPDX-License-Identifier: BSD-3-Clause
// Compiled on its own, with vectorized loops: cmake/GelenkPython.cmake.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "batch/block_steps.h"

// Loops over lanes, chosen when the module is loaded: with the same bits, as lanes/kernels.h says. Sanitizers are not
// yet at work then.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define GELENK_BY_PROCESSOR [[gnu::target_clones("avx2", "default")]]
#else
#define GELENK_BY_PROCESSOR
#endif

namespace gelenk {
namespace {

constexpr int W = BlockSteps::lanes;

// Of a pivot where pivots were chosen: below it, errors of accelerations grow with its inverse square.
constexpr double least_constraint_pivot = 0.03;
// Masses, seen from a joint, vary a lot.
constexpr double least_mass_pivot = 1e-8;

// As in formulation/constraint_projector.cpp.
constexpr double closure_tolerance = 1e-14;
constexpr int most_projections = 30;
constexpr double stall_ratio = 0.5;
constexpr double renewal_ratio = 0.1;
constexpr double slack = 1e3;

lanes::Instruction scaled_sum(int to, double k, int a, int c) {
  return {.code = lanes::Code::scale_add, .to = to, .a = a, .c = c, .k = k};
}

lanes::Instruction copied(int to, int a) { return {.code = lanes::Code::copy, .to = to, .a = a}; }

}  // namespace

BlockSteps::BlockSteps(const StepPrograms& programs, double length, double step)
    : programs_(programs),
      length_(length),
      step_(step),
      storage_(static_cast<std::size_t>(programs.frame.size() + 1) * W),
      kept_(static_cast<std::size_t>(programs.factors) * W) {
  void* first = storage_.data();
  std::size_t space = storage_.size() * sizeof(double);
  constexpr std::size_t alignment = 64;
  memory_ = static_cast<double*>(std::align(alignment, space - alignment, first, space));
  for (const auto& [number, value] : programs.frame.constants()) std::fill_n(slot(number), W, value);
  const StepSlots& at = programs.slots;
  const auto each = [&](auto add) {
    for (int i = 0; i < programs.size(); ++i)
      add(at.y + i, programs.rate_slots[static_cast<std::size_t>(i)], at.before + i, at.sum + i);
  };
  // The rates of coordinates may be velocities: these are changed last.
  each([&](int y, int, int before, int) { begin_.push_back(copied(before, y)); });
  each([&](int, int rate, int, int sum) { first_.push_back(copied(sum, rate)); });
  each([&](int, int rate, int, int sum) { middle_.push_back(scaled_sum(sum, 2, rate, sum)); });
  each([&](int, int rate, int, int sum) {
    last_.push_back({.code = lanes::Code::add, .to = sum, .a = sum, .b = rate});
  });
  third_ = middle_;
  each([&](int y, int rate, int before, int) {
    first_.push_back(scaled_sum(y, 0.5 * step, rate, before));
    middle_.push_back(scaled_sum(y, 0.5 * step, rate, before));
    third_.push_back(scaled_sum(y, step, rate, before));
  });
  each([&](int y, int, int before, int sum) { last_.push_back(scaled_sum(y, step / 6, sum, before)); });
  last_pivots_.resize(programs.guards.size() * W);
}

void BlockSteps::evaluate(double time) {
  if (programs_.reads_time) std::fill_n(slot(programs_.slots.time), W, time);
  time_ = time;
  run(has_gaps_ ? programs_.evaluate_closed : programs_.evaluate);
  has_gaps_ = false;
}

void BlockSteps::limits_of(double* limits) {
  for (std::size_t g = 0; g < programs_.guards.size(); ++g) {
    const double least = programs_.guards[g].is_mass ? least_mass_pivot : least_constraint_pivot;
    const double* const reciprocal = slot(programs_.guards[g].slot);
    for (int l = 0; l < W; ++l) limits[g * W + static_cast<std::size_t>(l)] = reciprocal[l] / least;
  }
}

bool BlockSteps::is_finite(std::size_t lane) {
  for (int i = 0; i < programs_.size(); ++i) {
    if (!std::isfinite(slot(programs_.slots.y + i)[lane])) return false;
  }
  return true;
}

GELENK_BY_PROCESSOR void BlockSteps::check_pivots(const double* limits, Stops& stops) {
  for (std::size_t g = 0; g < programs_.guards.size(); ++g) {
    const double* const reciprocal = slot(programs_.guards[g].slot);
    const double* const limit = limits + g * W;
    double* const last = last_pivots_.data() + g * W;
    if (!has_pivots_) std::copy_n(reciprocal, W, last);
    std::int64_t any = 0;
    for (std::size_t l = 0; l < W; ++l)
      any |= std::abs(reciprocal[l]) <= std::abs(limit[l]) && reciprocal[l] * last[l] > 0 ? 0 : 1;
    for (std::size_t l = 0; any != 0 && l < W; ++l) {
      const bool is_regular = std::abs(reciprocal[l]) <= std::abs(limit[l]) && reciprocal[l] * last[l] > 0;
      if (is_regular || stops[l] != StopReason::none) continue;
      stops[l] = programs_.guards[g].is_mass ? StopReason::massless : StopReason::singular;
      if (std::isnan(reciprocal[l]) && !is_finite(l)) stops[l] = StopReason::not_finite;
      broken_[l] = static_cast<int>(g);
    }
    std::copy_n(reciprocal, W, last);
  }
  has_pivots_ = true;
}

GELENK_BY_PROCESSOR BlockSteps::Numbers BlockSteps::largest(int first, int count, double least) {
  Numbers out;
  out.fill(least);
  for (int i = 0; i < count; ++i) {
    const double* const x = slot(first + i);
    for (std::size_t l = 0; l < W; ++l) {
      const double size = std::abs(x[l]);
      out[l] = size <= out[l] ? out[l] : size;  // keeps NaN
    }
  }
  return out;
}

void BlockSteps::normalize() {
  for (const int first : programs_.quaternions) {
    double* const a = slot(programs_.slots.y + first);
    for (int l = 0; l < W; ++l) {
      const double x = a[l];
      const double y = a[l + W];
      const double z = a[l + 2 * W];
      const double w = a[l + 3 * W];
      const double length = std::sqrt(x * x + y * y + z * z + w * w);
      for (int k = 0; k < 4; ++k) a[l + k * W] /= length;
    }
  }
}

// Factors at the present state for some lanes.
void BlockSteps::renew_factors(const std::array<bool, lanes>& renews) {
  const double* const factors = slot(programs_.slots.factors);
  std::copy_n(factors, kept_.size(), kept_.begin());
  has_gaps_ = false;
  evaluate(time_);
  ++renewals_;
  double* const now = slot(programs_.slots.factors);
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    if (!renews[i % W]) now[i] = kept_[i];
  }
}

GELENK_BY_PROCESSOR void BlockSteps::correct_positions(const std::array<bool, lanes>& waits) {
  run(programs_.displace);
  if (!programs_.rates_are_velocities) run(programs_.move);
  const int by = programs_.rates_are_velocities ? programs_.slots.displacement : programs_.slots.moved;
  for (int k = 0; k < programs_.nq; ++k) {
    double* const q = slot(programs_.slots.y + k);
    const double* const dq = slot(by + k);
    for (std::size_t l = 0; l < W; ++l) q[l] = waits[l] ? q[l] : q[l] + dq[l];
  }
  if (!programs_.quaternions.empty()) normalize();
  run(programs_.gaps);
}

GELENK_BY_PROCESSOR void BlockSteps::correct_velocities(const std::array<bool, lanes>& waits) {
  std::copy_n(slot(programs_.slots.rate), static_cast<std::ptrdiff_t>(programs_.rows) * W, slot(programs_.slots.Phi));
  run(programs_.displace);
  for (int k = 0; k < programs_.nv; ++k) {
    double* const v = slot(programs_.slots.y + programs_.nq + k);
    const double* const dv = slot(programs_.slots.displacement + k);
    for (std::size_t l = 0; l < W; ++l) v[l] = waits[l] ? v[l] : v[l] + dv[l];
  }
  run(programs_.gap_rates);
}

// What an iteration knows of each lane.
struct BlockSteps::Closing {
  Numbers before, floor;
  std::array<bool, lanes> waits{}, renews{};
  bool any_open = false, any_renews = false;

  // Which lanes are closed, or have to stop; the others need a correction, some with renewed factors.
  void judge(const Numbers& gap, bool is_last, Stops& stops);
};

GELENK_BY_PROCESSOR void BlockSteps::Closing::judge(const Numbers& gap, bool is_last, Stops& stops) {
  renews.fill(false);
  any_open = any_renews = false;
  for (std::size_t l = 0; l < W; ++l) {
    if (waits[l]) continue;
    const bool stalls = gap[l] > stall_ratio * before[l] && gap[l] <= slack * floor[l];
    waits[l] = gap[l] <= floor[l] || stalls;
    if (waits[l]) continue;
    if (is_last || !std::isfinite(gap[l])) {
      stops[l] = std::isfinite(gap[l]) ? StopReason::open : StopReason::not_finite;
      waits[l] = true;
      continue;
    }
    renews[l] = gap[l] > renewal_ratio * before[l];
    any_renews = any_renews || renews[l];
    any_open = true;
    before[l] = gap[l];
  }
}

// Newton's method, until the residual of each lane is rounding.
template <class Correct>
void BlockSteps::close(int residual, const Numbers& floor, Stops& stops, Correct correct) {
  Closing closing{.before = {}, .floor = floor};
  closing.before.fill(std::numeric_limits<double>::infinity());
  for (std::size_t l = 0; l < W; ++l) closing.waits[l] = stops[l] != StopReason::none;
  for (int i = 0;; ++i) {
    const Numbers gap = largest(residual, programs_.rows, 0);
    std::int64_t any = 0;
    for (std::size_t l = 0; l < W; ++l) any |= gap[l] <= floor[l] ? 0 : 1;
    if (any == 0) return;
    closing.judge(gap, i == most_projections, stops);
    if (!closing.any_open) return;
    if (closing.any_renews) renew_factors(closing.renews);
    correct(closing.waits);
  }
}

void BlockSteps::close_positions(Stops& stops) {
  run(programs_.gaps);
  Numbers floor = largest(programs_.slots.y, programs_.nq, 0);
  for (double& x : floor) x = length_ * std::max(closure_tolerance, 2e-16 * x);  // of many revolutions
  close(programs_.slots.Phi, floor, stops, [&](const std::array<bool, lanes>& waits) { correct_positions(waits); });
}

void BlockSteps::close_velocities(Stops& stops) {
  run(programs_.gap_rates);
  Numbers floor = largest(programs_.slots.y + programs_.nq, programs_.nv, 1);
  for (double& x : floor) x *= closure_tolerance * length_;
  close(programs_.slots.rate, floor, stops, [&](const std::array<bool, lanes>& waits) { correct_velocities(waits); });
}

GELENK_BY_PROCESSOR void BlockSteps::step(double time, const double* limits, Stops& stops) {
  lanes::run(begin_, memory_);
  evaluate(time);
  if (!has_pivots_) check_pivots(limits, stops);
  lanes::run(first_, memory_);
  evaluate(time + 0.5 * step_);
  lanes::run(middle_, memory_);
  evaluate(time + 0.5 * step_);
  lanes::run(third_, memory_);
  evaluate(time + step_);
  lanes::run(last_, memory_);
  check_pivots(limits, stops);
  if (!programs_.quaternions.empty()) normalize();
  if (programs_.rows > 0) {
    close_positions(stops);
    close_velocities(stops);
  }
  has_gaps_ = programs_.rows > 0;
  Numbers zero{};
  for (int i = 0; i < programs_.size(); ++i) {
    const double* const y = slot(programs_.slots.y + i);
    for (std::size_t l = 0; l < W; ++l) zero[l] += y[l] * 0;
  }
  int any = 0;
  for (std::size_t l = 0; l < W; ++l) any |= static_cast<int>(stops[l]) | (zero[l] == 0 ? 0 : 1);
  if (any == 0) return;
  for (std::size_t l = 0; l < W; ++l) {
    if (!(zero[l] == 0) && stops[l] == StopReason::none) stops[l] = StopReason::not_finite;
  }
  for (int i = 0; i < programs_.size(); ++i) {
    double* const y = slot(programs_.slots.y + i);
    const double* const before = slot(programs_.slots.before + i);
    for (std::size_t l = 0; l < W; ++l) y[l] = stops[l] == StopReason::none ? y[l] : before[l];
  }
}

}  // namespace gelenk
