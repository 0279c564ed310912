#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# build.sh [FOLDER]: compiles detection, exact queries and the judge to WebAssembly, by the C interface, and packs the ES module
# for Node 18 and newer and for browsers into FOLDER/package (default: build/js). Needs Emscripten 3.1.6 or newer, CMake, Ninja,
# Eigen, m4, and the source of GMP, which it fetches by `apt-get source gmp` unless GMP_SOURCE names an unpacked one. A build
# without threads. check.sh compares its results with those of the native library.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
mkdir -p "${1:-build/js}"
out=$(realpath "${1:-build/js}")

if [ ! -f "$out/gmp/lib/libgmp.a" ]; then
  source=${GMP_SOURCE:-}
  if [ -z "$source" ]; then
    (cd "$out" && apt-get source --download-only gmp >/dev/null)
    source=$out/gmp_source
    mkdir -p "$source"
    tar -xf "$out"/gmp_*.orig.tar.* -C "$source" --strip-components=1
  fi
  # Debian removes the manual; the float format cannot be tested without running a program.
  (cd "$source" && mkdir -p doc && { [ -f doc/Makefile.in ] || echo 'all install:' >doc/Makefile.in; } &&
    CC_FOR_BUILD=gcc gmp_cv_c_double_format="IEEE little endian" emconfigure ./configure --host none --disable-assembly \
      --disable-shared --prefix="$out/gmp" CFLAGS=-O2 && emmake make && make install && cp gmpxx.h "$out/gmp/include") \
    >"$out/gmp.log" 2>&1 || { tail -n 20 "$out/gmp.log" >&2; exit 1; }
fi

# A symbol of the C interface that no scene needs.
exported=$(sed -n 's/^    \(selvedge_[a-z_]*\);/_\1/p' bindings/c/exported.map | grep -vE '_(scene|simulation|state)_|_set_threads' | paste -sd,)
# Eigen sums in the order of two lanes of SSE2, so the bits are those of x86-64.
# A copy of Eigen without assembly for old compilers; Emscripten lacks the header of MMX, which Eigen includes and does not use.
eigen=${EIGEN_INCLUDE:-/usr/include/eigen3}
if [ ! -d "$out/include/Eigen" ]; then
  mkdir -p "$out/include"
  cp -r "$eigen/Eigen" "$out/include/"
  sed -i 's/^#if EIGEN_COMP_GNUC && EIGEN_COMP_GNUC < 63/#if 0/' "$out/include/Eigen/src/Core/arch/SSE/PacketMath.h"
  : >"$out/include/mmintrin.h"
fi
flags="-fexceptions -msimd128 -msse2 -I$out/include"
off=()
for option in APPS SIMULATION RENDER C PYTHON THREADS ASSIMP FCL LIBCCD EMBREE OSMESA PAGMO INSTALL PCH; do off+=(-DSELVEDGE_$option=OFF); done
emcmake cmake -S . -B "$out/library" -G Ninja -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_UNITY=ON "${off[@]}" -DSELVEDGE_JUDGE=ON \
  -DEigen3_DIR="${Eigen3_DIR:-/usr/share/eigen3/cmake}" -DSELVEDGE_GMP="$out/gmp/lib/libgmp.a" \
  -DSELVEDGE_GMP_INCLUDE="$out/gmp/include" -DCMAKE_CXX_FLAGS="$flags -isystem $out/gmp/include" >"$out/library.log"
ninja -C "$out/library" selvedge_detection selvedge_judge >"$out/library.log" || { tail -n 30 "$out/library.log" >&2; exit 1; }

version=$(sed -n 's/^project(selvedge VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
gmp=$(sed -n 's/^#define __GNU_MP_VERSION\(_MINOR\|_PATCHLEVEL\)\? *\([0-9]*\)$/\2/p' "$out/gmp/include/gmp.h" | paste -sd.)
sed -e "s/@PROJECT_VERSION@/$version/; s/@SELVEDGE_LICENCE@/MIT/" \
  -e "s/@SELVEDGE_LIBRARY_LIST@/Eigen (MPL-2.0)\n  GMP $gmp (LGPL-3.0-or-later or GPL-2.0-or-later)/" apps/version.cpp.in >"$out/version.cpp"
rm -rf "$out/package"
mkdir -p "$out/package"
mapfile -t libraries < <(find "$out/library" -name 'libselvedge_*.a')
# shellcheck disable=SC2086
em++ -std=c++20 -O3 -DNDEBUG $flags -ffp-contract=off -I "$out/library/include" bindings/c/library.cpp \
  bindings/c/detection.cpp bindings/c/judge.cpp "$out/version.cpp" -Wl,--start-group "${libraries[@]}" -Wl,--end-group "$out/gmp/lib/libgmp.a" \
  -sMODULARIZE=1 -sEXPORT_ES6=1 -sUSE_ES6_IMPORT_META=1 -sENVIRONMENT=web -sALLOW_MEMORY_GROWTH=1 -sMAXIMUM_MEMORY=4GB \
  -sFILESYSTEM=0 -sTOTAL_STACK=5MB -sEXPORTED_FUNCTIONS="$exported,_malloc,_free" -sEXPORTED_RUNTIME_METHODS=UTF8ToString,stringToUTF8,lengthBytesUTF8 \
  -o "$out/package/selvedge_wasm.mjs"
cp bindings/js/{index.mjs,index.d.ts} LICENSE "$out/package/"
sed "s/@VERSION@/$version/" bindings/js/package.json.in >"$out/package/package.json"
(cd "$out/package" && gzip -9 -k -c selvedge_wasm.wasm | wc -c | xargs printf 'WebAssembly: %d bytes compressed\n')
if command -v npm >/dev/null; then (cd "$out" && npm pack --silent ./package); fi
