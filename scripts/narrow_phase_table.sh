#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# narrow_phase_table.sh FOLDER [OPTION OF selvedge ccd]...: runs every narrow phase of the build on all query files in
# FOLDER and writes docs/lab/tables/narrow_phase.csv: all queries of a kind together, then each family (subfolder of FOLDER)
# alone. Also writes the rows of all queries into docs/lab/narrow_phase.md, between its markers. Builds the program first,
# unless SELVEDGE_PROGRAM names one.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [ $# -eq 0 ] || [ ! -d "$1" ]; then
  echo "usage: scripts/narrow_phase_table.sh FOLDER [OPTION OF selvedge ccd]..., FOLDER with query files; 'selvedge run" \
    "SCENE --record FOLDER' makes some" >&2
  exit 2
fi
folder=$1
shift

program=${SELVEDGE_PROGRAM:-}
if [ -z "$program" ]; then
  cmake --preset release -S "$root" >/dev/null
  cmake --build --preset release --target selvedge_program >/dev/null
  program=$root/build/release/apps/selvedge
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
processor=$(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1)
for merge in kind family; do
  "$program" ccd "$folder" --narrow-phase all --markdown --merge "$merge" "$@"
done >"$work/tables.md"

# Merges all tables into one: a heading such as "### stress: 300 edge_edge queries, 152 collide" becomes four columns.
csv=$root/docs/lab/tables/narrow_phase.csv
mkdir -p "${csv%/*}"
awk '
  /^### / {
    split(substr($0, 5), part, ": ")
    name = part[1]
    split(part[2], word, " ")
    next
  }
  /^\| *---/ { next }
  /^\| *\|/ {
    if (!seen++) { sub(/^\| *\|/, "| queries | kind | count | collide | method |"); print }
    next
  }
  /^\|/ { print "| " name " | " word[2] " | " word[1] " | " word[4] " " $0 }' "$work/tables.md" |
  "$root/scripts/table_to_csv.sh" >"$csv"

# Columns of the CSV: 1 queries, 2 kind, 3 count, 4 collide, 5 method, 6 misses, 7 false, 8 late, 10 mean us.
{
  echo
  awk -F, '
    $1 != "all" { next }
    { cells = $6 " | " $7 " | " $8 " | " sprintf("%.3f", $10) }
    $2 == "edge_edge" { edges = $3 " edge-edge queries (" $4 " collide)"; edge[$5] = cells }
    $2 == "point_triangle" { points = $3 " point-triangle queries (" $4 " collide)"; point[$5] = cells; name[++n] = $5 }
    END {
      print "Left: " edges ". Right: " points ".\n"
      print "| method | misses | false | late | mean us | misses | false | late | mean us |"
      print "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
      for (i = 1; i <= n; ++i) print "| `" name[i] "` | " edge[name[i]] " | " point[name[i]] " |"
    }' "$csv"
  echo
  echo "All rows: [docs/lab/tables/narrow_phase.csv](tables/narrow_phase.csv). Measured $(date +%Y-%m-%d) on" \
    "${processor:-an unnamed processor}, one thread."
  echo
} >"$work/short.md"

page=$root/docs/lab/narrow_phase.md
awk -v table="$work/short.md" '
  /<!-- end of the table -->/ { inside = 0 }
  !inside { print }
  /<!-- table by scripts\/narrow_phase_table.sh -->/ {
    inside = 1
    while ((getline line < table) > 0) print line
  }' "$page" >"$work/page.md"
cat "$work/page.md" >"$page"
echo "written: $csv and $page"
