// SPDX-License-Identifier: BSD-3-Clause
// The functions that a page calls when the core runs in it as WebAssembly (python/gelenk/viewer/core/core.js). A page
// has the same plant as an FMU, with the same variables. What can fail returns a negative number or a null pointer;
// gelenk_error() then is the text. Arrays of results are written to memory of the caller.
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fmu/runtime/plant.h"
#include "scene_file/read.h"
#include "util/archive.h"

#define GELENK_PAGE(name) extern "C" __attribute__((export_name(#name)))

namespace {

using gelenk::EventReport;
using gelenk::Plant;
using gelenk::PlantModel;
using gelenk::Variable;

struct Page {
  Page(std::string_view json, const std::string& file) : plant(std::make_shared<const PlantModel>(json, file)) {}

  const Variable& variable(int index) const { return plant.catalog().variables().at(static_cast<std::size_t>(index)); }

  Plant plant;
  gelenk::Archive saved;
  std::vector<EventReport> events;    // of the last step
  std::vector<std::string> warnings;  // of the start
  std::string scene;                  // as it was last written
};

std::string last_error;

// Calls a function that returns a number, and returns -1 if it throws.
template <class F>
int guarded(const F& f) {
  try {
    return f();
  } catch (const std::exception& e) {
    last_error = e.what();
  } catch (...) {
    last_error = "unknown error";
  }
  return -1;
}

}  // namespace

GELENK_PAGE(gelenk_reserve) void* gelenk_reserve(std::size_t bytes) { return std::malloc(bytes); }
GELENK_PAGE(gelenk_release) void gelenk_release(void* memory) { std::free(memory); }
GELENK_PAGE(gelenk_error) const char* gelenk_error() { return last_error.c_str(); }

// file: name of the scene in messages. Returns null for an invalid scene.
GELENK_PAGE(gelenk_create) Page* gelenk_create(const char* json, std::size_t length, const char* file) {
  Page* made = nullptr;
  guarded([&] {
    made = new Page({json, length}, file);
    return 0;
  });
  return made;
}
GELENK_PAGE(gelenk_destroy) void gelenk_destroy(Page* page) { delete page; }

// Sets the start time [s] and the tolerance (0: the scene's), and assembles.
GELENK_PAGE(gelenk_initialize) int gelenk_initialize(Page* page, double time, double tolerance) {
  return guarded([&] {
    page->plant.set_experiment(time, tolerance);
    page->plant.assemble();
    page->warnings = page->plant.start_warnings();
    page->events.clear();
    return 0;
  });
}
GELENK_PAGE(gelenk_warnings) int gelenk_warnings(const Page* page) { return static_cast<int>(page->warnings.size()); }
GELENK_PAGE(gelenk_warning) const char* gelenk_warning(const Page* page, int i) {
  return page->warnings[static_cast<std::size_t>(i)].c_str();
}

// Writes the scene with the parameters set, as JSON, and returns its size at gelenk_scene().
GELENK_PAGE(gelenk_write_scene) int gelenk_write_scene(Page* page) {
  return guarded([&] {
    page->scene = gelenk::write_scene_json(page->plant.simulation().scene());
    return static_cast<int>(page->scene.size());
  });
}
GELENK_PAGE(gelenk_scene) const char* gelenk_scene(const Page* page) { return page->scene.c_str(); }

GELENK_PAGE(gelenk_variables) int gelenk_variables(const Page* page) {
  return static_cast<int>(page->plant.catalog().variables().size());
}
// 0: name, 1: unit, 2: description.
GELENK_PAGE(gelenk_variable_text) const char* gelenk_variable_text(const Page* page, int variable, int which) {
  const Variable& of = page->variable(variable);
  return (which == 0 ? of.name : which == 1 ? of.unit : of.description).c_str();
}
// 0: causality, 1: variability, 2: type, as the numbers of the enumerations; 3: start value, NaN if there is none;
// 4: minimum, 5: maximum, infinite if there are none; 6: whether it is no output that the scene wants.
GELENK_PAGE(gelenk_variable_number) double gelenk_variable_number(const Page* page, int variable, int which) {
  const Variable& of = page->variable(variable);
  switch (which) {
    case 0:
      return static_cast<double>(of.causality);
    case 1:
      return static_cast<double>(of.variability);
    case 2:
      return static_cast<double>(of.type);
    case 3:
      return of.start.value_or(std::numeric_limits<double>::quiet_NaN());
    case 4:
      return of.min;
    case 5:
      return of.max;
    default:
      return of.hidden ? 1 : 0;
  }
}

