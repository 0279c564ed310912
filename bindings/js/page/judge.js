// SPDX-License-Identifier: MIT
// The second part of the page: the verdict on two frames of any program, with the pairs that cross.
'use strict';

const kMostPairs = 200; // that the list shows
const kKinds = ['point and triangle', 'triangle and point', 'edge and edge'];

/** Fills a box with a verdict and rows of [name, value]. */
function showVerdict(box, good, sentence, rows) {
  const table = document.createElement('table'), head = document.createElement('strong');
  head.textContent = sentence;
  for (const [name, value] of rows) {
    const row = table.insertRow();
    row.insertCell().textContent = name;
    row.insertCell().textContent = String(value);
  }
  box.replaceChildren(head, table);
  box.className = `verdict ${good ? 'good' : 'bad'}`;
  box.hidden = false;
}

class FrameJudge {
  constructor(stage) {
    Object.assign(this, { stage, frames: [null, null], body: null, pairs: [] });
  }

  /** Takes a file; `place` is 0 or 1 for a frame, or "body". */
  take(place, { name, content }) {
    const mesh = { name, ...selvedge.readMesh(name, content) };
    if (place === 'body') this.body = mesh;
    else this.frames[place] = mesh;
    this.update();
  }

  /** Where the next dropped file goes. */
  nextPlace() {
    return this.frames[0] === null ? 0 : this.frames[1] === null ? 1 : 'body';
  }

  update() {
    const [a, b] = this.frames;
    page('files').textContent = [a, b, this.body].map((mesh, i) => (mesh === null ? '' : `${['t = 0', 't = 1', 'body'][i]}: ${mesh.name}, ${mesh.x0.length / 3} vertices`)).filter(Boolean).join('; ');
    this.stage.remove('cloth', 'body', 'crossing', 'pair', 'contacts');
    page('frames_verdict').hidden = true;
    page('pairs').replaceChildren();
    page('time').disabled = a === null || b === null;
    if (this.body !== null) this.stage.set('body', this.body.x0, this.body.triangles, kBody);
    const one = a ?? b;
    if (one === null) return;
    this.stage.look(one.x0, b?.x0 ?? [], this.body?.x0 ?? []);
    if (a !== null && b !== null) this.judgeBoth(a, b);
    else this.stage.set('cloth', one.x0, one.triangles, kCloth);
  }

  judgeBoth(a, b) {
    if (a.x0.length !== b.x0.length || a.triangles.some((v, i) => v !== b.triangles[i]))
      throw new Error(`${a.name} and ${b.name} have different triangles; they must be frames of one mesh`);
    const body = this.body === null ? null : { x0: this.body.x0, triangles: this.body.triangles }, surface = { x0: a.x0, x1: b.x0, triangles: a.triangles };
    const states = [a, b].map((frame) => selvedge.judge({ x0: frame.x0, triangles: frame.triangles }, { body }));
    const path = selvedge.judgePath(surface, { body });
    const total = states.reduce((sum, s) => sum + s.selfCrossings + s.bodyCrossings, 0) + path.selfCollisions + path.bodyCollisions;
    this.crossings = [a, b].map((frame) => this.crossingTriangles(frame, body));
    this.pairs = [[null, 'self'], ...(body === null ? [] : [[body, 'body']])].flatMap(([other, name]) => this.collisions(surface, other, name));
    showVerdict(page('frames_verdict'), total === 0, total === 0 ? 'Clean: nothing crosses in either frame or between them.' : 'Not clean.', [
      ...states.flatMap((s, i) => [[`cloth crosses itself, t = ${i}`, s.selfCrossings], ...(body === null ? [] : [[`cloth crosses body, t = ${i}`, s.bodyCrossings], [`vertices inside, t = ${i}`, s.insideVertices]])]),
      ['cloth hits itself between', path.selfCollisions], ...(body === null ? [] : [['cloth hits body between', path.bodyCollisions]])]);
    document.documentElement.dataset.total = total;
    this.listPairs();
    this.showAt(1);
  }

