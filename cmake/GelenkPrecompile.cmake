# SPDX-License-Identifier: BSD-3-Clause
# Precompiled headers for Zig, which builds the runtimes of all platforms (cmake/runtimes.py) and would spend most of the
# time on reading headers. Other builds have none, so that each file is known to include what it uses.
set(GELENK_PRECOMPILED [[<algorithm>]] [[<array>]] [[<cmath>]] [[<functional>]] [[<limits>]] [[<map>]] [[<memory>]]
  [[<numbers>]] [[<numeric>]] [[<optional>]] [[<set>]] [[<span>]] [[<stdexcept>]] [[<string>]] [[<string_view>]]
  [[<unordered_map>]] [[<utility>]] [[<variant>]] [[<vector>]]
  [[<Eigen/Cholesky>]] [[<Eigen/Core>]] [[<Eigen/Geometry>]] [[<Eigen/LU>]] [[<Eigen/QR>]] [[<Eigen/SparseCore>]]
  [[<nlohmann/json.hpp>]] [["dynamics/dynamics.h"]])

# gelenk_precompile(NAME option...): headers for files that are compiled with these options if optimized.
function(gelenk_precompile name)
  if(NOT GELENK_ZIG)
    return()
  endif()
  set(target gelenk_headers_${name})
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "// A target needs a file.\n")
  add_library(${target} OBJECT ${source})
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/src ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(${target} PRIVATE gelenk_flags gelenk_eigen gelenk_json)
  target_compile_options(${target} PRIVATE "$<$<CONFIG:Release>:${ARGN}>")
  target_precompile_headers(${target} PRIVATE ${GELENK_PRECOMPILED})
endfunction()

# gelenk_precompiled(NAME file...): uses these headers in files.
function(gelenk_precompiled name)
  if(NOT GELENK_ZIG)
    return()
  endif()
  set(headers ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/gelenk_headers_${name}.dir/cmake_pch.hxx.pch)
  list(REMOVE_DUPLICATES ARGN)
  set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS -include-pch ${headers})
  set_property(SOURCE ${ARGN} APPEND PROPERTY OBJECT_DEPENDS ${headers})
endfunction()
