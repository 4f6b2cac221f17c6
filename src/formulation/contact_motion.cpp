// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/contact_motion.h"

#include <utility>

#include "touch/touch_modes.h"

namespace gelenk {

ContactMotion::ContactMotion(const ImpulseSteps::Context& context) : steps_(context) {}

ContactMotion::~ContactMotion() = default;

TouchModes& ContactMotion::use(std::unique_ptr<TouchModes> touch) {
  touch_ = std::move(touch);
  return *touch_;
}

std::vector<std::array<std::string, 2>> ContactMotion::event_texts(const Scene& scene) const {
  return touch_ ? touch_->outputs().event_texts(scene) : std::vector<std::array<std::string, 2>>{};
}

ContactReadings* ContactMotion::readings() { return touch_ ? &touch_->outputs() : steps_.readings(); }

void ContactMotion::count(RunCounts& counts) const {
  counts.contact_points = static_cast<long>(steps_.contact_points());
  counts.cone_iterations = steps_.solved().iterations;
  counts.cone_residual = steps_.solved().residual;
  if (!touch_) return;
  counts.impacts += touch_->counts().impacts;
  counts.closed_series += touch_->counts().closed_series;
  counts.ambiguous += touch_->counts().ambiguous;
  counts.contact_points = static_cast<long>(touch_->equations().closed().size());
}

void ContactMotion::start() {
  steps_.forget();
  if (touch_) touch_->start();
}

void ContactMotion::begin_part(bool continues) {
  steps_.begin_part(continues);
  if (touch_) touch_->begin_part();
}

void ContactMotion::undo_part() {
  steps_.undo_part();
  if (touch_) touch_->undo_part();
}

void ContactMotion::serialize(Archive& archive) {
  steps_.serialize(archive);
  if (touch_) touch_->serialize(archive);
}

}  // namespace gelenk
