#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""hits.py [COUNT]: bodies that strike held cloth, drawn at random, each run once.

    scripts/hits.py                       # seeds 1 to 100
    scripts/hits.py --first 17 1          # seed 17 alone
    scripts/hits.py --out out/hits        # keep scenes and results
    scripts/hits.py --kind elbow 24       # or sleeve, twist, drop, fast: kin of the hits

A sheet is held at an edge, two corners, one corner or the seam of two pieces. A ball, a box, a plate edge first or a
limb passes through the place where it hangs, at 1 to 20 m/s, with the default steps. A hit is right if the run reaches
its last frame, is clean (outside of jams, where the limbs of an elbow leave cloth no room), and no accepted state has a
spring stretched to more than 1.5 times its limit. Each line gives
the seed, what was drawn, the largest stretch, the steps and the processor time. Exit code 1: fewer than --least of 100
are right. SELVEDGE names the program (default: build/release/apps/selvedge).
"""
import argparse
import json
import math
import os
import random
import resource
import signal
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LIMIT = 0.1  # of the default material
MOST = 1.5  # times the limit
CLEAR = 0.05  # m, from the path of the body to all that is held
DRAWS = 500_000  # of a body, after which another sheet is drawn: no limb keeps clear of a short seam. Seed 2 takes 421,394.


class Draw:
    """Random values of one seed. Only random(), whose bits Python guarantees, is used."""

    def __init__(self, seed):
        self.random = random.Random(seed).random

    def uniform(self, low, high):
        return low + (high - low) * self.random()

    def power(self, low, high):
        return low * (high / low) ** self.random()

    def one_of(self, choices):
        return choices[int(self.random() * len(choices))]

    def direction(self):
        while True:
            v = [self.uniform(-1, 1) for _ in range(3)]
            size = math.sqrt(sum(a * a for a in v))
            if 0.1 < size <= 1.0:
                return [a / size for a in v]


def upright(**more):
    """A grid in the plane x, z."""
    return {"transformation": {"translation": [more.pop("x", 0.0), 0, 0], "rotation": {"axis": [1, 0, 0], "angle_deg": 90}}, **more}


def sheet(draw, held):
    """The pieces, and the points that are held, m."""
    size, cells = draw.uniform(0.3, 0.6), int(draw.uniform(8, 15))
    half = 0.5 * size
    if held == "seam":
        gap = 0.003
        pieces = [upright(name=name, size=[half, size], cells=[(cells + 1) // 2, cells], x=x)
                  for name, x in (("left", -0.5 * (half + gap)), ("right", 0.5 * (half + gap)))]
        seam = {"sides": [{"geometry": "left", "select": "x1"}, {"geometry": "right", "select": "x0"}], "merge": 0.004}
        points = [(0.0, -half + size * k / 8) for k in range(9)]
        handle = {"geometry": "left", "select": "x1"}
        return {"geometry": pieces, "seams": [seam], "handles": [handle]}, size, points
    select, points = {
        "edge": ("y1", [(-half + size * k / 8, half) for k in range(9)]),
        "two corners": (["x0y1", "x1y1"], [(-half, half), (half, half)]),
        "corner": (["x0y1"], [(-half, half)]),
    }[held]
    return {"geometry": [upright(name="sheet", size=[size, size], cells=[cells, cells])], "handles": [{"select": select}]}, size, points


def body(draw, kind):
    """The shape, its largest radius about its centre, m, and how it is turned."""
    turn = {"axis": draw.direction(), "angle_deg": draw.uniform(0, 180)}
    if kind == "ball":
        radius = draw.uniform(0.04, 0.12)
        return {"type": "sphere", "radius": radius, "resolution": 24}, radius, None
    if kind == "box":
        side = [draw.uniform(0.06, 0.2) for _ in range(3)]
        return {"type": "box", "size": side}, 0.5 * math.hypot(*side), turn
    if kind == "plate":
        side = [draw.uniform(0.1, 0.3), draw.uniform(0.1, 0.3), 0.01]
        # Its edge leads: the thin side lies along z or x, never along its path y.
        flat = {"axis": [0, 1, 0], "angle_deg": draw.uniform(0, 180)}
        return {"type": "box", "size": side}, 0.5 * math.hypot(*side), flat
    radius, length = draw.uniform(0.03, 0.06), draw.uniform(0.15, 0.35)
    return {"type": "capsule", "radius": radius, "height": length, "resolution": 24}, radius + 0.5 * length, turn


def distance(point, start, way):
    """From a point of the plane y = 0 to the line of the body's centre."""
    d = [point[0] - start[0], -start[1], point[1] - start[2]]
    along = sum(a * b for a, b in zip(d, way))
    return math.sqrt(max(0.0, sum(a * a for a in d) - along * along))


