// SPDX-License-Identifier: BSD-3-Clause
#include "batch/varied_scene.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "batch/equation_check.h"
#include "decomposition/dense.h"
#include "recording/recorded.h"
#include "scene/words.h"
#include "scene_file/read.h"
#include "simulation/simulation.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Operations grow with the cube of their number; beyond it, recording takes longer than most runs.
constexpr std::size_t most_velocities = 64;

std::string prefix_of(const Scene& scene) { return (scene.file.empty() ? scene.name : scene.file) + ": "; }

// What is 0 or 1, such as a damping or a factor, is left out of the equations. To have those in which it may be any
// number, it is another one, so near that it has no effect.
double nearby(double value) {
  constexpr double tiny = 1e-200;
  if (value == 0) return tiny;
  return std::abs(value) == 1 ? std::nextafter(value, 2 * value) : value;
}

// The parameters with these names, in this order.
std::vector<Parameter> named(const Scene& scene, const std::vector<std::string>& names) {
  const std::vector<Parameter> all = scene_parameters(scene);
  std::vector<Parameter> out;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(all, name, &Parameter::name);
    if (found == all.end()) throw UsageError(name + ": no such parameter");
    if (found->type != ParameterType::real || name.starts_with("solver.") || name.starts_with("assembly."))
      throw UsageError(name + ": the same for all lanes; expected a number of the mechanism");
    out.push_back(*found);
  }
  return out;
}

// What no lane can do, in the names of the scene.
void refuse_unsuited(const Scene& scene, const SceneEquations& equations) {
  std::vector<std::string> faults;
  for (const std::string& note : equations.notes)
    faults.push_back(prefix_of(scene) + note + " Lanes need equations that hold everywhere.");
  if (scene.solver.start != words::starts.front())
    faults.push_back(prefix_of(scene) + "solver.start: found " + scene.solver.start + ", expected " +
                     words::starts.front() + ": lanes begin with the start values, such as those of an equilibrium");
  for (const std::string& name : equations.prescribed)
    faults.push_back(prefix_of(scene) + name + ": found a prescribed motion, expected forces and motors only");
  if (equations.v.size() > most_velocities)
    faults.push_back(prefix_of(scene) + "found " + std::to_string(equations.v.size()) +
                     " velocities of joints, expected at most " + std::to_string(most_velocities) +
                     "; gelenk.sweep runs mechanisms of any size");
  if (equations.has_kinks)
    faults.push_back(prefix_of(scene) +
                     "found expressions with branches (abs, min, if, ...), at which steps end; lanes step together");
  if (!faults.empty()) throw SceneError(faults);
}

// In motion: at rest, many terms vanish. Velocities that contradict constraint equations would make redundant ones
// contradict each other.
LaneStart expected(const TracedScene& scene) {
  const SceneEquations& equations = scene.equations();
  std::vector<double> q;
  std::vector<double> u;
  for (const EquationArgument& of : equations.q) q.push_back(of.start);
  for (const EquationArgument& of : equations.u) u.push_back(of.start);
  const auto n = static_cast<Eigen::Index>(equations.v.size());
  Eigen::VectorXd v(n);
  for (Eigen::Index k = 0; k < n; ++k)
    v[k] = 0.3 + 0.37 * static_cast<double>(k % 5) - 0.11 * static_cast<double>(k % 7);
  const double speed = v.lpNorm<Eigen::Infinity>();
  const auto as_list = [&] { return std::vector<double>(v.begin(), v.end()); };
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  if (!equations.rows.empty()) {
    const EquationValues values = scene.values(q, as_list(), u);
    const Eigen::Map<const RowMajor> J(values.J.data(), static_cast<Eigen::Index>(equations.rows.size()), n);
    v -= least_norm_solution(J, J * v);
  }
  const EquationValues values = scene.values(q, as_list(), u);
  LaneStart out{.numbers = {}, .state = q, .v = as_list(), .vdot = values.vdot, .size = speed * speed};
  for (const EquationArgument& of : equations.v) out.state.push_back(of.start);
  out.state.insert(out.state.end(), u.end() - static_cast<std::ptrdiff_t>(equations.states.size()), u.end());
  for (std::size_t k = 0; k < out.vdot.size(); ++k) {
    const double mass = values.M[k * out.vdot.size() + k];
    out.size = std::max({out.size, std::abs(out.vdot[k]), mass > 0 ? std::abs(values.h[k] / mass) : 0});
  }
  return out;
}

}  // namespace

VariedScene::VariedScene(const Scene& scene, const std::vector<std::string>& parameters)
    : scene_(scene), parameters_(named(scene, parameters)) {
  const NumberedScene first = numbered(scene);
  refuse_unsuited(scene, first.scene->equations());
  if (parameters.empty()) {
    record(scene, first, first);
    return;
  }
  const NumberedScene others = changed();
  if (record(scene, first, others)) return;
  const Scene other = without_special_values(values(), Replaced::all);
  if (!record(other, numbered(other), others)) throw other_equations(nullptr);
}

