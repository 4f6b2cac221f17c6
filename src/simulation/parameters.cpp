// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/parameters.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "formulation/formulation.h"
#include "integrator/integrator.h"
#include "joint/kinds.h"
#include "scene/quantity_groups.h"
#include "scene/settable.h"
#include "scene/touching_laws.h"
#include "scene/words.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Items of an enumeration: names and what they mean.
struct Items {
  std::vector<std::string> names, summaries;

  template <class Kinds>
  Items& add(const Kinds& kinds) {
    for (const auto& kind : kinds) {
      names.emplace_back(kind.name);
      summaries.emplace_back(kind.summary);
    }
    return *this;
  }
};

// access(scene) returns a reference to the number, for a Scene and for a const Scene.
template <class Access>
Parameter real_parameter(std::string name, std::string_view unit, std::string description, Access access) {
  Parameter p;
  p.name = std::move(name);
  p.unit = unit;
  p.description = std::move(description);
  p.get = [access](const Scene& scene) -> double { return access(scene); };
  p.put = [access](Scene& scene, double value) { access(scene) = value; };
  return p;
}

Parameter parameter_of(const Scene& scene, const SettableNumber& number) {
  Parameter p;
  p.name = number.variable(scene);
  p.unit = number.unit(scene);
  p.description = number.owner(scene) + ": " + number.description(scene);
  p.min = number.min();
  p.tunable = number.tunable();
  p.keeps_positions = number.keeps_positions();
  p.get = [number](const Scene& s) { return number.get(s); };
  p.put = [number](Scene& s, double value) { number.put(s, value); };
  return p;
}

bool is_fixed(const JointStart& start) {
  const auto any = [](const std::vector<bool>& flags) { return std::ranges::find(flags, true) != flags.end(); };
  return any(start.q_fixed) || any(start.v_fixed);
}

void fix(JointStart& start, bool fixed) {
  start.q_fixed.assign(start.q.size(), fixed);
  start.v_fixed.assign(start.v.size(), fixed);
  if (!fixed) return;  // given values remain guesses
  start.q_given.assign(start.q.size(), true);
  start.v_given.assign(start.v.size(), true);
}

// The elements of one array: the first and one past the last.
struct IndexRange {
  std::size_t first, last;
};

// The quantities in the same array as quantity i: "Q[1]" to "Q[4]".
IndexRange array_around(std::span<const Quantity> all, std::size_t i) {
  const auto base = [&](std::size_t k) { return all[k].name.substr(0, all[k].name.find('[')); };
  IndexRange range{i, i + 1};
  while (range.first > 0 && base(range.first - 1) == base(i)) --range.first;
  while (range.last < all.size() && base(range.last) == base(i)) ++range.last;
  return range;
}

Parameter start_value(const std::string& joint, std::size_t j, std::span<const Quantity> quantities, bool speed,
                      std::size_t i) {
  const Quantity& quantity = quantities[i];
  const IndexRange array = array_around(quantities, i);
  Parameter p;
  p.name = start_parameter(joint, quantity.name);
  p.unit = quantity.unit;
  p.description = joint + ": start value (exact if " + joint + ".fixed, otherwise an initial guess) of " +
                  std::string(quantity.description);
  p.get = [=](const Scene& scene) {
    const JointStart& start = scene.joints[j].start;
    return (speed ? start.v : start.q)[i];
  };
  p.put = [=](Scene& scene, double value) {
    JointStart& start = scene.joints[j].start;
    const bool fixed = is_fixed(start);
    (speed ? start.v : start.q)[i] = value;
    if (!speed) start.q_set.resize(start.q.size());
    if (!speed) start.q_set[i] = true;
    for (std::size_t k = array.first; k < array.last; ++k) {  // an array is given or fixed as a whole
      (speed ? start.v_given : start.q_given)[k] = true;
      if (fixed) (speed ? start.v_fixed : start.q_fixed)[k] = true;
    }
  };
  return p;
}

