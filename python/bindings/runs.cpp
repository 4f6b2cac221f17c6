// SPDX-License-Identifier: BSD-3-Clause
// Runs over many communication points, and many runs of one scene with other numbers.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <iterator>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings.h"
#include "check/check.h"
#include "plant.h"
#include "runs/trajectory.h"
#include "scene_file/read.h"
#include "simulation/parameters.h"
#include "simulation/repeated_start.h"
#include "simulation/start_report.h"
#include "simulation/stepping_report.h"
#include "util/text.h"

namespace nb = nanobind;
using gelenk::Channels;
using gelenk::Scene;
using gelenk::SharedSimulation;
using gelenk::Simulation;

namespace {

template <int dimensions>
using Numbers = nb::ndarray<const double, nb::ndim<dimensions>, nb::c_contig, nb::device::cpu>;
using Events = std::vector<std::tuple<double, std::string>>;
using Clock = gelenk::Interruption::Clock;

// The end of a time span [s] from now; of one that never ends if it is not positive.
Clock::time_point after(double seconds) {
  if (seconds <= 0 || seconds > 1e9) return Clock::time_point::max();
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

Events to_python(const std::vector<gelenk::EventReport>& events) {
  Events out;
  for (const gelenk::EventReport& event : events) out.emplace_back(event.time, event.text);
  return out;
}

void check_channels(const Channels& channels, const Simulation& simulation) {
  const auto in_range = [](const std::vector<int>& indices, int from, std::size_t to) {
    return std::ranges::all_of(indices, [&](int i) { return i >= from && i < static_cast<int>(to); });
  };
  const std::size_t inputs = simulation.inputs().size();
  const int diagnostics = static_cast<int>(simulation.diagnostics().size());
  if (!in_range(channels.held, 0, inputs) || !in_range(channels.motions, 0, inputs) ||
      !in_range(channels.readings, -diagnostics, simulation.outputs().size()) ||
      !std::ranges::all_of(channels.constants, [&](const gelenk::ConstantInput& constant) {
        return constant.input >= 0 && constant.input < static_cast<int>(inputs);
      })) {
    throw nb::index_error("an index of an input or a reading is out of range");
  }
}

using Sample = std::tuple<int, Events, std::string, std::string>;

// Runs a leg; returns the number of steps, the events, and the class and message of an error, empty if there was none.
Sample record(SharedSimulation& plant, const Channels& channels, const Numbers<1>& times, const Numbers<2>& inputs,
              const nb::ndarray<double, nb::ndim<2>, nb::device::cpu>& rows, double seconds) {
  check_channels(channels, plant.fixed());
  const std::size_t steps = times.size() == 0 ? 0 : times.size() - 1;
  if (inputs.shape(0) < steps || inputs.shape(1) != channels.columns() || rows.shape(0) < steps ||
      rows.shape(1) != channels.readings.size()) {
    throw nb::index_error("the tables of inputs and readings do not have a row for each step");
  }
  const gelenk::Leg leg{.times = {times.data(), times.size()},
                        .inputs = {inputs.data(), inputs.size()},
                        .rows = {rows.data(), rows.stride(0), rows.stride(1)},
                        .until = {after(seconds)}};
  gelenk::Recorded done;
  std::string kind;
  std::string text;
  try {
    plant.with([&](Simulation& s) { gelenk::run_leg(s, channels, leg, done); });
  } catch (const gelenk::StepBudgetError& error) {
    kind = "StepBudgetError", text = error.what();
  } catch (const gelenk::StepError& error) {
    kind = "StepError", text = error.what();
  } catch (const gelenk::UsageError& error) {
    kind = "UsageError", text = error.what();
  }
  return {static_cast<int>(done.steps), to_python(done.events), kind, text};
}

// The outcome of one run of a batch.
struct RunReport {
  int steps = 0;             // that were completed
  bool is_repeated = false;  // whether the simulation of another run was used again
  bool is_complete = false;  // whether it has reached the end of the times
  std::string error;         // why not; lines
  std::vector<std::string> warnings;
  Events events;
  double seconds = 0;  // wall-clock time

  void fail(const std::string& text) { error = text; }
  void fail(const std::vector<std::string>& lines) {
    for (const std::string& line : lines) error += (error.empty() ? "" : "\n") + line;
  }
};

// A simulation of which each run begins where the first one did (simulation/repeated_start.h).
struct RepeatedRun {
  explicit RepeatedRun(const Scene& scene) : simulation(scene) {}

  Simulation simulation;
  gelenk::RepeatedStart start{simulation};
};

// Many runs of a scene, which differ by parameters and constant inputs. Its functions may be called by several threads.
class Batch {
 public:
  // parameters: names of the numbers that differ, in the order of their columns. channels.constants: the inputs that
  // differ, then others.
  Batch(Scene scene, const std::vector<std::string>& parameters, Channels channels, const Numbers<1>& times,
        const Numbers<2>& inputs)
      : scene_(std::move(scene)),
        channels_(std::move(channels)),
        times_(times.data(), times.data() + times.size()),
        inputs_(inputs.data(), inputs.data() + inputs.size()) {
    for (gelenk::Parameter& known : gelenk::scene_parameters(scene_)) {
      if (std::ranges::find(parameters, known.name) != parameters.end()) parameters_.push_back(std::move(known));
    }
    if (parameters_.size() != parameters.size()) throw gelenk::UsageError("parameters: found an unknown name");
    for (std::size_t i = 0; i < parameters.size(); ++i) {  // into the given order
      std::iter_swap(parameters_.begin() + static_cast<std::ptrdiff_t>(i),
                     std::ranges::find(parameters_, parameters[i], &gelenk::Parameter::name));
    }
    only_numbers_ =
        std::ranges::none_of(parameters, [this](const std::string& name) { return is_method_or_start(name); });
    repeats_ = std::ranges::all_of(parameters_, &gelenk::Parameter::keeps_positions);
    check_channels(channels_, Simulation(scene_));
    if (times_.empty() || inputs.shape(0) < std::max<std::size_t>(1, times_.size() - 1) ||
        inputs.shape(1) != channels_.columns()) {
      throw nb::index_error("the table of inputs does not have a row for each step, or none");
    }
  }

  // Makes a run for each row of `parameters` and `constants`, with the readings in rows[run][reading][point]. A run
  // that takes longer than `seconds` fails. Ends early after stop(); returns the reports of the complete runs.
  std::vector<RunReport> run(const Numbers<2>& parameters, const Numbers<2>& constants,
                             const nb::ndarray<double, nb::ndim<3>, nb::c_contig, nb::device::cpu>& rows,
                             double seconds) const {
    const std::size_t runs = rows.shape(0);
    if (parameters.shape(0) != runs || constants.shape(0) != runs || parameters.shape(1) != parameters_.size() ||
        constants.shape(1) > channels_.constants.size() || rows.shape(1) != channels_.readings.size() ||
        rows.shape(2) != times_.size()) {
      throw nb::index_error("the arrays do not have the shapes of the batch");
    }
    const nb::gil_scoped_release release;
    std::vector<RunReport> out;
    for (std::size_t i = 0; i < runs && !stop_; ++i) {
      const double* values = constants.data() + (i * constants.shape(1));
      RunReport report = guarded(parameters.data() + (i * parameters_.size()), {values, values + constants.shape(1)},
                                 rows.data() + (i * rows.shape(1) * rows.shape(2)), seconds);
      if (!stop_) out.push_back(std::move(report));
    }
    return out;
  }

  // Ends the calls of run() in other threads at the next communication point.
  void stop() { stop_ = true; }

 private:
  RunReport guarded(const double* parameters, const std::vector<double>& constants, double* rows,
                    double seconds) const {
    const Clock::time_point start = Clock::now();
    RunReport report;
    try {
      run_one(report, parameters, constants, rows, after(seconds));
      if (!report.is_complete) {
        report.fail("the run has taken longer than " + gelenk::text::number(seconds) + " s; it had reached t = " +
                    gelenk::text::number(times_[report.steps]) + " s of " + gelenk::text::number(times_.back()) + " s");
      }
    } catch (const gelenk::SceneError& error) {
      report.fail(error.lines());
    } catch (const std::exception& error) {
      report.fail(std::string(error.what()));
    }
    report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return report;
  }

  void run_one(RunReport& report, const double* parameters, const std::vector<double>& constants, double* rows,
               Clock::time_point deadline) const {
    Channels channels = channels_;
    for (std::size_t i = 0; i < constants.size(); ++i) channels.constants[i].value = constants[i];
    const auto set_inputs = [&](Simulation& simulation) {
      gelenk::set_inputs(simulation, channels, std::span(inputs_).first(channels.columns()));
    };
    std::unique_ptr<RepeatedRun> repeated = idle_run();
    const bool was_any = repeated != nullptr;
    if (was_any) {
      Simulation& simulation = repeated->simulation;
      report.is_repeated = repeated->start.begin([&](Scene& scene) { return take_parameters(scene, parameters); },
                                                 [&] { set_inputs(simulation); });
      if (report.is_repeated) record(report, simulation, channels, rows, deadline);
      keep_for_others(std::move(repeated));
      if (report.is_repeated) return;
    }
    auto made = std::make_unique<RepeatedRun>(parameters_.empty() ? scene_ : with(parameters));
    set_inputs(made->simulation);
    made->simulation.initialize();
    if (repeats_) made->start.keep();
    record(report, made->simulation, channels, rows, deadline);
    // In place of one that could not begin this run: others are more likely to be as this one.
    if (!made->start.is_possible()) return;
    if (was_any) idle_run();
    keep_for_others(std::move(made));
  }

  // A simulation that no thread uses; null: there is none, or none can be used again.
  std::unique_ptr<RepeatedRun> idle_run() const {
    const std::scoped_lock lock(mutex_);
    if (idle_.empty()) return nullptr;
    std::unique_ptr<RepeatedRun> out = std::move(idle_.back());
    idle_.pop_back();
    return out;
  }
  // Those of runs that failed are not kept.
  void keep_for_others(std::unique_ptr<RepeatedRun> of) const {
    const std::scoped_lock lock(mutex_);
    if (idle_.size() < most_idle) idle_.push_back(std::move(of));
  }

  void record(RunReport& report, Simulation& simulation, const Channels& channels, double* rows,
              Clock::time_point deadline) const {
    report.warnings = gelenk::StartReport(simulation).warnings();
    const auto points = static_cast<std::ptrdiff_t>(times_.size());
    gelenk::read_channels(simulation, channels, rows, points);
    gelenk::Recorded done;
    try {
      const gelenk::Leg leg{
          .times = times_, .inputs = inputs_, .rows = {rows + 1, 1, points}, .until = {deadline, &stop_}};
      gelenk::run_leg(simulation, channels, leg, done);
    } catch (const gelenk::StepError&) {
      note(report, done);
      throw;
    }
    note(report, done);
    std::ranges::move(gelenk::SteppingReport(simulation).warnings(), std::back_inserter(report.warnings));
    report.is_complete = done.steps + 1 == times_.size();
  }

  // Whether a parameter is one that every scene has: a start value, a component of gravity, a setting of the solver.
  // Other parameters are numbers that the scene lists, which are stored as they are set.
  bool is_method_or_start(const std::string& name) const {
    Scene without = scene_;
    without.parameters.clear();
    const std::vector<gelenk::Parameter> known = gelenk::scene_parameters(without);
    return std::ranges::find(known, name, &gelenk::Parameter::name) != known.end();
  }

  static void note(RunReport& report, const gelenk::Recorded& done) {
    report.steps = static_cast<int>(done.steps);
    report.events = to_python(done.events);
  }

  void set_parameters(Scene& scene, const double* values) const {
    for (const gelenk::Parameter& parameter : parameters_) gelenk::set_parameter(scene, parameter, *values++);
  }

  // Returns whether they are valid; otherwise those of a new scene are refused in words.
  bool take_parameters(Scene& scene, const double* values) const try {
    set_parameters(scene, values);
    return parameters_.empty() || gelenk::numbers_are_valid(scene);
  } catch (const std::invalid_argument&) {
    return false;
  }

  Scene with(const double* values) const {
    Scene changed = scene_;
    set_parameters(changed, values);
    if (!only_numbers_) return gelenk::checked(changed);
    gelenk::check_scene(changed);
    return changed;
  }

  Scene scene_;
  Channels channels_;
  std::vector<double> times_, inputs_;
  std::vector<gelenk::Parameter> parameters_;
  bool only_numbers_ = false;  // so that a changed scene need not be read again to be the same as if it were
  bool repeats_ = false;       // no position depends on the parameters
  std::atomic<bool> stop_ = false;

  static constexpr std::size_t most_idle = 64;
  mutable std::mutex mutex_;  // of idle_
  mutable std::vector<std::unique_ptr<RepeatedRun>> idle_;
};

}  // namespace

void gelenk::bind_runs(nb::module_& m, nb::class_<SharedSimulation>& simulation) {
  nb::class_<Channels>(m, "Channels", "The inputs and outputs of a run, by their indices.")
      .def(
          "__init__",
          [](Channels* self, const std::vector<int>& held, const std::vector<int>& motions,
             const std::vector<int>& readings, const std::vector<std::tuple<int, double, bool>>& constants) {
            new (self) Channels{.held = held, .motions = motions, .constants = {}, .readings = readings};
            for (const auto& [input, value, moves] : constants) self->constants.push_back({input, value, moves});
          },
          nb::arg("held"), nb::arg("motions"), nb::arg("readings"), nb::arg("constants"),
          "held: inputs with a column in the table of sampled inputs; motions: inputs with five columns; readings: "
          "outputs, and -1 - i for diagnostic i; constants: (input, value, whether it is a prescribed motion).");
  simulation.def("record", record, nb::arg("channels"), nb::arg("times"), nb::arg("inputs"), nb::arg("rows"),
                 nb::arg("seconds"),
                 "Step to all times but the first, with a row of inputs and of readings for each step; end early after "
                 "`seconds`. Returns the number of steps, the events, and the class and message of an error.");
  nb::class_<RunReport>(m, "RunReport", "The outcome of one run of a batch.")
      .def_ro("steps", &RunReport::steps)
      .def_ro("is_repeated", &RunReport::is_repeated, "Whether the simulation of another run was used again.")
      .def_ro("error", &RunReport::error)
      .def_ro("warnings", &RunReport::warnings)
      .def_ro("events", &RunReport::events)
      .def_ro("seconds", &RunReport::seconds);
  nb::class_<Batch>(m, "Batch", "Many runs of a scene, which differ by parameters and constant inputs.")
      .def(nb::init<Scene, const std::vector<std::string>&, Channels, const Numbers<1>&, const Numbers<2>&>(),
           nb::arg("scene"), nb::arg("parameters"), nb::arg("channels"), nb::arg("times"), nb::arg("inputs"))
      .def("run", &Batch::run, nb::arg("parameters"), nb::arg("constants"), nb::arg("rows"), nb::arg("seconds"),
           "Make a run for each row of `parameters` and `constants`. Returns the reports of the complete runs.")
      .def("stop", &Batch::stop, "End the calls of `run` in other threads.");
}
