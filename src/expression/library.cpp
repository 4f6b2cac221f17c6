// SPDX-License-Identifier: BSD-3-Clause
#include "expression/library.h"

#include <algorithm>
#include <array>
#include <limits>

#include "util/text.h"

namespace gelenk::expression {
namespace {

struct Function {
  std::string_view name, form;
  int fewest = 1, most = 1;
  Operation operation = Operation::constant;  // constant: composed of others
};

constexpr int any_number = std::numeric_limits<int>::max();
constexpr Function functions[] = {
    {"sin", "sin(x)", 1, 1, Operation::sin},
    {"cos", "cos(x)", 1, 1, Operation::cos},
    {"tan", "tan(x)", 1, 1, Operation::tan},
    {"asin", "asin(x)", 1, 1, Operation::asin},
    {"acos", "acos(x)", 1, 1, Operation::acos},
    {"atan", "atan(x)", 1, 1, Operation::atan},
    {"atan2", "atan2(y, x)", 2, 2, Operation::atan2},
    {"sinh", "sinh(x)", 1, 1, Operation::sinh},
    {"cosh", "cosh(x)", 1, 1, Operation::cosh},
    {"tanh", "tanh(x)", 1, 1, Operation::tanh},
    {"asinh", "asinh(x)", 1, 1, Operation::asinh},
    {"acosh", "acosh(x)", 1, 1, Operation::acosh},
    {"atanh", "atanh(x)", 1, 1, Operation::atanh},
    {"exp", "exp(x)", 1, 1, Operation::exp},
    {"log", "log(x)", 1, 1, Operation::log},
    {"log10", "log10(x)", 1, 1, Operation::log10},
    {"sqrt", "sqrt(x)", 1, 1, Operation::sqrt},
    {"cbrt", "cbrt(x)", 1, 1, Operation::cbrt},
    {"erf", "erf(x)", 1, 1, Operation::erf},
    {"abs", "abs(x)"},
    {"sign", "sign(x)"},
    {"pow", "pow(x, y)", 2, 2},
    {"hypot", "hypot(x, y)", 2, 2},
    {"min", "min(a, b, ...)", 2, any_number},
    {"max", "max(a, b, ...)", 2, any_number},
    {"clip", "clip(x, lower, upper)", 3, 3},
    {"smoothstep", "smoothstep(x, from, to)", 3, 3},
    {"if", "if(condition, a, b)", 3, 3},
    {"table", "table(name, x), or table(name, x, y)", 2, 3},
};

const Function* found(std::string_view name) {
  const auto* const at = std::ranges::find(functions, name, &Function::name);
  return at == std::end(functions) ? nullptr : at;
}

struct Instead {
  std::string_view name, meant;
};
// Names in other languages.
constexpr Instead of_functions[] = {
    {"ln", "the natural logarithm is log(x)"},
    {"lg", "the logarithm to base 10 is log10(x)"},
    {"log2", "write log(x)/log(2)"},
    {"exp2", "write 2^x"},
    {"sqr", "write x^2"},
    {"square", "write x^2"},
    {"power", "write x^y"},
    {"fabs", "write abs(x)"},
    {"sgn", "write sign(x)"},
    {"signum", "write sign(x)"},
    {"clamp", "write clip(x, lower, upper)"},
    {"saturate", "write clip(x, lower, upper)"},
    {"sat", "write clip(x, lower, upper)"},
    {"limit", "write clip(x, lower, upper)"},
    {"arcsin", "write asin(x)"},
    {"arccos", "write acos(x)"},
    {"arctan", "write atan(x)"},
    {"arctan2", "write atan2(y, x)"},
    {"tg", "write tan(x)"},
    {"cot", "write 1/tan(x)"},
    {"sec", "write 1/cos(x)"},
    {"lookup", "write table(name, x)"},
    {"interp", "write table(name, x)"},
    {"interp1", "write table(name, x)"},
    {"interp2", "write table(name, x, y)"},
    {"where", "write if(condition, a, b)"},
    {"iff", "write if(condition, a, b)"},
    {"ifelse", "write if(condition, a, b)"},
    {"heaviside", "write if(x > 0, 1, 0)"},
    {"step", "write if(x > 0, 1, 0)"},
    {"rad", "write x*pi/180"},
    {"radians", "write x*pi/180"},
    {"deg", "write x*180/pi"},
    {"degrees", "write x*180/pi"},
    {"der", "a derivative in time is a name of its own, such as the speed w of the angle phi"},
    {"floor", "functions that jump again and again are not available"},
    {"ceil", "functions that jump again and again are not available"},
    {"round", "functions that jump again and again are not available"},
    {"mod", "functions that jump again and again are not available"},
    {"fmod", "functions that jump again and again are not available"},
};
constexpr Instead of_names[] = {
    {"e", "Euler's number is exp(1)"},
    {"E", "Euler's number is exp(1)"},
    {"PI", "write pi"},
    {"Pi", "write pi"},
    {"inf", "expected a finite number"},
    {"nan", "expected a number"},
    {"True", "write a comparison"},
    {"true", "write a comparison"},
    {"False", "write a comparison"},
    {"false", "write a comparison"},
    {"time", "the time is t"},
    {"else", "write if(condition, a, b)"},
};
constexpr std::string_view units[] = {"m",  "mm",  "cm",  "km", "kg",  "g",   "s", "ms", "N", "kN", "Nm", "rad",
                                      "Hz", "rpm", "bar", "Pa", "kPa", "MPa", "V", "A",  "W", "kW", "J",  "K"};

// Without the name of a module of Python.
std::string_view without_module(std::string_view name) {
  for (const std::string_view module : {"math.", "np.", "numpy.", "std.", "Modelica.Math."}) {
    if (name.starts_with(module)) return name.substr(module.size());
  }
  return name;
}

template <std::size_t n>
std::string_view meant_by(const Instead (&list)[n], std::string_view name) {
  const auto* const at = std::ranges::find(list, name, &Instead::name);
  return at == std::end(list) ? std::string_view() : at->meant;
}

}  // namespace

bool Library::has(std::string_view name) { return found(name) != nullptr; }

std::vector<std::string> Library::names() {
  std::vector<std::string> out;
  for (const Function& function : functions) out.emplace_back(function.name);
  return out;
}

std::pair<int, int> Library::arguments(std::string_view name) {
  const Function* function = found(name);
  return {function->fewest, function->most};
}

std::string Library::form(std::string_view name) { return std::string(found(name)->form); }

Term Library::absolute(Term x) { return graph_.choose(x, x, graph_.negate(x)); }
Term Library::least(Term a, Term b) { return graph_.choose(graph_.subtract(b, a), a, b); }
Term Library::largest(Term a, Term b) { return graph_.choose(graph_.subtract(a, b), a, b); }

Term Library::applied(std::string_view name, const std::vector<Term>& arguments) {
  const std::vector<Term>& of = arguments;
  const Function& function = *found(name);
  if (function.operation == Operation::atan2) return graph_.function(function.operation, of[0], of[1]);
  if (function.operation != Operation::constant) return graph_.function(function.operation, of[0]);
  if (name == "abs") return absolute(of[0]);
  if (name == "sign") {
    const Term not_positive = graph_.choose(graph_.negate(of[0]), graph_.constant(-1), graph_.constant(0));
    return graph_.choose(of[0], graph_.constant(1), not_positive);
  }
  if (name == "pow") return graph_.power(of[0], of[1]);
  if (name == "hypot") {
    const Term sum = graph_.add(graph_.integer_power(of[0], 2), graph_.integer_power(of[1], 2));
    return graph_.function(Operation::sqrt, sum);
  }
  if (name == "clip") return least(largest(of[0], of[1]), of[2]);
  if (name == "smoothstep") {
    const Term ratio = graph_.divide(graph_.subtract(of[0], of[1]), graph_.subtract(of[2], of[1]));
    const Term x = least(largest(ratio, graph_.constant(0)), graph_.constant(1));
    const Term rest = graph_.subtract(graph_.constant(3), graph_.multiply(graph_.constant(2), x));
    return graph_.multiply(graph_.integer_power(x, 2), rest);
  }
  Term out = of[0];
  for (std::size_t k = 1; k < of.size(); ++k) out = name == "min" ? least(out, of[k]) : largest(out, of[k]);
  return out;
}

std::string advice_on_function(std::string_view name) {
  const std::string_view plain = without_module(name);
  if (const std::string_view meant = meant_by(of_functions, plain); !meant.empty()) return std::string(meant);
  if (plain != name && Library::has(plain)) return "expected " + Library::form(plain);
  std::vector<std::string> names = Library::names();
  const std::string near = text::nearest(plain, names);
  if (!near.empty()) return "did you mean " + Library::form(near) + "?";
  return "expected one of " + text::list(names);
}

std::string advice_on_name(std::string_view name, const std::vector<std::string>& known) {
  if (const std::string_view meant = meant_by(of_names, without_module(name)); !meant.empty())
    return std::string(meant);
  if (const std::string near = text::nearest(name, known); !near.empty()) return "did you mean '" + near + "'?";
  if (known.empty()) return "expected a number or a function; there are no names here";
  return "expected " + text::one_of(name, known, "names");
}

std::string advice_on_unit(std::string_view number, std::string_view name) {
  const std::string shown(number);
  if (name == "deg" || name == "degree" || name == "degrees")
    return "found a unit; angles are in rad: write " + shown + "*pi/180";
  if (std::ranges::find(units, name) == std::end(units)) return {};
  return "found " + text::quoted(name) + " after " + shown +
         "; numbers are in SI units, without a name, and a multiplication is written with '*'";
}

}  // namespace gelenk::expression
