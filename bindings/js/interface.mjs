// SPDX-License-Identifier: MIT
// Exact cloth collision and cloth simulation in WebAssembly: the C interface (bindings/c/selvedge.h) with typed arrays.
// index.d.ts documents it.
let wasm;
/** Names the module of Emscripten that all functions use. */
export function use(module) {
  wasm = module;
}
const kPointTriangle = 0, kEdgeEdge = 2;
export const POINT_TRIANGLE = kPointTriangle, TRIANGLE_POINT = 1, EDGE_EDGE = kEdgeEdge;

export class SelvedgeError extends Error {
  constructor(code, sentence) {
    super(sentence);
    this.name = 'SelvedgeError';
    this.code = code;
  }
}

function check(code) {
  if (code !== 0) throw new SelvedgeError(code, wasm.UTF8ToString(wasm._selvedge_last_error()));
}

/** Memory of one call, which is freed at its end. */
class Scratch {
  #blocks = [];
  bytes(n) {
    const at = wasm._malloc(Math.max(n, 8));
    if (at === 0) throw new SelvedgeError(4, 'the memory is used up');
    this.#blocks.push(at);
    return at;
  }
  array(values, Type) {
    const typed = values instanceof Type ? values : Type.from(values);
    const at = this.bytes(typed.byteLength);
    new Type(wasm.HEAPU8.buffer, at, typed.length).set(typed);
    return at;
  }
  text(value) {
    if (value == null) return 0;
    const n = wasm.lengthBytesUTF8(value) + 1, at = this.bytes(n);
    wasm.stringToUTF8(value, at, n);
    return at;
  }
  /** A selvedge_surface; 0 for none. */
  surface(given, name) {
    if (given == null) return 0;
    const { x0, x1, triangles } = given;
    if (x0 == null || triangles == null) throw new TypeError(`${name}: needs x0 and triangles`);
    if (x0.length % 3 !== 0) throw new TypeError(`${name}.x0: its length is ${x0.length}, no multiple of 3`);
    if (triangles.length % 3 !== 0) throw new TypeError(`${name}.triangles: its length is ${triangles.length}, no multiple of 3`);
    if (x1 != null && x1.length !== x0.length)
      throw new TypeError(`${name}.x1: its length is ${x1.length}, that of x0 is ${x0.length}`);
    const fields = [this.array(x0, Float64Array), x1 == null ? 0 : this.array(x1, Float64Array), x0.length / 3,
      this.array(triangles, Int32Array), triangles.length / 3];
    return this.array(fields, Uint32Array);
  }
  free() {
    for (const at of this.#blocks) wasm._free(at);
  }
}

function scratched(work) {
  const scratch = new Scratch();
  try {
    return work(scratch);
  } finally {
    scratch.free();
  }
}

const word = (at) => wasm.HEAPU32[at >> 2];
const copied = (Type, at, n) => (at === 0 ? new Type(0) : new Type(wasm.HEAPU8.buffer, at, n).slice());

/** Columns of selvedge_contacts: place among its words, type, numbers in a row. */
const kColumns = { kind: [1, Uint8Array, 1], vertices: [2, Int32Array, 4], weights: [3, Float64Array, 4], normal: [4, Float64Array, 3],
  primitives: [5, Int32Array, 2], toi: [6, Float64Array, 1], gap: [7, Float64Array, 1], restGap: [8, Float64Array, 1],
  impulse: [9, Float64Array, 3] };
const kOfPairs = ['kind', 'vertices', 'weights', 'normal', 'primitives'];

/** Reads the named columns of a selvedge_contacts and frees it. */
function takeContacts(at, names) {
  const out = { count: word(at) };
  for (const name of names) {
    const [place, Type, width] = kColumns[name];
    out[name] = copied(Type, word(at + 4 * place), width * out.count);
  }
  wasm._selvedge_contacts_free(at);
  return out;
}

/** Reads a selvedge_pairs and frees it. */
function takePairs(at) {
  const pairs = copied(Int32Array, word(at + 4), 2 * word(at));
  wasm._selvedge_pairs_free(at);
  return pairs;
}

export function version() {
  return wasm.UTF8ToString(wasm._selvedge_version());
}

function names(function_) {
  const found = [];
  for (let at; (at = function_(found.length)) !== 0;) found.push(wasm.UTF8ToString(at));
  return found;
}
export const broadPhases = () => names(wasm._selvedge_broad_phase);
export const narrowPhases = () => names(wasm._selvedge_narrow_phase);

/** The objects of the library that belong to objects of JavaScript, which free them at the latest when nothing refers to them. */
const owned = new WeakMap();
const unused = new FinalizationRegistry((free) => free());
function own(object, handle, free) {
  owned.set(object, { handle, free });
  unused.register(object, free, object);
}
/** The object of the library, 0 if it is free. */
const handleOf = (object) => owned.get(object)?.handle ?? 0;
function release(object) {
  owned.get(object)?.free();
  owned.delete(object);
  unused.unregister(object);
}

export class Detector {
  constructor({ broadPhase = null, narrowPhase = null, minSeparation = 0 } = {}) {
    const handle = scratched((scratch) => {
      const out = scratch.bytes(4);
      check(wasm._selvedge_detector_create(scratch.text(broadPhase), scratch.text(narrowPhase), minSeparation, out));
      return word(out);
    });
    own(this, handle, () => wasm._selvedge_detector_free(handle));
  }
  free() {
    release(this);
  }
  findCollisions(a, b = null) {
    return scratched((scratch) => {
      const out = scratch.bytes(4);
      check(wasm._selvedge_find_collisions(handleOf(this), scratch.surface(a, 'a'), scratch.surface(b, 'b'), out));
      return takeContacts(word(out), [...kOfPairs, 'toi']);
    });
  }
  findCandidates(a, b = null, distance = 0) {
    return scratched((scratch) => {
      const out = scratch.bytes(12);
      check(wasm._selvedge_find_candidates(handleOf(this), scratch.surface(a, 'a'), scratch.surface(b, 'b'), distance, out, out + 4,
        out + 8));
      return { pointTriangle: takePairs(word(out)), trianglePoint: takePairs(word(out + 4)), edgeEdge: takePairs(word(out + 8)) };
    });
  }
}

export function findCollisions(a, b = null, options = {}) {
  return new Detector(options).findCollisions(a, b);
}

export function findMeetings(a, b = null) {
  return scratched((scratch) => {
    const out = scratch.bytes(8);
    check(wasm._selvedge_find_meetings(scratch.surface(a, 'a'), scratch.surface(b, 'b'), out, out + 4));
    return { crossings: takePairs(word(out)), touches: takePairs(word(out + 4)) };
  });
}

export function findContacts(a, b, distance) {
  return scratched((scratch) => {
    const out = scratch.bytes(4);
    check(wasm._selvedge_find_contacts(scratch.surface(a, 'a'), scratch.surface(b, 'b'), distance, out));
    return takeContacts(word(out), [...kOfPairs, 'gap']);
  });
}

export function edges(triangles) {
  return scratched((scratch) => {
    const out = scratch.bytes(4);
    check(wasm._selvedge_edges(scratch.array(triangles, Int32Array), triangles.length / 3, out));
    return takePairs(word(out));
  });
}

function countOf(queries) {
  if (queries.length % 24 !== 0) throw new TypeError(`queries: the length is ${queries.length}, no multiple of 24`);
  return queries.length / 24;
}

export function impactTimes(kind, queries, narrowPhase = null) {
  const n = countOf(queries);
  return scratched((scratch) => {
    const toi = scratch.bytes(8 * n);
    check(wasm._selvedge_impact_times(scratch.text(narrowPhase), kind, scratch.array(queries, Float64Array), n, toi));
    return copied(Float64Array, toi, n);
  });
}

export function touchTimes(kind, queries) {
  const n = countOf(queries);
  return scratched((scratch) => {
    const lo = scratch.bytes(8 * n), hi = scratch.bytes(8 * n);
    check(wasm._selvedge_touch_times(kind, scratch.array(queries, Float64Array), n, lo, hi));
    return { lo: copied(Float64Array, lo, n), hi: copied(Float64Array, hi, n) };
  });
}

const kCounts = ['selfCrossings', 'bodyCrossings', 'selfTouches', 'bodyTouches', 'insideVertices'];
const kMeasures = ['maxPenetration', 'maxStretch', 'maxCompression'];

export function judge(mesh, { body = null, rest = null } = {}) {
  return scratched((scratch) => {
    const out = scratch.bytes(80);
    if (rest != null && rest.length !== mesh.x0.length)
      throw new TypeError(`rest: its length is ${rest.length}, that of x0 is ${mesh.x0.length}`);
    check(wasm._selvedge_judge(scratch.surface(mesh, 'mesh'), scratch.surface(body, 'body'),
      rest == null ? 0 : scratch.array(rest, Float64Array), out));
    const verdict = {}, counts = new BigUint64Array(wasm.HEAPU8.buffer, out, 5), measures = new Float64Array(wasm.HEAPU8.buffer, out + 40, 3);
    kCounts.forEach((name, i) => { verdict[name] = Number(counts[i]); });
    kMeasures.forEach((name, i) => { verdict[name] = measures[i]; });
    const first = copied(Int32Array, out + 64, 4);
    verdict.firstSelfCrossing = first[0] < 0 ? null : [first[0], first[1]];
    verdict.firstBodyCrossing = first[2] < 0 ? null : [first[2], first[3]];
    return verdict;
  });
}

export function judgePath(mesh, { body = null } = {}) {
  return scratched((scratch) => {
    const out = scratch.bytes(16);
    check(wasm._selvedge_judge_path(scratch.surface(mesh, 'mesh'), scratch.surface(body, 'body'), out, out + 8));
    const counts = new BigUint64Array(wasm.HEAPU8.buffer, out, 2);
    return { selfCollisions: Number(counts[0]), bodyCollisions: Number(counts[1]) };
  });
}

/** Writes files, by relative name, to a folder in memory. */
function writeFiles(folder, files) {
  for (const [name, content] of Object.entries(files)) {
    const parts = name.split('/');
    if (parts.some((part) => part === '' || part === '.' || part === '..'))
      throw new TypeError(`files: "${name}" is no path below the scene`);
    wasm.FS.mkdirTree([folder, ...parts.slice(0, -1)].join('/'));
    wasm.FS.writeFile(`${folder}/${name}`, typeof content === 'string' ? content : new Uint8Array(content));
  }
}

function removeFolder(folder) {
  for (const name of wasm.FS.readdir(folder)) {
    if (name === '.' || name === '..') continue;
    const path = `${folder}/${name}`;
    if (wasm.FS.isDir(wasm.FS.stat(path).mode)) removeFolder(path);
    else wasm.FS.unlink(path);
  }
  wasm.FS.rmdir(folder);
}

let folders = 0;
/** Calls work(folder) with a new folder that has the files; removes it if that throws. */
function withFolder(files, work) {
  const folder = `/selvedge_${folders++}`;
  wasm.FS.mkdir(folder);
  try {
    writeFiles(folder, files);
    return work(folder);
  } catch (error) {
    removeFolder(folder);
    throw error;
  }
}

/** Copies a selvedge_mesh. */
const meshAt = (at) => ({ x0: copied(Float64Array, word(at + 4), 3 * word(at)), triangles: copied(Int32Array, word(at + 12), 3 * word(at + 8)) });

export function readMesh(name, content) {
  return withFolder({ [name]: content }, (folder) => {
    const mesh = scratched((scratch) => {
      const out = scratch.bytes(4);
      check(wasm._selvedge_mesh_read(scratch.text(`${folder}/${name}`), out));
      const at = word(out), read = meshAt(at);
      wasm._selvedge_mesh_free(at);
      return read;
    });
    removeFolder(folder);
    return mesh;
  });
}

export class Scene {
  constructor(scene, { files = {} } = {}) {
    const text = typeof scene === 'string' ? scene : JSON.stringify(scene);
    withFolder(files, (folder) => {
      const handle = scratched((scratch) => {
        const out = scratch.bytes(4);
        check(wasm._selvedge_scene_create(scratch.text(text), scratch.text(`${folder}/scene.json`), out));
        return word(out);
      });
      own(this, handle, () => {
        wasm._selvedge_scene_free(handle);
        removeFolder(folder);
      });
    });
  }
  get json() {
    return wasm.UTF8ToString(wasm._selvedge_scene_json(handleOf(this)));
  }
  get frames() {
    return wasm._selvedge_scene_frames(handleOf(this));
  }
  get fps() {
    return wasm._selvedge_scene_fps(handleOf(this));
  }
  free() {
    release(this);
  }
}

/** What a simulation carries from step to step. */
class State {
  free() {
    release(this);
  }
}

export class Simulation {
  constructor(scene, { driven = [], files = {} } = {}) {
    /** Its files are read again by restore(). */
    this.scene = scene instanceof Scene ? scene : new Scene(scene, { files });
    const handle = scratched((scratch) => {
      const out = scratch.bytes(4);
      check(wasm._selvedge_simulation_create(handleOf(this.scene), scratch.array(driven, Uint32Array), driven.length, out));
      return word(out);
    });
    own(this, handle, () => wasm._selvedge_simulation_free(handle));
  }
  step() {
    check(wasm._selvedge_simulation_step(handleOf(this)));
  }
  advance(frame) {
    check(wasm._selvedge_simulation_advance(handleOf(this), frame));
  }
  get time() {
    return wasm._selvedge_simulation_time(handleOf(this));
  }
  get steps() {
    return wasm._selvedge_simulation_steps(handleOf(this)) >>> 0; // the lower half of 64 bits
  }
  get vertexCount() {
    return wasm._selvedge_simulation_vertices(handleOf(this));
  }
  get positions() {
    return copied(Float64Array, wasm._selvedge_simulation_positions(handleOf(this)), 3 * this.vertexCount);
  }
  get velocities() {
    return copied(Float64Array, wasm._selvedge_simulation_velocities(handleOf(this)), 3 * this.vertexCount);
  }
  #triangles(function_) {
    return scratched((scratch) => {
      const count = scratch.bytes(4), at = function_(handleOf(this), count);
      return copied(Int32Array, at, 3 * word(count));
    });
  }
  get triangles() {
    return this.#triangles(wasm._selvedge_simulation_triangles);
  }
  get bodyCount() {
    return wasm._selvedge_simulation_bodies(handleOf(this));
  }
  bodyBegin(i) {
    return wasm._selvedge_simulation_body_begin(handleOf(this), i);
  }
  get bodyPositions() {
    return copied(Float64Array, wasm._selvedge_simulation_body_positions(handleOf(this)), 3 * this.bodyBegin(this.bodyCount));
  }
  get bodyTriangles() {
    return this.#triangles(wasm._selvedge_simulation_body_triangles);
  }
  setForces(forces) {
    if (forces != null && forces.length !== 3 * this.vertexCount)
      throw new TypeError(`forces: the length is ${forces.length}, not 3 times ${this.vertexCount} vertices`);
    scratched((scratch) =>
      check(wasm._selvedge_simulation_set_forces(handleOf(this), forces == null ? 0 : scratch.array(forces, Float64Array))));
  }
  hold(vertices, x) {
    if (x.length !== 3 * vertices.length) throw new TypeError(`x: the length is ${x.length}, not 3 times ${vertices.length} vertices`);
    scratched((scratch) => check(wasm._selvedge_simulation_hold(handleOf(this), scratch.array(vertices, Int32Array), vertices.length,
      scratch.array(x, Float64Array))));
  }
  release(vertices = null) {
    scratched((scratch) => check(wasm._selvedge_simulation_release(handleOf(this),
      vertices == null ? 0 : scratch.array(vertices, Int32Array), vertices?.length ?? 0)));
  }
  moveBody(body, x) {
    if (x.length % 3 !== 0) throw new TypeError(`x: the length is ${x.length}, no multiple of 3`);
    scratched((scratch) => check(wasm._selvedge_simulation_move_body(handleOf(this), body, scratch.array(x, Float64Array), x.length / 3)));
  }
  contacts() {
    return scratched((scratch) => {
      const out = scratch.bytes(4);
      check(wasm._selvedge_simulation_contacts(handleOf(this), out));
      return takeContacts(word(out), ['kind', 'vertices', 'weights', 'normal', 'gap', 'restGap', 'impulse']);
    });
  }
  figure(name) {
    return scratched((scratch) => {
      const out = scratch.bytes(8);
      check(wasm._selvedge_simulation_figure(handleOf(this), scratch.text(name), out));
      return wasm.HEAPF64[out >> 3];
    });
  }
  get hash() {
    return scratched((scratch) => {
      const out = scratch.bytes(17);
      check(wasm._selvedge_simulation_hash(handleOf(this), out));
      return wasm.UTF8ToString(out);
    });
  }
  save() {
    const handle = scratched((scratch) => {
      const out = scratch.bytes(4);
      check(wasm._selvedge_simulation_save(handleOf(this), out));
      return word(out);
    });
    const state = new State();
    own(state, handle, () => wasm._selvedge_state_free(handle));
    return state;
  }
  restore(state) {
    check(wasm._selvedge_simulation_restore(handleOf(this), handleOf(state)));
  }
  free() {
    release(this);
  }
}

