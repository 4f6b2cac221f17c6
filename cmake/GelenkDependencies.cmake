# SPDX-License-Identifier: BSD-3-Clause
# SUNDIALS, Eigen, nlohmann-json, FMI headers, yaml-cpp, zlib: from Python wheels if they are installed, otherwise from
# the system. A <Package>_DIR given by the user has priority.

# The interpreter: -DPython_EXECUTABLE, that of an active virtualenv, or one on PATH.
set(Python_FIND_VIRTUALENV FIRST)
set(Python_FIND_UNVERSIONED_NAMES FIRST)
if(GELENK_PYTHON_HEADERS)  # for another platform: cmake/cross_wheels.py
  find_package(Python 3.12 REQUIRED COMPONENTS Interpreter)
  set(Python_INCLUDE_DIRS ${GELENK_PYTHON_HEADERS})
  foreach(target IN ITEMS Module SABIModule)
    add_library(Python::${target} INTERFACE IMPORTED)
    target_include_directories(Python::${target} INTERFACE ${GELENK_PYTHON_HEADERS})
    target_link_libraries(Python::${target} INTERFACE ${GELENK_PYTHON_LIBRARY})
  endforeach()
elseif(GELENK_PYTHON)
  find_package(Python 3.12 REQUIRED COMPONENTS Interpreter Development.Module ${SKBUILD_SABI_COMPONENT})
else()
  find_package(Python 3.8 QUIET COMPONENTS Interpreter)
endif()

if(Python_Interpreter_FOUND)
  execute_process(COMMAND ${Python_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/find_wheels.py
    OUTPUT_VARIABLE wheels OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  string(REPLACE "\n" ";" wheels "${wheels}")
  foreach(line IN LISTS wheels)
    if(line MATCHES "^([a-z]+)=(.*)$")
      set(wheel_${CMAKE_MATCH_1} "${CMAKE_MATCH_2}")
    endif()
  endforeach()
endif()

# Uses the wheel's folder unless the user gave another. A folder chosen by this function in an earlier run is replaced,
# since the interpreter may have changed and pip builds in temporary environments.
function(gelenk_wheel_dir variable folder)
  if(DEFINED CACHE{${variable}} AND "$CACHE{${variable}}" STREQUAL "$CACHE{gelenk_chose_${variable}}")
    unset(${variable} CACHE)
  endif()
  if(folder AND NOT ${variable})
    set(${variable} "${folder}" CACHE PATH "" FORCE)
    set(gelenk_chose_${variable} "${folder}" CACHE INTERNAL "")
  endif()
endfunction()

gelenk_wheel_dir(Eigen3_DIR "${wheel_eigen}")
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
add_library(gelenk_eigen INTERFACE)
target_link_libraries(gelenk_eigen INTERFACE Eigen3::Eigen)
target_compile_definitions(gelenk_eigen INTERFACE EIGEN_MPL2_ONLY)  # excludes code under the LGPL

gelenk_wheel_dir(SUNDIALS_DIR "${wheel_sundials}")
find_package(SUNDIALS 7.1 REQUIRED COMPONENTS
  idas cvodes arkode nvecserial sunmatrixdense sunlinsoldense sunnonlinsolnewton sunnonlinsolfixedpoint)
# One target for all libraries used; static ones if available, since the FMU must contain them.
add_library(gelenk_sundials INTERFACE)
foreach(part idas cvodes arkode nvecserial sunmatrixdense sunlinsoldense sunnonlinsolnewton sunnonlinsolfixedpoint core
        generic)
  if(TARGET SUNDIALS::${part}_static)
    target_link_libraries(gelenk_sundials INTERFACE SUNDIALS::${part}_static)
  elseif(TARGET SUNDIALS::${part})
    target_link_libraries(gelenk_sundials INTERFACE SUNDIALS::${part})
  endif()
endforeach()
# The archives of the sundials4py wheel call a few functions of its Python module (sundials_wheel_stubs.cpp).
file(GLOB sundials_python_module ${SUNDIALS_DIR}/../../../sundials4py*.so)
set(GELENK_SUNDIALS_WHEEL OFF)
if(sundials_python_module)
  set(GELENK_SUNDIALS_WHEEL ON)
endif()

if(NOT wheel_json)
  find_package(nlohmann_json 3.10 QUIET)
  if(nlohmann_json_FOUND)
    get_target_property(wheel_json nlohmann_json::nlohmann_json INTERFACE_INCLUDE_DIRECTORIES)
  else()
    find_path(GELENK_JSON_INCLUDE nlohmann/json.hpp REQUIRED)
    set(wheel_json ${GELENK_JSON_INCLUDE})
  endif()
endif()
add_library(gelenk_json INTERFACE)
target_include_directories(gelenk_json SYSTEM INTERFACE ${wheel_json})

if(NOT GELENK_FMI_HEADERS AND wheel_fmi)
  set(fmi_headers "${wheel_fmi}")
else()
  set(fmi_headers "${GELENK_FMI_HEADERS}")
endif()
if(NOT EXISTS "${fmi_headers}/fmi2Functions.h" OR NOT EXISTS "${fmi_headers}/fmi3Functions.h")
  message(FATAL_ERROR "No headers of FMI 2.0 and 3.0 in '${fmi_headers}'. Give -DGELENK_FMI_HEADERS=<folder with "
    "fmi2Functions.h and fmi3Functions.h>, or -DPython_EXECUTABLE=<an interpreter that has the package fmpy>.")
endif()
add_library(gelenk_fmi INTERFACE)
target_include_directories(gelenk_fmi SYSTEM INTERFACE ${fmi_headers})

set(GELENK_YAML OFF)
if(GELENK_WITH_YAML)  # AUTO counts as true
  gelenk_wheel_dir(yaml-cpp_DIR "${wheel_yaml}")
  if(GELENK_WITH_YAML STREQUAL "AUTO")
    find_package(yaml-cpp QUIET)
  else()
    find_package(yaml-cpp REQUIRED)
  endif()
  set(GELENK_YAML ${yaml-cpp_FOUND})
  if(TARGET yaml-cpp::yaml-cpp)
    set(GELENK_YAML_TARGET yaml-cpp::yaml-cpp)
  else()
    set(GELENK_YAML_TARGET yaml-cpp)  # before yaml-cpp 0.8
  endif()
endif()

# gelenk-export compresses FMUs with zlib; without it, files are stored uncompressed.
set(GELENK_ZLIB OFF)
gelenk_wheel_dir(ZLIB_DIR "${wheel_zlib}")
find_package(ZLIB QUIET CONFIG COMPONENTS static)
if(TARGET ZLIB::ZLIBSTATIC)
  set(GELENK_ZLIB ZLIB::ZLIBSTATIC -no-pie)  # the wheel's archive is not position-independent
else()
  find_package(ZLIB QUIET MODULE)
  if(ZLIB_FOUND)
    set(GELENK_ZLIB ZLIB::ZLIB)
  endif()
endif()

message(STATUS "Eigen ${Eigen3_VERSION}: ${Eigen3_DIR}")
message(STATUS "SUNDIALS ${SUNDIALS_VERSION}: ${SUNDIALS_DIR}")
message(STATUS "nlohmann-json: ${wheel_json}")
message(STATUS "FMI headers: ${fmi_headers}")
message(STATUS "YAML in gelenk-export: ${GELENK_YAML} ${yaml-cpp_DIR}")
message(STATUS "zlib in gelenk-export: ${GELENK_ZLIB} ${ZLIB_DIR}")
