// SPDX-License-Identifier: MIT
// The program of the page that `selvedge view` writes. It draws with WebGL 2 and needs no library.
"use strict";

const $ = id => document.getElementById(id);
const results = JSON.parse($("data").textContent);
const first = results[0];
const frameCount = first.frames.length;
const numbers = first.frames.map(f => f.number);

// ---- numbers of the file ---------------------------------------------------------------------

function bytesOf(text) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

// Positions in metres from 16-bit numbers in a box.
function positionsOf(surface) {
  const levels = new Uint16Array(bytesOf(surface.x).buffer), x = new Float32Array(levels.length);
  for (let i = 0; i < levels.length; ++i) x[i] = surface.low[i % 3] + surface.extent[i % 3] * levels[i] / 65535;
  return x;
}

const meshes = results.map(r => r.triangles.map(text => ({ text, index: null, edges: null })));
function meshOf(r, number) {
  const mesh = meshes[r][number];
  if (mesh.index === null) mesh.index = new Uint32Array(bytesOf(mesh.text).buffer);
  return mesh;
}

function edgesOf(mesh) {
  if (mesh.edges !== null) return mesh.edges;
  const seen = new Set(), list = [], t = mesh.index;
  for (let i = 0; i < t.length; i += 3)
    for (let k = 0; k < 3; ++k) {
      const a = Math.min(t[i + k], t[i + (k + 1) % 3]), b = Math.max(t[i + k], t[i + (k + 1) % 3]);
      const key = a * 4294967296 + b;
      if (seen.has(key)) continue;
      seen.add(key);
      list.push(a, b);
    }
  return mesh.edges = new Uint32Array(list);
}

// ---- geometry --------------------------------------------------------------------------------

// Area vectors of the triangles, and their sums at the vertices.
function normalsOf(x, index) {
  const face = new Float32Array(index.length), sum = new Float32Array(x.length);
  for (let i = 0; i < index.length; i += 3) {
    const a = 3 * index[i], b = 3 * index[i + 1], c = 3 * index[i + 2];
    const ux = x[b] - x[a], uy = x[b + 1] - x[a + 1], uz = x[b + 2] - x[a + 2];
    const vx = x[c] - x[a], vy = x[c + 1] - x[a + 1], vz = x[c + 2] - x[a + 2];
    face[i] = uy * vz - uz * vy;
    face[i + 1] = uz * vx - ux * vz;
    face[i + 2] = ux * vy - uy * vx;
    for (const v of [a, b, c]) for (let k = 0; k < 3; ++k) sum[v + k] += face[i + k];
  }
  normalise(face);
  normalise(sum);
  return [face, sum];
}

function normalise(list) {
  for (let i = 0; i < list.length; i += 3) {
    const l = Math.hypot(list[i], list[i + 1], list[i + 2]) || 1;
    for (let k = 0; k < 3; ++k) list[i + k] /= l;
  }
}

// Corners of the triangles one by one, so that sharp edges of bodies stay sharp: a corner has the
// normal of its vertex unless that is far from the normal of the triangle.
const smoothCosine = 0.77;
function cornersOf(x, index) {
  const [face, sum] = normalsOf(x, index);
  const points = new Float32Array(3 * index.length), normals = new Float32Array(3 * index.length);
  for (let i = 0; i < index.length; ++i) {
    const v = 3 * index[i], f = 3 * Math.floor(i / 3);
    const smooth = face[f] * sum[v] + face[f + 1] * sum[v + 1] + face[f + 2] * sum[v + 2] > smoothCosine;
    for (let k = 0; k < 3; ++k) {
      points[3 * i + k] = x[v + k];
      normals[3 * i + k] = smooth ? sum[v + k] : face[f + k];
    }
  }
  return [points, normals];
}

