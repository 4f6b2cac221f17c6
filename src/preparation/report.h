// SPDX-License-Identifier: BSD-3-Clause
// Messages about preparation and steps, in the names of the scene and in SI units.
#pragma once

#include <string>
#include <vector>

#include "analysis/constrained_sensitivity.h"
#include "analysis/singular_start.h"
#include "assembly/assembly.h"
#include "event/event_log.h"
#include "event_driven/law_edge.h"
#include "mechanism/mechanism.h"
#include "scene/scene.h"
#include "scene/signals.h"

namespace gelenk {

// Describes the assembly: start values of all scalar coordinates, and by how much guesses were changed. found: by
// island.
std::string describe_assembly(const Scene& scene, const ReducedScene& reduced, const std::vector<Assembled>& found);

// Describes why no start values satisfy the constraint equations of an island.
std::string describe_failure(const Scene& scene, const ReducedScene& reduced, int island, const CannotAssemble& fault);

// Describes that the fixed velocities are not those of any branch at a singular start.
std::string describe_no_branch(const Scene& scene, const ReducedScene& reduced, int island, const SingularStart& start);
// Describes a start in or near a singular configuration, and what is undetermined there.
std::string describe_singular_start(const Scene& scene, const ReducedScene& reduced, int island,
                                    const SingularStart& start);

// Describes a start from which loops move a coordinate beyond its limit. indicator: see LockModes::State.
std::string describe_unstoppable(const Scene& scene, const Loads& loads, int indicator);

// Describes each coordinate, and each swing of a ball joint, that is beyond one of its limits at the position q.
// `dynamics` is left there.
std::vector<std::string> describe_violated_swings(const Scene& scene, const Mechanism& mechanism, Dynamics& dynamics,
                                                  const double* q);
std::vector<std::string> describe_violated_limits(const Scene& scene, const Loads& loads, Dynamics& dynamics,
                                                  const double* q);

// Returns the joints of the scene in the loop that a cut closes, in ascending order.
std::vector<int> joints_of_loop(const Mechanism& mechanism, int cut);

// Describes that no equilibrium was found; left [SI]: the largest of the smallest residual accelerations found.
std::string describe_no_equilibrium(const Scene& scene, const Signal& acceleration, double left);
// Describes that an equilibrium is requested while a prescribed motion has a velocity.
std::string describe_moving_drive(const Scene& scene, int constraint);

// Describes a constraint whose equations are undefined at the start.
std::string describe_undefined_rows(const Scene& scene, const Cut& cut);
// Describes a link that moves without inertia.
std::string describe_massless(const Scene& scene, const std::string& link);

// Describes a link that had inertia at the start but lost it; t [s]: time of the last valid state.
std::string describe_lost_inertia(double t, const std::string& link);

// Describes why derivatives do not exist at t [s]. states: the independent coordinates.
std::string describe_undetermined(const Scene& scene, const NotDifferentiablePoint& fault, double t,
                                  const std::vector<std::string>& states);
// Describes that loops can be closed in two positions equally close to the start values. coordinate: one in which they
// differ; taken, other: its value [SI] in the chosen position and in the other one.
std::string describe_equal_assemblies(const Scene& scene, const std::string& coordinate, double taken, double other);
// Describes a spring whose ends coincide at the start.
std::string describe_collapsed_spring(const Scene& scene, int force);

// Describes that the integrator auto makes time steps from the start. reason: see reason_for_time_steps(); accuracy: of
// a step [natural units].
std::string describe_time_steps(const Scene& scene, const std::string& reason, double accuracy);

// Describes a tolerance smaller than the errors `finest` that the integrator can achieve.
std::string describe_unreachable_tolerance(const std::string& integrator, double tolerance, double finest);

// Describes a step to `end` [s] that ended at t [s] because the evaluation budget was exhausted.
// obstacle: what hinders the motion there, or empty.
std::string describe_exhausted_budget(double t, double end, long evaluations, const std::string& obstacle);

// Describes a failed step; good_time [s]: time of the state that is kept.
std::string describe_failed_step(const std::string& cause, double good_time);

// Describes an event with its time.
std::string describe_event(const EventReport& event);

// Says something about a contact at t: "t = 0 s: contacts.c is ...".
std::string describe_closed_contact(const Scene& scene, int contact, const std::string& what, double t);
// Why no derivatives exist where the force of a contact is at the edge of its law.
std::string describe_contact_edge(const Scene& scene, const LawEdge& edge, double t);

// Why no derivatives exist where a force with modes (its index among those of the island) is between two of them.
std::string describe_mode_boundary(const Scene& scene, const Loads& loads, int force, double t);

}  // namespace gelenk
