// SPDX-License-Identifier: MIT
// Surfaces, points and lines on a canvas by WebGL 2, and rays from the camera into them. Needs no library.
'use strict';

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const along = (a, s, b) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const difference = (a, b) => along(a, -1, b);
const pointAt = (x, v) => [x[3 * v], x[3 * v + 1], x[3 * v + 2]];

/** Normals at the vertices, weighted by the areas of their triangles; not normalised. */
function vertexNormals(x, triangles) {
  const sum = new Float32Array(x.length);
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i], b = 3 * triangles[i + 1], c = 3 * triangles[i + 2];
    const ux = x[b] - x[a], uy = x[b + 1] - x[a + 1], uz = x[b + 2] - x[a + 2];
    const vx = x[c] - x[a], vy = x[c + 1] - x[a + 1], vz = x[c + 2] - x[a + 2];
    const n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const v of [a, b, c]) for (let k = 0; k < 3; ++k) sum[v + k] += n[k];
  }
  return sum;
}

/** The box of positions: [lowest, highest]. */
function boxOf(x) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < x.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], x[i]);
    high[i % 3] = Math.max(high[i % 3], x[i]);
  }
  return [low, high];
}

/** The first triangle on a ray: { distance, triangle }, or null. Möller and Trumbore, "Fast, minimum storage ray/triangle
 * intersection", 1997. For the pointer only, so in rounded numbers. */
function firstHit(origin, direction, x, triangles) {
  let best = null;
  for (let i = 0; i < triangles.length; i += 3) {
    const a = pointAt(x, triangles[i]), ab = difference(pointAt(x, triangles[i + 1]), a), ac = difference(pointAt(x, triangles[i + 2]), a);
    const p = cross(direction, ac), determinant = dot(ab, p);
    if (determinant === 0) continue;
    const from = difference(origin, a), u = dot(from, p) / determinant, q = cross(from, ab), v = dot(direction, q) / determinant;
    const distance = dot(ac, q) / determinant;
    if (u >= 0 && v >= 0 && u + v <= 1 && distance > 0 && (best === null || distance < best.distance)) best = { distance, triangle: i / 3 };
  }
  return best;
}

const kVertexShader = `#version 300 es
uniform mat4 view;
uniform float size;
in vec3 point;
in vec3 normal;
out vec3 at, facing;
void main() { at = point; facing = normal; gl_Position = view * vec4(point, 1.0); gl_PointSize = size; }`;
const kFragmentShader = `#version 300 es
precision highp float;
uniform vec3 eye, front, back;
uniform float lit;
in vec3 at, facing;
out vec4 result;
void main() {
  vec3 base = gl_FrontFacing ? front : back;
  if (lit < 0.5) { result = vec4(front, 1.0); return; }
  vec3 towards = normalize(eye - at);
  vec3 n = normalize(facing + 1e-20 * towards);
  if (dot(n, towards) < 0.0) n = -n;
  float light = 0.42 + 0.14 * n.z + 0.34 * max(dot(n, normalize(vec3(0.4, -0.4, 0.8))), 0.0) + 0.16 * max(dot(n, towards), 0.0);
  result = vec4(base * light, 1.0);
}`;

function compiledProgram(gl) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, kVertexShader], [gl.FRAGMENT_SHADER, kFragmentShader]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.bindAttribLocation(program, 0, 'point');
  gl.bindAttribLocation(program, 1, 'normal');
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}

