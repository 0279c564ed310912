#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# build.sh [FOLDER]: compiles detection, exact queries, the judge, simulation and dress to WebAssembly, by the C interface, without
# threads. Packs the ES module for Node 18 and newer and for browsers into FOLDER/package (default: build/js). Needs Emscripten 3.1.6 or newer
# with LLVM 16 or newer (Debian 12: clang-16, lld-16, llvm-16, and EM_LLVM_ADD_VERSION=16 EM_CLANG_ADD_VERSION=16), CMake, Ninja,
# Eigen, nlohmann-json, fmt, m4, and the source of GMP, which it fetches by `apt-get source gmp` unless GMP_SOURCE names an
# unpacked one. Writes the page to try it to FOLDER/page. check.sh compares the results with those of the native library; page/check.mjs
# tries the page in Chromium.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
mkdir -p "${1:-build/js}"
out=$(realpath "${1:-build/js}")
# Where Debian has the packages that Emscripten needs, for a Node from elsewhere.
export NODE_PATH=${NODE_PATH:-/usr/share/nodejs}
# ccache sees the script em++ alone, which is the same for every LLVM.
CCACHE_COMPILERCHECK="string:$(em++ -v 2>&1 | tr "\n" " ")"
export CCACHE_COMPILERCHECK

# LLVM 14 and 15 may read a number for a vector only after a later write to its place. With them, the axes of rotations were
# those of the next values read.
cat >"$out/order.cpp" <<'END'
#include <wasm_simd128.h>
#include <cstdlib>
__attribute__((noinline)) v128_t pair(double* at, double second) {
  const double first = *at;
  *at = 0.0;
  return wasm_f64x2_make(first, second);
}
int main() {
  double value = 1.0;
  if (wasm_f64x2_extract_lane(pair(&value, 2.0), 0) != 1.0) std::abort();
}
END
em++ -O2 -msimd128 -sSINGLE_FILE=1 -sENVIRONMENT=node "$out/order.cpp" -o "$out/order.cjs"
node "$out/order.cjs" >/dev/null 2>&1 || { echo "build.sh: this LLVM reads numbers after they are overwritten; use LLVM 16 or newer" >&2; exit 1; }

# shellcheck source=cmake/cross.sh
source cmake/cross.sh
if [ ! -f "$out/gmp/lib/libgmp.a" ]; then
  source=${GMP_SOURCE:-$out/gmp_source}
  [ -n "${GMP_SOURCE:-}" ] || debian_source "$out" gmp
  # Debian removes the manual; the float format cannot be tested without running a program.
  (cd "$source" && mkdir -p doc && { [ -f doc/Makefile.in ] || echo 'all install:' >doc/Makefile.in; } &&
    CC_FOR_BUILD=gcc gmp_cv_c_double_format="IEEE little endian" emconfigure ./configure --host none --disable-assembly \
      --disable-shared --prefix="$out/gmp" CFLAGS=-O2 && emmake make -j "$(nproc)" && make install && cp gmpxx.h "$out/gmp/include") \
    >"$out/gmp.log" 2>&1 || { tail -n 20 "$out/gmp.log" >&2; exit 1; }
fi

# The symbols of the C interface; the number of threads has no meaning here.
exported=$(sed -n 's/^    \(selvedge_[a-z_]*\);/_\1/p' bindings/c/exported.map | grep -v _set_threads | paste -sd,)
header_packages "$out"
# Eigen without assembly for old compilers. Emscripten lacks the header of MMX, which Eigen includes and does not use.
if [ ! -f "$out/include/mmintrin.h" ]; then
  sed -i 's/^#if EIGEN_COMP_GNUC && EIGEN_COMP_GNUC < 63/#if 0/' "$out/include/Eigen/src/Core/arch/SSE/PacketMath.h"
  : >"$out/include/mmintrin.h"