// Pairs as lines at time t of the step: the edges of the triangle and a cross at the point, or two edges.
function pairLines(pairs, t, size) {
  const list = [];
  for (const pair of pairs) {
    const p = i => [0, 1, 2].map(k => (1 - t) * pair.x0[3 * i + k] + t * pair.x1[3 * i + k]);
    const line = (a, b) => list.push(...a, ...b);
    if (pair.edge_edge) { line(p(0), p(1)); line(p(2), p(3)); continue; }
    line(p(1), p(2)); line(p(2), p(3)); line(p(3), p(1));
    for (let k = 0; k < 3; ++k) {
      const a = p(0), b = p(0);
      a[k] -= size; b[k] += size;
      line(a, b);
    }
  }
  return new Float32Array(list);
}

// ---- colours ---------------------------------------------------------------------------------

const ramps = {
  diverging: [[33, 82, 168], [113, 160, 216], [238, 238, 238], [231, 138, 112], [170, 24, 40]],
  sequential: [[238, 238, 238], [250, 206, 110], [240, 130, 60], [190, 40, 80], [80, 10, 90]]
};
const flagNames = [[8, "given up", [20, 20, 24]], [1, "tangled", [190, 40, 190]], [2, "pinched", [235, 130, 20]], [4, "over the strain limit", [220, 30, 40]]];
const sideColours = [[214, 214, 208], [30, 110, 200], [235, 130, 20]];
const calm = [196, 200, 204];

function ramp(stops, share) {
  const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1), i = Math.min(Math.floor(at), stops.length - 2);
  return stops[i].map((c, k) => Math.round(c + (at - i) * (stops[i + 1][k] - c)));
}

function colourOf(scale, byte) {
  if (scale === "flags") { const flag = flagNames.find(f => byte & f[0]); return flag ? flag[2] : calm; }
  if (scale === "sides") return sideColours[byte === 0 ? 0 : 2 - byte % 2];
  return ramp(ramps[scale], scale === "diverging" ? (byte - 1) / 254 : byte / 255);
}
const palettes = {};
for (const scale of ["diverging", "sequential", "flags", "sides"]) palettes[scale] = Array.from({ length: 256 }, (_, byte) => colourOf(scale, byte));

const valueOf = (field, byte) => field.scale === "diverging" ? (byte - 128) / 127 * field.full : field.scale === "sequential" ? byte / 255 * field.full : byte;
const zeroOf = field => field.scale === "diverging" ? 128 : 0;
const fieldOf = r => results[r].fields.find(f => f.name === state.colour);

// Bytes of a frame, or null where all values are 0.
const fieldBytes = (field, i) => field.frames[i] ? bytesOf(field.frames[i]) : null;

function vertexColours(r, i, vertices) {
  const field = fieldOf(r), colours = new Uint8Array(4 * vertices);
  if (!field) return colours;
  const bytes = fieldBytes(field, i), palette = palettes[field.scale];
  for (let v = 0; v < vertices; ++v) colours.set(palette[bytes ? bytes[v] : zeroOf(field)], 4 * v);
  return colours;
}

const short = x => x === 0 ? "0" : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(2) : String(Number(x.toPrecision(3)));

// ---- camera ----------------------------------------------------------------------------------

const fieldOfView = 35 * Math.PI / 180;
const start = { az: -54, el: 24 };
const state = { frame: first.pairs.length ? 0 : frameCount - 1, colour: "none", wire: false, bodies: true, az: start.az, el: start.el, zoom: 1, pan: [0, 0, 0], playing: false };

// Box of the cloth over all frames and results: the centre of the view and its size.
const bounds = (() => {
  const low = [Infinity, Infinity, Infinity], high = low.map(v => -v);
  for (const result of results) for (const f of result.frames) for (let k = 0; k < 3; ++k) {
    low[k] = Math.min(low[k], f.low[k]);
    high[k] = Math.max(high[k], f.low[k] + f.extent[k]);
  }
  // Bodies of the size of the cloth are shown whole; a floor is not.
  const size = Math.hypot(...low.map((l, k) => high[k] - l)) || 1;
  for (const result of results) for (const b of result.bodies) {
    if (Math.hypot(...b.extent) > 3 * size) continue;
    for (let k = 0; k < 3; ++k) {
      low[k] = Math.min(low[k], b.low[k]);
      high[k] = Math.max(high[k], b.low[k] + b.extent[k]);
    }
  }
  return { centre: low.map((l, k) => (l + high[k]) / 2), radius: Math.hypot(...low.map((l, k) => high[k] - l)) / 2 || 1 };
})();

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

