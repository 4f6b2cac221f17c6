# SPDX-License-Identifier: BSD-3-Clause
# The software bill of materials (CycloneDX) of the FMU runtime: what it contains, in which version, under which license.
file(STRINGS ${wheel_json}/nlohmann/detail/abi_macros.hpp json_version REGEX "#define NLOHMANN_JSON_VERSION_(MAJOR|MINOR|PATCH)")
list(TRANSFORM json_version REPLACE "[^0-9]*([0-9]+).*" "\\1")
list(JOIN json_version "." json_version)

# One component: name, version, SPDX expression of its license, and its page.
function(gelenk_component name version license page)
  set(entry [[{"type": "library", "name": "@name@", "version": "@version@", "licenses": [{"expression": "@license@"}],
     "externalReferences": [{"type": "website", "url": "@page@"}]}]])
  string(CONFIGURE "${entry}" entry @ONLY)
  list(APPEND components "${entry}")
  set(components "${components}" PARENT_SCOPE)
endfunction()

set(components)
gelenk_component(SUNDIALS ${SUNDIALS_VERSION} BSD-3-Clause https://computing.llnl.gov/projects/sundials)
gelenk_component(Eigen ${Eigen3_VERSION} MPL-2.0 https://eigen.tuxfamily.org)
gelenk_component(nlohmann-json ${json_version} MIT https://json.nlohmann.me)
gelenk_component("FMI headers" 3.0 BSD-2-Clause https://fmi-standard.org)
if(GELENK_ZIG)
  gelenk_component(libc++ ${CMAKE_CXX_COMPILER_VERSION} "Apache-2.0 WITH LLVM-exception" https://libcxx.llvm.org)
  if(WIN32)
    gelenk_component(MinGW-w64 "as in Zig" ZPL-2.1 https://www.mingw-w64.org)
  endif()
else()
  gelenk_component(libstdc++ ${CMAKE_CXX_COMPILER_VERSION} "GPL-3.0-or-later WITH GCC-exception-3.1" https://gcc.gnu.org)
endif()
# Pages in the documentation of FMUs contain three.js if they are made by the Python package.
execute_process(COMMAND ${Python_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/three_js.py --release
  OUTPUT_VARIABLE three_release OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE no_three)
if(no_three EQUAL 0)
  gelenk_component(three.js r${three_release} MIT https://threejs.org)
endif()
list(JOIN components ",\n    " components)
set(GELENK_SBOM ${PROJECT_BINARY_DIR}/sbom-${GELENK_FMU_PLATFORM}.cdx.json)
file(CONFIGURE OUTPUT ${GELENK_SBOM} @ONLY CONTENT [[{
  "bomFormat": "CycloneDX",
  "specVersion": "1.5",
  "version": 1,
  "metadata": {
    "component": {"type": "library", "name": "gelenk_fmu (@GELENK_FMU_PLATFORM@)", "version": "@PROJECT_VERSION@",
     "licenses": [{"expression": "BSD-3-Clause"}]}
  },
  "components": [
    @components@
  ]
}
]])
