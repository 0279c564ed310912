#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# compare_pages.sh [PROGRAM [FOLDER [PAGE...]]]: makes the pages that compare alternative methods, each by one command:
#   detectors    every broad phase on five scenes (five pages): time, recall
#   integrators  every integrator at six step lengths
#   responses    every response on a ball at three step lengths
#   limiters     every strain limiter on a flag at three step lengths
# Of 50 x 50 cells, with 90 % intervals over SEEDS (3) seeds; only if they are named, or `all_50`, which takes half an hour:
#   detectors_50, narrow_50  every broad and every narrow phase on a ball: time, recall, difference from the first
#   responses_50             every response on the ball at three step lengths
#   integrators_50           every implicit integrator on a flag without a strain limit, at three step lengths
#   explicit_50              the explicit ones and imex on the same flag (they divide a step as they need)
#   limiters_50              every strain limiter on a flag with a limit of 2 %
#   bending_50, shear_50     every law of bending on the ball, of shear on the flag
#   laws                     laws of stretch and of bending on a flag of triangles
# An interrupted run continues when started again. It takes a minute or two on two cores. If chromium is present, the
# script also saves each page as a picture.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=${1:-$root/build/release/apps/selvedge}
folder=${2:-$root/out/compare_pages}
shift $(($# < 2 ? $# : 2))
pages=("$@")
if [ "${#pages[@]}" -eq 0 ]; then pages=(detectors integrators responses limiters); fi
repeats=${REPEATS:-3}
budget=20  # s of the clock for a run
mkdir -p "$folder"
failed=0

# The table of a page names missing and slow methods. Exit code 1 means that a method broke a promise.
page() {
  local name=$1 scene=$2 begin status=0
  shift 2
  begin=$(date +%s)
  "$program" compare "$root/$scene" --out "$folder/$name" --repeats "$repeats" --budget "$budget" "$@" >"$folder/$name.txt" 2>&1 || status=$?
  printf '%-28s exit %d, %4d s, %s rows, %s kB\n' "$name" "$status" $(($(date +%s) - begin)) \
    "$(tail -n +2 "$folder/$name/compare.csv" | wc -l)" "$(($(stat -c %s "$folder/$name/compare.html") / 1000))"
  if [ "$status" -ne 0 ]; then failed=1; fi
  draw "$name"
}

draw() {
  if ! command -v chromium >/dev/null; then return; fi
  local profile
  profile=$(mktemp -d)
  timeout 60 chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir="$profile" \
    --window-size=900,1000 --virtual-time-budget=3000 --screenshot="$folder/$1.png" \
    "file://$(realpath "$folder/$1/compare.html")" >/dev/null 2>&1 || echo "$1: no picture could be made"
  rm -rf "$profile"
}

# Scenes of 50 x 50 cells. Without damping of its springs, the stiffest mode alone sets the step of an explicit method.
ball=(data/scenes/cloth_on_sphere.json --set 'geometry.0.cells=[50,50]' --set obstacles.0.shape.resolution=50 --seeds "${SEEDS:-3}")
flag=(data/scenes/flag.json --set 'geometry.0.cells=[50,50]' --seeds "${SEEDS:-3}" --judge 0)
free=("${flag[@]}" --set time.frames=6 --set solver.strain_limiter=false --set materials.default.spring_damping=0
  --set materials.default.bending_damping=0)
if [ "${pages[0]}" = all_50 ]; then
  pages=(detectors_50 narrow_50 responses_50 integrators_50 explicit_50 limiters_50 bending_50 shear_50 laws)
fi

for name in "${pages[@]}"; do
  if [[ $name == *_50 || $name == laws ]]; then budget=${BUDGET:-300}; fi
  case $name in
    detectors)
      small=(--vary broad_phase=all --no-reference --judge 2)
      page detectors_flag data/scenes/flag.json "${small[@]}" --set 'geometry.0.cells=[24,24]' --set time.frames=4 --set plan=false
      page detectors_ball data/scenes/cloth_on_sphere.json "${small[@]}" --set 'geometry.0.cells=[24,24]' \
        --set obstacles.0.shape.resolution=24 --set time.frames=12
      page detectors_two_sheets data/scenes/two_sheets_on_ball.json "${small[@]}" --set 'geometry.0.cells=[20,20]' \
        --set 'geometry.1.cells=[20,20]' --set time.frames=6
      page detectors_incline data/scenes/incline.json "${small[@]}" --set time.frames=6
      page detectors_table data/scenes/round_table.json "${small[@]}" --set 'geometry.0.cells=[24,24]' --set time.frames=6
      ;;
    integrators)
      page integrators data/scenes/flag.json --vary integrator=all --vary 'dt=0.0005..0.016:6 log' \
        --set 'geometry.0.cells=[8,8]' --set time.frames=6 --judge 0
      ;;
    responses)
      page responses data/scenes/cloth_on_sphere.json --vary response=all --vary 'dt=0.002..0.008:3 log' \
        --set 'geometry.0.cells=[14,14]' --set obstacles.0.shape.resolution=20 --set time.frames=16 --judge 2
      ;;
    limiters)
      page limiters data/scenes/flag.json --vary strain_limiter=all --vary 'dt=0.002..0.008:3 log' \
        --set 'geometry.0.cells=[12,12]' --set time.frames=20 --set materials.default.strain_limit=0.02 --judge 0
      ;;
    detectors_50 | narrow_50)
      kind=broad_phase
      if [ "$name" = narrow_50 ]; then kind=narrow_phase; fi
      page "$name" "${ball[@]}" --vary "$kind=all" --set time.frames=12 --no-reference --judge 2
      ;;
    responses_50)
      page responses_50 "${ball[@]}" --vary response=all --vary 'dt=0.002..0.008:3 log' --set time.frames=16 --judge 0
      ;;
    integrators_50)
      page integrators_50 "${free[@]}" --vary integrator=implicit_euler,implicit_blend,bdf2,implicit_newton,implicit_desbrun,implicit_kang \
        --vary 'dt=0.001..0.016:3 log'
      ;;
    explicit_50)
      page explicit_50 "${free[@]}" \
        --vary integrator=implicit_blend,imex,symplectic_euler,verlet,damped_verlet,forward_euler,midpoint,runge_kutta_4,rkf45
      ;;
    limiters_50)
      page limiters_50 "${flag[@]}" --vary strain_limiter=all --set time.frames=6 --set materials.default.strain_limit=0.02
      ;;
    bending_50)
      page bending_50 "${ball[@]}" --vary materials.default.bending_law=shape_operator,hinge,bridson,chord,twisting,buckling,beam \
        --set time.frames=30 --judge 0
      ;;
    shear_50)
      page shear_50 "${flag[@]}" --vary materials.default.shear_law=springs,angle,twisting --set time.frames=30
      ;;
    laws)
      page laws data/scenes/flag.json --vary materials.default.stretch_law=hooke,st_venant_kirchhoff,corotated \
        --vary materials.default.bending_law=hinge,bridson,shape_operator --set geometry.0.pattern=triangular \
        --set 'geometry.0.cells=[50,50]' --set time.frames=30 --judge 0 --seeds 3 \
        --reference-set materials.default.stretch_law=corotated
      ;;
    *)
      echo "compare_pages.sh: there is no page $name; there are detectors, integrators, responses, limiters, detectors_50, narrow_50," \
        "responses_50, integrators_50, explicit_50, limiters_50, bending_50, shear_50, laws, all_50" >&2
      exit 2
      ;;
  esac
done
exit "$failed"
