// SPDX-License-Identifier: BSD-3-Clause
// Memory that is freed when the library is unloaded. The statically linked C++ library reserves 72,704 bytes for
// exceptions thrown when memory has run out. It does not free them, since as a shared library it is never unloaded, but
// this copy is unloaded with the FMU.
#if defined(__ELF__)

namespace __gnu_cxx {            // NOLINT(bugprone-reserved-identifier): the C++ library's name
[[gnu::weak]] void __freeres();  // NOLINT(bugprone-reserved-identifier): absent in other C++ libraries
}

namespace {

// Priority 101: runs after all other destructors, which may still throw and catch.
[[gnu::destructor(101)]] void free_exception_reserve() {
  if (__gnu_cxx::__freeres != nullptr) __gnu_cxx::__freeres();
}

}  // namespace
#endif
