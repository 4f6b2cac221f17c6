// SPDX-License-Identifier: BSD-3-Clause
#include "expression/parse.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <span>
#include <utility>

#include "expression/conditions.h"
#include "expression/library.h"
#include "expression/tokens.h"
#include "util/text.h"

namespace gelenk::expression {
namespace {

constexpr int max_depth = 200;  // of parentheses and signs within each other

// A number, or a condition.
struct Value {
  Term term = -1;
  int condition = -1;
  Token from;  // its first word
};

class Parser {
 public:
  Parser(Graph& graph, std::string_view text, const Names& names)
      : graph_(graph), library_(graph), conditions_(graph), names_(names), tokens_(tokens(text)) {}

  Term whole() {
    if (next().kind == Token::Kind::end) fail(next(), "found nothing, expected an expression");
    const Term out = number(alternatives());
    if (next().kind != Token::Kind::end) fail_after_value();
    return out;
  }

 private:
  const Token& next() const { return tokens_[at_]; }
  const Token& following() const { return tokens_[std::min(at_ + 1, tokens_.size() - 1)]; }
  Token take() { return tokens_[at_ + 1 < tokens_.size() ? at_++ : at_]; }
  bool accept(std::string_view symbol) {
    if (!next().is(symbol)) return false;
    take();
    return true;
  }
  [[noreturn]] static void fail(const Token& at, const std::string& text) {
    throw SyntaxError(at.place, std::max<std::size_t>(1, at.text.size()), text);
  }
  static std::string shown(const Token& token) {
    return token.kind == Token::Kind::end ? "the end" : text::quoted(token.text);
  }

  // Levels are counted where the grammar refers to itself.
  struct Level {
    explicit Level(Parser& of) : depth(of.depth_) {
      if (++depth > max_depth) fail(of.next(), "found more than 200 parentheses within each other");
    }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;
    ~Level() { --depth; }
    int& depth;
  };

  static Term number(const Value& value) {
    if (value.condition >= 0)
      fail(value.from, "found a comparison, expected a number; write if(condition, a, b) to choose between two");
    return value.term;
  }
  static int condition(const Value& value) {
    if (value.condition < 0) fail(value.from, "found a number, expected a comparison, such as s > 0");
    return value.condition;
  }

  Value alternatives() {
    const Level level(*this);
    Value left = joint();
    while (next().is("or")) {
      take();
      left = {.condition = conditions_.either(condition(left), condition(joint())), .from = left.from};
    }
    return left;
  }
  Value joint() {
    Value left = negation();
    while (next().is("and")) {
      take();
      left = {.condition = conditions_.both(condition(left), condition(negation())), .from = left.from};
    }
    return left;
  }
  Value negation() {
    if (!next().is("not")) return comparison();
    const Level level(*this);
    const Token from = take();
    return {.condition = conditions_.negation(condition(negation())), .from = from};
  }
  Value comparison() {
    Value left = sum();
    while (next().is("<") || next().is(">") || next().is("<=") || next().is(">=")) {
      const Token sign = take();
      if (left.condition >= 0) fail(sign, "found a second comparison, expected 'and': write a < b and b < c");
      Term a = number(left);
      Term b = number(sum());
      if (sign.is(">") || sign.is(">=")) std::swap(a, b);
      const bool or_equal = sign.text.size() == 2;
      // a <= b where not a - b > 0
      const int less = or_equal ? conditions_.negation(conditions_.positive(graph_.subtract(a, b)))
                                : conditions_.positive(graph_.subtract(b, a));
      left = {.condition = less, .from = left.from};
    }
    return left;
  }
  Value sum() {
    Value left = product();
    while (next().is("+") || next().is("-")) {
      const bool plus = take().is("+");
      const Term a = number(left);
      const Term b = number(product());
      left = {.term = plus ? graph_.add(a, b) : graph_.subtract(a, b), .from = left.from};
    }
    return left;
  }
  Value product() {
    Value left = sign();
    while (next().is("*") || next().is("/")) {
      const bool times = take().is("*");
      const Term a = number(left);
      const Term b = number(sign());
      left = {.term = times ? graph_.multiply(a, b) : graph_.divide(a, b), .from = left.from};
    }
    return left;
  }
  Value sign() {
    if (!next().is("-") && !next().is("+")) return power();
    const Level level(*this);
    const Token from = take();
    const Term a = number(sign());
    return {.term = from.is("-") ? graph_.negate(a) : a, .from = from};
  }
  Value power() {
    const Value base = primary();
    if (!accept("^")) return base;
    const Level level(*this);
    const Term a = number(base);
    return {.term = graph_.power(a, number(sign())), .from = base.from};
  }

  Value primary() {
    const Token from = take();
    if (from.kind == Token::Kind::number) return finished({.term = graph_.constant(from.value), .from = from});
    if (from.is("(")) {
      Value inside = alternatives();
      close(from);
      inside.from = from;
      return finished(inside);
    }
    if (from.kind == Token::Kind::name) return next().is("(") ? finished(call(from)) : finished(named(from));
    if (from.is(")")) fail(from, "found ')', expected a number, a name or '('");
    fail(from, "found " + shown(from) + ", expected a number, a name or '('");
  }
  void close(const Token& open) {
    if (accept(")")) return;
    if (next().kind == Token::Kind::end) fail(open, "found '(' without ')'");
    fail_after_value();
  }

