#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# mutants_margins.sh: proves that the tests see a margin that is too small. CTest calls it with the environment below.
# Halves the margins, inflations and reaches of the detection, one at a time, in a copy of the source. Each of these
# mutants must fail a test; a change whose pattern is not in the source any more is an error. First the unchanged
# sources must pass the same tests.
#
#   CXX, FLAGS      compiler and flags that the sources of the library need
#   SOURCE          root of the sources
#   INCLUDE         folder that holds selvedge/, a link to the sources
#   DETECTION_STAGE, NARROWPHASE, BROADPHASE    object files of these test programs
#   LIBRARIES       libraries of these tests
#   WORK            folder for the results, made anew
#   JOBS            mutants at a time (default: processors)
set -uo pipefail
JOBS=${JOBS:-$(nproc)}
rm -rf "$WORK"
mkdir -p "$WORK"

folder=simulation/detail
detection=$folder/detection.cpp
candidates=$folder/candidates.cpp
near=$folder/contacts.cpp
clearances=$folder/clearances.cpp
search=$folder/body_search.cpp
filter=$folder/contact_filter.cpp
proofs=$folder/idle_proofs.cpp
plan=$folder/detection_plan.cpp
reach=$folder/strain_reach.cpp
verlet=broadphase/verlet_list.cpp
certificates=$folder/certificates.cpp
distance=narrowphase/distance.cpp
floats=narrowphase/detail/float_paths.cpp

# compile OPTIONS... SOURCE -o OBJECT: as the library is compiled.
compile() {
  # shellcheck disable=SC2086
  "$CXX" -std=c++20 -O1 -DNDEBUG -ffp-contract=off $FLAGS -I"$INCLUDE" "$@"
}

# The headers of all these sources, compiled once: they take two thirds of the time of a mutant.
for file in $detection $candidates $near $clearances $search $filter $proofs $plan $reach $verlet $certificates $distance \
  $floats; do
  grep '^#include' "$SOURCE/$file"
done | sort -u >"$WORK/headers.h"
compile -x c++-header "$WORK/headers.h" -o "$WORK/headers.h.gch" || exit 1

# build FOLDER SOURCE TEST: links the source, compiled apart, with the objects of a test. The library's objects hold
# several sources each. Of two definitions the linker takes the first, and position-independent code calls it
# everywhere.
build() {
  local objects
  case $3 in
    composer | plan) objects=$DETECTION_STAGE ;;
    narrowphase) objects=$NARROWPHASE ;;
    verlet_list) objects=$BROADPHASE ;;
  esac
  # shellcheck disable=SC2086
  compile -include "$WORK/headers.h" -c "$2" -o "$1/source.o" &&
    "$CXX" $FLAGS "$1/source.o" $objects -Wl,-z,muldefs -Wl,--start-group $LIBRARIES -Wl,--end-group -o "$1/trial"
}

# run FOLDER FILTER: 0 if all tests of the filter pass. A mutant may not end.
run() {
  { (ulimit -t "$most_seconds"; exec "$1/trial" --gtest_filter="$2" --gtest_brief=1 --gtest_fail_fast) >"$1/log" 2>&1; } 2>/dev/null
}

# mutant NAME FILE FROM TO TEST FILTER: the first FROM in FILE becomes TO.
mutant() {
  local name=$1 file=$2 from=$3 to=$4 test=$5 filter=$6 folder=$WORK/$1 text changed
  mkdir -p "$folder"
  text=$(cat "$SOURCE/$file")
  changed=${text/"$from"/"$to"}
  [ "$changed" != "$text" ] || { echo "$name: \"$from\" is not in $file any more"; return 1; }
  printf '%s\n' "$changed" >"$folder/source.cpp"
  build "$folder" "$folder/source.cpp" "$test" || { echo "$name: does not build"; return 1; }
  if run "$folder" "$filter"; then
    echo "$name: LIVES: ${test}_test passes with \"$to\" in $file"
    return 1
  fi
  echo "$name: found by $(sed -n 's/^\[  FAILED  \] \([A-Za-z/_0-9.]*\).*/\1/p' "$folder/log" | head -n 1)"
  rm -f "$folder/trial" "$folder/source.o"
}

