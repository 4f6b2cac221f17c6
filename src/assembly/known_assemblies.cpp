// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/known_assemblies.h"

#include <list>
#include <mutex>
#include <random>
#include <utility>

#include "assembly/search_positions.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

constexpr int probes = 3;

struct Store {
  std::mutex mutex;
  std::list<std::pair<AssemblyKey, KnownAssembly>> entries;  // the last one needed first
  std::size_t numbers = 0;                                   // of all keys
};

Store& store() {
  static Store instance;
  return instance;
}

template <class Numbers>
void add(std::vector<double>& out, const Numbers& numbers) {
  out.push_back(static_cast<double>(numbers.size()));
  for (const auto x : numbers) out.push_back(static_cast<double>(x));
}

void add_guesses(std::vector<double>& out, const InitialGuess& guesses) {
  add(out, guesses.q);
  add(out, guesses.q_fixed);
  add(out, guesses.q_weight);
  add(out, guesses.q_given);
  add(out, guesses.turns);
  add(out, guesses.rank);
  add(out, guesses.user_sign);
}

}  // namespace

AssemblyKey::AssemblyKey(AssemblyProblem& problem, const InitialGuess& tree, const InitialGuess& cuts,
                         const std::vector<double>& closed) {
  add(numbers_, closed);
  add_guesses(numbers_, tree);
  add_guesses(numbers_, cuts);
  for (const Link& link : problem.mechanism().links) add(numbers_, std::vector{link.nq, link.nv, link.parent});
  std::mt19937 random(7);  // NOLINT(bugprone-random-generator-seed): the same positions each time
  const auto velocities = static_cast<Eigen::Index>(problem.free(AssemblyProblem::Level::position).size());
  for (int i = 0; i < probes; ++i) {
    const std::vector<double> q = random_position(problem, random);
    add(numbers_, problem.gap(q));
    add(numbers_, problem.distance(q));
    add(numbers_, problem.displaced(q, Eigen::VectorXd::Constant(velocities, 0.1 * problem.length())));
  }
}

std::optional<KnownAssembly> find_known(const AssemblyKey& key) {
  Store& all = store();
  const std::scoped_lock lock(all.mutex);
  for (auto entry = all.entries.begin(); entry != all.entries.end(); ++entry) {
    if (!(entry->first == key)) continue;
    all.entries.splice(all.entries.begin(), all.entries, entry);
    return entry->second;
  }
  return std::nullopt;
}

void remember(AssemblyKey key, KnownAssembly assembly) {
  Store& all = store();
  const std::scoped_lock lock(all.mutex);
  all.entries.emplace_front(std::move(key), std::move(assembly));
  all.numbers += all.entries.front().first.numbers().size();
  while (all.entries.size() > max_known_assemblies || all.numbers > max_known_numbers) {
    all.numbers -= all.entries.back().first.numbers().size();
    all.entries.pop_back();
  }
}

}  // namespace gelenk
