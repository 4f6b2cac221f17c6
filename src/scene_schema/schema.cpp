// SPDX-License-Identifier: BSD-3-Clause
// JSON Schema of scene files: fields, types, sizes, signs. References to names, inertias and everything else that
// requires arithmetic are checked by the reader only.
#include "scene_schema/schema.h"

#include <limits>

#include "joint/kinds.h"
#include "scene/quantity_groups.h"
#include "scene/words.h"
#include "scene_file/read.h"
#include "scene_schema/schema_parts.h"

namespace gelenk {
namespace {

using namespace schema;

Json rotation() {
  Json out;
  out["description"] = "Orientation of a frame; the columns of the matrix are its axes.";
  out["oneOf"] = {
      object({{"quaternion", list(4, "", "Scalar part first: [w, x, y, z]")}}, {"quaternion"}),
      object({{"rpy", list(3, "rad", "Rotations about the fixed x, y, z axes, in this order: R = Rz(y) Ry(p) Rx(r)")}},
             {"rpy"}),
      object({{"axis", list(3, "", "Direction of the axis")},
              {"angle", number("rad", "Angle of rotation about the axis")}},
             {"axis", "angle"}),
      object({{"matrix", {{"type", "array"}, {"items", list(3, "", "A row")}, {"minItems", 3}, {"maxItems", 3}}}},
             {"matrix"})};
  return out;
}

Json pose_fields() { return {{"position", list(3, "m", "Origin of the frame")}, {"rotation", reference("rotation")}}; }

Json frame(bool with_rotation) {
  Json fields;
  fields["body"] = string("Name of a body, or ground");
  fields["position"] = list(3, "m", "Position in the body");
  if (with_rotation) fields["rotation"] = reference("rotation");
  Json out;
  out["description"] =
      "A frame fixed in a body: its pose, or only the name of the body for the frame of the body itself.";
  out["oneOf"] = {string("Name of a body, or ground"), object(fields, {"body"})};
  return out;
}

Json body() {
  const Json moments = list(3, "kg m2", "xx, yy, zz where the body's axes are principal axes");
  const Json all = list(6, "kg m2", "xx, yy, zz, xy, xz, yz: entries of the inertia matrix");
  Json inertia = {{"description", "Inertia about the center of mass, along the body's axes."},
                  {"oneOf", {moments, all}}};
  const Body plain;
  std::vector<std::string> required;
  Json fields = properties(Body::fields(), &plain, nullptr, required);
  const Json by_density = object({{"density", number("kg/m3", "Density of the shapes", Range::positive)}}, {"density"});
  fields["mass"] = {
      {"description", "Mass [kg], or the density of the shapes, of which mass, center of mass and inertia are those."},
      {"oneOf", {fields["mass"], by_density}}};
  fields["inertia"] = inertia;
  fields["pose"] = object(pose_fields(), {});
  fields["shapes"] = reference("shapes");
  Json out = object(fields, required);
  out["properties"]["pose"]["description"] =
      "Pose in the world at the reference configuration, for joints given by 'at'.";
  out["if"] = {{"properties", {{"mass", {{"type", "object"}}}}}, {"required", {"mass"}}};
  out["then"] = {{"required", {"shapes"}}, {"properties", {{"com", false}, {"inertia", false}}}};
  return out;
}

Json start(const JointKind& kind) {
  Json fields = Json::object();
  Json names = Json::array();
  for (const auto quantities : {kind.q, kind.v}) {
    for (const QuantityGroup& g : groups(quantities)) {
      fields[g.name] = g.array ? list(static_cast<int>(g.size), g.unit, g.description) : number(g.unit, g.description);
      names.push_back(g.name);
    }
  }
  Json one_rotation;  // excludes that both the quaternion and a rotation are given
  if (kind.has_quaternion()) {
    fields["rotation"] = reference("rotation");
    names.push_back("rotation");
    one_rotation = {{"required", {"Q", "rotation"}}};
  }
  Json listed = {{"type", "array"}};
  if (!names.empty()) listed["items"] = {{"enum", names}};
  fields["fixed"] = {
      {"description", "Values to keep exactly: true for all, or a list of names. Others are initial guesses."},
      {"oneOf", {{{"type", "boolean"}}, listed}}};
  Json weights = Json::object();
  for (const Json& name : names) weights[name.get<std::string>()] = number("", "Weight", Range::not_negative);
  fields["weight"] = {
      {"description",
       "Weight of the squared change of a guess if the guesses are inconsistent: one for all values, or by name"},
      {"oneOf", {number("", "Weight of all given values", Range::not_negative), object(weights, {})}}};
  Json out = object(fields, {});
  out["description"] = "Start values.";
  if (!one_rotation.is_null()) out["not"] = one_rotation;
  return out;
}

Json joint(const JointKind& kind) {
  Json fields;
  fields["type"] = {{"const", kind.name}, {"description", kind.summary}};
  if (kind.axes == 1) fields["axis"] = list(3, "", "Direction in the joint's frame; [0, 0, 1] if not given");
  if (kind.axes == 2) {
    fields["axes"] = {{"description", "First axis, fixed in the parent, and second, fixed in the child"},
                      {"type", "array"},
                      {"items", list(3, "", "Direction in the joint's frame")},
                      {"minItems", 2},
                      {"maxItems", 2}};
  }
  fields["parent"] = reference("frame");
  fields["child"] = reference("frame");
  fields["at"] = object(pose_fields(), {});
  fields["at"]["description"] =
      "The joint's frame in the world at the reference configuration, instead of in both bodies.";
  fields["start"] = start(kind);
  std::vector<std::string> required = {"type", "parent", "child"};
  fields.update(joint_numbers(kind, required));
  return object(fields, required);
}

// Selects the kind by its name, then checks the fields of that kind, so that messages of validators refer to it.
Json any_joint() {
  Json names = Json::array();
  Json cases = Json::array();
  for (const JointKind& kind : joint_kinds()) {
    names.push_back(kind.name);
    cases.push_back(when_type(std::string(kind.name), reference("joint_" + std::string(kind.name))));
  }
  return by_type(names, cases);
}

Json definitions() {
  Json out;
  out["rotation"] = rotation();
  out["frame"] = frame(true);
  out["point"] = frame(false);
  out["shapes"] = shapes();
  for (const JointKind& kind : joint_kinds()) out["joint_" + std::string(kind.name)] = joint(kind);
  return out;
}

Json reductions() {
  Json fields;
  for (const std::string& name : words::reductions) fields[name] = {{"type", "boolean"}};
  fields["all"] = {{"type", "boolean"}, {"description", "Default for the reductions that are not named"}};
  Json out = object(fields, {});
  out["description"] = "Reductions of the model that leave its results unchanged; all are on unless switched off here.";
  return out;
}

Json left_out() {
  Json out = object({{"length", number("m", "Largest length of the removed bodies", Range::not_negative)},
                     {"travel", number("m", "Largest distance between removed parts", Range::not_negative)},
                     {"mass", number("kg", "Mass of the heaviest removed body", Range::not_negative)}},
                    {});
  out["description"] = "In FMUs: sizes of the parts removed because of `outputs`; natural units are chosen by them.";
  return out;
}

Json solver() {
  return object(
      {{"formulation", {{"enum", words::formulations}}},
       {"integrator", {{"enum", words::integrators}}},
       {"start",
        {{"enum", words::starts},
         {"description",
          "Initial state of a run: the start values, or the equilibrium found from them; as_given if not given"}}},
       {"equations",
        {{"enum", words::equations},
         {"description",
          "How the equations of motion are evaluated: by the general kernels, or traced, by a program that is made for "
          "the scene when a run begins, where that is possible; automatic: at present the same"}}},
       {"step", number("s", "Step of fixed-step methods; 0: chosen from experiment.step", Range::not_negative)},
       {"max_evaluations",
        {{"type", "integer"},
         {"minimum", words::max_evaluations.min},
         {"maximum", words::max_evaluations.max},
         {"description",
          "Maximum number of evaluations of the equations of motion of each island in a communication step, which "
          "ends early then; if not given, 1000000 for each second, or 1000 times step, of it"}}},
       {"max_events",
        {{"type", "integer"},
         {"minimum", words::max_events.min},
         {"maximum", words::max_events.max},
         {"description",
          "Maximum number of events of an island (a stop engages or disengages) in a communication step, which fails "
          "then; 10000 if not given"}}},
       {"corrections",
        {{"type", "integer"},
         {"minimum", words::corrections.min},
         {"maximum", words::corrections.max},
         {"description",
          "Number of iterations of the formulation projection for positions, and for velocities, after each step, so "
          "that all steps cost the same; 0 if not given: until convergence"}}},
       {"cone_tolerance",
        {{"type", "number"},
         {"minimum", words::min_cone_tolerance},
         {"maximum", words::max_cone_tolerance},
         {"description",
          "Residual of the velocities of contacts, relative to the largest one, to which moreau-jean solves for "
          "impulses; 1e-11 if not given"}}},
       {"rho_inf",
        {{"type", "number"},
         {"minimum", 0},
         {"maximum", 1},
         {"description",
          "Spectral radius of generalized-alpha and hht at infinite frequency: the fraction of an infinitely fast "
          "oscillation that remains after a step; 0.8 if not given"}}},
       {"baumgarte_alpha", number("1/s", "Gain of baumgarte on J v; 0: chosen from the step", Range::not_negative)},
       {"baumgarte_beta", number("1/s", "Gain of baumgarte on Phi; 0: chosen from the step", Range::not_negative)},
       {"reductions", reductions()},
       {"left_out", left_out()}},
      {});
}

Json gravity() {
  std::vector<std::string> required;
  const GravityField none;
  Json fields = properties(GravityField::fields(), &none, nullptr, required);
  fields["uniform"] = list(3, "m/s2", "Uniform acceleration that is added; none if not given");
  Json field = object(fields, required);
  add_ways(field, GravityField::fields());
  const Json uniform = list(3, "m/s2", "Gravitational acceleration in the world");
  return {{"description", "Gravitational acceleration in the world, uniform or a field; none if not given"},
          {"oneOf", {uniform, field}}};
}

Json settings() {
  Json out;
  out["assembly"] =
      object({{"tolerance",
               {{"type", "number"},
                {"minimum", 0},
                {"maximum", words::max_assembly_tolerance},
                {"description",
                 "Largest displacement of joint frames [rad, or relative to the size of the mechanism] by "
                 "which loops with redundant constraints and rounded dimensions are made to close "
                 "exactly; 0 if not given: no more than 1e-9"}}}},
             {});
  out["experiment"] = object({{"stop", number("s", "Default end time of a run", Range::positive)},
                              {"step", number("s", "Default communication step", Range::positive)},
                              {"tolerance",
                               {{"type", "number"},
                                {"minimum", words::min_tolerance},
                                {"maximum", words::max_tolerance},
                                {"description", "Relative error tolerance; absolute per radian, meter, rad/s, m/s"}}}},
                             {});
  out["solver"] = solver();
  return out;
}

// Sections of quantities that expressions name.
void name_quantities(Json& fields) {
  fields["constants"] = {{"description", "Numbers that expressions name, in SI units."},
                         {"type", "object"},
                         {"additionalProperties", {{"type", "number"}}}};
  const Json points = {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", 2}};
  const Json rows = {{"type", "array"}, {"items", points}, {"minItems", 2}};
  const auto word_of = [](const auto& words) { return Json{{"enum", words}}; };
  const Json beyond = word_of(expression::extrapolations);
  const Json table = object(
      {{"x", points},
       {"y", points},
       {"values", {{"anyOf", {points, rows}}, {"description", "Values at each x, or lists of them at each y"}}},
       {"file", {{"type", "string"}, {"description", "CSV file in the folder of the scene, in place of x, y, values"}}},
       {"columns",
        {{"type", "array"},
         {"minItems", 2},
         {"maxItems", 2},
         {"description", "Headers or numbers of the columns of x and of the values in the file"}}},
       {"interpolation", word_of(expression::interpolations)},
       {"extrapolation",
        {{"anyOf", {beyond, {{"type", "array"}, {"items", beyond}, {"minItems", 2}, {"maxItems", 2}}}}}},
       {"text", {{"type", "string"}, {"description", "Description"}}}},
      {});
  fields["tables"] = section(table, "Tables that expressions look up, in SI units.", false);
  fields["inputs"] = section(object({{"unit", {{"type", "string"}, {"description", "Unit of SI, such as V or N.m"}}},
                                     {"start", number("", "Start value; 0 if not given", Range::any)},
                                     {"text", {{"type", "string"}, {"description", "Description"}}}},
                                    {}),
                             "Inputs that expressions name.", false);
  const Json rate = {{"type", "string"}, {"description", "Expression of its rate in time, in SI units"}};
  Json state = object({{"rate", rate},
                       {"unit", {{"type", "string"}, {"description", "Unit of SI, such as A or Pa"}}},
                       {"start", number("", "Start value; 0 if not given", Range::any)},
                       {"nominal", number("", "Size of ordinary values, to which tolerances refer", Range::positive)},
                       {"resets",
                        {{"type", "array"},
                         {"description", "Jumps at the instants at which conditions become true"},
                         {"items", object({{"when", {{"type", "string"}, {"description", "Condition"}}},
                                           {"to", {{"type", {"string", "number"}}, {"description", "State after it"}}}},
                                          {"when", "to"})}}},
                       {"text", {{"type", "string"}, {"description", "Description"}}}},
                      {"rate"});
  fields["states"] = section({{"anyOf", {rate, state}}},
                             "States of elements, such as currents and controllers, by their rates.", false);
  const Json value = {{"type", "string"}, {"description", "Expression, in SI units"}};
  Json expression = object({{"value", value},
                            {"unit", {{"type", "string"}, {"description", "Unit of SI, such as W or N.m"}}},
                            {"text", {{"type", "string"}, {"description", "Description"}}}},
                           {"value"});
  fields["expressions"] =
      section({{"anyOf", {value, expression}}}, "Expressions with names: outputs, and parts of others.", false);
}

}  // namespace

std::string scene_schema() {
  Json fields;
  fields["gelenk"] = {{"const", scene_version}, {"description", "Version of the format"}};
  fields["name"] = {{"type", "string"}, {"minLength", 1}, {"maxLength", 200}, {"description", "Name of the mechanism"}};
  for (const MetadataKey& key : metadata_keys) {
    fields[std::string(key.name)] = {{"type", "string"},
                                     {"minLength", 1},
                                     {"maxLength", max_metadata_size},
                                     {"description", std::string(key.meaning) + "; passed on by FMUs"}};
  }
  name_quantities(fields);
  fields["gravity"] = gravity();
  fields["bodies"] = section(body(), "Rigid bodies. The ground always exists.", true);
  fields["ground"] = object({{"shapes", reference("shapes")}}, {});
  fields["ground"]["description"] = "Shapes that do not move.";
  fields["joints"] =
      section(any_joint(), "Joints, the edges of the mechanism's graph, which may contain closed loops.", true);
  const Scene nothing;
  each_section(nothing, [&](const Section& of, const auto& none) {
    fields[std::string(of.name)] = section(elements(of, none), std::string(of.description), false);
  });
  fields["parameters"] = {
      {"anyOf", {{{"type", "array"}, {"items", {{"type", "string"}}}, {"uniqueItems", true}}, {{"const", "all"}}}},
      {"description", "Paths of numbers that can be set before a run, such as crank.mass; all: every settable number"}};
  fields["outputs"] = {{"type", "array"},
                       {"items", {{"type", "string"}, {"minLength", 1}}},
                       {"minItems", 1},
                       {"uniqueItems", true},
                       {"description",
                        "Wanted outputs, by name or pattern (*, ?, [...]); parts that none of them depends on are "
                        "removed from the model. All if not given"}};
  fields.update(settings());
  Json out;
  out["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  out["title"] = "Gelenk scene";
  out["description"] = "A mechanism, in SI units and radians.";
  out.update(object(fields, {"gelenk", "bodies", "joints"}));
  out["$defs"] = definitions();
  return out.dump(2) + "\n";
}

}  // namespace gelenk
