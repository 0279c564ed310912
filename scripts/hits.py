#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""hits.py [COUNT]: bodies that strike held cloth, drawn at random, each run once.

    scripts/hits.py                       # seeds 1 to 100
    scripts/hits.py --first 17 1          # seed 17 alone
    scripts/hits.py --out out/hits        # keep scenes and results
    scripts/hits.py --kind elbow 24       # or sleeve, twist: kin of the hits (hit_kin.py)

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
import statistics
import subprocess
import sys
import tempfile

import hit_kin

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LIMIT = 0.1  # of the default material
MOST = 1.5  # times the limit
CLEAR = 0.05  # m, from the path of the body to all that is held


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
        seam = {"a": {"geometry": "left", "select": {"edge": "x1"}}, "b": {"geometry": "right", "select": {"edge": "x0"}}, "merge": 0.004}
        points = [(0.0, -half + size * k / 8) for k in range(9)]
        handle = {"geometry": "left", "select": {"edge": "x1"}}
        return {"geometry": pieces, "seams": [seam], "handles": [handle]}, size, points
    select, points = {
        "edge": ({"edge": "y1"}, [(-half + size * k / 8, half) for k in range(9)]),
        "two corners": ({"corners": ["x0y1", "x1y1"]}, [(-half, half), (half, half)]),
        "corner": ({"corners": ["x0y1"]}, [(-half, half)]),
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
    return {"type": "capsule", "radius": radius, "length": length, "resolution": 24}, radius + 0.5 * length, turn


def distance(point, start, way):
    """From a point of the plane y = 0 to the line of the body's centre."""
    d = [point[0] - start[0], -start[1], point[1] - start[2]]
    along = sum(a * b for a, b in zip(d, way))
    return math.sqrt(max(0.0, sum(a * a for a in d) - along * along))


def hit(draw, _):
    held, kind = draw.one_of(["edge", "two corners", "corner", "seam"]), draw.one_of(["ball", "box", "plate", "limb"])
    scene, size, points = sheet(draw, held)
    while True:
        shape, radius, turn = body(draw, kind)
        way = [draw.uniform(-0.5, 0.5), 1.0, draw.uniform(-0.5, 0.5)]
        length = math.hypot(*way)
        way = [a / length for a in way]
        target = [draw.uniform(-0.5, 0.5) * size, 0.0, draw.uniform(-0.5, 0.5) * size]
        back = radius + 0.05
        start = [t - back / way[1] * w for t, w in zip(target, way)]
        if min(distance(p, start, way) for p in points) > radius + CLEAR:
            break
    speed, travel = draw.power(1.0, 20.0), 2.0 * back + draw.uniform(0.4, 0.8)
    seconds = travel / speed
    place = {"translation": start, **({"rotation": turn} if turn else {})}
    scene["obstacles"] = [{"shape": shape, "friction": draw.one_of([0.0, 0.3, 0.6]), "transformation": place,
                           "motion": [{"time": 0}, {"time": seconds, "translation": [travel * w for w in way]}]}]
    scene["time"] = {"frames": math.ceil(60 * seconds) + 20, "fps": 60}
    return scene, f"{held}, {kind}, {speed:.1f} m/s"


def run(program, scene, folder, budget):
    os.makedirs(folder, exist_ok=True)
    file = os.path.join(folder, "scene_in.json")
    with open(file, "w", encoding="utf-8") as out:
        json.dump(scene, out)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([program, "run", file, "--out", os.path.join(folder, "result"), "--threads", "1", "--no-picture", "--overwrite",
                           "--json", "--budget", str(budget)], capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime - before.ru_utime
    try:
        result = json.loads(done.stdout)
    except ValueError:
        result = {}
    return done.returncode, result, (done.stderr.strip().splitlines() or [""])[-1], seconds


KINDS = {"hit": hit, **hit_kin.KINDS}


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("count", nargs="?", type=int, default=100)
    options.add_argument("--kind", choices=KINDS, default="hit")
    options.add_argument("--first", type=int, default=1, help="first seed")
    options.add_argument("--least", type=float, default=98.0, help="of 100 hits that have to be right")
    options.add_argument("--budget", type=float, default=60.0, help="wall seconds of a hit")
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
