#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Unpacks Python 3.13 for 64-bit ARM from Debian, and what gelenk requires from PyPI, into a folder: arm_python.sh FOLDER.
# tests/platforms/test_wheels.py runs it in QEMU if GELENK_ARM_PYTHON names the folder. Nothing is installed.
set -eu
root=$(realpath -m "$1")
here=$(dirname "$(realpath "$0")")
python=${PYTHON:-python3}
mkdir -p "$root/apt/lists/partial" "$root/apt/cache/archives/partial"
touch "$root/apt/status"
mirror=$(sed -n 's/^URIs: *//p; s/^deb .*\(http[^ ]*\) .*/\1/p' /etc/apt/sources.list.d/* /etc/apt/sources.list 2>/dev/null | head -n 1)
keys=/usr/share/keyrings/debian-archive-keyring.gpg
echo "deb [arch=arm64 signed-by=$keys] $mirror trixie main" > "$root/apt/sources.list"
cat > "$root/apt/apt.conf" << END
APT::Architecture "arm64";
APT::Architectures { "arm64"; };
Dir::State "$root/apt";
Dir::State::lists "$root/apt/lists";
Dir::State::status "$root/apt/status";
Dir::Cache "$root/apt/cache";
Dir::Etc::sourcelist "$root/apt/sources.list";
Dir::Etc::sourceparts "-";
END
export APT_CONFIG="$root/apt/apt.conf"
apt-get -q update
apt-get -q -y install --no-install-recommends --download-only \
  python3.13-minimal libpython3.13-stdlib libstdc++6 libgcc-s1 zlib1g libgfortran5
for package in "$root"/apt/cache/archives/*.deb; do dpkg -x "$package" "$root"; done
[ -e "$root/lib" ] || ln -s usr/lib "$root/lib"
"$python" -c "import sys, tomllib; print(*tomllib.load(open(sys.argv[1], 'rb'))['project']['dependencies'], sep='\n')" \
  "$here/../../pyproject.toml" > "$root/requirements.txt"
"$python" -m pip install --quiet --target "$root/site" --only-binary=:all: --python-version 3.13 --implementation cp \
  --platform manylinux_2_28_aarch64 --platform manylinux_2_27_aarch64 --platform manylinux2014_aarch64 \
  --abi cp313 --abi abi3 --abi none -r "$root/requirements.txt"
