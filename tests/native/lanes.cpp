// SPDX-License-Identifier: BSD-3-Clause
#include "expression/parse.h"
#include "expression/tape.h"
#include "lanes/kernels.h"
#include "lanes/program.h"
#include "machine_code/compiled_program.h"

#include <nanobind/stl/array.h>
#include <nanobind/stl/set.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "units.h"

namespace nb = nanobind;
using namespace gelenk::expression;
namespace lanes = gelenk::lanes;
namespace machine_code = gelenk::machine_code;

namespace native {
namespace {

// Expressions in named variables, by a program on lanes and by a tape.
class Lanes {
 public:
  Lanes(const std::vector<std::string>& texts, const std::vector<std::string>& names) {
    const Names known{.find = [&](std::string_view name) -> std::optional<Term> {
                        for (std::size_t k = 0; k < names.size(); ++k) {
                          if (names[k] == name) return graph_.variable(static_cast<int>(k));
                        }
                        return std::nullopt;
                      },
                      .known = [&] { return names; }};
    for (const std::string& text : texts) terms_.push_back(parse(graph_, text, known));
    lanes::Slots given;
    first_ = frame_.add(static_cast<int>(names.size()));
    for (int k = 0; k < static_cast<int>(names.size()); ++k) given.emplace(graph_.variable(k), first_ + k);
    result_ = frame_.add(static_cast<int>(terms_.size()));
    std::vector<lanes::Output> outputs;
    for (std::size_t k = 0; k < terms_.size(); ++k) outputs.emplace_back(terms_[k], result_ + static_cast<int>(k));
    program_ = lanes::Program(graph_, given, outputs, frame_);
    lanes::Program of_one(graph_, given, outputs, frame_, lanes::Order::calls_first);
    program_.place_temporaries(frame_);
    of_one.place_temporaries(frame_);
    alone_ = machine_code::CompiledProgram(of_one.instructions(), frame_.fixed());
    machine_code::ExecutableMemory::refuse(true);
    refused_ = machine_code::CompiledProgram(of_one.instructions(), frame_.fixed());
    machine_code::ExecutableMemory::refuse(false);
  }

  // x: by variable. encoded: by machine code, otherwise as where the system permits none.
  Numbers alone(const Numbers& x, bool encoded) const {
    Numbers memory(static_cast<std::size_t>(frame_.size()));
    for (const auto& [number, value] : frame_.constants()) memory[static_cast<std::size_t>(number)] = value;
    std::ranges::copy(x, memory.begin() + first_);
    (encoded ? alone_ : refused_).run(memory.data());
    // What is given is not overwritten.
    if (!std::ranges::equal(x, std::span(memory).subspan(static_cast<std::size_t>(first_), x.size()))) return {};
    return {memory.begin() + result_, memory.begin() + result_ + static_cast<std::ptrdiff_t>(terms_.size())};
  }
  std::array<bool, 2> are_encoded() const { return {alone_.is_encoded(), refused_.is_encoded()}; }

  // x: by variable, by lane. Returns the expressions, by lane.
  Table by_lanes(const Table& x) const {
    constexpr auto W = static_cast<std::size_t>(lanes::lanes_per_block);
    constexpr std::size_t alignment = 64;
    std::vector<double> storage((static_cast<std::size_t>(frame_.size()) * W) + alignment);
    void* start = storage.data();
    std::size_t space = storage.size() * sizeof(double);
    auto* const memory = static_cast<double*>(std::align(alignment, sizeof(double), start, space));
    const auto slot = [&](int number) { return memory + (static_cast<std::size_t>(number) * W); };
    for (const auto& [number, value] : frame_.constants()) std::fill_n(slot(number), W, value);
    for (std::size_t k = 0; k < x.size(); ++k) std::copy_n(x[k].begin(), W, slot(first_ + static_cast<int>(k)));
    lanes::run(program_.instructions(), memory);
    Table out;
    for (std::size_t k = 0; k < terms_.size(); ++k) {
      const double* const row = slot(result_ + static_cast<int>(k));
      out.emplace_back(row, row + W);
    }
    return out;
  }
  Numbers by_tape(const Numbers& x) const {
    Numbers out(terms_.size());
    Tape(graph_, terms_).evaluate(x.data(), out.data());
    return out;
  }
  // The kinds of instructions of the program, by their numbers.
  std::set<int> codes() const {
    std::set<int> out;
    for (const lanes::Instruction& i : program_.instructions()) out.insert(static_cast<int>(i.code));
    return out;
  }

 private:
  Graph graph_;
  std::vector<Term> terms_;
  lanes::Frame frame_;
  lanes::Program program_;
  machine_code::CompiledProgram alone_, refused_;
  int first_ = 0, result_ = 0;
};

}  // namespace

void bind_lanes(nb::module_& m) {
  m.attr("lanes_per_block") = lanes::lanes_per_block;
  m.attr("lane_codes") = static_cast<int>(lanes::Code::function) + 1;
  m.attr("has_encoder") = machine_code::has_encoder;
  m.def("use_all_lane_instructions", &lanes::use_all_instructions);
  nb::class_<Lanes>(m, "Lanes")
      .def(nb::init<const std::vector<std::string>&, const std::vector<std::string>&>())
      .def("by_lanes", &Lanes::by_lanes)
      .def("alone", &Lanes::alone)
      .def("are_encoded", &Lanes::are_encoded)
      .def("by_tape", &Lanes::by_tape)
      .def("codes", &Lanes::codes);
}

}  // namespace native
