# SPDX-License-Identifier: BSD-3-Clause
# Compiler flags. No -ffast-math and no -march: the same FMU must give the same bits on every x86-64 machine.
get_property(multi_config GLOBAL PROPERTY GENERATOR_IS_MULTI_CONFIG)
if(NOT CMAKE_BUILD_TYPE AND NOT multi_config)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# What every target of ours is compiled with; third-party headers come in as SYSTEM and stay quiet.
add_library(gelenk_flags INTERFACE)
target_compile_options(gelenk_flags INTERFACE
  -Wall -Wextra -Wpedantic
  -ffp-contract=off  # a compiler free to fuse would give other bits than the next one
  -ffunction-sections -fdata-sections
  # Unique symbols would tie two FMUs in one process together. clang-tidy does not know the flag.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<NOT:$<BOOL:${GELENK_TIDY}>>>:-fno-gnu-unique>
  # GCC 12 warns of overlapping copies inside its own std::string where there are none (GCC bug 105651).
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>
  $<$<BOOL:${GELENK_WERROR}>:-Werror>)

# Undefined behaviour goes with the addresses, whose runtime finds it too; races need a runtime of their own.
set(sanitizers_address address,undefined)
set(sanitizers_thread thread)
set(sanitizers_fuzzer fuzzer-no-link,address,undefined)  # libFuzzer and what it finds; tests/fuzz
if(GELENK_SANITIZE)
  if(NOT DEFINED sanitizers_${GELENK_SANITIZE})
    message(FATAL_ERROR "GELENK_SANITIZE: found '${GELENK_SANITIZE}', expected OFF, address, thread or fuzzer")
  endif()
  set(sanitizers -fsanitize=${sanitizers_${GELENK_SANITIZE}})
  target_compile_options(gelenk_flags INTERFACE ${sanitizers} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(gelenk_flags INTERFACE ${sanitizers})
endif()
# Canaries on the stack and checked copies for sources that read what comes from outside; docs/performance.md has the costs.
# Not where sanitizers see more.
set(GELENK_HARDENING -fstack-protector-strong -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2)
function(gelenk_harden)
  if(GELENK_SANITIZE OR WIN32)
    return()
  endif()
  foreach(flag IN LISTS GELENK_HARDENING)
    set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS
      "$<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU,Clang>>:${flag}>")
  endforeach()
endfunction()

if(GELENK_COVERAGE)
  target_compile_options(gelenk_flags INTERFACE --coverage -fprofile-update=atomic)
  target_link_options(gelenk_flags INTERFACE --coverage)
endif()

# clang-tidy beside the compiler, so that only what changed is looked at again; for targets of ours only.
function(gelenk_tidy)
  if(NOT GELENK_TIDY)
    return()
  endif()
  cmake_path(GET Python_EXECUTABLE PARENT_PATH scripts)
  find_program(GELENK_CLANG_TIDY clang-tidy HINTS ${scripts} REQUIRED)
  foreach(target IN LISTS ARGN)
    if(TARGET ${target})
      set_target_properties(${target} PROPERTIES CXX_CLANG_TIDY
        "${GELENK_CLANG_TIDY};--quiet;--extra-arg=-Wno-unknown-warning-option;--extra-arg=-Wno-ignored-optimization-argument")
    endif()
  endforeach()
endfunction()
