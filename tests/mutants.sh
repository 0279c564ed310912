#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# mutants.sh: proves that the tests of the exact narrow phase can fail. CTest calls it with the environment below.
# 1. Builds the narrow phase at -O0, too. Verdicts, times and contacts of a fixed set of queries must have the same
#    digest there, in the library, and on every vector path.
# 2. Takes away its error bounds and turns its comparisons, one at a time (mutants_lib.sh). Each of these mutants must
#    give a wrong answer to one of the queries of `ccd_trial`; a change whose pattern is not in the source any more is
#    an error.
#
#   OBJECTS         object files of ccd_trial
#   LIBRARIES       libraries of ccd_trial, the narrow phase among them
#   others          see mutants_lib.sh
# shellcheck disable=SC2086,SC2153
set -uo pipefail
# shellcheck source=tests/mutants_lib.sh
source "$SOURCE/tests/mutants_lib.sh"

exact=(ccd_exact distance narrow_phase ../core/base/big_int detail/ccd_filter
       detail/exact_query detail/float_paths detail/in_plane detail/polynomial detail/polynomial_isolation
       detail/polynomial_root detail/root_floor detail/root_isolation detail/sharp_query)
# Those that the changes below reach.
changed=(detail/ccd_filter detail/exact_query detail/in_plane
         detail/polynomial detail/polynomial_isolation detail/polynomial_root detail/root_floor detail/root_isolation
         detail/sharp_query)

# compile_all LEVEL FOLDER SOURCES...: objects in FOLDER.
compile_all() {
  local level=$1 folder=$2 headers=$WORK/headers_$1.h source
  shift 2
  mkdir -p "$folder"
  grep -v "^#pragma once" "$SOURCE/cmake/precompiled.h" >"$headers"
  printf '%s\n' '#if __x86_64__' '#include <immintrin.h>' '#endif' >>"$headers"
  precompile "$headers" "-$level" || return 1
  for source in "$@"; do
    try compile "-$level" -include "$headers" -c "$(source_of "narrowphase/$source.cpp")" -o "$folder/${source//\//_}.o"
  done
  tried
}

# digest PROGRAM: what it answers, on each vector path.
digest() { "$1" --digest --queries 20000 --seed 11 | tee "$1.digest" | sed "s/^/$(basename "$1") /"; }

declare -A families  # of queries that show the mutant

# mutant NAME FILE FROM TO FAMILIES: a change (mutants_lib.sh) that a query of the families must show.
mutant() {
  change "$1" "$2" "$3" "$4"
  families[$1]=$5
}

# is_found NAME: 0 if an answer is wrong. A mutant may narrow a root for ever; the unchanged program needs a second.
is_found() {
  local name=$1 log=$WORK/$1.log status
  { (ulimit -t $most_seconds; SELVEDGE_MUTANT=$(number "$name") exec "$WORK/changed_O1" --threads 1 --queries $queries \
    --families ${families[$name]}) >"$log" 2>&1; } 2>/dev/null
  status=$?
  if [ $status = 0 ]; then
    echo "$name: LIVES: nothing was wrong in $queries queries of ${families[$name]}"
    return 1
  fi
  if [ $status = 1 ]; then
    echo "$name: found, $(tail -n 1 "$log" | sed 's/.*second; //')"
  else
    echo "$name: found, does not end within $most_seconds s (signal $((status - 128)))"
  fi
}

most_seconds=3
queries=4000

# Error bounds of the floating-point stages, and the rounding of halved coefficients. Not here:
# kSharpConstraintError, which no query can show to be needed. It counts beside kConstraintSlope * half_width, and
# locate() succeeds only where the cubic exceeds kSharpCubicError, 2^-94 of the product of the differences, half_width
# beside the root. Its slope is below 36 of these units, so that half_width > 2^-100 and the slope's part > 2^-97.
# Nor have queries been found (20,000 with three roots within 2^-26 to 2^-4) that need `least` in the test for a
# monotonic cubic, or the signs that locate() asks for after floor_of_root has enclosed the root; nor any that need
# kSlopeError, the curvature or the bracket in the proof by Newton's method: a root near which the slope is that small
# is too uncertain to pass the tests that follow.
bounds=narrowphase/detail/error_bounds.h
detail=narrowphase/detail
mutant cubic_error $bounds "kCubicError = @192.0@" 0.0 "moved_as_one_in_reals shared_vertex"
mutant bernstein_error $bounds "kBernsteinError = @96.0@" 0.0 "moved_as_one_in_reals shared_vertex"
mutant constraint_error $bounds "kConstraintError = @48.0@" 0.0 "vertex_on_turning_edge vertex_on_vertex"
mutant sharp_cubic_error $bounds "kSharpCubicError = @0x1p-94@" 0.0 \
  "vertex_on_vertex vertex_on_turning_edge moved_as_one_in_reals"
