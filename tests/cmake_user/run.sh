#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# run.sh BUILD CMAKE NINJA PYTHON: installs what was built in BUILD in a folder there, and builds this folder's project
# against it. Run by the target cmake_user.
set -euo pipefail
build=$1 cmake=$2 ninja=$3 python=$4
work=$build/cmake_user
rm -rf "$work"
"$cmake" --install "$build" --prefix "$work/prefix" --component native >/dev/null
"$cmake" -S "$(dirname "${BASH_SOURCE[0]}")" -B "$work/build" -G Ninja "-DCMAKE_MAKE_PROGRAM=$ninja" \
  "-DCMAKE_PREFIX_PATH=$work/prefix" >/dev/null
"$cmake" --build "$work/build"
"$python" -m zipfile --test "$work/build/Pendulum.fmu"
files=$("$python" -m zipfile --list "$work/build/Pendulum.fmu")
for file in modelDescription.xml model.png binaries/linux64/Pendulum.so resources/scene.json documentation/licenses/Eigen.txt; do
  grep -q "^$file " <<<"$files" || { echo "Pendulum.fmu lacks $file; it holds:"; echo "$files"; exit 1; }
done
echo "find_package(gelenk), gelenk_add_fmu(Pendulum): Pendulum.fmu is complete"
