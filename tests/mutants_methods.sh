#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# mutants_methods.sh: proves that a test tells each method from the method that it could be confused with. CTest calls it
# with the environment below. Each mutant is a method turned into the other one; a test of its filter must fail
# (mutants_lib.sh). A change whose pattern is not in the source any more is an error. With TABLE it writes the table
# docs/lab/tables/mutants.csv anew; without, the table must be as it would be.
#
#   BUILD           build folder of Ninja, whose commands link the test programs
#   others          see mutants_lib.sh
# shellcheck disable=SC2086,SC2153
set -uo pipefail
# shellcheck source=tests/mutants_lib.sh
source "$SOURCE/tests/mutants_lib.sh"

declare -A row_of method_of other_of program filter_of

# mutant NAME ROW METHOD OTHER FILE FROM TO PROGRAM FILTER: METHOD of a row of docs/lab/survey_map.md, changed into OTHER.
mutant() {
  change "$1" "$5" "$6" "$7"
  row_of[$1]=$2 method_of[$1]=$3 other_of[$1]=$4 program[$1]=$8 filter_of[$1]=$9
}

# Meshes.
mutant net_simplified I.7 "one diagonal in each cell" "both diagonals (rectangular)" core/patterns/topology_net.cpp \
  "return @detail::Diagonals::same@;" detail::Diagonals::both cloth 'SpringNets.*'
mutant net_responsive I.3 "springs across two cells along diagonals" "rows and columns only (rectangular)" \
  core/patterns/topology_net.cpp ".add(@net == SpringNet::responsive@)" false cloth 'SpringNets.*'
mutant net_triangular I.6 "a spring across every interior edge" "edges only" core/patterns/topology_net.cpp \
  "add(e.v[0], e.v[1], @constants.flexion@)" 0.0 cloth 'SpringNets.*'
mutant net_equal I.1 "equal constants in the net as printed" "shear of half the constant, as in a fabric" \
  core/patterns/topology_net.cpp "c.spring_diagonal = @constants.shear@;" "0.5 * constants.shear" cloth 'SpringNets.*'
mutant bilayered_relaxed I.4 "a dense layer with forces of its own" "dense vertices interpolated (hanging nodes)" \
  core/solver/following.cpp "offset_[i] = @all_mean_[i]@;" "Vec3(Vec3::Zero())" cloth 'Bilayered.*'
mutant hanging_nodes I.5 "hanging nodes eliminated, x = (a + b)/2" "hanging nodes with a motion of their own" \
  core/solver/following.cpp "followers_.spread(own.mean, end.mean);" \
  "for (std::size_t l = 0; l < own.mean.size(); ++l) end.mean[followers_.leaders()[l]] = own.mean[l];" \
  cloth 'Followers.*'
mutant hanging_mass I.5 "the weight of a hanging node on its leaders" "no weight (masses of the leaders alone)" \
  core/solver/following.cpp "followers.gather(std::span<const double>(all.mass), std::span(own.mass));" \
  "for (std::size_t l = 0; l < own.mass.size(); ++l) own.mass[l] = all.mass[leaders[l]];" cloth 'Followers.*'
mutant bisected_edge I.5 "bisection of the longest edge (Rivara)" "of the edge opposite the newest vertex" \
  core/patterns/adaptive_triangles.cpp "return @longest@;" \
  "cuts_[triangle].empty() ? longest : t[1] == cuts_[triangle].back() ? 2 : 1" \
  cloth 'AdaptiveTriangles.*Half'
mutant bisected_quarters I.5 "four quarters by two bisections" "halves by one" core/patterns/adaptive_triangles.cpp \
  "kBisectionsPerLevel = @2@;" 1 cloth 'AdaptiveTriangles.SplitEverywhere*'

# Internal forces.
mutant kawabata III.2 "tension by LT and EMT" "Hooke's law" core/cloth/force_spring_curve.cpp \
  "scale * s * (@1.0 + gamma * s * s@), slope_scale" 1.0 forces 'CurveSprings.*'
mutant measured_curve III.2 "the measured tension curve" "Hooke's law of its slope at rest" core/cloth/force_spring_curve.cpp \
  "if (@d <= 0.0@) return" true lab 'MeasuredTension.*'
mutant measured_bending III.2 "M(kappa) turned to F(d) by the chord" "a spring with the moment over the length of a cell" \
  core/cloth/force_chord.cpp "-w * m.force / (@d * sine@)" d lab 'ChordLink.*'