void add_starts(std::vector<Parameter>& table, const Scene& scene) {
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const JointKind* kind = find_joint_kind(joint.type);
    if (kind == nullptr || kind->nv == 0) continue;
    for (std::size_t i = 0; i < kind->q.size(); ++i) table.push_back(start_value(joint.name, j, kind->q, false, i));
    for (std::size_t i = 0; i < kind->v.size(); ++i) table.push_back(start_value(joint.name, j, kind->v, true, i));
    Parameter fixed;
    fixed.name = joint.name + ".fixed";
    fixed.description =
        joint.name + ": whether start values are exact; otherwise they are initial guesses for assembly";
    fixed.type = ParameterType::boolean;
    fixed.get = [j](const Scene& s) { return is_fixed(s.joints[j].start) ? 1.0 : 0.0; };
    fixed.put = [j](Scene& s, double value) { fix(s.joints[j].start, value != 0); };
    table.push_back(std::move(fixed));
  }
  for (std::size_t i = 0; i < scene.states.size(); ++i) {
    const ElementState& state = scene.states[i];
    table.push_back(real_parameter(start_parameter(state.name), state.unit, "start value of " + state.name,
                                   [i](auto& s) -> auto& { return s.states[i].start; }));
  }
}

void add_gravity(std::vector<Parameter>& table) {
  static constexpr const char* axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    table.push_back(
        real_parameter("gravity[" + std::to_string(i + 1) + "]", "m/s2",
                       std::string("gravitational acceleration, ") + axes[i] + " component in the world frame",
                       [i](auto& scene) -> auto& { return scene.gravity[i]; }));
    table.back().tunable = true;
  }
}

Parameter choice(const char* name, const char* description, Items items, std::string Solver::* field) {
  Parameter p;
  p.name = name;
  p.description = description;
  p.type = ParameterType::enumeration;
  p.items = std::move(items.names);
  p.item_summaries = std::move(items.summaries);
  p.min = 1;
  p.max = static_cast<double>(p.items.size());
  p.get = [items = p.items, field](const Scene& scene) {
    return 1.0 + static_cast<double>(std::ranges::find(items, scene.solver.*field) - items.begin());
  };
  p.put = [items = p.items, field](Scene& scene, double value) {
    scene.solver.*field = items[static_cast<std::size_t>(value) - 1];
  };
  return p;
}

Parameter count(const char* name, const char* description, IntRange range, int Solver::* field) {
  Parameter p;
  p.name = name;
  p.description = description;
  p.type = ParameterType::integer;
  p.min = range.min;
  p.max = range.max;
  p.get = [field](const Scene& scene) { return static_cast<double>(scene.solver.*field); };
  p.put = [field](Scene& scene, double value) { scene.solver.*field = static_cast<int>(value); };
  return p;
}

void add_cone_tolerance(std::vector<Parameter>& table) {
  Parameter cone_tolerance = real_parameter(
      "solver.cone_tolerance", "1", "moreau-jean: residual of the velocities of contacts, relative to the largest one",
      [](auto& scene) -> auto& { return scene.solver.cone_tolerance; });
  cone_tolerance.min = words::min_cone_tolerance;
  cone_tolerance.max = words::max_cone_tolerance;
  table.push_back(std::move(cone_tolerance));
}

void add_solver(std::vector<Parameter>& table) {
  Parameter tolerance =
      real_parameter("solver.tolerance", "1",
                     "relative tolerance of the integrator; absolute for values below 1 rad, 1 m, 1 rad/s and 1 m/s",
                     [](auto& scene) -> auto& { return scene.experiment.tolerance; });
  tolerance.min = 1e-15;  // below, error estimates of steps consist of rounding errors only
  tolerance.max = 1;
  table.push_back(std::move(tolerance));
  Parameter rounded = real_parameter("assembly.tolerance", "1",
                                     "maximum adjustment of joint frames [rad; relative to the size of the mechanism] "
                                     "by which loops with rounded dimensions are made to close; 0: at most 1e-9",
                                     [](auto& scene) -> auto& { return scene.assembly.tolerance; });
  rounded.min = 0;
  rounded.max = words::max_assembly_tolerance;
  table.push_back(std::move(rounded));
  Parameter step = real_parameter("solver.step", "s", "step of fixed-step methods; 0: derived from the default step",
                                  [](auto& scene) -> auto& { return scene.solver.step; });
  step.min = 0;
  table.push_back(std::move(step));
  table.push_back(choice("solver.formulation", "formulation of the constraint equations for the integrator",
                         Items().add(formulation_kinds()), &Solver::formulation));
  table.push_back(
      choice("solver.integrator", "integration method", Items().add(integrator_kinds()), &Solver::integrator));
  Items starts;
  starts.names = words::starts;
  starts.summaries = {"the start values", "the equilibrium under the inputs that is found from the start values"};
  table.push_back(choice("solver.start", "initial state of a run", std::move(starts), &Solver::start));
  const auto gain = [&](const char* name, const char* on, double Solver::* field) {
    Parameter p = real_parameter(name, "1/s", std::string("baumgarte: gain on ") + on + "; 0: derived from the step",
                                 [field](auto& scene) -> auto& { return scene.solver.*field; });
    p.min = 0;
    table.push_back(std::move(p));
  };
  gain("solver.baumgarte_alpha", "the constraint errors at velocity level", &Solver::baumgarte_alpha);
  gain("solver.baumgarte_beta", "the constraint errors at position level (enters as its square)",
       &Solver::baumgarte_beta);
  Parameter rho_inf =
      real_parameter("solver.rho_inf", "1", "generalized-alpha, hht: spectral radius at infinite frequency",
                     [](auto& scene) -> auto& { return scene.solver.rho_inf; });
  rho_inf.min = 0;
  rho_inf.max = 1;
  table.push_back(std::move(rho_inf));
  table.push_back(
      count("solver.max_evaluations",
            "maximum number of evaluations of the equations of motion per island and communication step; if "
            "exceeded, the step ends early, with status Discard at the time reached",
            words::max_evaluations, &Solver::max_evaluations));
  table.push_back(
      count("solver.corrections",
            "projection: fixed number of position corrections, and of velocity corrections, after each step, so "
            "that all steps cost the same; 0: as many as close the loops",
            words::corrections, &Solver::corrections));
  Items evaluations;
  evaluations.names = words::equations;
  evaluations.summaries = {"at present the same as traced", "by the general kernels",
                           "by a program that is made for the scene when a run begins, where that is possible"};
  table.push_back(
      choice("solver.equations", "evaluation of the equations of motion", std::move(evaluations), &Solver::equations));
}

