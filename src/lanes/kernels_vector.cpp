// SPDX-License-Identifier: BSD-3-Clause
// Compiled on its own, with vectorized loops: cmake/GelenkPython.cmake.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "expression/functions.h"
#include "lanes/kernels.h"
#include "lanes/library_function.h"
#include "lanes/sine.h"

// What is not the same on every processor is chosen when a program runs.
#if defined(__x86_64__) && defined(__GNUC__)
#define GELENK_AVX2
#endif

namespace gelenk::lanes {
namespace {

constexpr int W = lanes_per_block;

double* numbers(double* memory, int slot) { return memory + static_cast<std::ptrdiff_t>(slot) * W; }

void by_library(const Instruction& i, double* memory) {
  const double* const x = numbers(memory, i.a);
  const double* const y = i.b < 0 ? x : numbers(memory, i.b);
  double* const to = numbers(memory, i.to);
  for (int l = 0; l < W; ++l) to[l] = library_function(i.function, x[l], y[l]);
}

// Angles of many turns, which are rare, by the library; so are infinite ones and NaN.
[[gnu::noinline]] void mend_circular(const double* x, double* sine, double* cosine) {
  for (int l = 0; l < W; ++l) {
    if (std::abs(x[l]) <= circular_limit) continue;
    if (sine != nullptr) sine[l] = std::sin(x[l]);
    if (cosine != nullptr) cosine[l] = std::cos(x[l]);
  }
}

// Vectors of the compiler; processors without such large ones compute them in parts.
using Vector [[gnu::vector_size(32), gnu::may_alias]] = double;
using Integers [[gnu::vector_size(32), gnu::may_alias]] = std::int64_t;
constexpr int vector_lanes = 4;
// expression: of a, b, c, d in these lanes, and the constant k. What it does not contain is not looked up.
#define GELENK_EACH_LANE(expression)                                            \
  do {                                                                          \
    Vector* const to = slot(memory, at->to);                                    \
    [[maybe_unused]] const Vector* const pa = slot(memory, at->a);              \
    [[maybe_unused]] const Vector* const pb = slot(memory, at->b);              \
    [[maybe_unused]] const Vector* const pc = slot(memory, at->c);              \
    [[maybe_unused]] const Vector* const pd = slot(memory, at->d);              \
    [[maybe_unused]] const double k = at->k;                                    \
    for (int l = 0; l < W / vector_lanes; ++l) {                                \
      [[maybe_unused]] const Vector a = pa[l], b = pb[l], c = pc[l], d = pd[l]; \
      to[l] = Vector(expression);                                               \
    }                                                                           \
    ++at;                                                                       \
  } while (at != end && at->code == code);                                      \
  break;

[[gnu::always_inline]] inline Vector* slot(double* memory, int number) {
  return reinterpret_cast<Vector*>(memory) +
         static_cast<std::size_t>(static_cast<unsigned>(number)) * (W / vector_lanes);
}
[[gnu::always_inline]] inline void circular(const Instruction& i, double* memory) {
  const Vector* const x = slot(memory, i.a);
  // What is not asked for is not computed.
  Vector* const sine = i.code == Code::cosine ? nullptr : slot(memory, i.to);
  Vector* const cosine = i.code == Code::cosine ? slot(memory, i.to)
                         : i.code == Code::sine ? nullptr
                                                : slot(memory, i.b);
  Integers far{};
  for (int l = 0; l < W / vector_lanes; ++l) {
    Vector s;
    Vector c;
    sine_cosine<Vector, Integers>(x[l], s, c);
    far |= ~((x[l] <= circular_limit) & (x[l] >= -circular_limit));
    if (sine != nullptr) sine[l] = s;
    if (cosine != nullptr) cosine[l] = c;
  }
  std::int64_t any = 0;
  for (int l = 0; l < vector_lanes; ++l) any |= far[l];
  if (any != 0)
    mend_circular(numbers(memory, i.a), sine == nullptr ? nullptr : numbers(memory, i.to),
                  cosine == nullptr ? nullptr : numbers(memory, (i.code == Code::cosine ? i.to : i.b)));
}

// NOLINTNEXTLINE(readability-function-cognitive-complexity): a line for each kind of instruction
[[gnu::always_inline]] inline void run_all(const Instruction* at, const Instruction* end, double* memory) {
  while (at != end) {
    const Code code = at->code;
    switch (code) {
      case Code::copy:
        GELENK_EACH_LANE(a)
      case Code::add:
        GELENK_EACH_LANE(a + b)
      case Code::subtract:
        GELENK_EACH_LANE(a - b)
      case Code::multiply:
        GELENK_EACH_LANE(a * b)
      case Code::divide:
        GELENK_EACH_LANE(a / b)
      case Code::negate:
        GELENK_EACH_LANE(-a)
      case Code::add_constant:
        GELENK_EACH_LANE(a + k)
      case Code::subtract_from_constant:
        GELENK_EACH_LANE(k - a)
      case Code::scale:
        GELENK_EACH_LANE(k * a)
      case Code::divide_constant:
        GELENK_EACH_LANE(k / a)
      case Code::multiply_add:
        GELENK_EACH_LANE(a * b + c)
      case Code::multiply_subtract:
        GELENK_EACH_LANE(a * b - c)
      case Code::subtract_multiply:
        GELENK_EACH_LANE(c - a * b)
      case Code::multiply_add_multiply:
        GELENK_EACH_LANE(a * b + c * d)
      case Code::multiply_subtract_multiply:
        GELENK_EACH_LANE(a * b - c * d)
      case Code::scale_add:
        GELENK_EACH_LANE(k * a + c)
      case Code::scale_subtract:
        GELENK_EACH_LANE(k * a - c)
      case Code::subtract_scale:
        GELENK_EACH_LANE(c - k * a)
      case Code::choose:
        GELENK_EACH_LANE(a > 0 ? b : c)
      case Code::square_root: {
        const double* const x = numbers(memory, at->a);
        double* const y = numbers(memory, at->to);
        for (int l = 0; l < W; ++l) y[l] = std::sqrt(x[l]);
        ++at;
        break;
      }
      case Code::sine:
      case Code::cosine:
      case Code::sine_cosine:
        circular(*at++, memory);
        break;
      case Code::function:
        by_library(*at++, memory);
        break;
    }
  }
}
#undef GELENK_EACH_LANE

void run_baseline(const Instruction* at, const Instruction* end, double* memory) { run_all(at, end, memory); }

#ifdef GELENK_AVX2
[[gnu::target("avx2")]] void run_avx2(const Instruction* at, const Instruction* end, double* memory) {
  run_all(at, end, memory);
}
bool has_avx2() { return __builtin_cpu_supports("avx2") != 0; }
#else
void run_avx2(const Instruction* at, const Instruction* end, double* memory) { run_all(at, end, memory); }
bool has_avx2() { return false; }
#endif

bool uses_avx2 = has_avx2();

}  // namespace

void run(std::span<const Instruction> program, double* memory) {
  const Instruction* const first = program.data();
  (uses_avx2 ? run_avx2 : run_baseline)(first, first + program.size(), memory);
}

std::string_view instruction_set() { return uses_avx2 ? "avx2" : "baseline"; }

void use_all_instructions(bool on) { uses_avx2 = on && has_avx2(); }

}  // namespace gelenk::lanes
