#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# check.sh ZIP PROGRAM: unpacks the package of build.sh into a folder whose name has a space and an umlaut, and tries it under Wine
# (package wine64) against the native program: hashes of six scenes after six frames, detectors, exact queries, judge, dress and
# pictures with the same output, a second run kept out of a folder, a run killed and resumed, a path with a drive letter and
# backslashes. Ends with 1 if anything differs.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$(mktemp -d)
# A build of other sources may replace the program meanwhile.
cp "$2" "$work/native"
zip=$(realpath "$1") native=$work/native
export WINEPREFIX=$work/wine WINEDEBUG=-all LC_ALL=C.UTF-8
wine=$(command -v wine64 || echo /usr/lib/wine/wine64)
trap 'wineserver -k 2>/dev/null || true; rm -rf "$work"' EXIT
failed=0
here="$work/Größe und Stoff"
"$wine" wineboot -i >/dev/null 2>&1 || true
seconds=$SECONDS
mkdir "$here"
unzip -q "$zip" -d "$here"
program=$(echo "$here"/selvedge-*/selvedge.exe)
data=$(dirname "$program")
printf '#!/bin/sh\nexec "%s" "%s" "$@"\n' "$wine" "$program" >"$work/selvedge"
chmod +x "$work/selvedge"
cd "$here"

# outcome NAME COMMAND...
outcome() {
  if "${@:2}"; then echo "$1: yes"; else echo "$1: NO"; failed=1; fi
}
# same FILTER ARGUMENTS...: what both programs print, through an awk program, is the same.
same() {
  "$work/selvedge" "${@:2}" 2>"$work/errors" | tr -d '\r' | awk "$1" >"$work/windows.txt"
  "$native" "${@:2}" 2>>"$work/errors" | awk "$1" >"$work/native.txt"
  # The native program has more detectors.
  [ -s "$work/windows.txt" ] && ! grep -Fxvf "$work/native.txt" "$work/windows.txt"
}

first_drape() {
  "$work/selvedge" run "$data/scenes/cloth_on_sphere.json" --out erste 2>/dev/null >"$work/first" && grep '^clean  *yes' "$work/first" &&
    "$work/selvedge" check erste 2>/dev/null
}

hashes() {
  local scenes=()
  for name in cloth_on_sphere flag hysteresis incline plate_2 finite_elements; do scenes+=("$root/data/scenes/$name.json"); done
  "$root/scripts/scene_hashes.sh" --frames 6 --program "$native" "${scenes[@]}" >"$work/hashes"
  "$root/scripts/scene_hashes.sh" --frames 6 --program "$work/selvedge" --compare "$work/hashes" "${scenes[@]}"
}

hash_of() { grep -m 1 '"state_hash"' "$1/result.json" | tr -d '\r'; }

judge() { same 1 check erste/frames/cloth_00020.ply --against erste/frames/bodies_00000.ply; }
detectors() { same 'NF == 9 { print $1, $5, $6, $7, $8 }' detect --a0 erste/frames/cloth_00009.ply --a1 erste/frames/cloth_00010.ply; }
queries() {
  "$work/selvedge" run "$data/scenes/two_sheets_on_ball.json" --out asked_run --set time.frames=6 --record asked >/dev/null 2>&1 &&
    same '/^ccd/ { print $1, $2, $3, $4, $5 }' ccd asked.point_triangle.csv asked.edge_edge.csv
}

dress() {
  for program in "$work/selvedge" "$native"; do
    "$program" dress "$root/data/patterns/flared_skirt.json" "$data/bodies/mannequin_arms_out.ply" --up z --resolution 0.04 \
      --out "skirt_${program##*/}_$([ "$program" = "$native" ] && echo native)" >/dev/null 2>&1
  done
  [ "$(hash_of skirt_selvedge_)" = "$(hash_of skirt_selvedge_native)" ]
}

pictures() { "$work/selvedge" render erste >/dev/null && [ "$(head -c 4 "$(find erste -name '*.png' | head -n 1)" | tail -c 3)" = PNG ]; }

# Windows names.
windows_path() { "$work/selvedge" check "Z:${PWD//\//\\}\\erste" >/dev/null 2>&1; }

# A run that is killed continues to the same bits, and keeps a second one out while it lives.
killed_and_resumed() {
  local run=("$work/selvedge" run "$data/scenes/flag.json" --set time.frames=90)
  "${run[@]}" --out ganz >/dev/null
  "${run[@]}" --out halb >/dev/null 2>&1 &
  local process=$! second=0
  until [ -e halb/checkpoint.json ] || [ ! -d "/proc/$process" ]; do sleep 0.1; done
  "${run[@]}" --out halb --resume >"$work/second" 2>&1 || second=$?
  kill -9 $process || return 1
  wait $process 2>/dev/null || true
  [ $second -eq 2 ] && grep -q 'another run (process [0-9]*) is at work' "$work/second" || return 1
  "${run[@]}" --out halb --resume >/dev/null && [ "$(hash_of ganz)" = "$(hash_of halb)" ]
}

outcome "first clean drape from the zip" first_drape
echo "seconds from the zip to the first clean drape: $((SECONDS - seconds))"
outcome "hashes of six scenes as native" hashes
outcome "judge as native" judge
outcome "detectors as native" detectors
outcome "exact queries as native" queries
outcome "dress, same state as native" dress
outcome "pictures" pictures
outcome "path with a drive letter and backslashes" windows_path
outcome "killed, a second one kept out, resumed to the same bits" killed_and_resumed
"$work/selvedge" --version | tr -d '\r' | head -n 1
exit $failed
