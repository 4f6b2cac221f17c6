// SPDX-License-Identifier: BSD-3-Clause
// The JSON Schema says what a schema can: fields, types, sizes, signs. Names that must exist, inertias, and
// whatever else needs arithmetic are left to the reader.
#include <limits>

#include "joint/registry.h"
#include "scene/units.h"
#include "scene/words.h"
#include "scene_file/read.h"
#include "scene_file/schema_parts.h"

namespace gelenk {
namespace {

using namespace schema;

Json rotation() {
  Json out;
  out["description"] = "Orientation of a frame: columns of the matrix are its axes.";
  out["oneOf"] = {
      object({{"quaternion", list(4, "", "Scalar part first: [w, x, y, z]")}}, {"quaternion"}),
      object({{"rpy", list(3, "rad", "Turns about the fixed x, y, z axes, in this order: R = Rz(y) Ry(p) Rx(r)")}},
             {"rpy"}),
      object({{"axis", list(3, "", "Direction of the axis")}, {"angle", number("rad", "Turn about the axis")}},
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
  out["description"] = "A frame fixed in a body: where it is, or only the body's name for the body's own frame.";
  out["oneOf"] = {string("Name of a body, or ground"), object(fields, {"body"})};
  return out;
}

Json body() {
  const Json moments = list(3, "kg m2", "xx, yy, zz where the body's axes are principal axes");
  const Json all = list(6, "kg m2", "xx, yy, zz, xy, xz, yz: entries of the inertia matrix");
  Json inertia = {{"description", "About the centre of mass, along the body's axes."}, {"oneOf", {moments, all}}};
  const Body plain;
  std::vector<std::string> required;
  Json fields = properties(Body::fields(), &plain, nullptr, required);
  fields["inertia"] = inertia;
  fields["pose"] = object(pose_fields(), {});
  Json out = object(fields, required);
  out["properties"]["pose"]["description"] =
      "Pose in the world at the reference configuration, for joints given by 'at'.";
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
  Json one_rotation;  // a rotation stands for the quaternion, not beside it
  if (kind.has_quaternion()) {
    fields["rotation"] = reference("rotation");
    names.push_back("rotation");
    one_rotation = {{"required", {"Q", "rotation"}}};
  }
  Json listed = {{"type", "array"}};
  if (!names.empty()) listed["items"] = {{"enum", names}};
  fields["fixed"] = {
      {"description", "Keep the values exactly: true, or the names of those to keep. Others are guesses."},
      {"oneOf", {{{"type", "boolean"}}, listed}}};
  Json weights = Json::object();
  for (const Json& name : names) weights[name.get<std::string>()] = number("", "Weight", Range::not_negative);
  fields["weight"] = {
      {"description",
       "How much the square of a guess's change counts where guesses contradict: of all values, or by name"},
      {"oneOf", {number("", "Of all values given", Range::not_negative), object(weights, {})}}};
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

// The kind by its name, then the fields of that kind: a validator's message stays with what was meant.
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
  for (const JointKind& kind : joint_kinds()) out["joint_" + std::string(kind.name)] = joint(kind);
  return out;
}

Json reductions() {
  Json fields;
  for (const std::string& name : words::reductions) fields[name] = {{"type", "boolean"}};
  fields["all"] = {{"type", "boolean"}, {"description", "Those not named"}};
  Json out = object(fields, {});
  out["description"] = "Passes that make the model smaller; all are on unless switched off here.";
  return out;
}

Json left_out() {
  Json out = object({{"length", number("m", "Largest length of its bodies", Range::not_negative)},
                     {"travel", number("m", "Largest distance at which things stand", Range::not_negative)},
                     {"mass", number("kg", "Mass of its heaviest body", Range::not_negative)}},
                    {});
  out["description"] = "In FMUs: the size of what `outputs` has left out, which natural units are chosen by.";
  return out;
}

Json settings() {
  Json out;
  out["assembly"] = object({{"tolerance",
                             {{"type", "number"},
                              {"minimum", 0},
                              {"maximum", words::loosest_assembly},
                              {"description",
                               "How far joint frames may be moved [rad, lengths of about the mechanism's size] so that "
                               "loops with redundant constraints, whose numbers were rounded, close exactly; 0 if not "
                               "given: by no more than 1e-9"}}}},
                           {});
  out["experiment"] =
      object({{"stop", number("s", "Default end of a run", Range::positive)},
              {"step", number("s", "Default communication step", Range::positive)},
              {"tolerance", number("", "Relative; absolute per radian, metre, rad/s, m/s", Range::positive)}},
             {});
  out["solver"] = object(
      {{"formulation", {{"enum", words::formulations}}},
       {"integrator", {{"enum", words::integrators}}},
       {"start",
        {{"enum", words::starts},
         {"description",
          "What a run begins with: the start values, or the rest found from them; as_given if not given"}}},
       {"step", number("s", "Of fixed-step methods; 0: chosen from experiment.step", Range::not_negative)},
       {"max_evaluations",
        {{"type", "integer"},
         {"minimum", words::max_evaluations.least},
         {"maximum", words::max_evaluations.most},
         {"description",
          "Evaluations of the equations of motion, of each island, after which a communication step ends early; "
          "10000000 if not given"}}},
       {"max_events",
        {{"type", "integer"},
         {"minimum", words::max_events.least},
         {"maximum", words::max_events.most},
         {"description",
          "Events of an island (a stop begins or ends to push) after which a communication step is given up; 10000 if "
          "not given"}}},
       {"corrections",
        {{"type", "integer"},
         {"minimum", words::corrections.least},
         {"maximum", words::corrections.most},
         {"description",
          "Of the formulation projection: corrections of positions, and of speeds, after each step, so that each "
          "costs the same; 0 if not given: as many as close the loops"}}},
       {"rho_inf",
        {{"type", "number"},
         {"minimum", 0},
         {"maximum", 1},
         {"description",
          "Of generalized-alpha and hht: share of an infinitely fast oscillation that a step leaves; 0.8 if not "
          "given"}}},
       {"baumgarte_alpha", number("1/s", "Of baumgarte, on J v; 0: chosen from the step", Range::not_negative)},
       {"baumgarte_beta", number("1/s", "Of baumgarte, on Phi; 0: chosen from the step", Range::not_negative)},
       {"reductions", reductions()},
       {"left_out", left_out()}},
      {});
  return out;
}

}  // namespace

std::string scene_schema() {
  Json fields;
  fields["gelenk"] = {{"const", scene_version}, {"description", "Version of the format"}};
  fields["name"] = {{"type", "string"}, {"minLength", 1}, {"maxLength", 200}, {"description", "Name of the mechanism"}};
  fields["gravity"] = list(3, "m/s2", "Gravitational acceleration in the world; none if not given");
  fields["bodies"] = section(body(), "Rigid bodies. The ground is there by itself.", true);
  fields["joints"] = section(any_joint(), "Joints, the edges of the mechanism's graph. Loops may close.", true);
  const Scene nothing;
  each_section(nothing, [&](const Section& of, const auto& none) {
    fields[std::string(of.name)] = section(elements(of, none), std::string(of.description), false);
  });
  fields["parameters"] = {
      {"anyOf", {{{"type", "array"}, {"items", {{"type", "string"}}}, {"uniqueItems", true}}, {{"const", "all"}}}},
      {"description", "Paths of numbers that may be set before a run, such as crank.mass; all: whatever can be"}};
  fields["outputs"] = {{"type", "array"},
                       {"items", {{"type", "string"}, {"minLength", 1}}},
                       {"minItems", 1},
                       {"uniqueItems", true},
                       {"description",
                        "Outputs that are wanted, by name or pattern (*, ?, [...]); what none of them depends on is "
                        "left out. All if not given"}};
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
