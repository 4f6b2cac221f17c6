// SPDX-License-Identifier: BSD-3-Clause
// told SCENE: reads a scene in JSON and prints, as JSON, the scene as it is written back, the schema, its input and
// output signals, its parameters, and what pictures show of it: shapes of bodies, and what acts on bodies at rest whose
// frames all coincide with the world's.
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "mechanism/mechanism.h"
#include "outputs/wrenches.h"
#include "preparation/loads.h"
#include "scene/settable.h"
#include "scene/signals.h"
#include "scene_file/read.h"
#include "scene_schema/schema.h"

namespace {

nlohmann::json told(const std::vector<gelenk::Signal>& signals) {
  nlohmann::json out = nlohmann::json::object();
  for (const gelenk::Signal& signal : signals) out[signal.name] = {signal.unit, signal.description};
  return out;
}

nlohmann::json numbers(const Eigen::Vector3d& x) { return {x.x(), x.y(), x.z()}; }

nlohmann::json drawings(const gelenk::Scene& scene) {
  nlohmann::json out = nlohmann::json::object();
  for (const gelenk::Body& body : scene.bodies) {
    for (const gelenk::BodyShape& shape : body.shapes) {
      const gelenk::Drawing drawn = gelenk::drawing_of(*shape.is, 1);
      nlohmann::json& of = out[shape.name] = {{"points", nlohmann::json::array()}, {"triangles", drawn.triangles}};
      for (const Eigen::Vector3d& p : drawn.points) of["points"].push_back(numbers(p));
    }
  }
  return out;
}

struct AtRest final : gelenk::Readings<double> {
  void cut_speeds(int, double*) const override {}
  void cut_accelerations(int, double*) const override {}
  gelenk::Energy energy() const override { return {}; }
  void state_rates(const double*, double*) override {}
  void expression_values(const double*, double*) override {}
  Pose link_pose(int) const override { return {}; }
  Motion link_velocity(int) const override { return {}; }
  Motion link_acceleration(int) const override { return {}; }
  Pose rod_pose(int) const override { return {}; }
  Motion rod_velocity(int) const override { return {}; }
  Force tree_reaction(int) const override { return {}; }
  Force cut_reaction(int) const override { return {}; }
  double contact_force(int, int) const override { return 0; }
  double coordinate_force(int) const override { return 0; }
  void switching_forces(const double*, const int*, const double*, double*) const override {}
  Pose plane_pose(int) const override { return {}; }
  Pose pose_on_plane(int) const override { return {}; }
};

nlohmann::json wrenches(const gelenk::Scene& scene) {
  const gelenk::ReducedScene reduced = gelenk::reduce(scene);
  const std::vector<gelenk::Loads> loads = gelenk::make_loads(scene, reduced);
  const std::vector<double> u(gelenk::input_signals(scene).size()), zeros(100);
  gelenk::BodyWrenches found(scene, reduced);
  for (std::size_t i = 0; i < loads.size(); ++i) {
    AtRest at_rest;
    const gelenk::Reading reading{.dynamics = at_rest,
                                  .q = zeros.data(),
                                  .v = zeros.data(),
                                  .vdot = zeros.data(),
                                  .cut_q = zeros.data(),
                                  .cut_v = zeros.data(),
                                  .forces = zeros.data()};
    found.add(static_cast<int>(i), reading, loads[i], u.data());
  }
  nlohmann::json out = nlohmann::json::array();
  for (const gelenk::BodyWrench& of : found.all) {
    out.push_back({of.name, scene.bodies[static_cast<std::size_t>(of.body)].name, numbers(of.f), numbers(of.n)});
  }
  return out;
}

}  // namespace

int main(int, char** argv) try {
  std::ifstream file(argv[1]);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const gelenk::Scene scene = gelenk::read_scene_json(text, argv[1]);
  nlohmann::json out = {{"scene", nlohmann::json::parse(gelenk::write_scene_json(scene))},
                        {"schema", nlohmann::json::parse(gelenk::scene_schema())},
                        {"inputs", told(gelenk::input_signals(scene))},
                        {"outputs", told(gelenk::output_signals(scene))},
                        {"settable", nlohmann::json::object()},
                        {"drawings", drawings(scene)},
                        {"wrenches", wrenches(scene)}};
  for (const gelenk::SettableNumber& number : gelenk::settable_numbers(scene)) {
    out["settable"][number.variable(scene)] = {number.unit(scene), number.description(scene)};
  }
  std::cout << out << '\n';
  return 0;
} catch (const std::exception& error) {
  std::cout << error.what() << '\n';
  return 1;
}
