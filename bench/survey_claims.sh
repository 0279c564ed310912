#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# survey_claims.sh [--list] [C4 C9 ...]: measures the given claims of the survey, or all of them, and prints the
# figures. docs/lab/survey_claims.md discusses them and docs/lab/tables/survey_claims.csv records them. Claims that share a
# measurement share its run. Builds the programs first, unless SELVEDGE_BUILD names a folder that has them.
# SELVEDGE_TURNS: repeats of interleaved timings (default 7). --list prints the measurement of each claim.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
build=${SELVEDGE_BUILD:-build/release}
turns=${SELVEDGE_TURNS:-7}

# part CLAIM: prints the measurement that decides the claim; claims that share a measurement have the same one.
part() {
  case "$1" in
    C1 | C3) echo balance ;;
    C2 | C25) echo meshes ;;
    C4 | C5) echo limiters_alone ;;
    C6) echo limiters ;;
    C7) echo stability ;;
    C8) echo error_and_time ;;
    C9) echo rival_responses ;;
    C10 | C28 | C29) echo responses ;;
    C11) echo image_space ;;
    C12 | C13 | C17) echo detectors ;;
    C14) echo scaling ;;
    C15) echo voxels ;;
    C16) echo enclosure ;;
    C18) echo drape ;;
    C26) echo refinement ;;
    C19) echo adaptive ;;
    C20) echo bilayered ;;
    C21 | C22 | C23 | C24) echo integrators ;;
    C27) echo elements ;;
    C30) echo strains ;;
    *) echo "survey_claims.sh: no claim \"$1\"; they are C1 to C30" >&2; return 2 ;;
  esac
}

say() { printf '\n## %s\n' "$*"; }

