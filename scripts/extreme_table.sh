#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# extreme_table.sh [--responses | --integrators | --limiters] [OPTION OF selvedge stability]...: runs all extreme cases
# (data/extreme) and writes docs/lab/tables/extreme_cases.csv. With one of the families it runs every case with several
# methods of it and writes the cases on which they differ, one column for each, to docs/lab/tables/extreme_responses.csv,
# extreme_integrators.csv or extreme_limiters.csv. SELVEDGE names the program (default: build/release/apps/selvedge). The
# table includes failed cases; the script then exits with 1.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=${SELVEDGE:-build/release/apps/selvedge}
family= methods=
case ${1:-} in
  --responses) family=${1#--} methods=contact_force,impulse,penalty,position_velocity ;;
  --integrators) family=${1#--} methods=implicit_euler,bdf2,implicit_newton,imex,symplectic_euler,verlet ;;
  --limiters) family=${1#--} methods=none,position,velocity,han,bayraktar ;;
esac
if [ -n "$family" ]; then shift; fi
printed=$(mktemp)
trap 'rm -f "$printed"' EXIT
status=0
"$program" stability data/extreme ${family:+"--$family" "$methods"} "$@" >"$printed" || status=$?
if [ "$status" -gt 1 ]; then exit "$status"; fi

# Rows have the form "| `case` | answer | ... |"; the program writes "/" for a "|" within a cell.
quote='function quote(cell) { gsub(/`/, "", cell); if (cell ~ /[",]/) { gsub(/"/, "\"\"", cell); cell = "\"" cell "\"" } return cell }'
if [ -z "$family" ]; then
  awk -F ' [|] ' "$quote"'
    BEGIN { print "case,answer,detail,stretch_percent,crossings,worst_speed_m_s,energy_ratio,energy_given_mJ,wall_s" }
    /^[|] `/ {
      sub(/^[|] /, ""); sub(/ [|]$/, "")
      for (i = 1; i <= NF; ++i) printf "%s%s", quote($i), i < NF ? "," : "\n"
    }' "$printed" >docs/lab/tables/extreme_cases.csv
else
  awk -F ' [|] ' -v names="$methods" "$quote"'
    BEGIN { print "case," names; count = split(names, method, ",") }
    /^[|] `/ {
      sub(/^[|] /, "")
      if (!($1 in known)) { known[$1]; cases[++rows] = $1 }
      answer[$1, $2] = $3 ($4 == "" ? "" : ": " $4)
    }
    END {
      for (r = 1; r <= rows; ++r) {
        differs = 0
        for (k = 2; k <= count; ++k) differs += answer[cases[r], method[k]] != answer[cases[r], method[1]]
        if (!differs) continue
        printf "%s", quote(cases[r])
        for (k = 1; k <= count; ++k) printf ",%s", quote(answer[cases[r], method[k]])
        print ""
      }
    }' "$printed" >"docs/lab/tables/extreme_$family.csv"
fi
tail -n 1 "$printed"
exit "$status"