mutant angle_shear III.2 "shear by the angle of warp and weft" "shear of the springs of edges" core/cloth/cloth_mesh.cpp \
  "on_triangles = @shear_law_of(m).by_triangles@;" false lab 'AngleShear.*'
mutant angle_sine III.2 "the angle of warp and weft" "its sine" core/cloth/force_yarn.cpp \
  "shear = @angle.value - 0.5 * std::numbers::pi@;" "-elementary::cos(angle.value)" lab 'AngleShear.*'
mutant angle_gradient III.2 "the gradient of the angle" "that of its sine" core/cloth/force_yarn.cpp \
  "s.gradient = angle.gradient;" \
  "for (int k = 0; k < 3; ++k) s.gradient[k] = elementary::sin(angle.value) * angle.gradient[k];" \
  forces '*EveryInternalForce.IsMinus*'
mutant beam III.7 "beam, linear in the displacement" "twisting spring, linear in the angle (Dai)" core/cloth/force_beam.cpp \
  "s.moment = stiffness * @bend@;" "2.0 * std::asin(std::min(1.0, 0.5 * bend))" forces 'Beam.*'
mutant beam_lengths III.7 "one displacement of two unequal beams" "eq. 4 for each beam by itself" core/cloth/force_beam.cpp \
  "s.weight = {@1.0 / p@, -1.0 / p - 1.0 / q, 1.0 / q};" "2.0 / (p + q)" forces 'Beam.*'
mutant bridson III.8 "sine of half the angle (Bridson)" "the angle (hinge)" core/cloth/force_bridson.cpp \
  "2.0 * k * (@elementary::sin(0.5 * d.angle)@ - sine0)" "0.5 * d.angle" forces 'BridsonHinges.*'
mutant genetic_kinds III.9 "natural length of each kind of springs" "one length for all kinds" lab/identify_net.cpp \
  "rest_length *= @kind.length@;" "kinds[0].length" lab 'NetIdentification.*'
mutant genetic_limit III.9 "an elongation rate to look for" "a rate given beforehand" lab/identify_net.cpp \
  "strain_limit[s] = @kind.limit@;" 0.1 lab 'NetIdentification.*'

# External forces.
mutant sewing IV.5 "an acceleration of the pair" "a force (eq. 10 as printed)" core/cloth/force_sewing.cpp \
  "@reduced_mass(e, mass)@ * config.acceleration" 1.0 forces 'Sewing.*'
mutant sewing_merged IV.5 "a closed seam becomes one vertex" "a seam that stays two rows" simulation/seam_merging.cpp \
  "norm() > @distance@) continue" 0.0 run 'SeamScenes.AClosedSeam*'
mutant air_sign IV.4 "wind that pushes along itself" "eq. 9 as printed, upwind" core/cloth/force_air.cpp \
  "area / 3.0 * n.dot(@u - v@)" "Vec3(v - u)" cloth 'AirForce.*'
mutant air_flow IV.4 "the flow at each triangle" "one constant vector" core/cloth/force_air.cpp "@flow_.is_uniform()@ ?" true cloth \
  'AirForce.*'

# Limiters, integrators.
mutant han V.6b "limits stretch and compression (Han)" "stretch alone (velocity, Vassilev)" core/solver/strain_limiter_han.cpp \
  "@std::max(0.0, l0 - most)@, l0 + most" 0.0 integrators 'HanLimiter.*'
mutant han_along V.6b "along the spring at the end of the step" "along the spring at its start" \
  core/solver/strain_limiter_han.cpp "n = @length > 0.0@ ?" false integrators 'HanLimiter.*'
mutant han_curve V.6b "a cubic that stiffens both ways" "Hooke's law" core/solver/strain_limiter_han.cpp "d * d * d * d, @c * d * d * d@, 3.0" \
  0.0 integrators 'HanLimiter.*'
mutant bdf2 VII.3 "second order" "implicit Euler" core/solver/integrator_bdf2.cpp "two_steps_[k] = @next_h_[k] > 0.0@" false \
  integrators 'OscillatorOrder.*'
mutant bdf2_pieces VII.3 "implicit Euler for the piece in contact" "for the whole step" core/solver/integrator_bdf2.cpp \
  "start.touched && @start.touched_particles.empty()@" true scene 'IntegratorScene.Bdf2*'

# Detection, rivals, yarns.
mutant image_normal VIII.2 "the normal of the map" "that of the triangle of a pair" broadphase/image_space/particle_maps.cpp \
  "best.normal = chosen.normal;" \
  "best.normal = (body.x_t1[t[1]] - body.x_t1[t[0]]).cross(body.x_t1[t[2]] - body.x_t1[t[0]]).normalized();" image_space \
  'ParticleMapsScene.*'
