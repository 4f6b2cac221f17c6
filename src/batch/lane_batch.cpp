// SPDX-License-Identifier: BSD-3-Clause
#include "batch/lane_batch.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <tuple>
#include <utility>

#include "recording/recorded.h"
#include "scene_file/read.h"
#include "simulation/parameters.h"
#include "simulation/simulation.h"
#include "util/text.h"

namespace gelenk {
namespace {

constexpr int block_lanes = BlockSteps::lanes;

// Operations grow with the cube of their number; beyond it, recording takes longer than most runs.
constexpr std::size_t most_velocities = 64;

std::string prefix_of(const Scene& scene) { return (scene.file.empty() ? scene.name : scene.file) + ": "; }

std::string in_lane(std::size_t lane) { return "lane " + std::to_string(lane) + ": "; }

Scene with(const Scene& scene, const std::vector<Parameter>& table, const std::vector<double>& values) {
  Scene out = scene;
  for (std::size_t k = 0; k < table.size(); ++k) set_parameter(out, table[k], values[k]);
  return checked(out);
}

// What is 0, such as a damping, is left out of the equations. To have those in which it may be any number, it is so
// small instead that it has no effect.
std::vector<double> without_zeros(std::vector<double> values) {
  constexpr double tiny = 1e-200;
  for (double& value : values) value = value == 0 ? tiny : value;
  return values;
}

std::vector<double> values_of(const Scene& scene, const std::vector<Parameter>& table) {
  std::vector<double> out;
  for (const Parameter& parameter : table) out.push_back(parameter.get(scene));
  return out;
}

// The parameters with these names, in this order.
std::vector<Parameter> named(const Scene& scene, const std::vector<std::string>& names) {
  const std::vector<Parameter> all = scene_parameters(scene);
  std::vector<Parameter> out;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(all, name, &Parameter::name);
    if (found == all.end()) throw UsageError(name + ": no such parameter");
    if (found->type != ParameterType::real || name.starts_with("solver.") || name.starts_with("assembly."))
      throw UsageError(name + ": the same for all lanes; expected a number of the mechanism");
    out.push_back(*found);
  }
  return out;
}

// What no lane can do, in the names of the scene.
void refuse_unsuited(const Scene& scene, const SceneEquations& equations) {
  std::vector<std::string> faults;
  for (const std::string& note : equations.notes)
    faults.push_back(prefix_of(scene) + note + " Lanes need equations that hold everywhere.");
  for (const std::string& name : equations.prescribed)
    faults.push_back(prefix_of(scene) + name + ": found a prescribed motion, expected forces and motors only");
  if (equations.v.size() > most_velocities)
    faults.push_back(prefix_of(scene) + "found " + std::to_string(equations.v.size()) +
                     " velocities of joints, expected at most " + std::to_string(most_velocities) +
                     "; gelenk.sweep runs mechanisms of any size");
  if (equations.has_kinks)
    faults.push_back(prefix_of(scene) +
                     "found expressions with branches (abs, min, if, ...), at which steps end; lanes step together");
  if (!faults.empty()) throw SceneError(faults);
}

}  // namespace

