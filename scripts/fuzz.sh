#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# fuzz.sh TARGET [SECONDS [OPTION OF libFuzzer...]]: builds the fuzz target with clang's libFuzzer and the address and
# undefined-behaviour sanitizers (in build/fuzz), runs it for SECONDS (default 60), and prints how many executions it
# made. An input that fails stays in out/fuzz/TARGET, and the script ends with its code. New inputs are kept there too;
# `fuzz.sh TARGET 0 -set_cover_merge=1 -use_counters=0 tests/fuzz/corpus/TARGET out/fuzz/TARGET` takes few of them, which
# reach all code that they reach, into the repository: tests/fuzz_test.cpp runs these and their mutants in every build.
# SANITIZERS=off makes many more executions in the same time: optimized, with the library's assertions only, guided by
# branches but not by comparisons (in build/fuzz_fast). `fuzz.sh TARGET 0 -runs=0 out/fuzz/TARGET` then runs all inputs
# found under the sanitizers.
# Targets, readers: mesh (OBJ, PLY, OFF, flat patterns), query (query files), scene (scene files), fabric (fabric files),
# garment (sewing patterns and their meshes), result (results and checkpoints), sequence (folders of mesh sequences),
# folder (result folders). Targets, engines: ccd (ccd_exact against the judge), detectors (every broad phase against brute
# force and the judge), simulation (small scenes against the judge).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
target=${1:?usage: scripts/fuzz.sh TARGET [SECONDS [OPTIONS]]}
seconds=${2:-60}
shift $(($# < 2 ? $# : 2))
case $target in
  mesh) libraries=(mesh_files bodies system base) ;;
  query) libraries=(query_files narrowphase bodies system base) ;;
  ccd) libraries=(narrowphase bodies judge base) ;;
  scene | fabric | sequence) libraries=(scene garment response query_files narrowphase broadphase mesh_files bodies solver patterns cloth system base) ;;
  garment) libraries=(garment system base) ;;
  result) libraries=(run simulation scene garment response query_files narrowphase detection broadphase mesh_files bodies solver patterns cloth system base) ;;
  folder) libraries=(check_result judge run simulation scene garment response query_files narrowphase detection broadphase mesh_files bodies solver patterns cloth system base) ;;
  detectors) libraries=(broadphase judge base) ;;
  simulation) libraries=(simulation scene garment judge response query_files narrowphase detection broadphase mesh_files bodies solver patterns cloth system base) ;;
  *) echo "fuzz.sh: there is no target $target" >&2; exit 2 ;;
esac
scripts/install_dependencies.sh clang
if [ "${SANITIZERS:-on}" = off ]; then
  build=build/fuzz_fast
  flags=(-O2 -g1 -D_GLIBCXX_ASSERTIONS -fno-sanitize-coverage=trace-cmp)
else
  build=build/fuzz
  flags=(-O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=undefined)
fi
scripts/quietly.sh cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=RelWithDebInfo -DSELVEDGE_UNITY=ON -DCMAKE_C_COMPILER=clang \
  -DCMAKE_CXX_COMPILER=clang++ "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-fsanitize=fuzzer-no-link ${flags[*]}" \
  -DSELVEDGE_APPS=ON -DSELVEDGE_TESTS=OFF -DSELVEDGE_ASSIMP=OFF \
  -DSELVEDGE_JUDGE=ON -DSELVEDGE_SIMULATION=ON -DSELVEDGE_FCL=OFF -DSELVEDGE_LIBCCD=OFF -DSELVEDGE_EMBREE=OFF \
  -DSELVEDGE_OSMESA=OFF -DSELVEDGE_PCH=OFF -DSELVEDGE_INSTALL=OFF
scripts/quietly.sh cmake --build "$build" --parallel "$(nproc)" --target "${libraries[@]/#/selvedge_}"
archives=()
for library in "${libraries[@]}"; do archives+=("$(find "$build" -name "libselvedge_$library.a")"); done
eigen=$(pkg-config --cflags eigen3 2>/dev/null || echo -I/usr/include/eigen3)
# shellcheck disable=SC2086
clang++ -std=c++20 "${flags[@]}" -fsanitize=fuzzer -Wall -Wextra -I"$build/include" $eigen \
  "tests/fuzz/$target.cpp" -Wl,--start-group "${archives[@]}" -Wl,--end-group -ltbb -lgmp -lfmt \
  -o "$build/fuzz_$target"
found=out/fuzz/$target
mkdir -p "$found" "tests/fuzz/corpus/$target"
[ "$seconds" -gt 0 ] || exec "$build/fuzz_$target" "$@"
options=("-max_total_time=$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 "-artifact_prefix=$found/")
[ "$build" = build/fuzz ] || options+=(-entropic=0)  # weighing the inputs took a quarter of the time
[ -f "tests/fuzz/$target.dict" ] && options+=("-dict=tests/fuzz/$target.dict")
# Files of the repository are inputs to start from, too.
case $target in
  garment) more=(data/patterns) ;;
  fabric) more=(data/fabrics) ;;
  *) more=() ;;
esac
"$build/fuzz_$target" "${options[@]}" "$@" "$found" "tests/fuzz/corpus/$target" "${more[@]}"