// Axes of the camera, its eye and its matrix, column by column as WebGL takes it.
function camera(aspect) {
  const az = state.az * Math.PI / 180, el = state.el * Math.PI / 180;
  const back = [Math.cos(el) * Math.cos(az), Math.cos(el) * Math.sin(az), Math.sin(el)];
  const right = [-Math.sin(az), Math.cos(az), 0], up = cross(back, right);
  const half = Math.tan(fieldOfView / 2), fit = Math.min(1, aspect);
  const distance = 0.85 * bounds.radius / Math.sin(Math.atan(half * fit)) / state.zoom;
  const target = bounds.centre.map((c, k) => c + state.pan[k]);
  const eye = target.map((t, k) => t + distance * back[k]);
  const near = distance / 100, far = distance + 60 * bounds.radius;
  const f = 1 / half, a = (far + near) / (near - far), b = 2 * far * near / (near - far);
  const rows = [[...right.map(v => v * f / aspect), -dot(right, eye) * f / aspect], [...up.map(v => v * f), -dot(up, eye) * f],
    [...back.map(v => v * a), -dot(back, eye) * a + b], [...back.map(v => -v), dot(back, eye)]];
  const matrix = new Float32Array(16);
  for (let i = 0; i < 4; ++i) for (let k = 0; k < 4; ++k) matrix[4 * k + i] = rows[i][k];
  return { matrix, eye, right, up, back, distance };
}

// ---- drawing ---------------------------------------------------------------------------------

const vertexShader = `#version 300 es
uniform mat4 view;
in vec3 point;
in vec3 normal;
in vec4 colour;
out vec3 at, facing;
out vec3 tint;
void main() { at = point; facing = normal; tint = colour.rgb; gl_Position = view * vec4(point, 1.0); }`;
const fragmentShader = `#version 300 es
precision highp float;
uniform vec3 eye, front, back;
uniform float tinted, lit, alpha;
in vec3 at, facing, tint;
out vec4 result;
void main() {
  vec3 base = mix(gl_FrontFacing ? front : back, tint, tinted);
  if (lit < 0.5) { result = vec4(base * alpha, alpha); return; }
  vec3 n = normalize(facing), towards = normalize(eye - at);
  if (dot(n, towards) < 0.0) n = -n;
  vec3 key = normalize(vec3(0.45, -0.35, 0.82));
  float sky = 0.5 + 0.5 * n.z;
  float light = 0.36 + 0.22 * sky + 0.38 * max(dot(n, key), 0.0) + 0.16 * max(dot(n, towards), 0.0);
  result = vec4(base * light, 1.0);
}`;

const canvas = $("scene");
const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });

function compile() {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertexShader], [gl.FRAGMENT_SHADER, fragmentShader]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  ["point", "normal", "colour"].forEach((name, i) => gl.bindAttribLocation(program, i, name));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  const place = {};
  for (const name of ["view", "eye", "front", "back", "tinted", "lit", "alpha"]) place[name] = gl.getUniformLocation(program, name);
  return { program, place };
}

// Buffers of one surface; `set` fills an attribute.
function makeSurface() {
  const array = gl.createVertexArray(), buffers = [0, 1, 2].map(() => gl.createBuffer()), index = gl.createBuffer(), edges = gl.createBuffer();
  return {
    array, index, edges, count: 0, edgeCount: 0, mesh: null, edgeMesh: null, key: "",
    set(i, data, size, type) {
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[i]);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, size, type, type === gl.UNSIGNED_BYTE, 0, 0);
    },
    setIndex(buffer, data) {
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, data, gl.STATIC_DRAW);
    }
  };
}

