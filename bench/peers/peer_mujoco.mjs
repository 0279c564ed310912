// SPDX-License-Identifier: MIT
// node peer_mujoco.mjs PACKAGE FOLDER MODE: simulates the sheet of the case as a flexcomp of MuJoCo on its bodies and
// writes FOLDER/MODE/*.obj. PACKAGE is the folder of the npm package @mujoco/mujoco (WebAssembly, one thread).
//   mujoco      contacts are constraints with friction
//   mujoco_ipc  flag ipc: no step ends with a crossing; its contacts have no friction
// Cloth and contacts have the settings of MuJoCo's model poncho_edgeequality.xml, with the integrator that bending now
// needs, a radius for cells of this size and, with `mujoco`, the friction of the case.
// MuJoCo collides a mesh as its convex hull. The ball and the boxes are convex. With `mujoco` they are meshes, because the
// sheet crosses the edge of a box that is a primitive. With `mujoco_ipc` they are primitives, because edges and vertices of a
// mesh slow a sheet without friction. The human body is a geom of type sdf (a distance function of the mesh) with `mujoco` and a
// rigid flex with `mujoco_ipc`. Bodies that move as prescribed weigh 1000 kg and slide with the velocity that takes
// them there (contacts do not see the velocity of a mocap body). Held vertices are equality constraints with the world.
import fs from 'node:fs';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

const FPS = 60, SUBSTEPS = 8, RADIUS = 0.004; // m, half the thickness of the flex
const [where, folder, mode] = process.argv.slice(2);
if (!mode) throw new Error('usage: node peer_mujoco.mjs PACKAGE FOLDER mujoco|mujoco_ipc');

const numbers = words => words.map(Number);

function readObj(file) {
  const mesh = {points: [], faces: []};
  for (const line of fs.readFileSync(file, 'ascii').split('\n')) {
    const [kind, ...words] = line.split(' ');
    if (kind === 'v') mesh.points.push(numbers(words));
    if (kind === 'f') mesh.faces.push(numbers(words).map(i => i - 1));
  }
  return mesh;
}

const flat = rows => rows.map(row => row.join(' ')).join(' ');

function primitive(part) {
  const half = part.shape === 'ball' ? part.size : part.size.map(x => x / 2);
  return `type="${part.shape === 'ball' ? 'sphere' : 'box'}" size="${half.join(' ')}" pos="${part.centre.join(' ')}"
    axisangle="0 1 0 ${part.degrees}"`;
}

// Asset and geom of a body.
function bodyOf(part, k, friction) {
  const mesh = readObj(path.join(folder, `part_${k}.obj`));
  if (mode === 'mujoco_ipc' && part.shape === 'mesh')
    return {asset: '', geom: `<flexcomp name="body" type="direct" dim="2" rigid="true" radius="0.0005" mass="1"
      point="${flat(mesh.points)}" element="${flat(mesh.faces)}"><contact selfcollide="none" internal="false"/></flexcomp>`};
  const moves = Object.keys(part.motion).length > 0;
  const slides = ['1 0 0', '0 1 0', '0 0 1'].map(axis => `<joint type="slide" axis="${axis}"/>`).join('');
  const inBody = geom => moves ? `<body name="body_${k}" gravcomp="1">${slides}
    <inertial pos="0 0 0" mass="1000" diaginertia="1 1 1"/>${geom}</body>` : geom;
  if (mode === 'mujoco_ipc') return {asset: '', geom: inBody(`<geom ${primitive(part)}/>`)};
  const type = part.shape === 'mesh' ? 'sdf' : 'mesh';
  return {asset: `<mesh name="mesh_${k}" vertex="${flat(mesh.points)}" face="${flat(mesh.faces)}"/>`,
          geom: inBody(`<geom type="${type}" mesh="mesh_${k}" friction="${friction} 0.005 0.0001" solref="0.003 1"/>`)};
}

// Where the keys [time, x, y, z] have taken a body.
function shiftAt(keys, time) {
  for (let k = 1; k < keys.length; ++k) {
    const [a, b] = [keys[k - 1], keys[k]], s = (time - a[0]) / (b[0] - a[0]);
    if (s < 1) return [1, 2, 3].map(i => a[i] + s * (b[i] - a[i]));
  }
  return keys.at(-1).slice(1);
}

const SETTINGS = {
  integrator: 'discrete',
  solver: 'CG',
  tolerance: 1e-6,
  steps_per_frame: SUBSTEPS,
  radius_m: RADIUS,
  edge: 'equality, damping 0.1',
  bending: 'young 3e5, poisson 0, thickness 8e-3, damping 0.02',
  contact_solref: '0.003 1',
};

// At MuJoCo's default, 0.02 1, the strip of the jaws becomes 0.63 m long instead of 0.36 m.
const edgeSolref = given => given.held_vertices.length ? '0.003 1' : '0.02 1';

// Its manual names both against slipping grips: with the default cone, pyramidal, and impratio 1, the strip creeps in the jaws.
const GRIP = 'cone="elliptic" impratio="10"';
const gripOf = given => given.release_s === undefined ? '' : GRIP;

