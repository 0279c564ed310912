#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# extreme_table.sh [--responses] [OPTION OF selvedge stability]...: runs all extreme cases (data/extreme) and writes
# docs/tables/extreme_cases.csv. With --responses it runs every case with four responses and writes one column for each
# to docs/tables/extreme_responses.csv. SELVEDGE names the program (default: build/release/apps/selvedge). The table
# includes failed cases; the script then exits with 1.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=${SELVEDGE:-build/release/apps/selvedge}
responses=
if [ "${1:-}" = --responses ]; then
  responses=contact_force,impulse,penalty,position_velocity
  shift
fi
printed=$(mktemp)
trap 'rm -f "$printed"' EXIT
status=0
"$program" stability data/extreme ${responses:+--responses "$responses"} "$@" >"$printed" || status=$?
if [ "$status" -gt 1 ]; then exit "$status"; fi

# Rows have the form "| `case` | answer | ... |"; the program writes "/" for a "|" within a cell.
quote='function quote(cell) { gsub(/`/, "", cell); if (cell ~ /[",]/) { gsub(/"/, "\"\"", cell); cell = "\"" cell "\"" } return cell }'
if [ -z "$responses" ]; then
  awk -F ' [|] ' "$quote"'
    BEGIN { print "case,answer,detail,stretch_percent,crossings,worst_speed_m_s,energy_ratio,energy_given_mJ,wall_s" }
    /^[|] `/ {
      sub(/^[|] /, ""); sub(/ [|]$/, "")
      for (i = 1; i <= NF; ++i) printf "%s%s", quote($i), i < NF ? "," : "\n"
    }' "$printed" >docs/tables/extreme_cases.csv
else
  awk -F ' [|] ' -v names="$responses" "$quote"'
    BEGIN { print "case," names; count = split(names, response, ",") }
    /^[|] `/ {
      sub(/^[|] /, "")
      if (!($1 in known)) { known[$1]; cases[++rows] = $1 }
      answer[$1, $2] = $3 ($4 == "" ? "" : ": " $4)
    }
    END {
      for (r = 1; r <= rows; ++r) {
        printf "%s", quote(cases[r])
        for (k = 1; k <= count; ++k) printf ",%s", quote(answer[cases[r], response[k]])
        print ""
      }
    }' "$printed" >docs/tables/extreme_responses.csv
fi
tail -n 1 "$printed"
exit "$status"
