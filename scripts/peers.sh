#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# peers.sh FOLDER [CELLS] [FRAMES]: drapes the same sheet with selvedge, Blender's cloth and Bullet's soft bodies on the
# same ball, on the edge of the same box and on the same incline, lets `selvedge check` judge every frame, and writes
# FOLDER/peers.md and FOLDER/peers.json: crossings, deepest penetration, stretch, friction against Coulomb's law, seconds
# a frame, and a picture of the worst frame of each. Programs that are not installed are named and left out. Uses the
# program of build/release, unless SELVEDGE_PROGRAM names one.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [ $# -lt 1 ] || [ $# -gt 3 ]; then
  echo "usage: scripts/peers.sh FOLDER [CELLS (default 30)] [FRAMES (default 60)]" >&2
  exit 2
fi
mkdir -p "$1"
out=$(cd "$1" && pwd)
cells=${2:-30} frames=${3:-60}
program=${SELVEDGE_PROGRAM:-$root/build/release/apps/selvedge}
[ -x "$program" ] || { echo "$program does not exist; build it or set SELVEDGE_PROGRAM" >&2; exit 2; }
for needed in python3; do
  command -v "$needed" >/dev/null || { echo "$needed is not installed" >&2; exit 2; }
done

python3 "$root/scripts/peer_prepare.py" "$out" "$cells" "$frames"
rm -f "$out/missing.txt"
touch "$out/missing.txt"

bullet=
if pkg-config --exists bullet 2>/dev/null && command -v g++ >/dev/null; then
  bullet=$out/peer_bullet
  # shellcheck disable=SC2046
  g++ -O2 -o "$bullet" "$root/scripts/peer_bullet.cpp" $(pkg-config --cflags bullet) -lBulletSoftBody \
    -lBulletDynamics -lBulletCollision -lLinearMath
else
  echo "Bullet: not installed (libbullet-dev, g++, pkg-config)" >>"$out/missing.txt"
fi
command -v blender >/dev/null || echo "Blender: not installed" >>"$out/missing.txt"

for scene in ball edge incline; do
  folder=$out/$scene
  echo "$scene: selvedge"
  "$program" run "$folder/scene.json" --out "$folder/selvedge" --threads 1 --overwrite >"$folder/selvedge.log" 2>&1 ||
    echo "selvedge: run of $scene failed, see $folder/selvedge.log" >>"$out/missing.txt"
  if command -v blender >/dev/null; then
    echo "$scene: Blender"
    blender -b --factory-startup -t 1 --python-exit-code 1 --python "$root/scripts/peer_blender.py" -- "$folder" \
      >"$folder/blender.log" 2>&1 || echo "Blender: run of $scene failed, see $folder/blender.log" >>"$out/missing.txt"
  fi
  if [ -n "$bullet" ]; then
    echo "$scene: Bullet"
    "$bullet" "$folder" "$scene" "$cells" "$frames" >"$folder/bullet.log" 2>&1 ||
      echo "Bullet: run of $scene failed, see $folder/bullet.log" >>"$out/missing.txt"
  fi
done
python3 "$root/scripts/peer_judge.py" "$out" "$program"
echo "$out/peers.md"
