#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# broad_phase_table.sh [--quick | --only NAME]: measures every broad phase that this machine can build and writes the tables of
# docs/broad_phase.md between their markers, with the machine, the date and the command. --quick: small scenes and few
# repeats, to see that it works; its tables go to the standard output alone. --only: one of detectors, libraries, spikes,
# scaling, memory and frames.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
quick=false
names=(detectors libraries spikes scaling memory frames)
case "${1:-}" in
  "") ;;
  --quick) quick=true ;;
  --only) names=("${2:?which table?}") ;;
  *) echo "usage: scripts/broad_phase_table.sh [--quick | --only NAME]" >&2; exit 2 ;;
esac

build=build/release
if [ -z "${SELVEDGE_BENCH_BROADPHASE:-}" ]; then
  configure=(cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_BENCH=ON)
  if [ ! -f "$build/CMakeCache.txt" ] && command -v ninja >/dev/null; then configure+=(-G Ninja); fi
  scripts/quietly.sh "${configure[@]}"
  scripts/quietly.sh cmake --build "$build" --target bench_broadphase --parallel
fi
bench=${SELVEDGE_BENCH_BROADPHASE:-$build/bench/bench_broadphase}
page=docs/broad_phase.md
tables=$(mktemp -d)
trap 'rm -rf "$tables"' EXIT

# table NAME ARGUMENTS...: the table with what it was measured by.
table() {
  local name=$1
  shift
  echo "Measuring: $name" >&2
  {
    echo
    "$bench" "$@" --markdown
    echo "\`bench_broadphase $*\` on $(nproc) cores of $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)," \
         "$(date -u +%Y-%m-%d), load $(cut -d' ' -f1 /proc/loadavg)."
    echo
  } >"$tables/$name"
}

if $quick; then
  table detectors detectors --size 30 --repeats 1
  table libraries libraries --size 30 --repeats 1
  table spikes spikes --size 30 --repeats 1
  table scaling scaling --size 20,40 --repeats 1
  table memory memory --size 30
  table frames frames --size 30 --frames 5
  cat "$tables"/*
  exit 0
fi
for name in "${names[@]}"; do
  case "$name" in
    detectors) table detectors detectors --size 50,200 --threads 1,2 --repeats 3 ;;
    libraries) table libraries libraries --size 200 --threads 1,2 --repeats 9 ;;
    spikes) table spikes spikes --size 100 --smaller 1e5,1e7 --repeats 3 --limit 10 ;;
    scaling)
      table scaling scaling --size 50,100,200,400 --repeats 3 --limit 15 --detectors \
        bvh_aabb,bvh_kdop14,curvature_cone,sweep_and_prune,uniform_grid,verlet_bvh
      ;;
    memory) table memory memory --size 200 --large --detectors bvh_aabb,bvh_kdop14 ;;
    frames) table frames frames --size 100 --frames 200 --detectors bvh_aabb,verlet_bvh ;;
    *) echo "broad_phase_table.sh: there is no table '$name'" >&2; exit 2 ;;
  esac
done

for name in "${names[@]}"; do
  begin="<!-- table: $name -->"
  end="<!-- end of table: $name -->"
  if ! grep -qF "$begin" "$page" || ! grep -qF "$end" "$page"; then
    echo "broad_phase_table.sh: $page has no markers '$begin' and '$end'" >&2
    exit 1
  fi
  awk -v begin="$begin" -v end="$end" -v file="$tables/$name" '
    $0 == end { inside = 0 }
    !inside { print }
    $0 == begin { inside = 1; while ((getline line < file) > 0) print line }' "$page" >"$tables/page"
  cp "$tables/page" "$page"
done
echo "Written: $page"
