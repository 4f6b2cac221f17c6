// SPDX-License-Identifier: BSD-3-Clause
// The list of all elements along the coordinates of a joint. A new one requires a header and its name here.
#pragma once

#include <optional>
#include <tuple>

#include "element/joint_forces/joint_damper.h"
#include "element/joint_forces/joint_friction.h"
#include "element/joint_forces/joint_law.h"
#include "element/joint_forces/joint_limit.h"
#include "element/joint_forces/joint_lock.h"
#include "element/joint_forces/joint_one_way.h"
#include "element/joint_forces/joint_spring.h"
#include "element/joint_forces/stop.h"

namespace gelenk {

// Of one coordinate; those in std::optional need not be present.
struct JointForces
    : std::tuple<JointDamper, JointSpring, std::optional<Stop>, std::optional<JointFriction>, std::optional<JointLimit>,
                 std::optional<JointOneWay>, std::optional<JointLaw>, std::optional<JointLock>> {
  const tuple& all() const { return *this; }
};

}  // namespace gelenk
