#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# release.sh [BUILD]: makes the packages of the last commit in build/packages, for the Debian that it runs on, with their
# checksums in SHA256SUMS: the .deb files of the program, the library and the Python module, a wheel that carries its
# libraries, the zip for Windows and, where Emscripten is installed, the npm package. BUILD is a folder to compile in (build/release_packages); one of an earlier build compiles what has changed.
# The same commit in the same folder gives the same bytes. Refuses sources that differ from the commit.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=$(realpath -m "${1:-build/release_packages}")
out=$PWD/build/packages
if [ -n "$(git status --porcelain)" ]; then
  echo "release.sh: the sources differ from the last commit; commit or remove the changes" >&2
  exit 1
fi
scripts/install_dependencies.sh release
scripts/install_dependencies.sh windows
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH
umask 022
configure=(cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_UNITY=ON -DSELVEDGE_CGAL=OFF -DSELVEDGE_APPS=ON
  -DSELVEDGE_INSTALL=ON -DSELVEDGE_PYTHON=ON -DSELVEDGE_PYTHON_DIR=lib/python3/dist-packages -DPython_EXECUTABLE=/usr/bin/python3)
if [ ! -f "$build/CMakeCache.txt" ] && command -v ninja >/dev/null; then configure+=(-G Ninja); fi
rm -rf "$out"
mkdir -p "$out"
scripts/quietly.sh "${configure[@]}"
scripts/quietly.sh cmake --build "$build" --parallel "$(nproc)"
scripts/quietly.sh cpack -G DEB --config "$build/CPackConfig.cmake" -B "$out"
rm -rf "$out/_CPack_Packages"
PYTHONPATH=bindings/python/build_backend scripts/quietly.sh /usr/bin/python3 -B -c "
import selvedge_build
selvedge_build.build_wheel('$out', {'build': '$build', 'libraries': 'bundle'})"
scripts/quietly.sh apps/windows/build.sh "$build/windows"
cp "$build"/windows/selvedge-*-windows.zip "$out"
if command -v em++ >/dev/null; then
  scripts/quietly.sh bindings/js/build.sh "$build/js"
  cp "$build"/js/selvedge-*.tgz "$out"
else
  echo "release.sh: Emscripten is not installed, so there is no npm package"
fi
# The list of files comes before the file of sums exists.
sums=$(cd "$out" && sha256sum -- *)
echo "$sums" | tee "$out/SHA256SUMS"
