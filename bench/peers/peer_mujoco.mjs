// SPDX-License-Identifier: MIT
// node peer_mujoco.mjs PACKAGE FOLDER SCENE MODE: simulates the sheet of the case as a flexcomp of MuJoCo on its body and
// writes FOLDER/MODE/*.obj. PACKAGE is the folder of the npm package @mujoco/mujoco (WebAssembly, one thread).
//   mujoco      contacts are constraints with friction
//   mujoco_ipc  flag ipc: no step ends with a crossing; its contacts have no friction
// Cloth and contacts have the settings of MuJoCo's model poncho_edgeequality.xml, with the integrator that bending now
// needs, a radius for cells of this size and, with `mujoco`, the friction of the case.
// MuJoCo collides a mesh as its convex hull. The ball and the boxes are convex. With `mujoco` they are meshes, because the
// sheet crosses the edge of a box that is a primitive. With `mujoco_ipc` they are primitives, because edges and vertices of a
// mesh slow a sheet without friction. The human body is a geom of type sdf (a distance function of the mesh) with `mujoco` and a
// rigid flex with `mujoco_ipc`.
import fs from 'node:fs';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

const FPS = 60, SUBSTEPS = 8, RADIUS = 0.004; // m, half the thickness of the flex
const [where, folder, scene, mode] = process.argv.slice(2);
if (!mode) throw new Error('usage: node peer_mujoco.mjs PACKAGE FOLDER SCENE mujoco|mujoco_ipc');

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

const PRIMITIVES = {
  ball: 'type="sphere" size="0.15"',
  edge: 'type="box" size="0.15 0.45 0.15" axisangle="0 1 0 45"',
  incline: 'type="box" size="2 0.5 0.1" axisangle="0 1 0 30"',
};

function bodyOf(friction) {
  const mesh = readObj(path.join(folder, 'body.obj'));
  if (mode === 'mujoco_ipc' && scene === 'body')
    return {asset: '', geom: `<flexcomp name="body" type="direct" dim="2" rigid="true" radius="0.0005" mass="1"
      point="${flat(mesh.points)}" element="${flat(mesh.faces)}"><contact selfcollide="none" internal="false"/></flexcomp>`};
  if (mode === 'mujoco_ipc') return {asset: '', geom: `<geom ${PRIMITIVES[scene]}/>`};
  const type = scene === 'body' ? 'sdf' : 'mesh';
  return {asset: `<asset><mesh name="body" vertex="${flat(mesh.points)}" face="${flat(mesh.faces)}"/></asset>`,
          geom: `<geom type="${type}" mesh="body" friction="${friction} 0.005 0.0001" solref="0.003 1"/>`};
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

function model(sheet, given) {
  const s = SETTINGS, body = bodyOf(given.friction);
  const flags = mode === 'mujoco_ipc' ? '<flag ipc="enable"/>' : '';
  return `<mujoco>
    <option timestep="${1 / FPS / SUBSTEPS}" integrator="${s.integrator}" solver="${s.solver}"
      tolerance="${s.tolerance}">${flags}</option>
    <size memory="1G"/>${body.asset}
    <worldbody>${body.geom}
      <flexcomp name="sheet" type="direct" dim="2" radius="${RADIUS}" mass="${given.density * given.size ** 2}"
          point="${flat(sheet.points)}" element="${flat(sheet.faces)}">
        <edge equality="true" damping="0.1"/>
        <elasticity young="3e5" poisson="0" thickness="8e-3" elastic2d="bend" damping="0.02"/>
        <contact selfcollide="auto" internal="false" solref="${s.contact_solref}"
          friction="${given.friction} 0.005 0.0001"/>
      </flexcomp>
    </worldbody></mujoco>`;
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
mujoco.mj_forward(compiled, data);
const first = compiled.nflex === 2 ? compiled.flex_vertadr[1] : 0; // the rigid body is the first flex
const positions = () => Array.from(data.flexvert_xpos.subarray(3 * first, 3 * (first + sheet.points.length)));
write(0, positions(), sheet.points.length, sheet.faces);
let seconds = 0;
for (let frame = 1; frame <= given.frames; ++frame) {
  const start = process.cpuUsage();
  for (let k = 0; k < SUBSTEPS; ++k) mujoco.mj_step(compiled, data);
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
const settings = {...SETTINGS, friction: mode === 'mujoco' ? given.friction : 'none with ipc', warnings};
fs.writeFileSync(path.join(folder, mode, 'report.json'), JSON.stringify({
  program: `MuJoCo ${version}${mode === 'mujoco_ipc' ? ', ipc' : ''}`, seconds, settings}) + '\n');