LaneBatch::LaneBatch(const Scene& scene, int lanes, double step, const std::vector<std::string>& parameters)
    : scene_(scene),
      lanes_(lanes),
      stride_((lanes + block_lanes - 1) / block_lanes * block_lanes),
      step_(step),
      parameters_(parameters),
      first_(std::make_unique<NumberedScene>(numbered(scene))) {
  refuse_unsuited(scene, equations());
  const std::vector<Parameter> table = named(scene_, parameters_);
  const std::vector<double> varied = parameters.empty() ? first_->numbers : changed_numbers();
  Scene recorded = scene;
  if (varied.size() != first_->numbers.size()) {
    recorded = with(scene, table, without_zeros(values_of(scene, table)));
    *first_ = numbered(recorded);
  }
  if (varied.size() != first_->numbers.size())
    throw SceneError({prefix_of(scene) + "the parameters change more than numbers of the equations of motion"});
  varied_ = std::make_unique<VariedNumbers>(first_->numbers, varied);
  pivots_ = choose_pivots(*first_->scene);
  const std::vector<double> numbers = first_->numbers;
  {
    const recording::NumberList list(varied_->variables());
    first_->scene = std::make_unique<TracedScene>(recorded);
  }
  programs_ = std::make_unique<StepPrograms>(equations(), pivots_, varied_->count());
  const auto rows = [&](int count) {
    return std::vector<double>(static_cast<std::size_t>(count) * static_cast<std::size_t>(stride_));
  };
  state_ = start_ = rows(programs_->size());
  input_ = rows(programs_->inputs);
  numbers_ = rows(varied_->count());
  blocks_.resize(static_cast<std::size_t>(stride_ / block_lanes));
  for (Block& block : blocks_) {
    block.constants.resize(static_cast<std::size_t>(programs_->constants) * block_lanes);
    block.limits.resize(programs_->guards.size() * block_lanes);
  }
  for (int k = 0; k < programs_->inputs; ++k)
    std::fill_n(input_.data() + static_cast<std::ptrdiff_t>(k) * stride_, stride_,
                equations().u[static_cast<std::size_t>(k)].start);
  set({});
}

std::vector<EquationArgument> LaneBatch::inputs() const {
  return {equations().u.begin(), equations().u.begin() + equations().inputs};
}

double LaneBatch::time() const { return static_cast<double>(steps_) * step_; }

// All parameters with other values, by different amounts: all that depends on them is another number.
Scene LaneBatch::changed() const {
  const std::vector<Parameter> table = named(scene_, parameters_);
  constexpr double changes[] = {1e-3, -1e-3, 1e-6, -1e-6};  // of their values; some are at their limits
  for (const double change : changes) {
    std::vector<double> values;
    for (std::size_t k = 0; k < table.size(); ++k) {
      const double value = table[k].get(scene_);
      const double own = change * (1 + 0.7 * static_cast<double>(k + 1) / static_cast<double>(table.size() + 1));
      values.push_back(value == 0 ? own : value * (1 + own));
    }
    try {
      return with(scene_, table, values);
    } catch (const std::runtime_error&) {  // values that contradict each other
    } catch (const std::invalid_argument&) {
    }
  }
  throw SceneError({prefix_of(scene_) + "no other values of these parameters are possible together"});
}

std::vector<double> LaneBatch::changed_numbers() const {
  try {
    return numbered(changed()).numbers;
  } catch (const AssemblyError& e) {
    throw AssemblyError("with slightly other values of the parameters: " + std::string(e.what()));
  }
}

void LaneBatch::set(const std::vector<std::vector<double>>& values) {
  const auto before = std::tuple(numbers_, start_, state_, blocks_);
  try {
    change(values);
  } catch (...) {
    std::tie(numbers_, start_, state_, blocks_) = before;
    throw;
  }
  reset();
}

