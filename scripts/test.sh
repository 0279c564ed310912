#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# test.sh [--quick] [CMAKE OPTIONS]: installs missing packages, builds everything but the benchmarks and runs every test: the unit,
# physics and program tests (CTest), the format check of the sources, and the consumers of the library. Prints how many
# tests ran. Tests that need data from outside the repository are skipped, and counted as skipped, if the data is absent.
# With --quick it omits the tests with the label `slow` and the consumers, for work in between.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
started=$SECONDS
quick=no
if [ "${1:-}" = --quick ]; then quick=yes; shift; fi
scripts/install_dependencies.sh test

build=build/release
configure=(cmake --preset release -DSELVEDGE_UNITY=ON)
if [ ! -f "$build/CMakeCache.txt" ] && command -v ninja >/dev/null; then configure+=(-G Ninja); fi

echo "Building (the first time about 10 minutes on two idle cores)"
scripts/quietly.sh "${configure[@]}" "$@"
scripts/quietly.sh cmake --build "$build" --parallel "$(nproc)"
echo "Built after $((SECONDS - started)) s"
if [ "$quick" = yes ]; then
  scripts/run_ctest.sh "$build" --label-exclude slow
  scripts/check_format.sh
  echo "The quick tests passed in $((SECONDS - started)) s; scripts/test.sh runs all"
  exit
fi
scripts/run_ctest.sh "$build"
scripts/check_format.sh
echo "Consumers"
scripts/check_consumer.sh "$build"
echo "Everything passed in $((SECONDS - started)) s"
