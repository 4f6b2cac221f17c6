// SPDX-License-Identifier: BSD-3-Clause
// Many instances of a few plants, which are stepped together, as learning requires.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings.h"
#include "plant.h"
#include "runs/trajectory.h"
#include "util/archive.h"

namespace nb = nanobind;
using gelenk::Channels;
using gelenk::SharedSimulation;
using gelenk::Simulation;

namespace {

template <int dimensions>
using Table = nb::ndarray<double, nb::ndim<dimensions>, nb::c_contig, nb::device::cpu>;
using Indices = nb::ndarray<const int, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// An instance is the saved state of the plant with which it has started.
class Fleet {
 public:
  // plants: initialized, at their starts. channels: for each of them, with as many held inputs and readings.
  // step: [s].
  Fleet(std::vector<SharedSimulation*> plants, std::vector<Channels> channels, int count, double step)
      : plants_(std::move(plants)), channels_(std::move(channels)), step_(step) {
    if (plants_.empty() || channels_.size() != plants_.size() || count < 1)
      throw nb::index_error("a fleet needs a plant, channels for each, and an instance");
    for (std::size_t k = 0; k < plants_.size(); ++k) {
      gelenk::Archive& start = starts_.emplace_back();
      std::vector<double>& seen = seen_.emplace_back(channels_[k].readings.size());
      plants_[k]->with([&](Simulation& s) {
        s.serialize(start);
        gelenk::read_channels(s, channels_[k], seen.data(), 1);
      });
    }
    instances_.resize(static_cast<std::size_t>(count));
    for (Instance& instance : instances_) instance.state = starts_[0];
  }

  // Puts instances to starts, and writes the readings there into their rows.
  void reset(const Indices& instances, const Indices& starts, const Table<2>& rows) {
    if (starts.size() != instances.size()) throw nb::index_error("there are not as many starts as instances");
    check(rows);
    for (std::size_t k = 0; k < instances.size(); ++k) {
      const auto start = static_cast<std::size_t>(starts.data()[k]);
      Instance& instance = instances_.at(static_cast<std::size_t>(instances.data()[k]));
      instance.state = starts_.at(start);
      instance.start = start;
      instance.steps = 0;
      std::ranges::copy(seen_[start], rows.data() + (static_cast<std::size_t>(instances.data()[k]) * rows.shape(1)));
    }
  }

  // Makes a step with each instance: the inputs are the rows of `actions`. Returns the events (instance, time, text)
  // and the errors (instance, text); an instance with an error remains where it was.
  std::tuple<std::vector<std::tuple<int, double, std::string>>, std::vector<std::tuple<int, std::string>>> step(
      const Table<2>& actions, const Table<2>& rows) {
    check(rows);
    if (actions.shape(0) != instances_.size() || actions.shape(1) != channels_[0].columns())
      throw nb::index_error("actions: there must be a row for each instance and a column for each input");
    events_.clear();
    errors_.clear();
    for (std::size_t k = 0; k < plants_.size(); ++k) {
      plants_[k]->with([&](Simulation& s) {
        for (std::size_t i = 0; i < instances_.size(); ++i) {
          if (instances_[i].start != k) continue;
          advance(s, i, {actions.data() + (i * actions.shape(1)), actions.shape(1)}, rows.data() + (i * rows.shape(1)));
        }
      });
    }
    return {events_, errors_};
  }

 private:
  struct Instance {
    gelenk::Archive state;
    std::size_t start = 0;
    long steps = 0;
  };

  void check(const Table<2>& rows) const {
    if (rows.shape(0) != instances_.size() || rows.shape(1) != channels_[0].readings.size())
      throw nb::index_error("rows: there must be one for each instance and a column for each reading");
  }

  void advance(Simulation& simulation, std::size_t i, std::span<const double> action, double* row) {
    Instance& instance = instances_[i];
    const Channels& channels = channels_[instance.start];
    instance.state.start_reading();
    simulation.serialize(instance.state);
    const std::array<double, 2> times{static_cast<double>(instance.steps) * step_,
                                      static_cast<double>(instance.steps + 1) * step_};
    gelenk::Recorded done;
    const auto number = static_cast<int>(i);
    try {
      gelenk::run_leg(simulation, channels, {.times = times, .inputs = action, .rows = {row, 0, 1}, .until = {}}, done);
    } catch (const std::runtime_error& error) {
      errors_.emplace_back(number, error.what());
      gelenk::read_channels(simulation, channels, row, 1);
    }
    for (const gelenk::EventReport& event : done.events) events_.emplace_back(number, event.time, event.text);
    ++instance.steps;
    instance.state.start_writing();
    simulation.serialize(instance.state);
  }

  std::vector<SharedSimulation*> plants_;
  std::vector<Channels> channels_;
  double step_;
  std::vector<gelenk::Archive> starts_;
  std::vector<std::vector<double>> seen_;  // readings at the starts
  std::vector<Instance> instances_;
  std::vector<std::tuple<int, double, std::string>> events_;
  std::vector<std::tuple<int, std::string>> errors_;
};

}  // namespace

void gelenk::bind_fleet(nb::module_& m) {
  nb::class_<Fleet>(m, "Fleet", "Many instances of a few plants, which are stepped together.")
      .def(nb::init<std::vector<SharedSimulation*>, std::vector<Channels>, int, double>(), nb::arg("plants"),
           nb::arg("channels"), nb::arg("count"), nb::arg("step"), nb::keep_alive<1, 2>(),
           "plants: initialized, at their starts; they must outlive the fleet. channels: for each plant. step: [s].")
      .def("reset", &Fleet::reset, nb::arg("instances"), nb::arg("starts"), nb::arg("rows"),
           "Put instances to starts, by their numbers; write the readings there into their rows.")
      .def("step", &Fleet::step, nb::arg("actions"), nb::arg("rows"),
           "Make a step with each instance, whose inputs are a row of `actions`. Returns the events (instance, time, "
           "text) and the errors (instance, text); an instance with an error remains where it was.");
}
