// SPDX-License-Identifier: BSD-3-Clause
#include "machine_code/one_lane.h"

#include <cmath>
#include <cstdint>

#include "lanes/library_function.h"
#include "lanes/sine.h"

namespace gelenk::machine_code {
namespace {

using lanes::Code;
using Two [[gnu::vector_size(16), gnu::may_alias]] = double;
using TwoIntegers [[gnu::vector_size(16), gnu::may_alias]] = std::int64_t;

void sine_cosine(double x, double& sine, double& cosine) {
  if (!(std::abs(x) <= lanes::circular_limit)) {
    sine = std::sin(x);
    cosine = std::cos(x);
    return;
  }
  Two s;
  Two c;
  lanes::sine_cosine<Two, TwoIntegers>(Two{x, x}, s, c);
  sine = s[0];
  cosine = c[0];
}

}  // namespace

// NOLINTNEXTLINE(readability-function-cognitive-complexity,readability-function-size): a line for each kind
void run_one(const lanes::Instruction& i, double* memory) {
  const auto a = [&] { return memory[i.a]; };
  const auto b = [&] { return memory[i.b]; };
  const auto c = [&] { return memory[i.c]; };
  double& to = memory[i.to];
  double unused = 0;
  switch (i.code) {
    case Code::copy:
      to = a();
      break;
    case Code::add:
      to = a() + b();
      break;
    case Code::subtract:
      to = a() - b();
      break;
    case Code::multiply:
      to = a() * b();
      break;
    case Code::divide:
      to = a() / b();
      break;
    case Code::negate:
      to = -a();
      break;
    case Code::add_constant:
      to = a() + i.k;
      break;
    case Code::subtract_from_constant:
      to = i.k - a();
      break;
    case Code::scale:
      to = i.k * a();
      break;
    case Code::divide_constant:
      to = i.k / a();
      break;
    case Code::multiply_add:
      to = a() * b() + c();
      break;
    case Code::multiply_subtract:
      to = a() * b() - c();
      break;
    case Code::subtract_multiply:
      to = c() - a() * b();
      break;
    case Code::multiply_add_multiply:
      to = a() * b() + c() * memory[i.d];
      break;
    case Code::multiply_subtract_multiply:
      to = a() * b() - c() * memory[i.d];
      break;
    case Code::scale_add:
      to = i.k * a() + c();
      break;
    case Code::scale_subtract:
      to = i.k * a() - c();
      break;
    case Code::subtract_scale:
      to = c() - i.k * a();
      break;
    case Code::sine:
      sine_cosine(a(), to, unused);
      break;
    case Code::cosine:
      sine_cosine(a(), unused, to);
      break;
    case Code::sine_cosine:
      sine_cosine(a(), to, memory[i.b]);
      break;
    case Code::square_root:
      to = std::sqrt(a());
      break;
    case Code::choose:
      to = a() > 0 ? b() : c();
      break;
    case Code::function:
      to = lanes::library_function(i.function, a(), i.b < 0 ? 0 : b());
      break;
  }
}

}  // namespace gelenk::machine_code
