#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# mutants.sh: proves that the tests of the exact narrow phase can fail. CTest calls it with the environment below.
# 1. Builds the narrow phase at -O0 and at -O3. Verdicts, times and contacts of a fixed set of queries must have the
#    same digest in both and on every vector path.
# 2. Takes away its error bounds and turns its comparisons, one at a time, in a copy of the source. Each of these
#    mutants must give a wrong answer to one of the queries of `ccd_trial`; a change whose pattern is not in the
#    source any more is an error.
#
#   CXX, FLAGS      compiler and flags that the sources of the library need
#   SOURCE          root of the sources
#   INCLUDE         folder that holds selvedge/, a link to the sources
#   OBJECTS         object files of ccd_trial
#   LIBRARIES       libraries of ccd_trial, the narrow phase among them
#   WORK            folder for the results, made anew
#   JOBS            mutants at a time (default: processors)
set -uo pipefail
JOBS=${JOBS:-$(nproc)}
rm -rf "$WORK"
mkdir -p "$WORK"

exact=(ccd_exact distance narrow_phase detail/big_int detail/ccd_filter detail/ccd_filter_avx2 detail/ccd_filter_avx512
       detail/exact_query detail/float_paths detail/in_plane detail/polynomial detail/root_floor detail/root_isolation detail/sharp_query)
filters="detail/ccd_filter detail/ccd_filter_avx2 detail/ccd_filter_avx512"

# compile OUT OPTIONS FILE: OUT from a source of the narrow phase.
compile() {
  # shellcheck disable=SC2086
  "$CXX" -std=c++20 -DNDEBUG -ffp-contract=off $FLAGS $2 -I"$INCLUDE" "$3" -o "$1"
}

# precompile LEVEL: writes headers_LEVEL.h. Most of the compile time of a mutant goes to the standard library, Eigen and
# the vector instructions: they are compiled once for each level.
precompile() {
  local headers=$WORK/headers_$1.h
  cp "$SOURCE/cmake/precompiled.h" "$headers"
  printf '%s\n' '#if __x86_64__' '#include <immintrin.h>' '#endif' >>"$headers"
  compile "$headers.gch" "-$1 -x c++-header" "$headers"
}

# compile_source OUT LEVEL OPTIONS FILE: the object OUT.
compile_source() { compile "$1" "-$2 -include $WORK/headers_$2.h $3 -c" "$4"; }

# link OUT OBJECTS...: ccd_trial with these objects instead of the library's own. The library's objects hold several
# sources each. Of two definitions the linker takes the first, and position-independent code calls it everywhere.
link() {
  local out=$1
  shift
  # shellcheck disable=SC2086
  "$CXX" $FLAGS "$@" $OBJECTS -Wl,-z,muldefs -Wl,--start-group $LIBRARIES -Wl,--end-group -o "$out"
}

# ---- The same answers from every build and vector path

digest_of_level() {  # LEVEL
  local objects=() source
  mkdir -p "$WORK/$1"
  precompile "$1" || return 1
  for source in "${exact[@]}"; do
    compile_source "$WORK/$1/${source//\//_}.o" "$1" "" "$SOURCE/narrowphase/$source.cpp" || return 1
    objects+=("$WORK/$1/${source//\//_}.o")
  done
  link "$WORK/$1/trial" "${objects[@]}" && "$WORK/$1/trial" --digest --queries 20000 --seed 11 >"$WORK/$1/digest"
}

same_digests() {
  local level pids=()
  for level in O0 O3; do
    digest_of_level $level &
    pids+=($!)
  done
  for pid in "${pids[@]}"; do wait "$pid" || { echo "The narrow phase cannot be built apart"; return 1; }; done
  sed 's/^/O0 /' "$WORK/O0/digest"
  sed 's/^/O3 /' "$WORK/O3/digest"
  [ "$(cat "$WORK"/O?/digest | sed 's/.*: //' | sort -u | wc -l)" = 1 ] && [ "$(wc -l <"$WORK/O0/digest")" = 3 ]
}

# ---- Mutants

