// SPDX-License-Identifier: BSD-3-Clause
#include "batch/lane_batch.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <thread>
#include <tuple>
#include <utility>

#include "util/text.h"

namespace gelenk {
namespace {

constexpr int block_lanes = BlockSteps::lanes;

// work(i) in so many threads, the first one in this.
template <class Work>
void in_threads(int count, Work work) {
  std::vector<std::thread> others;
  for (int i = 1; i < count; ++i) others.emplace_back(work, static_cast<std::size_t>(i));
  work(0);
  for (std::thread& other : others) other.join();
}

std::string in_lane(std::size_t lane) { return "lane " + std::to_string(lane) + ": "; }

}  // namespace

LaneBatch::LaneBatch(const Scene& scene, int lanes, double step, const std::vector<std::string>& parameters)
    : scene_(scene, parameters),
      lanes_(lanes),
      stride_((lanes + block_lanes - 1) / block_lanes * block_lanes),
      step_(step),
      pivots_(pivots_of(scene_.traced())),
      programs_(equations(), pivots_, scene_.numbers()) {
  const auto rows = [&](int count) {
    return std::vector<double>(static_cast<std::size_t>(count) * static_cast<std::size_t>(stride_));
  };
  state_ = start_ = rows(programs_.size());
  input_ = rows(programs_.inputs);
  numbers_ = rows(scene_.numbers());
  blocks_.resize(static_cast<std::size_t>(stride_ / block_lanes));
  for (Block& block : blocks_) {
    block.constants.resize(static_cast<std::size_t>(programs_.constants) * block_lanes);
    block.limits.resize(programs_.guards.size() * block_lanes);
  }
  for (int k = 0; k < programs_.inputs; ++k)
    std::fill_n(input_.data() + static_cast<std::ptrdiff_t>(k) * stride_, stride_,
                equations().u[static_cast<std::size_t>(k)].start);
  set({}, 1);
}

std::vector<EquationArgument> LaneBatch::inputs() const {
  return {equations().u.begin(), equations().u.begin() + equations().inputs};
}

double LaneBatch::time() const { return static_cast<double>(steps_) * step_; }

void LaneBatch::set(const std::vector<std::vector<double>>& values, int threads) {
  const auto before = std::tuple(numbers_, start_, state_, blocks_);
  try {
    change(values, threads);
  } catch (...) {
    std::tie(numbers_, start_, state_, blocks_) = before;
    throw;
  }
  reset();
}

void LaneBatch::change(const std::vector<std::vector<double>>& values, int threads) {
  const std::vector<double> usual = scene_.values();
  const std::size_t different = values.empty() ? 1 : static_cast<std::size_t>(lanes_);
  std::vector<LaneStart> starts(different);
  std::vector<std::exception_ptr> errors(different);
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t lane = next++; lane < different; lane = next++) {
      std::vector<double> own = usual;
      for (std::size_t k = 0; k < values.size(); ++k) own[k] = values[k][lane];
      try {
        starts[lane] = scene_.start(own, in_lane(lane));
      } catch (...) {
        errors[lane] = std::current_exception();
        return;
      }
    }
  };
  in_threads(threads, [&](std::size_t) { work(); });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
  // Lanes that complete the last block are copies of the last one.
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(stride_); ++lane) {
    const LaneStart& start = starts[std::min(lane, different - 1)];
    const auto put = [&](const std::vector<double>& from, std::vector<double>& rows) {
      for (std::size_t k = 0; k < from.size(); ++k) rows[k * static_cast<std::size_t>(stride_) + lane] = from[k];
    };
    put(start.numbers, numbers_);
    put(start.state, start_);
  }
  prepare_blocks(starts);
}

