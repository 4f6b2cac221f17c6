# SPDX-License-Identifier: BSD-3-Clause
# The FMUs of scenes/, in fmus/ of the build folder. YAML scenes are skipped without yaml-cpp.
file(GLOB scenes CONFIGURE_DEPENDS
  ${CMAKE_CURRENT_SOURCE_DIR}/scenes/*.json ${CMAKE_CURRENT_SOURCE_DIR}/scenes/*.yaml)
add_custom_target(scene_fmus ALL)
foreach(scene IN LISTS scenes)
  if(NOT TARGET gelenk-export OR NOT TARGET gelenk_fmu)
    break()
  endif()
  cmake_path(GET scene STEM name)
  cmake_path(GET scene EXTENSION LAST_ONLY extension)
  if(extension STREQUAL ".yaml" AND NOT GELENK_YAML)
    message(STATUS "No FMU of ${name}.yaml: yaml-cpp was not found")
    continue()
  endif()
  gelenk_add_fmu(fmu_${name} ${scene} OUTPUT fmus/${name}.fmu EXCLUDE_FROM_ALL)
  add_dependencies(scene_fmus fmu_${name})
endforeach()
