#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Reads the files of a run back with three.js and compares them with its PLY frames.

    npm install three                                   # in any folder
    python3 tests/run/check_in_three.py build/release/apps/selvedge FOLDER/node_modules/three

Names, positions, normals, texture coordinates, colours, flags and pressure of each piece and body of a small run.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
TOLERANCE = 1e-7  # m
FRAMES = 12
CELLS = 9, 6
SCENE = {
    "name": "exchange",
    "geometry": [
        {"name": name, "size": [0.4, 0.3], "cells": list(CELLS), "transformation": {"translation": [0.01, 0.02, z]}}
        for name, z in (("lower", 0.211), ("upper", 0.222))
    ],
    "obstacles": [
        {"name": "ball", "shape": {"type": "sphere", "radius": 0.2, "resolution": 24}},
        {"name": "box", "shape": {"type": "box", "size": [0.1, 0.1, 0.1]}, "transformation": {"translation": [0.6, 0, 0]}},
    ],
    "time": {"frames": FRAMES},
    "output": {"formats": [{"type": "ply", "pressure": True}, "gltf", "obj", "usd"]},
}


def read_ply(file):
    head, body = file.read_bytes().split(b"end_header\n", 1)
    fields, counts = [], []
    for line in head.decode().splitlines():
        words = line.split()
        if words[0] == "element":
            counts.append(int(words[2]))
        elif words[0] == "property" and len(counts) == 1:
            fields.append((words[2], {"double": "<f8", "uchar": "u1"}[words[1]]))
    table = np.frombuffer(body, dtype=np.dtype(fields), count=counts[0])
    faces = np.frombuffer(body, dtype=[("n", "u1"), ("v", "<i4", 3)], count=counts[1], offset=table.nbytes)["v"]
    return table, np.stack([table["x"], table["y"], table["z"]], 1), faces


def smooth(x, faces):
    """Normals of the vertices: means by area."""
    area = np.cross(x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]])
    sums = np.zeros_like(x)
    for k in range(3):
        np.add.at(sums, faces[:, k], area)
    return sums / np.linalg.norm(sums, axis=1, keepdims=True)


def upright(x):
    """three.js has y up."""
    x = np.array(x).reshape(-1, 3)
    return np.stack([x[:, 0], -x[:, 2], x[:, 1]], 1)


def off(a, b):
    assert a.shape == b.shape, (a.shape, b.shape)
    return float(np.abs(a - b).max())


def check_gltf(meshes, result):
    by_name = {m["name"]: m for m in meshes}
    assert list(by_name) == ["lower", "upper", "ball", "box"], list(by_name)
    own = (CELLS[0] + 1) * (CELLS[1] + 1)
    frames = [read_ply(result / "frames" / f"cloth_{k:05d}.ply") for k in range(FRAMES + 1)]
    worst = turned = 0.0
    for piece, name in enumerate(("lower", "upper")):
        mesh, part = by_name[name], slice(piece * own, (piece + 1) * own)
        assert mesh["targets"] == FRAMES
        for k in (0, 5, FRAMES):
            _, x, faces = frames[k]
            worst = max(worst, off(upright(mesh["frames"][(0, 5, FRAMES).index(k)]["x"]), x[part]))
            turned = max(turned, off(upright(mesh["frames"][(0, 5, FRAMES).index(k)]["n"]), smooth(x, faces)[part]))
        flat = frames[0][1][part, :2]
        uv = (flat - flat.min(0)) / np.ptp(flat, axis=0).max()
        found = np.array(mesh["uv"]).reshape(-1, 2)
        assert off(np.stack([found[:, 0], 1 - found[:, 1]], 1), uv) < 1e-6
        assert off(np.array(mesh["flag"], float), np.bitwise_or.reduce([f[0]["flag"][part] for f in frames]).astype(float)) == 0
        assert off(np.array(mesh["pressure"]), frames[-1][0]["pressure"][part].astype("f4").astype(float)) == 0
    assert by_name["lower"]["colour"] != by_name["upper"]["colour"]
    _, body, faces = read_ply(result / "frames" / "bodies_00000.ply")
    ball, box = (by_name[n]["frames"][0] for n in ("ball", "box"))
    balls = len(ball["x"]) // 3
    worst = max(worst, off(upright(ball["x"]), body[:balls]))
    assert off(upright(ball["n"]), smooth(body, faces)[:balls]) < 1e-6, "the ball is smooth"
    sides = np.abs(upright(box["n"]))
    assert off(np.sort(sides, axis=1), np.tile([0, 0, 1.0], (len(sides), 1))) < 1e-6, "the box has sharp edges"
    assert by_name["ball"]["targets"] == 0, "a body at rest has no morph targets"
    return worst, turned


def check_obj(meshes, result, stem, number, names):
    assert [m["name"] for m in meshes] == names, [m["name"] for m in meshes]
    _, x, faces = read_ply(result / "frames" / f"{stem}_{number:05d}.ply")
    corners = np.concatenate([np.array(m["frames"][0]["x"]).reshape(-1, 3) for m in meshes])
    return off(corners, x[faces].reshape(-1, 3).astype("f4").astype(float))


def main():
    program, three = (str(Path(name).resolve()) for name in sys.argv[1:])
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        (work / "scene.json").write_text(json.dumps(SCENE))
        subprocess.run([program, "run", "scene.json", "--out", "result", "--no-pictures"], cwd=work, check=True, stdout=subprocess.DEVNULL)
        result = work / "result"

        def read(file, *frames):
            call = ["node", str(HERE / "read_in_three.mjs"), three, str(file), *map(str, frames)]
            return json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout)

        worst, turned = check_gltf(read(result / "result.glb", 0, 5, FRAMES), result)
        print(f"glTF: positions to {worst:.2g} m, normals to {turned:.2g}")
        assert worst <= TOLERANCE and turned < 1e-6
        for stem, number, names in (("cloth", FRAMES, ["lower", "upper"]), ("bodies", 0, ["ball", "box"])):
            worst = check_obj(read(result / "frames" / f"{stem}_{number:05d}.obj", 0), result, stem, number, names)
            print(f"OBJ, {stem}: positions to {worst:.2g} m")
            assert worst <= TOLERANCE
    print("three.js reads pieces, coordinates and normals")


main()
