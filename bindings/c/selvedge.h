/* SPDX-License-Identifier: MIT */
/*
 * The C interface of selvedge: detection, exact queries, the judge, simulations in memory, and
 * garments put on bodies.
 *
 * Arrays. Positions are n rows of three doubles, in metres; triangles are rows of three vertex
 * indices. Arrays that you pass are read during the call only, unless a comment says more.
 *
 * Errors. A function that returns int returns a code, 0 for success. selvedge_last_error() has the
 * sentence: what is wrong, where, and what helps. Results are written only on success. A handle
 * that is null, or an array that is null though its length is not 0, is SELVEDGE_INVALID; a query
 * that returns no code answers 0 or NULL. All *_free functions accept NULL.
 *
 * Ownership. Functions that write to a pointer to a pointer give you the object; free it with the
 * function of its type. `const` pointers into an object belong to the object.
 *
 * Threads. All functions may be called from any thread. One thread at a time may use one detector
 * or one simulation; a call that would change it meanwhile returns SELVEDGE_BUSY. A call uses all
 * processors inside, unless selvedge_set_threads() says otherwise; results have the same bits for
 * any number.
 *
 * Stability. The interface only grows: structures that you fill never change, structures that the
 * library fills may get new fields at their end, and functions keep their meaning while
 * selvedge_interface_version() is 1.
 */
#ifndef SELVEDGE_H
#define SELVEDGE_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define SELVEDGE_API __declspec(dllexport)
#else
#define SELVEDGE_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Codes. */
enum {
  SELVEDGE_OK = 0,
  SELVEDGE_INVALID = 1,   /* an argument cannot be used */
  SELVEDGE_FAILED = 2,    /* the simulation cannot continue; its last good state is kept. Or a
                             garment cannot be put on */
  SELVEDGE_BUSY = 3,      /* another thread uses the object */
  SELVEDGE_NO_MEMORY = 4, /* nothing has changed */
  SELVEDGE_INTERNAL = 5   /* a fault of selvedge; please report the sentence */
};

/* ---- The library ---- */

/* 1. A later library with the same number serves a program that was compiled with this header. */
SELVEDGE_API int selvedge_interface_version(void);
/* Version, licence and the libraries inside, in lines. */
SELVEDGE_API const char* selvedge_version(void);
/* The sentence of the last call of this thread that failed; "" if none has. Valid until the next
   failure in this thread. */
SELVEDGE_API const char* selvedge_last_error(void);
/* Threads that loops of this process use from now on, 0: all processors. Call it while no other
   function runs. */
SELVEDGE_API int selvedge_set_threads(int threads);
/* Name of broad phase or narrow phase number `i`, from 0; NULL beyond the last. */
SELVEDGE_API const char* selvedge_broad_phase(size_t i);
SELVEDGE_API const char* selvedge_narrow_phase(size_t i);

/* ---- Detection ---- */

/* A surface during one step: every vertex moves on a straight line from x_t0 to x_t1. For
   questions about one state, x_t1 may be NULL: nothing moves. */
typedef struct selvedge_surface {
  const double* x_t0; /* (vertices,3), m */
  const double* x_t1;
  size_t vertices;
  const int32_t* triangles; /* (triangle_count,3) */
  size_t triangle_count;
} selvedge_surface;

/* Kinds of pairs: which primitives, and the order of their four vertices. */
enum {
  SELVEDGE_POINT_TRIANGLE = 0, /* point of a, then the corners of a triangle of b */
  SELVEDGE_TRIANGLE_POINT = 1, /* point of b, then the corners of a triangle of a */
  SELVEDGE_EDGE_EDGE = 2       /* the ends of an edge of a, then those of an edge of b */
};

/* Pairs of primitives with the points where they touch; column by column. Columns that a function
   does not have are NULL. */
typedef struct selvedge_contacts {
  size_t count;
  const uint8_t* kind;       /* (count) SELVEDGE_POINT_TRIANGLE, ... */
  const int32_t* vertices;   /* (count,4) */
  const double* weights;     /* (count,4) signed barycentric weights, sum 0 */
  const double* normal;      /* (count,3) unit, from the second primitive towards the first */
  const int32_t* primitives; /* (count,2) vertex, triangle or edge (selvedge_edges) of each side */
  const double* toi;         /* (count) time of impact in [0,1] */
  const double* gap;         /* (count) m */
  const double* rest_gap;    /* (count) m, the distance that the simulation keeps */
  const double* impulse;     /* (count,3) N s, on the first primitive */
} selvedge_contacts;
SELVEDGE_API void selvedge_contacts_free(selvedge_contacts* contacts);

