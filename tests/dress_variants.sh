#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# dress_variants.sh SOURCE PROGRAM: variants of sewing patterns (scripts/dress_variants.py) are the same for the same seed, change
# edges by at most 15 %, and are patterns that PROGRAM reads; --results counts the garments of a batch.
set -euo pipefail

source=$1 program=$2
script=$source/scripts/dress_variants.py
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "dress_variants.sh: $1" >&2; exit 1; }

make() { python3 "$script" --count 10 --seed "$2" --up z --out "$folder/$1" "$source/data/patterns"; }
make first 1
make again 1
make other 2
diff -r "$folder/first" "$folder/again" || fail "the same seed makes other variants"
diff -qr "$folder/first" "$folder/other" >/dev/null && fail "another seed makes the same variants"
[ "$(grep -vc '^#' "$folder/first/list.txt")" = 10 ] || fail "the list has not 10 lines"

python3 - "$source/data/patterns" "$folder/first" <<'PYTHON' || fail "an edge is changed too much, or none is"
import glob, json, math, os, sys

def chords(file):
    panels = json.load(open(file))["pattern"]["panels"]
    return [math.dist(p["vertices"][e["endpoints"][0]], p["vertices"][e["endpoints"][1]])
            for p in panels.values() for e in p["edges"]]

largest = []
for file in glob.glob(os.path.join(sys.argv[2], "*.json")):
    before = chords(os.path.join(sys.argv[1], os.path.basename(file)[:-8] + ".json"))
    largest.append(max(abs(b / a - 1.0) for a, b in zip(before, chords(file))))
sys.exit(not (len(largest) == 10 and max(largest) < 0.1501 and min(largest) > 0.03))
PYTHON

# Read as patterns: the time for a garment ends before its seams close, which is exit code 1 and not 2.
for name in $(grep -v '^#' "$folder/first/list.txt"); do
  code=0
  "$program" dress "$folder/first/$name" "$source/data/bodies/mannequin_arms_out.ply" --up z --resolution 0.05 --budget 0.001 \
    --no-pictures --out "$folder/out" >"$folder/log" 2>&1 || code=$?
  [ "$code" = 1 ] || { cat "$folder/log"; fail "$name is not read, exit code $code"; }
done

result() { mkdir -p "$folder/batch/$1" && echo "$2" >"$folder/batch/$1/result.json"; }
result a '{"dress": "finished", "clean": true, "sewn": true, "good": true, "verdict": "good"}'
result b '{"dress": "unfinished"}'
python3 "$script" --results "$folder/batch" | grep -q "garments 1, finished 1, clean 1, sewn 1, good 1" || fail "wrong counts"
result c '{"dress": "failed", "good": false, "verdict": "stitch 3 does not close"}'
code=0
python3 "$script" --results "$folder/batch" >"$folder/log" || code=$?
[ "$code" = 1 ] || fail "a failed garment of two has exit code $code"
grep -q "c: not finished; stitch 3 does not close" "$folder/log" || fail "the failed garment is not named"
echo "dress_variants.sh: all checks passed"
