// SPDX-License-Identifier: BSD-3-Clause
// The start of a run with closed loops: as the scene has them or, where redundant constraint equations contradict each
// other because numbers were rounded, with joint frames moved until they agree.
#include <algorithm>
#include <cmath>
#include <utility>

#include "assembly/loop_closure.h"
#include "scene/words.h"
#include "simulation/simulation_impl.h"
#include "simulation/start_report.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Numbers with fewer digits than four are no mechanism's dimensions.
constexpr double fewest_digits = 1e-3;
constexpr int most_rows = 300;  // of all loops: beyond, a search for a sufficient tolerance would take long

// Of the largest pivot: regular positions of rigid frameworks have smallest ones of 1e-3 and more.
constexpr double beside_singular = 1e-3;

std::string prefix(const Scene& scene) { return scene.file.empty() ? "" : scene.file + ": "; }

std::string advice(const Scene& scene, double from, double most) {
  int rows = 0;
  for (const Mechanism& mechanism : reduce(scene).islands) rows += mechanism.rows;
  if (rows > most_rows) return {};
  const double tolerance = sufficient_tolerance(scene, from, most);
  if (tolerance == 0) return {};
  return " If its numbers are rounded, assembly: {tolerance: " + text::rounded(tolerance, 1) +
         "} would do: " + describe_moves(scene, adjust(scene, tolerance).moved) + ".";
}

// Bodies that stand still although only a position beside a singular one holds them: names, for people.
std::vector<std::string> hardly_held(const Scene& scene, const PreparedScene& prepared) {
  std::vector<std::string> out;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const BodyPlace& place = prepared.reduced.bodies[b];
    if (place.island < 0 || place.rod >= 0) continue;
    const MobilityAnalysis& mobility = prepared.islands[static_cast<std::size_t>(place.island)].mobility;
    const auto& standing = mobility.immobile_links;
    const auto link = static_cast<std::size_t>(place.link);
    const bool sound = std::isfinite(mobility.best_pivot_ratio) && mobility.best_pivot_ratio >= beside_singular;
    if (!sound && link < standing.size() && standing[link]) {
      out.push_back(scene.bodies[b].name);
    }
  }
  return out;
}

}  // namespace

void Simulation::Impl::take(AdjustedScene adjusted) {
  moved = std::move(adjusted.moved);
  if (moved.empty()) return;
  scene = std::move(adjusted.scene);
  reduced = reduce(scene);
}

// What was moved by more than what loops may gape by anyway is told as a doubt about the start.
void Simulation::Impl::tell_moves() {
  const std::string moves = describe_moves(scene, moved);
  if (moves.empty()) return;
  prepared.report += "; " + moves;
  if (scene.assembly.tolerance == 0) return;
  prepared.warnings.push_back(prefix(scene) + "assembly.tolerance = " + text::rounded(scene.assembly.tolerance, 3) +
                              ": " + moves);
}

void Simulation::Impl::prepare_start() {
  close_loops();
  tell_moves();
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
    if (fits) take(std::move(adjusted));
  };
  if (scene.assembly.tolerance > 0) fit();
  prepare_or_advise(tolerance);
  if (!prepared.doubtful) return;
  if (scene.assembly.tolerance == 0) {
    fit();
    if (!moved.empty()) prepare_or_advise(tolerance);
    if (!prepared.doubtful) return;
  }
  const std::string remedy = advice(scene, tolerance, fewest_digits);
  if (!remedy.empty()) {
    throw AssemblyError(prefix(scene) + "the loops close at the start values, but not beside them." + remedy);
  }
  const std::vector<std::string> held = hardly_held(scene, prepared);
  prepared = prepare(scene, reduced, time, u);
  if (!held.empty()) {
    prepared.warnings.push_back(
        prefix(scene) + "the loops close in a position beside a singular configuration, in which " + text::list(held) +
        " cannot move at all. If they are meant to, give start values that close the loops on "
        "the branch of motion that is meant");
    return;
  }
  if (fits) return;  // what is doubtful is meant
  prepared.warnings.push_back(prefix(scene) +
                              "the loops close at the start, but redundant constraint equations contradict each other "
                              "beside it, and steps may fail to close them again");
}

// As far as there is no doubt. Where a loop stays open, the message says what tolerance would close it.
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

}  // namespace gelenk
