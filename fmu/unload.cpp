// SPDX-License-Identifier: BSD-3-Clause
// What has to be done when the library is unloaded while the program continues. Other C++ libraries remain loaded.
// - Destructors of static objects are called. In libraries linked by GCC this is done anyway; in those linked by Zig
//   it is not, so that the C library would call them at the end of the program, where the library no longer is.
// - The statically linked C++ library of GCC reserves 72,704 bytes for exceptions thrown when memory has run out. It
//   does not free them.
#if defined(__ELF__)

// NOLINTBEGIN(bugprone-reserved-identifier): names of the C++ ABI
extern "C" {
void __cxa_finalize(void* library);
extern void* __dso_handle [[gnu::visibility("hidden")]];  // identifies this library
}
// NOLINTEND(bugprone-reserved-identifier)

namespace __gnu_cxx {            // NOLINT(bugprone-reserved-identifier): the C++ library's name
[[gnu::weak]] void __freeres();  // NOLINT(bugprone-reserved-identifier): absent in other C++ libraries
}

namespace {

// Priority 101: runs after all other destructors, which may still throw and catch.
[[gnu::destructor(101)]] void unload() {
  __cxa_finalize(static_cast<void*>(&__dso_handle));
  if (__gnu_cxx::__freeres != nullptr) __gnu_cxx::__freeres();
}

}  // namespace
#endif
