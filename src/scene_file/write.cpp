// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "joint/kinds.h"
#include "scene/component_parts.h"
#include "scene/quantity_groups.h"
#include "scene/words.h"
#include "scene_file/element_fields.h"
#include "scene_file/read.h"

namespace gelenk {
namespace {

// Writes a rotation as a matrix: reading does not change a matrix that is orthonormal up to round-off.
void add_pose(Json& out, const Pose3& X) {
  out["position"] = numbers_of(X.p);
  if ((X.R.array() == Eigen::Matrix3d::Identity().array()).all()) return;
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) rows.push_back(numbers_of(Eigen::RowVector3d(X.R.row(i))));
  out["rotation"]["matrix"] = rows;
}

Json frame(const BodyFrame& frame) {
  Json out;
  out["body"] = frame.body;
  add_pose(out, frame.X_BF);
  return out;
}

Json point(const BodyFrame& frame) {
  Json out;
  out["body"] = frame.body;
  out["position"] = numbers_of(frame.X_BF.p);
  return out;
}

template <class Element>
Json section(const std::vector<Element>& elements, Json (*write)(const Element&)) {
  Json out = Json::object();
  for (const Element& element : elements) out[element.name] = write(element);
  return out;
}

// Writes a shape under the name of its kind: {sphere: 0.1, position: [..], surface: wood}.
Json shape(const BodyShape& shape) {
  const ShapeKind& kind = kind_of(*shape.is);
  Json out;
  Json& dimensions = out[std::string(kind.kind)];
  if (kind.of_points) {
    Json points = Json::array();
    for (const Eigen::Vector3d& point : points_of(*shape.is)) points.push_back(numbers_of(point));
    if (kind.of_triangles) {
      dimensions["points"] = std::move(points);
      dimensions["triangles"] = triangles_of(*shape.is);
    } else {
      dimensions = std::move(points);
    }
  } else if (!kind.bounded) {
    dimensions = {0, 0, 1};
  } else {
    write_fields(dimensions, kind.fields, data_of(*shape.is));
    if (kind.fields.size() == 1) dimensions = Json(dimensions.front());
  }
  add_pose(out, shape.X_BS);
  if (!shape.surface.empty()) out["surface"] = shape.surface;
  return out;
}

Json body(const Body& body) {
  const Eigen::Matrix3d& I = body.inertia;
  Json out;
  out["mass"] = body.mass;
  out["com"] = numbers_of(body.com);
  out["inertia"] = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  if (body.pose) {
    out["pose"] = Json::object();
    add_pose(out["pose"], *body.pose);
  }
  if (!body.shapes.empty()) out["shapes"] = section(body.shapes, shape);
  return out;
}

// Writes the groups of coordinates or velocities that have a given value.
void add_start_values(Json& out, Json& fixed, std::span<const Quantity> quantities, const std::vector<double>& values,
                      const std::vector<bool>& given, const std::vector<bool>& held) {
  for (const QuantityGroup& group : groups(quantities)) {
    const auto any = [&](const std::vector<bool>& flags) {
      const auto first = flags.begin() + static_cast<std::ptrdiff_t>(group.first);
      return std::any_of(first, first + static_cast<std::ptrdiff_t>(group.size), [](bool flag) { return flag; });
    };
    if (!any(given) && !any(held)) continue;
    const double* first = values.data() + group.first;
    out[group.name] = group.array ? numbers_of(std::span(first, group.size)) : Json(*first);
    if (any(held)) fixed.push_back(group.name);
  }
}

// Writes the weights that differ from the default, by name.
void add_weights(Json& out, std::span<const Quantity> quantities, const std::vector<bool>& given,
                 const std::vector<double>& weights) {
  for (const QuantityGroup& group : groups(quantities)) {
    const double weight = weights.at(group.first);
    if (given.at(group.first) && weight != default_start_weight) out[group.name] = weight;
  }
}

Json start(const JointStart& start, const JointKind& kind) {
  Json out = Json::object();
  Json fixed = Json::array();
  add_start_values(out, fixed, kind.q, start.q, start.q_given, start.q_fixed);
  add_start_values(out, fixed, kind.v, start.v, start.v_given, start.v_fixed);
  if (!fixed.empty()) out["fixed"] = fixed.size() == out.size() ? Json(true) : fixed;
  Json weights = Json::object();
  add_weights(weights, kind.q, start.q_given, start.q_weight);
  add_weights(weights, kind.v, start.v_given, start.v_weight);
  if (!weights.empty()) out["weight"] = std::move(weights);
  return out;
}

// Writes the forces along the coordinates: of several, numbers as a list, and groups by the name of the coordinate.
void write_forces(Json& out, const Joint& joint, const JointKind& kind) {
  for (const JointForceKind& force : joint_force_kinds()) {
    if (!force.fits(kind)) continue;
    if (!force.group.empty()) {
      for (std::size_t i = 0; i < joint.along.size(); ++i) {
        const void* there = force.in(*joint.along[i]);
        if (there == nullptr) continue;
        Json& group = out[std::string(force.group)];
        const std::string name(coordinate_of(kind, static_cast<int>(i)).name);
        write_fields(kind.nv == 1 || force.of_joint ? group : group[name], force.fields, there);
      }
      continue;
    }
    for (const Field& field : force.fields) {
      Json values = Json::array();
      for (const auto& along : joint.along) values.push_back(field.of<double>(force.in(*along)));
      out[std::string(field.name)] = kind.nv == 1 ? values[0] : values;
    }
  }
}

Json joint(const Joint& joint) {
  Json out;
  out["type"] = joint.type;
  if (joint.axes.size() == 1) out["axis"] = numbers_of(joint.axes[0]);
  if (joint.axes.size() == 2) out["axes"] = {numbers_of(joint.axes[0]), numbers_of(joint.axes[1])};
  out["parent"] = frame(joint.parent);
  out["child"] = frame(joint.child);
  const JointKind* kind = find_joint_kind(joint.type);
  if (kind == nullptr) return out;
  write_fields(out, kind->fields, data_of(*joint.is));
  if (kind->nv == 0) return out;
  Json values = start(joint.start, *kind);
  if (!values.empty()) out["start"] = std::move(values);
  write_forces(out, joint, *kind);
  for (const Field& field : kind->fields) {  // "friction.translation" is in the mapping of "friction"
    const std::size_t dot = field.name.find('.');
    if (dot == std::string_view::npos || !out.contains(field.name)) continue;
    out[std::string(field.name.substr(0, dot))][std::string(field.name.substr(dot + 1))] =
        std::move(out[std::string(field.name)]);
    out.erase(std::string(field.name));
  }
  return out;
}

Json element(const ElementPlace& element, const ElementKind& kind, const void* data, const Section& section) {
  Json out;
  if (section.default_type != kind.kind) out["type"] = kind.kind;
  std::size_t frames = 0;
  std::size_t joints = 0;
  for (const Port& port : kind.ports) {
    const std::string name(port.name);
    if (port.kind == Port::Kind::surfaces) {
      out[name] = element.surfaces;
      continue;
    }
    if (port.kind == Port::Kind::joint) {
      const std::string& joint = element.joints.at(joints++);
      if (!joint.empty()) out[name] = joint;
      if (!element.coordinate.empty()) out["coordinate"] = element.coordinate;
      continue;
    }
    const BodyFrame& at = element.frames.at(frames++);
    const Json written = port.kind == Port::Kind::body    ? Json{{"body", at.body}}
                         : port.kind == Port::Kind::point ? point(at)
                                                          : frame(at);
    if (name.empty()) {
      out.update(written);
    } else {
      out[name] = written;
    }
  }
  write_fields(out, kind.fields, data);
  return out;
}

Json gravity(const Scene& scene) {
  if (!scene.gravity_field) return numbers_of(scene.gravity);
  Json out;
  write_fields(out, GravityField::fields(), &*scene.gravity_field);
  if (!scene.gravity_field->is_central()) out.erase("center");
  if (!scene.gravity.isZero(0)) out["uniform"] = numbers_of(scene.gravity);
  return out;
}

Json table(const SceneTable& table) {
  const expression::Table::Data& data = table.is->data();
  Json out = {{"x", numbers_of(data.x)}};
  if (data.arguments() == 1) {
    out["values"] = numbers_of(data.values);
  } else {
    out["y"] = numbers_of(data.y);
    out["values"] = Json::array();
    for (auto row = data.values.begin(); row != data.values.end();) {
      const auto end = row + static_cast<std::ptrdiff_t>(data.y.size());
      out["values"].push_back(numbers_of(std::span(row, end)));
      row = end;
    }
  }
  const auto beyond = [&](std::size_t k) {
    return expression::extrapolations[static_cast<std::size_t>(data.extrapolation[k])];
  };
  out["interpolation"] = expression::interpolations[static_cast<std::size_t>(data.interpolation)];
  const bool is_same = data.arguments() == 1 || data.extrapolation[0] == data.extrapolation[1];
  out["extrapolation"] = is_same ? Json(beyond(0)) : Json({beyond(0), beyond(1)});
  if (!table.text.empty()) out["text"] = table.text;
  return out;
}

void add_states(Json& out, const Scene& scene) {
  for (const ElementState& of : scene.states) {
    if (!of.component.empty()) continue;
    Json& state = out["states"][of.name] = {{"rate", std::string(of.rate.text())}};
    if (!of.unit.empty()) state["unit"] = of.unit;
    if (of.start != 0) state["start"] = of.start;
    if (of.nominal != 0) state["nominal"] = of.nominal;
    if (!of.text.empty()) state["text"] = of.text;
    for (const StateReset& reset : of.resets)
      state["resets"].push_back({{"when", reset.condition}, {"to", std::string(reset.to.text())}});
  }
}

// What expressions name.
void add_names(Json& out, const Scene& scene) {
  for (const FormulaNames::Constant& constant : scene.constants) out["constants"][constant.name] = constant.value;
  for (const SceneTable& of : scene.tables) out["tables"][of.name] = table(of);
  for (const SceneInput& of : scene.inputs) {
    if (!of.component.empty()) continue;
    Json& input = out["inputs"][of.name] = Json::object();
    if (!of.unit.empty()) input["unit"] = of.unit;
    if (of.start != 0) input["start"] = of.start;
    if (!of.text.empty()) input["text"] = of.text;
  }
  add_states(out, scene);
  for (const NamedExpression& of : scene.expressions) {
    if (!of.component.empty()) continue;
    Json& expression = out["expressions"][of.name] = {{"value", std::string(of.value.text())}};
    if (!of.unit.empty()) expression["unit"] = of.unit;
    if (!of.text.empty()) expression["text"] = of.text;
  }
}

// Without those that components have added, but with the start values of their states.
void add_elements(Json& out, const Scene& scene) {
  each_section(scene, [&](const Section& of, const auto& elements) {
    Json& entries = out[std::string(of.name)] = Json::object();
    for (const auto& e : elements) {
      if (e.component.empty()) entries[e.name] = element(e, kind_of(*e.is), data_of(*e.is), of);
    }
  });
  for (const ElementState& state : scene.states) {
    if (state.component.empty()) continue;
    out[std::string(components_section.name)][state.component]["start"][own_name(state)] = state.start;
  }
}

// Formats JSON with one line per entry of a section: short, but suitable for reading and diffing.
std::string formatted(const Json& tree) {
  std::string out = "{";
  const char* separator = "\n ";
  for (const auto& [key, value] : tree.items()) {
    out += separator + Json(key).dump() + ": ";
    separator = ",\n ";
    const bool entries = value.is_object() && !value.empty() && value.front().is_object();
    if (!entries) {
      out += value.dump();
      continue;
    }
    const char* inner = "{\n  ";
    for (const auto& [name, entry] : value.items()) {
      out += inner + Json(name).dump() + ": " + entry.dump();
      inner = ",\n  ";
    }
    out += "\n }";
  }
  return out + "\n}\n";
}

}  // namespace

