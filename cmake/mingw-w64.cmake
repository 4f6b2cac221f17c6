# SPDX-License-Identifier: BSD-3-Clause
# Toolchain file: 64-bit Windows from Linux with MinGW-w64 (Debian: g++-mingw-w64-x86-64-posix). `make win64` uses it.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
foreach(suffix IN ITEMS -posix "")  # std::mutex exists in the variant with POSIX threads
  find_program(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++${suffix})
  find_program(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc${suffix})
endforeach()
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
# Programs are those of the host; libraries and headers given by path are used as given.
set(CMAKE_FIND_ROOT_PATH /usr/x86_64-w64-mingw32)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY BOTH)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE BOTH)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE BOTH)
