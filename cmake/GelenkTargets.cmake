# SPDX-License-Identifier: BSD-3-Clause
# The native targets: the core, the FMU runtime, the export tool. Sources are globbed, so new files need no edit here.
set(modules util field math shape joint element scene check scene_file scene_schema mechanism linear cone collision kinematics derivatives dynamics contact touch assembly analysis event modes formulation integrator
  preparation outputs simulation runs inspection)
list(TRANSFORM modules PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/src/)
list(TRANSFORM modules APPEND /*.cpp OUTPUT_VARIABLE patterns)
file(GLOB core_sources CONFIGURE_DEPENDS ${patterns} ${CMAKE_CURRENT_SOURCE_DIR}/modelDescription/*.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/fmu/runtime/*.cpp ${CMAKE_CURRENT_SOURCE_DIR}/fmu/export/*.cpp)
set(yaml_source ${CMAKE_CURRENT_SOURCE_DIR}/src/scene_file/yaml.cpp)
set(stubs_source ${CMAKE_CURRENT_SOURCE_DIR}/src/integrator/sundials_wheel_stubs.cpp)
list(REMOVE_ITEM core_sources ${yaml_source} ${stubs_source})

# Code that reads, reduces and describes scenes runs once and is optimized for size, since every FMU contains it. So is
# the evaluation of power series, for output derivatives.
set(small ${core_sources})
list(FILTER small INCLUDE REGEX
  "/(util|field|shape|element|event|scene|check|scene_file|scene_schema|assembly|preparation|modelDescription|runtime|export|mechanism)/[^/]*$|/derivatives/(residual_evaluator|residual_kernels)\\.cpp$")
set(once
  formulation/branch_acceleration formulation/contact_motion formulation/independent formulation/penalty formulation/registry
  integrator/automatic integrator/contact_scheme integrator/registry integrator/starter
  cone/registry
  derivatives/forward_ad
  analysis/equilibrium analysis/independent_columns analysis/rest_forces analysis/rest_pose analysis/singular_start
  analysis/mobility
  kinematics/loads kinematics/model
  contact/contact_state contact/recorded_problem contact/step_impacts
  dynamics/distributed_forces touch/spot_features
  modes/friction_treatment modes/joint_locks modes/mode_changes
  linear/box_complementarity linear/least_load linear/singular_values
  outputs/outputs_dual outputs/port_readings
  inspection/inspection
  touch/contact_impact touch/decision_checks touch/slow_motions touch/touch_changes touch/touch_decision
  touch/touch_modes touch/touch_outputs
  simulation/assemblies simulation/assembled_start simulation/events simulation/parameters simulation/probe
  simulation/replay simulation/sensitivity simulation/set_up simulation/start_at_equilibrium
  simulation/state_derivatives)
list(TRANSFORM once PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/src/)
list(TRANSFORM once APPEND .cpp)
list(APPEND small ${once})
list(FILTER small EXCLUDE REGEX "/(plant|motion_law)\\.cpp$")  # executed in every step
set_source_files_properties(${small} PROPERTIES COMPILE_OPTIONS "$<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU,Clang>>:-Os>")
gelenk_harden(${small})
set(fast ${core_sources})
list(REMOVE_ITEM fast ${small})
include(GelenkPrecompile)
gelenk_precompile(small -Os ${GELENK_HARDENING})
gelenk_precompiled(small ${small})
gelenk_precompile(fast)
gelenk_precompiled(fast ${fast})

# Loops in the kernels run over the few velocities of a joint or constraint equations of a loop. Vectorized loops take
# longer (a fifth on a four-bar); straight-line code is still vectorized, but not by Clang: it joins loads of components
# that were just written one by one, for which processors wait (a fifth on an arm of seven joints).
set(kernels ${core_sources})
list(FILTER kernels INCLUDE REGEX "/(linear|kinematics|derivatives|dynamics)/([a-z]*_kernels|dynamics|articulated_factor|row_factor|sparse_factor|sparse_row_factor)\\.cpp$")
list(REMOVE_ITEM kernels ${small})
set_property(SOURCE ${kernels} APPEND PROPERTY COMPILE_OPTIONS
  "$<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU>>:-fno-tree-loop-vectorize>;$<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:Clang>>:-fno-vectorize;-fno-slp-vectorize;-mllvm;-disable-vector-combine>")

# Code for every kind of joint and force: unrolled loops are a third or a fifth of it, and not faster.
set_property(SOURCE ${CMAKE_CURRENT_SOURCE_DIR}/src/derivatives/recursive.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/src/analysis/constrained_sensitivity.cpp APPEND PROPERTY COMPILE_OPTIONS
  "$<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU,Clang>>:-O2>")

# If several files instantiate a template, the linker keeps the copy of the first one. Files compiled for speed therefore
# come first, except those that mostly instantiate functions of dual numbers and power series: no step needs these, and
# the copies of the files compiled for size are kept (90 kB less).
set(source ${CMAKE_CURRENT_SOURCE_DIR}/src)
set(dual ${source}/derivatives/residual_evaluator.cpp ${source}/derivatives/residual_kernels.cpp ${source}/analysis/equilibrium.cpp
  ${source}/analysis/rest_pose.cpp ${source}/joint/rod.cpp ${source}/derivatives/recursive.cpp ${source}/analysis/constrained_sensitivity.cpp)
list(REMOVE_DUPLICATES small)
list(REMOVE_ITEM core_sources ${small} ${dual})
list(REMOVE_ITEM small ${dual})
list(APPEND core_sources ${dual} ${small})
add_library(gelenk_core STATIC ${core_sources})
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
include(GelenkFmu)

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