/* Pairs of indices: (count,2). */
typedef struct selvedge_pairs {
  size_t count;
  const int32_t* index;
} selvedge_pairs;
SELVEDGE_API void selvedge_pairs_free(selvedge_pairs* pairs);

/* A broad phase and a narrow phase by name (NULL: "bvh_aabb", "ccd_exact"), which keep their trees
   from call to call. Primitives at most `min_separation` (m, >= 0) apart count as colliding. */
typedef struct selvedge_detector selvedge_detector;
SELVEDGE_API int selvedge_detector_create(const char* broad_phase, const char* narrow_phase,
                                          double min_separation, selvedge_detector** out);
SELVEDGE_API void selvedge_detector_free(selvedge_detector* detector);
/* Collisions between a and b during the step, or of a with itself if b is NULL: every one, and
   with "ccd_exact" no other. Sorted by toi, then by kind and indices. Columns up to toi. */
SELVEDGE_API int selvedge_find_collisions(selvedge_detector* detector, const selvedge_surface* a,
                                          const selvedge_surface* b, selvedge_contacts** out);
/* Pairs whose paths may come within `distance` (m) of each other. Each `out` may be NULL; for one
   surface (b is NULL), triangle_point is empty. */
SELVEDGE_API int selvedge_find_candidates(selvedge_detector* detector, const selvedge_surface* a,
                                          const selvedge_surface* b, double distance,
                                          selvedge_pairs** point_triangle,
                                          selvedge_pairs** triangle_point,
                                          selvedge_pairs** edge_edge);
/* Triangles that cross, and triangles that touch without crossing, at x_t0. Exact. Each `out` may
   be NULL, and b for one surface. */
SELVEDGE_API int selvedge_find_meetings(const selvedge_surface* a, const selvedge_surface* b,
                                        selvedge_pairs** crossings, selvedge_pairs** touches);
/* Points and triangles, and edges, that are nearer than `distance` (m, > 0) at x_t0, sorted by gap.
   Columns up to primitives, and gap. b may be NULL. */
SELVEDGE_API int selvedge_find_contacts(const selvedge_surface* a, const selvedge_surface* b,
                                        double distance, selvedge_contacts** out);
/* The edges of triangles, lower index first, sorted: the numbers of edges everywhere above. */
SELVEDGE_API int selvedge_edges(const int32_t* triangles, size_t triangle_count,
                                selvedge_pairs** out);

/* A triangle mesh. */
typedef struct selvedge_mesh {
  size_t vertices;
  const double* x; /* (vertices,3), in the unit of the file */
  size_t triangle_count;
  const int32_t* triangles; /* (triangle_count,3) */
} selvedge_mesh;
/* Reads OBJ, PLY or OFF exactly: doubles, in the order of the file, polygons split into fans,
   nothing merged or dropped. */
SELVEDGE_API int selvedge_mesh_read(const char* file, selvedge_mesh** out);
SELVEDGE_API void selvedge_mesh_free(selvedge_mesh* mesh);

/* ---- Exact queries ---- */

/* n queries of 24 doubles each: four points at t = 0, then the same at t = 1; for
   SELVEDGE_POINT_TRIANGLE the point and the corners, for SELVEDGE_EDGE_EDGE the ends of both edges.
   Writes the time of impact of each, or infinity, to toi (n). Narrow phase by name; NULL:
   "ccd_exact", which neither misses a collision nor invents one. */
SELVEDGE_API int selvedge_impact_times(const char* narrow_phase, int kind, const double* queries,
                                       size_t n, double* toi);
/* The same decided by the judge, which shares no code with the narrow phases: the doubles next to
   the exact time from below and above, equal if it is a double; infinity for none. */
SELVEDGE_API int selvedge_touch_times(int kind, const double* queries, size_t n, double* lo,
                                      double* hi);

/* ---- The judge ---- */