# unchanged NAME FILE TEST FILTER: passes, built in the same way.
unchanged() {
  mkdir -p "$WORK/$1"
  build "$WORK/$1" "$SOURCE/$2" "$3" && run "$WORK/$1" "$4" && echo "$1: passes" && return 0
  echo "$1: the unchanged $2 does not pass $3: $(tail -n 3 "$WORK/$1/log")"
  return 1
}

most_seconds=60
running=0
failed=0
finish() {
  wait -n || failed=1
  running=$((running - 1))
}
try() {
  [ "$running" -lt "$JOBS" ] || finish
  "$@" &
  running=$((running + 1))
}

boxes='*Composer.FindsWhat*/bvh_aabb'
culled='*Composer.FindsWhat*/bvh_kdop18:*Composer.FindsWhat*/bvh_obb'
contacts='Contacts.*'

try unchanged unchanged_candidates "$candidates" composer "$boxes:$culled:$contacts:Margins.*"
try unchanged unchanged_contacts "$near" composer "$boxes:$culled:$contacts:Margins.*"
try unchanged unchanged_clearances "$clearances" composer "$contacts"
try unchanged unchanged_detection "$detection" composer "$contacts"
try unchanged unchanged_plan "$plan" composer "$contacts:Margins.*"
try unchanged unchanged_proofs "$proofs" plan 'SheetProof.*'
try unchanged unchanged_floats "$floats" narrowphase 'FindContacts.*:FindProximities.*'

# Candidates, and how far they reach.
try mutant inflation_boxes "$candidates" ": margin_;" ": 0.5 * margin_;" composer "$boxes"
try mutant inflation_culled "$candidates" "? std::numbers::sqrt3 * margin_" "? 0.5 * std::numbers::sqrt3 * margin_" \
  composer "$culled"
try mutant inflation_diagonal "$candidates" "? std::numbers::sqrt3 * margin_" "? margin_" composer "$culled"
try mutant body_margin "$candidates" "cloth(0.0), margin_," "cloth(0.0), 0.5 * margin_," composer "$boxes"
try mutant body_thickness "$candidates" "margin_, 0.5 * context_.rest_gap" "margin_, 0.25 * context_.rest_gap" \
  composer "$boxes"
try mutant margin "$candidates" "margin_(context.rest_gap)" "margin_(0.5 * context.rest_gap)" composer "$boxes:Margins.*"
try mutant largest_rest_gap "$near" "return pairs_.largest_rest_gap()" \
  "return 0.5 * pairs_.largest_rest_gap()" composer "$boxes"
try mutant cover "$candidates" "<= margin_)) count" "<= 2.0 * margin_)) count" composer "Margins.*"
try mutant search_boxes "$search" "margin : margin" "margin : 0.5 * margin" composer "$boxes"
try mutant search_distance "$search" "? std::numbers::sqrt3 * margin" "? 0.5 * std::numbers::sqrt3 * margin" \
  composer "$boxes"
try mutant search_diagonal "$search" "? std::numbers::sqrt3 * margin" "? margin" composer "$boxes"
try mutant verlet_margin "$verlet" "search_wide(wide_a, wide_b, self, list.pairs)" \
  "search_wide([&] { SurfaceView s = wide_a; s.thickness -= 0.5 * margin_a; return s; }(),
     [&] { SurfaceView s = wide_b; s.thickness -= 0.5 * margin_b; return s; }(), self, list.pairs)" \
  verlet_list 'VerletList.*'

# Contacts: from where on pairs take part.
try mutant proximity_reach "$near" "kProximityReach = 4.0" "kProximityReach = 2.0" composer "$contacts"
try mutant point_reach "$near" "kPointReach = 1.5" "kPointReach = 0.75" composer "$contacts"
try mutant point_reach_used "$near" ".reach = kPointReach" ".reach = 0.5 * kPointReach" composer "$contacts"
try mutant secondary_reach "$near" "kSecondaryReach = 1.1" "kSecondaryReach = 0.55" composer "$contacts"
try mutant secondary_share "$near" "kSecondaryShare = 0.5" "kSecondaryShare = 0.25" composer "$contacts"
try mutant start_share "$near" "kStartShare = 0.9" "kStartShare = 0.45" composer "$contacts"
try mutant same_normal "$near" "kSameNormal = 0.95" "kSameNormal = 0.475" composer "$contacts"
try mutant wide_enough "$clearances" "kWideEnough = 0.05" "kWideEnough = 0.025" composer "$contacts"
try mutant point_slope "$filter" "kPointSlope = 1e-6" "kPointSlope = 0.5e-6" composer "ContactFilter.*"
try mutant edge_slope "$filter" "kEdgeSlope = 0.1" "kEdgeSlope = 0.05" composer "ContactFilter.*"
try mutant border "$filter" "kBorder = 1e-9" "kBorder = 0.5e-9" composer "ContactFilter.*"

