# SPDX-License-Identifier: BSD-3-Clause
# gelenk_add_fmu(NAME SCENE [OUTPUT file.fmu] [EXCLUDE_FROM_ALL])
#
# Adds the target NAME, which exports SCENE (a .json file, or .yaml if gelenk-export was built with yaml-cpp) to
# NAME.fmu in the current binary directory, or to OUTPUT. It is part of `all` unless EXCLUDE_FROM_ALL is given.
# The FMU is rebuilt when the scene or Gelenk changes, without a compiler. The target's property GELENK_FMU is its
# path.
function(gelenk_add_fmu NAME SCENE)
  cmake_parse_arguments(PARSE_ARGV 2 arg "EXCLUDE_FROM_ALL" "OUTPUT" "")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "gelenk_add_fmu(${NAME}): unknown arguments '${arg_UNPARSED_ARGUMENTS}'; "
      "expected OUTPUT <file> or EXCLUDE_FROM_ALL")
  endif()
  cmake_path(ABSOLUTE_PATH SCENE BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} OUTPUT_VARIABLE scene)
  if(NOT arg_OUTPUT)
    set(arg_OUTPUT ${NAME}.fmu)
  endif()
  cmake_path(ABSOLUTE_PATH arg_OUTPUT BASE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR} OUTPUT_VARIABLE fmu)

  get_property(licenses GLOBAL PROPERTY GELENK_LICENSE_DIR)
  cmake_path(GET fmu PARENT_PATH folder)
  file(MAKE_DIRECTORY ${folder})
  add_custom_command(OUTPUT ${fmu}
    COMMAND gelenk::gelenk-export ${scene} ${fmu}
      --runtime $<TARGET_PROPERTY:gelenk::gelenk_fmu,GELENK_PLATFORM>=$<TARGET_FILE:gelenk::gelenk_fmu>.gz --licenses ${licenses}
    DEPENDS ${scene} gelenk::gelenk-export gelenk::gelenk_fmu $<TARGET_FILE:gelenk::gelenk_fmu>
    COMMENT "Packing ${NAME}.fmu" VERBATIM)
  if(arg_EXCLUDE_FROM_ALL)
    add_custom_target(${NAME} DEPENDS ${fmu})
  else()
    add_custom_target(${NAME} ALL DEPENDS ${fmu})
  endif()
  set_target_properties(${NAME} PROPERTIES GELENK_FMU ${fmu})
endfunction()
