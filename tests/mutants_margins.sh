#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# mutants_margins.sh: proves that the tests see a margin that is too small. CTest calls it with the environment below.
# Halves the margins, inflations and reaches of the detection, one at a time (mutants_lib.sh). Each of these mutants
# must fail a test; a change whose pattern is not in the source any more is an error. First the same programs must pass
# these tests with nothing changed.
#
#   DETECTION_STAGE, NARROWPHASE, BROADPHASE    object files of these test programs
#   LIBRARIES       libraries of these tests
#   others          see mutants_lib.sh
# shellcheck disable=SC2086,SC2153
set -uo pipefail
# shellcheck source=tests/mutants_lib.sh
source "$SOURCE/tests/mutants_lib.sh"

folder=simulation/contacts
detection=$folder/detection.cpp
candidates=$folder/candidates.cpp
near=$folder/contacts.cpp
clearances=$folder/clearances.cpp
search=$folder/body_search.cpp
filter=$folder/contact_filter.cpp
proofs=$folder/idle_proofs.cpp
plan=$folder/detection_plan.cpp
reach=simulation/detail/strain_reach.cpp
verlet=broadphase/verlet_list.cpp
certificates=$folder/certificates.cpp
distance=narrowphase/distance.cpp
floats=narrowphase/detail/float_paths.cpp

declare -A program filter_of  # the test program and the tests that show the mutant

# mutant NAME FILE FROM TO PROGRAM FILTER: a change (mutants_lib.sh) that a test of the filter must show.
mutant() {
  change "$1" "$2" "$3" "$4"
  program[$1]=$5 filter_of[$1]=$6
}

# run LOG PROGRAM FILTER NUMBER: 0 if all tests of the filter pass. A mutant may not end.
run() {
  { (ulimit -t $most_seconds; SELVEDGE_MUTANT=$4 exec "$WORK/$2" --gtest_filter="$3" --gtest_brief=1 --gtest_fail_fast) >"$1" 2>&1; } 2>/dev/null
}

# is_found NAME: 0 if a test fails.
is_found() {
  local name=$1 log=$WORK/$1.log
  if run "$log" "${program[$name]}" "${filter_of[$name]}" "$(number "$name")"; then
    echo "$name: LIVES: ${filter_of[$name]} of ${program[$name]} pass"
    return 1
  fi
  echo "$name: found by $(sed -n 's/^\[  FAILED  \] \([A-Za-z/_0-9.]*\).*/\1/p' "$log" | head -n 1)"
}

# passes PROGRAM FILTER: with nothing changed.
passes() {
  run "$WORK/$1.log" "$1" "$2" 0 && echo "$1: passes with nothing changed" && return 0
  echo "$1: does not pass with nothing changed: $(tail -n 3 "$WORK/$1.log")"
  return 1
}

most_seconds=60
boxes='*Composer.FindsWhat*/bvh_aabb'
culled='*Composer.FindsWhat*/bvh_kdop18:*Composer.FindsWhat*/bvh_obb'
contacts='Contacts.*'

# Candidates, and how far they reach.
mutant inflation_boxes $candidates ": @self_margin_@;" "0.5 * self_margin_" detection_stage "$boxes"
mutant inflation_culled $candidates "std::numbers::sqrt3 * self_margin_" "0.5 * std::numbers::sqrt3 * self_margin_" \
  detection_stage "$culled"
mutant inflation_diagonal $candidates "std::numbers::sqrt3 * self_margin_" "self_margin_" detection_stage "$culled"
mutant body_margin $candidates "cloth(0.0), @margin_@," "0.5 * margin_" detection_stage "$boxes"
mutant body_thickness $candidates "0.5 * context_.rest_gap" "0.25 * context_.rest_gap" detection_stage "$boxes"
mutant margin $candidates " margin_(@context.rest_gap@)" "0.5 * context.rest_gap" detection_stage "$boxes:Margins.*"
mutant self_margin $candidates "self_margin_(@0.5@ * kPointReach" "0.25" detection_stage "$boxes:Margins.*"
mutant largest_rest_gap $near "pairs_.largest_rest_gap()" "0.5 * pairs_.largest_rest_gap()" detection_stage "$boxes"
mutant cover_bodies $candidates "<= @kOfMargin * margin_@)" "2.0 * margin_" detection_stage "Margins.*"
mutant cover_self $candidates "@2.0@ * kOfMargin * self_margin_" "4.0" detection_stage "Margins.*"
mutant cover_boxes $candidates "bodies_idle_ || @body_search_.compares_boxes()@" "true" detection_stage "Margins.*"
mutant cover_self_boxes $candidates "boxes = @broad_self_->traits().pairs != PairSet::culled@" "true" \
  detection_stage "$culled"
mutant cover_start $candidates "searched[i].cwiseMin(@x_t0[i]@)" "searched[i].cwiseMin(2.0 * x_t0[i] - x_t1[i])" \
  detection_stage "$boxes:Margins.*"
mutant search_boxes $search "std::numbers::sqrt3 * margin : @margin@;" "0.5 * margin" detection_stage "$boxes"
mutant search_distance $search "std::numbers::sqrt3 * margin" "0.5 * std::numbers::sqrt3 * margin" \
  detection_stage "$boxes"
mutant search_diagonal $search "std::numbers::sqrt3 * margin" "margin" detection_stage "$boxes"
mutant verlet_margin $verlet "search_wide(wide_a, wide_b, self, list.pairs)" \
  "search_wide([&] { SurfaceView s = wide_a; s.thickness -= 0.5 * margin_a; return s; }(),
     [&] { SurfaceView s = wide_b; s.thickness -= 0.5 * margin_b; return s; }(), self, list.pairs)" \
  broadphase 'VerletList.*'