def clear_path(draw, kind, size, points):
    """A body, its start and its way past all that is held; None if no draw keeps clear."""
    for _ in range(DRAWS):
        shape, radius, turn = body(draw, kind)
        way = [draw.uniform(-0.5, 0.5), 1.0, draw.uniform(-0.5, 0.5)]
        length = math.hypot(*way)
        way = [a / length for a in way]
        target = [draw.uniform(-0.5, 0.5) * size, 0.0, draw.uniform(-0.5, 0.5) * size]
        back = radius + 0.05
        start = [t - back / way[1] * w for t, w in zip(target, way)]
        if min(distance(p, start, way) for p in points) > radius + CLEAR:
            return shape, turn, back, start, way
    return None


def hit(draw, _):
    held, kind = draw.one_of(["edge", "two corners", "corner", "seam"]), draw.one_of(["ball", "box", "plate", "limb"])
    path = None
    while path is None:
        scene, size, points = sheet(draw, held)
        path = clear_path(draw, kind, size, points)
    shape, turn, back, start, way = path
    speed, travel = draw.power(1.0, 20.0), 2.0 * back + draw.uniform(0.4, 0.8)
    seconds = travel / speed
    place = {"translation": start, **({"rotation": turn} if turn else {})}
    scene["obstacles"] = [{"shape": shape, "friction": draw.one_of([0.0, 0.3, 0.6]), "transformation": place,
                           "motion": [{"time": 0}, {"time": seconds, "translation": [travel * w for w in way]}]}]
    scene["time"] = {"frames": math.ceil(60 * seconds) + 20, "fps": 60}
    return scene, f"{held}, {kind}, {speed:.1f} m/s"


def processor_time(process):
    """Seconds of the processor that a running process has used."""
    with open(f"/proc/{process}/stat", encoding="ascii") as stat:
        return int(stat.read().rsplit(")", 1)[1].split()[11]) / os.sysconf("SC_CLK_TCK")


