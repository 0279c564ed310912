#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# peers.sh FOLDER [CELLS [FRAMES [SCENE...]]]: moves the same cloth with selvedge, Blender's cloth, Bullet's soft bodies and
# MuJoCo's flexes, with and without its flag ipc. In ball, edge, incline and body, a sheet falls on a ball, on the edge of a
# box, on an incline and on the mannequin. In jaws, two boxes close on a strip, a load hangs from it and its handle lets go:
# who holds? In hit, a ball of 5 m/s hits a flag: who stretches? In floor and seam, a sheet slides without friction over one
# box and over two flush ones: who stops? `selvedge check` judges every frame. Writes FOLDER/peers.md and FOLDER/peers.json:
# crossings, deepest penetration, stretch, friction against Coulomb's law, how far the strip sinks, how far the seam shortens
# the slide, processor seconds a frame, versions, and a picture of the worst frame of each. Every program has one thread.
# Programs that are not installed are named and left out. Uses the program of build/release, unless SELVEDGE_PROGRAM names one.
# MuJoCo is the npm package @mujoco/mujoco, in node_modules of FOLDER or of the folder that SELVEDGE_MUJOCO names:
# npm install --prefix FOLDER @mujoco/mujoco@3.14.0
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
all=(ball edge incline body jaws hit floor seam)
if [ $# -lt 1 ]; then
  echo "usage: bench/peers/peers.sh FOLDER [CELLS (default 30) [FRAMES (default 60) [SCENE... (default ${all[*]})]]]" >&2
  exit 2
fi
mkdir -p "$1"
out=$(cd "$1" && pwd)
cells=${2:-30} frames=${3:-60}
scenes=("${@:4}")
[ ${#scenes[@]} -gt 0 ] || scenes=("${all[@]}")
for scene in "${scenes[@]}"; do
  [[ " ${all[*]} " == *" $scene "* ]] || { echo "$scene is none of ${all[*]}" >&2; exit 2; }
done
program=${SELVEDGE_PROGRAM:-$root/build/release/apps/selvedge}
[ -x "$program" ] || { echo "$program does not exist; build it or set SELVEDGE_PROGRAM" >&2; exit 2; }
command -v python3 >/dev/null || { echo "python3 is not installed" >&2; exit 2; }

python3 "$root/bench/peers/peer_prepare.py" "$out" "$cells" "$frames"
: >"$out/missing.txt"

for scene in "${scenes[@]}"; do
  rm -rf "$out/$scene"/{selvedge,blender,bullet,mujoco,mujoco_ipc} "$out/$scene"/*_worst*
done
rm -f "$out"/peers.{md,json}

bullet=
if pkg-config --exists bullet 2>/dev/null && command -v g++ >/dev/null; then
  bullet=$out/peer_bullet
  # shellcheck disable=SC2046
  g++ -O2 -o "$bullet" "$root/bench/peers/peer_bullet.cpp" $(pkg-config --cflags bullet) -lBulletSoftBody \
    -lBulletDynamics -lBulletCollision -lLinearMath
else
  echo "Bullet: not installed (libbullet-dev, g++, pkg-config)" >>"$out/missing.txt"
fi
blender=
if command -v blender >/dev/null; then blender=yes; else echo "Blender: not installed" >>"$out/missing.txt"; fi
mujoco=${SELVEDGE_MUJOCO:-$out}/node_modules/@mujoco/mujoco
if ! command -v node >/dev/null || [ ! -f "$mujoco/mujoco.js" ]; then
  echo "MuJoCo: not installed (node; npm install --prefix $out @mujoco/mujoco@3.14.0)" >>"$out/missing.txt"
  mujoco=
fi

# run_peer NAME LOG COMMAND...: runs a program on $scene.
run_peer() {
  local name=$1 log=$2
  shift 2
  echo "$scene: $name"
  "$@" >"$log" 2>&1 || echo "$name: run of $scene failed, see $log" >>"$out/missing.txt"
}

TIMEFORMAT='%U %S'
for scene in "${scenes[@]}"; do
  folder=$out/$scene
  { time run_peer selvedge "$folder/selvedge.log" "$program" run "$folder/scene.json" --out "$folder/selvedge" \
      --threads 1 --overwrite --no-pictures; } 2>"$folder/selvedge.seconds"
  if [ -n "$blender" ]; then
    run_peer Blender "$folder/blender.log" blender -b --factory-startup -t 1 --python-exit-code 1 \
      --python "$root/bench/peers/peer_blender.py" -- "$folder"
  fi
  if [ -n "$bullet" ]; then run_peer Bullet "$folder/bullet.log" "$bullet" "$folder"; fi
  if [ -n "$mujoco" ]; then
    for mode in mujoco mujoco_ipc; do
      run_peer "$mode" "$folder/$mode.log" node "$root/bench/peers/peer_mujoco.mjs" "$mujoco" "$folder" "$mode"
    done
  fi
done
python3 "$root/bench/peers/peer_judge.py" "$out" "$program" "${scenes[@]}"
echo "$out/peers.md"