# Pairs that floats tell apart. Half of the slack is just enough, since the errors of four numbers and two sums can add
# up to it, but sums of numbers near 1 lie on a grid of 2^-22: only an eighth is seen to miss one. The slacks of lengths
# count two slacks where one eighth serves; without them pairs at the edge of the reach are lost.
try mutant float_slack "$floats" "kSlack = 0x1p-20" "kSlack = 0x1p-23" narrowphase 'FindContacts.WhatFloats*'
try mutant float_gap "$floats" "kOfGap = 2.0" "kOfGap = 0.0" narrowphase 'FindProximities.FloatsLose*'
try mutant float_spread "$floats" "of_spread = of_gap + kOfSpread * slack_" \
  "of_spread = 0.0" narrowphase 'FindProximities.FloatsLose*'

# Rooms of pairs, and what their vertices moved since. Skipping rooms by the largest motion of all vertices is a shortcut.
try mutant room "$distance" "std::copy_n(room.begin(), block.size, rooms.begin() + static_cast<std::ptrdiff_t>(i))" \
  "for (int j = 0; j < block.size; ++j) rooms[i + j] = 1.1F * room[j]" narrowphase 'FindProximities.NoPair*'
try mutant room_moved "$certificates" "> moved(pairs[i])" "> 0.5F * moved(pairs[i])" composer "$boxes"
try mutant room_most "$certificates" "2.0F * most" "1.0F * most" composer "$boxes"

# Proofs that nothing has to be searched.
try mutant plan_proximity "$detection" "proximity = kPointReach * thickness" "proximity = 0.5 * kPointReach * thickness" \
  composer "$contacts"
# Between pieces, and between cloth and bodies, boxes must be 4 + 2 largest thicknesses apart, but only 2 and 1.5 are
# needed by the margins and reaches above: half of it, 3, misses nothing. A quarter and an eighth do.
try mutant plan_pieces "$plan" "distances_.reach + 2.0 * distances_.margin)" \
  "0.2 * (distances_.reach + 2.0 * distances_.margin))" composer "Margins.*"
try mutant plan_bodies "$plan" "least = distances_.reach + 2.0 * distances_.margin" \
  "least = 0.125 * (distances_.reach + 2.0 * distances_.margin)" composer "Margins.*"
# Any positive number serves, 1e-6 is for rounding: only one below 0 misses something.
try mutant plan_apart "$plan" "kApart = 1e-6" "kApart = -4.0" composer "$contacts"
try mutant sheet_near "$proofs" "for_near = distance / nearest_" "for_near = 0.5 * distance / nearest_" plan 'SheetProof.*'
# Bounds of SheetProof are wider than they need to be: no state is known that is judged wrongly with half of them. Far
# pairs do not collide with any bound above 0; one below 0 misses a roll that closes. The bounds on what a motion changes
# take the largest change of every edge at once. With a tenth of sheet_moved, or ten times what sheet_spare may use up,
# folds are missed. Half of sheet_change is enough for every rotation (cos 2a >= cos a - sin a); none is not.
try mutant sheet_far "$proofs" "for_far = distance / far_" "for_far = distance / far_ - 1.0" plan 'SheetProof.*'
try mutant sheet_moved "$proofs" "3.0 * std::numbers::sqrt2" "0.3 * std::numbers::sqrt2" plan 'SheetProof.*'
try mutant sheet_change "$proofs" "least - std::sqrt(fastest)" "least" plan 'SheetProof.*'
try mutant sheet_spare "$proofs" "kOfSpare = 0.99" "kOfSpare = 9.9" plan 'SheetProof.*'
try mutant strain_growth "$reach" "return ((high - low).norm() + rounding)" "return (0.5 * (high - low).norm() + rounding)" \
  plan 'StrainReach.*'

while [ "$running" -gt 0 ]; do finish; done
exit "$failed"