let drawer = null;
const surfaces = [];

function loadCloth(r, i) {
  const s = surfaces[r].cloth, frame = results[r].frames[i], key = i + " " + state.colour;
  if (s.key === key) return;
  s.key = key;
  const mesh = meshOf(r, frame.triangles), x = positionsOf(frame);
  s.x = x;
  s.set(0, x, 3, gl.FLOAT);
  s.set(1, normalsOf(x, mesh.index)[1], 3, gl.FLOAT);
  s.set(2, vertexColours(r, i, x.length / 3), 4, gl.UNSIGNED_BYTE);
  if (s.mesh !== mesh) { s.setIndex(s.index, mesh.index); s.mesh = mesh; s.count = mesh.index.length; }
}

function loadEdges(r) {
  const s = surfaces[r].cloth;
  if (s.edgeMesh === s.mesh) return;
  const edges = edgesOf(s.mesh);
  s.setIndex(s.edges, edges);
  s.edgeMesh = s.mesh;
  s.edgeCount = edges.length;
}

function loadBodies(r, i) {
  const s = surfaces[r].bodies, number = results[r].frames[i].bodies;
  if (s.key === number) return;
  s.key = number;
  const body = results[r].bodies[number], [points, normals] = cornersOf(positionsOf(body), meshOf(r, body.triangles).index);
  s.set(0, points, 3, gl.FLOAT);
  s.set(1, normals, 3, gl.FLOAT);
  s.count = points.length / 3;
}

const dye = { front: [0.74, 0.32, 0.28], back: [0.87, 0.74, 0.53] }, grey = [0.66, 0.67, 0.69];

function look(front, back, tinted, lit, alpha) {
  const p = drawer.place;
  gl.uniform3fv(p.front, front);
  gl.uniform3fv(p.back, back);
  gl.uniform1f(p.tinted, tinted);
  gl.uniform1f(p.lit, lit);
  gl.uniform1f(p.alpha, alpha);
}

function drawResult(r, i, area) {
  gl.viewport(...area);
  gl.enable(gl.POLYGON_OFFSET_FILL);
  const eye = camera(area[2] / area[3]);
  gl.uniformMatrix4fv(drawer.place.view, false, eye.matrix);
  gl.uniform3fv(drawer.place.eye, eye.eye);
  const { cloth, bodies, pairs } = surfaces[r];
  if (state.bodies && results[r].frames[i].bodies >= 0) {
    loadBodies(r, i);
    look(grey, grey, 0, 1, 1);
    gl.polygonOffset(4, 4);  // a body stays behind the cloth that lies on it
    gl.bindVertexArray(bodies.array);
    gl.drawArrays(gl.TRIANGLES, 0, bodies.count);
  }
  loadCloth(r, i);
  look(dye.front, dye.back, fieldOf(r) ? 1 : 0, 1, 1);
  gl.bindVertexArray(cloth.array);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, cloth.index);
  gl.polygonOffset(1, 1);  // behind its edges
  gl.drawElements(gl.TRIANGLES, cloth.count, gl.UNSIGNED_INT, 0);
  gl.disable(gl.POLYGON_OFFSET_FILL);
  if (state.wire) {
    loadEdges(r);
    look([0.08, 0.08, 0.1], [0.08, 0.08, 0.1], 0, 0, 0.4);
    gl.bindVertexArray(cloth.array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, cloth.edges);
    gl.drawElements(gl.LINES, cloth.edgeCount, gl.UNSIGNED_INT, 0);
  }
  if (results[r].pairs.length > 0) {
    const lines = pairLines(results[r].pairs, results[r].frames[i].time, 0.01 * bounds.radius);
    pairs.set(0, lines, 3, gl.FLOAT);
    gl.disable(gl.DEPTH_TEST);
    look([0.85, 0, 0.1], [0.85, 0, 0.1], 0, 0, 1);
    gl.bindVertexArray(pairs.array);
    gl.drawArrays(gl.LINES, 0, lines.length / 3);
    gl.enable(gl.DEPTH_TEST);
  }
}