# Contacts: from where on pairs take part.
mutant proximity_reach $near "kProximityReach = @4.0@" 2.0 detection_stage "$contacts"
mutant point_reach $near "kPointReach = @1.5@" 0.75 detection_stage "$contacts"
mutant point_reach_used $near ".reach = @kPointReach@" "0.5 * kPointReach" detection_stage "$contacts"
mutant secondary_reach $near "kSecondaryReach = @1.1@" 0.55 detection_stage "$contacts"
mutant secondary_share $near "kSecondaryShare = @0.5@" 0.25 detection_stage "$contacts"
mutant start_share $near "kStartShare = @0.9@" 0.45 detection_stage "$contacts"
mutant same_normal $near "kSameNormal = @0.95@" 0.475 detection_stage "$contacts"
mutant wide_enough $clearances "kWideEnough = @0.05@" 0.025 detection_stage "$contacts"
mutant point_slope $filter "kPointSlope = @1e-6@" 0.5e-6 detection_stage "ContactFilter.*"
mutant edge_slope $filter "kEdgeSlope = @0.1@" 0.05 detection_stage "ContactFilter.*"
mutant border $filter "kBorder = @1e-9@" 0.5e-9 detection_stage "ContactFilter.*"

# Pairs that floats tell apart. Half of the slack is just enough, since the errors of four numbers and two sums can add
# up to it, but sums of numbers near 1 lie on a grid of 2^-22: only an eighth is seen to miss one. The slacks of lengths
# count two slacks where one eighth serves; without them pairs at the edge of the reach are lost.
mutant float_slack $floats "kSlack = @0x1p-20@" 0x1p-23 narrowphase 'FindContacts.WhatFloats*'
mutant float_gap $floats "kOfGap = @2.0@" 0.0 narrowphase 'FindProximities.FloatsLose*'
mutant float_spread $floats "of_spread = @of_gap + kOfSpread * slack_@" 0.0 narrowphase 'FindProximities.FloatsLose*'

# Rooms of pairs, and what their vertices moved since. Skipping rooms by the largest motion of all vertices is a shortcut.
mutant room $distance "std::copy_n(room.begin(), block.size, rooms.begin() + static_cast<std::ptrdiff_t>(i));" \
  "for (int j = 0; j < block.size; ++j) rooms[i + j] = 1.1F * room[j];" narrowphase 'FindProximities.NoPair*'
mutant room_moved $certificates "> @moved(pairs[i])@" "0.5F * moved(pairs[i])" detection_stage "$boxes"
mutant room_most $certificates "2.0F * most" "1.0F * most" detection_stage "$boxes"

# Proofs that nothing has to be searched.
mutant plan_proximity $detection "proximity = @kPointReach * thickness@" "0.5 * kPointReach * thickness" \
  detection_stage "$contacts"
# Between pieces, and between cloth and bodies, boxes must be 4 + 2 largest thicknesses apart, but only 2 and 1.5 are
# needed by the margins and reaches above: half of it, 3, misses nothing. A quarter and an eighth do.
mutant plan_pieces $plan "@distances_.reach + 2.0 * distances_.margin@)" \
  "0.2 * (distances_.reach + 2.0 * distances_.margin)" detection_stage "Margins.*"
mutant plan_bodies $plan "least = @distances_.reach + 2.0 * distances_.margin@" \
  "0.125 * (distances_.reach + 2.0 * distances_.margin)" detection_stage "Margins.*"
# Any positive number serves, 1e-6 is for rounding: only one below 0 misses something.
mutant plan_apart $plan "kApart = @1e-6@" -4.0 detection_stage "$contacts"
mutant sheet_near $proofs "for_near = @distance / nearest_@" "0.5 * distance / nearest_" detection_stage 'SheetProof.*'
# Bounds of SheetProof are wider than they need to be: no state is known that is judged wrongly with half of them. Far
# pairs do not collide with any bound above 0; one below 0 misses a roll that closes. The bounds on what a motion changes
# take the largest change of every edge at once. With a tenth of sheet_moved, or ten times what sheet_spare may use up,
# folds are missed. Half of sheet_change is enough for every rotation (cos 2a >= cos a - sin a); none is not.
mutant sheet_far $proofs "for_far = @distance / far_@" "distance / far_ - 1.0" detection_stage 'SheetProof.*'
mutant sheet_moved $proofs "3.0 * std::numbers::sqrt2" "0.3 * std::numbers::sqrt2" detection_stage 'SheetProof.*'
mutant sheet_change $proofs "least - std::sqrt(fastest)" "least" detection_stage 'SheetProof.*'
mutant sheet_spare $proofs "kOfSpare = @0.99@" 9.9 detection_stage 'SheetProof.*'
mutant strain_growth $reach "return (@(high - low).norm()@ + rounding)" "0.5 * (high - low).norm()" \
  detection_stage 'StrainReach.*'

compile_changes
try link "$WORK/detection_stage" "$WORK"/*.o $DETECTION_STAGE
try link "$WORK/narrowphase" "$WORK"/*.o $NARROWPHASE
try link "$WORK/broadphase" "$WORK"/*.o $BROADPHASE
tried || { echo "The test programs do not link"; exit 1; }

try passes detection_stage "$boxes:$culled:$contacts:Margins.*:ContactFilter.*:SheetProof.*:StrainReach.*"
try passes narrowphase 'FindContacts.*:FindProximities.*'
try passes broadphase 'VerletList.*'
for name in "${names[@]}"; do try is_found "$name"; done
tried
