# SPDX-License-Identifier: MIT
"""Detection by brute force in NumPy, in floating point: slow, simple, and independent of the library.

Each function also returns what it cannot decide because rounding might decide it.
"""

import itertools

import numpy as np


def edges_of(triangles):
    pairs = {tuple(sorted((int(t[i]), int(t[(i + 1) % 3])))) for t in triangles for i in range(3)}
    return np.array(sorted(pairs), dtype=np.int32).reshape(-1, 2)


def point_segment(p, a, b):
    d = b - a
    s = np.clip(np.dot(p - a, d) / max(np.dot(d, d), 1e-300), 0.0, 1.0)
    return np.linalg.norm(p - a - s * d)


def point_triangle(p, a, b, c):
    n = np.cross(b - a, c - a)
    area = np.dot(n, n)
    if area > 0.0:
        u = np.dot(np.cross(c - b, p - b), n) / area
        v = np.dot(np.cross(a - c, p - c), n) / area
        if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
            return abs(np.dot(p - a, n)) / np.sqrt(area)
    return min(point_segment(p, a, b), point_segment(p, b, c), point_segment(p, c, a))


def edge_edge(a0, a1, b0, b1):
    best = min(
        point_segment(a0, b0, b1),
        point_segment(a1, b0, b1),
        point_segment(b0, a0, a1),
        point_segment(b1, a0, a1),
    )
    d, e, r = a1 - a0, b1 - b0, a0 - b0
    n = np.cross(d, e)
    square = np.dot(n, n)
    if square > 1e-24:
        s = np.dot(np.cross(e, r), n) / square
        t = np.dot(np.cross(d, r), n) / square
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            best = min(best, abs(np.dot(r, n)) / np.sqrt(square))
    return best


DISTANCE = {True: edge_edge, False: point_triangle}
TIMES = np.array([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0])
TO_CUBIC = np.linalg.inv(np.vander(TIMES, 4))


def impact(start, end, edges):
    """First time of impact of one query of four points, inf for none, nan if rounding decides."""

    def at(t):
        return (1.0 - t) * start + t * end

    def volume(t):
        x = at(t)
        return np.dot(x[1] - x[0], np.cross(x[2] - x[0], x[3] - x[0]))

    cubic = TO_CUBIC @ np.array([volume(t) for t in TIMES])
    unsure = False
    for root in sorted(np.roots(cubic), key=lambda z: z.real):
        if abs(root.imag) > 1e-5 or not -1e-6 < root.real < 1.0 + 1e-6:
            continue
        distance = DISTANCE[edges](*at(root.real))
        inside = 0.0 <= root.real <= 1.0 and abs(root.imag) < 1e-12
        if distance < 1e-9 and inside:
            return np.nan if unsure else root.real
        if distance < 1e-4:
            unsure = True
    return np.nan if unsure else np.inf


def collisions(x0, x1, triangles, body=None):
    """{(kind, a, b): toi} of the pairs that collide, and the set of those that rounding decides."""
    y0, y1, body_triangles = (x0, x1, triangles) if body is None else body
    edges_a, edges_b = edges_of(triangles), edges_of(body_triangles)
    found, unsure = {}, set()

    def decide(key, four0, four1, edges):
        toi = impact(four0, four1, edges)
        if np.isnan(toi):
            unsure.add(key)
        elif np.isfinite(toi):
            found[key] = toi

    used_a, used_b = np.unique(triangles), np.unique(body_triangles)
    for p, (k, t) in itertools.product(used_a, enumerate(body_triangles)):
        if body is None and p in t:
            continue
        decide(
            (0, int(p), k), np.vstack([x0[p], y0[t]]), np.vstack([x1[p], y1[t]]), False
        )
    if body is not None:
        for p, (k, t) in itertools.product(used_b, enumerate(triangles)):
            decide(
                (1, k, int(p)), np.vstack([y0[p], x0[t]]), np.vstack([y1[p], x1[t]]), False
            )
    for (i, e), (j, f) in itertools.product(enumerate(edges_a), enumerate(edges_b)):
        if body is None and (i >= j or set(e) & set(f)):
            continue
        decide((2, i, j), np.vstack([x0[e], y0[f]]), np.vstack([x1[e], y1[f]]), True)
    return found, unsure


def proximities(x, triangles, distance, body=None):
    """{(kind, a, b): gap} of the pairs nearer than `distance`."""
    y, body_triangles = (x, triangles) if body is None else body
    edges_a, edges_b = edges_of(triangles), edges_of(body_triangles)
    found = {}

    def note(key, gap):
        if gap < distance:
            found[key] = gap

    for p, (k, t) in itertools.product(np.unique(triangles), enumerate(body_triangles)):
        if body is not None or p not in t:
            note((0, int(p), k), point_triangle(x[p], *y[t]))
    if body is not None:
        for p, (k, t) in itertools.product(np.unique(body_triangles), enumerate(triangles)):
            note((1, k, int(p)), point_triangle(y[p], *x[t]))
    for (i, e), (j, f) in itertools.product(enumerate(edges_a), enumerate(edges_b)):
        if body is not None or (i < j and not set(e) & set(f)):
            note((2, i, j), edge_edge(*x[e], *y[f]))
    return found


def crossings(x, triangles, body=None):
    """Pairs of triangles of which an edge of one passes through the other."""
    y, body_triangles = (x, triangles) if body is None else body

    def passes(a, b, tri):
        n = np.cross(tri[1] - tri[0], tri[2] - tri[0])
        da, db = np.dot(a - tri[0], n), np.dot(b - tri[0], n)
        if da * db > 0.0 or da == db:
            return False
        p = a + da / (da - db) * (b - a)
        sides = [np.dot(np.cross(tri[(i + 1) % 3] - tri[i], p - tri[i]), n) for i in range(3)]
        return min(sides) >= 0.0

    def cross(s, t):
        return any(
            passes(one[i], one[(i + 1) % 3], other)
            for one, other in ((s, t), (t, s))
            for i in range(3)
        )

    return {
        (i, j)
        for (i, s), (j, t) in itertools.product(enumerate(triangles), enumerate(body_triangles))
        if (body is not None or (i < j and not set(s) & set(t))) and cross(x[s], y[t])
    }
