# SPDX-License-Identifier: MIT
"""peer_prepare.py FOLDER CELLS FRAMES: writes the bodies, the sheet and the scene of each case of peers.sh."""
import json
import math
import struct
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SIZE = 0.6  # m, of the sheet
DENSITY = 0.15  # kg/m^2
FRICTION = 0.3  # Coulomb's coefficient on the incline and elsewhere
SLOPE = 30.0  # degrees
CLEARANCE = 0.025  # m, between the sheet and the incline at the start: more than any program keeps at rest


def write_obj(file, points, faces):
    with open(file, "w", encoding="ascii") as out:
        for p in points:
            out.write("v %.17g %.17g %.17g\n" % tuple(p))
        for f in faces:
            out.write("f " + " ".join(str(i + 1) for i in f) + "\n")


def ball(radius, centre, around=64):
    rings = around // 2
    points, faces = [(centre[0], centre[1], centre[2] - radius)], []
    for ring in range(1, rings):
        polar = math.pi * ring / rings
        for k in range(around):
            angle = 2 * math.pi * k / around
            points.append((centre[0] + radius * math.sin(polar) * math.cos(angle),
                           centre[1] + radius * math.sin(polar) * math.sin(angle),
                           centre[2] - radius * math.cos(polar)))
    points.append((centre[0], centre[1], centre[2] + radius))
    at = lambda ring, k: 1 + (ring - 1) * around + k % around
    for k in range(around):
        faces.append((0, at(1, k + 1), at(1, k)))
        faces.append((len(points) - 1, at(rings - 1, k), at(rings - 1, k + 1)))
        for ring in range(1, rings - 1):
            a, b, c, d = at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)
            faces += [(a, b, c), (a, c, d)]
    return points, faces


def turned_about_y(p, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return (c * p[0] + s * p[2], p[1], -s * p[0] + c * p[2])


def box(size, degrees, cells=(1, 1, 1)):
    """A closed box, turned about y, with so many squares along each side."""
    points, faces, number = [], [], {}

    def corner(at):
        if at not in number:
            number[at] = len(points)
            points.append(turned_about_y([(at[k] / cells[k] - 0.5) * size[k] for k in range(3)], degrees))
        return number[at]

    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, cells[axis]):
            for i in range(cells[u]):
                for j in range(cells[v]):
                    at = [0, 0, 0]
                    at[axis] = end
                    quad = []
                    for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        at[u], at[v] = i + du, j + dv
                        quad.append(corner(tuple(at)))
                    a, b, c, d = quad if end else quad[::-1]
                    faces += [(a, b, c), (a, c, d)]
    return points, faces


def sheet(cells, degrees, centre):
    points = []
    for j in range(cells + 1):
        for i in range(cells + 1):
            p = turned_about_y(((i / cells - 0.5) * SIZE, (j / cells - 0.5) * SIZE, 0.0), degrees)
            points.append(tuple(p[k] + centre[k] for k in range(3)))
    faces = []
    for j in range(cells):
        for i in range(cells):
            k = j * (cells + 1) + i
            faces += [(k, k + 1, k + cells + 2), (k, k + cells + 2, k + cells + 1)]
    return points, faces


def read_ply(file):
    """A binary little-endian PLY file: double x, y, z and triangles with int indices."""
    head, data = file.read_bytes().split(b"end_header\n", 1)
    counts = {words[1]: int(words[2]) for words in map(str.split, head.decode("ascii").splitlines())
              if words[0] == "element"}
    points = [struct.unpack_from("<3d", data, 24 * i) for i in range(counts["vertex"])]
    start = 24 * counts["vertex"]
    return points, [struct.unpack_from("<3i", data, start + 13 * k + 1) for k in range(counts["face"])]


def main():
    out, cells, frames = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    above = lambda distance: turned_about_y((0.0, 0.0, distance), SLOPE)
    cases = {
        "ball": (ball(0.15, (0, 0, 0)), 0.0, (0.013, 0.007, 0.18)),
        "edge": (box((0.3, 0.9, 0.3), 45.0), 0.0, (0.013, 0.007, 0.24)),
        # Blender's cloth sinks into faces of metres.
        "incline": (box((4.0, 1.0, 0.2), SLOPE, (40, 10, 2)), SLOPE, above(0.1 + CLEARANCE)),
        # Our mannequin, 1.69 m: the sheet falls over head and shoulders.
        "body": (read_ply(ROOT / "data" / "bodies" / "mannequin.ply"), 0.0, (0.013, -0.013, 1.72)),
    }
    for name, (body, degrees, centre) in cases.items():
        folder = out / name
        folder.mkdir(parents=True, exist_ok=True)
        write_obj(folder / "body.obj", *body)
        write_obj(folder / "sheet.obj", *sheet(cells, degrees, centre))
        scene = {
            "name": name,
            "geometry": [{"name": "cloth", "size": [SIZE, SIZE], "cells": [cells, cells], "material": "sheet",
                          "transformation": {"translation": centre,
                                             "rotation": {"axis": [0, 1, 0], "angle_deg": degrees}}}],
            "materials": {"sheet": {"density": DENSITY}},
            "obstacles": [{"name": "body", "mesh": "body.obj", "friction": FRICTION}],
            "time": {"frames": frames, "fps": 60},
        }
        (folder / "scene.json").write_text(json.dumps(scene, indent=1) + "\n", encoding="utf-8")
        case = {"size": SIZE, "density": DENSITY, "friction": FRICTION, "slope_deg": SLOPE, "clearance": CLEARANCE, "cells": cells,
                "frames": frames, "centre": centre}
        (folder / "case.json").write_text(json.dumps(case) + "\n", encoding="utf-8")


main()