# mutant NAME FILE FROM TO SOURCES FAMILIES QUERIES: the first FROM in FILE becomes TO.
mutant() {
  local name=$1 file=$2 from=$3 to=$4 sources=$5 families=$6 queries=$7
  local folder=$WORK/$name text changed source objects=()
  mkdir -p "$folder/selvedge/narrowphase/detail"
  text=$(cat "$SOURCE/narrowphase/$file")
  changed=${text/"$from"/"$to"}
  [ "$changed" != "$text" ] || { echo "$name: \"$from\" is not in narrowphase/$file any more"; return 1; }
  printf '%s\n' "$changed" >"$folder/selvedge/narrowphase/$file"
  for source in $sources; do
    local path=$SOURCE/narrowphase/$source.cpp
    [ "$source.cpp" != "$file" ] || path=$folder/selvedge/narrowphase/$file
    compile_source "$folder/${source//\//_}.o" O1 "-I$folder" "$path" || { echo "$name: does not compile"; return 1; }
    objects+=("$folder/${source//\//_}.o")
  done
  link "$folder/trial" "${objects[@]}" || { echo "$name: does not link"; return 1; }
  # A mutant may narrow a root for ever; the unchanged program needs a second.
  # shellcheck disable=SC2086
  { (ulimit -t "$most_seconds"; exec "$folder/trial" --threads 1 --queries "$queries" --families $families) \
    >"$folder/log" 2>&1; } 2>/dev/null
  local status=$?
  if [ $status = 0 ]; then
    echo "$name: LIVES: nothing was wrong in $queries queries of $families"
    return 1
  fi
  if [ $status = 1 ]; then
    echo "$name: found, $(tail -n 1 "$folder/log" | sed 's/.*second; //')"
  else
    echo "$name: found, does not end within $most_seconds s (signal $((status - 128)))"
  fi
}

most_seconds=3
running=0
failed=0
finish() {
  wait -n || failed=1
  running=$((running - 1))
}
try() {
  [ "$running" -lt "$JOBS" ] || finish
  mutant "$@" &
  running=$((running + 1))
}

precompile O1 || exit 1
same_digests || { echo "The digests of builds and vector paths differ"; exit 1; }

sharp="detail/sharp_query"
isolation="detail/root_isolation"
exact_query="detail/exact_query"
polynomial="detail/polynomial"

# Error bounds of the floating-point stages, and the rounding of halved coefficients. Not here:
# kSharpConstraintError, which no query can show to be needed. It counts beside kConstraintSlope * half_width, and
# locate() succeeds only where the cubic exceeds kSharpCubicError, 2^-94 of the product of the differences, half_width
# beside the root. Its slope is below 36 of these units, so that half_width > 2^-100 and the slope's part > 2^-97.
# Nor have queries been found (20,000 with three roots within 2^-26 to 2^-4) that need `least` in the test for a
# monotonic cubic, or the signs that locate() asks for after floor_of_root has enclosed the root; nor any that need
# kSlopeError, the curvature or the bracket in the proof by Newton's method: a root near which the slope is that small
# is too uncertain to pass the tests that follow.
bounds=detail/error_bounds.h
try cubic_error $bounds "kCubicError = 192.0" "kCubicError = 0.0" "$filters" \
  "moved_as_one_in_reals shared_vertex" 4000
try bernstein_error $bounds "kBernsteinError = 96.0" "kBernsteinError = 0.0" "$isolation" \
  "moved_as_one_in_reals shared_vertex" 4000
try constraint_error $bounds "kConstraintError = 48.0" "kConstraintError = 0.0" "$filters $isolation" \
  "vertex_on_turning_edge vertex_on_vertex" 4000
try sharp_cubic_error $bounds "kSharpCubicError = 0x1p-94" "kSharpCubicError = 0.0" "$filters $sharp" \
  "vertex_on_vertex vertex_on_turning_edge moved_as_one_in_reals" 4000
try constraint_slope $bounds "kConstraintSlope = 8.0" "kConstraintSlope = 0.0" "$filters $isolation" \
  "close_roots_on_rim" 4000
