// SPDX-License-Identifier: MIT
// The first part of the page: cloth falls on a body, the pointer pulls it, and it is judged at the end.
'use strict';

const kFps = 60, kSeconds = 4;
const kBusy = 50, kMostBehind = 200; // ms: after which no further frame begins before the picture is drawn, and for which frames are made up
const kPullSpeed = 2; // m/s at which a held vertex follows the pointer
const kFabrics = ['default', 'denim', 'cotton shirting', 'petrak_2025/M1', 'petrak_2025/M3', 'petrak_2025/M6'];
const kCloth = { front: [0.74, 0.30, 0.26], back: [0.88, 0.74, 0.52], behind: 1 }, kBody = { front: [0.64, 0.66, 0.69], behind: 4 };

/** A unit by the size of a body: nothing that cloth falls on is larger than 10 m. */
function guessedUnit(extent) {
  return extent > 1000 ? 0.001 : extent > 10 ? 0.01 : 1;
}

/** A body file as an obstacle that stands on z = 0 over the origin: { obstacle, files, low, high }. */
function placedBody({ name, content }, unit, up) {
  const mesh = selvedge.readMesh(name, content), x = mesh.x0;
  if (x.length === 0) throw new Error(`${name} has no vertices`);
  const [low, high] = boxOf(x), scale = unit || guessedUnit(Math.max(...difference(high, low)));
  // z up: x stays, -z becomes y, y becomes z.
  const a = (up === 'y' ? [low[0], -high[2], low[1]] : low).map((c) => c * scale), b = (up === 'y' ? [high[0], -low[2], high[1]] : high).map((c) => c * scale);
  const move = [-(a[0] + b[0]) / 2, -(a[1] + b[1]) / 2, -a[2]];
  const obstacle = { name: 'body', mesh: name, unit: scale, up, friction: 0.4, transformation: { translation: move } };
  return { obstacle, files: { [name]: content }, top: b[2] - a[2] };
}

class Drape {
  constructor(stage) {
    Object.assign(this, { stage, simulation: null, running: false, frame: 0, end: 0, clock: 0, dropped: null, pull: null });
  }

  body() {
    if (page('body').value === 'sphere')
      return { obstacle: { name: 'body', shape: { type: 'sphere', radius: 0.3, resolution: 40 }, friction: 0.3, transformation: { translation: [0, 0, 0.3] } }, files: {}, top: 0.6 };
    if (page('body').value === 'dropped') return placedBody(this.dropped, Number(page('unit').value), page('up').value);
    return { obstacle: { name: 'body', mesh: 'mannequin.ply', friction: 0.4 }, files: { 'mannequin.ply': selvedgeMannequin() }, top: 1.71 - 0.02 };
  }

  scene({ obstacle, top }) {
    const size = Number(page('size').value), cells = Number(page('particles').value) - 1, fabric = page('fabric').value;
    return {
      name: 'page', geometry: [{ name: 'cloth', size: [size, size], cells: [cells, cells], transformation: { translation: [0, 0, top + 0.02] } }],
      ...(fabric === 'default' ? {} : { materials: { default: { fabric } } }),
      obstacles: [obstacle], air: { normal_drag: 1, viscous_drag: 0.1 }, time: { frames: 99999, fps: kFps },
      contact: { broad_phase: page('broad').value, narrow_phase: page('narrow').value },
    };
  }

  start() {
    this.stop();
    const body = this.body();
    this.simulation = new selvedge.Simulation(this.scene(body), { files: body.files });
    const s = this.simulation;
    Object.assign(this, { frame: 0, end: kSeconds * kFps, running: true, triangles: s.triangles, rest: s.positions, kept: null, rate: 0, last: 0 });
    this.bodyX = s.bodyPositions;
    this.bodyTriangles = s.bodyTriangles;
    this.stage.set('body', this.bodyX, this.bodyTriangles, kBody);
    this.stage.look(this.rest, this.bodyX);
    page('drape_verdict').hidden = true;
    this.show();
  }

  stop() {
    this.kept?.free();
    this.simulation?.free();
    this.simulation?.scene.free();
    Object.assign(this, { simulation: null, running: false, kept: null, pull: null });
  }

  /** Makes the frames that are due at a picture, so that the cloth falls as fast as a real one where the processor is fast enough. */
  tick(now) {
    if (!this.running) return;
    const begin = performance.now(), first = this.frame;
    this.clock = Math.max(this.clock, now - kMostBehind);
    for (; this.running && this.clock <= now && performance.now() - begin < kBusy; this.clock += 1000 / kFps) {
      this.moveHeld();
      this.stepFrame();
      if (this.frame >= this.end && this.pull === null) this.running = false;
    }
    if (this.frame === first) return;
    // Frames in a second, over some ten pictures.
    if (this.last > 0) this.rate += 0.1 * (1000 * (this.frame - first) / Math.max(now - this.last, 1) - this.rate);
    this.last = now;
    this.show();
    if (!this.running) this.judge();
  }

