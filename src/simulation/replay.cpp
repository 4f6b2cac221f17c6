// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/replay.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "simulation/simulation_impl.h"

namespace gelenk {

void ReplayPath::serialize(Archive& archive) {
  int count = static_cast<int>(legs.size());
  archive.serialize_in_range(count, 0, static_cast<int>(ReplayHistory::max_legs));
  if (count == 0) return;
  legs.resize(count);
  long sum = 0;
  for (ReplayStep& leg : legs) {
    leg.serialize(archive);
    if (!std::isfinite(leg.end) || leg.evaluations < 0) sum = LONG_MAX;
    sum = std::min(sum, ReplayHistory::max_evaluations + 1) + std::min(leg.evaluations, ReplayHistory::max_evaluations);
  }
  if (sum > ReplayHistory::max_evaluations) throw std::invalid_argument("it is not of this plant, or damaged");
  archive.serialize(evaluations, jumped, shown);
}

bool ReplayHistory::add(const ReplayStep& leg, bool continues) {
  evaluations += leg.evaluations;
  if (evaluations > max_evaluations) return false;
  if (continues && !leg.jumped && !legs.empty()) {
    legs.back().evaluations += leg.evaluations;
    return true;
  }
  if (legs.size() == max_legs) return false;
  legs.push_back(leg);
  return true;
}

void InputLog::reserve() {
  one_.start_writing();
  last_.serialize(one_);
  words_.resize(capacity * one_.words().size());
}

void InputLog::add(const Inputs& u) {
  if (words_.empty()) return;
  last_ = u;
  one_.start_writing();
  last_.serialize(one_);
  ++added_;
  std::ranges::copy(one_.words(), words_.begin() + static_cast<std::ptrdiff_t>(place(1)));
}

void InputLog::forget_last() {
  if (added_ == 0) return;
  --added_;
  if (added_ > 0) last_ = before(1);
}

void InputLog::serialize_last(Archive& archive) {
  bool any = added_ > 0;
  archive.serialize(any);
  if (archive.reading()) added_ = 0;
  if (!any) return;
  Inputs last = last_;
  last.serialize(archive);
  if (archive.reading()) add(last);
}

Inputs InputLog::before(std::size_t ago) const {
  const auto from = words_.begin() + static_cast<std::ptrdiff_t>(place(ago));
  Archive archive({from, from + static_cast<std::ptrdiff_t>(width())});
  Inputs u = last_;
  u.serialize(archive);
  return u;
}

void InputLog::serialize(Archive& archive, std::size_t count) {
  if (archive.reading()) added_ = count;
  for (std::size_t ago = count; ago > 0; --ago) {
    const std::span<std::uint64_t> words(words_.data() + place(ago), width());
    archive.serialize(words);
  }
  if (archive.reading() && count > 0) last_ = before(1);
}

// Follows the islands, which are written as they were at the restarts of their methods. Empty if no method has a
// history.
void Simulation::Impl::serialize_replay(Archive& archive) {
  const bool reading = archive.reading();
  if (reading ? archive.at_end() : !any_integrator(islands, &Integrator::has_history)) return;
  std::vector<ReplayPath> paths(islands.size());
  std::size_t longest = 0;
  for (std::size_t i = 0; i < islands.size(); ++i) {
    if (!reading) paths[i] = islands[i]->replay_path();
    paths[i].serialize(archive);
    longest = std::max(longest, paths[i].legs.size());
  }
  if (longest == 0) throw std::invalid_argument("it is not of this plant, or damaged");
  log.serialize(archive, longest);
  if (reading) replay(paths);
}

void Simulation::Impl::replay(const std::vector<ReplayPath>& paths) {
  for (std::size_t i = 0; i < islands.size(); ++i) replay(*islands[i], paths[i], 0);
}

// newer: number of inputs in the log after those of the path.
void Simulation::Impl::replay(Island& island, const ReplayPath& path, std::size_t newer) {
  if (path.legs.empty()) return;
  Inputs present = u;
  for (std::size_t k = 0; k < path.legs.size(); ++k) {
    u = log.before(path.legs.size() - k + newer);
    island.replay(path.legs[k]);
  }
  island.finish_replay(path, time);
  u = std::move(present);
}

}  // namespace gelenk
