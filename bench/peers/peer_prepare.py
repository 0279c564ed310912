# SPDX-License-Identifier: MIT
"""peer_prepare.py FOLDER CELLS FRAMES: writes the bodies, the sheet and the scene of each case of peers.sh."""
import json
import math
import struct
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FPS = 60
SIZE = 0.6  # m, of the sheet
DENSITY = 0.15  # kg/m^2
FRICTION = 0.3  # Coulomb's coefficient on the incline and elsewhere
SLOPE = 30.0  # degrees
CLEARANCE = 0.025  # m, between the sheet and the incline at the start: more than any program keeps at rest
GRAVITY = (0.0, 0.0, -9.81)  # m/s^2
# m, that each program keeps between cloth and body at rest with the settings of its script
KEPT = {"selvedge": 0.002, "blender": 0.01, "bullet": 0.005, "mujoco": 0.004, "mujoco_ipc": 0.001}
SHUT_S, RELEASE_S = 0.3, 0.4  # s, when the jaws are shut and when the handle of the strip lets go
SEAM_X = 0.363  # m: 50 mm before the leading edge of the sheet
PULL = 0.9  # m/s^2: the leading edge comes to the seam with 0.3 m/s


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


def sheet(size, cells, placed):
    """A grid of size[0] by size[1]; `placed` maps its points from the plane z = 0."""
    points = [placed(((i / cells[0] - 0.5) * size[0], (j / cells[1] - 0.5) * size[1], 0.0))
              for j in range(cells[1] + 1) for i in range(cells[0] + 1)]
    faces = []
    for j in range(cells[1]):
        for i in range(cells[0]):
            k = j * (cells[0] + 1) + i
            faces += [(k, k + 1, k + cells[0] + 2), (k, k + cells[0] + 2, k + cells[0] + 1)]
    return points, faces


def moved(mesh, by):
    return [tuple(a + b for a, b in zip(p, by)) for p in mesh[0]], mesh[1]


def read_ply(file):
    """A binary little-endian PLY file: double x, y, z and triangles with int indices."""
    head, data = file.read_bytes().split(b"end_header\n", 1)
    counts = {words[1]: int(words[2]) for words in map(str.split, head.decode("ascii").splitlines())
              if words[0] == "element"}
    points = [struct.unpack_from("<3d", data, 24 * i) for i in range(counts["vertex"])]
    start = 24 * counts["vertex"]
    return points, [struct.unpack_from("<3i", data, start + 13 * k + 1) for k in range(counts["face"])]


def ball_part(radius, centre, motion=None):
    return {"shape": "ball", "size": [radius], "centre": centre, "degrees": 0.0, "mesh": ball(radius, centre),
            "motion": motion or {}}


def box_part(size, centre=(0.0, 0.0, 0.0), degrees=0.0, cells=(1, 1, 1), motion=None):
    return {"shape": "box", "size": size, "centre": centre, "degrees": degrees,
            "mesh": moved(box(size, degrees, cells), centre), "motion": motion or {}}


def draped(part, centre, degrees=0.0, frames=45, cells=30):
    """A sheet that falls on a body that does not move."""
    return {"parts": [part], "size": [SIZE, SIZE], "cells": [cells, cells], "friction": FRICTION, "frames": frames,
            "gravity": GRAVITY, "axis": [0, 1, 0], "angle_deg": degrees, "centre": centre}


def jaws(cells, frames):
    """A strip whose handle lets go after two jaws have shut to half of the room that cloth at rest takes."""
    size, open_m, parts = (0.18, 0.06, 0.09), 0.025, []
    for side in (1, -1):
        motion = {name: [[0.0, 0.0, 0.0, 0.0], [SHUT_S, 0.0, side * (0.5 * kept - open_m), 0.0]]
                  for name, kept in KEPT.items()}
        parts.append(box_part(size, (0.0, side * (open_m + 0.5 * size[1]), 0.06), motion=motion))
    along = max(2, round(cells / 5))
    return {"parts": parts, "size": [0.12, 0.36], "cells": [along, 3 * along], "friction": 0.7,
            "frames": max(2 * frames, round(FPS * (RELEASE_S + 1.0))),  # a second and more after the release
            "gravity": GRAVITY, "axis": [1, 0, 0], "angle_deg": 90.0, "centre": (0.0, 0.0, 0.0), "held": "y1",
            "release_s": RELEASE_S, "load_kg": 0.02, "gripped_m": [0.015, 0.105]}


def hit(cells, frames):
    """A flag that hangs from its upper edge; a ball flies through the place of its middle with 5 m/s."""
    end = frames / FPS
    motion = {name: [[0.0, 0.0, 0.0, 0.0], [end, 0.0, 5.0 * end, 0.0]] for name in KEPT}
    return {"parts": [ball_part(0.1, (0.02, -0.2, 0.01), motion)], "size": [SIZE, SIZE], "cells": [cells, cells],
            "friction": FRICTION, "frames": frames, "gravity": GRAVITY, "axis": [1, 0, 0], "angle_deg": 90.0,
            "centre": (0.0, 0.0, 0.0), "held": "y1"}


