# SPDX-License-Identifier: BSD-3-Clause
# The FMU runtime: a self-contained library that exports only the functions of FMI and depends only on the C library, so
# that several FMUs in one process do not interfere.
file(GLOB fmu_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/fmu/*.cpp)
set(exports_map ${CMAKE_CURRENT_LIST_DIR}/fmu_exports.map)
set(glibc_source ${CMAKE_CURRENT_SOURCE_DIR}/fmu/glibc.cpp)
if(GELENK_SANITIZE)  # its runtimes intercept the newest symbols
  list(REMOVE_ITEM fmu_sources ${glibc_source})
endif()

gelenk_harden(${fmu_sources})
set(fmu_once ${fmu_sources})
list(FILTER fmu_once INCLUDE REGEX "/(derivatives|instance|lifecycle|log|model_exchange|states|uri)\\.cpp$")  # called once or rarely
set_property(SOURCE ${fmu_once} APPEND PROPERTY COMPILE_OPTIONS
  "$<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU,Clang>>:-Os>")
# The objects of the core are linked in a fixed order (GelenkTargets.cmake). From an archive the linker would take them in
# the order in which they are needed, which would decide which copies of shared templates it keeps.
add_library(gelenk_fmu MODULE ${fmu_sources} $<TARGET_OBJECTS:gelenk_core>)
add_library(gelenk::gelenk_fmu ALIAS gelenk_fmu)
target_link_libraries(gelenk_fmu PRIVATE gelenk_flags gelenk_core gelenk_fmi)
target_link_options(gelenk_fmu PRIVATE
  -static-libgcc -static-libstdc++ -Wl,--gc-sections
  -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=free  # fmu/memory.h
  $<$<CONFIG:Release>:-Wl,--strip-all>)

if(WIN32)  # the headers of FMI declare the exported functions
  # Otherwise the 16 MB of the memory reserve would be stored in the file.
  set_source_files_properties(${CMAKE_CURRENT_SOURCE_DIR}/fmu/memory.cpp PROPERTIES COMPILE_OPTIONS -fno-data-sections)
  set(runtime_platform win64)
  set(runtime_suffix .dll)
  target_link_options(gelenk_fmu PRIVATE -static)
else()
  set(runtime_platform linux64)
  set(runtime_suffix .so)
  target_link_options(gelenk_fmu PRIVATE
    -Wl,--version-script=${exports_map} -Wl,--exclude-libs,ALL -Wl,-Bsymbolic
    -Wl,-z,relro,-z,now -Wl,-z,noexecstack
    $<$<NOT:$<BOOL:${GELENK_SANITIZE}>>:-Wl,-z,defs>)
endif()

include(CheckCXXSymbolExists)
check_cxx_symbol_exists(__GLIBC__ cstddef GELENK_GLIBC)
if(GELENK_GLIBC AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" AND NOT GELENK_SANITIZE)
  foreach(function IN ITEMS exp exp2 log log2 pow hypot fmod stat fstat64 pthread_once __pthread_key_create)
    target_link_options(gelenk_fmu PRIVATE -Wl,--wrap=${function})
  endforeach()
  # Contains the last two functions before glibc 2.34; empty since.
  target_link_libraries(gelenk_fmu PRIVATE -Wl,--push-state,--no-as-needed,-l:libpthread.so.0,--pop-state)
endif()
set_target_properties(gelenk_fmu PROPERTIES
  PREFIX "" SUFFIX ${runtime_suffix} LINK_DEPENDS ${exports_map}
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/runtime/${runtime_platform})
# The library is nearly all of an FMU and the same in all of them, so it is compressed once.
add_custom_command(TARGET gelenk_fmu POST_BUILD
  COMMAND ${CMAKE_COMMAND} -DFILE=$<TARGET_FILE:gelenk_fmu> -P ${CMAKE_CURRENT_LIST_DIR}/GelenkGzip.cmake VERBATIM)