const kGarmentFigures = { worn: 'worn', good: 'good', clean: 'clean', sewn: 'sewn', atRest: 'at_rest' };

/** The selvedge_dress_options of C. */
function dressOptions(scratch, { edgeLength = 0.02, fabric = null, bodyFriction = 0.4, up = 'y', fitOrigin = false }) {
  const at = scratch.bytes(32), name = scratch.text(fabric), view = new DataView(wasm.HEAPU8.buffer);
  view.setFloat64(at, edgeLength, true);
  view.setUint32(at + 8, name, true);
  view.setFloat64(at + 16, bodyFriction, true);
  view.setUint8(at + 24, up.charCodeAt(0));
  view.setUint8(at + 25, fitOrigin ? 1 : 0);
  return at;
}

export function dress(pattern, body, options = {}) {
  const text = typeof pattern === 'string' ? pattern : JSON.stringify(pattern);
  return scratched((scratch) => {
    const out = scratch.bytes(8);
    check(wasm._selvedge_dress(scratch.text(text), scratch.text(options.name ?? 'pattern'), scratch.surface(body, 'body'),
      dressOptions(scratch, options), out));
    const garment = word(out), figure = (name) => {
      check(wasm._selvedge_garment_figure(garment, scratch.text(name), out));
      return new Float64Array(wasm.HEAPU8.buffer, out, 1)[0];
    };
    try {
      const worn = { garment: meshAt(wasm._selvedge_garment_mesh(garment)), flat: meshAt(wasm._selvedge_garment_flat(garment)),
        body: meshAt(wasm._selvedge_garment_body(garment)), verdict: wasm.UTF8ToString(wasm._selvedge_garment_verdict(garment)),
        hash: wasm.UTF8ToString(wasm._selvedge_garment_hash(garment)), maxStretch: figure('max_stretch'), drop: figure('drop_m'),
        statesJudged: figure('states_judged') };
      for (const [name, field] of Object.entries(kGarmentFigures)) worn[name] = figure(field) === 1;
      return worn;
    } finally {
      wasm._selvedge_garment_free(garment);
    }
  });
}
