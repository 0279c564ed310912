// SPDX-License-Identifier: MIT
/** Positions are flat arrays of x, y, z in metres, triangles flat arrays of three vertex indices. Results are copies. */
export type Numbers = Float64Array | ArrayLike<number>;

/** A surface during a step: every vertex moves on a straight line from x0 to x1. Without x1 nothing moves. */
export interface Surface {
  x0: Numbers;
  x1?: Numbers | null;
  triangles: Int32Array | ArrayLike<number>;
}

/** An argument that cannot be used (code 1), a simulation that cannot continue and keeps its last good state (code 2), or no memory
 * (code 4). The message names the place. */
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
  /** Frees the memory now; else the collector of garbage does. The same for all classes. */
  free(): void;
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

/** Reads OBJ, PLY or OFF exactly; the ending of the name tells which. Throws SelvedgeError with the line or byte of a fault. */
export function readMesh(name: string, content: string | Uint8Array | ArrayBuffer): Mesh;

/** Files that a scene names, by their paths relative to it. */
export type Files = Record<string, string | Uint8Array | ArrayBuffer>;

/** A scene from the JSON of a scene file, as text or as an object. Free it after its simulations. */
export class Scene {
  constructor(scene: string | object, options?: { files?: Files });
  /** The scene as read, with all defaults. */
  readonly json: string;
  /** The number of its last frame, and frames per second. */
  readonly frames: number;
  readonly fps: number;
  free(): void;
}

/** Contacts of the last step, at its end. Vertices count the cloth first, then the bodies. */
export interface StepContacts {
  count: number;
  kind: Uint8Array;
  vertices: Int32Array;
  weights: Float64Array;
  normal: Float64Array;
  /** m */
  gap: Float64Array;
  /** m, the distance that the simulation keeps */
  restGap: Float64Array;
  /** Rows of three, N s, on the first primitive. */
  impulse: Float64Array;
}

/** All that a simulation carries from step to step. */
export interface State {
  free(): void;
}

/** The cloth of a scene in time. */
export class Simulation {
  /** `driven`: numbers of bodies that the program moves by moveBody. */
  constructor(scene: Scene | string | object, options?: { driven?: number[]; files?: Files });
  readonly scene: Scene;
  /** Makes one accepted step. */
  step(): void;
  /** Steps to the time of a frame, and verifies each frame. */
  advance(frame: number): void;
  /** s */
  readonly time: number;
  readonly steps: number;
  readonly vertexCount: number;
  /** Copies of the state, rows of three, in m and m/s. */
  readonly positions: Float64Array;
  readonly velocities: Float64Array;
  readonly triangles: Int32Array;
  /** All bodies joined; body i has the vertices from bodyBegin(i) up to bodyBegin(i + 1). */
  readonly bodyCount: number;
  bodyBegin(i: number): number;
  readonly bodyPositions: Float64Array;
  readonly bodyTriangles: Int32Array;
  /** Forces in N on the cloth, rows of three, until they are set again; null: none. */
  setForces(forces: Numbers | null): void;
  /** Moves vertices on straight lines to x, rows of three, by the end of the next nominal step, and holds them there. */
  hold(vertices: ArrayLike<number>, x: Numbers): void;
  /** Releases held vertices; without an argument all. */
  release(vertices?: ArrayLike<number> | null): void;
  /** Moves all vertices of a driven body to x, rows of three, by the end of the next nominal step. */
  moveBody(body: number, x: Numbers): void;
  contacts(): StepContacts;
  /** A figure of the run since the start, by its name in result.json, or an energy: "energy.kinetic". */
  figure(name: string): number;
  /** 16 hex digits of positions and velocities. */
  readonly hash: string;
  save(): State;
  /** Continues from a state of the same scene with the same bits. Input is forgotten. */
  restore(state: State): void;
  free(): void;
}

export interface Mesh {
  x0: Float64Array;
  triangles: Int32Array;
}
export interface WornGarment {
  /** As worn, in m with z up. */
  garment: Mesh;
  /** The pattern; triangle i of both correspond. */
  flat: Mesh;
  /** On which it lies: its skin goes back where it leaves cloth no room. */
  body: Mesh;
  /** "good", or how it fits badly, or why it is not worn. */
  verdict: string;
  worn: boolean;
  good: boolean;
  clean: boolean;
  sewn: boolean;
  atRest: boolean;
  maxStretch: number;
  /** m, by which it sank */
  drop: number;
  statesJudged: number;
  /** 16 hex digits of positions and velocities. */
  hash: string;
}
export interface DressOptions {
  /** For messages. */
  name?: string;
  /** m, of the triangles; 0.02 by default */
  edgeLength?: number;
  fabric?: string | null;
  bodyFriction?: number;
  /** Axis of the pattern that points up; y by default. */
  up?: 'x' | 'y' | 'z';
  /** Moves a pattern that stands beside the body to it. */
  fitOrigin?: boolean;
}
/** Sews a pattern of GarmentCode, as text or as an object, around a body of closed parts in m with z up. Takes seconds to minutes.
 * Throws SelvedgeError with code 2 if the garment cannot be put on. */
export function dress(pattern: string | object, body: Surface, options?: DressOptions): WornGarment;

export function version(): string;
export function broadPhases(): string[];
export function narrowPhases(): string[];
