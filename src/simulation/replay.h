// SPDX-License-Identifier: BSD-3-Clause
// Saving of a run whose integrator has a history that cannot be serialized: the state at the method's last restart and
// the steps since. Repeating these gives the same bits, and saving does not change the run. To limit the number of
// steps to repeat, the method is restarted from time to time, whether the run is saved or not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formulation/inputs.h"
#include "util/archive.h"

namespace gelenk {

// One advance of an island.
struct ReplayStep {
  double end = 0;        // requested end [s]
  long evaluations = 0;  // used; they determine where an advance with a limited budget ended
  bool jumped = false;   // whether inputs or tunable parameters jumped before it

  void serialize(Archive& archive) { archive.serialize(end, evaluations, jumped); }
};

// The advances from the method's last restart to the present.
struct ReplayPath {
  std::vector<ReplayStep> legs;
  long evaluations = 0;  // of the whole run up to the present
  bool jumped = false;   // whether inputs jumped since the last leg
  bool shown = false;    // whether outputs of the present have been evaluated
  // Throws std::invalid_argument.
  void serialize(Archive& archive);
};

struct ReplayHistory {
  // After a restart at order 1 a method takes some twenty steps to regain its order: few compared with 1000 steps, or
  // with 256 communication steps of at least one step each. Repeating the longest path takes some milliseconds for an
  // arm with 7 joints.
  static constexpr std::size_t max_legs = 256;
  static constexpr long max_steps = 1000;
  // In all legs together; exceeded only if one communication step is cut short again and again. A saved state with more
  // is invalid.
  static constexpr long max_evaluations = 10'000'000;

  Archive beginning;  // the island at the restart; of a method without a history, at the start of the last advance
  std::vector<ReplayStep> legs;
  bool begun = false;    // whether a history begins there
  long steps = 0;        // integrator steps of the island at the restart
  long evaluations = 0;  // of the legs

  // Starts a history at the state that has been written to `beginning`.
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
  // Appends a leg, or extends the last one if it was cut short and is continued. Returns false if the path would become
  // too long.
  bool add(const ReplayStep& leg, bool continues);
};

// The inputs of the latest communication steps, in a ring buffer.
class InputLog {
 public:
  // like: inputs of the same number and kinds.
  explicit InputLog(const Inputs& like) : last_(like) {}

  // Allocates the buffer; without it, nothing is recorded.
  void reserve();
  void add(const Inputs& u);
  // Takes back the last one.
  void forget_last();
  // Inputs of the last step (ago = 1), of the one before it (2), and so on.
  Inputs before(std::size_t ago) const;
  bool ends_with(const Inputs& u) const { return added_ > 0 && last_ == u; }
  // Writes or reads the latest `count` inputs; reading discards all others.
  void serialize(Archive& archive, std::size_t count);
  // The same for the last inputs alone, if there are any.
  void serialize_last(Archive& archive);

 private:
  // Those of the longest path, and of a step that may be taken back.
  static constexpr std::size_t capacity = ReplayHistory::max_legs + 1;
  std::size_t place(std::size_t ago) const { return (added_ - ago) % capacity * width(); }
  std::size_t width() const { return words_.size() / capacity; }

  Inputs last_;
  Archive one_;
  std::vector<std::uint64_t> words_;
  std::size_t added_ = 0;
};

}  // namespace gelenk
