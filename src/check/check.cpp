// SPDX-License-Identifier: BSD-3-Clause
#include "check/check.h"

#include <algorithm>
#include <cmath>

#include "math/rotations.h"
#include "scene/words.h"
#include "util/text.h"

namespace gelenk {
namespace {

void check_word(const std::string& word, const std::vector<std::string>& words, const std::string& path, Faults& faults,
                bool partial) {
  if (partial && word.empty()) return;
  if (std::ranges::find(words, word) == words.end()) {
    faults.add(path, text::quoted(word), text::one_of(word, words, "words"));
  }
}

void check_positive(double x, const std::string& path, Faults& faults) {
  if (!(x > 0) || !std::isfinite(x)) faults.add(path, text::number(x) + " s", "more than 0 s");
}

void check_gain(double gain, const char* path, const Solver& solver, Faults& faults) {
  const std::string found = text::number(gain) + " 1/s";
  if (!(gain >= 0) || !std::isfinite(gain)) faults.add(path, found, "0 1/s or more");
  if (gain > 0 && !solver.formulation.empty() && solver.formulation != "baumgarte") {
    faults.add(path, found + " with the formulation " + solver.formulation, "the formulation baumgarte, or 0 1/s");
  }
}

void check_integrator_of_formulation(const Solver& solver, Faults& faults) {
  const auto limited =
      std::ranges::find(words::allowed_integrators, solver.formulation, &words::FormulationIntegrators::formulation);
  if (limited == words::allowed_integrators.end()) return;
  // An unknown integrator has been reported already.
  if (std::ranges::find(words::integrators, solver.integrator) == words::integrators.end()) return;
  const std::vector<std::string>& allowed = limited->integrators;
  if (std::ranges::find(allowed, solver.integrator) != allowed.end()) return;
  faults.add("solver.integrator", text::quoted(solver.integrator) + " with the formulation " + solver.formulation,
             text::one_of({}, allowed, "words") + ", or another formulation");
}

void check_count(int count, IntRange range, const char* path, Faults& faults) {
  if (count >= range.min && count <= range.max) return;
  faults.add(path, std::to_string(count),
             "a whole number from " + std::to_string(range.min) + " to " + std::to_string(range.max));
}

void check_rho_inf(const Solver& solver, Faults& faults) {
  const std::string found = text::number(solver.rho_inf);
  const bool hht = solver.integrator == "hht";
  const double min_rho = hht ? 0.5 : 0;
  if (!(solver.rho_inf >= min_rho && solver.rho_inf <= 1)) {
    faults.add("solver.rho_inf", found + (hht ? " with the integrator hht" : ""),
               "a number from " + text::number(min_rho) + " to 1");
  }
  const bool used = hht || solver.integrator == "generalized-alpha" || solver.integrator.empty();
  if (!used && solver.rho_inf != Solver{}.rho_inf) {
    faults.add("solver.rho_inf", found + " with the integrator " + solver.integrator,
               "the integrator generalized-alpha or hht, or " + text::number(Solver{}.rho_inf));
  }
}

void check_cone_tolerance(const Solver& solver, Faults& faults) {
  const std::string found = text::number(solver.cone_tolerance);
  if (!(solver.cone_tolerance >= words::min_cone_tolerance && solver.cone_tolerance <= words::max_cone_tolerance)) {
    faults.add(
        "solver.cone_tolerance", found,
        "a number from " + text::number(words::min_cone_tolerance) + " to " + text::number(words::max_cone_tolerance));
  }
  const bool used = solver.integrator == "moreau-jean" || solver.integrator == "auto" || solver.integrator.empty();
  if (!used && solver.cone_tolerance != Solver{}.cone_tolerance) {
    faults.add("solver.cone_tolerance", found + " with the integrator " + solver.integrator,
               "the integrator moreau-jean, or " + text::number(Solver{}.cone_tolerance));
  }
}

void check_settings(const Scene& scene, Faults& faults, bool partial) {
  const Experiment& experiment = scene.experiment;
  check_positive(experiment.stop, "experiment.stop", faults);
  check_positive(experiment.step, "experiment.step", faults);
  if (experiment.step > experiment.stop) {
    faults.add("experiment.step", text::number(experiment.step) + " s",
               "at most experiment.stop = " + text::number(experiment.stop) + " s");
  }
  if (!(experiment.tolerance >= words::min_tolerance && experiment.tolerance <= words::max_tolerance)) {
    faults.add("experiment.tolerance", text::number(experiment.tolerance), "a number from 1e-15 to 1");
  }
  if (!(scene.assembly.tolerance >= 0 && scene.assembly.tolerance <= words::max_assembly_tolerance)) {
    faults.add("assembly.tolerance", text::number(scene.assembly.tolerance),
               "0, or a number up to " + text::number(words::max_assembly_tolerance) +
                   ": the rounding error of joint frames [rad, or relative to the size of the mechanism]");
  }
  check_word(scene.solver.formulation, words::formulations, "solver.formulation", faults, partial);
  check_word(scene.solver.integrator, words::integrators, "solver.integrator", faults, partial);
  check_word(scene.solver.equations, words::equations, "solver.equations", faults, partial);
  check_word(scene.solver.start, words::starts, "solver.start", faults, partial);
  check_integrator_of_formulation(scene.solver, faults);
  check_cone_tolerance(scene.solver, faults);
  check_rho_inf(scene.solver, faults);
  if (!(scene.solver.step >= 0) || !std::isfinite(scene.solver.step)) {
    faults.add("solver.step", text::number(scene.solver.step) + " s", "0 s or more");
  }
  check_count(scene.solver.max_evaluations, words::max_evaluations, "solver.max_evaluations", faults);
  check_count(scene.solver.max_events, words::max_events, "solver.max_events", faults);
  check_count(scene.solver.corrections, words::corrections, "solver.corrections", faults);
  check_gain(scene.solver.baumgarte_alpha, "solver.baumgarte_alpha", scene.solver, faults);
  check_gain(scene.solver.baumgarte_beta, "solver.baumgarte_beta", scene.solver, faults);
}

}  // namespace

void check_finite(const double* data, std::size_t size, const std::string& path, Faults& faults) {
  for (std::size_t i = 0; i < size; ++i) {
    if (std::isfinite(data[i])) continue;
    faults.add(size == 1 ? path : path + "[" + std::to_string(i + 1) + "]", text::number(data[i]), "a finite number");
  }
}

void check_frame(const BodyFrame& frame, const Scene& scene, const std::string& path, Faults& faults, bool partial) {
  check_finite(frame.X_BF.p.data(), 3, path + ".position", faults);
  const double error = rotation_error(frame.X_BF.R);
  if (!(error < 1e-9)) {  // a rotation read from a file is orthogonal up to round-off
    faults.add(path + ".rotation", "columns that deviate from orthonormality by " + text::rounded(error), "a rotation");
  }
  if (frame.body == ground || (partial && frame.body.empty())) return;
  if (std::ranges::find(scene.bodies, frame.body, &Body::name) != scene.bodies.end()) return;
  std::vector<std::string> names = {ground};
  for (const Body& body : scene.bodies) names.push_back(body.name);
  faults.add(path + ".body", text::quoted(frame.body), text::one_of(frame.body, names, "bodies"));
}

void find_faults(const Scene& scene, Faults& faults, const SuspectNames& suspect_names) {
  const bool partial = !faults.none();
  if (!partial && scene.bodies.empty()) faults.add("bodies", "nothing", "at least one body");
  if (!partial && scene.joints.empty()) faults.add("joints", "nothing", "at least one joint");
  check_finite(scene.gravity.data(), 3, "gravity", faults);
  check_names(scene, faults);
  check_bodies(scene, faults, partial);
  check_shapes(scene, faults, partial);
  check_joints(scene, faults, partial);
  check_connection(scene, faults);
  check_elements(scene, faults, partial);
  if (!partial) check_motions(scene, faults);
  if (!partial) check_locking(scene, faults);
  check_parameters(scene, faults, suspect_names);
  check_outputs(scene, faults, !faults.none());
  check_settings(scene, faults, partial);
}

bool numbers_are_valid(const Scene& scene) {
  Faults faults(scene.file);
  check_finite(scene.gravity.data(), 3, "gravity", faults);
  check_bodies(scene, faults, false);
  check_joints(scene, faults, false);
  check_elements(scene, faults, false);
  check_motions(scene, faults);
  return faults.none();
}

void check_scene(const Scene& scene) {
  Faults faults(scene.file);
  find_faults(scene, faults);
  faults.raise();
}

}  // namespace gelenk
