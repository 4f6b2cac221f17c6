# SPDX-License-Identifier: BSD-3-Clause
# Toolchain file: other platforms from Linux with Zig, whose package has compilers, linkers and C libraries for all of
# them. To be included by a file that defines (cmake/runtimes.py writes one for each target)
#   GELENK_ZIG         the program zig
#   GELENK_ZIG_TARGET  a target of Zig, e.g. aarch64-linux-gnu.2.17
#   GELENK_ZIG_TOOLS   folder for scripts that call it
#   GELENK_ZIG_C_FLAGS further flags of the C compiler
string(REGEX REPLACE "-.*" "" CMAKE_SYSTEM_PROCESSOR ${GELENK_ZIG_TARGET})
if(GELENK_ZIG_TARGET MATCHES "windows")
  set(CMAKE_SYSTEM_NAME Windows)
elseif(GELENK_ZIG_TARGET MATCHES "macos")
  set(CMAKE_SYSTEM_NAME Darwin)
  set(CMAKE_INSTALL_NAME_TOOL /bin/false)  # looked for, but not used
elseif(GELENK_ZIG_TARGET MATCHES "wasm")
  set(CMAKE_SYSTEM_NAME Generic)
  set(GELENK_WASM ON)
  set(CMAKE_HAVE_LIBC_PTHREAD ON CACHE INTERNAL "")  # there are no threads, and no library of them
else()
  set(CMAKE_SYSTEM_NAME Linux)
endif()

# CMake expects a program for each tool.
set(tools ${GELENK_ZIG_TOOLS})
foreach(tool IN ITEMS ar ranlib rc)
  file(CONFIGURE OUTPUT ${tools}/${tool} CONTENT "#!/bin/sh\nexec '@GELENK_ZIG@' @tool@ \"$@\"\n" @ONLY)
  file(CHMOD ${tools}/${tool} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
endforeach()
set(CMAKE_C_COMPILER ${GELENK_ZIG} cc -target ${GELENK_ZIG_TARGET})
set(CMAKE_CXX_COMPILER ${GELENK_ZIG} c++ -target ${GELENK_ZIG_TARGET})
set(CMAKE_AR ${tools}/ar)
set(CMAKE_RANLIB ${tools}/ranlib)
set(CMAKE_RC_COMPILER ${tools}/rc)

# What browsers have since 2022; exceptions are in the encoding that all of them know. Size counts: pages are mailed.
set(optimization -O2)
if(GELENK_WASM)
  set(optimization -Os)
  set(wasm " -mcpu=generic+exception_handling+bulk_memory+sign_ext+nontrapping_fptoint+mutable_globals")
  string(APPEND wasm " -fexceptions -fwasm-exceptions -mllvm -wasm-enable-eh")
  string(APPEND CMAKE_C_FLAGS_INIT "${wasm}")
  string(APPEND CMAKE_CXX_FLAGS_INIT "${wasm} -include ${CMAKE_CURRENT_LIST_DIR}/one_thread.h")
endif()

foreach(language IN ITEMS C CXX)
  set(CMAKE_${language}_FLAGS_RELEASE "${optimization} -DNDEBUG" CACHE STRING "")
  # Zig adds checks of undefined behavior to some builds, and debugging symbols to all, which the linker removes again.
  # Paths would differ between machines.
  string(APPEND CMAKE_${language}_FLAGS_INIT
    " -g0 -fno-sanitize=undefined -ffile-prefix-map=${CMAKE_SOURCE_DIR}=.")
  # As with GCC: no calls that only set errno, so that sine and cosine of an angle are one call.
  string(APPEND CMAKE_${language}_FLAGS_INIT " -fno-math-errno")
  # Nor frame pointers, which Zig keeps; on macOS they are required.
  if(NOT CMAKE_SYSTEM_NAME STREQUAL "Darwin")
    string(APPEND CMAKE_${language}_FLAGS_INIT " -fomit-frame-pointer")
  endif()
  # Return addresses are signed and indirect calls must lead to landing pads, on processors that verify this; others skip
  # these instructions. Systems do not enforce landing pads, as Zig's C++ library has none.
  if(CMAKE_SYSTEM_NAME STREQUAL "Linux" AND CMAKE_SYSTEM_PROCESSOR STREQUAL "aarch64")
    string(APPEND CMAKE_${language}_FLAGS_INIT " -mbranch-protection=standard")
  endif()
  # <math.h> of macOS gets INFINITY and NAN from <float.h>, of which libc++ lets it read either these or the rest.
  if(CMAKE_SYSTEM_NAME STREQUAL "Darwin")
    string(APPEND CMAKE_${language}_FLAGS_INIT " -include float.h -include __float_infinity_nan.h")
  endif()
endforeach()
string(APPEND CMAKE_C_FLAGS_INIT " ${GELENK_ZIG_C_FLAGS}")

# Programs are those of the host; libraries and headers given by path are used as given.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY BOTH)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE BOTH)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE BOTH)