try halving_error detail/root_isolation.cpp "(4.0 * m + 2.0) * kRoundoff" "0.0 * kRoundoff" "$isolation" \
  "triple_root parallel_sides grazing" 4000
try smallest $bounds "kSmallest = 0x1p-260" "kSmallest = 0.0" "$filters $isolation" \
  "products_at_the_range" 4000
try largest $bounds "kLargest = 0x1p260" "kLargest = 1e308" "$filters $isolation" \
  "products_at_the_range" 4000
try place_cubic_error $bounds "kPlaceCubicError = 128.0" "kPlaceCubicError = 0.0" "$filters" \
  "close_roots_on_rim" 4000
try cubic_value_error $bounds "kCubicValueError = 256.0" "kCubicValueError = 0.0" "$filters" \
  "close_roots_on_rim grazing" 4000

try plane_axis detail/in_plane.cpp "double best = kConstraintError * kRoundoff;" "double best = -1.0;" \
  "detail/in_plane" "in_turning_plane in_fixed_plane parallel_sides" 4000

# Comparisons.
try axes_touch detail/ccd_filter_kernel.inc "(hi0 < second_lo0) & (hi1 < second_lo1)" \
  "(hi0 <= second_lo0) & (hi1 <= second_lo1)" "$filters" "static_overlap in_a_point" 4000
try axes_one_end detail/ccd_filter_kernel.inc "(hi0 < second_lo0) & (hi1 < second_lo1)" \
  "(hi0 < second_lo0) & (hi0 < second_lo0)" "$filters" "vertex_on_vertex touch_at_end" 4000
try one_sign_open_ends detail/root_isolation.cpp \
  "return sign_at(lo, f[0], error) > 0 && sign_at(hi, f[3], error) > 0" "return f[0] >= 0.0 && f[3] >= 0.0" \
  "$isolation" "vertex_on_turning_edge vertex_on_vertex" 4000
roots=detail/ccd_root_kernel.inc
try one_change $roots " & ((c1 > error) | (c2 < -error));" ";" "$filters" "vertex_on_vertex rim_as_rounded" 4000
try level_component $roots "excluded |= flat;" "" "$filters" "irrational_time_on_rim" 4000
try root_at_a_double $roots " & (abs(root.lo) > off)" "" "$filters" "touch_between dyadic_time" 4000
try root_floor_unsigned detail/root_floor.cpp "if (sign == 0) return false;" "" "detail/root_floor" \
  "beside_a_double triple_root" 4000
try root_is_a_double detail/polynomial.cpp "if (sign == 0) return at_double(t);" "" "$polynomial" \
  "dyadic_time touch_between" 4000
try clear_in_doubles detail/polynomial.cpp "kError = 0x1p-46" "kError = 0.0" "$polynomial" \
  "irrational_time_on_rim grazing" 4000
try inside_open detail/exact_query.cpp "if (root.sign(p) * sign < 0) return false" \
  "if (root.sign(p) * sign <= 0) return false" "$exact_query" "rational_time dyadic_time" 4000
try segment_open detail/exact_query.cpp "return root.sign(test.span) <= 0" "return root.sign(test.span) < 0" \
  "$exact_query" "in_a_point triple_root" 4000
try order_by_remainder detail/polynomial.cpp "side(sign_p[i], lo[i], hi[i])" "side(-sign_p[i], lo[i], hi[i])" \
  "$polynomial" "irrational_time_on_rim grazing" 4000
try never_common detail/polynomial.cpp "(sign_p == 0 ? 0 : 1)" "1" "$polynomial" \
  "irrational_time_on_rim grazing" 4000
try order_of_roots detail/polynomial.cpp "std::swap(roots[n - 1], roots[n])" "(void)n" "$polynomial" \
  \
  "grazing triple_root grid" 4000
try fixed_overflow detail/fixed_int.h "if (!fits) [[unlikely]]" "if (false)" "$exact_query $polynomial" \
  "triple_root sliver rational_time_nudged" 4000

while [ "$running" -gt 0 ]; do finish; done
exit "$failed"
