// SPDX-License-Identifier: BSD-3-Clause
// The contacts of shapes of a formulation: in steps with impulses, or with modes that change at events.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "formulation/impulse_steps.h"
#include "modes/run_counts.h"
#include "scene/scene.h"
#include "util/archive.h"

namespace gelenk {

class TouchModes;

class ContactMotion {
 public:
  explicit ContactMotion(const ImpulseSteps::Context& context);
  ~ContactMotion();
  ContactMotion(const ContactMotion&) = delete;
  ContactMotion& operator=(const ContactMotion&) = delete;

  // Once: from then on, modes change at events.
  TouchModes& use(std::unique_ptr<TouchModes> touch);

  ImpulseSteps& steps() { return steps_; }
  const ImpulseSteps& steps() const { return steps_; }
  TouchModes* touch() const { return touch_.get(); }  // null: not at events

  // By indicator of contacts, which follow all others.
  std::vector<std::array<std::string, 2>> event_texts(const Scene& scene) const;
  // What outputs of contacts show; null: there are none.
  ContactReadings* readings();
  void count(RunCounts& counts) const;

  // At the start of a run.
  void start();
  // At the start of each part of a communication step, to which undo_part() returns; continues: of a later one.
  void begin_part(bool continues);
  void undo_part();
  void serialize(Archive& archive);

 private:
  ImpulseSteps steps_;
  std::unique_ptr<TouchModes> touch_;
};

}  // namespace gelenk
