# SPDX-License-Identifier: BSD-3-Clause
# The native targets: the core, the FMU runtime, the export tool. Sources are globbed, so new files need no edit here;
# new folders do.
#
# Each folder is compiled in one of three ways, which decide nothing but speed and size. Hot folders are what every step
# executes. Warm: what only some scenes or methods execute. Cold: what reads, reduces and describes scenes, or runs once;
# compiled for size, since every FMU contains it. Cold and warm folders read external data, such as scenes and saved states,
# and are hardened. They are linked in this order, since the linker keeps the first copy of a template that several of them
# instantiate.
set(GELENK_HOT src/math src/joint src/linear src/kinematics src/dynamics src/outputs src/integrator src/formulation src/machine_code)
set(GELENK_WARM src/decomposition src/complementarity src/collision src/contact_geometry src/derivatives src/nonsmooth src/time_stepping src/event_driven
  src/expression src/recording src/lanes src/recorded fmu/runtime)
set(GELENK_COLD src/util src/field src/shape src/element src/element/components src/element/constraints src/event src/scene src/check src/scene_file src/scene_schema
  src/mechanism src/assembly src/analysis src/preparation src/simulation src/runs src/inspection modelDescription fmu/export)
if(GELENK_WASM)  # pages make no FMUs; they have no files
  list(REMOVE_ITEM GELENK_COLD src/scene_schema src/inspection fmu/export)
endif()

