#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# same_bits.sh [VARIANT...]: builds the program with each compiler, optimisation and processor (in build/bits_VARIANT), runs
# short scenes with one and with three threads, and prints a table of their state hashes: a row for each variant and a
# column for each scene. Three more rows run the first variant on a processor without AVX (emulated), with a C library
# whose sin, exp, ... are off by one unit in the last place, and with those of musl. Ends with 1 if any two rows differ.
# Variants: gcc_O2 gcc_O3 clang_O2 clang_O3 arm64_O2 (default: all). The last is 64-bit Arm: compiled by a cross compiler
# and run by qemu.
# SELVEDGE_BITS_PROGRAMS names a folder with programs VARIANT instead of building them. The programs have no adapters, which
# take no part in a state.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
variants=("$@")
[ ${#variants[@]} -gt 0 ] || variants=(gcc_O2 gcc_O3 clang_O2 clang_O3 arm64_O2)

declare -A options=(
  [cloth_on_sphere]="--set time.frames=6 --set geometry.0.cells=[20,20]"
  [flag]="--set time.frames=6"
  [hysteresis]="--set time.frames=6"
  [incline]="--set time.frames=6"
  [plate_2]="--set time.frames=6"
  [finite_elements]="--set time.frames=4"
)
scenes=(cloth_on_sphere flag hysteresis incline plate_2 finite_elements)
scripts/install_dependencies.sh bits
[[ " ${variants[*]} " != *" arm64_"* ]] || scripts/install_dependencies.sh arm64
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

program_of() {
  local variant=$1
  if [ -n "${SELVEDGE_BITS_PROGRAMS:-}" ]; then
    echo "$SELVEDGE_BITS_PROGRAMS/$variant"
    return
  fi
  local build=build/bits_$variant compiler=g++ c=gcc cross=()
  case $variant in
    clang_*) compiler=clang++ c=clang ;;
    arm64_*)
      compiler=aarch64-linux-gnu-g++ c=aarch64-linux-gnu-gcc
      cross=(-DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64)
      ;;
    gcc_*) ;;
    *) echo "same_bits.sh: there is no variant $variant" >&2; return 1 ;;
  esac
  command -v "$compiler" >/dev/null || { echo "same_bits.sh: $compiler is not installed" >&2; return 1; }
  scripts/quietly.sh cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_UNITY=ON "-DCMAKE_CXX_FLAGS_RELEASE=-${variant#*_} -DNDEBUG" \
    -DCMAKE_C_COMPILER=$c -DCMAKE_CXX_COMPILER=$compiler "${cross[@]}" -DSELVEDGE_TESTS=OFF -DSELVEDGE_BENCH=OFF \
    -DSELVEDGE_EXAMPLES=OFF -DSELVEDGE_ASSIMP=OFF -DSELVEDGE_FCL=OFF -DSELVEDGE_LIBCCD=OFF -DSELVEDGE_EMBREE=OFF \
    -DSELVEDGE_OSMESA=OFF >&2
  scripts/quietly.sh cmake --build "$build" --parallel "$(nproc)" --target selvedge_program >&2
  echo "$build/apps/selvedge"
}

# The state hash of a run, or the reason why there is none.
hash_of() {
  local program=$1 scene=$2 threads=$3 out=$work/out
  rm -rf "$out"
  # shellcheck disable=SC2086
  "${emulator[@]}" "$program" run "data/scenes/$scene.json" --out "$out" --no-pictures --threads "$threads" ${options[$scene]} \
    >"$work/log" 2>&1 || true
  { grep -o '"state_hash" *: *"[0-9a-f]*"' "$out/result.json" 2>/dev/null || echo '"failed"'; } | tr -d '" ' | sed 's/.*://'
}

row() {
  local name=$1 program=$2 threads=$3 line
  line=$(printf '%-30s' "$name, threads $threads")
  for scene in "${scenes[@]}"; do line+=$(printf ' %-17s' "$(hash_of "$program" "$scene" "$threads")"); done
  echo "$line"
  echo "$line" | cut -c31- >>"$work/hashes"
}

printf '%-30s' variant
printf ' %-17s' "${scenes[@]}"
echo
first=
emulator=()
for variant in "${variants[@]}"; do
  program=$(program_of "$variant")
  if [[ $variant == arm64_* ]]; then emulator=(qemu-aarch64-static); else first=${first:-$program}; fi
  for threads in 1 3; do row "$variant" "$program" "$threads"; done
  emulator=()
done
if [ -n "$first" ]; then
  cc -shared -fPIC -O1 -fno-builtin -o "$work/libm_off.so" tests/libm_off_by_one_ulp.c -ldl -lm
  LD_PRELOAD=$work/libm_off.so row "libm off by one ulp" "$first" 1
  # Debian has no C++ library for musl, so glibc serves the rest of the program.
  musl=/usr/lib/$(uname -m)-linux-musl/libc.a
  functions='a?(sin|cos|tan)h?|sincos|atan2|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot'
  parts='__(sin|cos|tan|expo2|math_[a-z]*|rem_pio2|rem_pio2_large|invtrigl)|(exp|exp2f|log|log2|pow)_data'
  mkdir "$work/musl"
  ar t "$musl" | grep -E "^($functions|$parts)\.lo$" | (cd "$work/musl" && xargs ar x "$musl")
  cc -shared -o "$work/libm_musl.so" "$work"/musl/*.lo -lm
  LD_PRELOAD=$work/libm_musl.so row "functions of musl" "$first" 1
  emulator=(qemu-x86_64-static -cpu Nehalem)
  row "no AVX" "$first" 1
fi
if [ "$(sort -u "$work/hashes" | wc -l)" -ne 1 ] || grep -q failed "$work/hashes"; then
  echo "same_bits.sh: the variants end with different bits" >&2
  exit 1
fi
echo "All variants end with the same bits."