// An input, or a parameter: then the next step or reading assembles again.
GELENK_PAGE(gelenk_set) int gelenk_set(Page* page, int variable, double value) {
  return guarded([&] {
    page->variable(variable);
    page->plant.set(variable, value);
    return 0;
  });
}
// An input, or a tunable parameter of a run.
GELENK_PAGE(gelenk_tune) int gelenk_tune(Page* page, int variable, double value) {
  return guarded([&] {
    page->variable(variable);
    page->plant.assemble();
    page->plant.tune(variable, value);
    return 0;
  });
}
GELENK_PAGE(gelenk_set_derivative)
int gelenk_set_derivative(Page* page, int input, int order, double value) {
  return guarded([&] {
    page->variable(input);
    page->plant.set_input_derivative(input, order, value);
    return 0;
  });
}

// The values of variables, by their indices.
GELENK_PAGE(gelenk_get) int gelenk_get(Page* page, const std::int32_t* variables, int count, double* values) {
  return guarded([&] {
    for (int i = 0; i < count; ++i) {
      page->variable(variables[i]);
      values[i] = page->plant.get(variables[i]);
    }
    return 0;
  });
}

GELENK_PAGE(gelenk_time) double gelenk_time(const Page* page) { return page->plant.time(); }
GELENK_PAGE(gelenk_step_to) int gelenk_step_to(Page* page, double end) {
  page->events.clear();
  const int out = guarded([&] {
    page->plant.assemble();
    page->plant.step_to(end);
    return 0;
  });
  if (out == 0) page->events = page->plant.events(false);
  return out;
}
GELENK_PAGE(gelenk_events) int gelenk_events(const Page* page) { return static_cast<int>(page->events.size()); }
GELENK_PAGE(gelenk_event_time) double gelenk_event_time(const Page* page, int i) {
  return page->events[static_cast<std::size_t>(i)].time;
}
GELENK_PAGE(gelenk_event_text) const char* gelenk_event_text(const Page* page, int i) {
  return page->events[static_cast<std::size_t>(i)].text.c_str();
}

GELENK_PAGE(gelenk_bodies) int gelenk_bodies(const Page* page) {
  return static_cast<int>(page->plant.model().scene.bodies.size());
}
// Of each body: position [m] and quaternion (x, y, z, w) of its frame in the world.
GELENK_PAGE(gelenk_poses) int gelenk_poses(Page* page, double* out) {
  return guarded([&] {
    gelenk::Simulation& simulation = page->plant.simulation();
    const int bodies = gelenk_bodies(page);
    for (int body = 0; body < bodies; ++body) {
      const gelenk::Pose3 X_WB = simulation.body_pose(body);
      Eigen::Map<Eigen::Vector3d> p(out + 7 * static_cast<std::ptrdiff_t>(body));
      p = X_WB.p;
      Eigen::Map<Eigen::Vector4d>(p.data() + 3) = Eigen::Quaterniond(X_WB.R).coeffs();
    }
    return 0;
  });
}

// Saves all that determines how the run continues, and returns the number of 64-bit words at gelenk_saved().
GELENK_PAGE(gelenk_save) int gelenk_save(Page* page) {
  return guarded([&] {
    page->saved = {};
    page->plant.serialize(page->saved);
    return static_cast<int>(page->saved.words().size());
  });
}
GELENK_PAGE(gelenk_saved) const std::uint64_t* gelenk_saved(const Page* page) { return page->saved.words().data(); }
// Restores a state that any plant of the same scene has saved. After a failure the plant must be freed.
GELENK_PAGE(gelenk_restore) int gelenk_restore(Page* page, const std::uint64_t* words, std::size_t count) {
  return guarded([&] {
    gelenk::Archive archive(std::vector<std::uint64_t>(words, words + count));
    page->plant.serialize(archive);
    archive.finish();
    page->events.clear();
    return 0;
  });
}