# Prints a command without the folders of this machine, then runs it.
measure() {
  local shown="$*"
  shown=${shown//$build\/apps\//}
  shown=${shown//$build\/bench\//}
  shown=${shown//$build\/tests\//}
  printf '\n%s\n\n' "${shown//$out/OUT}"
  "$@"
}

compare() {
  local name=$1
  shift
  measure "$build/apps/selvedge" compare "$@" --judge 0 --no-pictures --out "$out/$name"
}

# quartiles OF: reads "scene detector value" lines and prints median and quartiles of each scene and detector. For six
# values or more it also prints the 95 % interval of the median by the ranks of the sign test.
quartiles() {
  sort -k1,1 -k2,2 -k3,3g | awk -v of="$1" '
    function at(share,   place, low) {
      place = 1 + share * (n - 1); low = int(place)
      return value[low] + (place - low) * (value[low < n ? low + 1 : low] - value[low])
    }
    function interval(   ways, below, k) {
      ways = 1
      for (k = 0; (below + ways) / 2 ^ n <= .025; ways *= (n - k + 1) / k) { below += ways; ++k }
      return k ? sprintf("95 %% %.3f to %.3f, ", value[k], value[n + 1 - k]) : ""
    }
    function show() { if (n) printf "%-10s %-20s %s %.3f (%squartiles %.3f to %.3f, of %d)\n", scene, detector, of, at(.5), interval(), at(.25), at(.75), n }
    $1 != scene || $2 != detector { show(); scene = $1; detector = $2; n = 0 }
    { value[++n] = $3 }
    END { show() }'
}

# Frame after which the kinetic energy stays below that of a cloth moving at 1 mm/s everywhere.
frames_to_balance() {
  awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "kinetic_J") k = i }
           NR > 1 && $k > 1e-7 { last = NR - 1 }
           END { print last }' "$1/measures/energy.csv"
}

balance() {
  say "C1: time until the square held at two corners is at balance, 36 cells (1 mm/s: 1e-7 J)"
  local turn pattern frames
  local run=("$build/apps/selvedge" run data/meshes/hang.json --threads 1 --no-pictures --set 'geometry.0.cells=[36,36]')
  for pattern in rectangular simplified triangular responsive; do
    measure "${run[@]}" --set time.frames=300 --set "geometry.0.pattern=$pattern" --out "$out/$pattern" >/dev/null
    "$build/apps/selvedge" measure "$out/$pattern" --no-pictures >/dev/null
    frames=$(frames_to_balance "$out/$pattern")
    echo "$pattern: at balance after $frames frames of 0.1 s"
    echo "$pattern $frames" >>"$out/frames"
  done
  for turn in $(seq "$turns"); do
    while read -r pattern frames; do
      "${run[@]}" --set "time.frames=$frames" --set "geometry.0.pattern=$pattern" --out "$out/hang" >/dev/null </dev/null
      echo "$turn $pattern $(seconds_of "$out/hang")"
      rm -rf "$out/hang"
    done <"$out/frames"
  done | awk '$2 == "rectangular" { base = $3 } { print "hang", $2, $3 / base }' | quartiles "time to balance over rectangular:"
  survey_size "C1, C3: four nets of equal springs at the survey's sizes, on a table and hung" meshes --springs "equal k" --stiffness 3
  survey_size "C1, C3: the same with the constants of one fabric" meshes --springs "equal fabric"
}

# survey_size TITLE ARGUMENTS...: a part of survey_size.py.
survey_size() {
  say "$1 (needs the Python module in $build/python and NumPy)"
  shift
  measure env PYTHONPATH="$build/python" bench/survey_size.py "$@"
}

meshes() {
  survey_size "C2: steps of four nets on a table at the survey's sizes" meshes --scenes table --springs "equal k" --stiffness 3 --longest 1
  say "C2, C3, C25: meshes"
  echo "(some minutes; writes docs/lab/tables/mesh_hang.csv)"
  SELVEDGE=$build/apps/selvedge measure scripts/tables.sh mesh --only hang
  cat docs/lab/tables/mesh_hang.csv
}

limiters_alone() {
  say "C4, C5: strain limiters alone, on the same ends of steps and to the same residual"
  local stiffness
  for stiffness in 3 1; do
    measure "$build/bench/bench" limiters --replay --stiffness "$stiffness"
  done
}

limiters() {
  say "C6: strain limiters; ratios of times to \"position\", deviation over the extent of the cloth"
  compare limiters data/scenes/flag.json --no-reference --repeats 7 --set 'geometry.0.cells=[24,24]' \
    --set time.frames=8 --set materials.default.stretch_stiffness=60 \
    --vary strain_limiter=position,ordered_position,position_velocity,ordered_position_velocity,priority_position_velocity,velocity
  local stiffness
  for stiffness in 3 1; do
    survey_size "C6: 2,500 particles on a round table until balance" limiters --stiffness "$stiffness"
  done
}

stability() {
  say "C7: largest stable steps"
  measure "$build/apps/selvedge" stability data/scenes/flag.json --set 'geometry.0.cells=[19,19]' --steps 500 \
    --integrator forward_euler,midpoint,runge_kutta_4,verlet,implicit_euler --stiffness '1e2..1e4:3 log' --damping 0,0.001
  say "C7: the same of 2,500 particles; rkf45 divides its steps, which takes minutes, so it has one stiffness"
  local six=("$build/apps/selvedge" stability data/scenes/flag.json --set 'geometry.0.cells=[49,49]' --steps 500
    --precision 0.03 --damping '0,0.001')
  measure "${six[@]}" --integrator forward_euler,midpoint,runge_kutta_4,verlet,implicit_euler --stiffness '1e2..1e4:3 log'
  measure "${six[@]}" --integrator rkf45 --stiffness 100
  say "C7: the same of 2,500 particles that swing from level, without a strain limiter and with one (twenty minutes)"
  local limiter forward=forward_euler,  # with the limiter it takes too long
  for limiter in none ordered_position_velocity; do
    measure "$build/apps/selvedge" stability data/scenes/flag.json --set 'geometry.0.cells=[49,49]' \
      --set geometry.0.transformation.rotation.angle_deg=0 --strain-limiter "$limiter" --sweeps 20 --seconds 1 --steps 200000 \
      --precision 0.03 --integrator "${forward}midpoint,runge_kutta_4,verlet,rkf45,implicit_euler" --stiffness 1000 --damping 0
    forward=
  done
}

error_and_time() {
  say "C8: error against time, explicit and implicit; ratios of times to the first cell"
  compare error_and_time data/scenes/flag.json --repeats 5 --set 'geometry.0.cells=[10,10]' --set time.frames=15 \
    --reference-set solver.integrator=runge_kutta_4 \
    --vary integrator=symplectic_euler,verlet,runge_kutta_4,implicit_euler,bdf2 --vary dt=0.0005,0.002,0.00556
}

rival_responses() {
  say "C9: whole drapes of the survey's 2,500 particles, and the same few steps from the same states"
  measure "$build/bench/bench" response --no-table --claim C9 --claim-cells 49 --repeats 5
}

responses() {
  say "C10, C28, C29: responses"
  local claim
  for claim in C10 C28 C29; do
    measure "$build/bench/bench" response --no-table --claim-cells 20 --claim "$claim"
  done
  survey_size "C10: penalty springs on the cloth of Figure 45" penalty --stiffness 3 --longest 2
}

# detector_rows ARGUMENTS...: writes the table of bench broadphase, turn after turn, as lines into $out/rows.
# Columns: scene, detector, threads, cold, build, refit, query, warm, ...
detector_rows() {
  local turn
  printf '\nbench broadphase detectors %s\n\n' "$*"
  for turn in $(seq "$turns"); do
    "$build/bench/bench" broadphase detectors "$@"
  done | awk -F' *[|] *' 'NF > 12 && $2 ~ /^(drape|crumple) / { print }' >"$out/rows"
}

# over BASE WHICH [COLUMN NAME]: warm time, or that column, of the detectors that match WHICH over that of BASE in the same turn.
over() {
  awk -F' *[|] *' -v base="$1" -v which="$2" -v column="${3:-9}" '
    $3 == base { time = $column }
    $3 ~ which && time > 0 { scene = $2; gsub(" ", "_", scene); print scene, $3, $column / time }' "$out/rows" |
    quartiles "${4:-warm call} over $1:"
}

image_space() {
  say "C11: image space against a tree"
  detector_rows --scene drape --size 100 --threads 1 --repeats 3 --markdown --detectors bvh_aabb,image_space_pairs
  over bvh_aabb image_space_pairs
  say "C11: maps against a tree that answers the same particles"
  measure "$build/bench/bench" image_space
}

detectors() {
  say "C12, C13, C17: k-DOPs, refitting, curvature cone"
  detector_rows --size 50,100,200 --threads 1 --repeats 5 --least --markdown \
    --detectors bvh_aabb,bvh_kdop14,bvh_kdop18,bvh_kdop26,bvh_obb,curvature_cone
  over bvh_aabb 'kdop|cone|obb'
  over bvh_kdop14 'kdop(18|26)'
  over bvh_aabb 'kdop|obb' 7 "update of the volumes"
  awk -F' *[|] *' '$3 ~ "bvh" && $7 > 0 { scene = $2; gsub(" ", "_", scene); print scene, $3, $6 / $7 }' "$out/rows" |
    quartiles "build over update:"
  awk -F' *[|] *' '$3 == "curvature_cone" { scene = $2; gsub(" ", "_", scene); print scene, $3, $12 }' "$out/rows" |
    quartiles "share of the pairs that it keeps:"
}

scaling() {
  say "C14: exponent of the warm time over primitives and pairs"
  printf '\nbench broadphase scaling --size 50,100,200 --repeats 7 --least --limit 15 --markdown --detectors bvh_aabb\n\n'
  local turn
  for turn in $(seq "$turns"); do
    "$build/bench/bench" broadphase scaling --size 50,100,200 --repeats 7 --least --limit 15 --markdown --detectors bvh_aabb
  done | awk -F' *[|] *' '$3 == "bvh_aabb" { print $2, $3, $(NF - 1) }' | quartiles "exponent:"
}

voxels() {
  say "C15: size of the voxel"
  printf '\nbroadphase_tests --gtest_filter=Voxel*\n\n'
  local turn
  for turn in $(seq "$turns"); do
    "$build/tests/broadphase_tests" '--gtest_filter=Voxel*' |
      awk '/^voxel of/ { sub(":", "", $5); ms[$3] = $6 } END { for (v in ms) print "voxel", v, ms[v] / ms["2.0"] }'
  done | quartiles "typical extents: time over that of 2.0:"
  survey_size "C15: two sheets of 2,500 particles that fall onto a ball" voxels --longest 0.2 --turns 5
}

enclosure() {
  say "C16: minimal enclosure"
  measure "$build/bench/bench" enclosure --cells 60 --repeats 5 --threads 1 --scene "leg sleeve" --brute
  measure "$build/bench/bench" enclosure --cells 60 --repeats 5 --threads 1 --scene "figure skirt" --brute
}

drape() {
  say "C18: drape coefficients, arc mesh, woven and triangular disc"
  local mesh TIMEFORMAT='%U s of the processor'
  for mesh in "--cells 12" "--cells 24 --mesh woven" "--cells 48 --mesh woven" \
    "--cells 24 --mesh triangular" "--cells 48 --mesh triangular"; do
    # shellcheck disable=SC2086  # words of the command
    time measure "$build/apps/selvedge" drape petrak_2025/M{1,2,3,4,5,6} $mesh --seeds 3 --levels 1 --threads 1
  done
}

refinement() {
  say "C26: drape coefficients of six measured fabrics with five seeds on two meshes, the second for twelve minutes"
  local cells
  for cells in 12 32; do
    measure "$build/apps/selvedge" drape petrak_2025/M{1,2,3,4,5,6} --cells $cells --levels 1 --seeds 5
  done
}

# The seconds of a run according to its result.
seconds_of() { sed -n 's/^ *"wall_s": *\([0-9.e+-]*\),*$/\1/p' "$1/result.json"; }

adaptive() {
  say "C19: 12 x 12 cells that are split once where they bend, against 24 x 24, and against 12 x 12"
  local turn cells angle
  printf '\nselvedge run data/scenes/adaptive.json --threads 1 --no-pictures --set time.frames=60'
  printf ' --set geometry.0.refine.levels=1 --set geometry.0.cells=[N,N] --set geometry.0.refine.angle_deg=A\n'
  echo "(N, A: 24, 179, which splits nothing; 12, 179; 12, 12)"
  for turn in $(seq "$turns"); do
    for cells in 24,179 12,179 12,12; do
      angle=${cells#*,}
      "$build/apps/selvedge" run data/scenes/adaptive.json --threads 1 --no-pictures --set time.frames=60 \
        --set geometry.0.refine.levels=1 --set "geometry.0.cells=[${cells%,*},${cells%,*}]" \
        --set "geometry.0.refine.angle_deg=$angle" --out "$out/adaptive" >/dev/null
      echo "$cells $(seconds_of "$out/adaptive")" >>"$out/seconds"
      if [ "$turn" -eq 1 ]; then echo "$cells: $(grep -o '"refine[a-z_]*": *[0-9.]*' "$out/adaptive/result.json" | tr '\n' ' ')"; fi
      rm -rf "$out/adaptive"
    done
  done
  awk '$1 == "24,179" { base = $2 } { print "adaptive", $1, $2 / base }' "$out/seconds" |
    quartiles "seconds over those of 24 x 24 cells:"
  say "C19: 16 x 16 cells, split twice once they are at rest, against 64 x 64 from the start"
  printf '\nselvedge run data/scenes/multi_level.json --threads 1 --no-pictures --set geometry.0.cells=[N,N] --set geometry.0.refine.speed=V\n'
  echo "(N, V: 64, 1e-6, which splits nothing; 16, 0.12)"
  for turn in $(seq "$turns"); do
    for cells in 64,1e-6 16,0.12; do
      "$build/apps/selvedge" run data/scenes/multi_level.json --threads 1 --no-pictures \
        --set "geometry.0.cells=[${cells%,*},${cells%,*}]" --set "geometry.0.refine.speed=${cells#*,}" --out "$out/level" >/dev/null
      echo "$cells $(seconds_of "$out/level")"
      rm -rf "$out/level"
    done
  done | awk '$1 == "64,1e-6" { base = $2 } { print "multi_level", $1, $2 / base }' |
    quartiles "seconds over those of 64 x 64 cells:"
  survey_size "C19: time and error of adaptive and multi-level meshes" levels
}

bilayered() {
  say "C20: two layers against one of the same cells"
  compare bilayered data/scenes/bilayered.json --no-reference --repeats 5 --set time.frames=20 \
    --vary pattern=bilayered,rectangular
  survey_size "C20: time and error of two layers and of plain sheets" layers
}

integrators() {
  say "C21, C22, C23, C24: integrators"
  measure "$build/bench/bench" integrators --work 500,2000,8000
  measure "$build/bench/bench" integrators
  compare integrators data/scenes/flag.json --repeats 7 --set 'geometry.0.cells=[10,10]' --set time.frames=15 \
    --reference-set solver.integrator=runge_kutta_4 --vary dt=0.0005 \
    --vary integrator=symplectic_euler,verlet,forward_euler,rkf45,implicit_euler,implicit_desbrun,implicit_kang
}

elements() {
  say "C27: mass-spring, finite elements and a geometric drape"
  measure "$build/bench/bench" rivals --repeats "$turns"
  measure "$build/bench/bench" rivals --cells 24 --repeats 3
  measure "$build/apps/selvedge" drape petrak_2025/M1 petrak_2025/M3 petrak_2025/M6 --cells 20 --levels 1 --seeds 1 \
    --stretch-law hooke
  measure "$build/apps/selvedge" drape petrak_2025/M1 petrak_2025/M3 petrak_2025/M6 --cells 20 --levels 1 --seeds 1 \
    --stretch-law corotated
}

strains() {
  say "C30: strain of the faces and of the springs of five fabrics, by frame"
  measure "$build/apps/selvedge" run data/experiments/xii_ji.json --out "$out/strains" --no-pictures
  measure "$build/apps/selvedge" measure "$out/strains" --no-pictures
  local table=$out/strains/measures/energy.csv
  head -n 1 "$table"
  awk 'NR > 1 && (NR - 2) % 15 == 0' "$table"
  # Columns 7 and 8: mean strain of the springs, growth of the area; the first frame is at rest.
  awk -F, 'NR > 2 { print "frames", "area_over_springs", $8 / $7 }' "$table" | quartiles "growth over strain:"
}

claims=()
for ((i = 1; i <= 30; ++i)); do claims+=("C$i"); done
if [ "${1:-}" = --list ]; then
  for claim in "${claims[@]}"; do echo "$claim $(part "$claim")"; done
  exit 0
fi
if [ $# -gt 0 ]; then claims=("$@"); fi
parts=()
for claim in "${claims[@]}"; do
  name=$(part "$claim")
  case " ${parts[*]-} " in *" $name "*) ;; *) parts+=("$name") ;; esac
done

if [ -z "${SELVEDGE_BUILD:-}" ]; then
  cmake --preset release -DSELVEDGE_BENCH=ON -S . >/dev/null
  cmake --build --preset release --target selvedge_program selvedge_bench >/dev/null
fi
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
failed=0
for name in "${parts[@]}"; do
  # Report a failed measurement and continue with the others.
  set +e
  (
    set -e
    "$name"
  )
  status=$?
  set -e
  if [ "$status" -ne 0 ]; then
    echo "survey_claims.sh: the part \"$name\" failed" >&2
    failed=1
  fi
done
exit "$failed"
