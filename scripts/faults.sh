#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# faults.sh [PROGRAM [KILLS]]: what happens to a run when the machine fails. Prints a line for each fault and ends with 1
# if a result is lost or wrong: KILLS (default 100) runs that are killed at a random moment and resumed, a full disk (a
# small tmpfs, as root), a limit of the memory, a folder that cannot be written, paths with spaces, quotes and letters of
# other scripts, a locale with a decimal comma, and a second run into the folder of a run.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit
program=$(realpath "${1:-build/release/apps/selvedge}")
kills=${2:-100}
work=$(mktemp -d)
trap 'umount "$work/small" 2>/dev/null; rm -rf "$work"' EXIT
cat >"$work/scene.json" <<'SCENE'
{"name": "faults",
 "geometry": [{"size": [0.5, 0.5], "cells": [12, 12], "transformation": {"translation": [0.01, 0.02, 0.305]}}],
 "obstacles": [{"shape": {"type": "sphere", "radius": 0.3, "resolution": 16}}],
 "output": {"formats": ["vtk"]}, "time": {"frames": 40}}
SCENE
failed=0
say() { printf '%-34s %s\n' "$1" "$2"; }
fail() { say "$1" "WRONG: $2"; failed=1; }
hash_of() { grep -o '"state_hash" *: *"[0-9a-f]*"' "$1/result.json" 2>/dev/null | tr -d '" ' | sed 's/.*://'; }
command=("$program" run "$work/scene.json" --no-pictures)
run() { "${command[@]}" "$@"; }

run --out "$work/whole" >/dev/null 2>&1
whole=$(hash_of "$work/whole")
[ -n "$whole" ] || { echo "faults.sh: the scene does not run" >&2; exit 1; }
begin=$(date +%s%N)
run --out "$work/timed" >/dev/null 2>&1
length=$((($(date +%s%N) - begin) / 1000000)) # ms

# -- kill -9 ------------------------------------------------------------------------------------------------------
resumed=0 fresh=0 late=0
for ((i = 0; i < kills; ++i)); do
  out=$work/killed
  rm -rf "$out"
  "${command[@]}" --out "$out" >/dev/null 2>&1 &
  child=$!
  sleep "$(awk -v ms="$length" -v r="$RANDOM" 'BEGIN { printf "%.3f", ms * r / 32768 / 1000 }')"
  kill -9 "$child" 2>/dev/null || late=$((late + 1))
  wait "$child" 2>/dev/null
  if [ -f "$out/checkpoint.json" ]; then
    run --out "$out" --resume >"$work/log" 2>&1 || fail "kill -9, then --resume" "$(tail -n 1 "$work/log")"
    resumed=$((resumed + 1))
  else
    run --out "$out" --overwrite >"$work/log" 2>&1 || fail "kill -9 before a checkpoint" "$(tail -n 1 "$work/log")"
    fresh=$((fresh + 1))
  fi
  [ "$(hash_of "$out")" = "$whole" ] || fail "kill -9, then --resume" "other bits"
  [ -z "$(find "$out" -name '*.partial*')" ] || say "kill -9" "leaves $(find "$out" -name '*.partial*' | wc -l) partial files"
done
say "kill -9 at $kills random moments" "$resumed resumed, $fresh before the first checkpoint, $late after the end; same bits"

# -- SIGTERM ------------------------------------------------------------------------------------------------------
"${command[@]}" --out "$work/term" >/dev/null 2>&1 &
child=$!
for _ in $(seq 100); do [ -f "$work/term/frames/cloth_00001.ply" ] && break; sleep 0.01; done
kill -TERM "$child" 2>/dev/null
wait "$child"
run --out "$work/term" --resume >/dev/null 2>&1
if [ "$(hash_of "$work/term")" = "$whole" ]; then say "SIGTERM, then --resume" "same bits"; else fail "SIGTERM" "other bits"; fi