mutant image_distance VIII.2 "distance along the normal" "depth along the axis" broadphase/image_space/particle_maps.cpp \
  "-one.depth * @std::abs(one.normal[axis])@" 1.0 image_space 'ParticleMaps.*'
mutant image_views VIII.2 "front, back and side views" "front and back" broadphase/image_space/particle_maps.cpp \
  "first(@count@)" 1 image_space 'ParticleMaps.*'
mutant green beyond "Green's strain (St. Venant-Kirchhoff)" "elongations along warp and weft (springs)" \
  core/cloth/force_membrane.cpp "{@0.5 * (f_.col(0).squaredNorm() - 1.0)@," "f_.col(0).norm() - 1.0" forces \
  'StVenantKirchhoff.*:Membrane.*'
mutant corotated beyond "a frame that turns with the triangle (corotated)" "a frame along its longer side" \
  core/cloth/force_membrane.cpp "sine = @in_frame(1, 0) - in_frame(0, 1)@;" 0.0 forces '*EveryInternalForce.IsMinus*'
mutant catenary beyond "catenary (Weil)" "parabola" lab/geometric_drape.cpp "c * (@std::hypot(1.0, q)@ - height)" \
  "1.0 + 0.5 * q * q" lab 'Catenary.*'
mutant weave beyond "the weave of its matrix (twill)" "plain" core/patterns/topology_weave.cpp "return @(place + repeat) % repeat < over@;" \
  "(i + j) % 2 == 0" lab 'Weave.*'
mutant weave_crimp beyond "crimps of warp and weft that add up" "flat yarns" core/patterns/topology_weave.cpp \
  "return @crimp_share * (warp.diameter() + weft.diameter())@;" 0.0 lab 'Weave.*'
mutant knit beyond "the sinker behind the legs and the head before them" "a flat loop" core/patterns/topology_knit.cpp \
  "return {k < top ? -half.x() : half.x(), half.y(), @back ? 2.0 * middle_ - z : z@};" 0.0 lab 'Knit.*'

run() {
  { (ulimit -t $most_seconds; SELVEDGE_MUTANT=$3 exec "$WORK/${program[$2]}_tests" --gtest_filter="${filter_of[$2]}" --gtest_brief=1 \
    --gtest_fail_fast) >"$1" 2>&1; } 2>/dev/null
}

is_found() {
  local name=$1 log=$WORK/$1.log
  if ! run "$log.plain" "$name" 0; then
    echo "$name: ${filter_of[$name]} does not pass with nothing changed: $(tail -n 3 "$log.plain")"
    return 1
  fi
  if run "$log" "$name" "$(number "$name")"; then
    echo "$name: LIVES: ${filter_of[$name]} passes"
    return 1
  fi
  sed -n 's/^\[  FAILED  \] \([A-Za-z/_0-9.]*\).*/\1/p' "$log" | head -n 1 >"$WORK/$name.found"
  [ -s "$WORK/$name.found" ] || echo "no end within $most_seconds s" >"$WORK/$name.found"
  echo "$name: found by $(cat "$WORK/$name.found")"
}

most_seconds=60

compile_changes
# link_tests NAME FOLDERS...: the test program with the changed sources of these folders.
link_tests() {
  local name=$1 folder objects=()
  shift
  for folder in "$@"; do objects+=("$WORK/${folder}_"*.o); done
  link_again "${name}_tests" "${objects[@]}"
}
for one in cloth forces integrators scene; do try link_tests $one core; done
try link_tests lab core lab
try link_tests run core simulation
try link_tests image_space broadphase
tried || { echo "The test programs do not link"; exit 1; }
for name in "${names[@]}"; do try is_found "$name"; done
tried || exit 1
{
  echo "row,method,confused with,test that fails"
  for name in "${names[@]}"; do
    printf '%s,"%s","%s",%s\n' "${row_of[$name]}" "${method_of[$name]}" "${other_of[$name]}" "$(cat "$WORK/$name.found")"
  done
} >"$WORK/mutants.csv"
[ -z "${TABLE:-}" ] || cp "$WORK/mutants.csv" "$TABLE"
diff "$SOURCE/docs/lab/tables/mutants.csv" "$WORK/mutants.csv" || { echo "docs/lab/tables/mutants.csv is not up to date"; exit 1; }