# gelenk_folders(TARGET folder...): puts the sources of folders into a target, those of each folder together.
function(gelenk_folders target)
  foreach(folder IN LISTS ARGN)
    file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${folder}/*.cpp)
    list(REMOVE_ITEM sources ${yaml_source} ${stubs_source})
    gelenk_together(${target} ${folder} ${sources})
  endforeach()
endfunction()

set(yaml_source ${CMAKE_CURRENT_SOURCE_DIR}/src/scene_file/yaml.cpp)
set(stubs_source ${CMAKE_CURRENT_SOURCE_DIR}/src/integrator/sundials_wheel_stubs.cpp)
foreach(temperature IN ITEMS hot warm cold)
  string(TOUPPER ${temperature} folders)
  add_library(gelenk_${temperature} OBJECT)
  gelenk_folders(gelenk_${temperature} ${GELENK_${folders}})
  target_include_directories(gelenk_${temperature} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/src ${CMAKE_CURRENT_SOURCE_DIR})
  target_compile_definitions(gelenk_${temperature} PRIVATE GELENK_VERSION="${PROJECT_VERSION}")
  target_link_libraries(gelenk_${temperature} PRIVATE gelenk_eigen gelenk_flags gelenk_sundials gelenk_json)
endforeach()
# Loops in the kernels run over the few velocities of a joint or constraint equations of a loop. Vectorized loops take
# longer (a fifth on a four-bar); straight-line code is still vectorized, but not by Clang: it joins loads of components
# that were just written one by one, for which processors wait (a fifth on an arm of seven joints).
# GCC inlines less where a file is large; the kernels of all kinds of joints are, and some were 14 % slower.
target_compile_options(gelenk_hot PRIVATE
  "$<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU>>:-fno-tree-loop-vectorize;--param=inline-unit-growth=300>"
  "$<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:Clang>>:-fno-vectorize;-fno-slp-vectorize;-mllvm;-disable-vector-combine>")
if(GELENK_WASM)
  target_compile_options(gelenk_hot PRIVATE "$<$<CONFIG:Release>:-O2>")
  target_compile_options(gelenk_warm PRIVATE "$<$<CONFIG:Release>:-Os>")
  target_compile_options(gelenk_cold PRIVATE "$<$<CONFIG:Release>:-Oz>")
else()
  target_compile_options(gelenk_warm PRIVATE "$<$<CONFIG:Release>:-O2>")
  target_compile_options(gelenk_cold PRIVATE "$<$<CONFIG:Release>:-Os>")
endif()
gelenk_harden(gelenk_warm)
gelenk_harden(gelenk_cold)

add_library(gelenk_core STATIC $<TARGET_OBJECTS:gelenk_hot> $<TARGET_OBJECTS:gelenk_warm> $<TARGET_OBJECTS:gelenk_cold>)
target_include_directories(gelenk_core PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/src ${CMAKE_CURRENT_SOURCE_DIR})
target_compile_definitions(gelenk_core PUBLIC GELENK_VERSION="${PROJECT_VERSION}")
find_package(Threads REQUIRED)
target_link_libraries(gelenk_core
  PUBLIC gelenk_eigen
  PRIVATE gelenk_flags gelenk_sundials gelenk_json Threads::Threads)

# The stubs must follow the archives that call them, so they are declared as a dependency of SUNDIALS.
if(GELENK_SUNDIALS_WHEEL)
  add_library(gelenk_sundials_stubs STATIC ${stubs_source})
  target_link_libraries(gelenk_sundials_stubs PRIVATE gelenk_flags)
  set_property(TARGET SUNDIALS::core_static APPEND PROPERTY INTERFACE_LINK_LIBRARIES gelenk_sundials_stubs)
endif()

include(GelenkGlibc)
if(GELENK_WASM)  # for pages, which need no FMU
  set(GELENK_FMU_PLATFORM wasm32)
  include(GelenkPageCore)
else()
  include(GelenkFmu)
endif()

set(export_source ${CMAKE_CURRENT_SOURCE_DIR}/fmu/export/tool/export_main.cpp)
if(EXISTS ${export_source})
  add_executable(gelenk-export ${export_source})
  add_executable(gelenk::gelenk-export ALIAS gelenk-export)
  target_link_libraries(gelenk-export PRIVATE gelenk_flags gelenk_core)
  if(GELENK_YAML AND EXISTS ${yaml_source})
    target_sources(gelenk-export PRIVATE ${yaml_source})
    target_compile_definitions(gelenk-export PRIVATE GELENK_WITH_YAML)
    target_link_libraries(gelenk-export PRIVATE gelenk_json ${GELENK_YAML_TARGET})
  endif()
  if(GELENK_ZLIB)
    target_compile_definitions(gelenk-export PRIVATE GELENK_WITH_ZLIB)
    target_link_libraries(gelenk-export PRIVATE ${GELENK_ZLIB})
  endif()
endif()

# The JSON Schema of scene files, generated from the registries at build time.
set(schema_source ${CMAKE_CURRENT_SOURCE_DIR}/fmu/export/tool/schema_main.cpp)
set(GELENK_SCHEMA ${PROJECT_BINARY_DIR}/schema/scene.schema.json)
add_executable(gelenk-schema ${schema_source})
target_link_libraries(gelenk-schema PRIVATE gelenk_flags gelenk_core)
add_custom_command(OUTPUT ${GELENK_SCHEMA} COMMAND gelenk-schema ${GELENK_SCHEMA}
  DEPENDS gelenk-schema COMMENT "Writing scene.schema.json" VERBATIM)
add_custom_target(gelenk_schema ALL DEPENDS ${GELENK_SCHEMA})

# Licenses of the software in an FMU, in the same location relative to the runtime as in the installed package.
file(GLOB GELENK_LICENSES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/licenses/*.txt)
list(APPEND GELENK_LICENSES ${CMAKE_CURRENT_SOURCE_DIR}/LICENSE)
file(COPY ${GELENK_LICENSES} DESTINATION ${PROJECT_BINARY_DIR}/licenses)
set_property(GLOBAL PROPERTY GELENK_LICENSE_DIR ${PROJECT_BINARY_DIR}/licenses)
# What belongs to the runtime alone is beside it.
include(GelenkSbom)
set(GELENK_RUNTIME_LICENSES ${GELENK_SBOM} ${CMAKE_CURRENT_SOURCE_DIR}/licenses/runtimes/libstdc++.txt)
file(COPY ${GELENK_RUNTIME_LICENSES} DESTINATION ${PROJECT_BINARY_DIR}/runtime/${GELENK_FMU_PLATFORM}/licenses)
