// SPDX-License-Identifier: BSD-3-Clause
// Results of searches for the nearest assembly in this process: a mechanism whose geometry and guesses have occurred
// before, as in a sweep over masses or after a reset, is not searched again.
#pragma once

#include <optional>
#include <vector>

#include "assembly/assembly_problem.h"

namespace gelenk {

struct KnownAssembly {
  std::vector<double> q;        // of the nearest assembly
  std::vector<double> equal_q;  // of another one that is as near; empty: none is known
};

// Everything on which the search for an assembly depends, bit for bit: the guesses, and the closure errors and
// distances of the problem at some positions in general position. These are analytic functions of the position, so that
// problems for which they agree there are the same.
class AssemblyKey {
 public:
  // closed: the assembly from which the search starts.
  AssemblyKey(AssemblyProblem& problem, const InitialGuess& tree, const InitialGuess& cuts,
              const std::vector<double>& closed);
  bool operator==(const AssemblyKey& other) const { return numbers_ == other.numbers_; }
  const std::vector<double>& numbers() const { return numbers_; }

 private:
  std::vector<double> numbers_;
};

// Threads may call these at any time. The store has a limited size; what was not needed for longest is forgotten.
std::optional<KnownAssembly> find_known(const AssemblyKey& key);
void remember(AssemblyKey key, KnownAssembly assembly);
inline constexpr std::size_t max_known_assemblies = 64;
inline constexpr std::size_t max_known_numbers = 1'000'000;  // of their keys: 8 MB

}  // namespace gelenk