// Part of the canvas of each result in pixels, from the lower left corner: side by side if it is wide.
function areas() {
  const w = canvas.width, h = canvas.height;
  if (results.length === 1) return [[0, 0, w, h]];
  if (w >= h) return [[0, 0, w >> 1, h], [w >> 1, 0, w - (w >> 1), h]];
  return [[0, h >> 1, w, h - (h >> 1)], [0, 0, w, h >> 1]];
}

function draw() {
  const scale = Math.min(devicePixelRatio || 1, 2);
  const w = Math.max(1, Math.round(canvas.clientWidth * scale)), h = Math.max(1, Math.round(canvas.clientHeight * scale));
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  gl.viewport(0, 0, w, h);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.useProgram(drawer.program);
  areas().forEach((area, r) => drawResult(r, state.frame, area));
  placeNames();
  tell();
  document.documentElement.dataset.frame = numbers[state.frame];
  if (probing) probe(w, h);
}

// For tests: how many pixels are drawn, and a number that depends on all of them.
let probing = false;
function probe(w, h) {
  const pixels = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let drawn = 0, hash = 2166136261;
  for (let i = 0; i < pixels.length; i += 4) {
    if (pixels[i + 3] > 0) ++drawn;
    for (let k = 0; k < 4; ++k) hash = Math.imul(hash ^ pixels[i + k], 16777619);
  }
  Object.assign(document.documentElement.dataset, { drawn, pixels: hash >>> 0, width: w, height: h });
}

let due = false;
function redraw() {
  if (due) return;
  due = true;
  requestAnimationFrame(() => { due = false; draw(); });
}

// ---- words -----------------------------------------------------------------------------------

function placeNames() {
  if (results.length === 1) return;
  areas().forEach((area, r) => {
    const name = document.querySelectorAll(".name")[r], scale = canvas.width / canvas.clientWidth;
    name.style.left = area[0] / scale + 6 + "px";
    name.style.top = (canvas.height - area[1] - area[3]) / scale + 6 + "px";
  });
}

function rangeOf(r) {
  const field = fieldOf(r), bytes = field && fieldBytes(field, state.frame);
  if (!bytes) return [0, 0];
  let low = 255, high = 0;
  for (const b of bytes) { low = Math.min(low, b); high = Math.max(high, b); }
  return [valueOf(field, low), valueOf(field, high)];
}

function chip(text, colour) {
  const e = document.createElement("span");
  e.className = "chip";
  e.textContent = text;
  e.style.setProperty("--c", `rgb(${colour})`);
  return e;
}

function countBytes(r, wanted) {
  const field = fieldOf(r), bytes = field && fieldBytes(field, state.frame);
  return bytes ? bytes.reduce((n, b) => n + (wanted(b) ? 1 : 0), 0) : 0;
}

function drawScale() {
  const field = results.map((_, r) => fieldOf(r)).find(f => f), box = $("scale");
  if (!field) return box.replaceChildren(chip("front", dye.front.map(c => 255 * c)), chip("back", dye.back.map(c => 255 * c)));
  const sum = wanted => results.map((_, r) => fieldOf(r) ? countBytes(r, wanted) : 0).join(" and ");
  if (field.scale === "flags") return box.replaceChildren(...flagNames.map(f => chip(`${f[1]}: ${sum(b => b & f[0])} vertices`, f[2])));
  if (field.scale === "sides")
    return box.replaceChildren(chip(`first side: ${sum(b => b % 2 === 1)} vertices`, sideColours[1]), chip(`second side: ${sum(b => b > 0 && b % 2 === 0)}`, sideColours[2]));
  const bar = document.createElement("canvas"), pen = bar.getContext("2d");
  bar.width = 256; bar.height = 1;
  for (let b = 0; b < 256; ++b) { pen.fillStyle = `rgb(${palettes[field.scale][b]})`; pen.fillRect(b, 0, 1, 1); }
  box.replaceChildren(field.scale === "diverging" ? "\u2212" + short(field.full) : "0", bar, short(field.full) + " " + field.unit);
}