  stepFrame() {
    try {
      this.simulation.advance(this.frame + 1);
    } catch (error) {
      // A pull into the body leaves the cloth no room: let it go and continue from the frame before.
      if (error.code !== 2 || this.pull === null || this.kept === null) throw error;
      this.simulation.restore(this.kept);
      this.drop();
      return;
    }
    ++this.frame;
    if (this.pull !== null) {
      this.kept?.free();
      this.kept = this.simulation.save();
    }
  }

  show() {
    const s = this.simulation;
    this.x = s.positions;
    this.stage.set('cloth', this.x, this.triangles, kCloth);
    const count = this.showContacts(s);
    page('now').textContent = `${s.time.toFixed(2)} s, ${this.rate.toFixed(0)} frames a second${count === null ? '' : `, ${count} contacts`}`;
    Object.assign(document.documentElement.dataset, { frame: this.frame, rate: this.rate.toFixed(2) });
  }

  /** Marks where the first primitives of the contacts touch; returns their number, or null. */
  showContacts(s) {
    this.stage.remove('contacts');
    if (!page('contacts').checked) return null;
    const { count, vertices, weights } = s.contacts(), n = this.x.length / 3, points = new Float32Array(3 * count);
    for (let i = 0; i < count; ++i)
      for (let k = 0; k < 4; ++k) {
        const v = vertices[4 * i + k], w = weights[4 * i + k];
        if (w <= 0) continue;
        const p = v < n ? pointAt(this.x, v) : pointAt(this.bodyX, v - n);
        for (let d = 0; d < 3; ++d) points[3 * i + d] += w * p[d];
      }
    if (count > 0) this.stage.set('contacts', points, null, { mode: 'points', front: [0.05, 0.35, 0.85], size: 4, over: true });
    return count;
  }

  /** The pointer takes hold of a vertex and its neighbours; false if it is beside the cloth. */
  grab(ray) {
    if (this.simulation === null) return false;
    const cloth = firstHit(ray.origin, ray.direction, this.x, this.triangles), body = firstHit(ray.origin, ray.direction, this.bodyX, this.bodyTriangles);
    if (cloth === null || (body !== null && body.distance < cloth.distance)) return false;
    const at = along(ray.origin, cloth.distance, ray.direction), corners = this.triangles.slice(3 * cloth.triangle, 3 * cloth.triangle + 3);
    const far = (v) => Math.hypot(...difference(pointAt(this.x, v), at));
    const vertex = corners.reduce((best, v) => (far(v) < far(best) ? v : best));
    const ring = new Set([vertex]);
    for (let i = 0; i < this.triangles.length; i += 3)
      if (this.triangles.subarray(i, i + 3).includes(vertex)) this.triangles.subarray(i, i + 3).forEach((v) => ring.add(v));
    const start = pointAt(this.x, vertex), offsets = [...ring].map((v) => difference(pointAt(this.x, v), start));
    this.pull = { vertex, ring: [...ring], offsets, depth: dot(difference(start, ray.origin), this.stage.view().back), target: start };
    page('drape_verdict').hidden = true;
    this.running = true;
    this.last = 0;
    return true;
  }

  /** The pointer has moved: what it holds follows parallel to the picture, but stays in front of the body. */
  drag(ray) {
    if (this.pull === null) return;
    const { back } = this.stage.view(), body = firstHit(ray.origin, ray.direction, this.bodyX, this.bodyTriangles);
    let distance = this.pull.depth / dot(ray.direction, back);
    if (body !== null) distance = Math.min(distance, body.distance - 0.03);
    this.pull.target = along(ray.origin, distance, ray.direction);
  }

  moveHeld() {
    if (this.pull === null) return;
    const { vertex, ring, offsets, target } = this.pull, x = pointAt(this.simulation.positions, vertex), way = difference(target, x);
    const next = along(x, Math.min(1, kPullSpeed / kFps / Math.max(Math.hypot(...way), 1e-9)), way);
    this.simulation.hold(ring, offsets.flatMap((offset) => along(next, 1, offset)));
  }

  drop() {
    if (this.pull === null) return;
    this.simulation.release();
    this.pull = null;
    this.end = Math.max(this.end, this.frame + 2 * kFps);
  }

  judge() {
    const v = selvedge.judge({ x0: this.x, triangles: this.triangles }, { body: { x0: this.bodyX, triangles: this.bodyTriangles }, rest: this.rest });
    const crossings = v.selfCrossings + v.bodyCrossings, clean = crossings === 0 && v.insideVertices === 0 && this.simulation.figure('clean') === 1;
    const verdict = this.simulation.figure('unchecked') === 0 ? 'Clean: nothing passed through anything.'
      : 'No crossing now; this method may have missed collisions before.';
    showVerdict(page('drape_verdict'), clean, clean ? verdict : 'Not clean.', [
      ['cloth crosses itself', v.selfCrossings], ['cloth crosses body', v.bodyCrossings], ['vertices inside the body', v.insideVertices],
      ['largest stretch', `${(100 * v.maxStretch).toFixed(1)} %`], ['steps', this.simulation.steps], ['state', this.simulation.hash]]);
  }
}