std::string write_scene_json(const Scene& scene) {
  Json out;
  out["gelenk"] = scene_version;
  out["name"] = scene.name;
  for (const MetadataKey& key : metadata_keys) {
    if (const std::string& text = scene.metadata.*key.text; !text.empty()) out[std::string(key.name)] = text;
  }
  out["gravity"] = gravity(scene);
  add_names(out, scene);
  if (!scene.ground_shapes.empty()) out["ground"]["shapes"] = section(scene.ground_shapes, shape);
  out["bodies"] = section(scene.bodies, body);
  out["joints"] = section(scene.joints, joint);
  add_elements(out, scene);
  out["parameters"] = scene.parameters;
  if (!scene.outputs.empty()) out["outputs"] = scene.outputs;
  if (scene.assembly.tolerance > 0) out["assembly"] = {{"tolerance", scene.assembly.tolerance}};
  const Experiment& e = scene.experiment;
  out["experiment"] = {{"stop", e.stop}, {"step", e.step}, {"tolerance", e.tolerance}};
  const Solver& s = scene.solver;
  out["solver"] = {{"formulation", s.formulation}, {"integrator", s.integrator}, {"step", s.step}};
  if (s.start != Solver{}.start) out["solver"]["start"] = s.start;
  if (s.equations != Solver{}.equations) out["solver"]["equations"] = s.equations;
  if (s.max_evaluations != Solver{}.max_evaluations) out["solver"]["max_evaluations"] = s.max_evaluations;
  if (s.max_events != Solver{}.max_events) out["solver"]["max_events"] = s.max_events;
  if (s.corrections != Solver{}.corrections) out["solver"]["corrections"] = s.corrections;
  if (s.cone_tolerance != Solver{}.cone_tolerance) out["solver"]["cone_tolerance"] = s.cone_tolerance;
  if (s.rho_inf != Solver{}.rho_inf) out["solver"]["rho_inf"] = s.rho_inf;
  if (s.baumgarte_alpha != 0) out["solver"]["baumgarte_alpha"] = s.baumgarte_alpha;
  if (s.baumgarte_beta != 0) out["solver"]["baumgarte_beta"] = s.baumgarte_beta;
  if (const auto& l = scene.left_out) {
    out["solver"]["left_out"] = {{"length", l->length}, {"travel", l->travel}, {"mass", l->mass}};
  }
  for (int i = 0; i < reduction_count; ++i) {
    if (!s.reductions[i]) out["solver"]["reductions"][words::reductions[i]] = false;
  }
  return formatted(out);
}

}  // namespace gelenk
