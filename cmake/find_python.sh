#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Prints a Python >= 3.12 that can create virtual environments and build extensions, or fails with a message. A name on
# PATH is not sufficient: version managers install scripts there that only print an error.
usable() {
  "$1" -c '
import os, sys, sysconfig, venv, ensurepip
header = os.path.join(sysconfig.get_path("include"), "Python.h")
sys.exit(sys.version_info < (3, 12) or not os.path.exists(header))' >/dev/null 2>&1
}
if [ -n "$PYTHON" ]; then
  usable "$PYTHON" && { echo "$PYTHON"; exit 0; }
  echo "PYTHON=$PYTHON is not a Python >= 3.12 with venv, ensurepip and Python.h." >&2
  exit 1
fi
for candidate in python3 python3.12 python3.13 python3.14 python3.15 \
    "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.1[2-9]*/bin/python /usr/local/bin/python3 /usr/bin/python3; do
  usable "$candidate" && { echo "$candidate"; exit 0; }
done
echo "Gelenk needs Python >= 3.12 with venv and Python.h; none was found on PATH or among pyenv's versions." >&2
echo "Install one (Debian: python3, python3-venv, python3-dev), or select it: make PYTHON=/path/to/python3.12 ..." >&2
exit 1
