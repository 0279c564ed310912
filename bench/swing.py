#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How much of its motion cloth keeps, by integrator and steps per frame (docs/lab/integrators.md).

    bench/swing.py [--program build/release/apps/selvedge] [--integrators implicit_euler,bdf2,implicit_blend]
                     [--steps 2,8,32] [--scenes edge,corners,flag,fall,land]

A sheet of 0.5 m with 20 x 20 cells, without air unless the scene says so, for 2 s:
    edge     held by an edge, flat at the start: kinetic energy of the fourth half second by that of the first, largest values
    corners  the same, held by two corners
    flag     held by an edge in a wind of 4 m/s: mean kinetic energy from 0.5 s on, mJ
    fall     swings from an edge, is released and falls on the floor: mean kinetic energy of the first half second, before the
             contact, mJ
    land     falls on a ball: mean kinetic energy of the second half second, after the contact, mJ

Prints a table in Markdown: the figure of each scene and, in brackets, its share of that of implicit Euler at the most steps.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

FPS = 60


def scene(height, more, rotation=None):
    sheet = {"name": "sheet", "size": [0.5, 0.5], "cells": [20, 20],
             "transformation": {"translation": [0, 0, height], **({"rotation": rotation} if rotation else {})}}
    return {"geometry": [sheet], "time": {"frames": 2 * FPS, "fps": FPS}, **more}


def held(**select):
    return {"handles": [{"name": "held", "select": select}]}


def largest(energy, begin, end):
    return max(energy[round(begin * FPS):round(end * FPS) + 1])


def mean(energy, begin, end):
    part = energy[round(begin * FPS):round(end * FPS) + 1]
    return 1e3 * sum(part) / len(part)


def kept(energy):
    return largest(energy, 1.5, 2.0) / largest(energy, 0.0, 0.5)


UPRIGHT = {"axis": [1, 0, 0], "angle_deg": 90}
SCENES = {
    "edge": (scene(1, held(edge="y1")), kept),
    "corners": (scene(1, held(corners=["x0y1", "x1y1"])), kept),
    "flag": (scene(1, {**held(edge="x0"), "air": {"wind": [4, 0.5, 0], "normal_drag": 0.8, "viscous_drag": 0.05}}, UPRIGHT),
             lambda energy: mean(energy, 0.5, 2.0)),
    "fall": (scene(0.6, {"handles": [{"name": "held", "select": "y1", "release": 0.35}],
                         "obstacles": [{"name": "floor", "shape": {"type": "plane"}}]}),
             lambda energy: mean(energy, 0.0, 0.5)),
    "land": (scene(0.35, {"obstacles": [{"name": "ball", "shape": {"type": "sphere", "radius": 0.1, "resolution": 40},
                                         "transformation": {"translation": [0, 0, 0.1]}}]}),
             lambda energy: mean(energy, 0.5, 1.0)),
}


def figure(program, folder, name, integrator, steps):
    """The figure of a scene; None if the run is not clean."""
    description, measure = SCENES[name]
    file, out = folder / f"{name}.json", folder / f"{name}_{integrator}_{steps}"
    file.write_text(json.dumps({"name": name, **description}))
    run = [program, "run", file, "--out", out, "--set", f"solver.integrator={integrator}", "--set", f"time.steps_per_frame={steps}"]
    if subprocess.run(run, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode != 0:
        return None
    subprocess.run([program, "measure", out, "--no-pictures"], check=True, stdout=subprocess.DEVNULL)
    with open(out / "measures" / "energy.csv") as rows:
        return measure([float(row["kinetic_J"]) for row in csv.DictReader(rows)])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/release/apps/selvedge")
    parser.add_argument("--integrators", default="implicit_euler,bdf2,implicit_blend")
    parser.add_argument("--steps", default="2,8,32")
    parser.add_argument("--scenes", default=",".join(SCENES))
    options = parser.parse_args()
    scenes, steps = options.scenes.split(","), [int(n) for n in options.steps.split(",")]
    unknown = [name for name in scenes if name not in SCENES]
    if unknown:
        sys.exit(f"swing.py: no scene \"{unknown[0]}\"; there are {', '.join(SCENES)}")
    print("| integrator | steps per frame |", *(f"{name} |" for name in scenes))
    print("| --- | --: |", *("--: |" for _ in scenes), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        at = lambda *case: figure(options.program, pathlib.Path(folder), *case)
        fine = {name: at(name, "implicit_euler", max(steps)) for name in scenes}
        for integrator in options.integrators.split(","):
            for n in steps:
                known = (integrator, n) == ("implicit_euler", max(steps))
                cells = [(fine[name] if known else at(name, integrator, n), fine[name]) for name in scenes]
                shown = ("not clean |" if value is None or of is None else f"{value:.3g} ({value / of:.2f}) |" for value, of in cells)
                print(f"| `{integrator}` | {n} |", *shown, flush=True)


if __name__ == "__main__":
    main()
