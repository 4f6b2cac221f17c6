// SPDX-License-Identifier: BSD-3-Clause
// Isolation from the host's floating-point mode: traps, rounding, flushing of subnormal numbers.
#pragma once

#include <cfenv>

#if defined(__SSE2__)
#include <xmmintrin.h>
#elif defined(__aarch64__)
#include <cstdint>
#endif

namespace gelenk {

// Sets round to nearest, no traps, and flushing of subnormal numbers (below 2.2e-308) to zero, since these are a
// hundred times as slow as others and occur when a mechanism comes to rest. Thus the host's mode can neither abort a
// run nor change its results. The destructor restores the host's mode, including flags.
class FloatingPointGuard {
 public:
  FloatingPointGuard(const FloatingPointGuard&) = delete;
  FloatingPointGuard& operator=(const FloatingPointGuard&) = delete;

#if defined(__SSE2__)  // takes some nanoseconds, much less than the C library's functions
  FloatingPointGuard() : host_(_mm_getcsr()) {
    _mm_setcsr(plain);
    asm volatile("fnstcw %0" : "=m"(host_x87_));
    if (host_x87_ != plain_x87) set_x87(plain_x87);
  }
  ~FloatingPointGuard() {
    _mm_setcsr(host_);
    if (host_x87_ != plain_x87) set_x87(host_x87_);
  }

 private:
  // All exceptions masked, no flags, round to nearest, subnormal results and operands flushed to zero (bits 15 and 6).
  // The x87 mode matters because the C library uses it to convert text to numbers.
  static constexpr unsigned plain = 0x1f80 | 0x8000 | 0x0040;
  static constexpr unsigned short plain_x87 = 0x037f;
  static void set_x87(unsigned short mode) { asm volatile("fldcw %0" : : "m"(mode)); }
  unsigned host_;
  unsigned short host_x87_ = 0;
#elif defined(__aarch64__)
  FloatingPointGuard() {
    asm volatile("mrs %0, fpcr" : "=r"(host_));
    asm volatile("mrs %0, fpsr" : "=r"(host_flags_));
    asm volatile("msr fpcr, %0" : : "r"(plain));
  }
  ~FloatingPointGuard() {
    asm volatile("msr fpcr, %0" : : "r"(host_));
    asm volatile("msr fpsr, %0" : : "r"(host_flags_));
  }

 private:
  // No traps, round to nearest, subnormal results and operands flushed to zero (bit 24).
  static constexpr std::uint64_t plain = std::uint64_t{1} << 24U;
  std::uint64_t host_ = 0, host_flags_ = 0;
#else
  FloatingPointGuard() {
    std::feholdexcept(&host_);
    std::fesetround(FE_TONEAREST);
  }
  ~FloatingPointGuard() { std::fesetenv(&host_); }

 private:
  std::fenv_t host_{};
#endif
};

}  // namespace gelenk
