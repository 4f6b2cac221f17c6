#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# sh cmake/needs.sh TARGET NAME...: fails if something that `make TARGET` needs is missing, with a line for each that names
# the package of Debian and Ubuntu that contains it.
target=$1
shift
compiler=${CXX:-c++}
status=0

missing() {  # what, package
  echo "make $target: found no $1; install it (Debian, Ubuntu: apt install $2)" >&2
  status=1
}

# Where bindgen, which cargo runs, looks for libclang.
libclang() {
  for folder in "$LIBCLANG_PATH" "$(llvm-config --libdir 2>/dev/null)" /usr/lib /usr/lib64 /usr/local/lib \
      /usr/lib/*-linux-gnu /usr/lib/llvm*/lib /usr/lib64/llvm*/lib /Library/Developer/CommandLineTools/usr/lib; do
    for file in "$folder"/libclang.so* "$folder"/libclang-*.so* "$folder"/libclang.dylib; do
      [ -n "$folder" ] && [ -e "$file" ] && return 0
    done
  done
  return 1
}

for name; do
  case $name in
    c++)
      printf '#include <concepts>\n#include <span>\nstatic_assert(__cplusplus >= 202002L);\n' |
        "$compiler" -std=c++20 -x c++ -fsyntax-only - 2>/dev/null ||
        missing "C++20 compiler ($compiler, which CXX=... selects)" "g++, of version 12 or later" ;;
    clang++) command -v "${CLANGXX:-clang++}" >/dev/null || missing "${CLANGXX:-clang++}, which CLANGXX=... selects" clang ;;
    mvn) command -v mvn >/dev/null || missing "mvn" maven ;;
    java) java -version >/dev/null 2>&1 || missing "java" default-jdk ;;
    cargo) command -v cargo >/dev/null || missing "cargo" cargo ;;
    valgrind) command -v valgrind >/dev/null || missing "valgrind" valgrind ;;
    libclang) libclang || missing "libclang, which bindgen loads (LIBCLANG_PATH names its folder)" libclang-dev ;;
    libasan | libubsan | libtsan)  # a compiler that lacks the library prints its bare name
      case $("$compiler" -print-file-name=$name.so 2>/dev/null) in
        /*) ;;
        *) missing "$name.so of $compiler" "libgcc-$("$compiler" -dumpversion 2>/dev/null || echo VERSION)-dev" ;;
      esac ;;
    *) echo "cmake/needs.sh: $name is unknown" >&2; status=2 ;;
  esac
done
exit $status
