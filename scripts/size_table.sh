#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# size_table.sh [BUILD_DIR]: prints the size of a program with the lean parts of a finished build (core, broad phase,
# narrow phase; dependent on Eigen only), and the size that each optional library would add: our adapter in BUILD_DIR
# (build/release) and its shared libraries, excluding those that every C++ program uses.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=${1:-build/release}
compiler=${CXX:-c++}
eigen=${EIGEN_INCLUDE:-/usr/include/eigen3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

everywhere='linux-vdso|ld-linux|libc\.so|libm\.so|libstdc\+\+|libgcc_s'

# Bytes of the shared libraries that a file needs, excluding those that every C++ program uses.
shared_bytes() {
  { ldd "$1" | grep -Ev "$everywhere" | awk '$2 == "=>" && $3 ~ /^\// {print $3}' || true; } |
    sort -u | xargs -r stat -L -c %s | awk '{sum += $1} END {print sum + 0}'
}
shared_names() {
  { ldd "$1" | grep -Ev "$everywhere" | awk '$2 == "=>" {print $1}' || true; } | sort -u | wc -l
}
kilobytes() { awk -v bytes="$1" 'BEGIN {printf "%.0f", bytes / 1000}'; }

# Links tests/consumer/shards.cpp with the detectors of BUILD_DIR. Only core/parallel.cpp uses threads. Compiled without
# threads, it replaces the archive's version, so the lean program needs no separate build.
program() {
  local name=$1 label=$2 threads=$3
  local flags=(-std=c++20 -O3 -DNDEBUG -ffp-contract=off -I "$build/include" -isystem "$eigen")
  local objects=() libraries=("$build"/{broadphase/libselvedge_broadphase,narrowphase/libselvedge_narrowphase,bodies/libselvedge_bodies,core/libselvedge_base}.a)
  "$compiler" "${flags[@]}" -c tests/consumer/shards.cpp -o "$work/shards.o"
  objects=("$work/shards.o")
  if [ "$threads" = no ]; then
    "$compiler" "${flags[@]}" -c core/parallel.cpp -o "$work/parallel.o"
    objects+=("$work/parallel.o")
  else
    libraries+=(-ltbb)
  fi
  "$compiler" "${objects[@]}" -Wl,--start-group "${libraries[@]}" -Wl,--end-group -o "$work/$name"
  strip "$work/$name"
  "$work/$name" >/dev/null
  echo "| $label | $(kilobytes "$(stat -c %s "$work/$name")") | $(kilobytes "$(shared_bytes "$work/$name")") | $(shared_names "$work/$name") |"
}

echo "| program or library | our code, kB | shared libraries, kB | libraries |"
echo "| --- | ---: | ---: | ---: |"
program lean "detectors alone, no threads: Eigen only" no
program threads "the same with threads (oneTBB)" yes

adapter() {
  local label=$1 archive=$2 library=$3
  local file
  file=$(ldconfig -p | awk -v name="$library" '$1 ~ "^"name && !found {print $NF; found = 1}')
  if [ -z "$file" ]; then echo "| $label | not here | | |"; return; fi
  local ours=0
  if [ -n "$archive" ] && [ -f "$build/$archive" ]; then ours=$(size -t "$build/$archive" | awk 'END {print $4}'); fi
  local bytes=$(($(stat -L -c %s "$file") + $(shared_bytes "$file")))
  echo "| $label | $(kilobytes "$ours") | $(kilobytes "$bytes") | $(($(shared_names "$file") + 1)) |"
}
adapter "FCL, broad phase" broadphase/libselvedge_broadphase_fcl.a 'libfcl\.so'
adapter "FCL, narrow phase" narrowphase/libselvedge_narrowphase_fcl.a 'libfcl\.so'
adapter "libccd" narrowphase/libselvedge_narrowphase_libccd.a 'libccd\.so'
adapter "CGAL (templates; GMP and MPFR)" broadphase/libselvedge_broadphase_cgal.a 'libmpfr\.so'
adapter "Embree 3" broadphase/libselvedge_broadphase_embree.a 'libembree3\.so'
adapter "OSMesa, image space" broadphase/libselvedge_broadphase_osmesa.a 'libOSMesa\.so'
adapter "assimp, meshes of other formats" "" 'libassimp\.so'
