// SPDX-License-Identifier: MIT
//
// Drafts a FreeSewing design with the measures of a body, as a pattern for `selvedge dress --arrange`:
//
//   npm install --legacy-peer-deps          (in this folder)
//   node draft.mjs aaron BODY.obj out/aaron.json [SELVEDGE OPTIONS, such as --up z]
//   selvedge dress out/aaron.json BODY.obj --arrange --out out/aaron
//
// What is sewn to what stands below, by the names that the designs give their points. No length does.
import { execFileSync } from 'node:child_process'
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs'
import { dirname } from 'node:path'

// Pieces: the part of the design, and whether it is cut on the fold or twice. Seams: chains of edges
// between named points, end to start; "~" names the half that is not drawn.
const designs = {
  aaron: {
    package: 'aaron',
    name: 'Aaron',
    pieces: { front: { part: 'aaron.front', fold: ['cfNeck', 'cfHem'] }, back: { part: 'aaron.back', fold: ['cbNeck', 'cbHem'] } },
    seams: [
      [['front', 'hem', 'armhole'], ['~back', 'hem', 'armhole']],
      [['front', 'strapRight', 'strapLeft'], ['~back', 'strapRight', 'strapLeft']],
    ],
  },
  teagan: {
    package: 'teagan',
    name: 'Teagan',
    pieces: {
      front: { part: 'teagan.front', fold: ['cfNeck', 'cbHem'] },
      back: { part: 'teagan.back', fold: ['cbNeck', 'cbHem'] },
      sleeve: { part: 'teagan.sleeve', pair: 'right' },
    },
    seams: [
      [['front', 'hem', 'armhole'], ['~back', 'hem', 'armhole']],
      [['front', 'shoulder', 'neck'], ['~back', 'shoulder', 'neck']],
      [['sleeve', 'hemRight', 'bicepsRight'], ['sleeve', 'hemLeft', 'bicepsLeft']],
      [
        ['sleeve', 'bicepsRight', 'capQ2', 'bicepsLeft'],
        ['back', 'armhole', 'shoulder'],
        ['~front', 'shoulder', 'armhole'],
      ],
    ],
  },
  titan: {
    package: 'titan',
    name: 'Titan',
    pieces: { front: { part: 'titan.front', pair: 'right' }, back: { part: 'titan.back', pair: 'right' } },
    seams: [
      [['front', 'styleWaistOut', 'floorOut'], ['back', 'styleWaistOut', 'floorOut']],
      [['front', 'floorIn', 'fork'], ['back', 'floorIn', 'fork']],
      [['front', 'fork', 'crotchSeamCurveStart', 'styleWaistIn'], ['~front', 'styleWaistIn', 'crotchSeamCurveStart', 'fork']],
      [['back', 'fork', 'crossSeamCurveStart', 'styleWaistIn'], ['~back', 'styleWaistIn', 'crossSeamCurveStart', 'fork']],
    ],
    waist: [['front', 'styleWaistIn', 'styleWaistOut'], ['back', 'styleWaistIn', 'styleWaistOut']],
  },
}

function fail(message) {
  console.error(message)
  process.exit(2)
}

/// The outline of a part: corners with their names, and the curve to each next one. y points up.
function outlineOf(part) {
  const names = (p) => Object.keys(part.points).filter((n) => Math.hypot(part.points[n].x - p.x, part.points[n].y - p.y) < 0.01)
  const at = (p) => [p.x / 10, -p.y / 10]
  const corners = []
  for (const op of part.paths.seam.ops) {
    if (op.type === 'close') continue
    const curve = op.type === 'curve' ? [at(op.cp1), at(op.cp2)] : null
    const last = corners.at(-1)
    // A line without length, as where two of the design's points coincide.
    if (last && Math.hypot(at(op.to)[0] - last.at[0], at(op.to)[1] - last.at[1]) < 1e-3) {
      last.names.push(...names(op.to))
      continue
    }
    corners.push({ at: at(op.to), names: names(op.to), curve })
  }
  const first = corners[0]
  const last = corners.at(-1)
  if (Math.hypot(first.at[0] - last.at[0], first.at[1] - last.at[1]) < 1e-3) {
    first.curve = last.curve
    first.names.push(...last.names)
    corners.pop()
  }
  // corner.curve leads from the corner before; turned into edges, counter-clockwise.
  let edges = corners.map((c, i) => {
    const next = corners[(i + 1) % corners.length]
    return { from: c, to: next, curve: next.curve }
  })
  const area = corners.reduce((sum, c, i) => {
    const n = corners[(i + 1) % corners.length]
    return sum + c.at[0] * n.at[1] - n.at[0] * c.at[1]
  }, 0)
  if (area < 0)
    edges = edges.reverse().map((e) => ({ from: e.to, to: e.from, curve: e.curve && [...e.curve].reverse() }))
  return edges
}

