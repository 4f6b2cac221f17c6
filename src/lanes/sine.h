// SPDX-License-Identifier: BSD-3-Clause
// Sine and cosine without branches, so that compilers compute several at once. The polynomials and the reduction to
// [-pi/4, pi/4] are those of fdlibm (Sun Microsystems 1993, k_sin.c, k_cos.c, e_rem_pio2.c: the first iteration, good to
// 85 bits). Errors are below 1 unit in the last place, up to circular_limit.
#pragma once

#include <bit>
#include <cstdint>

namespace gelenk::lanes {

// Beyond it, multiples of pi/2 that are subtracted are rounded.
inline constexpr double circular_limit = 1e6;

struct SineCosine {
  double sine, cosine;
};

[[gnu::always_inline]] inline SineCosine sine_cosine(double x) {
  constexpr double rounding = 6755399441055744.0;  // 1.5 * 2^52: in the sum, integers are the last bits
  constexpr double two_over_pi = 6.36619772367581382433e-01;
  constexpr double half_pi = 1.57079632673412561417e+00;  // its first 33 bits ...
  constexpr double half_pi_rest = 6.07710050650619224932e-11;
  const double shifted = x * two_over_pi + rounding;
  const auto quadrant = std::bit_cast<std::int64_t>(shifted);
  const double turns = shifted - rounding;
  const double r = x - turns * half_pi;
  const double w = turns * half_pi_rest;
  const double y = r - w;
  const double rest = (r - y) - w;
  const double z = y * y;
  const double v = z * y;
  const double s = 8.33333333332248946124e-03 +
                   z * (-1.98412698298579493134e-04 +
                        z * (2.75573137070700676789e-06 +
                             z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
  const double sine = y - ((z * (0.5 * rest - v * s) - rest) - v * -1.66666666666666324348e-01);
  const double c =
      z * (4.16666666666666019037e-02 +
           z * (-1.38888888888741095749e-03 +
                z * (2.48015872894767294178e-05 +
                     z * (-2.75573143513906633035e-07 +
                          z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
  const double half = 0.5 * z;
  const double most = 1 - half;
  const double cosine = most + (((1 - most) - half) + (z * c - y * rest));
  const auto a = std::bit_cast<std::uint64_t>(sine);
  const auto b = std::bit_cast<std::uint64_t>(cosine);
  const auto n = static_cast<std::uint64_t>(quadrant);
  const std::uint64_t swaps = (a ^ b) & (0 - (n & 1));
  const std::uint64_t sine_sign = (n & 2) << 62;
  const std::uint64_t cosine_sign = ((n + 1) & 2) << 62;
  return {std::bit_cast<double>((a ^ swaps) ^ sine_sign), std::bit_cast<double>((b ^ swaps) ^ cosine_sign)};
}

}  // namespace gelenk::lanes