void LaneBatch::change(const std::vector<std::vector<double>>& values) {
  const std::vector<Parameter> table = named(scene_, parameters_);
  const bool is_same = values.empty();
  const auto count = static_cast<std::size_t>(lanes_);
  std::vector<Expected> expected(count);
  std::vector<double> own(table.size());
  for (std::size_t lane = 0; lane < count; ++lane) {
    if (is_same && lane > 0) {
      for (std::vector<double>* rows : {&numbers_, &start_}) {
        for (std::size_t i = 0; i < rows->size(); i += static_cast<std::size_t>(stride_))
          (*rows)[i + lane] = (*rows)[i];
      }
      expected[lane] = expected[0];
      continue;
    }
    for (std::size_t k = 0; k < own.size(); ++k) own[k] = is_same ? table[k].get(scene_) : values[k][lane];
    try {
      NumberedScene scene = numbered(with(scene_, table, own));
      expected[lane] = LaneBatch::expected(*scene.scene);
      if (!number_lane(lane, scene)) {
        scene = numbered(with(scene_, table, without_zeros(own)));
        if (!number_lane(lane, scene))
          throw SceneError({"its parameters change more than numbers of the equations of motion"});
      }
    } catch (const std::invalid_argument& e) {
      throw UsageError(in_lane(lane) + e.what());
    } catch (const SceneError& e) {
      std::vector<std::string> lines = e.lines();
      for (std::string& line : lines) line = in_lane(lane) + line;
      throw SceneError(lines);
    } catch (const AssemblyError& e) {
      throw AssemblyError(in_lane(lane) + e.what());
    }
  }
  // Lanes that complete the last block are copies of the last one.
  for (std::vector<double>* rows : {&numbers_, &start_}) {
    for (std::size_t i = 0; i < rows->size(); i += static_cast<std::size_t>(stride_))
      std::fill(rows->data() + i + count, rows->data() + i + stride_, (*rows)[i + count - 1]);
  }
  prepare_blocks(expected);
}

bool LaneBatch::number_lane(std::size_t lane, const NumberedScene& scene) {
  std::vector<double> values(static_cast<std::size_t>(varied_->count()));
  if (!varied_->find(scene.numbers, values.data())) return false;
  const auto put = [&](std::vector<double>& rows, std::size_t row, double value) {
    rows[row * static_cast<std::size_t>(stride_) + lane] = value;
  };
  for (std::size_t k = 0; k < values.size(); ++k) put(numbers_, k, values[k]);
  const SceneEquations& of = scene.scene->equations();
  std::size_t row = 0;
  for (const auto* list : {&of.q, &of.v}) {
    for (const EquationArgument& x : *list) put(start_, row++, x.start);
  }
  const std::size_t first = of.u.size() - of.states.size();
  for (std::size_t k = 0; k < of.states.size(); ++k) put(start_, row++, of.u[first + k].start);
  return true;
}

// In motion: at rest, many terms vanish. Velocities that contradict constraint equations would make redundant ones
// contradict each other.
LaneBatch::Expected LaneBatch::expected(const TracedScene& scene) {
  const SceneEquations& equations = scene.equations();
  std::vector<double> q;
  std::vector<double> u;
  for (const EquationArgument& of : equations.q) q.push_back(of.start);
  for (const EquationArgument& of : equations.u) u.push_back(of.start);
  const auto n = static_cast<Eigen::Index>(equations.v.size());
  Eigen::VectorXd v(n);
  for (Eigen::Index k = 0; k < n; ++k)
    v[k] = 0.3 + 0.37 * static_cast<double>(k % 5) - 0.11 * static_cast<double>(k % 7);
  const double speed = v.lpNorm<Eigen::Infinity>();
  const auto as_list = [&] { return std::vector<double>(v.begin(), v.end()); };
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  if (!equations.rows.empty()) {
    const EquationValues values = scene.values(q, as_list(), u);
    const Eigen::Map<const RowMajor> J(values.J.data(), static_cast<Eigen::Index>(equations.rows.size()), n);
    v -= J.completeOrthogonalDecomposition().solve(J * v);
  }
  const EquationValues values = scene.values(q, as_list(), u);
  Expected out{as_list(), values.vdot, speed * speed};
  for (std::size_t k = 0; k < out.vdot.size(); ++k) {
    const double mass = values.M[k * out.vdot.size() + k];
    out.size = std::max({out.size, std::abs(out.vdot[k]), mass > 0 ? std::abs(values.h[k] / mass) : 0});
  }
  return out;
}

void LaneBatch::load(BlockSteps& steps, std::size_t block) const {
  const std::size_t first = block * block_lanes;
  const auto copy = [&](const std::vector<double>& rows, int slot) {
    for (std::size_t i = 0; i < rows.size(); i += static_cast<std::size_t>(stride_))
      std::copy_n(rows.data() + i + first, block_lanes, steps.slot(slot++));
  };
  copy(state_, programs_->slots.y);
  copy(input_, programs_->slots.u);
  std::ranges::copy(blocks_[block].constants, steps.slot(programs_->slots.constants));
  steps.begin();
}