/// The edges between named corners, in the order of the loop.
function edgesBetween(edges, names, where) {
  const n = edges.length
  const corner = (name) => {
    const i = edges.findIndex((e) => e.from.names.includes(name))
    if (i < 0) fail(`${where}: the outline has no point ${name}; it has ${edges.map((e) => e.from.names[0] ?? '(none)').join(', ')}`)
    return i
  }
  const runs = []
  for (let k = 1; k < names.length; ++k) {
    const a = corner(names[k - 1])
    const b = corner(names[k])
    const ahead = (b - a + n) % n
    const [start, count] = ahead <= n - ahead ? [a, ahead] : [b, n - ahead]
    const run = Array.from({ length: count }, (_, i) => (start + i) % n)
    if (start === a) runs.push(...run)
    else runs.unshift(...run)
  }
  return runs
}

const [design, body, out, ...options] = process.argv.slice(2)
if (!designs[design] || !body || !out)
  fail(`draft.mjs DESIGN BODY OUT.json [OPTIONS OF selvedge]; DESIGN: ${Object.keys(designs).join(', ')}`)
const { package: source, name, pieces, seams, waist = [] } = designs[design]

mkdirSync(dirname(out), { recursive: true })
const measures = out.replace(/\.json$/, '') + '.measures.json'
execFileSync(process.env.SELVEDGE ?? 'selvedge', ['arrange', body, '--measures', measures, ...options], { stdio: ['ignore', 'ignore', 'inherit'] })
const Design = (await import(`@freesewing/${source}`))[name]
const pattern = new Design({ measurements: JSON.parse(readFileSync(measures)), sa: 0 })
pattern.draft()
const missing = pattern.getConfig().measurements.filter((m) => !(m in JSON.parse(readFileSync(measures))))
if (missing.length) fail(`${design}: needs the measures ${missing.join(', ')}, which selvedge does not take`)

const outlines = {}
const panels = {}
for (const [piece, { part, fold, pair }] of Object.entries(pieces)) {
  const edges = (outlines[piece] = outlineOf(pattern.parts[0][part]))
  const panel = { vertices: edges.map((e) => e.from.at), edges: [] }
  edges.forEach((e, i) => {
    const edge = { endpoints: [i, (i + 1) % edges.length] }
    if (e.curve) edge.curvature = { type: 'cubic', params: e.curve }
    panel.edges.push(edge)
  })
  if (fold) {
    // On the fold x is constant.
    const x = (i) => panel.vertices[i % edges.length][0]
    panel.fold = edges.findIndex((e, i) => e.from.names.some((p) => fold.includes(p)) && Math.abs(x(i) - x(i + 1)) < 1e-6)
    if (panel.fold < 0) fail(`${part}: has no fold from ${fold.join(' to ')}`)
  }
  if (pair) panel.pair = pair
  panels[piece] = panel
}
for (const [piece, ...names] of waist)
  for (const e of edgesBetween(outlines[piece], names, piece)) panels[piece].edges[e].label = 'waist'
const stitches = seams.map(([first, ...others]) => {
  const side = ([piece, ...names]) => {
    const panel = piece.replace('~', '')
    const link = { panel, edges: edgesBetween(outlines[panel], names, panel) }
    if (piece.startsWith('~')) link.mirror = true
    return link
  }
  return [side(first), others.length === 1 ? side(others[0]) : others.map(side)]
})
const text = {
  pattern: { panels, stitches },
  properties: { curvature_coords: 'absolute', normalize_panel_translation: false, units_in_meter: 100 },
}
writeFileSync(out, JSON.stringify(text, null, 1) + '\n')
console.log(`${out}: ${Object.keys(panels).length} pieces, ${stitches.length} seams; measures in ${measures}`)