mutant constraint_slope $bounds "kConstraintSlope = @8.0@" 0.0 "close_roots_on_rim"
mutant halving_error $detail/root_isolation.cpp "(4.0 * m + 2.0) * kRoundoff" 0.0 "triple_root parallel_sides grazing"
mutant smallest $bounds "kSmallest = @0x1p-260@" 0.0 "products_at_the_range"
mutant largest $bounds "kLargest = @0x1p260@" 1e308 "products_at_the_range"
mutant place_cubic_error $bounds "kPlaceCubicError = @128.0@" 0.0 "close_roots_on_rim"
mutant cubic_value_error $bounds "kCubicValueError = @256.0@" 0.0 "close_roots_on_rim grazing"
mutant plane_axis $detail/in_plane.cpp "double best = @kConstraintError * kRoundoff@;" -1.0 \
  "in_turning_plane in_fixed_plane parallel_sides"

# Comparisons.
mutant axes_touch $detail/ccd_filter_kernel.inc "(hi0 < second_lo0) & (hi1 < second_lo1)" \
  "(hi0 <= second_lo0) & (hi1 <= second_lo1)" "static_overlap in_a_point"
mutant axes_one_end $detail/ccd_filter_kernel.inc "(hi0 < second_lo0) & (hi1 < second_lo1)" \
  "(hi0 < second_lo0) & (hi0 < second_lo0)" "vertex_on_vertex touch_at_end"
mutant one_sign_open_ends $detail/root_isolation.cpp "sign_at(lo, f[0], error) > 0 && sign_at(hi, f[3], error) > 0" \
  "f[0] >= 0.0 && f[3] >= 0.0" "vertex_on_turning_edge vertex_on_vertex"
roots=$detail/ccd_root_kernel.inc
mutant one_change $roots "one = @starts & (c3 < -error) & ((c1 > error) | (c2 < -error))@" "starts & (c3 < -error)" \
  "vertex_on_vertex rim_as_rounded"
mutant level_component $roots "excluded |= flat;" ";" "irrational_time_on_rim"
mutant root_at_a_double $roots "near.proves(radius, bracket) & (abs(root.lo) > off)" "near.proves(radius, bracket)" \
  "touch_between dyadic_time"
mutant root_floor_unsigned $detail/root_floor.cpp "if (sign == 0) return false;" ";" "beside_a_double triple_root"
mutant root_is_a_double $detail/polynomial_root.cpp "if (sign == 0) return at_double(t);" ";" "dyadic_time touch_between"
mutant clear_in_doubles $detail/polynomial_root.cpp "kError = @0x1p-46@" 0.0 "irrational_time_on_rim grazing"
mutant inside_open $detail/exact_query.cpp "root.sign(p) * sign < 0" "root.sign(p) * sign <= 0" \
  "rational_time dyadic_time"
mutant segment_open $detail/exact_query.cpp "root.sign(test.span) <= 0" "root.sign(test.span) < 0" \
  "in_a_point triple_root"
mutant order_by_remainder $detail/polynomial_root.cpp "side(@sign_p[i]@, lo[i], hi[i])" "-sign_p[i]" \
  "irrational_time_on_rim grazing"
mutant never_common $detail/polynomial_root.cpp "(@sign_p == 0 ? 0 : 1@)" 1 "irrational_time_on_rim grazing"
mutant order_of_roots $detail/polynomial_isolation.cpp "std::swap(roots[n - 1], roots[n]);" ";" "grazing triple_root grid"
mutant fixed_overflow $detail/fixed_int.h "@!fits@) [[unlikely]]" false "triple_root sliver rational_time_nudged"

# build LEVEL PROGRAM SOURCES...: ccd_trial with these sources of the narrow phase instead of the library's.
build() {
  local level=$1 program=$2
  shift 2
  compile_all "$level" "$WORK/$level" "$@" && link "$WORK/$program" "$WORK/$level"/*.o $OBJECTS && return 0
  echo "The narrow phase cannot be built apart"
  exit 1
}

# The unchanged sources come first, while the folder for changed headers is empty.
link "$WORK/library" $OBJECTS || exit 1
build O0 unchanged_O0 "${exact[@]}"
write_changes
build O1 changed_O1 "${changed[@]}"

for program in unchanged_O0 changed_O1 library; do try digest "$WORK/$program"; done
tried || exit 1
if [ "$(cat "$WORK"/*.digest | sed 's/.*: //' | sort -u | wc -l)" != 1 ] || [ "$(wc -l <"$WORK/library.digest")" != 3 ]; then
  echo "The digests of builds and vector paths differ"
  exit 1
fi

for name in "${names[@]}"; do try is_found "$name"; done
tried
