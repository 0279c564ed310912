// SPDX-License-Identifier: MIT
// check.mjs PATTERN.json BODY.ply [SCENE.json ...]: prints the results of seeded questions, every double in hexadecimal, the hashes of a
// garment that is put on, z up, and of the scenes after six frames, from the package `selvedge`; the processor times of two runs of each scene go to the standard error. check.py prints the same from
// the native library.
import { readFileSync } from 'node:fs';
import * as s from 'selvedge';

/** 32-bit linear congruential numbers in [0,1). */
function generator(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 4294967296;
  };
}

const hex = (x) => {
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, x);
  return view.getBigUint64(0).toString(16).padStart(16, '0');
};
const show = (label, values, double) => console.log([label, ...Array.from(values, (x) => (double ? hex(x) : x))].join(' '));

function soup(seed, count) {
  const random = generator(seed), x0 = [], x1 = [], triangles = [];
  for (let i = 0; i < count; ++i) {
    const at = [random(), random(), random()];
    for (let k = 0; k < 3; ++k)
      for (let d = 0; d < 3; ++d) {
        x0.push(at[d] + 0.8 * random());
        x1.push(x0[x0.length - 1] + 0.2 * random());
      }
    triangles.push(3 * i, 3 * i + 1, 3 * i + 2);
  }
  return { x0: new Float64Array(x0), x1: new Float64Array(x1), triangles: new Int32Array(triangles) };
}

for (let seed = 1; seed <= 5; ++seed) {
  const a = soup(seed, 40), b = soup(seed + 100, 30);
  for (const other of [null, b]) {
    const found = s.findCollisions(a, other);
    show('collisions', found.vertices);
    show('toi', found.toi, true);
    show('weights', found.weights, true);
    show('normal', found.normal, true);
    const meetings = s.findMeetings(a, other);
    show('crossings', meetings.crossings);
    show('touches', meetings.touches);
    show('gaps', s.findContacts(a, other, 0.02).gap, true);
  }
  const random = generator(seed + 1000), queries = Float64Array.from({ length: 24 * 200 }, random);
  for (const kind of [s.POINT_TRIANGLE, s.EDGE_EDGE]) {
    show('impact', s.impactTimes(kind, queries), true);
    show('touch', s.touchTimes(kind, queries).hi, true);
  }
  const verdict = s.judge(a, { body: b, rest: a.x1 });
  show('judge', [verdict.selfCrossings, verdict.bodyCrossings, verdict.selfTouches, verdict.bodyTouches, verdict.insideVertices]);
  show('strain', [verdict.maxStretch, verdict.maxCompression], true);
  const path = s.judgePath(a, { body: b });
  show('path', [path.selfCollisions, path.bodyCollisions]);
}
for (const wrong of [() => s.findMeetings({ x0: [0, 0, NaN], triangles: [0, 0, 0] }), () => s.findCollisions(soup(1, 1), null, { broadPhase: 'bhv' })]) {
  try {
    wrong();
    throw new Error('a wrong argument was not refused');
  } catch (error) {
    if (!(error instanceof s.SelvedgeError) || error.code !== 1) throw error;
    console.log('refused', error.message);
  }
}

/** Processor time of this thread, s; of the process where the system does not tell. The compiler of WebAssembly has its own threads. */
function processorTime() {
  try {
    return Number(readFileSync(`/proc/self/task/${process.pid}/schedstat`, 'utf8').split(' ')[0]) / 1e9;
  } catch {
    return process.cpuUsage().user / 1e6;
  }
}

const [pattern, body, ...scenes] = process.argv.slice(2);
const worn = s.dress(readFileSync(pattern, 'utf8'), s.readMesh('body.ply', readFileSync(body)), { edgeLength: 0.05, up: 'z' });
console.log('dress', worn.hash, worn.statesJudged, worn.garment.x0.length, worn.worn ? 'worn' : 'not worn', worn.verdict);

for (const file of scenes) {
  const name = file.replace(/.*\//, ''), scene = new s.Scene(readFileSync(file, 'utf8')), seconds = [];
  let simulation;
  // The second run has the code that the compiler has optimized by then.
  for (let run = 0; run < 2; ++run) {
    const before = processorTime();
    simulation = new s.Simulation(scene);
    simulation.advance(6);
    seconds.push((processorTime() - before).toFixed(3));
  }
  console.log(`scene ${name} ${simulation.hash} ${simulation.steps} steps`);
  console.error(name, ...seconds);
  const state = simulation.save(), further = () => {
    simulation.step();
    return simulation.hash;
  };
  const first = further();
  simulation.restore(state);
  if (further() !== first) throw new Error(`${name}: a restored state continues otherwise`);
}