// Whether the equations of the scene are those of the changed one, too, but for numbers. first: the scene, traced.
bool VariedScene::record(const Scene& scene, const NumberedScene& first, const NumberedScene& changed) {
  if (first.numbers.size() != changed.numbers.size()) return false;
  varied_ = std::make_unique<VariedNumbers>(first.numbers, changed.numbers);
  const recording::NumberList list(varied_->variables());
  recorded_ = std::make_unique<TracedScene>(scene);
  std::vector<double> found;
  return find(first, *first.scene, found) && find(changed, *changed.scene, found);
}

// The values of the variables in a scene of which the numbers are listed, if with them the equations are those wanted.
bool VariedScene::find(const NumberedScene& scene, const TracedScene& wanted, std::vector<double>& out) const {
  out.resize(static_cast<std::size_t>(numbers()));
  return varied_->find(scene.numbers, out.data()) && are_equations_of(wanted, equations(), out);
}

std::vector<double> VariedScene::values() const {
  std::vector<double> out;
  for (const Parameter& parameter : parameters_) out.push_back(parameter.get(scene_));
  return out;
}

Scene VariedScene::with(const std::vector<double>& values) const {
  Scene out = scene_;
  for (std::size_t k = 0; k < parameters_.size(); ++k) set_parameter(out, parameters_[k], values[k]);
  return checked(out);
}

// With these values, or others nearby: all of them, or those of which 0 is no other law. Those of expressions may be
// switches.
Scene VariedScene::without_special_values(const std::vector<double>& values, Replaced which) const {
  std::vector<double> own = values;
  for (std::size_t k = 0; k < own.size(); ++k) {
    const bool is_of_expressions = std::ranges::find(scene_.constants, parameters_[k].name,
                                                     &FormulaNames::Constant::name) != scene_.constants.end();
    if (which == Replaced::all || !is_of_expressions) own[k] = nearby(own[k]);
  }
  return with(own);
}

// All parameters with other values: what depends on them is another number. They change by different amounts, unless
// they contradict each other then; so do the moments of inertia of a rod that are equal.
NumberedScene VariedScene::changed() const {
  struct Change {
    double size;  // of their values; some are at their limits
    double spread;
  };
  constexpr Change changes[] = {{1e-3, 0.7}, {-1e-3, 0.7}, {1e-6, 0.7}, {-1e-6, 0.7},
                                {1e-3, 0},   {-1e-3, 0},   {-1e-6, 0}};
  const std::vector<double> now = values();
  std::string why;
  for (const Change& change : changes) {
    std::vector<double> others;
    for (std::size_t k = 0; k < now.size(); ++k) {
      const double share = static_cast<double>(k + 1) / static_cast<double>(now.size() + 1);
      const double own = change.size * (1 + change.spread * share);
      others.push_back(now[k] == 0 ? own : now[k] * (1 + own));
    }
    try {
      return numbered(with(others));
    } catch (const SceneError& e) {
      why = e.lines().front();
    } catch (const std::runtime_error& e) {  // loops that do not close
      why = e.what();
    } catch (const std::invalid_argument& e) {
      why = e.what();
    }
  }
  throw SceneError({prefix_of(scene_) + "with slightly other values of the parameters: " + why});
}

LaneStart VariedScene::start(const std::vector<double>& values, const std::string& prefix) const {
  try {
    NumberedScene scene = numbered(with(values));
    std::vector<double> found;
    if (!find(scene, *scene.scene, found)) {
      scene = numbered(without_special_values(values, Replaced::all));
      const TracedScene wanted(without_special_values(values, Replaced::numbers_of_elements));
      if (!find(scene, wanted, found)) throw other_equations(&values);
    }
    LaneStart out = expected(*scene.scene);
    out.numbers = found;
    return out;
  } catch (const std::invalid_argument& e) {
    throw UsageError(prefix + e.what());
  } catch (const SceneError& e) {
    std::vector<std::string> lines = e.lines();
    for (std::string& line : lines) line = prefix + line;
    throw SceneError(lines);
  } catch (const AssemblyError& e) {
    throw AssemblyError(prefix + e.what());
  }
}

// What no program for all lanes can do: names the first parameter that causes it alone. values: of a lane; null: of
// any.
SceneError VariedScene::other_equations(const std::vector<double>* values) const {
  const auto named = [&](std::size_t k) {
    return parameters_[k].name + (values == nullptr ? "" : " = " + text::number((*values)[k]));
  };
  std::string found = parameters_.size() == 1 ? named(0) : "the parameters together";
  for (std::size_t k = 0; parameters_.size() > 1 && k < parameters_.size(); ++k) {
    try {
      const VariedScene alone(scene_, {parameters_[k].name});
      if (values != nullptr) (void)alone.start({(*values)[k]}, "");
    } catch (const std::exception&) {
      found = named(k);
      break;
    }
  }
  return SceneError({found + ": changes more than numbers of the equations of motion, such as an exponent or a "
                             "branch does; gelenk.sweep can run it"});
}

}  // namespace gelenk