def run(program, scene, folder, budget):
    os.makedirs(folder, exist_ok=True)
    file = os.path.join(folder, "scene_in.json")
    with open(file, "w", encoding="utf-8") as out:
        json.dump(scene, out)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = [program, "run", file, "--out", os.path.join(folder, "result"), "--threads", "1", "--no-pictures", "--overwrite", "--json"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
        stopped = False
        while True:
            try:
                printed, said = child.communicate(timeout=1.0)
                break
            except subprocess.TimeoutExpired:
                if not stopped and processor_time(child.pid) > budget:
                    child.send_signal(signal.SIGINT)  # ends with what is done so far
                    stopped = True
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime - before.ru_utime
    try:
        result = json.loads(printed)
    except ValueError:
        result = {}
    return child.returncode, result, (said.strip().splitlines() or [""])[-1], seconds


# Kin of the hits: sleeves on arms that bend or swing, and strips that are twisted.
def tube(radius, from_x, to_x, around, along):
    """Vertices and triangles of a tube along x, open at both ends."""
    vertices, triangles = [], []
    for i in range(along + 1):
        x = from_x + (to_x - from_x) * i / along
        for j in range(around):
            a = 2 * math.pi * (j + 0.5 * (i % 2)) / around
            vertices.append([x, radius * math.cos(a), radius * math.sin(a)])
    for i in range(along):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = a + around, b + around
            triangles += [[a, b, c], [b, d, c]] if i % 2 == 0 else [[a, d, c], [a, b, d]]
    return vertices, triangles


def limb(radius, from_x, to_x, around, along):
    """The same, closed."""
    vertices, triangles = tube(radius, from_x, to_x, around, along)
    n, last = len(vertices), along * around
    vertices += [[from_x, 0, 0], [to_x, 0, 0]]
    for j in range(around):
        k = (j + 1) % around
        triangles += [[n, k, j], [n + 1, last + j, last + k]]
    return vertices, triangles


def bent_in_an_arc(vertices, angle, half):
    """The centre line, along x, becomes an arc over 2 half about z, with straight ends."""
    out = []
    for x, y, z in vertices:
        if angle == 0.0:
            out.append([x, y, z])
            continue
        curvature = angle / (2 * half)
        s = max(-half, min(half, x))
        a = curvature * s
        cx, cy = math.sin(a) / curvature + (x - s) * math.cos(a), (1 - math.cos(a)) / curvature + (x - s) * math.sin(a)
        out.append([cx - y * math.sin(a), cy + y * math.cos(a), z])
    return out


def skinned(vertices, angle, half):
    """Each vertex goes to the mean of where its two bones take it, so that the skin of the elbow folds inwards."""
    out = []
    for x, y, z in vertices:
        share = max(0.0, min(1.0, 0.5 + 0.5 * x / half))
        upper, lower = ((x * math.cos(a) - y * math.sin(a), x * math.sin(a) + y * math.cos(a)) for a in (-0.5 * angle, 0.5 * angle))
        out.append([(1 - share) * upper[0] + share * lower[0], (1 - share) * upper[1] + share * lower[1], z])
    return out


def write_obj(path, vertices, triangles):
    with open(path, "w", encoding="utf-8") as file:
        for p in vertices:
            file.write("v %.9g %.9g %.9g\n" % tuple(p))
        for t in triangles:
            file.write("f %d %d %d\n" % tuple(i + 1 for i in t))


def elbow(draw, folder):
    """A sleeve on an arm that bends, or a strip in the bend. The files of the arm are written to the folder."""
    radius, length = draw.uniform(0.035, 0.055), draw.uniform(0.2, 0.3)
    way, cloth = draw.one_of(["arc", "skin", "skin"]), draw.one_of(["sleeve", "sleeve", "strip"])
    angle, seconds = math.radians(draw.uniform(100, 150)), draw.uniform(0.4, 1.2)
    half = radius * (draw.uniform(1.0, 1.4) if way == "arc" else draw.uniform(0.6, 1.4))
    if way == "arc":
        half = max(half, 0.5 * angle * radius * draw.uniform(1.0, 1.15))  # so that the skin has no fold
    bend = bent_in_an_arc if way == "arc" else skinned
    vertices, triangles = limb(radius, -length, length, 20, int(2 * length / 0.012))
    back, fps = draw.one_of([True, False]), 30
    n = max(3, int(seconds * fps))
    angles = [angle * (0.5 - 0.5 * math.cos(math.pi * i / n)) for i in range(n + 1)] + [angle] * 6
    if back:
        angles += [angle * (0.5 + 0.5 * math.cos(math.pi * i / n)) for i in range(1, n + 1)]
    files = []
    os.makedirs(folder, exist_ok=True)
    for i, a in enumerate(angles):
        files.append(f"arm_{i:03d}.obj")
        write_obj(os.path.join(folder, files[-1]), bend(vertices, a, half), triangles)
    piece, handles, held = elbow_cloth(draw, radius, angle, (way, cloth), lambda p, a: bend([p], a, half)[0], angles, fps)
    scene = {"geometry": [piece], "handles": handles, "gravity": [0, 0, -9.81] if cloth == "sleeve" else [0, -9.81, 0],
             "obstacles": [{"name": "arm", "sequence": {"files": files, "fps": fps}, "friction": draw.one_of([0.0, 0.3, 0.6])}],
             "contact": {"still_tangled": "carry"}, "time": {"frames": math.ceil(60 * (len(angles) - 1) / fps) + 10, "fps": 60}}
    return scene, f"{way}, {cloth}{' held' if held else ''}, {math.degrees(angle):.0f} degrees in {seconds:.2f} s{' and back' if back else ''}"


def elbow_cloth(draw, radius, angle, kind, place, angles, fps):
    """The piece, its handles, and whether one end of a sleeve is held on the upper arm."""
    way, cloth = kind
    if cloth == "strip":
        width, length = draw.uniform(0.04, 0.12), draw.uniform(0.15, 0.3)
        turned = {"rotation": {"axis": [1, 0, 0], "angle_deg": 90}, "translation": [0, radius + 0.004, 0]}
        draw.random()
        cells = [int(length / 0.012), max(3, int(width / 0.012))]
        return {"name": "strip", "size": [length, width], "cells": cells, "transformation": turned}, [], False
    room, around = draw.uniform(0.004, 0.015), 24
    cell = 2 * math.pi * (radius + room) / around
    a, b = -draw.uniform(0.08, 0.16), draw.uniform(0.08, 0.16)
    vertices, triangles = tube(radius + room, a, b, around, max(4, int((b - a) / cell)))
    held = draw.one_of([True, False])
    if way == "skin" and -a < 1.2 * (radius + room) * math.tan(0.5 * angle):
        held = False  # the handle would lie inside the lower arm
    piece = {"name": "sleeve", "mesh": {"vertices": [[round(c, 9) for c in p] for p in vertices], "triangles": triangles}}
    if not held:
        return piece, [], False
    motion = [{"time": i / fps, "translation": [p - q for p, q in zip(place([a, 0, 0], x), [a, 0, 0])],
               "rotation": {"axis": [0, 0, 1], "angle_deg": -0.5 * math.degrees(x)}} for i, x in enumerate(angles)]
    motion[0] = {"time": 0}
    return piece, [{"geometry": "sleeve", "select": list(range(around)), "motion": motion}], True


def twist(draw, _):
    """A strip held at both ends, one of which turns two to eight times and comes nearer."""
    length, width, cell = draw.uniform(0.2, 0.5), draw.uniform(0.03, 0.12), draw.uniform(0.006, 0.012)
    angle, rate = draw.uniform(720, 3000), draw.power(360, 2000)
    seconds, nearer, n = angle / rate, draw.uniform(0.0, 0.6) * length, math.ceil(angle / 90)
    motion = [{"time": 0}] + [{"time": seconds * i / n, "translation": [-nearer * (i / n) ** 2, 0, 0],
                               "rotation": {"axis": [1, 0, 0], "angle_deg": (angle * i / n) % 360}} for i in range(1, n + 1)]
    draw.random()
    cells = [int(length / cell), max(3, int(width / cell))]
    scene = {"gravity": [0, 0, draw.one_of([0, -9.81])], "geometry": [{"name": "strip", "size": [length, width], "cells": cells}],
             "handles": [{"select": "x0"}, {"select": "x1", "motion": motion}],
             "contact": {"rest_gap": draw.one_of([0.001, 0.002]), "still_tangled": "carry"},
             "time": {"frames": math.ceil(60 * seconds) + 10, "fps": 60}}
    return scene, f"{length:.2f} x {width:.2f} m, {angle:.0f} degrees at {rate:.0f} degrees/s, {nearer:.2f} m nearer"


def sleeve(draw, _):
    """A sleeve on an arm that turns about its shoulder at 800 to 1,500 degrees/s."""
    radius, length, room = draw.uniform(0.03, 0.06), draw.uniform(0.4, 0.7), draw.uniform(0.003, 0.015)
    around, a = draw.one_of([20, 24, 32]), draw.uniform(0.02, 0.1)
    b, cell = a + draw.uniform(0.25, 0.55), 2 * math.pi * (radius + room) / around
    vertices, triangles = tube(radius + room, a, b, around, max(4, int((b - a) / cell)))
    held, rate, angle = draw.one_of([False, False, True]), draw.uniform(800, 1500), draw.uniform(60, 170)
    draw.random()
    axis, seconds = draw.one_of([[0, 0, 1], [0, 1, 0]]), angle / rate
    turned = {"axis": axis, "angle_deg": angle}
    keys = [{"time": 0}, {"time": 0.05}, {"time": 0.05 + seconds, "rotation": turned}]
    if draw.one_of([False, True]):
        keys += [{"time": 0.05 + 2 * seconds}, {"time": 0.05 + 3 * seconds, "rotation": turned}]
    arm = limb(radius, 0.0, length, 24, 20)
    friction = draw.one_of([0.0, 0.3, 0.3, 0.6])
    scene = {"geometry": [{"name": "sleeve", "mesh": {"vertices": [[round(c, 9) for c in p] for p in vertices], "triangles": triangles}}],
             "obstacles": [{"name": "arm", "mesh": {"vertices": arm[0], "triangles": arm[1]}, "motion": keys, "friction": friction}],
             "contact": {"still_tangled": "carry"}, "time": {"frames": math.ceil(60 * keys[-1]["time"]) + 15, "fps": 60}}
    if held:
        scene["handles"] = [{"select": list(range(around)), "motion": shoulder_motion(keys, a, axis)}]
    return scene, f"{b - a:.2f} m{' held' if held else ''}, {1000 * room:.0f} mm of room, {angle:.0f} degrees at {rate:.0f} degrees/s, mu {friction}"


def shoulder_motion(keys, distance, axis):
    """Of particles about a point of the arm at a distance from the shoulder; a handle turns about its own centre."""
    motion, parts = [{"time": 0}], 8
    for before, after in zip(keys, keys[1:]):
        a, b = (k.get("rotation", {}).get("angle_deg", 0.0) for k in (before, after))
        for i in range(1, parts + 1):
            angle, time = a + (b - a) * i / parts, before["time"] + (after["time"] - before["time"]) * i / parts
            c, s = distance * math.cos(math.radians(angle)), distance * math.sin(math.radians(angle))
            place = [c - distance, 0, -s] if axis[1] else [c - distance, s, 0]
            motion.append({"time": time, "translation": place, **({"rotation": {"axis": axis, "angle_deg": angle}} if angle else {})})
    return motion


# Kin of the hits: loose sheets that are dropped on a body or thrown at it.
def struck(draw):
    """A body at the origin: its shape, how it is turned, its half height, m, and its name."""
    kind = draw.one_of(["ball", "box", "post", "plate"])
    turn = {"axis": draw.direction(), "angle_deg": draw.uniform(0, 180)}
    if kind == "ball":
        radius = draw.uniform(0.05, 0.25)
        return {"type": "sphere", "radius": radius, "resolution": 24}, None, radius, kind
    if kind == "box":
        side = [draw.uniform(0.1, 0.4) for _ in range(3)]
        return {"type": "box", "size": side}, turn, 0.5 * math.hypot(*side), kind
    if kind == "plate":
        side = [draw.uniform(0.1, 0.4), 0.01, draw.uniform(0.1, 0.4)]
        return {"type": "box", "size": side}, {"axis": [0, 0, 1], "angle_deg": draw.uniform(0, 180)}, 0.5 * side[2], kind
    radius, length = draw.uniform(0.01, 0.05), draw.uniform(0.1, 0.6)
    return {"type": "capsule", "radius": radius, "height": length, "resolution": 24}, None, radius + 0.5 * length, kind


def loose(draw, speed, fall):
    """A sheet that meets the top of a body after a fall, m, or at a speed, m/s. Its tip is at most 30 degrees low."""
    shape, turn, half, name = struck(draw)
    size, cells = [draw.uniform(0.3, 1.0) for _ in range(2)], draw.uniform(12, 40)
    cells = [max(4, int(cells * s / max(size))) for s in size]
    tilt = {"axis": draw.one_of([[1, 0, 0], [0, 1, 0]]), "angle_deg": draw.uniform(-30, 30)}
    low = 0.5 * max(size) * math.sin(math.radians(abs(tilt["angle_deg"])))
    aside = [draw.uniform(-0.3, 0.3) * size[0], draw.uniform(-0.3, 0.3) * size[1]]
    gap = fall if fall else 0.05
    sheet_at = {"translation": [*aside, half + low + gap], "rotation": tilt}
    seconds = 0.4 + (math.sqrt(2 * (fall + low) / 9.81) if fall else (gap + low) / speed)
    cloth = {"name": "sheet", "size": size, "cells": cells, "transformation": sheet_at, "velocity": [0, 0, -speed]}
    body_at = {"transformation": {"rotation": turn}} if turn else {}
    scene = {"geometry": [cloth], "obstacles": [{"shape": shape, "friction": draw.one_of([0.0, 0.3, 0.6]), **body_at}],
             "time": {"frames": math.ceil(60 * seconds), "fps": 60}}
    return scene, f"{size[0]:.2f} x {size[1]:.2f} m, {cells[0]} x {cells[1]} cells, {name}, "


def drop(draw, _):
    """A sheet that falls from 0.5 to 10 m."""
    fall = draw.power(0.5, 10.0)
    scene, words = loose(draw, 0.0, fall)
    return scene, words + f"from {fall:.1f} m"


def fast(draw, _):
    """A sheet that is thrown at 1 to 100 m/s."""
    speed = draw.power(1.0, 100.0)
    scene, words = loose(draw, speed, 0.0)
    return scene, words + f"{speed:.1f} m/s"


KINDS = {"hit": hit, "elbow": elbow, "sleeve": sleeve, "twist": twist, "drop": drop, "fast": fast}


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("count", nargs="?", type=int, default=100)
    options.add_argument("--kind", choices=KINDS, default="hit")
    options.add_argument("--first", type=int, default=1, help="first seed")
    options.add_argument("--least", type=float, default=98.0, help="of 100 hits that have to be right")
    options.add_argument("--budget", type=float, default=60.0, help="seconds of the processor of a hit")
    options.add_argument("--out", help="folder that keeps scenes and results")
    o = options.parse_args()
    program = os.environ.get("SELVEDGE", os.path.join(ROOT, "build/release/apps/selvedge"))
    right, times, stretches = 0, [], []
    with tempfile.TemporaryDirectory() as scratch:
        for seed in range(o.first, o.first + o.count):
            folder = os.path.join(o.out or scratch, str(seed))
            scene, words = KINDS[o.kind](Draw(seed), folder)
            code, result, said, seconds = run(program, scene, folder, o.budget)
            stretch = result.get("max_stretch", math.nan)
            good = code == 0 and result.get("clean_elsewhere") and stretch <= MOST * LIMIT
            right += good
            times.append(seconds)
            stretches.append(stretch if code == 0 else math.inf)
            print(f"{seed:4d}  {'right' if good else 'WRONG'}  {100 * stretch:8.2f} %  {result.get('steps', 0):5d} steps  {seconds:6.2f} s  "
                  f"{words}{'' if code == 0 else ': ' + said}", flush=True)
    print(f"seeds {o.first} to {o.first + o.count - 1}: {right} of {o.count} right; stretch median {100 * statistics.median(stretches):.2f} %, "
          f"worst {100 * max(stretches):.2f} %; processor time median {statistics.median(times):.2f} s, sum {sum(times):.1f} s")
    return 0 if 100 * right >= o.least * o.count else 1


if __name__ == "__main__":
    sys.exit(main())