void LaneBatch::load(BlockSteps& steps, std::size_t block) const {
  const std::size_t first = block * block_lanes;
  const auto copy = [&](const std::vector<double>& rows, int slot) {
    for (std::size_t i = 0; i < rows.size(); i += static_cast<std::size_t>(stride_))
      std::copy_n(rows.data() + i + first, block_lanes, steps.slot(slot++));
  };
  copy(state_, programs_.slots.y);
  copy(input_, programs_.slots.u);
  std::ranges::copy(blocks_[block].constants, steps.slot(programs_.slots.constants));
  steps.begin();
}

// Constants and limits of pivots of each lane.
void LaneBatch::prepare_blocks(const std::vector<LaneStart>& starts) {
  BlockSteps steps(programs_, equations().length, step_);
  const StepSlots& at = programs_.slots;
  state_ = start_;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    Block& block = blocks_[b];
    for (int k = 0; k < programs_.varied; ++k)
      std::copy_n(
          numbers_.data() + static_cast<std::ptrdiff_t>(k) * stride_ + static_cast<std::ptrdiff_t>(b * block_lanes),
          block_lanes, steps.slot(at.numbers + k));
    steps.prepare();
    std::copy_n(steps.slot(at.constants), block.constants.size(), block.constants.begin());
    load(steps, b);
    for (int k = 0; k < programs_.nq; ++k)
      std::fill_n(steps.slot(at.y + k), block_lanes, pivots_.q[static_cast<std::size_t>(k)]);
    steps.evaluate(0);
    steps.limits_of(block.limits.data());
    load(steps, b);
    const std::size_t end = std::min((b + 1) * block_lanes, starts.size());
    for (std::size_t lane = b * block_lanes; lane < end; ++lane) {
      for (std::size_t k = 0; k < starts[lane].v.size(); ++k)
        steps.slot(at.y + programs_.nq + static_cast<int>(k))[lane % block_lanes] = starts[lane].v[k];
    }
    steps.evaluate(0);
    for (std::size_t lane = b * block_lanes; lane < end; ++lane) check_lane(steps, lane, starts[lane]);
  }
}

// What has been recorded wrongly is not run.
void LaneBatch::check_lane(BlockSteps& steps, std::size_t lane, const LaneStart& expected) const {
  constexpr double different = 1e-8;  // of the largest acceleration: a mistake, not rounding, even with weak pivots
  BlockSteps::Stops stops{};
  steps.check_pivots(blocks_[lane / block_lanes].limits.data(), stops);
  if (stops[lane % block_lanes] != StopReason::none) return;  // the first step says so
  double error = 0;
  for (std::size_t k = 0; k < expected.vdot.size(); ++k) {
    const double here = steps.slot(programs_.slots.rates + programs_.nq + static_cast<int>(k))[lane % block_lanes];
    const double difference = std::abs(here - expected.vdot[k]);
    error = difference <= error ? error : difference;  // keeps NaN
  }
  if (error <= different * expected.size) return;
  throw SceneError({in_lane(lane) + "its accelerations at the start differ from those of a simulation by " +
                    text::number(error) + ", of " + text::number(expected.size) +
                    "; gelenk.sweep can run it. This is a fault of Gelenk: please report the scene"});
}

void LaneBatch::reset() {
  state_ = start_;
  steps_ = 0;
  stopped_.clear();
  for (Block& block : blocks_) block.stops.fill(StopReason::none);
}

void LaneBatch::start_as(std::size_t lane, const LaneBatch& source, std::size_t of) {
  const auto copy = [&](const std::vector<double>& from, std::vector<double>& to) {
    const auto first = static_cast<std::size_t>(source.stride_);
    const auto stride = static_cast<std::size_t>(stride_);
    for (std::size_t k = 0; k * stride < to.size(); ++k) to[k * stride + lane] = from[k * first + of];
  };
  copy(source.numbers_, numbers_);
  copy(source.start_, start_);
  copy(source.start_, state_);
  constexpr auto size = static_cast<std::size_t>(block_lanes);
  const Block& from = source.blocks_[of / size];
  Block& to = blocks_[lane / size];
  for (std::size_t k = 0; k < to.constants.size(); k += size)
    to.constants[k + lane % size] = from.constants[k + of % size];
  for (std::size_t k = 0; k < to.limits.size(); k += size) to.limits[k + lane % size] = from.limits[k + of % size];
  to.stops[lane % size] = StopReason::none;
}

