#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# build.sh [FOLDER]: builds the program for 64-bit Windows, with detectors, judge, dress and pictures, in FOLDER (build/windows), and
# packs selvedge-VERSION-windows.zip there: the program, which needs no other file, scenes, bodies and the licence. Needs the packages
# of `scripts/install_dependencies.sh windows`, and the network for the sources of GMP and libpng. Without oneTBB every loop is serial;
# without assimp bodies are OBJ, PLY and OFF. With SOURCE_DATE_EPOCH the same program gives the same zip. check.sh tries it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
mkdir -p "${1:-build/windows}"
out=$(realpath "${1:-build/windows}")
host=x86_64-w64-mingw32
# shellcheck source=cmake/cross.sh
source cmake/cross.sh
# logged NAME COMMAND...: in the background, where the first error of a function ends it; after || it would not.
logged() {
  "${@:2}" >"$out/$1.log" 2>&1 &
  wait $! || { tail -n 30 "$out/$1.log" >&2; exit 1; }
}

build_gmp() {
  debian_source "$out" gmp
  # Debian removes the manual.
  cd "$out/gmp_source"
  mkdir -p doc
  [ -f doc/Makefile.in ] || echo 'all install:' >doc/Makefile.in
  CC_FOR_BUILD=gcc ./configure --host $host --disable-shared --prefix="$out/libraries" CC=$host-gcc-posix CFLAGS=-O2
  make -j 2
  make install
  cp gmpxx.h "$out/libraries/include"
}

build_png() {
  debian_source "$out" libpng1.6
  cmake -S "$out/libpng1.6_source" -B "$out/png" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/mingw.cmake" -DCMAKE_BUILD_TYPE=Release \
    -DPNG_SHARED=OFF -DPNG_TESTS=OFF -DCMAKE_INSTALL_PREFIX="$out/libraries"
  ninja -C "$out/png" install
}

[ -f "$out/libraries/lib/libgmp.a" ] || logged gmp build_gmp
[ -f "$out/libraries/lib/libpng.a" ] || logged png build_png
header_packages "$out"
off=()
for option in C PYTHON THREADS ASSIMP FCL LIBCCD EMBREE OSMESA PAGMO INSTALL; do off+=(-DSELVEDGE_$option=OFF); done
CXXFLAGS="-DFMT_HEADER_ONLY -isystem $out/include -isystem $out/libraries/include" logged configure cmake -S . -B "$out/program" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/mingw.cmake" -DCMAKE_BUILD_TYPE=Release \
  -DSELVEDGE_UNITY=ON "${off[@]}" -DEigen3_DIR="${Eigen3_DIR:-/usr/share/eigen3/cmake}" -Dnlohmann_json_DIR="$out/packages/nlohmann_json" \
  -Dfmt_DIR="$out/packages/fmt" -DCLI11_DIR="$out/packages/CLI11" -DSELVEDGE_GMP="$out/libraries/lib/libgmp.a" \
  -DSELVEDGE_GMP_INCLUDE="$out/libraries/include" -DPNG_LIBRARY="$out/libraries/lib/libpng.a" -DPNG_PNG_INCLUDE_DIR="$out/libraries/include"
logged build ninja -j 2 -C "$out/program" selvedge_program

version=$(sed -n 's/^project(selvedge VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
name=selvedge-$version-windows
rm -rf "${out:?}/$name" "$out/$name.zip"
mkdir -p "$out/$name"
$host-strip -o "$out/$name/selvedge.exe" "$out/program/apps/selvedge.exe"
cp -r data/scenes data/bodies LICENSE "$out/$name/"
# One time for all files, in the order of their names; zip writes the local time.
find "$out/$name" -exec touch -h -d "@${SOURCE_DATE_EPOCH:-$(date +%s)}" {} +
(cd "$out" && find "$name" | LC_ALL=C sort | TZ=UTC zip -qX "$name.zip" -@)
ls -l "$out/$name.zip" "$out/$name/selvedge.exe"
