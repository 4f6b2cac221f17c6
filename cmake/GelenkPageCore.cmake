# SPDX-License-Identifier: BSD-3-Clause
# The core as WebAssembly, for pages: built by cmake/page_core.py with Zig. Zig's own library of exceptions for this
# target is compiled without exceptions, so its sources, which Zig's package contains, are compiled with them here; the
# linker is not given the other one.
enable_language(C)
cmake_path(GET GELENK_ZIG PARENT_PATH zig_lib)
cmake_path(APPEND zig_lib lib)
set(abi ${zig_lib}/libcxxabi)
set(unwind ${zig_lib}/libunwind)
set(abi_sources cxa_exception cxa_personality cxa_exception_storage cxa_handlers cxa_default_handlers cxa_virtual private_typeinfo
  stdlib_exception stdlib_stdexcept stdlib_typeinfo abort_message cxa_aux_runtime fallback_malloc stdlib_new_delete cxa_guard)
list(TRANSFORM abi_sources REPLACE "(.+)" "${abi}/src/\\1.cpp")
# The tag by which WebAssembly recognizes exceptions of C++; compilers expect that someone defines it.
set(tag ${CMAKE_CURRENT_BINARY_DIR}/exception_tag.c)
file(CONFIGURE OUTPUT ${tag} CONTENT
  [[__asm__(".globl __cpp_exception\n.tagtype __cpp_exception i32\n__cpp_exception:\n");]] @ONLY)
add_library(gelenk_exceptions OBJECT ${abi_sources} ${unwind}/src/Unwind-wasm.c ${tag})
set_property(TARGET gelenk_exceptions PROPERTY CXX_STANDARD 23)
target_compile_definitions(gelenk_exceptions PRIVATE _LIBCXXABI_BUILDING_LIBRARY _LIBCPP_BUILDING_LIBRARY
  _LIBCXXABI_HAS_NO_THREADS _LIBUNWIND_HAS_NO_THREADS LIBCXXABI_NON_DEMANGLING_TERMINATE __WASM_EXCEPTIONS__)
target_compile_options(gelenk_exceptions PRIVATE -w -Os "$<$<COMPILE_LANGUAGE:C>:-fdeclspec>")
target_include_directories(gelenk_exceptions PRIVATE ${unwind}/include
  "$<$<COMPILE_LANGUAGE:CXX>:${abi}/include;${abi}/src;${zig_lib}/libcxx/include;${zig_lib}/libcxx/src>")

# Zig's C++ library, without that one. Zig compiles it when something is first linked with it.
set(probe ${CMAKE_CURRENT_BINARY_DIR}/probe.cpp)
file(WRITE ${probe} "#include <string>\nint main(int n, char**) { return static_cast<int>(std::to_string(n).size()); }\n")
separate_arguments(compiler NATIVE_COMMAND "${CMAKE_CXX_COMPILER_ARG1}")
separate_arguments(flags NATIVE_COMMAND "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_RELEASE}")
execute_process(COMMAND ${CMAKE_COMMAND} -E env ZIG_VERBOSE_LINK=1 ${CMAKE_CXX_COMPILER} ${compiler} ${flags} ${probe}
  -o ${CMAKE_CURRENT_BINARY_DIR}/probe.wasm WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR} ERROR_VARIABLE linking RESULT_VARIABLE failed)
string(REGEX MATCH "[^ \n]+/libc\\+\\+\\.a" libcxx "${linking}")
if(failed OR NOT libcxx)
  message(FATAL_ERROR "Zig's C++ library was not found in what it links:\n${linking}")
endif()

cmake_path(ABSOLUTE_PATH libcxx BASE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR} NORMALIZE)

add_executable(gelenk_page ${PROJECT_SOURCE_DIR}/fmu/page/page_core.cpp $<TARGET_OBJECTS:gelenk_hot> $<TARGET_OBJECTS:gelenk_warm>
  $<TARGET_OBJECTS:gelenk_cold> $<TARGET_OBJECTS:gelenk_exceptions>)
target_link_libraries(gelenk_page PRIVATE gelenk_flags gelenk_core ${libcxx})
# The stack is large enough for scenes of 800 bodies in a chain.
target_link_options(gelenk_page PRIVATE -s -mexec-model=reactor -nostdlib++ -Wl,--gc-sections -Wl,-z,stack-size=1048576)
set_target_properties(gelenk_page PROPERTIES OUTPUT_NAME gelenk SUFFIX .wasm RUNTIME_OUTPUT_DIRECTORY
  ${PROJECT_BINARY_DIR}/runtime/${GELENK_FMU_PLATFORM})
