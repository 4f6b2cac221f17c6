// SPDX-License-Identifier: BSD-3-Clause
// Reads what expressions may name: the sections constants and inputs.
#include "scene/unit_system.h"
#include "scene_file/reader.h"

namespace gelenk {

void read_constants(const Json& section, Reader& reader) {
  each_entry(section, "constants", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               const double x = read_number(value, path, reader.faults, "").value_or(0);
               reader.scene.constants.push_back({name, x});
             });
}

void read_inputs(const Json& section, Reader& reader) {
  each_entry(section, "inputs", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               SceneInput& input = reader.scene.inputs.emplace_back();
               input.name = name;
               Fields fields(value, path, reader.faults, "a mapping with unit, start, text ({} for none of them)");
               if (!fields.valid()) return;
               if (const Json* unit = fields.find("unit")) {
                 constexpr const char* expected = "a unit of SI, such as V, N.m or rad/s";
                 input.unit = read_text(*unit, fields.path("unit"), reader.faults, expected).value_or("");
                 if (!is_unit(input.unit)) {
                   reader.faults.add(fields.path("unit"), text::quoted(input.unit), expected);
                   input.unit.clear();
                 }
               }
               if (const Json* text = fields.find("text"))
                 input.text = read_text(*text, fields.path("text"), reader.faults, "a text").value_or("");
               input.start = fields.number("start", 0, input.unit);
               fields.done();
             });
}

}  // namespace gelenk
