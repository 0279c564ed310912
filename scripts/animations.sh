#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# animations.sh: makes short animations of extreme scenes for the documentation. It runs each scene, draws its frames and
# writes a small docs/images/NAME.gif with few colours. It installs nothing.
#
#   scripts/animations.sh [--program FILE] [--work FOLDER] [NAME...]
#
# NAME: twist, ring, stack, knot, pinch (default: all). If the folder already holds a run, the script only redraws it.
set -euo pipefail
cd "$(dirname "$0")/.."

program=build/release/apps/selvedge
work=out/animations
while [[ ${1-} == --* ]]; do
  case $1 in
    --program) program=$2 ;;
    --work) work=$2 ;;
    *)
      echo "animations.sh: there is no option $1" >&2
      exit 2
      ;;
  esac
  shift 2
done
for tool in ffmpeg "$program"; do
  command -v "$tool" >/dev/null || {
    echo "animations.sh: $tool is missing: ffmpeg is a package of that name, selvedge is built by cmake --build --preset release" >&2
    exit 2
  }
done

readonly most_bytes=250000 size=240x180 colours=32 pictures_a_second=10

declare -A scene=([twist]=s07_twist [ring]=s06_ring_5cm [stack]=s05_stack [knot]=knot [pinch]=pinch_and_go)
# Number of pictures per film. Scenes with large grey areas and little motion compress best.
declare -A pictures=([twist]=40 [ring]=36 [stack]=30 [knot]=36 [pinch]=30)

film() {
  local name=$1 run=$work/$1 out=docs/images/extreme_$1.gif
  if [[ ! -f $run/result.json ]]; then
    "$program" run "data/extreme/${scene[$name]}.json" --out "$run" --overwrite --no-pictures
  fi
  local frames step
  frames=$(find "$run/frames" -name '*.ply' | wc -l)
  step=$(((frames + pictures[$name] - 1) / pictures[$name]))
  rm -rf "$work/$name.pictures"
  "$program" render "$run" --frames "0:$((frames - 1)):$step" --size "$size" --out "$work/$name.pictures"
  ffmpeg -y -loglevel error -framerate "$pictures_a_second" -pattern_type glob \
    -i "$work/$name.pictures/*.png" \
    -vf "split[a][b];[a]palettegen=max_colors=$colours[p];[b][p]paletteuse=dither=none:diff_mode=rectangle" \
    "$out"
  local bytes
  bytes=$(stat -c %s "$out")
  echo "$out: $bytes bytes, every ${step}th of $frames frames"
  if ((bytes > most_bytes)); then
    echo "animations.sh: $out has more than $most_bytes bytes; take fewer pictures" >&2
    exit 1
  fi
}

mkdir -p "$work"
for name in "${@:-twist ring stack knot pinch}"; do
  for one in $name; do
    [[ -n ${scene[$one]-} ]] || {
      echo "animations.sh: there is no animation $one; there are ${!scene[*]}" >&2
      exit 2
    }
    film "$one"
  done
done
