// SPDX-License-Identifier: MIT
// Loads the library beside this file; interface.mjs has the functions and classes.
import create from './selvedge_wasm.mjs';
import { use } from './interface.mjs';
export * from './interface.mjs';

// Emscripten 3.1.6 cannot load the file of an ES module in Node.
const file = new URL('./selvedge_wasm.wasm', import.meta.url);
const inNode = typeof process === 'object' && process.versions?.node !== undefined;
const wasmBinary = inNode ? await (await import('node:fs/promises')).readFile(file) : await (await fetch(file)).arrayBuffer();
use(await create({ wasmBinary }));
