// SPDX-License-Identifier: BSD-3-Clause
// Inputs as functions of time, the master's clock, archives, brackets of a zero, cubics of a step, realized stages, the
// monitor of singular configurations.
#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "event/cubic.h"
#include "event/scheme_watch.h"
#include "event/singularity_monitor.h"
#include "event/step_polynomial.h"
#include "fmu/clock.h"
#include "formulation/inputs.h"
#include "kinematics/stages.h"
#include "math/bracket.h"
#include "units.h"
#include "util/archive.h"

namespace nb = nanobind;

namespace native {
namespace {

// One value of each type that archives contain.
struct Sample {
  double x = 0;
  std::uint64_t word = 0;
  bool flag = false;
  int small = 0;
  long large = 0;
  int place = 0;  // index of one of four
  Numbers list;

  void serialize(gelenk::Archive& archive) {
    archive.serialize(x, word, flag, small, large);
    archive.serialize_in_range(place, 0, 3);
    archive.serialize(list);
  }
};

template <class T>
void bind_words(nb::class_<T>& c) {
  c.def("words", [](T& x) {
     gelenk::Archive archive;
     x.serialize(archive);
     const auto words = archive.words();
     return std::vector<std::uint64_t>(words.begin(), words.end());
   }).def("read", [](T& x, std::vector<std::uint64_t> words) {
    gelenk::Archive archive(std::move(words));
    x.serialize(archive);
    archive.finish();
  });
}

// Equations as a function of Python.
struct GivenRates final : gelenk::EventSource {
  explicit GivenRates(const nb::callable& rates, std::size_t size) : of(rates), size(size) {}
  nb::callable of;
  std::size_t size;

  bool rates(double t, const double* y, double* ydot) override {
    std::ranges::copy(nb::cast<Numbers>(of(t, Numbers(y, y + size))), ydot);
    return true;
  }
};

// The state at t within a step, each end with (t, y); empty where the polynomial is not accurate.
using End = std::pair<double, Numbers>;
Numbers within_step(const nb::callable& rates, const End& start, const End& end, double t) {
  const auto& [t0, y0] = start;
  const auto& [t1, y1] = end;
  GivenRates source(rates, y0.size());
  gelenk::StepPolynomial polynomial(static_cast<int>(y0.size()));
  if (!polynomial.set(source, t0, y0.data(), t1, y1.data())) return {};
  Numbers out(y0.size());
  polynomial.at(t, out.data());
  return out;
}

}  // namespace

void bind_times(nb::module_& m) {
  using gelenk::Bracket;
  using gelenk::Clock;
  using gelenk::Inputs;
  using gelenk::SingularityMonitor;

  m.def("within_step", &within_step);

  auto sample = nb::class_<Sample>(m, "Sample").def(nb::init<>());
  sample.def_rw("x", &Sample::x).def_rw("word", &Sample::word).def_rw("flag", &Sample::flag);
  sample.def_rw("small", &Sample::small).def_rw("large", &Sample::large).def_rw("place", &Sample::place);
  sample.def_rw("list", &Sample::list);
  bind_words(sample);

  auto inputs = nb::class_<Inputs>(m, "Inputs").def(nb::init<std::size_t>());
  nb::enum_<Inputs::Change>(m, "Change")
      .value("none", Inputs::Change::none)
      .value("smooth", Inputs::Change::smooth)
      .value("jump", Inputs::Change::jump);
  inputs.def_prop_ro("now", [](const Inputs& u) { return u.now(); })
      .def_prop_ro("moving", &Inputs::moving)
      .def("go_to", &Inputs::go_to)
      .def("value", &Inputs::value)
      .def("derivative", &Inputs::derivative)
      .def("rate", &Inputs::rate)
      .def("derivative_at", &Inputs::derivative_at)
      .def("set", &Inputs::set)
      .def("set_derivative", &Inputs::set_derivative)
      .def_static("fault", &Inputs::fault)
      .def("start", &Inputs::start)
      .def("finish", &Inputs::finish)
      .def("interrupt", &Inputs::interrupt)
      .def("same", [](const Inputs& a, const Inputs& b) { return a == b; });
  inputs.def_ro_static("highest_order", &Inputs::highest_order);
  bind_words(inputs);

  auto clock = nb::class_<Clock>(m, "Clock").def(nb::init<>());
  clock.def("start", &Clock::start).def("continues_at", &Clock::continues_at).def("step", &Clock::step);
  clock.def_prop_ro("end", &Clock::end);
  bind_words(clock);

  nb::class_<Bracket>(m, "Bracket")
      .def(nb::init<double, double, double, double>())
      .def_prop_ro("low", &Bracket::low)
      .def_prop_ro("high", &Bracket::high)
      .def_prop_ro("width", &Bracket::width)
      .def("clamped", &Bracket::clamped)
      .def("next", &Bracket::next)
      .def("update", &Bracket::update);

  using gelenk::Cubic;
  nb::class_<Cubic>(m, "Cubic")
      .def(nb::init<double, double, double, double>())
      .def("value", &Cubic::value)
      .def("zero", &Cubic::zero)
      .def("has_extremum", &Cubic::has_extremum)
      .def("extremum", &Cubic::extremum);

  using gelenk::SchemeWatch;
  auto watch = nb::class_<SchemeWatch>(m, "SchemeWatch").def(nb::init<double>());
  watch.def("located", &SchemeWatch::located)
      .def("are_too_many",
           [](const SchemeWatch& of, int closed) { return of.too_many(closed) != gelenk::SchemeChange::Cause::none; })
      .def("leave_events", &SchemeWatch::leave_events)
      .def("stepped",
           [](SchemeWatch& of, double time, bool changed, int closed) {
             of.stepped(time, changed, closed);
             return of.is_quiet();
           })
      .def("return_to_events", &SchemeWatch::return_to_events);
  bind_words(watch);

  using gelenk::Computed;
  using gelenk::Stage;
  using gelenk::Stages;
  nb::enum_<Stage>(m, "Stage")
      .value("position", Stage::position)
      .value("velocity", Stage::velocity)
      .value("acceleration", Stage::acceleration);
  nb::class_<Stages>(m, "Stages")
      .def(nb::init<>())
      .def("has", &Stages::has)
      .def("realize", &Stages::realize)
      .def("clear", &Stages::clear);
  nb::class_<Computed>(m, "Computed")
      .def(nb::init<Stage>())
      .def("holds", &Computed::holds)
      .def("set", &Computed::set)
      .def("drop", &Computed::drop);

  auto passages = nb::class_<SingularityMonitor>(m, "Passages").def(nb::init<>());
  passages.def("seen", &SingularityMonitor::observe)
      .def("accepted", &SingularityMonitor::accepted)
      .def("restart", &SingularityMonitor::restart);
  passages.def_prop_ro("count", &SingularityMonitor::count).def_prop_ro("last", &SingularityMonitor::last);
  bind_words(passages);
}

}  // namespace native