fi
# Eigen sums in the order of two lanes of SSE2, so the bits are those of x86-64. WebAssembly has exceptions of its own.
flags="-fwasm-exceptions -msimd128 -msse2 -DFMT_HEADER_ONLY -I$out/include -include $PWD/bindings/js/missing_std.h"
off=()
for option in APPS RENDER C PYTHON THREADS ASSIMP FCL LIBCCD EMBREE OSMESA PAGMO INSTALL PCH; do off+=(-DSELVEDGE_$option=OFF); done
emcmake cmake -S . -B "$out/library" -G Ninja -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_UNITY=ON "${off[@]}" -DSELVEDGE_JUDGE=ON \
  -DSELVEDGE_SIMULATION=ON -DEigen3_DIR="${Eigen3_DIR:-/usr/share/eigen3/cmake}" -Dnlohmann_json_DIR="$out/packages/nlohmann_json" \
  -Dfmt_DIR="$out/packages/fmt" -DSELVEDGE_GMP="$out/gmp/lib/libgmp.a" -DSELVEDGE_GMP_INCLUDE="$out/gmp/include" \
  -DCMAKE_CXX_FLAGS="$flags -isystem $out/gmp/include" >"$out/library.log"
ninja -j "$(nproc)" -C "$out/library" selvedge_detection selvedge_judge selvedge_dress >"$out/library.log" || { tail -n 30 "$out/library.log" >&2; exit 1; }

version=$(sed -n 's/^project(selvedge VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
gmp=$(sed -n 's/^#define __GNU_MP_VERSION\(_MINOR\|_PATCHLEVEL\)\? *\([0-9]*\)$/\2/p' "$out/gmp/include/gmp.h" | paste -sd.)
sed -e "s/@PROJECT_VERSION@/$version/; s/@SELVEDGE_LICENCE@/MIT/" \
  -e "s/@SELVEDGE_LIBRARY_LIST@/Eigen (MPL-2.0)\n  GMP $gmp (LGPL-3.0-or-later or GPL-2.0-or-later)\n  nlohmann-json (MIT)\n  fmt (MIT)/" apps/version.cpp.in >"$out/version.cpp"
rm -rf "$out/package"
mkdir -p "$out/package"
mapfile -t libraries < <(find "$out/library" -name 'libselvedge_*.a')
# shellcheck disable=SC2086
em++ -std=c++20 -O3 -DNDEBUG $flags -ffp-contract=off -I "$out/library/include" bindings/c/*.cpp \
  "$out/version.cpp" bindings/js/missing_process.cpp -Wl,--start-group "${libraries[@]}" -Wl,--end-group "$out/gmp/lib/libgmp.a" \
  -sMODULARIZE=1 -sEXPORT_NAME=createSelvedge -sENVIRONMENT=web -sALLOW_MEMORY_GROWTH=1 -sMAXIMUM_MEMORY=4GB \
  -sFORCE_FILESYSTEM=1 -sTOTAL_STACK=5MB -sEXPORTED_FUNCTIONS="$exported,_malloc,_free" \
  -sEXPORTED_RUNTIME_METHODS=FS,UTF8ToString,stringToUTF8,lengthBytesUTF8 -o "$out/selvedge_wasm.js"
cp "$out/selvedge_wasm.wasm" "$out/package/"
{ cat "$out/selvedge_wasm.js"; echo 'export default createSelvedge;'; } >"$out/package/selvedge_wasm.mjs"
cp bindings/js/{index.mjs,interface.mjs,index.d.ts} LICENSE "$out/package/"
sed "s/@VERSION@/$version/" bindings/js/package.json.in >"$out/package/package.json"
(cd "$out/package" && gzip -9 -k -c selvedge_wasm.wasm | wc -c | xargs printf 'WebAssembly: %d bytes compressed\n')
node bindings/js/page/pack.mjs "$out" "$out/page"
if command -v npm >/dev/null; then (cd "$out" && npm pack --silent ./package); fi
