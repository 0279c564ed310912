/* SPDX-License-Identifier: MIT */
/* The C interface: a collision of two triangles, then cloth on a ball, whose corner is pulled, with a state
   that is saved and restored, and the judge's verdict. */
#include <selvedge.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(int code) {
  if (code == SELVEDGE_OK) return;
  fprintf(stderr, "selvedge: %s\n", selvedge_last_error());
  exit(code);
}

static void find_collisions(void) {
  const double start[] = {0, 0, 1, 1, 0, 1, 0, 1, 1}, end[] = {0, 0, -1, 1, 0, -1, 0, 1, -1};
  const double ground[] = {-1, -1, 0, 3, -1, 0, -1, 3, 0};
  const int32_t triangle[] = {0, 1, 2};
  const selvedge_surface falling = {start, end, 3, triangle, 1}, resting = {ground, NULL, 3, triangle, 1};
  selvedge_detector* detector;
  selvedge_contacts* found;
  check(selvedge_detector_create(NULL, NULL, 0.0, &detector));
  check(selvedge_find_collisions(detector, &falling, &resting, &found));
  printf("%zu collisions, the first at t = %g\n", found->count, found->toi[0]);
  selvedge_contacts_free(found);
  selvedge_detector_free(detector);
}

static const char* const kScene =
    "{\"materials\": {\"default\": {\"density\": 0.15, \"bending_stiffness\": 2e-5}},"
    " \"geometry\": [{\"cells\": [20, 20], \"transformation\": {\"translation\": [0, 0, 0.32]}}],"
    " \"obstacles\": [{\"shape\": {\"type\": \"sphere\", \"radius\": 0.3}}], \"time\": {\"frames\": 40}}";

/* Pulls vertex 0 upwards until the last frame. */
static void pull(selvedge_simulation* simulation, int frames) {
  const int32_t corner = 0;
  for (int frame = 1; frame <= frames; ++frame) {
    double x[3];
    memcpy(x, selvedge_simulation_positions(simulation), sizeof x);
    x[2] += 0.001;
    check(selvedge_simulation_hold(simulation, &corner, 1, x));
    check(selvedge_simulation_advance(simulation, frame + frames));
  }
}

int main(void) {
  selvedge_scene* scene;
  selvedge_simulation* simulation;
  selvedge_state* half_way;
  selvedge_contacts* contacts;
  selvedge_verdict verdict;
  char first[17], again[17];
  find_collisions();

  check(selvedge_scene_create(kScene, NULL, &scene));
  const int half = selvedge_scene_frames(scene) / 2;
  check(selvedge_simulation_create(scene, NULL, 0, &simulation));
  selvedge_scene_free(scene);
  check(selvedge_simulation_advance(simulation, half));
  check(selvedge_simulation_save(simulation, &half_way));
  pull(simulation, half);
  check(selvedge_simulation_hash(simulation, first));
  check(selvedge_simulation_restore(simulation, half_way));
  selvedge_state_free(half_way);
  pull(simulation, half);
  check(selvedge_simulation_hash(simulation, again));

  check(selvedge_simulation_contacts(simulation, &contacts));
  selvedge_surface cloth = {selvedge_simulation_positions(simulation), NULL,
                            selvedge_simulation_vertices(simulation), NULL, 0};
  cloth.triangles = selvedge_simulation_triangles(simulation, &cloth.triangle_count);
  selvedge_surface ball = {selvedge_simulation_body_positions(simulation), NULL,
                           selvedge_simulation_body_begin(simulation, 1), NULL, 0};
  ball.triangles = selvedge_simulation_body_triangles(simulation, &ball.triangle_count);
  check(selvedge_judge(&cloth, &ball, NULL, &verdict));
  printf("after %g s: %zu contacts, %llu crossings, state %s, %s after the restored half\n",
         selvedge_simulation_time(simulation), contacts->count,
         (unsigned long long)(verdict.self_crossings + verdict.body_crossings), first,
         strcmp(first, again) == 0 ? "equal" : "not equal");
  const int clean = verdict.self_crossings + verdict.body_crossings == 0;
  selvedge_contacts_free(contacts);
  selvedge_simulation_free(simulation);
  return clean && strcmp(first, again) == 0 ? 0 : 1;
}
