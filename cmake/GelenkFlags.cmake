# SPDX-License-Identifier: BSD-3-Clause
# Compiler flags. No -ffast-math and no -march: an FMU must give identical bits on every x86-64 machine.
get_property(multi_config GLOBAL PROPERTY GENERATOR_IS_MULTI_CONFIG)
if(NOT CMAKE_BUILD_TYPE AND NOT multi_config)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
if(NOT GELENK_WASM)
  set(CMAKE_POSITION_INDEPENDENT_CODE ON)
endif()
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# Flags of all targets of Gelenk; third-party headers are SYSTEM, without warnings.
add_library(gelenk_flags INTERFACE)
target_compile_options(gelenk_flags INTERFACE
  -Wall -Wextra -Wpedantic
  -ffp-contract=off  # fused multiply-add would make results depend on the compiler
  -ffunction-sections -fdata-sections
  $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique>  # unique symbols would be shared by several FMUs in one process
  # GCC 12 falsely warns of overlapping copies inside std::string (GCC bug 105651).
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>
  $<$<BOOL:${GELENK_WERROR}>:-Werror>)

# Processors with control-flow enforcement detect calls and returns that lead elsewhere (CET: landing pads, shadow stack);
# others skip these instructions. For ARM, cmake/zig.cmake gives the flag to all code. The linker marks a library as
# fit for the shadow stack if all its parts are, but the C library's few startup instructions are not marked on every
# system; they do not change return addresses.
set(GELENK_CET OFF)
if(CMAKE_SYSTEM_NAME STREQUAL "Linux" AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" AND NOT GELENK_SANITIZE)
  set(GELENK_CET ON)
  target_compile_options(gelenk_flags INTERFACE $<$<CONFIG:Release>:-fcf-protection=full>)
endif()

# The address sanitizer is combined with that for undefined behavior; the thread sanitizer needs its own runtime.
set(sanitizers_address address,undefined)
set(sanitizers_thread thread)
set(sanitizers_fuzzer fuzzer-no-link,address,undefined)  # libFuzzer with sanitizers; see tests/fuzz
if(GELENK_SANITIZE)
  if(NOT DEFINED sanitizers_${GELENK_SANITIZE})
    message(FATAL_ERROR "GELENK_SANITIZE: found '${GELENK_SANITIZE}', expected OFF, address, thread or fuzzer")
  endif()
  set(sanitizers -fsanitize=${sanitizers_${GELENK_SANITIZE}})
  target_compile_options(gelenk_flags INTERFACE ${sanitizers} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(gelenk_flags INTERFACE ${sanitizers})
endif()
# Stack protector and checked copies for sources that read external data; docs/performance.md states the cost. Not in
# combination with sanitizers, which detect more, or for pages, whose WebAssembly is confined by the browser. The C library
# of Windows has no checked copies.
set(GELENK_HARDENING -fstack-protector-strong)
if(NOT WIN32)
  list(APPEND GELENK_HARDENING -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2)
endif()
function(gelenk_harden target)
  if(NOT GELENK_SANITIZE AND NOT GELENK_WASM)
    target_compile_options(${target} PRIVATE
      "$<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU,Clang>>:${GELENK_HARDENING}>")
  endif()
endfunction()

# Most of the time of compiling a file goes into reading headers and instantiating their templates. So all files of a
# folder are compiled together, which takes a quarter of the time; OFF compiles each on its own, for clang-tidy and to
# show whether each includes what it uses.
option(GELENK_TOGETHER "Compile all files of a folder together" ON)

# gelenk_together(TARGET FOLDER source...): adds the sources of a folder to a target, to be compiled together, those of a
# folder in a folder of src with it. Apart are
# files *_by_kind.cpp, which alone read the definitions of all kinds of forces: a new kind recompiles no others; and
# *_dual.cpp and *_dual_by_kind.cpp, instances for derivatives, which no step executes and which are compiled for size.
# So are *_vector.cpp, loops over lanes, which are vectorized; no result depends on these flags.
function(gelenk_together target folder)
  string(REGEX REPLACE "^(src/[^/]+)/.*" "\\1" group ${folder})
  string(MAKE_C_IDENTIFIER ${group} group)
  set(apart ${ARGN})
  list(FILTER apart INCLUDE REGEX "_(by_kind|dual|vector)\\.cpp$")
  set(duals ${apart})
  list(FILTER duals INCLUDE REGEX "_dual(_by_kind)?\\.cpp$")
  set_property(SOURCE ${duals} APPEND PROPERTY COMPILE_OPTIONS "$<$<CONFIG:Release>:-Os>")
  set(vectors ${apart})
  list(FILTER vectors INCLUDE REGEX "_vector\\.cpp$")
  set_property(SOURCE ${vectors} APPEND PROPERTY COMPILE_OPTIONS
    "$<$<CONFIG:Release>:-O3;-fno-math-errno;-fno-trapping-math;-Wno-psabi>")
  set_property(SOURCE ${ARGN} PROPERTY UNITY_GROUP ${group})
  set_property(SOURCE ${apart} PROPERTY SKIP_UNITY_BUILD_INCLUSION ON)
  target_sources(${target} PRIVATE ${ARGN})
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${GELENK_TOGETHER} UNITY_BUILD_MODE GROUP)
endfunction()

if(GELENK_COVERAGE)
  target_compile_options(gelenk_flags INTERFACE --coverage -fprofile-update=atomic)
  target_link_options(gelenk_flags INTERFACE --coverage)
endif()
