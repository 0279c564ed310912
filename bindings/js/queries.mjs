// SPDX-License-Identifier: MIT
// queries.mjs FOLDER: asks the exact narrow phase and the judge every query of the CSV files below a folder (eight rows of numerators
// and denominators of x, y, z and the truth, in folders "vertex-face" and "edge-edge") and counts wrong answers. Ends with 1 if there
// are any. Uses the package `selvedge`.
import { readFileSync, readdirSync } from 'node:fs';
import { EDGE_EDGE, POINT_TRIANGLE, impactTimes, touchTimes } from 'selvedge';

const files = readdirSync(process.argv[2], { recursive: true }).filter((file) => /(vertex-face|edge-edge)\/[^.]+\.csv$/.test(file)).sort();
const wrong = { missed: 0, invented: 0, judgeDiffers: 0 };
let total = 0;
for (const file of files) {
  const rows = readFileSync(`${process.argv[2]}/${file}`, 'utf8').trim().split('\n').map((line) => line.split(',').map(Number));
  const queries = Float64Array.from(rows.flatMap((row) => [row[0] / row[1], row[2] / row[3], row[4] / row[5]]));
  const kind = file.includes('edge-edge') ? EDGE_EDGE : POINT_TRIANGLE, toi = impactTimes(kind, queries), touch = touchTimes(kind, queries);
  for (let i = 0; i < toi.length; ++i, ++total) {
    const truth = rows[8 * i][6] === 1;
    if (truth && toi[i] === Infinity) ++wrong.missed;
    if (!truth && toi[i] !== Infinity) ++wrong.invented;
    if (truth !== (touch.hi[i] !== Infinity)) ++wrong.judgeDiffers;
  }
}
console.log(`${total} queries: ${wrong.missed} missed, ${wrong.invented} invented; the judge differs in ${wrong.judgeDiffers}`);
process.exitCode = total > 0 && wrong.missed + wrong.invented + wrong.judgeDiffers === 0 ? 0 : 1;