/* Counts are exact. */
typedef struct selvedge_verdict {
  uint64_t self_crossings, body_crossings; /* pairs of triangles */
  uint64_t self_touches, body_touches;
  uint64_t inside_vertices;       /* of the mesh, inside the closed parts of the body */
  double max_penetration;         /* m, of these */
  double max_stretch;             /* strain of edges against the rest mesh; 0 without one */
  double max_compression;         /* the same */
  int32_t first_self_crossing[2]; /* triangles; -1: none */
  int32_t first_body_crossing[2];
} selvedge_verdict;
/* Judges a state, x_t0. body may be NULL, and so may rest (n,3), the positions of the mesh without
   strain. */
SELVEDGE_API int selvedge_judge(const selvedge_surface* mesh, const selvedge_surface* body,
                                const double* rest, selvedge_verdict* out);
/* Judges straight paths from x_t0 to x_t1: pairs of primitives without a common vertex that
   collide. body may be NULL. */
SELVEDGE_API int selvedge_judge_path(const selvedge_surface* mesh, const selvedge_surface* body,
                                     uint64_t* self_collisions, uint64_t* body_collisions);

/* ---- Scenes ---- */

/* A scene from the JSON text of a scene file. `file` need not exist: messages begin with it and
   relative paths start at its folder; NULL: "scene.json" in the working folder. */
typedef struct selvedge_scene selvedge_scene;
SELVEDGE_API int selvedge_scene_create(const char* json, const char* file, selvedge_scene** out);
SELVEDGE_API void selvedge_scene_free(selvedge_scene* scene);
/* The scene as read, with all defaults, as JSON. */
SELVEDGE_API const char* selvedge_scene_json(const selvedge_scene* scene);
/* The number of its last frame, and frames per second. */
SELVEDGE_API int selvedge_scene_frames(const selvedge_scene* scene);
SELVEDGE_API double selvedge_scene_fps(const selvedge_scene* scene);

/* ---- Simulations ---- */

/* The cloth of a scene in time. The scene may be freed. `driven` has the numbers of bodies that
   the program moves by selvedge_simulation_move_body. */
typedef struct selvedge_simulation selvedge_simulation;
SELVEDGE_API int selvedge_simulation_create(const selvedge_scene* scene, const size_t* driven,
                                            size_t driven_count, selvedge_simulation** out);
SELVEDGE_API void selvedge_simulation_free(selvedge_simulation* simulation);
/* Makes one accepted step. */
SELVEDGE_API int selvedge_simulation_step(selvedge_simulation* simulation);
/* Steps to the time of a frame, and verifies each frame. */
SELVEDGE_API int selvedge_simulation_advance(selvedge_simulation* simulation, int frame);

/* The state. Pointers are valid until the next call that steps, restores or frees. */
SELVEDGE_API double selvedge_simulation_time(const selvedge_simulation* simulation); /* s */
SELVEDGE_API int64_t selvedge_simulation_steps(const selvedge_simulation* simulation);
SELVEDGE_API size_t selvedge_simulation_vertices(const selvedge_simulation* simulation);
SELVEDGE_API const double* selvedge_simulation_positions(const selvedge_simulation* simulation);
SELVEDGE_API const double* selvedge_simulation_velocities(const selvedge_simulation* simulation);
SELVEDGE_API const int32_t* selvedge_simulation_triangles(const selvedge_simulation* simulation,
                                                          size_t* count);
/* All bodies joined, in the order of the scene, at the state's time. Body i has the vertices from
   selvedge_simulation_body_begin(i) up to that of i + 1. */
SELVEDGE_API size_t selvedge_simulation_bodies(const selvedge_simulation* simulation);
SELVEDGE_API size_t selvedge_simulation_body_begin(const selvedge_simulation* simulation, size_t i);
SELVEDGE_API const double* selvedge_simulation_body_positions(
    const selvedge_simulation* simulation);
SELVEDGE_API const int32_t* selvedge_simulation_body_triangles(
    const selvedge_simulation* simulation, size_t* count);

/* Input, which acts until it is set again. */
/* Forces (vertices,3) in N on the cloth beside those of the scene; NULL: none. */
SELVEDGE_API int selvedge_simulation_set_forces(selvedge_simulation* simulation,
                                                const double* forces);
/* Moves n vertices on straight lines to x (n,3) by the end of the next nominal step, and holds
   them there. */
