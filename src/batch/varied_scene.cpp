// SPDX-License-Identifier: BSD-3-Clause
#include "batch/varied_scene.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "recording/recorded.h"
#include "scene_file/read.h"
#include "simulation/simulation.h"

namespace gelenk {
namespace {

// Operations grow with the cube of their number; beyond it, recording takes longer than most runs.
constexpr std::size_t most_velocities = 64;

std::string prefix_of(const Scene& scene) { return (scene.file.empty() ? scene.name : scene.file) + ": "; }

// What is 0, such as a damping, is left out of the equations. To have those in which it may be any number, it is so
// small instead that it has no effect.
std::vector<double> without_zeros(std::vector<double> values) {
  constexpr double tiny = 1e-200;
  for (double& value : values) value = value == 0 ? tiny : value;
  return values;
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
    v -= J.completeOrthogonalDecomposition().solve(J * v);
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
  NumberedScene first = numbered(scene);
  refuse_unsuited(scene, first.scene->equations());
  const std::vector<double> others = parameters.empty() ? first.numbers : changed_numbers();
  Scene recorded = scene;
  if (others.size() != first.numbers.size()) {
    recorded = with(without_zeros(values()));
    first = numbered(recorded);
  }
  if (others.size() != first.numbers.size())
    throw SceneError({prefix_of(scene) + "the parameters change more than numbers of the equations of motion"});
  varied_ = std::make_unique<VariedNumbers>(first.numbers, others);
  const recording::NumberList list(varied_->variables());
  recorded_ = std::make_unique<TracedScene>(recorded);
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

// All parameters with other values, by different amounts: all that depends on them is another number.
Scene VariedScene::changed() const {
  constexpr double changes[] = {1e-3, -1e-3, 1e-6, -1e-6};  // of their values; some are at their limits
  const std::vector<double> now = values();
  for (const double change : changes) {
    std::vector<double> others;
    for (std::size_t k = 0; k < now.size(); ++k) {
      const double own = change * (1 + 0.7 * static_cast<double>(k + 1) / static_cast<double>(now.size() + 1));
      others.push_back(now[k] == 0 ? own : now[k] * (1 + own));
    }
    const auto possible = [&]() -> std::optional<Scene> {
      try {
        return with(others);
      } catch (const SceneError&) {
        return std::nullopt;  // they contradict each other
      } catch (const std::invalid_argument&) {
        return std::nullopt;
      }
    };
    if (const std::optional<Scene> scene = possible()) return *scene;
  }
  throw SceneError({prefix_of(scene_) + "no other values of these parameters are possible together"});
}

std::vector<double> VariedScene::changed_numbers() const {
  try {
    return numbered(changed()).numbers;
  } catch (const AssemblyError& e) {
    throw AssemblyError("with slightly other values of the parameters: " + std::string(e.what()));
  }
}

LaneStart VariedScene::start(const std::vector<double>& values, const std::string& prefix) const {
  try {
    NumberedScene scene = numbered(with(values));
    LaneStart out = expected(*scene.scene);
    out.numbers.resize(static_cast<std::size_t>(numbers()));
    if (varied_->find(scene.numbers, out.numbers.data())) return out;
    scene = numbered(with(without_zeros(values)));
    if (varied_->find(scene.numbers, out.numbers.data())) return out;
    throw SceneError({"its parameters change more than numbers of the equations of motion"});
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

}  // namespace gelenk