/** A canvas with named parts, a camera that the pointer turns, and rays. */
class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext('webgl2', { antialias: true });
    if (this.gl === null) throw new Error('this browser has no WebGL 2');
    this.program = compiledProgram(this.gl);
    this.parts = new Map();
    /** Whether the picture differs from what was drawn last. */
    this.changed = true;
    this.camera = { azimuth: -0.95, elevation: 0.35, zoom: 1, centre: [0, 0, 0.4], radius: 1 };
  }

  /** Shows positions: triangles, or with `mode` "lines" or "points" rows of these. Without an index: all rows in order. */
  set(name, x, index, { mode = 'triangles', front = [0.7, 0.7, 0.7], back = front, size = 1, behind = 0, over = false } = {}) {
    const gl = this.gl;
    const part = this.parts.get(name) ?? { array: gl.createVertexArray(), buffers: [gl.createBuffer(), gl.createBuffer()], indices: gl.createBuffer(), index: null };
    this.parts.set(name, Object.assign(part, { mode, front, back, size, behind, over }));
    gl.bindVertexArray(part.array);
    const lists = [new Float32Array(x)];
    if (mode === 'triangles') lists.push(vertexNormals(lists[0], index));
    lists.forEach((list, i) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, part.buffers[i]);
      gl.bufferData(gl.ARRAY_BUFFER, list, gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 0, 0);
    });
    if (index != null && part.index !== index) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.indices);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(index), gl.STATIC_DRAW);
    }
    part.index = index;
    part.count = index?.length ?? x.length / 3;
    this.changed = true;
  }

  remove(...names) {
    for (const part of names.map((name) => this.parts.get(name)).filter((p) => p !== undefined)) {
      this.gl.deleteVertexArray(part.array);
      [...part.buffers, part.indices].forEach((buffer) => this.gl.deleteBuffer(buffer));
    }
    names.forEach((name) => this.parts.delete(name));
    this.changed = true;
  }

  /** Turns the camera to the box of positions. */
  look(...surfaces) {
    const boxes = surfaces.filter((x) => x.length > 0).map(boxOf);
    if (boxes.length === 0) return;
    const low = [0, 1, 2].map((k) => Math.min(...boxes.map((box) => box[0][k]))), high = [0, 1, 2].map((k) => Math.max(...boxes.map((box) => box[1][k])));
    Object.assign(this.camera, { centre: low.map((l, k) => (l + high[k]) / 2), radius: Math.hypot(...difference(high, low)) / 2 || 1, zoom: 1 });
    this.changed = true;
  }

  /** Eye, axes and half the height of the picture at distance 1. */
  view() {
    const { azimuth, elevation, zoom, centre, radius } = this.camera, aspect = this.canvas.clientWidth / this.canvas.clientHeight || 1;
    const back = [Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation)];
    const right = [-Math.sin(azimuth), Math.cos(azimuth), 0], up = cross(back, right), half = Math.tan(0.3);
    const distance = radius / Math.sin(Math.atan(half * Math.min(1, aspect))) / zoom;
    return { back, right, up, half, aspect, distance, eye: along(centre, distance, back) };
  }

  /** The ray through a place of the canvas, in pixels of the page. */
  ray(left, top) {
    const { back, right, up, half, aspect, eye } = this.view();
    const across = (2 * left / this.canvas.clientWidth - 1) * half * aspect, upwards = (1 - 2 * top / this.canvas.clientHeight) * half;
    const direction = along(along(along([0, 0, 0], -1, back), across, right), upwards, up), length = Math.hypot(...direction);
    return { origin: eye, direction: direction.map((c) => c / length) };
  }

  /** Turns by pixels of the page. */
  turn(dx, dy) {
    this.camera.azimuth -= 0.008 * dx;
    this.camera.elevation = Math.min(1.5, Math.max(-1.5, this.camera.elevation + 0.008 * dy));
    this.changed = true;
  }
  zoom(factor) {
    this.camera.zoom = Math.min(20, Math.max(0.2, this.camera.zoom * factor));
    this.changed = true;
  }

  matrix({ back, right, up, half, aspect, distance, eye }) {
    const near = distance / 200, far = 4 * distance + 20 * this.camera.radius, a = (far + near) / (near - far), b = 2 * far * near / (near - far);
    const rows = [[...right.map((c) => c / half / aspect), -dot(right, eye) / half / aspect], [...up.map((c) => c / half), -dot(up, eye) / half],
      [...back.map((c) => a * c), b - a * dot(back, eye)], [...back.map((c) => -c), dot(back, eye)]];
    return Float32Array.from({ length: 16 }, (_, i) => rows[i % 4][i >> 2]);
  }

  resize() {
    const scale = Math.min(globalThis.devicePixelRatio || 1, 2), { canvas } = this;
    const w = Math.max(1, Math.round(canvas.clientWidth * scale)), h = Math.max(1, Math.round(canvas.clientHeight * scale));
    if (canvas.width !== w || canvas.height !== h) {
      Object.assign(canvas, { width: w, height: h });
      this.changed = true;
    }
    this.gl.viewport(0, 0, w, h);
    return scale;
  }

  draw() {
    const { gl, program } = this, place = (name) => gl.getUniformLocation(program, name), scale = this.resize(), view = this.view();
    if (!this.changed) return;
    this.changed = false;
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(program);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.uniformMatrix4fv(place('view'), false, this.matrix(view));
    gl.uniform3fv(place('eye'), view.eye);
    const modes = { triangles: gl.TRIANGLES, lines: gl.LINES, points: gl.POINTS };
    for (const part of [...this.parts.values()].sort((a, b) => a.over - b.over)) {
      gl[part.over ? 'disable' : 'enable'](gl.DEPTH_TEST);
      gl.polygonOffset(part.behind, part.behind);
      gl.uniform3fv(place('front'), part.front);
      gl.uniform3fv(place('back'), part.back);
      gl.uniform1f(place('size'), part.size * scale);
      gl.uniform1f(place('lit'), part.mode === 'triangles' && !part.over ? 1 : 0);
      gl.bindVertexArray(part.array);
      if (part.index == null) {
        gl.drawArrays(modes[part.mode], 0, part.count);
      } else {
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.indices);
        gl.drawElements(modes[part.mode], part.count, gl.UNSIGNED_INT, 0);
      }
    }
  }
}