# -- a full disk --------------------------------------------------------------------------------------------------
mkdir "$work/small"
if mount -t tmpfs -o size=400k tmpfs "$work/small" 2>/dev/null; then
  code=0
  run --out "$work/small/out" >"$work/log" 2>&1 || code=$?
  lines=$(grep -vc '^frame ' "$work/log")
  if [ "$code" -eq 1 ] && grep -q 'No space left' "$work/log"; then
    say "full disk" "exit code 1, $lines line: $(tail -n 1 "$work/log" | cut -c1-90)"
  else
    fail "full disk" "exit code $code: $(tail -n 1 "$work/log")"
  fi
  mount -o remount,size=40m "$work/small"
  run --out "$work/small/out" --resume >"$work/log" 2>&1 || fail "resumed on a larger disk" "$(tail -n 1 "$work/log")"
  [ "$(hash_of "$work/small/out")" = "$whole" ] && say "resumed on a larger disk" "same bits"
  umount "$work/small"
else
  say "full disk" "left out: a tmpfs needs root"
fi

# -- memory -------------------------------------------------------------------------------------------------------
for megabytes in 60 120 200 300 500 1000; do
  code=0
  (ulimit -v $((megabytes * 1024)); exec "${command[@]}" --threads 1 --out "$work/memory" --overwrite) >"$work/log" 2>&1 || code=$?
  case $code in
    0) say "ulimit -v of $megabytes MB" "runs" ;;
    1 | 2 | 127) say "ulimit -v of $megabytes MB" "exit code $code: $(tail -n 1 "$work/log" | cut -c1-90)" ;;
    *) fail "ulimit -v of $megabytes MB" "exit code $code: $(tail -n 1 "$work/log")" ;;
  esac
done

# -- folders and paths --------------------------------------------------------------------------------------------
expect_2() {
  local what=$1 code=0
  shift
  "$@" >"$work/log" 2>&1 || code=$?
  if [ "$code" -eq 2 ]; then say "$what" "refused: $(tail -n 1 "$work/log" | sed "s|$work/||g" | cut -c1-90)"; else fail "$what" "exit code $code"; fi
}
expect_2 "a read-only place" run --out /proc/selvedge
expect_2 "a file in place of the folder" run --out "$work/scene.json/out"
expect_2 "results of an earlier run" run --out "$work/whole"
expect_2 "results of another scene" run --set name=other --out "$work/whole" --overwrite
"${command[@]}" --out "$work/two" >/dev/null 2>&1 &
child=$!
for _ in $(seq 100); do [ -f "$work/two/frames/cloth_00001.ply" ] && break; sleep 0.01; done
expect_2 "a second run into the folder" run --out "$work/two" --overwrite
wait "$child"
# shellcheck disable=SC2016
for name in "with space" "it's" 'a"b' '$(touch owned)' 'ünïcödé 布' '-dash' $'line\nend'; do
  mkdir -p "$work/odd/$name"
  cp "$work/scene.json" "$work/odd/$name/scene.json"
  if "$program" run "$work/odd/$name/scene.json" --no-pictures --set time.frames=1 --out "$work/odd/$name/out" >"$work/log" 2>&1 &&
    "$program" check "$work/odd/$name/out" >"$work/log" 2>&1; then
    :
  else
    fail "the path '$name'" "$(tail -n 1 "$work/log")"
  fi
done
say "odd paths" "run and check"

# -- locale -------------------------------------------------------------------------------------------------------
comma=$(locale -a 2>/dev/null | grep -iE '^(de_DE|fr_FR)' | head -n 1)
if [ -n "$comma" ]; then
  LC_ALL=$comma run --out "$work/comma" >/dev/null 2>&1
  if [ "$(hash_of "$work/comma")" = "$whole" ]; then say "locale $comma" "same bits"; else fail "locale $comma" "other bits"; fi
else
  say "a decimal comma" "left out: no such locale is installed"
fi
exit "$failed"
