// SPDX-License-Identifier: BSD-3-Clause
// Included by cmake/zig.cmake into every C++ file that is compiled as WebAssembly, where there is one thread: Zig's C++
// library has no mutexes then, and the system no clock of a thread.
#pragma once

#include <ctime>
#define CLOCK_THREAD_CPUTIME_ID CLOCK_MONOTONIC

#include <version>
#ifndef _LIBCPP_MUTEX
namespace std {
struct mutex {
  void lock() {}
  void unlock() {}
};
template <class Mutex>
struct scoped_lock {
  explicit scoped_lock(Mutex&) {}
  ~scoped_lock() {}  // not trivial: without it, compilers warn of an unused variable
};
}  // namespace std
#endif
