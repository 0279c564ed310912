#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# test.sh [CMAKE OPTIONS]: installs what is missing, builds everything and runs every test: the unit, physics and
# program tests (CTest), the format of the sources, and the consumers of the library. Says how many tests ran.
# Tests that read data from outside the repository are skipped, and counted as skipped, where it is not there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
started=$SECONDS
scripts/install_dependencies.sh test

build=build/release
configure=(cmake --preset release)
if [ ! -f "$build/CMakeCache.txt" ] && command -v ninja >/dev/null; then configure+=(-G Ninja); fi

echo "Build (several minutes the first time)"
scripts/quietly.sh "${configure[@]}" "$@"
scripts/quietly.sh cmake --build "$build" --parallel
echo "Built after $((SECONDS - started)) s"
scripts/run_ctest.sh "$build"
scripts/check_format.sh
echo "Consumers"
scripts/check_consumer.sh "$build"
echo "Everything passed in $((SECONDS - started)) s"
