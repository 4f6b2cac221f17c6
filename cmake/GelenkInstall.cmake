# SPDX-License-Identifier: BSD-3-Clause
# `cmake --install`: the export tool, the FMU runtime and a CMake package, so that find_package(gelenk) provides
# gelenk_add_fmu() to other projects.
if(TARGET gelenk-export AND TARGET gelenk_fmu)
  include(GNUInstallDirs)
  include(CMakePackageConfigHelpers)
  cmake_path(RELATIVE_PATH CMAKE_INSTALL_PREFIX BASE_DIRECTORY ${CMAKE_INSTALL_FULL_BINDIR} OUTPUT_VARIABLE up)
  set(licenses_dir ${CMAKE_INSTALL_LIBDIR}/gelenk/licenses)
  set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/gelenk)
  if(GELENK_YAML AND wheel_yaml AND yaml-cpp_DIR STREQUAL wheel_yaml)
    # Copy the library of a wheel, since its virtualenv may be deleted.
    install(IMPORTED_RUNTIME_ARTIFACTS ${GELENK_YAML_TARGET}
      LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/gelenk COMPONENT native)
    install(FILES licenses/export-tool/yaml-cpp.txt DESTINATION ${CMAKE_INSTALL_LIBDIR}/gelenk COMPONENT native)
    set_target_properties(gelenk-export PROPERTIES
      INSTALL_RPATH $ORIGIN/${up}/${CMAKE_INSTALL_LIBDIR}/gelenk)
  endif()
  if(TARGET ZLIB::ZLIBSTATIC)
    install(FILES licenses/export-tool/zlib.txt DESTINATION ${CMAKE_INSTALL_LIBDIR}/gelenk COMPONENT native)
  endif()
  install(TARGETS gelenk-export gelenk_fmu EXPORT gelenk
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT native
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/gelenk/runtime/${GELENK_FMU_PLATFORM} COMPONENT native)
  install(FILES $<TARGET_FILE:gelenk_fmu>.gz DESTINATION ${CMAKE_INSTALL_LIBDIR}/gelenk/runtime/${GELENK_FMU_PLATFORM}
    COMPONENT native)
  install(FILES ${GELENK_RUNTIME_LICENSES}
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/gelenk/runtime/${GELENK_FMU_PLATFORM}/licenses COMPONENT native)
  install(EXPORT gelenk NAMESPACE gelenk:: FILE gelenkTargets.cmake DESTINATION ${package_dir} COMPONENT native)
  install(FILES ${GELENK_LICENSES} DESTINATION ${licenses_dir} COMPONENT native)
  configure_package_config_file(cmake/gelenkConfig.cmake.in ${PROJECT_BINARY_DIR}/gelenkConfig.cmake
    INSTALL_DESTINATION ${package_dir} PATH_VARS licenses_dir)
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/gelenkConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES cmake/GelenkAddFmu.cmake ${PROJECT_BINARY_DIR}/gelenkConfig.cmake
    ${PROJECT_BINARY_DIR}/gelenkConfigVersion.cmake DESTINATION ${package_dir} COMPONENT native)
endif()