function tell() {
  const frame = first.frames[state.frame];
  $("now").textContent = `frame ${frame.number} of ${numbers[frameCount - 1]}, t = ${frame.time.toFixed(3)}` + (first.pairs.length ? "" : " s");
  $("time").value = state.frame;
  $("time").setAttribute("aria-valuetext", $("now").textContent);
  drawScale();
  const words = [];
  results.forEach((result, r) => {
    const field = fieldOf(r), name = results.length > 1 ? (r === 0 ? "First: " : "Second: ") : "";
    if (!field) return state.colour === "none" ? undefined : words.push(name + "no such value.");
    if (field.scale === "flags" || field.scale === "sides") return words.push(name + field.meaning + ".");
    const [low, high] = rangeOf(r);
    words.push(`${name}${field.meaning}; in this frame ${short(low)} to ${short(high)} ${field.unit}.`);
  });
  if (!words.length) words.push(`${first.frames[state.frame].extent.map(short).join(" \u00d7 ")} m is the box of the cloth in this frame.`);
  const text = words.join(" ");
  if ($("what").textContent !== text) $("what").textContent = text;
}

function drawNotes() {
  const list = [];
  results.forEach((result, r) => {
    const name = results.length > 1 ? (r === 0 ? "First: " : "Second: ") : "";
    for (const note of result.notes) list.push(name + note);
    if (result.pieces.length > 1) list.push(`${name}pieces of cloth: ${result.pieces.map(p => p[1]).join(", ")}.`);
    if (result.pairs.length) list.push(`${name}${result.pairs.length} pairs collide during this attempt (red), the first at t = ${short(Math.min(...result.pairs.map(p => p.toi)))}.`);
    list.push(`${name}${result.frames.length} frames; positions are exact to ${short(1000 * result.error_m)} mm.`);
  });
  $("notes").replaceChildren(...list.map(text => { const p = document.createElement("p"); p.className = "soft"; p.textContent = text; return p; }));
}

// ---- what the user does ----------------------------------------------------------------------

function setFrame(i) {
  const wanted = Math.min(Math.max(i, 0), frameCount - 1);
  if (wanted === state.frame) return;
  state.frame = wanted;
  $("picked").textContent = "Select a point of the cloth to read its value.";
  changed();
}

// The address keeps the view, so that it can be sent to somebody.
let keeping = 0;
function changed() {
  $("colour").value = state.colour;
  $("wire").checked = state.wire;
  $("bodies").checked = state.bodies;
  redraw();
  if (state.playing || probing) return;
  clearTimeout(keeping);
  keeping = setTimeout(() => {
    const words = [`frame=${numbers[state.frame]}`, `colour=${state.colour}`, `wire=${state.wire ? 1 : 0}`, `bodies=${state.bodies ? 1 : 0}`, `az=${Math.round(state.az)}`, `el=${Math.round(state.el)}`, `zoom=${state.zoom.toFixed(2)}`];
    history.replaceState(null, "", "#" + words.join("&"));
  }, 300);
}

function readAddress() {
  const given = new URLSearchParams(location.hash.slice(1));
  const number = name => given.has(name) && isFinite(given.get(name)) ? Number(given.get(name)) : null;
  const frame = number("frame");
  if (frame !== null) state.frame = Math.max(0, numbers.findLastIndex(n => n <= frame));
  const colours = [...$("colour").options].map(o => o.value);
  if (colours.includes(given.get("colour"))) state.colour = given.get("colour");
  for (const name of ["wire", "bodies"]) if (given.has(name)) state[name] = given.get(name) === "1";
  if (number("az") !== null) state.az = number("az");
  if (number("el") !== null) state.el = Math.min(Math.max(number("el"), -89), 89);
  if (number("zoom") !== null) state.zoom = Math.min(Math.max(number("zoom"), 0.05), 100);
  probing = given.get("probe") === "1";
}