function model(sheet, given) {
  const s = SETTINGS, bodies = given.parts.map((part, k) => bodyOf(part, k, given.friction));
  const held = given.held_vertices.map(i => `<connect body1="sheet_${i}" anchor="0 0 0" solref="0.003 1"/>`);
  const flags = mode === 'mujoco_ipc' ? '<flag ipc="enable"/>' : '';
  return `<mujoco>
    <option timestep="${1 / FPS / SUBSTEPS}" integrator="${s.integrator}" solver="${s.solver}"
      tolerance="${s.tolerance}" ${gripOf(given)} gravity="${given.gravity.join(' ')}">${flags}</option>
    <size memory="1G"/><asset>${bodies.map(b => b.asset).join('')}</asset>
    <worldbody>${bodies.map(b => b.geom).join('')}
      <flexcomp name="sheet" type="direct" dim="2" radius="${RADIUS}" mass="${given.mass_kg}"
          point="${flat(sheet.points)}" element="${flat(sheet.faces)}">
        <edge equality="true" damping="0.1" solref="${edgeSolref(given)}"/>
        <elasticity young="3e5" poisson="0" thickness="8e-3" elastic2d="bend" damping="0.02"/>
        <contact selfcollide="auto" internal="false" solref="${s.contact_solref}"
          friction="${given.friction} 0.005 0.0001"/>
      </flexcomp>
    </worldbody><equality>${held.join('')}</equality></mujoco>`;
}

function write(frame, x, count, faces) {
  const lines = [];
  for (let i = 0; i < count; ++i) lines.push(`v ${x[3 * i]} ${x[3 * i + 1]} ${x[3 * i + 2]}`);
  for (const f of faces) lines.push(`f ${f.map(i => i + 1).join(' ')}`);
  fs.writeFileSync(path.join(folder, mode, `frame_${String(frame).padStart(4, '0')}.obj`), lines.join('\n') + '\n');
}

const version = JSON.parse(fs.readFileSync(path.join(where, 'package.json'))).version;
const mujoco = await (await import(pathToFileURL(path.join(where, 'mujoco.js')))).default();
const given = JSON.parse(fs.readFileSync(path.join(folder, 'case.json')));
const sheet = readObj(path.join(folder, 'sheet.obj'));
fs.rmSync(path.join(folder, mode), {recursive: true, force: true});
fs.mkdirSync(path.join(folder, mode));
const compiled = mujoco.MjModel.from_xml_string(model(sheet, given));
const data = new mujoco.MjData(compiled);
const first = compiled.nflex === 2 ? compiled.flex_vertadr[1] : 0; // the rigid body is the first flex
for (const i of given.loaded_vertices)
  compiled.body_mass[compiled.flex_vertbodyid[first + i]] += given.load_kg / given.loaded_vertices.length;
if (given.loaded_vertices.length) mujoco.mj_setConst(compiled, data);
mujoco.mj_forward(compiled, data);
const moving = given.parts.map(part => part.motion[mode]).filter(keys => keys);

let lag = 0; // m, of a moving body behind its prescribed place

// This package has no eq_active: the constraints of the held vertices hold the world instead.
function release() {
  for (let k = 0; k < compiled.neq; ++k)
    if (compiled.eq_type[k] === mujoco.mjtEq.mjEQ_CONNECT.value) compiled.eq_obj1id[k] = compiled.eq_obj2id[k] = 0;
}

function step() {
  const dt = compiled.opt.timestep;
  moving.forEach((keys, k) => {
    shiftAt(keys, data.time + dt).forEach((x, i) => {
      data.qvel[3 * k + i] = (x - data.qpos[3 * k + i]) / dt;
    });
  });
  if (data.time > given.release_s - 1e-9) release();
  mujoco.mj_step(compiled, data);
  moving.forEach((keys, k) => shiftAt(keys, data.time).forEach((x, i) => {
    lag = Math.max(lag, Math.abs(x - data.qpos[3 * k + i]));
  }));
}

const positions = () => Array.from(data.flexvert_xpos.subarray(3 * first, 3 * (first + sheet.points.length)));
write(0, positions(), sheet.points.length, sheet.faces);
let seconds = 0;
for (let frame = 1; frame <= given.frames; ++frame) {
  const start = process.cpuUsage();
  for (let k = 0; k < SUBSTEPS; ++k) step();
  const used = process.cpuUsage(start);
  seconds += (used.user + used.system) / 1e6;
  const x = positions();
  if (!x.every(Number.isFinite)) throw new Error(`frame ${frame} holds positions that are not finite`);
  write(frame, x, sheet.points.length, sheet.faces);
}
const warnings = [];
for (let k = 0; k < mujoco.mjtWarning.mjNWARNING.value; ++k) {
  const count = data.warning.get(k).number;
  if (count > 0) warnings.push(`warning ${k}: ${count} times`);
}
const friction = mode === 'mujoco' ? given.friction : 'none with ipc';
const settings = {...SETTINGS, edge_solref: edgeSolref(given), grip: gripOf(given), friction, largest_lag_m: lag, warnings};
fs.writeFileSync(path.join(folder, mode, 'report.json'), JSON.stringify({
  program: `MuJoCo ${version}${mode === 'mujoco_ipc' ? ', ipc' : ''}`, seconds, settings}) + '\n');
