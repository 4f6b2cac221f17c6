// SPDX-License-Identifier: BSD-3-Clause
// The start of a run with closed loops: as described in the scene or, if redundant constraint equations contradict each
// other because dimensions were rounded, with joint frames adjusted until they are consistent.
#include <algorithm>
#include <cmath>
#include <utility>

#include "assembly/loop_closure.h"
#include "scene/words.h"
#include "simulation/sensitivity.h"
#include "simulation/simulation_impl.h"
#include "simulation/start_report.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Largest assembly tolerance that is suggested: dimensions of a mechanism have four digits or more.
constexpr double max_suggested_tolerance = 1e-3;
// With more constraint equations the search for a sufficient tolerance would take too long.
constexpr int max_rows_for_suggestion = 300;

// Ratio of the smallest to the largest pivot: 1e-3 and more in regular positions of rigid frameworks.
constexpr double min_regular_pivot_ratio = 1e-3;

std::string prefix(const Scene& scene) { return scene.file.empty() ? "" : scene.file + ": "; }

std::string advice(const Scene& scene, double from, double most) {
  int rows = 0;
  for (const Mechanism& mechanism : reduce(scene).islands) rows += mechanism.rows;
  if (rows > max_rows_for_suggestion) return {};
  const double tolerance = sufficient_tolerance(scene, from, most);
  if (tolerance == 0) return {};
  return " If its numbers are rounded, assembly: {tolerance: " + text::rounded(tolerance, 1) +
         "} would do: " + describe_moves(scene, adjust(scene, tolerance).moved) + ".";
}

// Names of bodies that are immobile only because the position is close to a singular one.
std::vector<std::string> immobilized_near_singularity(const Scene& scene, const PreparedScene& prepared) {
  std::vector<std::string> out;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const BodyPlace& place = prepared.reduced.bodies[b];
    if (place.island < 0 || place.rod >= 0) continue;
    const MobilityAnalysis& mobility = prepared.islands[static_cast<std::size_t>(place.island)].mobility;
    const auto& immobile = mobility.immobile_links;
    const auto link = static_cast<std::size_t>(place.link);
    const bool is_regular =
        std::isfinite(mobility.best_pivot_ratio) && mobility.best_pivot_ratio >= min_regular_pivot_ratio;
    if (!is_regular && link < immobile.size() && immobile[link]) {
      out.push_back(scene.bodies[b].name);
    }
  }
  return out;
}

}  // namespace

void Simulation::Impl::adopt(AdjustedScene adjusted) {
  moved = std::move(adjusted.moved);
  if (moved.empty()) return;
  scene = std::move(adjusted.scene);
  reduced = reduce(scene);
}

// Moves beyond the usual closure tolerance give a warning.
void Simulation::Impl::report_moves() {
  const std::string moves = describe_moves(scene, moved);
  if (moves.empty()) return;
  prepared.report += "; " + moves;
  if (scene.assembly.tolerance == 0) return;
  prepared.warnings.push_back(prefix(scene) + "assembly.tolerance = " + text::rounded(scene.assembly.tolerance, 3) +
                              ": " + moves);
}

void Simulation::Impl::prepare_start() {
  close_loops();
  report_moves();
}

void Simulation::Impl::close_loops() {
  if (!moved.empty()) {
    scene = in_units(given, scene.units);
    reduced = reduce(scene);
    moved.clear();
  }
  const double tolerance = std::max(scene.assembly.tolerance, assembled_gap);
  bool fits = true;
  const auto fit = [&] {
    AdjustedScene adjusted = adjust(scene, tolerance);
    fits = adjusted.closes;
    if (fits) adopt(std::move(adjusted));
  };
  if (scene.assembly.tolerance > 0) fit();
  prepare_or_advise(tolerance);
  if (!prepared.doubtful) return;
  if (scene.assembly.tolerance == 0) {
    fit();
    if (!moved.empty()) prepare_or_advise(tolerance);
    if (!prepared.doubtful) return;
  }
  const std::string remedy = advice(scene, tolerance, max_suggested_tolerance);
  if (!remedy.empty()) {
    throw AssemblyError(prefix(scene) + "the loops close at the start values, but not in their neighborhood." + remedy);
  }
  const std::vector<std::string> held = immobilized_near_singularity(scene, prepared);
  prepared = prepare(scene, reduced, time, u);
  if (!held.empty()) {
    prepared.warnings.push_back(
        prefix(scene) + "the loops close in a position near a singular configuration, in which " + text::list(held) +
        " cannot move at all. If motion is intended, give start values that close the loops on the intended "
        "branch of motion");
    return;
  }
  if (fits) return;  // the contradiction is intended
  prepared.warnings.push_back(prefix(scene) +
                              "the loops close at the start, but redundant constraint equations contradict each other "
                              "in its neighborhood, and steps may fail to close them again");
}

// Prepares the scene up to the first doubt (PreparedScene::doubtful). If a loop cannot be closed, the message suggests
// a sufficient tolerance.
void Simulation::Impl::prepare_or_advise(double tolerance) {
  try {
    prepared = prepare(scene, reduced, time, u, true);
  } catch (const OpenLoop& fault) {
    throw AssemblyError(fault.what() +
                        advice(scene, std::max(tolerance, fault.closure_error / 100), words::max_assembly_tolerance));
  }
}

std::vector<MovedFrame> StartReport::moved_frames() const {
  std::vector<MovedFrame> out = impl_.moved;
  for (MovedFrame& frame : out) frame.shift *= impl_.scene.units.size_of("m");
  return out;
}

Scene StartReport::adjusted_scene() const {
  Scene out = impl_.given;
  if (impl_.moved.empty()) return out;
  const double length = impl_.scene.units.size_of("m");
  for (std::size_t j = 0; j < out.joints.size(); ++j) {
    for (BodyFrame Joint::* half : {&Joint::parent, &Joint::child}) {
      const Pose3& X = (impl_.scene.joints[j].*half).X_BF;
      (out.joints[j].*half).X_BF = {X.R, length * X.p};
    }
  }
  return out;
}

const std::string& StartReport::assembly() const { return impl_.prepared.report; }
const std::vector<std::string>& StartReport::warnings() const { return impl_.prepared.warnings; }
const PreparedScene& StartReport::prepared() const { return impl_.prepared; }
int StartReport::kinematic_parts() const {
  return static_cast<int>(std::ranges::count_if(impl_.islands, [&](const auto& island) {
    return is_kinematic(impl_.scene, island->prepared(), island->formulation());
  }));
}

}  // namespace gelenk
