// SPDX-License-Identifier: BSD-3-Clause
// What the library gives back when it is unloaded. The C++ library inside reserves 72,704 bytes for exceptions when
// memory has run out; as a shared library it stays loaded, so nobody gives them back, but this one comes and goes with
// the FMU.
#if defined(__ELF__)

namespace __gnu_cxx {            // NOLINT(bugprone-reserved-identifier): the C++ library's name
[[gnu::weak]] void __freeres();  // NOLINT(bugprone-reserved-identifier): other C++ libraries have none
}

namespace {

// 101 is the last destructor to run: those before may throw and catch.
[[gnu::destructor(101)]] void give_back_exception_reserve() {
  if (__gnu_cxx::__freeres != nullptr) __gnu_cxx::__freeres();
}

}  // namespace
#endif
