#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# experiments.sh [PROGRAM [FOLDER [NAME...]]]: runs the experiments of the survey's section 7 (tables X to XVIII,
# data/experiments) and prints a table, of which docs/lab/experiments.md shows a part: whether each scene runs and is clean,
# steps, seconds, largest stretch, final speed, and what its figure shows, measured (experiment_outcome.py). The pictures
# are in FOLDER/NAME/pictures; ffmpeg, if it is there, joins them in FOLDER/experiments.png.
#   PROGRAM  the program (default: build/release/apps/selvedge)
#   FOLDER   the folder of results and pictures (default: out/experiments)
#   NAME     scenes, without .json (default: all scenes whose header names a table, and those of XVI also with the light and
#            the heavy weave); NAME@FABRIC: with this fabric of data/fabrics/usual_kes as the material "cloth"
# Exits with 1 if a scene did not run, was not clean, or does not show what its figure does.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=${1:-$root/build/release/apps/selvedge}
folder=${2:-$root/out/experiments}
shift $(($# < 2 ? $# : 2))
names=("$@")
if [ "${#names[@]}" -eq 0 ]; then
  for file in "$root"/data/experiments/*.json; do
    if grep -q '^  "description": .* Table [IVX]*: ' "$file"; then
      name=$(basename "$file" .json)
      names+=("$name")
      case "$name" in xvi_*) names+=("$name@plain_light" "$name@plain_heavy") ;; esac
    fi
  done
fi

value() { sed -n "s/^  *\"$2\": \(.*[^,]\),*\$/\1/p" "$1" | head -n 1; }

mkdir -p "$folder"
failed=0
pictures=()
printf '%-28s %-5s %-5s %7s %6s %8s %7s  %s\n' scene runs clean 'steps' 's' stretch% speed outcome
for name in "${names[@]}"; do
  out=$folder/$name
  rm -rf "$out"
  runs=yes
  sets=()
  if [ "$name" != "${name%@*}" ]; then sets=(--set "materials.cloth.fabric=usual_kes/${name#*@}"); fi
  "$program" run "$root/data/experiments/${name%@*}.json" --out "$out" "${sets[@]}" >"$folder/$name.log" 2>&1 || runs=NO
  result=$out/result.json
  clean=NO steps=- wall=- stretch=- speed=-
  if [ -f "$result" ]; then
    [ "$(value "$result" clean)" = true ] && clean=yes
    steps=$(value "$result" steps)
    wall=$(printf '%.1f' "$(value "$result" wall_s)")
    stretch=$(awk -v s="$(value "$result" max_stretch)" 'BEGIN {printf "%.2f", 100 * s}')
    speed=$(printf '%.4f' "$(value "$result" final_max_speed)")
  fi
  picture=$(find "$out/pictures" -name '*.png' 2>/dev/null | sort | tail -n 1)
  outcome=
  if [ "$runs" = yes ]; then outcome=$("$root/scripts/experiment_outcome.py" "$out" "$program") || failed=1; fi
  printf '%-28s %-5s %-5s %7s %6s %8s %7s  %s\n' "$name" "$runs" "$clean" "$steps" "$wall" "$stretch" "$speed" "$outcome"
  if [ "$runs$clean" != yesyes ] || [ -z "$picture" ]; then failed=1; fi
  pictures+=("$picture")
done
if command -v ffmpeg >/dev/null; then
  for k in "${!pictures[@]}"; do ln -sf "$(realpath "${pictures[k]}")" "$folder/$(printf '%02d' "$k").png"; done
  ffmpeg -loglevel error -y -i "$folder/%02d.png" -vf 'scale=240:-1,tile=5x4:padding=4:color=white' -frames:v 1 \
    "$folder/experiments.png"
  rm -f "$folder"/[0-9][0-9].png
fi
exit "$failed"
