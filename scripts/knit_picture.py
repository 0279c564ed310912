#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Draws the loops of data/scenes/knit.json at its start, from the front, into docs/images/knit.png.

    scripts/knit_picture.py    (needs NumPy; SELVEDGE names the program, by default build/release/apps/selvedge)

Loops of five wales in five courses, every other course in another colour.
"""
import json
import os
import pathlib
import struct
import subprocess
import tempfile
import zlib

import numpy as np

ROOT = pathlib.Path(__file__).parent.parent
SCENE = ROOT / "data/scenes/knit.json"
PIXELS_PER_M = 60000
DENSITY = 909.0  # kg/m³ of the yarn, the default


def particles(folder):
    """Positions in the state after one frame, in which the swatch still falls without touching anything."""
    program = os.environ.get("SELVEDGE", ROOT / "build/release/apps/selvedge")
    subprocess.run([program, "run", SCENE, "--out", folder, "--no-pictures", "--set", "time.frames=1"], check=True,
                   capture_output=True)
    data = (pathlib.Path(folder) / "checkpoint.ply").read_bytes()
    begin = data.index(b"end_header\n") + len("end_header\n")
    count = next(int(line.split()[2]) for line in data[:begin].decode().splitlines() if line.startswith("element vertex"))
    return np.frombuffer(data, "<f8", 6 * count, begin).reshape(count, 6)[:, :3]


def courses(x, cloth):
    """The axes of the yarn in the middle of the swatch, finely divided."""
    wales, rows = (n + 1 for n in cloth["cells"])
    loop = 8 * cloth["pattern"]["links"]
    yarn = x[wales * rows:].reshape(rows, loop * wales + 1, 3)
    for y in yarn[rows // 2 - 2:rows // 2 + 3, loop * (wales // 2 - 2):loop * (wales // 2 + 3) + 1]:
        place = np.linspace(0, len(y) - 1, 30 * (len(y) - 1))
        yield np.stack([np.interp(place, np.arange(len(y)), y[:, k]) for k in range(3)], axis=1)


def draw(axes, diameter):
    """Spheres along the axes, the nearer ones before the others."""
    points = np.concatenate(axes)
    low, high = points.min(axis=0) - diameter, points.max(axis=0) + diameter
    width, height = (int((high[k] - low[k]) * PIXELS_PER_M) for k in (0, 1))
    image, depth = np.full((height, width, 3), 255, np.uint8), np.full((height, width), -np.inf)
    radius = int(0.5 * diameter * PIXELS_PER_M)
    dy, dx = np.mgrid[-radius:radius + 1, -radius:radius + 1]
    inside = dx**2 + dy**2 <= radius**2
    rise = np.sqrt(1.0 - (dx**2 + dy**2)[inside] / radius**2)
    for number, axis in enumerate(axes):
        colour = np.array([200, 70, 60] if number % 2 else [70, 110, 190])
        for p in axis:
            column = int((p[0] - low[0]) * PIXELS_PER_M) + dx[inside]
            row = height - 1 - int((p[1] - low[1]) * PIXELS_PER_M) + dy[inside]
            z = p[2] + 0.5 * diameter * rise
            nearer = z > depth[row, column]
            depth[row[nearer], column[nearer]] = z[nearer]
            image[row[nearer], column[nearer]] = ((0.35 + 0.65 * rise[nearer])[:, None] * colour).astype(np.uint8)
    return image


def write_png(file, image):
    chunk = lambda kind, data: (struct.pack(">I", len(data)) + kind + data
                                + struct.pack(">I", zlib.crc32(kind + data)))
    lines = b"".join(b"\0" + row.tobytes() for row in image)
    header = struct.pack(">IIBBBBB", image.shape[1], image.shape[0], 8, 2, 0, 0, 0)
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines, 9))
                     + chunk(b"IEND", b""))


def main():
    cloth = json.loads(SCENE.read_text())["geometry"][0]
    diameter = np.sqrt(4e-6 * cloth["pattern"]["tex"] / (np.pi * DENSITY))
    with tempfile.TemporaryDirectory() as folder:
        axes = list(courses(particles(pathlib.Path(folder) / "out"), cloth))
    write_png(ROOT / "docs/images/knit.png", draw(axes, diameter))


if __name__ == "__main__":
    main()