SELVEDGE_API int selvedge_simulation_hold(selvedge_simulation* simulation, const int32_t* vertices,
                                          size_t n, const double* x);
/* Releases held vertices; NULL: all. */
SELVEDGE_API int selvedge_simulation_release(selvedge_simulation* simulation,
                                             const int32_t* vertices, size_t n);
/* Moves each of the n vertices of a driven body on a straight line to x (n,3) by the end of the
   next nominal step. */
SELVEDGE_API int selvedge_simulation_move_body(selvedge_simulation* simulation, size_t body,
                                               const double* x, size_t n);

/* Contacts of the last accepted step, at its end; all columns but primitives and toi. Vertices
   count the cloth first, then the bodies. */
SELVEDGE_API int selvedge_simulation_contacts(selvedge_simulation* simulation,
                                              selvedge_contacts** out);
/* A figure of the run since the start, by its name in result.json: "clean" (1 or 0),
   "unchecked" (1: paths between frames were not all searched), "max_stretch", "steps", or a counter
   such as "contacts"; or an energy in J: "energy.kinetic", "energy.gravity". */
SELVEDGE_API int selvedge_simulation_figure(selvedge_simulation* simulation, const char* name,
                                            double* out);
/* 16 hex digits of the positions and velocities, and a zero: equal states have equal hashes. */
SELVEDGE_API int selvedge_simulation_hash(selvedge_simulation* simulation, char out[17]);

/* All that a simulation carries from step to step, and where its driven bodies are. One that is
   restored from it, of the same scene with the same driven bodies, continues with the same bits.
   Input is forgotten. */
typedef struct selvedge_state selvedge_state;
SELVEDGE_API int selvedge_simulation_save(selvedge_simulation* simulation, selvedge_state** out);
SELVEDGE_API int selvedge_simulation_restore(selvedge_simulation* simulation,
                                             const selvedge_state* state);
SELVEDGE_API void selvedge_state_free(selvedge_state* state);

/* ---- Garments ---- */

/* A garment, sewn from a pattern around a body. */
typedef struct selvedge_garment selvedge_garment;
/* How it is put on; {0} with edge_length set is enough. */
typedef struct selvedge_dress_options {
  double edge_length;   /* m, of the triangles of the garment, such as 0.02 */
  const char* fabric;   /* by name, such as "denim", or a file; NULL: a knit */
  double body_friction; /* Coulomb coefficient; 0: 0.4 */
  char pattern_up;      /* axis of the pattern that points up, 'x', 'y' or 'z'; 0: 'y' */
  char fit_origin;      /* 1: a pattern that stands beside the body is moved to it */
} selvedge_dress_options;
/* Puts on a pattern, the JSON text of a GarmentCode file, which `name` stands for in messages. The
   body, x_t0 of closed parts, is in m with z up. Takes seconds to minutes. SELVEDGE_FAILED:
   the garment cannot be put on, and the sentence says why. */
SELVEDGE_API int selvedge_dress(const char* pattern, const char* name, const selvedge_surface* body,
                                const selvedge_dress_options* options, selvedge_garment** out);
SELVEDGE_API void selvedge_garment_free(selvedge_garment* garment);
/* As worn, in m with z up; its flat pattern, of which triangle i corresponds; and the body on which
   it lies: its skin goes back where it leaves cloth no room. */
SELVEDGE_API const selvedge_mesh* selvedge_garment_mesh(const selvedge_garment* garment);
SELVEDGE_API const selvedge_mesh* selvedge_garment_flat(const selvedge_garment* garment);
SELVEDGE_API const selvedge_mesh* selvedge_garment_body(const selvedge_garment* garment);
/* "good", or a sentence: how it fits badly, or why it is not worn. */
SELVEDGE_API const char* selvedge_garment_verdict(const selvedge_garment* garment);
/* "worn", "good", "clean", "sewn", "at_rest" (1 or 0), "max_stretch", "drop_m", "states_judged". */
SELVEDGE_API int selvedge_garment_figure(const selvedge_garment* garment, const char* name,
                                         double* out);
/* 16 hex digits of the positions and velocities. */
SELVEDGE_API const char* selvedge_garment_hash(const selvedge_garment* garment);

#ifdef __cplusplus
}
#endif

#endif
