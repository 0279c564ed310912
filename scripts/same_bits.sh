#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# same_bits.sh [VARIANT...]: builds the program with each compiler and optimisation (in build/bits_VARIANT), runs short
# scenes with one and with three threads, and prints a table of their state hashes: a row for each variant and a column
# for each scene. The last row runs the first variant with a C library whose sin, exp, ... are off by one unit in the
# last place. Ends with 1 if the hashes of the compilers differ. Variants: gcc_O2 gcc_O3 clang_O2 clang_O3 (default:
# all). SELVEDGE_BITS_PROGRAMS names a folder with programs VARIANT instead of building them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
variants=("$@")
[ ${#variants[@]} -gt 0 ] || variants=(gcc_O2 gcc_O3 clang_O2 clang_O3)

declare -A options=(
  [cloth_on_sphere]="--set time.frames=6 --set geometry.0.cells=[20,20]"
  [flag]="--set time.frames=6"
  [hysteresis]="--set time.frames=6"
  [incline]="--set time.frames=6"
  [plate_2]="--set time.frames=6"
  [finite_elements]="--set time.frames=4"
)
scenes=(cloth_on_sphere flag hysteresis incline plate_2 finite_elements)
[ -n "${SELVEDGE_BITS_PROGRAMS:-}" ] || scripts/install_dependencies.sh clang
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

program_of() {
  local variant=$1
  if [ -n "${SELVEDGE_BITS_PROGRAMS:-}" ]; then
    echo "$SELVEDGE_BITS_PROGRAMS/$variant"
    return
  fi
  local build=build/bits_$variant compiler=g++ c=gcc
  case $variant in
    clang_*) compiler=clang++ c=clang ;;
    gcc_*) ;;
    *) echo "same_bits.sh: there is no variant $variant" >&2; return 1 ;;
  esac
  command -v "$compiler" >/dev/null || { echo "same_bits.sh: $compiler is not installed" >&2; return 1; }
  scripts/quietly.sh cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=-${variant#*_} -DNDEBUG" \
    -DCMAKE_C_COMPILER=$c -DCMAKE_CXX_COMPILER=$compiler -DSELVEDGE_TESTS=OFF -DSELVEDGE_BENCH=OFF \
    -DSELVEDGE_EXAMPLES=OFF >&2
  scripts/quietly.sh cmake --build "$build" --parallel --target selvedge_program >&2
  echo "$build/apps/selvedge"
}

# The state hash of a run, or the reason why there is none.
hash_of() {
  local program=$1 scene=$2 threads=$3 out=$work/out
  rm -rf "$out"
  # shellcheck disable=SC2086
  "$program" run "data/scenes/$scene.json" --out "$out" --no-picture --threads "$threads" ${options[$scene]} \
    >"$work/log" 2>&1 || true
  { grep -o '"state_hash" *: *"[0-9a-f]*"' "$out/result.json" 2>/dev/null || echo '"failed"'; } | tr -d '" ' | sed 's/.*://'
}

row() {
  local name=$1 program=$2 threads=$3 line
  line=$(printf '%-30s' "$name, threads $threads")
  for scene in "${scenes[@]}"; do line+=$(printf ' %-17s' "$(hash_of "$program" "$scene" "$threads")"); done
  echo "$line"
  echo "$line" | cut -c31- >>"$work/${4:-hashes}"
}

printf '%-30s' variant
printf ' %-17s' "${scenes[@]}"
echo
first=
for variant in "${variants[@]}"; do
  program=$(program_of "$variant")
  first=${first:-$program}
  for threads in 1 3; do row "$variant" "$program" "$threads"; done
done
cc -shared -fPIC -O1 -fno-builtin -o "$work/libm_off.so" scripts/libm_off_by_one_ulp.c -ldl -lm
LD_PRELOAD=$work/libm_off.so row "libm off by one ulp" "$first" 1 off
if [ "$(sort -u "$work/hashes" | wc -l)" -ne 1 ]; then
  echo "same_bits.sh: the variants end with different bits" >&2
  exit 1
fi
echo "All variants end with the same bits."
cmp -s "$work/off" <(head -n 1 "$work/hashes") ||
  echo "Some depend on the last bits of the C library (docs/limitations.md)."
