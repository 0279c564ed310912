#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# make_walk.sh [FOLDER] [--faces N] [--seconds S] [--arms DEGREES]: writes a walking mannequin as a mesh sequence, a poncho
# and the scene walking_mannequin.json into FOLDER (out/walk), and prints how to run and check the scene. --arms: it begins
# with straight arms at this angle, as `selvedge dress` needs them. The repository does not contain these files, because a
# walk of 3 s takes 25 MB. Builds the program first, unless SELVEDGE_WALK names one.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
folder=$root/out/walk
seconds=3
options=()
while [ $# -gt 0 ]; do
  case $1 in
    --faces | --seconds | --arms)
      [ $# -ge 2 ] || { echo "make_walk.sh: $1 needs a number" >&2; exit 2; }
      options+=("$1" "$2")
      if [ "$1" = --seconds ]; then seconds=$2; fi
      shift
      ;;
    -*) echo "usage: scripts/make_walk.sh [FOLDER] [--faces N] [--seconds S] [--arms DEGREES]" >&2; exit 2 ;;
    *) folder=$(realpath -m "$1") ;;
  esac
  shift
done

walk=${SELVEDGE_WALK:-}
if [ -z "$walk" ]; then
  cd "$root"
  scripts/install_dependencies.sh lean
  build=build/release
  configure=(cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_UNITY=ON)
  if [ ! -f "$build/CMakeCache.txt" ] && command -v ninja >/dev/null; then configure+=(-G Ninja); fi
  scripts/quietly.sh "${configure[@]}"
  scripts/quietly.sh cmake --build "$build" --target selvedge-walk selvedge_program --parallel "$(nproc)"
  walk=$build/data/makers/selvedge-walk
fi

mkdir -p "$folder"
rm -f "$folder"/walk_*.ply
"$walk" "$folder" "${options[@]}"
frames=$(awk -v s="$seconds" 'BEGIN { printf "%d", s * 60 }')
cat >"$folder/walking_mannequin.json" <<SCENE
{
  "name": "walking_mannequin",
  "description": "The mannequin stands for half a second, then walks, in a poncho.",
  "geometry": [{"name": "poncho", "mesh": "poncho.ply", "transformation": {"translation": [0, 0.005, 1.545]}}],
  "materials": {"default": {"density": 0.2, "bending_stiffness": 1e-5}},
  "obstacles": [{"name": "mannequin", "sequence": {"files": "walk_####.ply", "fps": 30}, "friction": 0.4}],
  "air": {"normal_drag": 1, "viscous_drag": 0.1},
  "time": {"frames": $frames, "fps": 60},
  "output": {"camera": {"eye": [3.4, -5.2, 2], "target": [0, -1.2, 0.9], "field_of_view": 36}}
}
SCENE
echo "Scene         $folder/walking_mannequin.json"
echo "Run it        build/release/apps/selvedge run $folder/walking_mannequin.json --every-step --out out/walking_mannequin"
echo "Judge it      build/release/apps/selvedge check out/walking_mannequin"
