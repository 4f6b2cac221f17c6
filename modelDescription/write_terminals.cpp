// SPDX-License-Identifier: BSD-3-Clause
#include <string>
#include <vector>

#include "modelDescription/write_xml.h"
#include "modelDescription/xml_writer.h"
#include "scene/signals.h"

namespace gelenk {
namespace {

// The names of the joints on which elements of a section act, by element.
template <class Elements>
std::vector<std::string> joints_of(const Elements& elements) {
  std::vector<std::string> out;
  for (const auto& element : elements) out.push_back(element.joints.empty() ? std::string() : element.joints.front());
  return out;
}

void write_member(XmlWriter& w, const std::string& variable, std::string_view member) {
  w.open(3, "TerminalMemberVariable").attribute("variableName", variable);
  w.attribute("memberName", member).attribute("variableKind", "signal").end();
}

// A square of 20 mm.
void write_place_of_icon(XmlWriter& w) {
  const auto write_corners = [&w] {
    w.attribute("x1", -100).attribute("y1", -100).attribute("x2", 100).attribute("y2", 100);
  };
  w.open(1, "GraphicalRepresentation").inside();
  w.open(2, "CoordinateSystem");
  write_corners();
  w.attribute("suggestedScalingFactorTo_mm", 0.1).end();
  w.open(2, "Icon");
  write_corners();
  w.end();
  w.close(1, "GraphicalRepresentation");
}

// The part of a signal's name after the name of what it belongs to.
std::string_view quantity_in(const std::string& name) { return std::string_view(name).substr(name.find('.') + 1); }

class Terminals {
 public:
  Terminals(const Scene& scene, const Catalog& catalog)
      : scene_(scene),
        catalog_(catalog),
        inputs_(input_signals(scene)),
        outputs_(output_signals(scene)),
        driven_(joints_of(scene.motors)) {}

  void write(XmlWriter& w) const {
    bool has_begun = false;
    for (int j = 0; j < static_cast<int>(scene_.joints.size()); ++j) {
      const std::vector<int> found = outputs_of(j);
      if (found.empty()) continue;
      if (!has_begun) w.open(1, "Terminals").inside();
      has_begun = true;
      write_terminal(w, j, found);
    }
    if (has_begun) w.close(1, "Terminals");
  }

 private:
  // Those of its motion that are described.
  std::vector<int> outputs_of(int joint) const {
    std::vector<int> out;
    for (int i = 0; i < static_cast<int>(outputs_.size()); ++i) {
      const Signal& signal = outputs_[static_cast<std::size_t>(i)];
      const Variable& v = catalog_.variables()[static_cast<std::size_t>(catalog_.output_variable(i))];
      if (signal.joint == joint && signal.level <= 2 && v.causality == Causality::output) out.push_back(i);
    }
    return out;
  }

  void write_terminal(XmlWriter& w, int joint, const std::vector<int>& outputs) const {
    const std::string& name = scene_.joints[static_cast<std::size_t>(joint)].name;
    w.open(2, "Terminal").attribute("name", name).attribute("matchingRule", "bus");
    w.attribute("description", "joint " + name + ": its motion, and the inputs of its motors").inside();
    for (const int i : outputs) {
      const std::string& variable = outputs_[static_cast<std::size_t>(i)].name;
      write_member(w, variable, quantity_in(variable));
    }
    for (const Signal& input : inputs_) {
      const bool drives = input.section == sections::motors && driven_[static_cast<std::size_t>(input.element)] == name;
      if (drives) write_member(w, input.name, input.name);
    }
    w.close(2, "Terminal");
  }

  const Scene& scene_;
  const Catalog& catalog_;
  std::vector<Signal> inputs_, outputs_;
  std::vector<std::string> driven_;  // by motor
};

}  // namespace

std::string write_terminals(const Scene& scene, const Catalog& catalog, bool has_icon) {
  XmlWriter w;
  w.raw("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
  w.open(0, "fmiTerminalsAndIcons").attribute("fmiVersion", "3.0").inside();
  if (has_icon) write_place_of_icon(w);
  Terminals(scene, catalog).write(w);
  w.close(0, "fmiTerminalsAndIcons");
  return w.take();
}

}  // namespace gelenk
