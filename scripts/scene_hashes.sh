#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# scene_hashes.sh [--frames N] [--program FILE] [--compare TABLE] [SCENE.json ...]
# Prints one line per scene: its name, the exit code of `selvedge run` and the hash of its last state. Without scenes
# it takes all of data/scenes, data/extreme and data/experiments. Two programs behave alike when their tables agree:
#   scripts/scene_hashes.sh --frames 12 >before.txt      # then change the code and build again
#   scripts/scene_hashes.sh --frames 12 --compare before.txt
# --frames   runs at most N frames of each scene (0, the default: all)
# --compare  prints the lines that differ from the table and exits with 1 if there are any
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=$root/build/release/apps/selvedge
frames=0
table=
scenes=()
while [ $# -gt 0 ]; do
  case "$1" in
    --frames) frames=$2; shift 2 ;;
    --program) program=$(realpath "$2"); shift 2 ;;
    --compare) table=$(realpath "$2"); shift 2 ;;
    -*) echo "usage: scripts/scene_hashes.sh [--frames N] [--program FILE] [--compare TABLE] [SCENE.json ...]" >&2; exit 2 ;;
    *) scenes+=("$(realpath "$1")"); shift ;;
  esac
done
if [ ${#scenes[@]} -eq 0 ]; then
  scenes=("$root"/data/scenes/*.json "$root"/data/extreme/*.json "$root"/data/experiments/*.json)
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$root"

# The number of frames that a scene file requests; 120 if it names none.
frames_of() { { grep -o '"frames" *: *[0-9]*' "$1" || echo 120; } | head -n 1 | tr -dc '0-9'; }

for scene in "${scenes[@]}"; do
  [[ "$scene" == *.schema.json ]] && continue
  limit=()
  if [ "$frames" -gt 0 ] && [ "$(frames_of "$scene")" -gt "$frames" ]; then
    limit=(--set "time.frames=$frames")
  fi
  code=0
  "$program" run "$scene" --out "$work/out" "${limit[@]}" >/dev/null 2>&1 || code=$?
  hash=$({ grep -o '"state_hash" *: *"[0-9a-f]*"' "$work/out/result.json" 2>/dev/null || echo '"-"'; } | tr -d '" ' | sed 's/.*://')
  printf '%-40s %s %s\n' "${scene#"$root"/data/}" "$code" "$hash"
  rm -rf "$work/out"
done | tee "$work/table"

if [ -n "$table" ]; then
  differing=$(join -j 1 <(sort "$table") <(sort "$work/table") | awk '$2 != $4 || $3 != $5' || true)
  if [ -n "$differing" ]; then
    printf 'These scenes end otherwise than in %s (name, code and hash there, code and hash here):\n%s\n' "$table" "$differing" >&2
    exit 1
  fi
  echo "All $(wc -l <"$work/table") scenes end as in $table" >&2
fi