void LaneBatch::start_as(const std::vector<int>& lanes, const LaneBatch& source, const std::vector<int>& of) {
  for (std::size_t i = 0; i < lanes.size(); ++i)
    start_as(static_cast<std::size_t>(lanes[i]), source, static_cast<std::size_t>(of[i]));
  if (stopped_.empty()) return;
  std::erase_if(stopped_, [&](const LaneStop& stop) {
    const auto at = static_cast<std::size_t>(stop.lane);
    return blocks_[at / block_lanes].stops[at % block_lanes] == StopReason::none;
  });
}

std::string LaneBatch::name_of_guard(const BlockSteps& steps, std::size_t lane, StopReason stop) const {
  if (stop != StopReason::singular && stop != StopReason::massless) return {};
  const StepPrograms::Guard& guard = programs_.guards[static_cast<std::size_t>(steps.broken()[lane])];
  const auto of = static_cast<std::size_t>(guard.of);
  return guard.is_mass ? equations().v[of].name : equations().rows[of];
}

void LaneBatch::advance_block(BlockSteps& steps, std::size_t block, long count, std::vector<LaneStop>& stopped) {
  load(steps, block);
  BlockSteps::Stops& stops = blocks_[block].stops;
  for (long i = 0; i < count; ++i) {
    const BlockSteps::Stops before = stops;
    const double time = static_cast<double>(steps_ + i) * step_;
    steps.step(time, blocks_[block].limits.data(), stops);
    if (stops == before) continue;
    for (std::size_t l = 0; l < block_lanes; ++l) {
      const int lane = static_cast<int>(block * block_lanes + l);
      if (stops[l] != before[l] && lane < lanes_)
        stopped.push_back({lane, time, stops[l], name_of_guard(steps, l, stops[l])});
    }
  }
  int slot = programs_.slots.y;
  for (std::size_t i = 0; i < state_.size(); i += static_cast<std::size_t>(stride_))
    std::copy_n(steps.slot(slot++), block_lanes, state_.data() + i + block * block_lanes);
}

void LaneBatch::advance(long count, int threads) {
  const auto workers = static_cast<std::size_t>(std::clamp<long>(threads, 1, static_cast<long>(blocks_.size())));
  std::vector<std::vector<LaneStop>> stopped(workers);
  std::vector<long> renewals(workers);
  const auto work = [&](std::size_t worker) {
    BlockSteps steps(programs_, equations().length, step_);
    const std::size_t first = worker * blocks_.size() / workers;
    const std::size_t end = (worker + 1) * blocks_.size() / workers;
    for (std::size_t block = first; block < end; ++block) advance_block(steps, block, count, stopped[worker]);
    renewals[worker] = steps.renewals();
  };
  in_threads(static_cast<int>(workers), work);
  steps_ += count;
  std::vector<LaneStop> found;
  for (std::size_t worker = 0; worker < workers; ++worker) {
    found.insert(found.end(), stopped[worker].begin(), stopped[worker].end());
    evaluations_ += renewals[worker] * block_lanes;
  }
  std::ranges::stable_sort(found, {}, &LaneStop::time);
  stopped_.insert(stopped_.end(), found.begin(), found.end());
  evaluations_ += 4 * count * lanes_;
}

std::string LaneStop::text() const {
  switch (stop) {
    case StopReason::singular:
      return of +
             ": near a singular configuration, which lanes do not pass: the pivot of a constraint equation is less "
             "than 0.03 of its usual size, or has changed its sign";
    case StopReason::massless:
      return of + ": the mass that this velocity moves vanishes";
    case StopReason::open:
      return "constraint projection did not converge";
    default:
      return "the state is not finite";
  }
}

}  // namespace gelenk
