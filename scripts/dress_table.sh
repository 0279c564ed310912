#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# dress_table.sh BODY RESOLUTION PATTERN...: puts each garment on a body, one at a time, and prints one CSV row for each:
# pattern, panels, vertices, seconds of wall and processor time, states judged, largest seam opening, stretch and verdict.
# A PATTERN is a file or a folder of *.json files; BODY is in metres with y up; RESOLUTION is the edge length in metres. The
# results go to out/dress_table/RESOLUTION/NAME, or to the folder in OUT. SELVEDGE names the program (default:
# build/release/apps/selvedge); THREADS and LIMIT set the number of threads (default: all) and the longest time of one
# garment in seconds (default: 600). Exit code 1: a garment was not put on as wanted.
# dress_table.sh --results FOLDER...: prints the same of garments that were put on before: result folders of `selvedge dress`,
# or folders of such, as --list makes them. Wall time is without output; processor time stays empty.
set -euo pipefail

row() { # FOLDER, EXIT CODE, "WALL USER SYSTEM" TIMES or ""
  python3 - "$1/result.json" "$(basename "$1")" "$2" "$3" "${LIMIT:-600}" <<'PYTHON'
import csv, json, os, sys

file, name, code, times, limit = sys.argv[1:]
result = {}
if os.path.exists(file):
    with open(file) as text:
        result = json.load(text)
if code == "124":
    result["verdict"] = f"not finished within {limit} s"
if times:
    wall, user, system = (float(t) for t in times.split())
    seconds = [f"{wall:.1f}", f"{user + system:.1f}"]
else:
    seconds = [f"{sum(s for phase, s in result.get('seconds', {}).items() if phase != 'output' and '/' not in phase):.1f}", ""]
cells = [name, len(result.get("panels", [])) or "", result.get("vertices", ""), *seconds, result.get("states_judged", "")]
finished = "largest_opening_m" in result
cells += [f"{1e3 * result['largest_opening_m']:.2f}", f"{1e2 * result['max_stretch']:.1f}"] if finished else ["", ""]
csv.writer(sys.stdout, lineterminator="\n").writerow(cells + [result.get("verdict", f"no result, exit code {code}")])
PYTHON
}

header="pattern,panels,vertices,wall_s,cpu_s,states,opening_mm,stretch_percent,verdict"
if [ "${1:-}" = --results ] && [ $# -gt 1 ]; then
  echo "$header"
  for folder in "${@:2}"; do
    if [ -f "$folder/result.json" ]; then row "$folder" 0 ""; fi
    for result in "$folder"/*/result.json; do
      if [ -f "$result" ]; then row "$(dirname "$result")" 0 ""; fi
    done
  done
  exit 0
fi
if [ $# -lt 3 ]; then
  echo "usage: scripts/dress_table.sh BODY RESOLUTION PATTERN..., or scripts/dress_table.sh --results FOLDER..." >&2
  exit 2
fi
body=$1 resolution=$2
shift 2
out=${OUT:-out/dress_table/$resolution}
program=${SELVEDGE:-$(dirname "${BASH_SOURCE[0]}")/../build/release/apps/selvedge}
if ! command -v "$program" >/dev/null; then
  echo "dress_table.sh: there is no program '$program'; build it, or name it in SELVEDGE" >&2
  exit 2
fi

patterns=()
for pattern in "$@"; do
  if [ -d "$pattern" ]; then patterns+=("$pattern"/*.json); else patterns+=("$pattern"); fi
done
status=0
TIMEFORMAT='%R %U %S'
echo "$header"
for pattern in "${patterns[@]}"; do
  name=$(basename "$pattern" .json) code=0
  mkdir -p "$out"
  rm -rf "${out:?}/$name"
  { time timeout "${LIMIT:-600}" "$program" dress "$pattern" "$body" --resolution "$resolution" --threads "${THREADS:-0}" \
    --out "$out/$name" >"$out/$name.log" 2>&1; } 2>"$out/$name.times" || code=$?
  if [ "$code" -ne 0 ]; then status=1; fi
  row "$out/$name" "$code" "$(cat "$out/$name.times")"
  rm "$out/$name.times"
done
exit "$status"
