#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# check_consumer.sh [BUILD_DIR]: builds tests/consumer, an example of a user's project, in each way that users can use
# selvedge:
#   find_package      from an installation of BUILD_DIR (build/release) in a fresh prefix. The detectors may look only
#                     for Eigen and oneTBB; scene and simulation must not look for CLI11, PNG or GMP. Every installed
#                     target is also linked alone, and every installed header compiled alone, and all of them
#                     in one source.
#   add_subdirectory  broad and narrow phase, with Eigen and oneTBB only; all other targets are only configured
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD
build=$(realpath "${1:-build/release}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
generator=()
if command -v ninja >/dev/null; then generator=(-G Ninja); fi
without() { printf -- '-DCMAKE_DISABLE_FIND_PACKAGE_%s=ON\n' "$@"; }

configure() {
  local way=$1
  shift
  # Nothing is measured here, so nothing is optimised.
  scripts/quietly.sh cmake -S tests/consumer -B "$work/$way" "${generator[@]}" -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_UNITY=ON \
    -DCMAKE_CXX_FLAGS_RELEASE=-O0 "$@"
}

# consume WAY OPTIONS...: configures, builds and runs the programs.
consume() {
  local way=$1 count=0
  configure "$@"
  scripts/quietly.sh cmake --build "$work/$way" --parallel "$(nproc)"
  if [ -x "$work/$way/consumer" ]; then "$work/$way/consumer" | sed "s/^/$way: /"; fi
  for program in "$work/$way"/alone_*; do
    [ -x "$program" ] && [ -f "$program" ] || continue
    (cd "$work/$way" && "$program") || { echo "$way: $(basename "$program") failed" >&2; exit 1; }
    count=$((count + 1))
  done
  if [ "$count" -gt 0 ]; then echo "$way: $count targets, each linked alone"; fi
}

# shellcheck disable=SC2046
{
  scripts/quietly.sh cmake --install "$build" --prefix "$work/prefix"
  package=(-DCMAKE_PREFIX_PATH="$work/prefix" -DSELVEDGE_FROM=package)
  detectors=($(without nlohmann_json fmt assimp PNG CLI11 pagmo))
  simulation=($(without PNG CLI11 pagmo assimp))
}
# The packages of each way are checked when it is configured, so only one way links every target.
consume detectors "${package[@]}" "${detectors[@]}" -DCONSUMER_ALONE=OFF
configure simulation "${package[@]}" "${simulation[@]}" "-DCONSUMER_COMPONENTS=scene;simulation"
consume everything "${package[@]}" -DCONSUMER_COMPONENTS=all -DCONSUMER_HEADERS=ON
for program in "$work"/everything/alone_{scene,simulation}; do
  if ldd "$program" | grep -E 'libgmp|libpng'; then
    echo "$(basename "$program") loads libraries that stepping cloth does not need" >&2
    exit 1
  fi
done
consume add_subdirectory -DSELVEDGE_FROM="$root" "${detectors[@]}" -DCONSUMER_ALONE=OFF
configure subdirectory_simulation -DSELVEDGE_FROM="$root" "${simulation[@]}" -DSELVEDGE_SIMULATION=ON \
  "-DCONSUMER_COMPONENTS=scene;simulation"

"$work/prefix/bin/selvedge" list >/dev/null
echo "$(find "$work/prefix/include" -name '*.h' | wc -l) installed headers, each compiles alone"
