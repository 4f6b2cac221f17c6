// SPDX-License-Identifier: BSD-3-Clause
#include "expression/parse.h"
#include "expression/tape.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <string>
#include <vector>

#include "units.h"

namespace nb = nanobind;
using namespace gelenk::expression;

namespace native {
namespace {

// y empty: a table over x alone. Kinds: by their numbers.
NamedTable made_table(const std::string& name, const Numbers& x, const Numbers& y, const Numbers& values,
                      int interpolation, int extrapolation) {
  const auto beyond = static_cast<Extrapolation>(extrapolation);
  return {name, std::make_shared<const gelenk::expression::Table>(
                    gelenk::expression::Table::Data{.name = name,
                                                    .x = x,
                                                    .y = y,
                                                    .values = values,
                                                    .interpolation = static_cast<Interpolation>(interpolation),
                                                    .extrapolation = {beyond, beyond}})};
}

// An expression in named variables, evaluated in all ways. clock: the variable that is the time; -1: none.
class Expression {
 public:
  Expression(const std::string& text, const std::vector<std::string>& names, const std::vector<NamedTable>& tables,
             int clock) {
    const Names known{.find = [&](std::string_view name) -> std::optional<Term> {
                        for (std::size_t k = 0; k < names.size(); ++k) {
                          if (names[k] == name) return graph_.variable(static_cast<int>(k));
                        }
                        return std::nullopt;
                      },
                      .known = [&] { return names; },
                      .tables = &tables};
    try {
      term_ = parse(graph_, text, known);
    } catch (const SyntaxError& error) {
      throw nb::value_error(with_caret(error, text).c_str());
    }
    tape_ = Tape(graph_, {term_}, clock);
  }

  double value(const Numbers& x) const {
    double out = 0;
    tape_.evaluate(x.data(), &out);
    return out;
  }
  Numbers gradient(const Numbers& x) const {
    std::vector<gelenk::Dual> at(x.begin(), x.end());
    for (std::size_t k = 0; k < at.size(); ++k) at[k].derivatives()[static_cast<Eigen::Index>(k)] = 1;
    gelenk::Dual out;
    tape_.evaluate(at.data(), &out);
    return {out.derivatives().begin(), out.derivatives().begin() + static_cast<std::ptrdiff_t>(x.size())};
  }
  // The coefficients of the expression of x + rate t + acceleration t^2 / 2.
  Numbers series(const Numbers& x, const Numbers& rate, const Numbers& acceleration) const {
    std::vector<gelenk::Series> at;
    for (std::size_t k = 0; k < x.size(); ++k)
      at.emplace_back(gelenk::Series::Coefficients{x[k], rate[k], acceleration[k] / 2});
    gelenk::Series out;
    tape_.evaluate(at.data(), &out);
    return {out[0], out[1], out[2]};
  }
  // The value of the derivative with respect to these variables, one after the other.
  double derivative(const std::vector<int>& variables, const Numbers& x) {
    Term term = term_;
    for (const int variable : variables) term = gelenk::expression::derivative(graph_, term, variable);
    double out = 0;
    Tape(graph_, {term}).evaluate(x.data(), &out);
    return out;
  }
  Numbers arguments(const Numbers& x) const {
    Numbers out(static_cast<std::size_t>(tape_.choices()));
    double value = 0;
    tape_.evaluate(x.data(), &value, nullptr, out.data());
    return out;
  }
  double held(const Numbers& x, const std::vector<bool>& first) const {
    const auto sides = std::make_unique<bool[]>(first.size());
    for (std::size_t k = 0; k < first.size(); ++k) sides[k] = first[k];
    double out = 0;
    tape_.evaluate(x.data(), &out, sides.get());
    return out;
  }
  double next_break(double t) const { return tape_.next_break(t); }
  int operations() const { return tape_.operations(); }
  bool depends_on(int variable) const { return graph_.depends_on(term_, variable); }
  bool has_choices() const { return graph_.has_choices(term_); }

 private:
  Graph graph_;
  Term term_ = -1;
  Tape tape_;
};

}  // namespace

void bind_expressions(nb::module_& m) {
  nb::class_<NamedTable>(m, "Table")
      .def("__init__", [](NamedTable* at, const std::string& name, const Numbers& x, const Numbers& y,
                          const Numbers& values, int interpolation, int extrapolation) {
        new (at) NamedTable(made_table(name, x, y, values, interpolation, extrapolation));
      });
  m.def("doubt_about", [](const NamedTable& table) { return table.table->doubt(); });
  nb::class_<Expression>(m, "Expression")
      .def(nb::init<const std::string&, const std::vector<std::string>&, const std::vector<NamedTable>&, int>(),
           nb::arg("text"), nb::arg("names"), nb::arg("tables") = std::vector<NamedTable>(), nb::arg("clock") = -1)
      .def("next_break", &Expression::next_break)
      .def("value", &Expression::value)
      .def("gradient", &Expression::gradient)
      .def("series", &Expression::series)
      .def("derivative", &Expression::derivative)
      .def("arguments", &Expression::arguments)
      .def("held", &Expression::held)
      .def("depends_on", &Expression::depends_on)
      .def("has_choices", &Expression::has_choices)
      .def("operations", &Expression::operations);
}

}  // namespace native
