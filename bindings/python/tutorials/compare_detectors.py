# SPDX-License-Identifier: MIT
"""Compares all detectors of this build on two meshes and plots their times.

    python3 compare_detectors.py [--cloth MESH.obj] [--body MESH.obj] [--cells 60] [--out FOLDER]

Without meshes of your own: a square of cloth that falls onto a ball. Prints for each detector the number of
candidate pairs, the collisions that they lead to, and the time of a call; writes detectors.svg.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import selvedge


def read_obj(file):
    """Vertices and triangles of an OBJ file; polygons become fans of triangles."""
    vertices, triangles = [], []
    for line in Path(file).read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) for word in words[1:]]
            corners = [c - 1 if c > 0 else len(vertices) + c for c in corners]
            triangles += [[corners[0], a, b] for a, b in zip(corners[1:], corners[2:])]
    return np.array(vertices), np.array(triangles, dtype=np.int32)


def cloth_over_ball(cells):
    """A step of a cloth that reaches the ball: (x0, x1, triangles) and (vertices, triangles)."""
    simulation = selvedge.Simulation(
        {
            "geometry": [
                {
                    "size": [1, 1],
                    "cells": [cells, cells],
                    "transformation": {"translation": [0.01, 0.02, 0.31]},
                }
            ],
            "obstacles": [{"shape": {"type": "sphere", "radius": 0.3, "resolution": 4 * cells // 3 + 3}}],
        }
    )
    simulation.advance_to_frame(6)
    x0 = simulation.positions.copy()
    x1 = x0 - [0, 0, 0.03]  # a fast fall without contacts: the cloth passes into the ball
    body = simulation.body_positions.copy(), simulation.body_triangles.copy()
    return (x0, x1, simulation.triangles.copy()), body


def measure(name, cloth, body, repeats):
    """Candidate pairs, collisions, and the shortest time of a call in milliseconds."""
    detector = selvedge.Detector(name)
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        candidates = detector.find_candidates(*cloth, body)
        times.append(1e3 * (time.perf_counter() - begin))
    return len(candidates), len(detector.find_collisions(*cloth, body)), min(times)


def plot(file, rows):
    """Bars of the times, on a logarithmic scale, as SVG."""
    times = np.array([row[3] for row in rows])
    low = 10.0 ** np.floor(np.log10(times.min()))
    decades = max(1.0, np.log10(times.max() / low))
    left, width, step = 190, 420, 26
    height = step * len(rows) + 60
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {left + width + 90} {height}" '
        'font-family="sans-serif" font-size="14">',
        f'<rect width="100%" height="100%" fill="white"/><text x="{left}" y="22">'
        "milliseconds of a search, on a logarithmic scale</text>",
    ]
    for k, (name, pairs, found, ms) in enumerate(rows):
        y = 36 + step * k
        length = 4 + (width - 4) * np.log10(ms / low) / decades
        parts.append(
            f'<text x="{left - 8}" y="{y + 14}" text-anchor="end">{name}</text>'
            f'<rect x="{left}" y="{y}" width="{length:.1f}" height="18" fill="#34658c"/>'
            f'<text x="{left + length + 6:.1f}" y="{y + 14}">{ms:.2f}</text>'
        )
    parts.append(f'<text x="{left}" y="{height - 8}">shorter bars are faster</text></svg>\n')
    Path(file).write_text("\n".join(parts))


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cloth", help="OBJ file; moves down by --drop")
    parser.add_argument("--body", help="OBJ file")
    parser.add_argument("--drop", type=float, default=0.01, help="metres, with --cloth")
    parser.add_argument("--cells", type=int, default=60, help="of the cloth on a side")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--out", default=".")
    options = parser.parse_args(arguments)
    Path(options.out).mkdir(parents=True, exist_ok=True)
    if (options.cloth is None) != (options.body is None):
        parser.error("give both --cloth and --body, or neither")
    if options.cloth:
        x, triangles = read_obj(options.cloth)
        cloth, body = (x, x - [0, 0, options.drop], triangles), read_obj(options.body)
    else:
        cloth, body = cloth_over_ball(options.cells)
    exact = len(selvedge.find_collisions(*cloth, body))
    rows = []
    for method in selvedge.list_methods():
        pairs = method["family"] == "broad_phase" and method["available"]
        if pairs and "without pairs" not in method["promise"]:
            rows.append((method["name"], *measure(method["name"], cloth, body, options.repeats)))
    rows.sort(key=lambda row: row[3])
    print(f"{len(cloth[2])} triangles against {len(body[1])}: {exact} collisions")
    print(f"{'detector':24}{'candidates':>12}{'collisions':>12}{'ms':>10}")
    for name, pairs, found, ms in rows:
        print(f"{name:24}{pairs:12}{found:12}{ms:10.2f}")
    plot(Path(options.out) / "detectors.svg", rows)
    return exact, rows


if __name__ == "__main__":
    main()