  /** Triangles of the cloth that cross something, for the picture. */
  crossingTriangles(frame, body) {
    const surface = { x0: frame.x0, triangles: frame.triangles }, self = selvedge.findMeetings(surface).crossings;
    const other = body === null ? [] : selvedge.findMeetings(surface, body).crossings;
    const found = new Set([...self, ...Array.from(other).filter((_, i) => i % 2 === 0)]);
    return Int32Array.from([...found].flatMap((t) => [...frame.triangles.slice(3 * t, 3 * t + 3)]));
  }

  collisions(surface, other, name) {
    const { count, kind, vertices, toi } = selvedge.findCollisions(surface, other);
    return Array.from({ length: count }, (_, i) => ({ kind: kind[i], name, toi: toi[i], vertices: [...vertices.slice(4 * i, 4 * i + 4)] }));
  }

  listPairs() {
    const list = this.pairs.slice(0, kMostPairs).map((pair) => {
      const button = document.createElement('button');
      button.type = 'button';
      button.textContent = `t = ${pair.toi.toFixed(4)}: ${kKinds[pair.kind]}${pair.name === 'body' ? ' of the body' : ''}, vertices ${pair.vertices.join(' ')}`;
      button.onclick = () => this.showAt(pair.toi, pair);
      return button;
    });
    if (this.pairs.length > list.length) list.push(`and ${this.pairs.length - list.length} more`);
    page('pairs').replaceChildren(...list);
  }

  /** Shows the cloth on its way at time t, with what crosses in red at the ends, or a pair. */
  showAt(t, pair = null) {
    const [a, b] = this.frames, x = a.x0.map((c, i) => (1 - t) * c + t * b.x0[i]);
    page('time').value = t;
    this.stage.remove('crossing', 'pair');
    this.stage.set('cloth', x, a.triangles, kCloth);
    const crossing = t === 0 || t === 1 ? this.crossings[t] : new Int32Array(0);
    if (crossing.length > 0) this.stage.set('crossing', x, crossing, { front: [0.9, 0, 0.1], over: true });
    if (pair !== null) this.stage.set('pair', this.pairLines(x, pair), null, { mode: 'lines', front: [0.9, 0, 0.1], over: true });
    this.stage.draw();
  }

  pairLines(x, { kind, name, vertices }) {
    const ofBody = name === 'self' ? [] : [[1, 2, 3], [0], [2, 3]][kind];
    // Of kind 1 the point is of the other surface.
    const p = vertices.map((v, i) => pointAt(ofBody.includes(i) ? this.body.x0 : x, v));
    if (kind === 2) return [...p[0], ...p[1], ...p[2], ...p[3]];
    const near = p.slice(1).reduce((best, q) => (Math.hypot(...difference(q, p[0])) < Math.hypot(...difference(best, p[0])) ? q : best));
    return [...p[1], ...p[2], ...p[2], ...p[3], ...p[3], ...p[1], ...p[0], ...near];
  }

  /** A sheet of cloth of which one corner passes through the rest. */
  example() {
    const n = 12, frame = (t) => {
      const lines = [];
      for (let i = 0; i < n; ++i)
        for (let k = 0; k < n; ++k) {
          const u = i / (n - 1), w = k / (n - 1), fold = Math.max(0, u - 0.5), angle = t * Math.PI * 1.15;
          lines.push(`v ${Math.min(u, 0.5) + fold * Math.cos(angle)} ${w} ${fold * Math.sin(angle) + 0.02 * w}`);
        }
      for (let i = 0; i + 1 < n; ++i)
        for (let k = 0; k + 1 < n; ++k) lines.push(`f ${i * n + k + 1} ${(i + 1) * n + k + 1} ${(i + 1) * n + k + 2} ${i * n + k + 2}`);
      return lines.join('\n');
    };
    this.body = null;
    this.frames = [null, null];
    this.take(0, { name: 'flat.obj', content: frame(0.6) });
    this.take(1, { name: 'folded.obj', content: frame(1) });
  }
}
