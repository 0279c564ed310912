#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# quick_ctest.sh BUILD_DIR [SECONDS]: runs as many tests as fit into SECONDS (default 150) on this machine, the fastest
# first, and says how many it leaves out. The times are those of earlier runs in the build folder (CTest keeps them); a
# test that has not run yet counts as half a second, or as ten if its program runs whole scenes or commands.
set -euo pipefail
build=$1
seconds=${2:-150}
long='^(ablation|adapters|check_command|cli|compare|conformance|curvature_cone|detect_command|drape_bench|extreme|fabric|'
long+='garment|geometric_drape|identify|image_space|integrator_scene|measured|minimal_enclosure|plan|plan_scenes|python|readme|'
long+='real_frames|refinement|replay|reported|response_scene|rest|seam_merging|slender|stability|swatch|untangle|'
long+='walking_mannequin)\.'
costs=$build/Testing/Temporary/CTestCostData.txt
[ -f "$costs" ] || costs=/dev/null
chosen=$(ctest --test-dir "$build" -N | awk -v budget="$(($(nproc) * seconds))" -v long="$long" -v costs="$costs" '
  BEGIN { while ((getline line < costs) > 0) { if (line == "---") break; split(line, f, " "); if (f[2] > 0) cost[f[1]] = f[3] } }
  /^ *Test +#[0-9]+: / {
    number = $2; sub(/^#/, "", number); sub(/:$/, "", number)
    sub(/^ *Test +#[0-9]+: /, ""); name = $0
    print (name in cost ? cost[name] : name ~ long ? 10 : 0.5), number
  }' | sort -n | awk -v budget="$(($(nproc) * seconds))" '{ sum += $1 + 0.05; if (sum > budget) exit; printf ",%s", $2 }')
all=$(ctest --test-dir "$build" -N | sed -n 's/^Total Tests: //p')
count=$(tr -cd ',' <<<"$chosen" | wc -c)
echo "$count of $all tests; scripts/test.sh runs all"
"$(dirname "${BASH_SOURCE[0]}")"/run_ctest.sh "$build" -I "0,0,0$chosen"
