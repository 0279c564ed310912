// SPDX-License-Identifier: MIT
/** Positions are flat arrays of x, y, z in metres, triangles flat arrays of three vertex indices. Results are copies. */
export type Numbers = Float64Array | ArrayLike<number>;

/** A surface during a step: every vertex moves on a straight line from x0 to x1. Without x1 nothing moves. */
export interface Surface {
  x0: Numbers;
  x1?: Numbers | null;
  triangles: Int32Array | ArrayLike<number>;
}

/** An argument that cannot be used (code 1), or no memory (code 4). The message names the place. */
export class SelvedgeError extends Error {
  code: number;
}

export const POINT_TRIANGLE: 0;
export const TRIANGLE_POINT: 1;
export const EDGE_EDGE: 2;

/** Row i of each column is pair i: kind (1), vertices (4), weights (4), normal (3), primitives (2). */
export interface Contacts {
  count: number;
  kind: Uint8Array;
  vertices: Int32Array;
  weights: Float64Array;
  normal: Float64Array;
  primitives: Int32Array;
}
export interface Collisions extends Contacts {
  /** Times of impact in [0,1]. */
  toi: Float64Array;
}
export interface Proximities extends Contacts {
  /** Distances, m. */
  gap: Float64Array;
}

export interface DetectorOptions {
  broadPhase?: string | null;
  narrowPhase?: string | null;
  /** m; primitives at most this far apart count as colliding. */
  minSeparation?: number;
}

/** A broad and a narrow phase that keep their trees from call to call. */
export class Detector {
  constructor(options?: DetectorOptions);
  findCollisions(a: Surface, b?: Surface | null): Collisions;
  findCandidates(a: Surface, b?: Surface | null, distance?: number):
    { pointTriangle: Int32Array; trianglePoint: Int32Array; edgeEdge: Int32Array };
}

/** Collisions between a and b during the step, or of a with itself: every one, and no other. */
export function findCollisions(a: Surface, b?: Surface | null, options?: DetectorOptions): Collisions;
/** Pairs of triangles that cross, and that touch without crossing, at x0. Exact. */
export function findMeetings(a: Surface, b?: Surface | null): { crossings: Int32Array; touches: Int32Array };
/** Pairs nearer than `distance` (m) at x0. */
export function findContacts(a: Surface, b: Surface | null, distance: number): Proximities;
/** The edges of triangles, in the order of their numbers. */
export function edges(triangles: Int32Array | ArrayLike<number>): Int32Array;
/** Times of impact of queries of 24 numbers (four points at t = 0, then at t = 1), Infinity for none. */
export function impactTimes(kind: 0 | 2, queries: Numbers, narrowPhase?: string | null): Float64Array;
/** The same decided by the judge: the doubles next to the exact time. */
export function touchTimes(kind: 0 | 2, queries: Numbers): { lo: Float64Array; hi: Float64Array };

export interface Verdict {
  selfCrossings: number;
  bodyCrossings: number;
  selfTouches: number;
  bodyTouches: number;
  insideVertices: number;
  maxPenetration: number;
  maxStretch: number;
  maxCompression: number;
  firstSelfCrossing: [number, number] | null;
  firstBodyCrossing: [number, number] | null;
}
/** The exact verdict on a state, x0. */
export function judge(mesh: Surface, options?: { body?: Surface | null; rest?: Numbers | null }): Verdict;
/** The same for the straight paths from x0 to x1. */
export function judgePath(mesh: Surface, options?: { body?: Surface | null }): { selfCollisions: number; bodyCollisions: number };

export function version(): string;
export function broadPhases(): string[];
export function narrowPhases(): string[];
