#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# broad_phase_table.sh [--quick | --only NAME]: measures every broad phase that this machine can build. It writes each
# table to docs/lab/tables/broad_phase_NAME.csv, and a short form into docs/lab/broad_phase.md between the markers of that name,
# with the machine, the date and the command. --quick: small scenes and few repeats as a quick check; prints the tables
# and writes no file of docs/. --only: one of detectors, libraries, spikes, scaling, memory and frames.
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
if [ -z "${SELVEDGE_BENCH:-}" ]; then
  configure=(cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_UNITY=ON -DSELVEDGE_BENCH=ON)
  if [ ! -f "$build/CMakeCache.txt" ] && command -v ninja >/dev/null; then configure+=(-G Ninja); fi
  scripts/quietly.sh "${configure[@]}"
  scripts/quietly.sh cmake --build "$build" --target selvedge_bench --parallel "$(nproc)"
fi
bench=${SELVEDGE_BENCH:-$build/bench/bench}
page=docs/lab/broad_phase.md
tables=$(mktemp -d)
trap 'rm -rf "$tables"' EXIT

# table NAME ARGUMENTS...: measures the table NAME.csv and records the command and the machine.
table() {
  local name=$1
  shift
  echo "Measuring: $name" >&2
  "$bench" broadphase "$@" --csv "$tables/$name.raw" >/dev/null
  sed '/^$/d' "$tables/$name.raw" >"$tables/$name.csv"
  echo "\`bench broadphase $*\` on $(nproc) cores of $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)," \
    "$(date -u +%Y-%m-%d), load $(cut -d' ' -f1 /proc/loadavg)." >"$tables/$name.how"
}

if $quick; then
  table detectors detectors --size 30 --repeats 1
  table libraries libraries --size 30 --repeats 1
  table spikes spikes --size 30 --repeats 1
  table scaling scaling --size 20,40 --repeats 1
  table memory memory --size 30
  table frames frames --size 30 --frames 5
  cat "$tables"/*.csv
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

# columns FILE.csv NUMBERS...: prints these columns as a Markdown table.
columns() {
  local file=$1
  shift
  awk -F, -v list="$*" '
    BEGIN { count = split(list, column, " ") }
    {
      row = rule = "|"
      for (i = 1; i <= count; ++i) {
        row = row " " $column[i] " |"
        rule = rule (i < 3 ? " --- |" : " ---: |")
      }
      print row
      if (NR == 1) print rule
    }' "$file"
}

# Columns of detectors.csv: 1 scene, 2 detector, 3 threads, 8 warm ms, 11 share of the box pairs, 12 MB.
short_detectors() {
  echo "| detector | drape, ms | pairs, % | MB | crumple, ms | pairs, % | MB |"
  echo "| --- | ---: | ---: | ---: | ---: | ---: | ---: |"
  awk -F, '
    $3 != 1 || $1 !~ / 200$/ { next }
    NF < 12 && $1 ~ /^drape/ { next }  # answers particles, not pairs
    $1 ~ /^drape/ { drape[$2] = sprintf("%.1f | %.0f | %.0f", $8, 100 * $11, $12) }
    $1 ~ /^crumple/ { crumple[$2] = NF < 12 ? "- | - | -" : sprintf("%.1f | %.0f | %.0f", $8, 100 * $11, $12) }
    END { for (name in drape) print "| `" name "` | " drape[name] " | " crumple[name] " |" }' "$tables/detectors.csv" |
    sort -t'|' -k3,3n
}

# Columns of frames.csv: 1 scene, 2 detector, 4 speed, 5 mean ms, 7 worst ms.
short_frames() {
  echo "| scene | speed, m/s | bvh_aabb mean, ms | worst, ms | verlet_bvh mean, ms | worst, ms |"
  echo "| --- | ---: | ---: | ---: | ---: | ---: |"
  awk -F, '
    $2 == "bvh_aabb" { tree = $5 " | " $7 }
    $2 == "verlet_bvh" { print "| " $1 " | " $4 " | " tree " | " $5 " | " $7 " |" }' "$tables/frames.csv"
}

# Columns of spikes.csv: 1 scene, 2 detector, 3 threads, 4 perturbation, 6 ratio to plain.
short_spikes() {
  echo "| detector | drape: spike | far away | copy 1e5 | copy 1e7 | crumple: spike | far away | copy 1e5 | copy 1e7 |"
  echo "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
  awk -F, '
    $3 != 1 || NF < 6 { next }
    {
      kind = $4 ~ /^spike/ ? 1 : $4 ~ /away$/ ? 2 : $4 ~ /1e5/ ? 3 : $4 ~ /1e7/ ? 4 : 0
      scene = $1 ~ /^drape/ ? 0 : 4
      known[$2]
      if (NF >= 6 && $6 + 0 > ratio[$2, scene + kind] + 0) ratio[$2, scene + kind] = $6
    }
    END {
      for (name in known) {
        row = "| `" name "` |"
        for (k = 1; k <= 8; ++k) row = row " " ((name, k) in ratio && ratio[name, k] ? ratio[name, k] : "-") " |"
        print row
      }
    }' "$tables/spikes.csv" | sort
}

short() {
  case "$1" in
    detectors) short_detectors ;;
    frames) short_frames ;;
    libraries)
      columns "$tables/libraries.csv" 1 2 3 5 6 8 9 10 |
        sed "1s/.*/| scene | call | threads | bvh_aabb, ms | best library | its ms | ratio of minima | of medians |/"
      ;;
    scaling) columns "$tables/scaling.csv" 1 2 4 5 6 7 8 ;;
    memory) columns "$tables/memory.csv" 1 2 3 4 5 6 7 ;;
    spikes) short_spikes ;;
  esac
}

mkdir -p docs/lab/tables
for name in "${names[@]}"; do
  begin="<!-- table: $name -->"
  end="<!-- end of table: $name -->"
  if ! grep -qF "$begin" "$page" || ! grep -qF "$end" "$page"; then
    echo "broad_phase_table.sh: $page has no markers '$begin' and '$end'" >&2
    exit 1
  fi
  cp "$tables/$name.csv" "docs/lab/tables/broad_phase_$name.csv"
  short "$name" >"$tables/$name.short"
  {
    echo
    cat "$tables/$name.short"
    if [ -s "$tables/$name.short" ]; then echo; fi
    echo "All rows: [docs/lab/tables/broad_phase_$name.csv](tables/broad_phase_$name.csv), by"
    cat "$tables/$name.how"
    echo
  } >"$tables/$name.md"
  awk -v begin="$begin" -v end="$end" -v file="$tables/$name.md" '
    $0 == end { inside = 0 }
    !inside { print }
    $0 == begin { inside = 1; while ((getline line < file) > 0) print line }' "$page" >"$tables/page"
  cp "$tables/page" "$page"
done
echo "Written: $page and docs/lab/tables/broad_phase_*.csv"
