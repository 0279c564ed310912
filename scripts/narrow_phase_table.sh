#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# narrow_phase_table.sh FOLDER [OPTION OF selvedge ccd]...: runs every narrow phase of the build on all query files in
# FOLDER and writes the tables into docs/narrow_phase.md, between its markers: all queries of a kind together, then
# each family (folder in FOLDER) alone. Builds the program first, unless SELVEDGE_PROGRAM names one.
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

table=$(mktemp)
trap 'rm -f "$table" "$table.page"' EXIT
processor=$(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1)
{
  echo
  echo "Measured $(date +%Y-%m-%d) on ${processor:-an unnamed processor}, one thread, by \`scripts/narrow_phase_table.sh\`."
  for merge in kind family; do
    echo
    "$program" ccd "$folder" --narrow-phase all --markdown --merge "$merge" "$@"
  done
  echo
} >"$table"

page=$root/docs/narrow_phase.md
awk -v table="$table" '
  /<!-- end of the tables -->/ { inside = 0 }
  !inside { print }
  /<!-- tables by scripts\/narrow_phase_table.sh -->/ {
    inside = 1
    while ((getline line < table) > 0) print line
  }' "$page" >"$table.page"
cat "$table.page" >"$page"
echo "written: $page"
