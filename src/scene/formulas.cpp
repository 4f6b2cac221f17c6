// SPDX-License-Identifier: BSD-3-Clause
#include "scene/formulas.h"

#include <algorithm>

#include "scene/element_numbers.h"

namespace gelenk {
namespace {

// Calls visit(formula, field, coordinate) for each expression among these fields that is given.
template <class Visit>
void each_of(std::span<const Field> fields, void* element, const Coordinate& coordinate, Visit visit) {
  if (element == nullptr) return;
  for (const Field& field : fields) {
    if (field.type == Field::Type::group) each_of(field.inner(), field.in(element), coordinate, visit);
    for (Formula& formula : formulas_of(field, element)) {
      if (formula.is_given()) visit(formula, field, coordinate);
    }
  }
}

// The same for all expressions, with place(), that of their element, which is that of a joint for forces along it.
template <class Visit>
void each_formula(Scene& scene, Visit visit) {
  for (Joint& joint : scene.joints) {
    const JointKind& kind = *find_joint_kind(joint.type);
    const auto place = [&] {
      return ElementPlace{.name = joint.name, .frames = {}, .joints = {joint.name}, .coordinate = {}};
    };
    for (std::size_t i = 0; i < joint.along.size(); ++i) {
      for (const JointForceKind& force : joint_force_kinds()) {
        each_of(force.fields, force.find(*joint.along[i]), coordinate_of(kind, static_cast<int>(i)),
                [&](Formula& formula, const Field& field, const Coordinate& at) { visit(formula, field, at, place); });
      }
    }
  }
  if (scene.gravity_field) {
    const auto everywhere = [&] {
      ElementPlace place{.name = "gravity", .frames = {}, .joints = {}, .coordinate = {}};
      for (const Body& body : scene.bodies) place.frames.push_back({.body = body.name, .X_BF = {}});
      return place;
    };
    each_of(GravityField::fields(), &*scene.gravity_field, {},
            [&](Formula& formula, const Field& field, const Coordinate& at) { visit(formula, field, at, everywhere); });
  }
  each_section(scene, [&](const Section&, auto& elements) {
    for (auto& element : elements) {
      const auto place = [&]() -> const ElementPlace& { return element; };
      each_of(kind_of(*element.is).fields, data_of(*element.is), coordinate_of(scene, element),
              [&](Formula& formula, const Field& field, const Coordinate& at) { visit(formula, field, at, place); });
    }
  });
}

bool names(const Formula& formula, std::string_view signal) {
  return std::ranges::find(formula.signal_names(), signal) != formula.signal_names().end();
}

}  // namespace

FormulaNames formula_names(const Scene& scene) {
  FormulaNames out{.constants = scene.constants, .signals = {}};
  for (const SceneInput& input : scene.inputs) out.signals.push_back(input.name);
  return out;
}

void renew_formulas(Scene& scene) {
  const FormulaNames names = formula_names(scene);
  each_formula(scene, [&](Formula& formula, const Field& field, const Coordinate& coordinate, const auto&) {
    formula.renew(variables_of(field, coordinate), names, field.reads_signals);
  });
}

void bind_signals(Formula& formula, const Scene& scene, int first_input) {
  for (std::size_t k = 0; k < formula.signal_names().size(); ++k) {
    const auto input = std::ranges::find(scene.inputs, formula.signal_names()[k], &SceneInput::name);
    const int index = first_input + static_cast<int>(input - scene.inputs.begin());
    formula.bind_signal(k, index, input == scene.inputs.end() ? 1 : scene.units.size_of(input->unit));
  }
}

std::vector<ElementPlace> readers_of(const Scene& scene, std::string_view signal) {
  std::vector<ElementPlace> out;
  // NOLINTNEXTLINE(*-const-cast): only read
  each_formula(const_cast<Scene&>(scene),
               [&](const Formula& formula, const Field&, const Coordinate&, const auto& place) {
                 if (names(formula, signal)) out.push_back(place());
               });
  return out;
}

}  // namespace gelenk
