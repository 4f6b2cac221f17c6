// SPDX-License-Identifier: BSD-3-Clause
// What a run remembers so that it can be saved although its integrator carries a history that cannot be written down:
// where the method began anew, and what it has been asked for since. Going that way again leads to the same bits, and
// saving does nothing to the run. So that the way stays short the method begins anew now and then, saved or not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formulation/inputs.h"
#include "util/archive.h"

namespace gelenk {

// An advance of an island.
struct ReplayStep {
  double end = 0;        // s, asked for
  long evaluations = 0;  // by which it stopped there, or before
  bool jumped = false;   // the inputs, or what is tuned, before it

  void serialize(Archive& archive) { archive.serialize(end, evaluations, jumped); }
};

// From where the method began anew to the present.
struct ReplayPath {
  std::vector<ReplayStep> legs;
  long evaluations = 0;  // of the whole run, at the present
  bool jumped = false;   // since the last leg
  // Throws std::invalid_argument.
  void serialize(Archive& archive);
};

struct ReplayHistory {
  // A method of order 1 needs some twenty steps until it is where it was: of 1000, or of 256 communication steps of at
  // least one each, that is little. An arm with 7 joints goes the longest way again within some milliseconds.
  static constexpr std::size_t most_legs = 256;
  static constexpr long most_steps = 1000;
  // Of all legs; more only where one communication step is cut short again and again. A state from outside that asks
  // for more is none.
  static constexpr long most_evaluations = 10'000'000;

  Archive beginning;  // the island there
  std::vector<ReplayStep> legs;
  bool begun = false;    // there is one
  long steps = 0;        // the island's, there
  long evaluations = 0;  // of the legs

  // Begins where the island has just been written into `beginning`.
  void begin(long steps_there) {
    clear();
    begun = true;
    steps = steps_there;
  }
  void clear() {
    legs.clear();
    begun = false;
    evaluations = 0;
  }
  // goes_on: with what the last leg was cut short in. False: it would be too long a way.
  bool add(const ReplayStep& leg, bool continues);
};

// The inputs of the latest communication steps, in a ring.
class InputLog {
 public:
  explicit InputLog(std::size_t inputs) : last_(inputs) {}

  // Asks for the room that it needs. Without it nothing is kept.
  void make_room();
  void add(const Inputs& u);
  // Of the last step (ago = 1), of the one before it, and so on.
  Inputs before(std::size_t ago) const;
  bool ends_with(const Inputs& u) const { return added_ > 0 && last_ == u; }
  // The latest ones; when reading, there are no others afterwards.
  void serialize(Archive& archive, std::size_t count);

 private:
  std::size_t place(std::size_t ago) const { return (added_ - ago) % ReplayHistory::most_legs * width(); }
  std::size_t width() const { return words_.size() / ReplayHistory::most_legs; }

  Inputs last_;
  Archive one_;
  std::vector<std::uint64_t> words_;
  std::size_t added_ = 0;
};

}  // namespace gelenk
