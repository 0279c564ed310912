#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# mutants.sh [--count N] [--seed S] [--modules A,B] [--files N] [--longest SECONDS] [--seconds SECONDS] [--table FILE] [--again TABLE]:
# mutation testing. Draws N changes (default 200) from the sources of the modules, makes one at a time, and runs the
# tests that reach it, the fastest first, until one fails. `--again TABLE --table TABLE` tries those changes of a table
# again that no test noticed, and writes what becomes of them. Needs a release build by Ninja (BUILD, default build/release)
# with its test programs, and changes nothing in it. `tests/mutation/mutants.py --help` explains the options and the changes.
#
# All changes go into one copy of the sources, each behind a switch (tests/mutants_lib.sh), so a source is compiled
# once. Changes that do not compile are dropped and counted. JOBS (default: processors) limits the compilers.
# shellcheck disable=SC2034,SC2153
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit
SOURCE=$PWD
BUILD=$(realpath "${BUILD:-build/release}")
INCLUDE=$BUILD/include
WORK=${WORK:-$BUILD/mutants_drawn}
CXX=${CXX:-c++}
FLAGS=
# shellcheck source=tests/mutants_lib.sh
source tests/mutants_lib.sh
mutants=(python3 tests/mutation/mutants.py)

"${mutants[@]}" draw "$WORK" "$BUILD" "$@" || exit
FLAGS=@$WORK/flags  # a file, because definitions hold quotation marks
precompile "$WORK/headers.h" "-O1 -fPIC -w" || exit

# compile_unit UNIT: its object. Drops the changes in the lines that the compiler complains of, and tries again.
compile_unit() {
  local unit=$1
  until compile -O1 -fPIC -w -fmax-errors=0 -include "$WORK/headers.h" -c "$WORK/$unit.cpp" -o "$WORK/$unit.o" \
    2>"$WORK/$unit.log"; do
    "${mutants[@]}" drop "$WORK" "$unit" || return 1
  done
}
while read -r unit; do try compile_unit "$unit"; done <"$WORK/units"
try compile -O1 -fPIC -include "$WORK/headers.h" -c tests/mutation/mutants_reached.cpp -o "$WORK/reached.o"
tried || { echo "mutants.sh: the changed sources do not compile" >&2; exit 1; }

# Test programs with the changed sources of the libraries that they link.
while read -r program; do
  [ -f "$BUILD/tests/$program" ] || continue
  command=$(ninja -C "$BUILD" -t commands "tests/$program" | grep -F -- " -o tests/$program ")
  objects=("$WORK/reached.o")
  while read -r unit; do
    [[ $command != *"libselvedge_${unit%_unit}.a"* ]] || objects+=("$WORK/$unit.o")
  done <"$WORK/units"
  [ ${#objects[@]} -gt 1 ] || continue
  try link_again "$program" "${objects[@]}"
done <"$WORK/programs"
tried || { echo "mutants.sh: the test programs do not link" >&2; exit 1; }
"${mutants[@]}" run "$WORK" "$BUILD" "$@"