// Constants and limits of pivots of each lane.
void LaneBatch::prepare_blocks(const std::vector<Expected>& expected) {
  BlockSteps steps(*programs_, equations().length, step_);
  const StepSlots& at = programs_->slots;
  state_ = start_;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    Block& block = blocks_[b];
    for (int k = 0; k < programs_->varied; ++k)
      std::copy_n(
          numbers_.data() + static_cast<std::ptrdiff_t>(k) * stride_ + static_cast<std::ptrdiff_t>(b * block_lanes),
          block_lanes, steps.slot(at.numbers + k));
    steps.prepare();
    std::copy_n(steps.slot(at.constants), block.constants.size(), block.constants.begin());
    load(steps, b);
    for (int k = 0; k < programs_->nq; ++k)
      std::fill_n(steps.slot(at.y + k), block_lanes, pivots_.q[static_cast<std::size_t>(k)]);
    steps.evaluate(0);
    steps.limits_of(block.limits.data());
    load(steps, b);
    const std::size_t end = std::min((b + 1) * block_lanes, expected.size());
    for (std::size_t lane = b * block_lanes; lane < end; ++lane) {
      for (std::size_t k = 0; k < expected[lane].v.size(); ++k)
        steps.slot(at.y + programs_->nq + static_cast<int>(k))[lane % block_lanes] = expected[lane].v[k];
    }
    steps.evaluate(0);
    for (std::size_t lane = b * block_lanes; lane < end; ++lane) check_lane(steps, lane, expected[lane]);
  }
}

// What has been recorded wrongly is not run.
void LaneBatch::check_lane(BlockSteps& steps, std::size_t lane, const Expected& expected) const {
  constexpr double different = 1e-8;  // of the largest acceleration: a mistake, not rounding, even with weak pivots
  BlockSteps::Stops stops{};
  steps.check_pivots(blocks_[lane / block_lanes].limits.data(), stops);
  if (stops[lane % block_lanes] != StopReason::none) return;  // the first step says so
  double error = 0;
  for (std::size_t k = 0; k < expected.vdot.size(); ++k) {
    const double here = steps.slot(programs_->slots.rates + programs_->nq + static_cast<int>(k))[lane % block_lanes];
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

std::string LaneBatch::name_of_guard(const BlockSteps& steps, std::size_t lane, StopReason stop) const {
  if (stop != StopReason::singular && stop != StopReason::massless) return {};
  const StepPrograms::Guard& guard = programs_->guards[static_cast<std::size_t>(steps.broken()[lane])];
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
  int slot = programs_->slots.y;
  for (std::size_t i = 0; i < state_.size(); i += static_cast<std::size_t>(stride_))
    std::copy_n(steps.slot(slot++), block_lanes, state_.data() + i + block * block_lanes);
}

void LaneBatch::advance(long count, int threads) {
  const auto workers = static_cast<std::size_t>(std::clamp<long>(threads, 1, static_cast<long>(blocks_.size())));
  std::vector<std::vector<LaneStop>> stopped(workers);
  std::vector<long> renewals(workers);
  const auto work = [&](std::size_t worker) {
    BlockSteps steps(*programs_, equations().length, step_);
    const std::size_t first = worker * blocks_.size() / workers;
    const std::size_t end = (worker + 1) * blocks_.size() / workers;
    for (std::size_t block = first; block < end; ++block) advance_block(steps, block, count, stopped[worker]);
    renewals[worker] = steps.renewals();
  };
  std::vector<std::thread> others;
  for (std::size_t worker = 1; worker < workers; ++worker) others.emplace_back(work, worker);
  work(0);
  for (std::thread& other : others) other.join();
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
