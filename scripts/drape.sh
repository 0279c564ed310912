#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# drape.sh [SCENE.json]: installs missing packages, builds the program, drapes the cloth of the scene
# (data/scenes/cloth_on_sphere.json), checks the result and prints where the pictures are. Exits with 0 only if no
# surface passed through another.
set -euo pipefail

if [ $# -gt 1 ] || [[ "${1:-}" == -* ]]; then
  echo "usage: scripts/drape.sh [SCENE.json]" >&2
  exit 2
fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
scene=$(realpath -m "${1:-$root/data/scenes/cloth_on_sphere.json}")
if [ ! -f "$scene" ]; then
  echo "drape.sh: no scene file '${1:-$scene}'; the scenes that come with selvedge are in data/scenes" >&2
  exit 2
fi
cd "$root"
started=$SECONDS
packages=lean
# assimp reads bodies in these formats; the program does not need it otherwise.
if grep -qiE '\.(stl|dae|fbx|gltf|glb|3ds|blend|x3d|lwo)"' "$scene"; then packages=meshes; fi
scripts/install_dependencies.sh "$packages"
# We may not redistribute Debian's test meshes. Scenes that use them refer to data/fetched/.
if grep -q '"\.\./fetched/' "$scene"; then scripts/quietly.sh scripts/fetch_bodies.sh; fi

# scripts/test.sh also builds in build/release, so each script reuses the build of the other.
build=build/release
configure=(cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_UNITY=ON)
if [ ! -f "$build/CMakeCache.txt" ] && command -v ninja >/dev/null; then configure+=(-G Ninja); fi
echo "Building the program (the first time about five minutes on two idle cores)"
scripts/quietly.sh "${configure[@]}"
scripts/quietly.sh cmake --build "$build" --target selvedge_program --parallel "$(nproc)"
selvedge=$build/apps/selvedge
echo "Built after $((SECONDS - started)) s"

name=$(basename "$scene" .json)
out=out/$name
# Remove the old result, so that frames of an earlier, longer run do not mix with frames of this one.
rm -rf "$out"
"$selvedge" run "$scene" --out "$out" --overwrite

cloth=$(find "$out/frames" -name 'cloth_*.ply' | sort | tail -n 1)
bodies=$(find "$out/frames" -name 'bodies_*.ply' | sort | tail -n 1)
check=("$selvedge" check "$cloth" --json)
if [ -n "$bodies" ]; then check+=(--against "$bodies"); fi
# Exit code 1 means that the check found a fault; the summary reports it.
"${check[@]}" >"$out/check.json" || [ $? -eq 1 ]
"$selvedge" render "$out" >/dev/null

# Reads one number or word of a JSON file with one value per name. That is enough for result.json and check.json.
value() { grep -o "\"$2\" *: *[^,}]*" "$1" | head -n 1 | sed 's/^[^:]*: *//; s/[" ]//g'; }
clean=$(value "$out/result.json" clean)
steps=$(value "$out/result.json" steps)
stretch=$(value "$out/result.json" max_stretch)
crossing_self=$(value "$out/check.json" self_intersections)
crossing_body=$(value "$out/check.json" body_intersections)
inside=$(value "$out/check.json" inside_vertices)

echo
echo "Pictures      $root/$out/pictures"
find "$out/pictures" -name '*.png' | sort | tail -n 3 | sed 's/^/              /'
echo "Result        $root/$out/result.json"
awk -v s="$stretch" 'BEGIN { printf "Stretch       at most %.1f %%\n", 100 * s }'
echo "Last frame    $crossing_self self-intersections, $crossing_body body intersections, $inside vertices inside (exact check)"
if [ "$clean $crossing_self $crossing_body $inside" != "true 0 0 0" ]; then
  echo "NOT CLEAN     clean: $clean in result.json; see $out/result.json and $out/check.json" >&2
  exit 1
fi
echo "Clean         nothing passed through anything: 0 intersections in $steps accepted steps and on the paths between them"
echo "Took          $((SECONDS - started)) s in all"
