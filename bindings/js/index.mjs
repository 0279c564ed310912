// SPDX-License-Identifier: MIT
// Exact cloth collision in WebAssembly: the C interface (bindings/c/selvedge.h) with typed arrays. index.d.ts documents it.
import create from './selvedge_wasm.mjs';

// Emscripten 3.1.6 cannot load the file of an ES module in Node.
const file = new URL('./selvedge_wasm.wasm', import.meta.url);
const inNode = typeof process === 'object' && process.versions?.node !== undefined;
const wasmBinary = inNode ? await (await import('node:fs/promises')).readFile(file) : await (await fetch(file)).arrayBuffer();
const wasm = await create({ wasmBinary });
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

/** Reads a selvedge_contacts and frees it. `last`: the name of the column that the function has beside those of primitives. */
function takeContacts(at, last) {
  const n = word(at), column = (i) => word(at + 4 * i);
  const out = { count: n, kind: copied(Uint8Array, column(1), n), vertices: copied(Int32Array, column(2), 4 * n),
    weights: copied(Float64Array, column(3), 4 * n), normal: copied(Float64Array, column(4), 3 * n),
    primitives: copied(Int32Array, column(5), 2 * n) };
  out[last] = copied(Float64Array, column(last === 'toi' ? 6 : 7), n);
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

/** Frees the memory of a detector that nothing refers to. */
const registry = new FinalizationRegistry((handle) => wasm._selvedge_detector_free(handle));

export class Detector {
  #handle;
  constructor({ broadPhase = null, narrowPhase = null, minSeparation = 0 } = {}) {
    this.#handle = scratched((scratch) => {
      const out = scratch.bytes(4);
      check(wasm._selvedge_detector_create(scratch.text(broadPhase), scratch.text(narrowPhase), minSeparation, out));
      return word(out);
    });
    registry.register(this, this.#handle);
  }
  findCollisions(a, b = null) {
    return scratched((scratch) => {
      const out = scratch.bytes(4);
      check(wasm._selvedge_find_collisions(this.#handle, scratch.surface(a, 'a'), scratch.surface(b, 'b'), out));
      return takeContacts(word(out), 'toi');
    });
  }
  findCandidates(a, b = null, distance = 0) {
    return scratched((scratch) => {
      const out = scratch.bytes(12);
      check(wasm._selvedge_find_candidates(this.#handle, scratch.surface(a, 'a'), scratch.surface(b, 'b'), distance, out, out + 4,
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
    return takeContacts(word(out), 'gap');
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
