// SPDX-License-Identifier: BSD-3-Clause
// Sines and cosines of a vector of lanes, without branches. The polynomials and the reduction to [-pi/4, pi/4] are
// those of fdlibm (Sun Microsystems 1993, k_sin.c, k_cos.c, e_rem_pio2.c: the first iteration, good to 85 bits). Errors
// are below 1 unit in the last place, up to circular_limit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace gelenk::lanes {

// Beyond it, multiples of pi/2 that are subtracted are rounded.
inline constexpr double circular_limit = 1e6;

// The constants, as often as a vector has lanes: so they are operands in memory, rather than loaded and spread each
// time.
struct CircularConstants {
  static constexpr std::size_t most_lanes = 4;
  using Constant = std::array<double, most_lanes>;

  static constexpr Constant spread(double value) {
    Constant out{};
    out.fill(value);
    return out;
  }

  alignas(32) Constant rounding = spread(6755399441055744.0);  // 1.5 * 2^52: in the sum, integers are the last bits
  Constant two_over_pi = spread(6.36619772367581382433e-01);
  Constant half_pi = spread(1.57079632673412561417e+00);  // its first 33 bits ...
  Constant half_pi_rest = spread(6.07710050650619224932e-11);
  Constant half = spread(0.5);
  Constant one = spread(1);
  Constant s1 = spread(-1.66666666666666324348e-01);
  Constant s2 = spread(8.33333333332248946124e-03);
  Constant s3 = spread(-1.98412698298579493134e-04);
  Constant s4 = spread(2.75573137070700676789e-06);
  Constant s5 = spread(-2.50507602534068634195e-08);
  Constant s6 = spread(1.58969099521155010221e-10);
  Constant c1 = spread(4.16666666666666019037e-02);
  Constant c2 = spread(-1.38888888888741095749e-03);
  Constant c3 = spread(2.48015872894767294178e-05);
  Constant c4 = spread(-2.75573143513906633035e-07);
  Constant c5 = spread(2.08757232129817482790e-09);
  Constant c6 = spread(-1.13596475577881948265e-11);
};
inline constexpr CircularConstants circular_constants;

// Vector: of the compiler, with double; Integers: as many std::int64_t.
template <class Vector, class Integers>
[[gnu::always_inline]] inline void sine_cosine(const Vector& x, Vector& sine, Vector& cosine) {
  const CircularConstants& all = circular_constants;
  const auto k = [](const CircularConstants::Constant& of)
                     [[gnu::always_inline]] -> const Vector& { return *reinterpret_cast<const Vector*>(of.data()); };
  const Vector shifted = x * k(all.two_over_pi) + k(all.rounding);
  const Vector turns = shifted - k(all.rounding);
  const Vector r = x - turns * k(all.half_pi);
  const Vector w = turns * k(all.half_pi_rest);
  const Vector y = r - w;
  const Vector rest = (r - y) - w;
  const Vector z = y * y;
  const Vector v = z * y;
  const Vector s = k(all.s2) + z * (k(all.s3) + z * (k(all.s4) + z * (k(all.s5) + z * k(all.s6))));
  const Vector of_sine = y - ((z * (k(all.half) * rest - v * s) - rest) - v * k(all.s1));
  const Vector c =
      z * (k(all.c1) + z * (k(all.c2) + z * (k(all.c3) + z * (k(all.c4) + z * (k(all.c5) + z * k(all.c6))))));
  const Vector half = k(all.half) * z;
  const Vector most = k(all.one) - half;
  const Vector of_cosine = most + (((k(all.one) - most) - half) + (z * c - y * rest));
  // The quadrant is in the last bits: odd ones exchange sine and cosine, the signs are those of its second bit.
  const auto quadrant = reinterpret_cast<Integers>(shifted);
  const auto a = reinterpret_cast<Integers>(of_sine);
  const auto b = reinterpret_cast<Integers>(of_cosine);
  const Integers swaps = (a ^ b) & -(quadrant & 1);
  sine = reinterpret_cast<Vector>((a ^ swaps) ^ ((quadrant & 2) << 62));
  cosine = reinterpret_cast<Vector>((b ^ swaps) ^ (((quadrant + 1) & 2) << 62));
}

}  // namespace gelenk::lanes
