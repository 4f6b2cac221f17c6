// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/joint_outputs.h"

#include <algorithm>

namespace gelenk {

JointOutputs::JointOutputs(Dynamics& dynamics, LockModes& locks, const std::vector<int>& sides)
    : dynamics_(dynamics),
      forces_(dynamics.switching_forces()),
      locks_(locks),
      sides_(sides),
      recorded_sides_(sides.size()),
      recorded_forces_(sides.size()),
      holding_(sides.size()),
      recorded_holding_(static_cast<std::size_t>(forces_.locks())),
      present_forces_(sides.size()) {}

void JointOutputs::record() {
  if (locks_.empty()) return;
  recorded_sides_ = sides_;
  recorded_holding_ = locks_.distribute_holding_forces();
  read(recorded_holding_, recorded_forces_);
}

const std::vector<double>& JointOutputs::present() {
  if (!locks_.empty()) read(forces_.holding_forces().values(), present_forces_);
  return present_forces_;
}

// In the held modes. holding: by lock; out: by force.
void JointOutputs::read(const std::vector<double>& holding, std::vector<double>& out) {
  share_holding_forces(forces_, sides_.data(), holding.data(), holding_.data());
  dynamics_.readings().switching_forces(forces_.inputs().data(), sides_.data(), holding_.data(), out.data());
}

void JointOutputs::record(std::span<const LockForces> locks) {
  if (locks_.empty()) return;
  recorded_sides_ = sides_;
  std::ranges::fill(holding_, 0.0);
  for (std::size_t i = 0; i < locks.size(); ++i) {
    const auto lock = static_cast<int>(i);
    for (const int law : forces_.lock(lock).frictions) recorded_sides_[static_cast<std::size_t>(law)] = locks[i].motion;
    share_friction(forces_, lock, locks[i].motion, locks[i].friction, holding_.data());
    if (const int latch = forces_.lock(lock).latch; latch >= 0) {
      recorded_sides_[static_cast<std::size_t>(latch)] = locks[i].is_latched ? 1 : 0;
      holding_[static_cast<std::size_t>(latch)] = locks[i].latch;
    }
    const int limit = forces_.lock(lock).limit;
    if (limit < 0) continue;
    recorded_sides_[static_cast<std::size_t>(limit)] = locks[i].contact;
    holding_[static_cast<std::size_t>(limit)] = locks[i].limit;
  }
  dynamics_.readings().switching_forces(forces_.inputs().data(), sides_.data(), holding_.data(),
                                        recorded_forces_.data());
}

}  // namespace gelenk
