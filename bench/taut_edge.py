#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""taut_edge.py SCENE: whether a box catches the upper edge of a sheet that is held by its upper corners.

    scripts/hits.py --first 2030 --out out/hits 1
    bench/taut_edge.py out/hits/2030/scene_in.json

Runs a hit of scripts/hits.py and takes the upper edge of every state. A string without friction that starts where the
edge lies, ends at its corners and stays out of the box is pulled taut. Cloth cannot come back to its strain limit
without passing through the box as long as this string is longer than the limit allows. Prints, for some states, by how
much the edge and the string are longer than the edge at rest. Needs numpy.
"""
import argparse
import json
import math
import pathlib
import subprocess
import tempfile

import numpy as np

PARTS = 150  # of the string; shorter than a plate is thick
ROUNDS = 5000  # of smoothing
KEPT = 0.0015  # m, distance of the string from the box


TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4", "uint": "<u4"}


def vertices_of(path):
    """Of a binary PLY file (n, 3), m."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    words = [line.split() for line in head.decode().split("element face")[0].splitlines()]
    count = next(int(w[2]) for w in words if w[:2] == ["element", "vertex"])
    fields = [(w[2], TYPES[w[1]]) for w in words if w[0] == "property"]
    vertices = np.frombuffer(body, np.dtype(fields), count)
    return np.stack([vertices[k].astype(float) for k in "xyz"], axis=1)


def turn(axis, degrees):
    """Rotation matrix (3, 3)."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    k, a = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), math.radians(degrees)
    return np.eye(3) + math.sin(a) * k + (1 - math.cos(a)) * k @ k


def length(p):
    return np.linalg.norm(np.diff(p, axis=0), axis=1).sum()


def subdivided(p):
    """The polyline p (n, 3) in PARTS parts."""
    t = np.linspace(0, len(p) - 1, PARTS + 1)
    return np.stack([np.interp(t, range(len(p)), p[:, k]) for k in range(3)], axis=1)


def pulled_taut(p, centre, axes, half):
    """The string from p (n, 3) beside the box: each point goes between its neighbours, but not through the face before
    which it was."""
    own = (p - centre) @ axes
    ends = own[[0, -1]].copy()
    for _ in range(ROUNDS):
        before = own.copy()
        own[1:-1] = 0.5 * (own[:-2] + own[2:])
        inside = np.flatnonzero((np.abs(own) < half).all(axis=1))
        face = (np.abs(before[inside]) - half).argmax(axis=1)
        own[inside, face] = np.where(before[inside, face] < 0, -half[face], half[face])
        own[[0, -1]] = ends
    return own


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("scene")
    options.add_argument("--program", default="build/release/apps/selvedge")
    options.add_argument("--every", type=int, default=5, help="prints one of so many states above the limit")
    o = options.parse_args()
    scene = json.loads(pathlib.Path(o.scene).read_text())
    cells, size = scene["geometry"][0]["cells"], scene["geometry"][0]["size"][0]
    upper = range(cells[1] * (cells[0] + 1), (cells[1] + 1) * (cells[0] + 1))
    box = scene["obstacles"][0]
    rotation = box["transformation"].get("rotation", {"axis": [0, 0, 1], "angle_deg": 0})
    axes, half = turn(rotation["axis"], rotation["angle_deg"]), 0.5 * np.array(box["shape"]["size"]) + KEPT
    print("state  edge %  string %")
    with tempfile.TemporaryDirectory() as out:
        run = [o.program, "run", o.scene, "--out", out, "--overwrite", "--every-step", "--no-pictures"]
        subprocess.run(run, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        states = sorted(f for f in pathlib.Path(out, "steps").glob("*.ply") if not f.name.startswith("bodies"))
        bodies = sorted(pathlib.Path(out, "steps").glob("bodies*.ply"))
        far = 0
        for k, (state, body) in enumerate(zip(states, bodies)):
            edge = vertices_of(state)[upper]
            if length(edge) < 1.1 * size:
                continue
            far += 1
            if far % o.every == 1 or o.every == 1:
                own = vertices_of(body) @ axes
                centre = axes @ (0.5 * (own.min(axis=0) + own.max(axis=0)))
                taut = pulled_taut(subdivided(edge), centre, axes, half)
                print(f"{k:5d}  {100 * (length(edge) / size - 1):6.1f}  {100 * (length(taut) / size - 1):8.1f}", flush=True)


if __name__ == "__main__":
    main()
