// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/past.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "simulation/simulation_impl.h"

namespace gelenk {

void Way::exchange(Record& record) {
  int count = static_cast<int>(legs.size());
  record.within(count, 0, static_cast<int>(Past::most_legs));
  if (count == 0) return;
  legs.resize(count);
  long sum = 0;
  for (Leg& leg : legs) {
    leg.exchange(record);
    if (!std::isfinite(leg.end) || leg.evaluations < 0) sum = LONG_MAX;
    sum = std::min(sum, Past::most_evaluations + 1) + std::min(leg.evaluations, Past::most_evaluations);
  }
  if (sum > Past::most_evaluations) throw std::invalid_argument("it is not of this plant, or damaged");
  record.exchange(evaluations, jumped);
}

bool Past::add(const Leg& leg, bool goes_on) {
  evaluations += leg.evaluations;
  if (evaluations > most_evaluations) return false;
  if (goes_on && !leg.jumped && !legs.empty()) {
    legs.back().evaluations += leg.evaluations;
    return true;
  }
  if (legs.size() == most_legs) return false;
  legs.push_back(leg);
  return true;
}

void InputLog::make_room() {
  one_.write_anew();
  last_.exchange(one_);
  words_.resize(Past::most_legs * one_.words().size());
}

void InputLog::add(const Inputs& u) {
  if (words_.empty()) return;
  last_ = u;
  one_.write_anew();
  last_.exchange(one_);
  ++added_;
  std::ranges::copy(one_.words(), words_.begin() + static_cast<std::ptrdiff_t>(place(1)));
}

Inputs InputLog::before(std::size_t ago) const {
  const auto from = words_.begin() + static_cast<std::ptrdiff_t>(place(ago));
  Record record({from, from + static_cast<std::ptrdiff_t>(width())});
  Inputs u = last_;
  u.exchange(record);
  return u;
}

void InputLog::exchange(Record& record, std::size_t count) {
  if (record.reading()) added_ = count;
  for (std::size_t ago = count; ago > 0; --ago) {
    const std::span<std::uint64_t> words(words_.data() + place(ago), width());
    record.exchange(words);
  }
  if (record.reading() && count > 0) last_ = before(1);
}

// Behind the islands, which are written where their methods began anew. Nothing, where none has a history.
void Simulation::Impl::exchange_past(Record& record) {
  const bool reading = record.reading();
  if (reading ? record.ended() : !any_integrator(islands, &Integrator::has_past)) return;
  std::vector<Way> ways(islands.size());
  std::size_t longest = 0;
  for (std::size_t i = 0; i < islands.size(); ++i) {
    if (!reading) ways[i] = islands[i]->way();
    ways[i].exchange(record);
    longest = std::max(longest, ways[i].legs.size());
  }
  if (longest == 0) throw std::invalid_argument("it is not of this plant, or damaged");
  log.exchange(record, longest);
  if (reading) go_again(ways);
}

void Simulation::Impl::go_again(const std::vector<Way>& ways) {
  Inputs present = u;
  for (std::size_t i = 0; i < islands.size(); ++i) {
    const Way& way = ways[i];
    for (std::size_t k = 0; k < way.legs.size(); ++k) {
      u = log.before(way.legs.size() - k);
      islands[i]->go_again(way.legs[k]);
    }
    if (!way.legs.empty()) islands[i]->arrive(way, time);
  }
  u = std::move(present);
}

}  // namespace gelenk
