#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# without_packages.sh: compiles each source of the library that has parts for an optional package without any of them, as
# the build of a machine that has none does. CTest calls it with the environment below.
#
#   CXX, FLAGS  compiler and flags that the sources of the library need
#   SOURCE      root of the sources
#   INCLUDE     folder that holds selvedge/, a link to the sources
set -uo pipefail
cd "$SOURCE"
rooms=$(grep -oE '^[a-z/_]+' cmake/rooms.txt)
count=0 failed=0
# shellcheck disable=SC2086
for source in $(grep -lrE --include='*.cpp' '^#if.*SELVEDGE_(HAS|USE)_' $rooms | sort -u); do
  count=$((count + 1))
  "$CXX" -std=c++20 -fsyntax-only $FLAGS -I"$INCLUDE" "$source" || failed=$((failed + 1))
done
echo "$count sources, $failed do not compile"
[ "$count" -gt 3 ] && [ "$failed" = 0 ]
