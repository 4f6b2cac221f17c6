// SPDX-License-Identifier: BSD-3-Clause
// The section of constraints in the JSON Schema.
#include "scene/schema_parts.h"
#include "scene/words.h"

namespace gelenk::schema {
namespace {

Json numbers(int least, const std::string& description) {
  return {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", least}, {"description", description}};
}

Json motion() {
  Json fields;
  fields["type"] = {{"const", "motion"}};
  fields["joint"] = text("Name of a joint whose speeds are the rates of its coordinates");
  fields["coordinate"] = text("Which of the joint's coordinates, where it has several");
  fields["polynomial"] = numbers(1, "c0, c1, c2, ...: the coordinate is c0 + c1 t + c2 t^2 + ... [rad or m, s]");
  fields["sine"] = object({{"amplitude", number("rad or m", "Amplitude")},
                           {"frequency", number("Hz", "Frequency", Allowed::not_negative)},
                           {"phase", number("rad", "Phase at t = 0")}},
                          {"amplitude", "frequency"});
  fields["sine"]["description"] = "amplitude sin(2 pi frequency t + phase), added to the polynomial if there is one";
  fields["table"] = object({{"time", numbers(2, "Times, ascending [s]")},
                            {"value", numbers(2, "The coordinate at these [rad or m]")},
                            {"periodic", {{"type", "boolean"}, {"description", "Whether it repeats"}}}},
                           {"time", "value"});
  fields["table"]["description"] = "A cubic spline through these points";
  fields["speed"] = number("rad/s or m/s", "Constant speed, from wherever the coordinate starts");
  fields["input"] = {{"enum", words::motion_inputs}, {"description", "What an input of the model gives"}};
  Json out = object(fields, {"type", "joint"});
  const auto has = [](const char* field) { return Json{{"required", Json::array({field})}}; };
  const Json formula = {{"anyOf", Json::array({has("polynomial"), has("sine")})}};
  out["oneOf"] = Json::array({formula, has("table"), has("speed"), has("input")});
  return out;
}

Json gear() {
  return object({{"type", {{"const", "gear"}}},
                 {"joint", text("Name of a revolute joint")},
                 {"with", text("Name of another")},
                 {"ratio", number("", "Turns of the first for a turn of the other", Allowed::not_zero)},
                 {"carrier", text("Name of a third, against which both turn; none if not given")},
                 {"offset", number("rad", "Angle of the first where the other is at 0")}},
                {"type", "joint", "with", "ratio"});
}

Json rack() {
  return object({{"type", {{"const", "rack"}}},
                 {"rack", text("Name of a prismatic joint")},
                 {"pinion", text("Name of a revolute joint")},
                 {"radius", number("m", "Travel of the rack for a radian of the pinion", Allowed::not_zero)},
                 {"offset", number("m", "Position of the rack where the pinion is at 0")}},
                {"type", "rack", "pinion", "radius"});
}

Json contact(const char* type, const char* axis, bool wheel) {
  Json fields;
  fields["type"] = {{"const", type}};
  fields["body"] = text("Name of a body");
  fields["position"] = list(3, "m", wheel ? "Centre of the wheel" : "The edge's point");
  fields["rotation"] = reference("rotation");
  fields["axis"] = list(3, "", axis);
  fields["on"] = reference("frame");
  std::vector<std::string> required = {"type", "body"};
  if (wheel) {
    fields["radius"] = number("m", "Radius of the wheel", Allowed::positive);
    required.emplace_back("radius");
  }
  return object(fields, required);
}

}  // namespace

Json constraint() {
  return by_type(
      words::constraints,
      {when_type("motion", motion()), when_type("gear", gear()), when_type("rack", rack()),
       when_type("rolling", contact("rolling", "Axis of the wheel; [0, 1, 0] if not given", true)),
       when_type("knife_edge",
                 contact("knife_edge", "Direction in which it cannot slide; [0, 1, 0] if not given", false))});
}

}  // namespace gelenk::schema
