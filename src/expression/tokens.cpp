// SPDX-License-Identifier: BSD-3-Clause
#include "expression/tokens.h"

#include <algorithm>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>

#include "util/text.h"

namespace gelenk::expression {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool continues_name(char c) { return is_letter(c) || is_digit(c); }

// What people write, and what is meant. Longer ones first.
constexpr std::pair<std::string_view, std::string_view> habits[] = {
    {"**", "a power is written x^2"},
    {"==", "numbers are compared by <, <=, > and >=; two real numbers are hardly ever equal"},
    {"!=", "numbers are compared by <, <=, > and >=; two real numbers are hardly ever equal"},
    {"&&", "write 'and'"},
    {"||", "write 'or', or abs(x) for |x|"},
    {"//", "a division is written /"},
    {"=", "an expression has no '='; numbers are compared by <, <=, > and >="},
    {"&", "write 'and'"},
    {"|", "write abs(x) for |x|, and 'or' between comparisons"},
    {"!", "write 'not'"},
    {"?", "write if(condition, a, b)"},
    {":", "write if(condition, a, b)"},
    {"%", "there is no remainder and no percentage; write 0.05 for 5 %"},
    {"'",
     "names are written without quotes; a derivative in time is a name of its own, such as the speed w of the "
     "angle phi"},
    {"\"", "names are written without quotes"},
    {"[", "an index follows a name without a space: tip.r[1]"},
    {"{", "parentheses are ( and )"},
    {"}", "parentheses are ( and )"},
    {"]", "parentheses are ( and )"},
    {";", "an expression is one formula"},
    {"\u00b0", "angles are in rad: write 90*pi/180 for 90 degrees"},
    {"\u00b2", "write x^2"},
    {"\u00b3", "write x^3"},
    {"\u2212", "write the minus sign as -"},
    {"\u2013", "write the minus sign as -"},
    {"\u00d7", "write *"},
    {"\u00b7", "write *"},
    {"\u22c5", "write *"},
    {"\u00f7", "write /"},
    {"\u2264", "write <="},
    {"\u2265", "write >="},
    {"\u03c0", "write pi"},
    {"\u221a", "write sqrt(x)"},
};

constexpr std::string_view symbols[] = {"<=", ">=", "<", ">", "+", "-", "*", "/", "^", "(", ")", ","};

std::size_t length_of_character(std::string_view text) {
  std::size_t n = 1;
  while (n < text.size() && (static_cast<unsigned char>(text[n]) & 0xC0) == 0x80) ++n;
  return n;
}

std::size_t digits(std::string_view text, std::size_t from) {
  std::size_t at = from;
  while (at < text.size() && is_digit(text[at])) ++at;
  return at - from;
}

// Length of the number with which the text begins: digits with a point, and an exponent if it has digits.
std::size_t length_of_number(std::string_view text) {
  std::size_t at = digits(text, 0);
  if (at < text.size() && text[at] == '.') at += 1 + digits(text, at + 1);
  if (at + 1 < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    const std::size_t power = at + (text[at + 1] == '+' || text[at + 1] == '-' ? 2 : 1);
    if (digits(text, power) > 0) at = power + digits(text, power);
  }
  return at;
}

// from_chars is not used: the FMU would require a newer C library. strtod expects the point of the locale.
double value_of(std::string_view number) {
  std::string own(number);
  const char* const point = std::localeconv()->decimal_point;
  if (const std::size_t at = own.find('.'); at != std::string::npos) own.replace(at, 1, point);
  return std::strtod(own.c_str(), nullptr);
}

class Tokenizer {
 public:
  explicit Tokenizer(std::string_view text) : text_(text) {}

  std::vector<Token> all() && {
    while (true) {
      while (at_ < text_.size() && is_space(text_[at_])) ++at_;
      if (at_ == text_.size()) break;
      out_.push_back(next());
    }
    out_.push_back({Token::Kind::end, text_.substr(text_.size()), text_.size()});
    return std::move(out_);
  }

 private:
  Token next() {
    const char c = text_[at_];
    if (is_digit(c) || (c == '.' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1]))) return number();
    if (is_letter(c)) return name();
    const std::string_view rest = text_.substr(at_);
    for (const auto& [habit, instead] : habits) {
      if (rest.starts_with(habit))
        throw SyntaxError(at_, habit.size(), "found '" + std::string(habit) + "': " + std::string(instead));
    }
    for (const std::string_view symbol : symbols) {
      if (rest.starts_with(symbol)) return taken(Token::Kind::symbol, symbol.size());
    }
    const std::size_t length = length_of_character(rest);
    throw SyntaxError(at_, length,
                      "found " + text::quoted(rest.substr(0, length)) + ", expected a number, a name or an operator");
  }

  Token taken(Token::Kind kind, std::size_t length) {
    const Token out{kind, text_.substr(at_, length), at_};
    at_ += length;
    return out;
  }

  Token number() {
    const std::size_t length = length_of_number(text_.substr(at_));
    const double value = value_of(text_.substr(at_, length));
    if (!std::isfinite(value)) throw SyntaxError(at_, length, "found a number that is too large for 64 bits");
    if (at_ + length < text_.size() && text_[at_ + length] == '.')
      throw SyntaxError(at_, length + 1, "found two decimal points in a number");
    Token out = taken(Token::Kind::number, length);
    out.value = value;
    return out;
  }

  Token name() {
    std::size_t end = at_;
    const auto pass_identifier = [&] {
      while (end < text_.size() && continues_name(text_[end])) ++end;
    };
    pass_identifier();
    while (end + 1 < text_.size() && text_[end] == '.' && is_letter(text_[end + 1])) {
      ++end;
      pass_identifier();
    }
    if (end < text_.size() && text_[end] == '[') {
      const std::size_t close = text_.find(']', end);
      const std::string_view index = text_.substr(end + 1, close == text_.npos ? text_.npos : close - end - 1);
      if (close == text_.npos || index.empty() || !std::ranges::all_of(index, is_digit))
        throw SyntaxError(end, 1, "found '[' without a number and ']' after it, such as tip.r[1]");
      end = close + 1;
    }
    return taken(Token::Kind::name, end - at_);
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::vector<Token> out_;
};

}  // namespace

std::vector<Token> tokens(std::string_view text) { return Tokenizer(text).all(); }

std::string with_caret(const SyntaxError& error, std::string_view text) {
  const std::size_t place = std::min(error.place, text.size());
  const std::size_t line = place == 0 ? 0 : text.rfind('\n', place - 1) + 1;  // npos + 1 is 0
  const std::size_t end = std::min(text.find('\n', place), text.size());
  const auto characters = [&](std::size_t from, std::size_t to) {
    std::size_t n = 0;
    for (std::size_t i = from; i < to; i += length_of_character(text.substr(i))) ++n;
    return n;
  };
  const std::size_t column = characters(line, place);
  const std::size_t marks = std::max<std::size_t>(1, characters(place, std::min(place + error.length, end)));
  return "column " + std::to_string(column + 1) + ": " + error.what() + "\n  " +
         std::string(text.substr(line, end - line)) + "\n  " + std::string(column, ' ') + std::string(marks, '^');
}

}  // namespace gelenk::expression
