// SPDX-License-Identifier: MIT
// check.mjs BUILD PICTURES [SCENE.json HASH STEPS]: tries the output of build.sh in Chromium: the page from disk, wide and as on a
// phone (drape, pull, judge, two frames, a dropped body), with pictures in the folder PICTURES, and the npm package as a module
// from a static server, where a scene must end with HASH after six frames. Ends with 1 at the first fault, and if anything is
// written to the console of the browser.
import assert from 'node:assert';
import { createServer } from 'node:http';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { Browser } from './browser.mjs';

const [build, pictures, scene, hash] = process.argv.slice(2);
mkdirSync(pictures, { recursive: true });
const here = new URL('.', import.meta.url).pathname, address = pathToFileURL(resolve(build, 'page/index.html')).href;
const browser = new Browser();
const save = async (name) => writeFileSync(join(pictures, `${name}.png`), await browser.picture());
const words = (id) => browser.evaluate(`document.getElementById("${id}").innerText`);

/** Milliseconds of a frame, over n of them: by the clock, and of the processor in the thread of the page. */
async function frameTimes(n) {
  const at = async () => {
    const [frame, clock] = await browser.evaluate('[Number(document.documentElement.dataset.frame), performance.now()]');
    const { metrics } = await browser.call('Performance.getMetrics');
    return { frame, clock, thread: 1000 * metrics.find(({ name }) => name === 'ThreadTime').value };
  };
  const first = await at();
  await browser.until(`document.documentElement.dataset.frame >= ${first.frame + n}`);
  const last = await at(), frames = last.frame - first.frame;
  return { clock: (last.clock - first.clock) / frames, thread: (last.thread - first.thread) / frames };
}

async function drape() {
  await browser.until('document.documentElement.dataset.ready === "yes"');
  await browser.evaluate('document.getElementById("contacts").click()');
  await browser.until('document.documentElement.dataset.frame >= 20');
  const { clock, thread } = await frameTimes(150);
  console.log(`40 x 40 on the mannequin: ${(1000 / clock).toFixed(1)} frames a second; the thread of the page takes ${thread.toFixed(1)} ms of the processor a frame, ` +
    `${(1000 / thread).toFixed(1)} frames a second of it`);
  await browser.until('!document.getElementById("drape_verdict").hidden');
  const verdict = await words('drape_verdict');
  assert.match(verdict, /^Clean/, verdict);
  await save('wide');
}

/** Takes the cloth where the ray through a place of the picture meets it and pulls it sideways. */
async function pull() {
  const before = await browser.evaluate('Number(document.documentElement.dataset.frame)');
  const box = await browser.evaluate('(({ left, top, width, height }) => ({ left, top, width, height }))(document.getElementById("scene").getBoundingClientRect())');
  const x = box.left + 0.5 * box.width, y = box.top + 0.42 * box.height;
  await browser.mouse('mousePressed', x, y);
  for (let i = 1; i <= 20; ++i) {
    await browser.mouse('mouseMoved', x + 8 * i, y + 2 * i);
    await new Promise((done) => setTimeout(done, 50));
  }
  await save('pulled');
  const frames = await browser.evaluate('Number(document.documentElement.dataset.frame)') - before;
  await browser.mouse('mouseReleased', x + 160, y + 40);
  assert(frames > 0, 'the cloth did not move when the pointer pulled it');
  await browser.until('!document.getElementById("drape_verdict").hidden && document.documentElement.dataset.frame > ' + (before + frames + 60));
  assert.match(await words('drape_verdict'), /^Clean/);
}

async function frames() {
  await browser.evaluate('document.getElementById("tab_judge").click()');
  await browser.evaluate('document.getElementById("example").click()');
  assert.match(await words('frames_verdict'), /^Not clean/);
  assert(await browser.evaluate('Number(document.documentElement.dataset.total)') > 0);
  await browser.evaluate('document.querySelector("#pairs button").click()');
  await save('frames');
  const folder = resolve(pictures);
  writeFileSync(join(folder, 'a.obj'), 'v 0 0 1\nv 1 0 1\nv 0 1 1\nv -1 -1 0\nv 3 -1 0\nv -1 3 0\nf 1 2 3\nf 4 5 6\n');
  writeFileSync(join(folder, 'b.obj'), 'v 0 0 -1\nv 1 0 -1\nv 0 1 -1\nv -1 -1 0\nv 3 -1 0\nv -1 3 0\nf 1 2 3\nf 4 5 6\n');
  await browser.choose('#frame_0', join(folder, 'a.obj'));
  await browser.until('document.getElementById("files").innerText.includes("a.obj")');
  await browser.choose('#frame_1', join(folder, 'b.obj'));
  await browser.until('document.getElementById("files").innerText.includes("b.obj")');
  assert.match(await words('frames_verdict'), /cloth hits itself between\s+3/);
}

async function droppedBody() {
  await browser.evaluate('document.getElementById("tab_drape").click()');
  const ring = resolve(here, '../../../data/bodies/mannequin_arms_out.ply');
  await browser.choose('#body_file', ring);
  await browser.until('document.getElementById("body").value === "dropped" && document.documentElement.dataset.frame >= 10');
  assert.equal(await words('fault'), '');
}

async function phone() {
  await browser.open(address, { width: 390, height: 844, mobile: true, scale: 2 });
  await browser.until('document.documentElement.dataset.ready === "yes" && document.documentElement.dataset.frame >= 60');
  assert(await browser.evaluate('document.documentElement.scrollWidth <= innerWidth'), 'the page is wider than the phone');
  await save('narrow');
}

/** A module on a static server imports the package. */
async function served() {
  const types = { mjs: 'text/javascript', wasm: 'application/wasm', html: 'text/html' };
  const server = createServer((request, answer) => {
    const name = request.url.slice(1) || 'index.html';
    answer.setHeader('Content-Type', types[name.split('.').pop()] ?? 'text/plain');
    answer.end(name === 'index.html' ? '<!doctype html><link rel="icon" href="data:,"><title>selvedge</title>' : readFileSync(join(build, 'package', name)));
  });
  await new Promise((done) => server.listen(0, done));
  await browser.open(`http://localhost:${server.address().port}/`, { width: 400, height: 300 });
  await browser.until('document.title === "selvedge"');
  const found = await browser.evaluate(`import('/index.mjs').then((s) => {
    const simulation = new s.Simulation(${JSON.stringify(readFileSync(scene, 'utf8'))});
    simulation.advance(6);
    return simulation.hash;
  })`);
  server.close();
  assert.equal(found, hash);
  console.log(`module from a server: ${scene.replace(/.*\//, '')} has the hash ${found}`);
}

await browser.open(address, { width: 1280, height: 800 });
await drape();
await pull();
await frames();
await droppedBody();
await phone();
if (scene) await served();
await browser.close();
assert.deepEqual(browser.messages, []);
console.log('console: empty');
