#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""How much of the search for self-collisions a proof by charts could leave out (docs/lab/plan.md).

    bench/proof_share.py RESULT FRAME... [--gap METRES] [--steps N] [--leaf N]

RESULT is a folder of `selvedge run`; its cloth is one piece. The step begins at each FRAME and ends 1/N of the way to the next
one. A chart is the projection of the start along the mean normal of some triangles. Two primitives in a chart without a
common vertex are proved to keep 1.5 rest gaps apart as in simulation/contacts/detail/idle_proofs.h, except that the triangles need not
be convex: the shares are bounds from above. Columns:

candidates    pairs whose boxes overlap, inflated by the rest gap
near          of them, pairs in one chart of the triangles around a vertex and its neighbours that is proved
leaf pairs    pairs of leaves of a tree of boxes that overlap, of at most --leaf triangles
left out      of them, pairs whose chart (both leaves and the triangles around) is proved
whole         share of the charts of adjacent leaves that are proved; at 100 % no search would be needed, if the other leaves
              keep apart
halves        two charts, front and back, each of all triangles that face its direction at the start, so that they overlap along
              the sides; the directions lean upwards by 0 to 75 degrees. The most triangles that both charts of one pair of directions
              cover, %, and how many of the 48 pairs cover all and are proved
"""
import argparse
import pathlib

import numpy as np

TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4", "uint": "<u4"}


def read_ply(path):
    """Vertices and triangles of a binary PLY file."""
    data = path.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    counts, fields, element = {}, [], ""
    for words in (line.split() for line in head.decode().splitlines()):
        if words[0] == "element":
            element = words[1]
            counts[element] = int(words[2])
        elif words[0] == "property" and element == "vertex":
            fields.append((words[2], TYPES[words[1]]))
    vertices = np.frombuffer(body, np.dtype(fields), counts["vertex"])
    faces = np.frombuffer(body[vertices.nbytes:], np.dtype([("n", "u1"), ("v", "<i4", 3)]), counts["face"])
    return np.stack([vertices[k].astype(float) for k in "xyz"], 1), faces["v"].astype(int)


def box_pairs(low_a, high_a, low_b, high_b):
    """Index pairs of boxes that overlap."""
    order = np.argsort(low_b[:, 0])
    first, widest = low_b[order, 0], (high_b[:, 0] - low_b[:, 0]).max()
    for i in range(len(low_a)):
        near = order[np.searchsorted(first, low_a[i, 0] - widest):np.searchsorted(first, high_a[i, 0], "right")]
        for j in near[((low_b[near] <= high_a[i]) & (high_b[near] >= low_a[i])).all(1)]:
            yield i, j


class Surface:
    """A surface at its start, divided into leaves."""

    def __init__(self, x, triangles, leaf):
        self.x, self.triangles = x, triangles
        self.edges = np.unique(np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), 1), axis=0)
        self.normals = np.cross(x[triangles[:, 1]] - x[triangles[:, 0]], x[triangles[:, 2]] - x[triangles[:, 0]])
        self.of_vertex = [[] for _ in x]
        for i, t in enumerate(triangles):
            for v in t:
                self.of_vertex[v].append(i)
        self.leaves = []
        self.divide(np.arange(len(triangles)), leaf)
        self.leaf_of = np.empty(len(triangles), int)
        for number, leaf_triangles in enumerate(self.leaves):
            self.leaf_of[leaf_triangles] = number

    def divide(self, some, leaf):
        if len(some) <= leaf:
            self.leaves.append(some)
            return
        centroids = self.x[self.triangles[some]].mean(1)
        order = some[np.argsort(centroids[:, np.argmax(np.ptp(centroids, axis=0))], kind="stable")]
        self.divide(order[:len(some) // 2], leaf)
        self.divide(order[len(some) // 2:], leaf)

    def around(self, some):
        return {j for i in some for v in self.triangles[i] for j in self.of_vertex[v]}

    def adjacent_leaves(self):
        return sorted({(min(a, b), max(a, b)) for a, leaf in enumerate(self.leaves)
                       for b in {self.leaf_of[j] for j in self.around(leaf)}})


class Chart:
    """Triangles projected along their mean normal at the start."""

    def __init__(self, surface, some):
        some = np.array(sorted(some))
        self.corners = surface.triangles[some]
        normal = surface.normals[some].sum(0)
        u = np.cross(normal, np.eye(3)[np.argmin(abs(normal))])
        v = np.cross(normal, u)
        flat = surface.x[self.corners] @ np.stack([u / np.linalg.norm(u), v / np.linalg.norm(v)], 1)
        edges = np.stack([flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]], 2)
        twice = np.linalg.det(edges)
        self.valid = bool((twice > 0).all())
        if not self.valid:
            return
        self.inverse = np.linalg.inv(edges)
        self.nearest = min((twice / np.linalg.norm(flat[:, k] - flat[:, k - 1], axis=1)).min() for k in range(3))

    def gradients(self, x):
        a, b, c = (x[self.corners[:, k]] for k in range(3))
        return np.stack([b - a, c - a], 2) @ self.inverse

    def is_proved(self, start, end, distance):
        if not self.valid:
            return False
        both = [self.gradients(start), self.gradients(end)]
        u, _, v = np.linalg.svd((both[0] + both[1]).sum(0), full_matrices=False)
        frame, least = u @ v, np.inf
        for gradient in both:
            m = frame.T @ gradient
            least = min(least, np.linalg.eigvalsh((m + m.transpose(0, 2, 1)) / 2)[:, 0].min())
        change = np.sqrt(((both[1] - both[0]) ** 2).sum((1, 2)).max())
        return (least - change) * self.nearest > distance


class Halves:
    """A chart of the front and one of the back, for directions all around and leaning upwards."""

    def __init__(self, surface):
        unit = surface.normals / np.linalg.norm(surface.normals, axis=1, keepdims=True)
        unit *= 1.0 if (unit * (surface.x[surface.triangles].mean(1) - surface.x.mean(0))).sum() > 0.0 else -1.0  # outwards
        self.covered, self.charts = 0.0, []
        for lean in np.radians(np.arange(0, 90, 15)):
            for turn in np.radians(np.arange(0, 180, 22.5)):
                level = np.array([np.cos(turn), np.sin(turn), 0.0])
                faces = [unit @ (side * np.cos(lean) * level + np.sin(lean) * np.array([0.0, 0.0, 1.0])) > 0.0 for side in (1, -1)]
                share = (faces[0] | faces[1]).mean()
                self.covered = max(self.covered, share)
                if share == 1.0:
                    self.charts.append([Chart(surface, np.flatnonzero(f)) for f in faces])

    def proved(self, start, end, distance):
        return sum(all(chart.is_proved(start, end, distance) for chart in pair) for pair in self.charts)


def percent(part, whole):
    return 100.0 * part / max(whole, 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("result", type=pathlib.Path)
    parser.add_argument("frames", type=int, nargs="+")
    parser.add_argument("--gap", type=float, default=0.002, help="rest gap (m)")
    parser.add_argument("--steps", type=int, default=2, help="steps per frame")
    parser.add_argument("--leaf", type=int, default=16, help="most triangles of a leaf")
    options = parser.parse_args()

    def frame(number):
        return read_ply(options.result / "frames" / f"cloth_{number:05d}.ply")

    surface = Surface(*frame(0), options.leaf)
    triangles, edges = surface.triangles, surface.edges
    rings = [{v} | {w for t in surface.of_vertex[v] for w in triangles[t]} for v in range(len(surface.x))]
    vertex_charts = [Chart(surface, {t for w in ring for t in surface.of_vertex[w]}) if surface.of_vertex[v] else None
                     for v, ring in enumerate(rings)]
    adjacent = surface.adjacent_leaves()
    leaf_charts = [Chart(surface, surface.around(set(surface.leaves[a]) | set(surface.leaves[b]))) for a, b in adjacent]
    halves = Halves(surface)
    print("frame  candidates  near %  leaf pairs  left out %  whole %  halves %  proved")
    for number in options.frames:
        start = frame(number)[0]
        end = start + (frame(number + 1)[0] - start) / options.steps
        proved_vertex = [c is not None and c.is_proved(start, end, 1.5 * options.gap) for c in vertex_charts]
        proved_leaves = {pair for pair, c in zip(adjacent, leaf_charts) if c.is_proved(start, end, 1.5 * options.gap)}
        drifting = end - (end - start).mean(0)
        low, high = np.minimum(start, drifting) - options.gap, np.maximum(start, drifting) + options.gap
        of_edges = low[edges].min(1), high[edges].max(1)
        of_triangles = low[triangles].min(1), high[triangles].max(1)
        pairs = [((p,), triangles[t]) for p, t in box_pairs(low, high, *of_triangles) if p not in triangles[t]]
        pairs += [(edges[a], edges[b]) for a, b in box_pairs(*of_edges, *of_edges)
                  if a < b and not set(edges[a]) & set(edges[b])]
        near = sum(any(proved_vertex[v] and rings[v].issuperset(a) and rings[v].issuperset(b) for v in (*a, *b))
                   for a, b in pairs)
        of_leaves = (np.array([of_triangles[0][leaf].min(0) for leaf in surface.leaves]),
                     np.array([of_triangles[1][leaf].max(0) for leaf in surface.leaves]))
        visited = [(a, b) for a, b in box_pairs(*of_leaves, *of_leaves) if a <= b]
        print(f"{number:5d} {len(pairs):11d} {percent(near, len(pairs)):7.1f} {len(visited):11d} "
              f"{percent(sum(p in proved_leaves for p in visited), len(visited)):11.1f} "
              f"{percent(len(proved_leaves), len(adjacent)):8.1f} {100 * halves.covered:9.1f} "
              f"{halves.proved(start, end, 1.5 * options.gap):7d}", flush=True)


main()
