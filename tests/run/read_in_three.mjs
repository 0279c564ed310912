// SPDX-License-Identifier: MIT
// Prints what three.js reads from a .glb or .obj file as JSON: of each mesh its name, colour, and for each frame of --frames its
// positions, with the morph targets of that frame. Called by check_in_three.py.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, file, ...frames] = process.argv.slice(2);
const at = name => pathToFileURL(`${folder}/${name}`).href;
globalThis.self = globalThis;
const THREE = await import(at("build/three.module.js"));
const numbers = attribute => attribute ? Array.from(attribute.array) : null;

function read(mesh) {
  const g = mesh.geometry, morphs = g.morphAttributes.position || [], normals = g.morphAttributes.normal || [];
  const moved = (base, changes, frame) => {
    const x = Array.from(base.array);
    if (frame > 0 && changes.length) changes[frame - 1].array.forEach((d, k) => { x[k] += d; });
    return x;
  };
  return {
    name: mesh.userData.name || mesh.name, colour: mesh.material.color.toArray(), index: numbers(g.index), targets: morphs.length,
    uv: numbers(g.attributes.uv), flag: numbers(g.attributes._flag), pressure: numbers(g.attributes._pressure),
    frames: frames.map(Number).map(f => ({ x: moved(g.attributes.position, morphs, f), n: moved(g.attributes.normal, normals, f) }))
  };
}

function print(scene) {
  const meshes = [];
  scene.traverse(o => { if (o.isMesh) meshes.push(read(o)); });
  process.stdout.write(JSON.stringify(meshes));
}

if (file.endsWith(".glb")) {
  const { GLTFLoader } = await import(at("examples/jsm/loaders/GLTFLoader.js"));
  const bytes = readFileSync(file);
  new GLTFLoader().parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), "", gltf => print(gltf.scene),
    error => { console.error(error); process.exit(1); });
} else {
  const { OBJLoader } = await import(at("examples/jsm/loaders/OBJLoader.js"));
  print(new OBJLoader().parse(readFileSync(file, "utf8")));
}
