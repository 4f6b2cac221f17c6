# SPDX-License-Identifier: BSD-3-Clause
# The FMU runtime: a self-contained library that exports only the functions of FMI and depends only on the C library, so
# that several FMUs in one process do not interfere.
file(GLOB fmu_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/fmu/*.cpp)
set(exports_map ${CMAKE_CURRENT_LIST_DIR}/fmu_exports.map)
set(zig_source ${CMAKE_CURRENT_SOURCE_DIR}/fmu/zig.cpp)
list(REMOVE_ITEM fmu_sources ${zig_source} ${CMAKE_CURRENT_SOURCE_DIR}/fmu/glibc.cpp)  # see GelenkGlibc.cmake
file(GLOB fmi2_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/fmu/fmi2/*.cpp)
file(GLOB fmi3_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/fmu/fmi3/*.cpp)

# The objects of the core are linked in a fixed order, hot folders first (GelenkTargets.cmake). From an archive the linker
# would take them in the order in which they are needed, which would decide which copies of shared templates it keeps.
set(library_type MODULE)
if(APPLE)  # CMake makes a bundle of a MODULE, which cannot be opened like a library
  set(library_type SHARED)
endif()
add_library(gelenk_fmu ${library_type} $<TARGET_OBJECTS:gelenk_hot> $<TARGET_OBJECTS:gelenk_warm> $<TARGET_OBJECTS:gelenk_cold>)
gelenk_together(gelenk_fmu fmu ${fmu_sources})
gelenk_together(gelenk_fmu fmu/fmi2 ${fmi2_sources})
gelenk_together(gelenk_fmu fmu/fmi3 ${fmi3_sources})
set_property(SOURCE ${CMAKE_CURRENT_SOURCE_DIR}/fmu/unload.cpp PROPERTY SKIP_UNITY_BUILD_INCLUSION ON)  # declares what the compiler has
target_compile_options(gelenk_fmu PRIVATE "$<$<CONFIG:Release>:-Os>")
target_compile_definitions(gelenk_fmu PRIVATE $<$<BOOL:${GELENK_SANITIZE}>:GELENK_STEPS_USE_HEAP>)  # fmu/step_memory.cpp
gelenk_harden(gelenk_fmu)
add_library(gelenk::gelenk_fmu ALIAS gelenk_fmu)
target_link_libraries(gelenk_fmu PRIVATE gelenk_flags gelenk_core gelenk_fmi)
target_link_options(gelenk_fmu PRIVATE $<$<CONFIG:Release>:-Wl,-s>)
gelenk_static_cxx(gelenk_fmu)
if(GELENK_ZIG AND NOT APPLE)  # whose own functions are used there
  set_property(SOURCE ${zig_source} APPEND PROPERTY COMPILE_OPTIONS -fno-builtin)
  target_sources(gelenk_fmu PRIVATE ${zig_source})
endif()

if(WIN32)  # the headers of FMI declare the exported functions
  set(GELENK_FMU_PLATFORM win64)
  set(runtime_suffix .dll)
  target_link_options(gelenk_fmu PRIVATE -Wl,--gc-sections)
elseif(APPLE)
  set(GELENK_FMU_PLATFORM darwin64)
  set(runtime_suffix .dylib)
  # Operators that other libraries in the process could replace are hidden, too.
  set_property(SOURCE ${CMAKE_CURRENT_SOURCE_DIR}/fmu/memory.cpp APPEND PROPERTY COMPILE_OPTIONS
    -fvisibility-global-new-delete=force-hidden)
  target_link_options(gelenk_fmu PRIVATE -Wl,-dead_strip)
else()
  set(GELENK_FMU_PLATFORM linux64)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
    set(GELENK_FMU_PLATFORM aarch64-linux)
  endif()
  set(runtime_suffix .so)
  target_link_options(gelenk_fmu PRIVATE
    -Wl,--gc-sections
    -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=free  # fmu/memory.h
    -Wl,--version-script=${exports_map} -Wl,-Bsymbolic
    -Wl,-z,relro,-z,now -Wl,-z,noexecstack
    # Zig's linker does not know the option.
    $<$<AND:$<BOOL:${GELENK_CET}>,$<CONFIG:Release>,$<NOT:$<BOOL:${GELENK_ZIG}>>>:-Wl,-z,shstk>
    $<$<NOT:$<BOOL:${GELENK_SANITIZE}>>:-Wl,-z,defs>)
endif()

gelenk_old_glibc(gelenk_fmu)
set_target_properties(gelenk_fmu PROPERTIES
  GELENK_PLATFORM ${GELENK_FMU_PLATFORM} EXPORT_PROPERTIES GELENK_PLATFORM
  PREFIX "" SUFFIX ${runtime_suffix} LINK_DEPENDS ${exports_map}
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/runtime/${GELENK_FMU_PLATFORM})
# The library is nearly all of an FMU and the same in all of them, so it is compressed once.
add_custom_command(TARGET gelenk_fmu POST_BUILD
  COMMAND ${CMAKE_COMMAND} -DFILE=$<TARGET_FILE:gelenk_fmu> -P ${CMAKE_CURRENT_LIST_DIR}/GelenkGzip.cmake VERBATIM)
