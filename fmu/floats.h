// SPDX-License-Identifier: BSD-3-Clause
// The host's floating-point mode, kept out: traps, rounding, flushing of small numbers.
#pragma once

#include <cfenv>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace gelenk {

// While it lives: round to nearest, no traps, and numbers below 2.2e-308 are zero, which would cost a hundred times as
// much as others where a mechanism comes to rest; so a host's mode neither kills a run nor changes its bits. Then as
// before, flags included.
class PlainFloats {
 public:
  PlainFloats(const PlainFloats&) = delete;
  PlainFloats& operator=(const PlainFloats&) = delete;

#if defined(__SSE2__)  // some nanoseconds, which the C library's way is not
  PlainFloats() : host_(_mm_getcsr()) {
    _mm_setcsr(plain);
    asm volatile("fnstcw %0" : "=m"(host_x87_));
    if (host_x87_ != plain_x87) set_x87(plain_x87);
  }
  ~PlainFloats() {
    _mm_setcsr(host_);
    if (host_x87_ != plain_x87) set_x87(host_x87_);
  }

 private:
  // All exceptions masked, no flags, to nearest, small numbers to zero where they come from and where they come in
  // (bits 15 and 6); the x87's matters since the C library reads numbers as it rounds.
  static constexpr unsigned plain = 0x1f80 | 0x8000 | 0x0040;
  static constexpr unsigned short plain_x87 = 0x037f;
  static void set_x87(unsigned short mode) { asm volatile("fldcw %0" : : "m"(mode)); }
  unsigned host_;
  unsigned short host_x87_ = 0;
#else
  PlainFloats() {
    std::feholdexcept(&host_);
    std::fesetround(FE_TONEAREST);
  }
  ~PlainFloats() { std::fesetenv(&host_); }

 private:
  std::fenv_t host_{};
#endif
};

}  // namespace gelenk
