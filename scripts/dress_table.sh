#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# dress_table.sh BODY RESOLUTION PATTERN...: puts each garment on a body, one at a time, and prints one CSV row for each:
# pattern, panels, vertices, seconds of wall and processor time, states judged, largest seam opening, stretch and verdict. A PATTERN is a file or a
# folder of *.json files; BODY is in metres with y up; RESOLUTION is the edge length in metres. The results go to
# out/dress_table/RESOLUTION/NAME, or to the folder in OUT. SELVEDGE names the program (default:
# build/release/apps/selvedge); THREADS and LIMIT set the number of threads (default: all) and the longest time of one
# garment in seconds (default: 600). Exit code 1: a garment was not put on as wanted.
set -euo pipefail

if [ $# -lt 3 ]; then
  echo "usage: scripts/dress_table.sh BODY RESOLUTION PATTERN..." >&2
  exit 2
fi
body=$1 resolution=$2
shift 2
program=${SELVEDGE:-$(dirname "${BASH_SOURCE[0]}")/../build/release/apps/selvedge}
out=${OUT:-out/dress_table/$resolution}
if ! command -v "$program" >/dev/null; then
  echo "dress_table.sh: there is no program '$program'; build it, or name it in SELVEDGE" >&2
  exit 2
fi

row() { # NAME, EXIT CODE, "WALL USER SYSTEM" TIMES
  python3 - "$out/$1/result.json" "$@" "${LIMIT:-600}" <<'PYTHON'
import csv, json, os, sys

file, name, code, times, limit = sys.argv[1:]
wall, user, system = (float(t) for t in times.split())
result = {}
if os.path.exists(file):
    with open(file) as text:
        result = json.load(text)
if code == "124":
    result["verdict"] = f"not finished within {limit} s"
cells = [name, len(result.get("panels", [])) or "", result.get("vertices", ""), f"{wall:.1f}",
         f"{user + system:.1f}", result.get("states_judged", "")]
finished = "largest_opening_m" in result
cells += [f"{1e3 * result['largest_opening_m']:.2f}", f"{1e2 * result['max_stretch']:.1f}"] if finished else ["", ""]
csv.writer(sys.stdout, lineterminator="\n").writerow(cells + [result.get("verdict", f"no result, exit code {code}")])
PYTHON
}

patterns=()
for pattern in "$@"; do
  if [ -d "$pattern" ]; then patterns+=("$pattern"/*.json); else patterns+=("$pattern"); fi
done
status=0
TIMEFORMAT='%R %U %S'
echo "pattern,panels,vertices,wall_s,cpu_s,states,opening_mm,stretch_percent,verdict"
for pattern in "${patterns[@]}"; do
  name=$(basename "$pattern" .json) code=0
  mkdir -p "$out"
  rm -rf "${out:?}/$name"
  { time timeout "${LIMIT:-600}" "$program" dress "$pattern" "$body" --resolution "$resolution" --threads "${THREADS:-0}" \
    --out "$out/$name" >"$out/$name.log" 2>&1; } 2>"$out/$name.times" || code=$?
  if [ "$code" -ne 0 ]; then status=1; fi
  row "$name" "$code" "$(cat "$out/$name.times")"
  rm "$out/$name.times"
done
exit "$status"
