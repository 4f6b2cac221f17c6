// SPDX-License-Identifier: BSD-3-Clause
// What happened, in the user's names.
#pragma once

#include <string>
#include <vector>

#include "analysis/constrained_sensitivity.h"
#include "analysis/singular_start.h"
#include "assembly/assembly.h"
#include "event/event_log.h"

namespace gelenk {

// The branches found: start values of all scalar coordinates, and by how much guesses had to move. found: by island.
std::string describe_assembly(const Scene& scene, const ReducedScene& reduced, const std::vector<Assembled>& found);

// Why no start values satisfy the loops of an island.
std::string describe_failure(const Scene& scene, const ReducedScene& reduced, int island, const CannotAssemble& fault);

// The fixed velocities lead along no branch of a singular start.
std::string describe_no_branch(const Scene& scene, const ReducedScene& reduced, int island, const SingularStart& start);
// A start in or beside a singular configuration, and what it leaves open.
std::string describe_singular_start(const Scene& scene, const ReducedScene& reduced, int island,
                                    const SingularStart& start);

// Joints of the scene around the loop that a cut closes, ascending.
std::vector<int> joints_of_loop(const Mechanism& mechanism, int cut);

// No rest was found from the start values: the acceleration that stays at best.
std::string describe_unrest(const Scene& scene, const ReducedScene& reduced, int island, int speed,
                            double acceleration);
// A rest is asked for while a motion goes on.
std::string describe_moving_drive(const Scene& scene, int constraint);

std::string describe_undefined_rows(const Scene& scene, const Cut& cut);
// A link that moves without inertia.
std::string describe_massless(const Scene& scene, const std::string& link);

// The same of a link that had inertia at the start; t [s]: of the last good state.
std::string describe_lost_inertia(double t, const std::string& link);

// No derivatives at t [s]. states: the coordinates by which they were taken.
std::string describe_undetermined(const Scene& scene, const NotDifferentiablePoint& fault, double t,
                                  const std::vector<std::string>& states);
// Loops that can be closed in two ways which are equally near to the start values: one of the coordinates in which
// these differ, in SI units, in the one that is taken and in the other.
std::string describe_equal_assemblies(const Scene& scene, const std::string& coordinate, double taken, double other);
// The ends of a spring meet at the start.
std::string describe_collapsed_spring(const Scene& scene, int force);

// A tolerance that the integrator's steps are too coarse for, whatever is asked of them.
std::string describe_finest(const std::string& integrator, double tolerance, double finest);

// A step that was refused.
// The step to `end` was left at t, its evaluations budget_exhausted.
std::string describe_cut_short(double t, double end, long evaluations);

std::string describe_refusal(const std::string& cause, double good_time);

std::string describe_event(const EventReport& event);

}  // namespace gelenk
