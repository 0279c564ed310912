// SPDX-License-Identifier: MIT
// pack.mjs BUILD PAGE: writes the folder PAGE, the page to try the library, from the output of build.sh in BUILD. Its scripts are
// plain ones, because browsers load neither modules nor data from files on disk; the library and the mannequin stand compressed
// in selvedge.js.
import { cpSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { gzipSync } from 'node:zlib';

const [build, out] = process.argv.slice(2), here = new URL('.', import.meta.url);
const text = (file) => readFileSync(file, 'utf8');
const packed = (file) => gzipSync(readFileSync(file), { level: 9 }).toString('base64');

const library = text(new URL('../interface.mjs', here));
const names = [...library.matchAll(/^export (?:function|class|const) (\w+)/gm)].map((match) => match[1]);
const constants = ['POINT_TRIANGLE', 'TRIANGLE_POINT', 'EDGE_EDGE'];
mkdirSync(out, { recursive: true });
writeFileSync(`${out}/selvedge.js`, `// SPDX-License-Identifier: MIT
// Made by bindings/js/page/pack.mjs from interface.mjs and WebAssembly, which contains GMP (LGPL-3.0-or-later or GPL-2.0-or-later),
// Eigen (MPL-2.0), nlohmann-json and fmt (MIT).
'use strict';
${text(`${build}/selvedge_wasm.js`)}
let selvedgeMannequin;
const selvedge = (() => {
${library.replace(/^export /gm, '')}
async function unpacked(base64) {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).arrayBuffer());
}
async function load() {
  use(await createSelvedge({ wasmBinary: await unpacked('${packed(`${build}/package/selvedge_wasm.wasm`)}') }));
  const mannequin = await unpacked('${packed(new URL('../../../data/bodies/mannequin.ply', here))}');
  selvedgeMannequin = () => mannequin;
}
return { load, ${[...new Set([...names, ...constants])].join(', ')} };
})();
`);
for (const file of ['index.html', 'drawing.js', 'drape.js', 'judge.js', 'page.js']) cpSync(new URL(file, here), `${out}/${file}`);
cpSync(new URL('../../../LICENSE', here), `${out}/LICENSE`);
