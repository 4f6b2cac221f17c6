// SPDX-License-Identifier: BSD-3-Clause
// Many instances of one scene, each with numbers, a state and inputs of its own, stepped together.
#pragma once

#include <string>
#include <vector>

#include "batch/block_steps.h"
#include "batch/pivots_of_scene.h"
#include "batch/varied_scene.h"
#include "scene/scene.h"

namespace gelenk {

// A lane that has stopped.
struct LaneStop {
  int lane = 0;
  double time = 0;  // at which it remains [s]
  StopReason stop = StopReason::none;
  std::string of;  // the constraint, or the velocity of the mass

  std::string text() const;
};

class LaneBatch {
 public:
  // parameters: those that may vary; step [s]. Throws SceneError with the names of elements that cannot be stepped in
  // lanes, and what Simulation throws for the scene.
  LaneBatch(const Scene& scene, int lanes, double step, const std::vector<std::string>& parameters);

  // values: by parameter, by lane. Puts all lanes to their starts. Throws SceneError or AssemblyError, with the number
  // of the lane; the batch is then as it was.
  void set(const std::vector<std::vector<double>>& values, int threads);
  // Puts lanes to their starts, at time 0 of the batch.
  void reset();
  // Puts lanes to the starts of lanes of another batch, of the same scene with the same parameters.
  void start_as(const std::vector<int>& lanes, const LaneBatch& source, const std::vector<int>& of);
  // Makes `count` steps with the inputs of inputs().
  void advance(long count, int threads);

  int lanes() const { return lanes_; }
  double step() const { return step_; }
  double time() const;
  const std::vector<EquationArgument>& coordinates() const { return equations().q; }
  const std::vector<EquationArgument>& velocities() const { return equations().v; }
  std::vector<EquationArgument> inputs() const;
  const std::vector<std::string>& element_states() const { return equations().states; }
  // Rows of coordinates, velocities and element states, by lane; so many numbers from row to row.
  double* state() { return state_.data(); }
  double* input() { return input_.data(); }
  bool reads_time() const { return equations().reads_time; }
  int stride() const { return stride_; }
  // In the order in which they stopped.
  const std::vector<LaneStop>& stopped() const { return stopped_; }
  // Of the equations of motion, by all lanes.
  long evaluations() const { return evaluations_; }
  // Operations of one, and slots.
  int operations() const { return programs_.operations(); }
  int slots() const { return programs_.frame.size(); }

 private:
  struct Block {
    std::vector<double> constants, limits;
    BlockSteps::Stops stops{};
  };

  const SceneEquations& equations() const { return scene_.equations(); }
  void start_as(std::size_t lane, const LaneBatch& source, std::size_t of);
  void change(const std::vector<std::vector<double>>& values, int threads);
  void prepare_blocks(const std::vector<LaneStart>& starts);
  void check_lane(BlockSteps& steps, std::size_t lane, const LaneStart& expected) const;
  std::string name_of_guard(const BlockSteps& steps, std::size_t lane, StopReason stop) const;
  void load(BlockSteps& steps, std::size_t block) const;
  void advance_block(BlockSteps& steps, std::size_t block, long count, std::vector<LaneStop>& stopped);

  VariedScene scene_;
  int lanes_, stride_;
  double step_;
  PivotsOfScene pivots_;
  StepPrograms programs_;
  std::vector<double> state_, start_, input_, numbers_;  // rows
  std::vector<Block> blocks_;
  std::vector<LaneStop> stopped_;
  long steps_ = 0, evaluations_ = 0;
};

}  // namespace gelenk
