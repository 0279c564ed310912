#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# response_table.sh [OPTION OF bench_response]...: measures every response on scenes with closed forms, and the survey's
# claims on responses. Writes docs/lab/tables/response.csv, a table for each claim (response_c9.csv and so on), and a short
# table into docs/lab/response.md, between its markers. Prints the sentences that are not part of a table. Builds the
# program first, unless SELVEDGE_BENCH names its folder.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

bench=${SELVEDGE_BENCH:-}
if [ -z "$bench" ]; then
  cmake --preset release -DSELVEDGE_BENCH=ON -S "$root" >/dev/null
  cmake --build --preset release --target selvedge_bench >/dev/null
  bench=$root/build/release/bench
fi

tables=$root/docs/lab/tables
page=$root/docs/lab/response.md
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
processor=$(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1)

# The table before the first heading becomes response.csv; a heading such as "### C9: ..." starts response_c9.csv.
"$bench/bench" response "$@" | tee "$work/all.md" | awk -v work="$work" '
  BEGIN { name = "response" }
  /^### C[0-9]+:/ { name = "response_" tolower(substr($2, 1, length($2) - 1)); next }
  /^\|/ { print >(work "/" name ".table") }'
mkdir -p "$tables"
for table in "$work"/*.table; do
  name=$(basename "$table" .table)
  "$root/scripts/table_to_csv.sh" <"$table" >"$tables/$name.csv"
done
grep -v '^|' "$work/all.md" || true

# Cells of a row: 2 scene, 3 response, 4 seconds, 9 error, 13 RMS speed at the end.
if [ -f "$work/response.table" ]; then
  {
    echo
    echo "| response | slope slides, error | slope holds, mm/s | capstan holds, mm/s | ball, s | capstan, s | stack, s |" \
      "stack moves, mm/s |"
    echo "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
    awk -F' *[|] *' '
      $2 == "incline, slides" { name[++n] = $3; slides[$3] = $9 }
      $2 == "incline, sticks" { sub(/ mm\/s/, "", $9); holds[$3] = $9 }
      $2 == "capstan, holds" { sub(/ mm\/s/, "", $9); capstan[$3] = $9; capstan_s[$3] = $4 }
      $2 == "ball" { ball_s[$3] = $4 }
      $2 ~ /^stack/ { stack_s[$3] = $4; moves[$3] = $13 }
      END {
        for (i = 1; i <= n; ++i) {
          r = name[i]
          print "| `" r "` | " slides[r] " | " holds[r] " | " capstan[r] " | " ball_s[r] " | " capstan_s[r] " | " \
            stack_s[r] " | " moves[r] " |"
        }
      }' "$work/response.table"
    echo
    echo "All columns and scenes: [docs/lab/tables/response.csv](tables/response.csv), by \`bench response${*:+ $*}\`. Measured" \
      "$(date +%Y-%m-%d) on ${processor:-an unnamed processor}, one thread, seconds of processor time."
    echo
  } >"$work/short.md"
  awk -v table="$work/short.md" '
    /<!-- end of table -->/ { inside = 0 }
    !inside { print }
    /<!-- table by scripts\/response_table.sh -->/ {
      inside = 1
      while ((getline line < table) > 0) print line
    }' "$page" >"$work/page.md"
  cat "$work/page.md" >"$page"
fi
echo "written: $tables/response*.csv and $page"