  // What follows a value must not begin another one.
  Value finished(Value value) {
    const Token& after = next();
    const bool begins_value = after.kind == Token::Kind::number || after.is("(") ||
                              (after.kind == Token::Kind::name && !after.is("and") && !after.is("or"));
    if (begins_value) fail_after_value();
    return value;
  }
  [[noreturn]] void fail_after_value() const {
    const Token& after = next();
    const Token& before = tokens_[at_ == 0 ? 0 : at_ - 1];
    if (after.is(")")) fail(after, "found ')' without '('");
    if (after.is(",")) {
      const bool in_number = before.kind == Token::Kind::number && following().kind == Token::Kind::number;
      fail(after, in_number ? "found ',' in a number; the decimal point is '.': " + std::string(before.text) + "." +
                                  std::string(following().text)
                            : "found ',' outside of the arguments of a function");
    }
    if (before.kind == Token::Kind::number && after.kind == Token::Kind::name && !names_.find(after.text)) {
      if (const std::string unit = advice_on_unit(before.text, after.text); !unit.empty()) fail(after, unit);
    }
    if (after.is("if") || after.is("else"))
      fail(after, "found " + shown(after) + " after a number; write if(condition, a, b)");
    fail(after, "found " + shown(after) + " after " + shown(before) + "; a multiplication is written with '*': " +
                    std::string(before.text) + "*" + std::string(after.text));
  }

  Value named(const Token& name) {
    if (const std::optional<Term> term = names_.find(name.text)) return {.term = *term, .from = name};
    if (name.is("pi")) return {.term = graph_.constant(std::numbers::pi), .from = name};
    if (library_.has(name.text))
      fail(name, "found the function " + shown(name) + " without arguments; write " + library_.form(name.text));
    const std::string advice = names_.advice ? names_.advice(name.text) : std::string();
    fail(name, "found " + shown(name) + ", " + (advice.empty() ? advice_on_name(name.text, names_.known()) : advice));
  }

  Value call(const Token& name) {
    if (!library_.has(name.text)) {
      if (names_.find(name.text) || name.is("pi"))
        fail(name, shown(name) + " is no function; a multiplication is written with '*': " + std::string(name.text) +
                       "*(...)");
      fail(name, "found the function " + shown(name) + ", " + advice_on_function(name.text));
    }
    if (name.is("table")) return looked_up(name);
    const Token open = take();
    std::vector<Value> arguments;
    if (!next().is(")")) {
      do arguments.push_back(alternatives());
      while (accept(","));
    }
    close(open);
    const auto [fewest, most] = library_.arguments(name.text);
    const auto count = static_cast<int>(arguments.size());
    if (count < fewest || count > most) {
      const std::string expected = fewest == most ? std::to_string(fewest) : std::to_string(fewest) + " or more";
      fail_by_count(name, count, expected + ": " + library_.form(name.text));
    }
    if (name.is("if")) {
      const Term out = conditions_.choose(condition(arguments[0]), number(arguments[1]), number(arguments[2]));
      return {.term = out, .from = name};
    }
    std::vector<Term> terms;
    for (const Value& argument : arguments) terms.push_back(number(argument));
    return {.term = library_.applied(name.text, terms), .from = name};
  }

  static void fail_by_count(const Token& name, int count, const std::string& expected) {
    fail(name, shown(name) + ": found " + std::to_string(count) + (count == 1 ? " argument" : " arguments") +
                   ", expected " + expected);
  }

  // After the word `table`: its first argument is the name of one.
  Value looked_up(const Token& word) {
    const Token open = take();
    const Token name = take();
    if (name.kind != Token::Kind::name)
      fail(name, "found " + shown(name) + ", expected the name of a table: " + library_.form(word.text));
    const std::shared_ptr<const Table> table = table_of(name);
    std::vector<Term> of;
    while (accept(",")) of.push_back(number(alternatives()));
    close(open);
    if (table == nullptr) return {.term = graph_.constant(0), .from = word};  // a fault in it has been reported
    if (of.size() != table->arguments()) {
      const bool is_of_one = table->arguments() == 1;
      fail_by_count(word, static_cast<int>(of.size()) + 1,
                    std::string(is_of_one ? "2: table(" : "3: table(") + std::string(name.text) +
                        (is_of_one ? ", x)" : ", x, y)"));
    }
    return {.term = graph_.look_up(table, of[0], of.size() > 1 ? of[1] : -1), .from = word};
  }
  std::shared_ptr<const Table> table_of(const Token& name) const {
    std::vector<std::string> known;
    for (std::size_t k = 0; names_.tables != nullptr && k < names_.tables->size(); ++k) {
      const NamedTable& one = (*names_.tables)[k];
      if (one.name == name.text) return one.table;
      known.push_back(one.name);
    }
    fail(name, "found " + shown(name) + ", which is no table, expected " +
                   (known.empty() ? "a table of the section 'tables'" : text::one_of(name.text, known, "tables")));
  }

  Graph& graph_;
  Library library_;
  Conditions conditions_;
  const Names& names_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Term parse(Graph& graph, std::string_view text, const Names& names) {
  if (text.size() > max_length)
    throw SyntaxError(
        max_length, 1,
        "found " + std::to_string(text.size()) + " characters, expected at most " + std::to_string(max_length));
  return Parser(graph, text, names).whole();
}

}  // namespace gelenk::expression
