#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# check_consumer.sh [BUILD_DIR]: builds tests/consumer, somebody else's program, in the two ways others use selvedge,
# and, in the first way, compiles every installed header alone.
#   find_package      from an installation of BUILD_DIR (build/release) in a fresh prefix
#   add_subdirectory  with nothing but Eigen and oneTBB switched on
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD
build=$(realpath "${1:-build/release}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
generator=()
if command -v ninja >/dev/null; then generator=(-G Ninja); fi
consume() {
  local way=$1
  shift
  scripts/quietly.sh cmake -S tests/consumer -B "$work/$way" "${generator[@]}" -DCMAKE_BUILD_TYPE=Release "$@"
  scripts/quietly.sh cmake --build "$work/$way" --parallel
  "$work/$way/consumer" | sed "s/^/$way: /"
}

scripts/quietly.sh cmake --install "$build" --prefix "$work/prefix"
# Only these packages may be looked for: a consumer of the detectors has neither JSON nor assimp.
consume find_package -DCMAKE_PREFIX_PATH="$work/prefix" -DSELVEDGE_FROM=package \
  -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON -DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON -DCMAKE_DISABLE_FIND_PACKAGE_assimp=ON
consume add_subdirectory -DSELVEDGE_FROM="$root" \
  -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON -DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON -DCMAKE_DISABLE_FIND_PACKAGE_assimp=ON

"$work/prefix/bin/selvedge" list >/dev/null
echo "$(find "$work/prefix/include" -name '*.h' | wc -l) installed headers, each compiles alone"
