// SPDX-License-Identifier: BSD-3-Clause
// What happens where an exception cannot be handled: the process ends. The handler of the GNU C++ library would print
// the type of the exception first, for which each FMU would contain 30 kB that translate names of types.
#include <cstdlib>
#include <exception>

#if defined(__GLIBCXX__)
// The names are those of the library, which uses this definition instead of its own.
// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl58-cpp,cert-dcl37-c,cert-dcl51-cpp)
namespace __cxxabiv1 {
extern std::terminate_handler __terminate_handler;
std::terminate_handler __terminate_handler = std::abort;
}  // namespace __cxxabiv1
// NOLINTEND(bugprone-reserved-identifier,cert-dcl58-cpp,cert-dcl37-c,cert-dcl51-cpp)
#endif