def seam(cells, frames, boxes):
    """A sheet that a slight slope pulls along a floor without friction: one box, or two without common vertices."""
    low, high = -0.9, 1.5
    ends = [(low, high, (24, 10, 2))] if boxes == 1 else [(low, SEAM_X, (12, 10, 2)), (SEAM_X, high, (11, 9, 2))]
    parts = [box_part((b - a, 1.0, 0.2), (0.5 * (a + b), 0.0, -0.1), cells=count) for a, b, count in ends]
    return {"parts": parts, "size": [SIZE, SIZE], "cells": [cells, cells], "friction": 0.0, "frames": frames,
            "gravity": (PULL, 0.0, -9.81), "axis": [0, 0, 1], "angle_deg": 0.0, "centre": (0.013, 0.007, CLEARANCE)}


def placement(case):
    c, axis = case["centre"], case["axis"]
    if axis == [1, 0, 0]:  # upright
        return lambda p: (p[0] + c[0], c[1], p[1] + c[2])
    return lambda p: tuple(a + b for a, b in zip(turned_about_y(p, case["angle_deg"]), c))


def held_vertices(case):
    """Numbers of the upper and of the lower edge."""
    across, along = case["cells"]
    row = lambda j: [j * (across + 1) + i for i in range(across + 1)]
    return row(along), row(0)


def scene_of(name, case):
    obstacles = []
    for k, part in enumerate(case["parts"]):
        obstacle = {"name": "body_%d" % k, "mesh": "part_%d.obj" % k, "friction": case["friction"]}
        if part["motion"]:
            obstacle["motion"] = [{"time": key[0], "translation": key[1:]} for key in part["motion"]["selvedge"]]
        obstacles.append(obstacle)
    scene = {
        "name": name,
        "gravity": case["gravity"],
        "geometry": [{"name": "cloth", "size": case["size"], "cells": case["cells"], "material": "sheet",
                      "transformation": {"translation": case["centre"],
                                         "rotation": {"axis": case["axis"], "angle_deg": case["angle_deg"]}}}],
        "materials": {"sheet": {"density": DENSITY}},
        "obstacles": obstacles,
        "time": {"frames": case["frames"], "fps": FPS},
    }
    if "held" in case:
        scene["handles"] = [{"select": case["held"]}]
        if "release_s" in case:
            scene["handles"][0]["release"] = case["release_s"]
    if "load_kg" in case:
        scene["weights"] = [{"select": "y0", "mass": case["load_kg"] / (case["cells"][0] + 1)}]
    return scene


def words_of(case):
    """The case in words, for a program that does not read JSON."""
    rows = ["cloth %.17g %g %d" % (case["mass_kg"], case["friction"], case["frames"]),
            "gravity %g %g %g" % tuple(case["gravity"])]
    for k, part in enumerate(case["parts"]):
        size = [*part["size"], 0.0, 0.0, 0.0][:3]
        rows.append("part %s part_%d.obj %g %g %g %.17g %.17g %.17g %g" %
                    (part["shape"], k, *size, *part["centre"], part["degrees"]))
        rows += ["key %.17g %.17g %.17g %.17g" % tuple(key) for key in part["motion"].get("bullet", [])]
    rows += ["held %d" % i for i in case["held_vertices"]]
    rows += ["loaded %d %.17g" % (i, case["load_kg"] / len(case["loaded_vertices"])) for i in case["loaded_vertices"]]
    if "release_s" in case:
        rows.append("release %g" % case["release_s"])
    return "\n".join(rows) + "\n"


def write_case(folder, case):
    folder.mkdir(parents=True, exist_ok=True)
    for k, part in enumerate(case["parts"]):
        write_obj(folder / ("part_%d.obj" % k), *part["mesh"])
    write_obj(folder / "sheet.obj", *sheet(case["size"], case["cells"], placement(case)))
    (folder / "scene.json").write_text(json.dumps(scene_of(folder.name, case), indent=1) + "\n", encoding="utf-8")
    upper, lower = held_vertices(case)
    case = dict(case, density=DENSITY, slope_deg=SLOPE, clearance=CLEARANCE, kept_m=KEPT,
                mass_kg=DENSITY * case["size"][0] * case["size"][1], held_vertices=upper if "held" in case else [],
                loaded_vertices=lower if "load_kg" in case else [],
                parts=[{key: value for key, value in part.items() if key != "mesh"} for part in case["parts"]])
    (folder / "case.json").write_text(json.dumps(case) + "\n", encoding="utf-8")
    (folder / "case.txt").write_text(words_of(case), encoding="ascii")


def main():
    out, cells, frames = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    above = lambda distance: turned_about_y((0.0, 0.0, distance), SLOPE)
    # Our mannequin, 1.69 m: the sheet falls over head and shoulders.
    body = {"shape": "mesh", "size": [], "centre": (0.0, 0.0, 0.0), "degrees": 0.0, "motion": {},
            "mesh": read_ply(ROOT / "data" / "bodies" / "mannequin.ply")}
    kind = {"frames": frames, "cells": cells}
    cases = {
        "ball": draped(ball_part(0.15, (0.0, 0.0, 0.0)), (0.013, 0.007, 0.18), **kind),
        "edge": draped(box_part((0.3, 0.9, 0.3), degrees=45.0), (0.013, 0.007, 0.24), **kind),
        # Blender's cloth sinks into faces of metres.
        "incline": draped(box_part((4.0, 1.0, 0.2), degrees=SLOPE, cells=(40, 10, 2)), above(0.1 + CLEARANCE), SLOPE, **kind),
        "body": draped(body, (0.013, -0.013, 1.72), **kind),
        "jaws": jaws(cells, frames),
        "hit": hit(cells, frames),
        "floor": seam(cells, frames, 1),
        "seam": seam(cells, frames, 2),
    }
    for name, case in cases.items():
        write_case(out / name, case)


main()
