#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# response_table.sh [OPTION OF bench_response]...: measures every response on scenes with closed forms, and the survey's
# claims on them, and writes the tables into docs/response.md, between its markers. Builds the program first, unless
# SELVEDGE_BENCH names its folder.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

bench=${SELVEDGE_BENCH:-}
if [ -z "$bench" ]; then
  cmake --preset release -S "$root" >/dev/null
  cmake --build --preset release --target bench_response >/dev/null
  bench=$root/build/release/bench
fi

page=$root/docs/response.md
table=$(mktemp)
trap 'rm -f "$table" "$table.page"' EXIT
processor=$(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1)

{
  echo
  echo "Measured $(date +%Y-%m-%d) on ${processor:-an unnamed processor}, one thread, seconds of processor time, by" \
    "\`bench_response${*:+ $*}\`."
  echo
  "$bench/bench_response" "$@"
  echo
} >"$table"

awk -v table="$table" '
  /<!-- end of tables -->/ { inside = 0 }
  !inside { print }
  /<!-- tables by scripts\/response_table.sh -->/ {
    inside = 1
    while ((getline line < table) > 0) print line
  }' "$page" >"$table.page"
cat "$table.page" >"$page"
echo "written: $page"
