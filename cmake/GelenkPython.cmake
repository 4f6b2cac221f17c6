# SPDX-License-Identifier: BSD-3-Clause
# The Python module gelenk._core and the data of the package: the FMU runtime, the schema, the scenes, the licenses.
gelenk_wheel_dir(nanobind_DIR "${wheel_nanobind}")
find_package(nanobind CONFIG REQUIRED)

file(GLOB binding_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/python/bindings/*.cpp)
if(binding_sources)
  nanobind_add_module(_core STABLE_ABI NB_STATIC)  # one module for Python 3.12 and all later ones
  gelenk_together(_core python/bindings ${binding_sources})
  # Equations with names and batches are in no FMU.
  gelenk_folders(_core src/equations src/batch)
  if(GELENK_ZIG AND (WIN32 OR APPLE))  # SUNDIALS is compiled for it: cmake/sundials_memory.h
    target_sources(_core PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/fmu/memory.cpp ${CMAKE_CURRENT_SOURCE_DIR}/fmu/step_memory.cpp)
  endif()
  if(WIN32)
    set_property(TARGET _core PROPERTY SUFFIX .pyd)
  endif()
  if(GELENK_ZIG AND APPLE)  # Zig's linker makes no bundles and reads no list of the interpreter's symbols
    set(CMAKE_SHARED_MODULE_CREATE_CXX_FLAGS -dynamiclib)
    set_property(TARGET _core PROPERTY LINK_OPTIONS -Wl,-undefined,dynamic_lookup)
  endif()
  target_link_libraries(_core PRIVATE gelenk_flags gelenk_core)
  set(nanobind_library nanobind-static)
  if(TARGET nanobind-static-abi3)
    set(nanobind_library nanobind-static-abi3)
  endif()
  # nanobind's headers warn under -Wpedantic.
  target_include_directories(_core SYSTEM PRIVATE $<TARGET_PROPERTY:${nanobind_library},INTERFACE_INCLUDE_DIRECTORIES>)
  gelenk_static_cxx(_core)
  gelenk_old_glibc(_core)
  if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
    target_link_options(_core PRIVATE -Wl,-z,relro,-z,now -Wl,-z,noexecstack)
  endif()
  install(TARGETS _core LIBRARY DESTINATION gelenk COMPONENT python)
  # Its types and docstrings, for type checkers and editors. A module for another platform cannot be imported here: its
  # wheel has the types of this one.
  if(NOT GELENK_PYTHON_HEADERS)
    set(types ${CMAKE_CURRENT_BINARY_DIR}/types)
    file(GENERATE OUTPUT ${types}/gelenk/__init__.py CONTENT "__path__ = [r'$<TARGET_FILE_DIR:_core>']\n")
    nanobind_add_stub(_core_types MODULE gelenk._core PYTHON_PATH ${types} DEPENDS _core RECURSIVE INCLUDE_PRIVATE
      OUTPUT_PATH ${types} OUTPUT ${types}/_core/__init__.pyi ${types}/_core/elements.pyi ${types}/_core/joints.pyi)
    install(DIRECTORY ${types}/_core DESTINATION gelenk COMPONENT python)
  endif()
endif()
if(TARGET gelenk_fmu)
  install(FILES $<TARGET_FILE:gelenk_fmu>.gz DESTINATION gelenk/runtime/${GELENK_FMU_PLATFORM} COMPONENT python)
  install(FILES ${GELENK_RUNTIME_LICENSES} DESTINATION gelenk/runtime/${GELENK_FMU_PLATFORM}/licenses COMPONENT python)
endif()
if(TARGET gelenk_schema)
  install(FILES ${GELENK_SCHEMA} DESTINATION gelenk/schema COMPONENT python)
endif()
file(GLOB scene_files CONFIGURE_DEPENDS
  ${CMAKE_CURRENT_SOURCE_DIR}/scenes/*.json ${CMAKE_CURRENT_SOURCE_DIR}/scenes/*.yaml)
install(FILES ${scene_files} DESTINATION gelenk/scenes COMPONENT python)
# The pages of `gelenk view` contain three.js.
set(three_js ${CMAKE_CURRENT_BINARY_DIR}/three.min.js)
execute_process(
  COMMAND ${Python_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/cmake/three_js.py ${three_js}
  COMMAND_ERROR_IS_FATAL ANY)
install(FILES ${three_js} DESTINATION gelenk/viewer/page COMPONENT python)
# Their core, if `make page-core` has built it.
if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/build/page-core/package)
  install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/build/page-core/package/ DESTINATION gelenk COMPONENT python)
endif()
install(FILES ${GELENK_LICENSES} DESTINATION gelenk/licenses COMPONENT python)
