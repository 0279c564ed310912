#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# judge_scenes.sh [SCENE.json | NAME]... [--set PATH=VALUE]...: runs the given scenes, or every scene of data/scenes,
# with --every-step. `selvedge check` then judges every accepted state and every path between two. The script prints a
# table: frames, seconds, whether the run reports itself as clean, the verdict of the judge, largest stretch, final speed. It
# skips scenes whose body was not fetched and lists them. Exits with 0 only if every scene that ran is clean according
# to both. Builds the program first, unless SELVEDGE_PROGRAM names one. The results stay in out/judged, except for the
# large folders steps/; KEEP_STEPS=1 keeps these, too.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
usage() {
  echo "$1" >&2
  echo "usage: scripts/judge_scenes.sh [SCENE.json | NAME]... [--set PATH=VALUE]..." >&2
  exit 2
}

scenes=()
overrides=()
while [ $# -gt 0 ]; do
  case $1 in
    --set)
      [ $# -ge 2 ] || usage "judge_scenes.sh: --set needs PATH=VALUE"
      overrides+=(--set "$2")
      shift
      ;;
    -*) usage "judge_scenes.sh: unknown option $1" ;;
    *)
      if [ -f "$1" ]; then
        scenes+=("$(realpath "$1")")
      elif [ -f "$root/data/scenes/$1.json" ]; then
        scenes+=("$root/data/scenes/$1.json")
      else
        usage "judge_scenes.sh: no scene '$1'; those that come with selvedge are in data/scenes"
      fi
      ;;
  esac
  shift
done
if [ ${#scenes[@]} -eq 0 ]; then
  for scene in "$root"/data/scenes/*.json; do
    if [ "$(basename "$scene")" != scene.schema.json ]; then scenes+=("$scene"); fi
  done
fi

selvedge=${SELVEDGE_PROGRAM:-}
if [ -n "$selvedge" ]; then
  [ -x "$selvedge" ] || usage "judge_scenes.sh: SELVEDGE_PROGRAM=$selvedge is no program"
  selvedge=$(realpath "$selvedge")
fi
cd "$root"
if [ -z "$selvedge" ]; then
  scripts/install_dependencies.sh lean
  build=build/release
  configure=(cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_UNITY=ON)
  if [ ! -f "$build/CMakeCache.txt" ] && command -v ninja >/dev/null; then configure+=(-G Ninja); fi
  scripts/quietly.sh "${configure[@]}"
  scripts/quietly.sh cmake --build "$build" --target selvedge_program --parallel "$(nproc)"
  selvedge=$build/apps/selvedge
fi

# Reads one number or word of a JSON file with one value per name. That is enough for result.json and check.json.
value() {
  local text
  text=$({ grep -o "\"$2\" *: *[^,}]*" "$1" || true; } | head -n 1 | sed 's/^[^:]*: *//; s/[" ]//g')
  echo "${text:--}"
}
in_percent() { awk -v x="$1" 'BEGIN { if (x ~ /^[-+.0-9eE]+$/ && x != "-") printf "%.2f", 100 * x; else print x }'; }
rounded() { awk -v x="$1" -v f="$2" 'BEGIN { if (x ~ /^[-+.0-9eE]+$/ && x != "-") printf f, x; else print x }'; }

head='| %-18s | %6s | %6s | %8s | %-5s | %5s | %5s | %6s | %10s | %10s | %10s | %11s |\n'
# shellcheck disable=SC2059
row() { printf "$head" "$@"; }
row scene frames states seconds clean self body inside 'path self' 'path body' 'stretch %' 'speed m/s'
row --- ---: ---: ---: --- ---: ---: ---: ---: ---: ---: ---:

faults=0
judged=0
notes=()
for scene in "${scenes[@]}"; do
  name=$(basename "$scene" .json)
  out=out/judged/$name
  rm -rf "$out"
  mkdir -p out/judged
  log=out/judged/$name.log
  code=0
  "$selvedge" run "$scene" --out "$out" --overwrite --every-step --no-pictures "${overrides[@]}" >"$log" 2>&1 || code=$?
  if [ "$code" -eq 2 ] && grep -q 'scripts/fetch_bodies.sh' "$log"; then
    notes+=("$name was left out: its body is not there; scripts/fetch_bodies.sh fetches it")
    rm -f "$log"
    continue
  fi
  judged=$((judged + 1))
  if [ "$code" -ne 0 ]; then
    faults=$((faults + 1))
    notes+=("$name: run ended with $code: $(tail -n 1 "$log")")
  fi
  if [ "$code" -eq 2 ]; then continue; fi
  # The judge can also check the states of a run that failed before its end.
  check_code=0
  "$selvedge" check "$out" --json >"$log.check" 2>>"$log" || check_code=$?
  if [ "$check_code" -ne 0 ]; then
    if [ "$code" -eq 0 ]; then faults=$((faults + 1)); fi
    if [ "$check_code" -eq 1 ]; then
      notes+=("$name: check found something, first at $(value "$log.check" first_wrong)")
    else
      notes+=("$name: check ended with $check_code: $(tail -n 1 "$log")")
    fi
  fi
  result=$out/result.json
  if [ ! -f "$result" ]; then result=/dev/null; fi
  row "$name" "$(value "$result" frames)" "$(value "$log.check" states)" \
    "$(rounded "$(value "$result" wall_s)" %.1f)" "$(value "$result" clean)" \
    "$(value "$log.check" self_intersections)" "$(value "$log.check" body_intersections)" \
    "$(value "$log.check" inside_vertices)" "$(value "$log.check" path_self_collisions)" \
    "$(value "$log.check" path_body_collisions)" "$(in_percent "$(value "$result" max_stretch)")" \
    "$(rounded "$(value "$result" final_max_speed)" %.3g)"
  if [ -d "$out" ]; then mv "$log.check" "$out/check.json"; else rm -f "$log.check"; fi
  if [ -z "${KEEP_STEPS:-}" ] && [ "$check_code" -eq 0 ]; then rm -rf "$out/steps"; fi
done

echo
if [ ${#notes[@]} -gt 0 ]; then printf '%s\n' "${notes[@]}"; fi
echo "$((judged - faults)) of $judged scenes are clean by their own account and by the judge's"
[ "$faults" -eq 0 ] && [ "$judged" -gt 0 ]