let playedAt = 0, playedTime = 0;
function play(on) {
  state.playing = on && frameCount > 1;
  $("play").textContent = state.playing ? "Pause" : "Play";
  if (!state.playing) return changed();
  if (state.frame === frameCount - 1) setFrame(0);
  playedAt = performance.now();
  playedTime = first.frames[state.frame].time;
  requestAnimationFrame(advance);
}
function advance(now) {
  if (!state.playing) return;
  const time = playedTime + (now - playedAt) / 1000;
  const next = first.frames.findLastIndex(f => f.time <= time + 1e-9);
  if (next >= 0) setFrame(next);
  if (state.frame === frameCount - 1) return play(false);
  requestAnimationFrame(advance);
}

function turn(dx, dy) {
  state.az -= dx;
  state.el = Math.min(Math.max(state.el + dy, -89), 89);
  changed();
}
function zoom(factor) {
  state.zoom = Math.min(Math.max(state.zoom * factor, 0.05), 100);
  changed();
}
function move(dx, dy) {
  const view = camera(1), metres = 2 * view.distance * Math.tan(fieldOfView / 2) / canvas.clientHeight;
  state.pan = state.pan.map((p, k) => p + metres * (dy * view.up[k] - dx * view.right[k]));
  changed();
}
function reset() {
  Object.assign(state, { az: start.az, el: start.el, zoom: 1, pan: [0, 0, 0] });
  changed();
}
function nextColour() {
  const all = [...$("colour").options].map(o => o.value);
  state.colour = all[(all.indexOf(state.colour) + 1) % all.length];
  changed();
}

// " of " and the name of the piece of a vertex.
function pieceOf(r, vertex) {
  const piece = results[r].pieces.findLast(p => p[0] <= vertex);
  return piece ? ` of ${piece[1]}` : "";
}

// The vertex that is drawn nearest to the eye within a few pixels.
function pick(px, py) {
  const scale = canvas.width / canvas.clientWidth, x = px * scale, y = canvas.height - py * scale;
  const r = areas().findIndex(a => x >= a[0] && x < a[0] + a[2] && y >= a[1] && y < a[1] + a[3]);
  if (r < 0) return;
  const area = areas()[r], m = camera(area[2] / area[3]).matrix, points = surfaces[r].cloth.x;
  let best = -1, depth = Infinity;
  for (let v = 0; v < points.length; v += 3) {
    const row = i => m[i] * points[v] + m[i + 4] * points[v + 1] + m[i + 8] * points[v + 2] + m[i + 12];
    const w = row(3);
    const sx = area[0] + (row(0) / w + 1) / 2 * area[2], sy = area[1] + (row(1) / w + 1) / 2 * area[3];
    if (Math.hypot(sx - x, sy - y) < 9 * scale && w > 0 && w < depth) { depth = w; best = v / 3; }
  }
  if (best < 0) return;
  const field = fieldOf(r), bytes = field && fieldBytes(field, state.frame);
  const value = field ? valueOf(field, bytes ? bytes[best] : zeroOf(field)) : null;
  const flagged = field && field.scale === "flags" ? flagNames.filter(f => value & f[0]).map(f => f[1]).join(", ") || "no flag" : null;
  $("picked").textContent = `Vertex ${best}${pieceOf(r, best)}${results.length > 1 ? (r === 0 ? ", first result," : ", second result,") : ""} at ${[0, 1, 2].map(k => points[3 * best + k].toFixed(4)).join(", ")} m` +
    (field ? `: ${field.name} ${flagged ?? short(value) + " " + field.unit}` : "") + ".";
}