void add_listed(std::vector<Parameter>& table, const Scene& scene) {
  if (scene.parameters.empty()) return;
  const std::vector<SettableNumber> known = settable_numbers(scene);
  std::unordered_map<std::string, std::vector<const SettableNumber*>> named;
  for (const SettableNumber& number : known) {
    const std::string path = number.path(scene);
    const std::string index = number.index();
    named[path].push_back(&number);
    if (!index.empty()) named[path + index].push_back(&number);
  }
  for (const std::string& path : scene.parameters) {
    if (path.substr(0, path.find('[')) == "gravity") continue;  // always a parameter
    const auto found = named.find(path);
    if (found == named.end()) {
      throw SceneError({"parameters: found '" + path + "', expected the path of a number that can be set"});
    }
    for (const SettableNumber* number : found->second) table.push_back(parameter_of(scene, *number));
  }
}

std::string allowed(const Parameter& p) {
  if (p.type == ParameterType::boolean) return "false (0) or true (1)";
  if (p.type == ParameterType::enumeration) {
    std::string text;
    for (std::size_t i = 0; i < p.items.size(); ++i) {
      text += (i > 0 ? ", " : "") + std::to_string(i + 1) + " (" + p.items[i] + ")";
    }
    return p.items.size() == 1 ? text : "one of " + text;
  }
  if (p.type == ParameterType::integer) {
    return "a whole number from " + text::number(p.min) + " to " + text::number(p.max);
  }
  const std::string unit = p.unit.empty() || p.unit == "1" ? "" : " " + p.unit;
  if (std::isinf(p.min) && std::isinf(p.max)) return "a finite number";
  if (std::isinf(p.max)) return "at least " + text::number(p.min) + unit;
  return "between " + text::number(p.min) + " and " + text::number(p.max) + unit;
}

}  // namespace

std::vector<Parameter> scene_parameters(const Scene& scene) {
  std::vector<Parameter> table;
  add_starts(table, scene);
  add_gravity(table);
  add_solver(table);
  if (has_touching_laws(scene)) add_cone_tolerance(table);
  add_listed(table, scene);
  return table;
}

void check_parameter(const Parameter& parameter, double value) {
  const bool whole = parameter.type == ParameterType::real || value == std::floor(value);
  const bool in_range = parameter.type == ParameterType::boolean ? value == 0 || value == 1
                                                                 : parameter.min <= value && value <= parameter.max;
  if (!std::isfinite(value) || !whole || !in_range) {
    throw std::invalid_argument(parameter.name + ": found " + text::number(value) + ", expected " + allowed(parameter));
  }
}

void set_parameter(Scene& scene, const Parameter& parameter, double value) {
  check_parameter(parameter, value);
  if (value != parameter.get(scene)) parameter.put(scene, value);
}

}  // namespace gelenk
