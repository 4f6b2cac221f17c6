# SPDX-License-Identifier: BSD-3-Clause
# Libraries that load on systems older than this one: the runtime of FMUs and the Python module.

# Links the C++ library statically and hides its symbols.
function(gelenk_static_cxx target)
  if(NOT GELENK_ZIG AND NOT APPLE)  # Zig's is static; on macOS, it is part of the system
    target_link_options(${target} PRIVATE -static-libgcc -static-libstdc++ -Wl,--exclude-libs,ALL)
  endif()
endfunction()

include(CheckCXXSymbolExists)
check_cxx_symbol_exists(__GLIBC__ cstddef GELENK_GLIBC)

# Links to the oldest versions of symbols of glibc: fmu/glibc.cpp. The sanitizers intercept the newest ones, and Zig
# links to the versions of its target.
function(gelenk_old_glibc target)
  if(NOT GELENK_GLIBC OR NOT CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" OR GELENK_SANITIZE OR GELENK_ZIG)
    return()
  endif()
  target_sources(${target} PRIVATE ${PROJECT_SOURCE_DIR}/fmu/glibc.cpp)
  foreach(function IN ITEMS exp exp2 log log2 pow hypot fmod stat fstat64 pthread_once __pthread_key_create)
    target_link_options(${target} PRIVATE -Wl,--wrap=${function})
  endforeach()
  # Contains the last two functions before glibc 2.34; empty since.
  target_link_libraries(${target} PRIVATE -Wl,--push-state,--no-as-needed,-l:libpthread.so.0,--pop-state)
endfunction()