const keys = {
  " ": () => play(!state.playing), ArrowRight: () => setFrame(state.frame + 1), ArrowLeft: () => setFrame(state.frame - 1),
  Home: () => setFrame(0), End: () => setFrame(frameCount - 1), a: () => turn(-6, 0), d: () => turn(6, 0), w: () => turn(0, 6), s: () => turn(0, -6),
  "+": () => zoom(1.15), "=": () => zoom(1.15), "-": () => zoom(1 / 1.15), c: nextColour, r: reset,
  e: () => { state.wire = !state.wire; changed(); }, b: () => { state.bodies = !state.bodies; changed(); }
};

function listen() {
  const pointers = new Map();
  let moved = 0, spread = 0;
  canvas.addEventListener("pointerdown", e => { canvas.setPointerCapture(e.pointerId); pointers.set(e.pointerId, e); moved = 0; spread = 0; });
  canvas.addEventListener("pointermove", e => {
    const last = pointers.get(e.pointerId);
    if (!last) return;
    pointers.set(e.pointerId, e);
    const dx = e.clientX - last.clientX, dy = e.clientY - last.clientY;
    moved += Math.abs(dx) + Math.abs(dy);
    if (pointers.size === 2) {
      const [p, q] = [...pointers.values()], now = Math.hypot(p.clientX - q.clientX, p.clientY - q.clientY);
      if (spread > 0 && now > 0) zoom(now / spread);
      spread = now;
    } else if (e.shiftKey || e.buttons & 6) move(dx, dy);
    else turn(0.4 * dx, 0.4 * dy);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, e => {
    if (pointers.delete(e.pointerId) && moved < 4 && end === "pointerup") pick(e.offsetX, e.offsetY);
    spread = 0;
  });
  canvas.addEventListener("contextmenu", e => e.preventDefault());
  canvas.addEventListener("wheel", e => { e.preventDefault(); zoom(Math.exp(-0.0015 * e.deltaY)); }, { passive: false });
  $("time").addEventListener("input", () => { if (state.playing) play(false); setFrame(Number($("time").value)); });
  $("play").addEventListener("click", () => play(!state.playing));
  $("reset").addEventListener("click", reset);
  $("colour").addEventListener("change", () => { state.colour = $("colour").value; changed(); });
  for (const name of ["wire", "bodies"]) $(name).addEventListener("change", () => { state[name] = $(name).checked; changed(); });
  addEventListener("keydown", e => {
    const own = ["SELECT", "BUTTON", "INPUT"].includes(e.target.tagName);  // they have keys of their own
    if (e.ctrlKey || e.altKey || e.metaKey || !keys[e.key] || own && (e.key.length > 1 || e.key === " " || e.target.tagName === "SELECT")) return;
    e.preventDefault();
    keys[e.key]();
  });
  addEventListener("resize", redraw);
  addEventListener("hashchange", () => { readAddress(); changed(); });
}

function begin() {
  if (!gl) { $("fault").textContent = "This browser has no WebGL 2, which this page needs to draw."; return; }
  drawer = compile();
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  for (const result of results) {
    surfaces.push({ cloth: makeSurface(), bodies: makeSurface(), pairs: makeSurface() });
    if (results.length === 1) continue;
    const name = document.createElement("div");
    name.className = "name";
    name.textContent = result.name;
    canvas.parentElement.append(name);
  }
  const option = (value, text) => { const o = document.createElement("option"); o.value = value; o.textContent = text; $("colour").append(o); };
  option("none", "cloth");
  for (const name of new Set(results.flatMap(r => r.fields.map(f => f.name)))) option(name, name);
  $("time").max = frameCount - 1;
  for (const id of ["time", "play"]) $(id).disabled = frameCount < 2;
  if (results.some(r => r.fields.some(f => f.name === "distance"))) state.colour = "distance";
  drawNotes();
  readAddress();
  listen();
  changed();
  draw();
  document.documentElement.dataset.frames = frameCount;
  document.documentElement.dataset.colours = [...$("colour").options].map(o => o.value).join(" ");
  document.documentElement.dataset.ready = "yes";
}
begin();
