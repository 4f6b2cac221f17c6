// SPDX-License-Identifier: BSD-3-Clause
// Motions that follow element states: the prescribed value and its time derivatives as expressions of signals.
#pragma once

#include <array>
#include <functional>

#include "element/constraints/motion.h"
#include "scene/scene.h"

namespace gelenk {

// s, s', s''. Of a speed that is prescribed, s is not given. Throws expression::SyntaxError.
using MotionOfSignals = std::array<Formula, 3>;
// of: one that follows signals; names: formula_names(scene). The rates of states are inserted in place of their
// derivatives. seen(formula, order): of each before it is differentiated.
MotionOfSignals motion_of_signals(const Scene& scene, const Motion& of, const FormulaNames& names,
                                  const std::function<void(const Formula&, int order)>& seen = {});

// The motion of a constraint that follows signals; null: it is none.
const Motion* find_motion_of_signals(const Constraint& constraint);
bool has_motions_of_signals(const Scene& scene);

}  // namespace gelenk
