#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Measures claims of the survey on its scenes and sizes, 2,500 particles unless noted.

    PYTHONPATH=build/release/python bench/survey_size.py PART [--stiffness K] [--size 50] [--turns N] [--longest S]

PART:
limiters  C4, C5, C6, Figure 22, Table VI: strain limiters on a round table, with as many sweeps as each method needs
meshes    C1, C2, C3, Figures 11 and 12: four meshes at the survey's eight sizes, on the table and hung by two corners
penalty   C10, Figure 45: a cloth that falls onto the table with penalty springs from small to great
levels    C19: adaptive and multi-level meshes against uniform ones, time and error
layers    C20: a bilayered cloth against plain sheets, time and error
voxels    C15: two sheets that fall onto a ball, with voxels of several sizes
maps      C11: whole runs with depth and normal maps against the tree, body at rest and moving, time and error

The cloth is at balance when the root of its mean squared speed stays below 5 mm/s. Simulations use one thread; times are
those of the processor, which other programs disturb less than those of the clock.
"""
import argparse
import itertools
import json
import pathlib
import time

import numpy as np
import selvedge

SIDE = 1.0  # m
BOUND = 0.005  # m/s


def net(pattern, stiffness):
    """A net of equal springs."""
    keys = ("structural", "flexion") if pattern == "triangular_net" else ("structural", "shear", "flexion")
    return {"type": pattern, **{key: stiffness for key in keys}}


def table_scene(size, stiffness, solver, pattern=None):
    """A net of equal springs, or another pattern, over a round table of 0.3 m."""
    table = {"type": "cylinder", "radius": 0.3, "height": 0.02, "resolution": 96}
    return {
        "geometry": [{
            "name": "cloth", "size": [SIDE, SIDE], "cells": [size - 1, size - 1],
            "pattern": pattern or net("rectangular_net", stiffness), "transformation": {"translation": [0, 0, 0.503]},
        }],
        "materials": {"default": {"density": 0.2, "spring_damping": 0.001, "strain_limit": 0.1}},
        "obstacles": [
            {"name": "table", "shape": table, "transformation": {"translation": [0, 0, 0.49]}, "friction": 0.5}
        ],
        "air": {"viscous_drag": 1.6},
        "solver": solver,
        "time": {"frames": 3600, "fps": 60, "steps_per_frame": 1},
    }


def rms_speed(simulation):
    mass = np.asarray(simulation.mass)
    return np.sqrt((mass * (np.asarray(simulation.velocities) ** 2).sum(axis=1)).sum() / mass.sum())


class Run:
    """A simulation until its cloth has stayed below the bound for half a second, or for `longest` seconds."""

    def __init__(self, description, longest, watch=False):
        self.simulation = selvedge.Simulation(description)
        self.start = self.positions()
        self.highest = self.fastest = 0.0  # m above the start, m/s; if watched
        begin, step, calm = time.process_time(), 0, 0
        self.until = 0.0  # s, of the last step above the bound
        while step < longest * 60 and (calm < 30 or step < 90):
            self.simulation.step()
            step += 1
            if watch:
                self.highest = max(self.highest, (self.positions() - self.start)[:, 2].max())
                self.fastest = max(self.fastest, np.abs(np.asarray(self.simulation.velocities)).max())
            calm = calm + 1 if rms_speed(self.simulation) < BOUND else 0
            if calm == 0:
                self.until = step / 60.0
        self.calm = calm >= 30
        self.seconds = time.process_time() - begin

    def result(self):
        return self.simulation.result()

    def positions(self):
        return np.array(self.simulation.positions)


def spread(values, form="{:.3g}"):
    values = sorted(values)
    return f"{form.format(values[len(values) // 2])} ({form.format(values[0])} to {form.format(values[-1])})"


LIMITERS = {
    "position": "position",
    "ordered_position": "ordered_position",
    "ordered_position, one sweep": {"type": "ordered_position", "max_sweeps": 1},
    "velocity": "velocity",
    "position_velocity": "position_velocity",
    "ordered_position_velocity": "ordered_position_velocity",
    "position_as_printed": "position_as_printed",
}


def limiters(options):
    print("limiter | processor s, over position | strain phase s, over position | sweeps | residual % | "
          "largest stretch % | simulated s until balance | RMS distance to position, % of the side")
    runs = {name: [] for name in LIMITERS}
    for _, (name, limiter) in itertools.product(range(options.turns), LIMITERS.items()):
        kind = {"type": limiter} if isinstance(limiter, str) else dict(limiter)
        kind.setdefault("max_sweeps", 1000000)
        solver = {"strain_limiter": kind, "integrator": options.integrator}
        runs[name].append(Run(table_scene(options.size, options.stiffness, solver), options.longest))
    base = runs["position"]
    for name, own in runs.items():
        result = own[0].result()
        over = spread([a.seconds / b.seconds for a, b in zip(own, base)])
        strain = spread([a.result()["phase_s"]["strain"] / b.result()["phase_s"]["strain"] for a, b in zip(own, base)])
        off = 100.0 / SIDE * np.sqrt(((own[0].positions() - base[0].positions()) ** 2).sum(axis=1).mean())
        print(f"{name} | {own[0].seconds:.2f}, {over} | {strain} | {result['counters'].get('strain_sweeps', 0):.0f} | "
              f"{100 * result['strain_residual']:.2f} | {100 * result['max_stretch']:.1f} | {own[0].until:.2f}"
              f"{'' if own[0].calm else ' (moving)'} | {off:.2f}", flush=True)


SIZES = (10, 17, 25, 33, 42, 50, 56, 59)  # particles along a side: 100 to 3,481
NETS = ("rectangular", "simplified", "triangular", "responsive")


def hung_scene(size, stiffness, solver, pattern):
    """The same cloth held by two corners, without a table."""
    scene = table_scene(size, stiffness, solver, pattern)
    del scene["obstacles"]
    scene["handles"] = [{"name": "corners", "select": ["x0y1", "x1y1"]}]
    return scene


def at_places(start, x, size, places):
    """Positions of a grid of size x size particles at places (x, y) of its flat start, by bilinear interpolation."""
    cells = size - 1
    low = start[:, :2].min(axis=0)
    s = np.clip((places - low) / SIDE * cells, 0.0, cells)
    i = np.minimum(s.astype(int), cells - 1)
    u = (s - i)[:, :1], (s - i)[:, 1:]
    at = lambda a, b: x[(i[:, 1] + b) * size + i[:, 0] + a]
    return ((1 - u[0]) * (1 - u[1]) * at(0, 0) + u[0] * (1 - u[1]) * at(1, 0)
            + (1 - u[0]) * u[1] * at(0, 1) + u[0] * u[1] * at(1, 1))


def rms(difference):
    return 100.0 / SIDE * np.sqrt((difference**2).sum(axis=1).mean())


def balance_summary(scene, kind, times, offs, steps):
    """What the survey says of the nets, over the sizes. Each argument is by net, then by size."""
    sizes = len(times["rectangular"])
    over = {name: [a / b for a, b in zip(times[name], times["rectangular"])] for name in NETS}
    print(f"{scene}, {kind}: processor time until balance over rectangular, median over sizes (range): "
          + ", ".join(f"{name} {spread(over[name])}" for name in NETS[1:]))
    count = lambda holds: f"{sum(holds(i) for i in range(sizes))} of {sizes}"
    print(f"{scene}, {kind}: sizes at which triangular is faster than simplified: "
          + count(lambda i: times["triangular"][i] < times["simplified"][i])
          + "; simplified faster than rectangular: " + count(lambda i: over["simplified"][i] < 1)
          + "; responsive the slowest: " + count(lambda i: times["responsive"][i] == max(times[n][i] for n in NETS))
          + "; simplified the nearest to rectangular: " + count(lambda i: offs["simplified"][i] == min(offs[n][i] for n in NETS[1:]))
          + "; triangular the farthest: " + count(lambda i: offs["triangular"][i] == max(offs[n][i] for n in NETS[1:])))
    ms = [[steps[name][i] for name in NETS] for i in range(sizes)]
    print(f"{scene}, {kind}: dearest less cheapest net, ms per step, by size: "
          + ", ".join(f"{max(row) - min(row):.3f}" for row in ms))
    print(f"{scene}, {kind}: dearest over cheapest net by size: " + ", ".join(f"{max(row) / min(row):.2f}" for row in ms), flush=True)


def meshes(options):
    print("scene | springs | particles | mesh | simulated s until balance | steps | processor s | ms per step | "
          "processor s, over rectangular | RMS distance to rectangular, % of the side")
    scenes = {"table": table_scene, "hung": hung_scene}
    kinds = {"equal k": lambda name: net(name + "_net", options.stiffness), "equal fabric": lambda name: name}
    for scene, kind in itertools.product(options.scenes, options.springs):
        times, offs, per_step = ({name: [] for name in NETS} for _ in range(3))
        for size in options.sizes:
            base = None
            for name in NETS:
                run = Run(scenes[scene](size, options.stiffness, {"integrator": options.integrator}, kinds[kind](name)), options.longest)
                x, start, steps = run.positions(), run.start, run.result()["steps"]
                if name == "rectangular":
                    base = run.seconds, start, x
                off = rms(x - at_places(base[1], base[2], size, start[:, :2]))
                for table, value in ((times, run.seconds), (offs, off), (per_step, 1e3 * run.seconds / steps)):
                    table[name].append(value)
                print(f"{scene} | {kind} | {len(x)} | {name} | {run.until:.2f}{'' if run.calm else ' (moving)'} | {steps} | "
                      f"{run.seconds:.2f} | {1e3 * run.seconds / steps:.2f} | {run.seconds / base[0]:.2f} | {off:.2f}", flush=True)
        balance_summary(scene, kind, times, offs, per_step)


def penalty(options):
    print("K, N/m | steps | largest lack of the rest gap, mm | repairs | highest particle above its start, mm | "
          "largest speed, m/s | energy gained, mJ | at balance after, s")
    for stiffness in (1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6):
        solver = {"strain_limiter": "ordered_position", "integrator": options.integrator}
        scene = table_scene(options.size, options.stiffness, solver)
        scene["contact"] = {"response": {"type": "penalty", "stiffness": stiffness}}
        scene["time"]["energy_guard"] = False
        run = Run(scene, options.longest, watch=True)
        counters = run.result()["counters"]
        lack = counters.get("max_gap_violation_m", 0.0)
        repairs = sum(value for key, value in counters.items() if key.startswith("fail_safe"))
        print(f"{stiffness:g} | {run.result()['steps']} | {1e3 * lack:.3f} | {repairs:.0f} | {1e3 * run.highest:.1f} | "
              f"{run.fastest:.2f} | {1e3 * counters.get('energy_gained_J', 0.0):.3g} | "
              f"{run.until:.2f}{'' if run.calm else ' (moving)'}", flush=True)


def shipped(name, frames, **cloth):
    """A shipped scene with other cloth, stepped for some frames: processor time, and positions by frame."""
    scene = json.loads((pathlib.Path(__file__).parent.parent / "data/scenes" / f"{name}.json").read_text())
    del scene["$schema"]
    for key, value in cloth.items():
        if value is None:
            scene["geometry"][0].pop(key, None)
        else:
            scene["geometry"][0][key] = value
    scene["time"]["frames"] = frames
    simulation = selvedge.Simulation(scene)
    begin = time.process_time()
    simulation.advance_to_frame(frames)
    return time.process_time() - begin, np.array(simulation.positions)


def coarse(x, cells, step):
    """Vertices of a uniform mesh that a mesh with cells `step` times as large has too."""
    grid = x[:(cells[0] + 1) * (cells[1] + 1)].reshape(cells[1] + 1, cells[0] + 1, 3)
    return grid[::step, ::step].reshape(-1, 3)


def against(name, rows, reference, extent):
    print(f"{name}: cloth | processor s | RMS distance to the reference at common vertices, % of the longer side")
    for label, seconds, x in rows:
        off = 100.0 / extent * np.sqrt(((x - reference) ** 2).sum(axis=1).mean())
        print(f"{label} | {seconds:.2f} | {off:.3f}", flush=True)


def uniform(name, frames, cells, step):
    seconds, x = shipped(name, frames, cells=list(cells), refine=None)
    return f"{cells[0]} x {cells[1]} cells", seconds, coarse(x, cells, step)


def levels(options):
    """Each refined cloth beside a uniform one of about as many particles, in turns, and both against a finer one."""
    for name, first, frames, finest, rivals in (("adaptive", 12, 60, 96, {1: 24, 2: 48}),
                                                ("multi_level", 16, 150, 128, {1: 64, 2: 64})):
        reference = uniform(name, frames, (finest, finest), finest // first)[2]
        scene = json.loads((pathlib.Path(__file__).parent.parent / "data/scenes" / f"{name}.json").read_text())
        refine = scene["geometry"][0]["refine"]
        print(f"{name}: cloth | processor s, median (range) of {options.turns} turns | over the uniform one | "
              "RMS distance to the reference, % of the side, of both | particles")
        for deepest, cells in rivals.items():
            own, other = [], []
            for _ in range(options.turns):
                seconds, x = shipped(name, frames, refine={**refine, "levels": deepest})
                label, rival_seconds, rival = uniform(name, frames, (cells, cells), cells // first)
                own.append(seconds)
                other.append(rival_seconds)
            offs = [rms(places - reference) for places in (x[:(first + 1)**2], rival)]
            print(f"{first} x {first} cells, refined {deepest} times, over {label} | {spread(own)}, {spread(other)} | "
                  f"{spread([a / b for a, b in zip(own, other)])} | {offs[0]:.3f}, {offs[1]:.3f} | {len(x)}", flush=True)


def layers(options):
    frames = 20
    rows = []
    for k in (1, 2, 4, 8):
        seconds, x = shipped("bilayered", frames, cells=[12 * k, 9 * k], pattern="rectangular")
        rows.append((f"plain, {12 * k} x {9 * k} cells", seconds, coarse(x, (12 * k, 9 * k), k)))
    reference = rows[-1][2]
    seconds, x = shipped("bilayered", frames)
    rows.append(("bilayered, 48 x 36 cells", seconds, coarse(x, (48, 36), 4)))
    against("bilayered", rows, reference, 0.8)


VOXELS = (0.25, 0.5, 1.0, 1.4, 2.0, 2.8, 4.0, 8.0, 16.0)  # sides over the typical extent of an edge


def voxels(options):
    """Each step of the scene with another size of voxel: all meet the same states."""
    cells = [options.size - 1, options.size - 1]
    scene = json.loads((pathlib.Path(__file__).parent.parent / "data/scenes/two_sheets_on_ball.json").read_text())
    del scene["$schema"]
    for cloth in scene["geometry"]:
        cloth["cells"] = cells
    frames = int(options.longest * scene["time"]["fps"])
    scene["time"]["frames"] = frames
    seconds, places = {size: [] for size in VOXELS}, {}
    for _, size in itertools.product(range(options.turns), VOXELS):
        scene["contact"] = {"broad_phase": {"type": "voxel", "voxel": size}}
        simulation = selvedge.Simulation(scene)
        simulation.advance_to_frame(frames)
        seconds[size].append(simulation.result()["phase_s"]["broad_phase"])
        places[size] = np.array(simulation.positions)
    print(f"voxel, typical extents | broad phase, s | over that of 2 | positions after {frames} frames")
    for size in VOXELS:
        over = spread([a / b for a, b in zip(seconds[size], seconds[2.0])])
        same = "the same bits" if np.array_equal(places[size], places[2.0]) else "others"
        print(f"{size:g} | {seconds[size][0]:.3f} | {over} | {same}", flush=True)


def maps(options):
    """Each detector in turn on data/validation/depth_maps.json, and on the same sphere moving up and down by 5 cm."""
    scene = json.loads((pathlib.Path(__file__).parent.parent / "data/validation/depth_maps.json").read_text())
    del scene["$schema"]
    scene["geometry"][0]["cells"] = [options.size - 1, options.size - 1]
    moving = [{"time": k / 2, "translation": [0, 0, 0.05 * (k % 2)]} for k in range(12)]
    print("body | detector | processor s, median (range), over the tree | most crossings of a frame, self and body | "
          "RMS distance to the tree, % of the side | the tree, with velocities of another seed")
    for motion in (None, moving):
        if motion:
            scene["obstacles"][0]["motion"] = motion
        seconds, places, crossings = {}, {}, {}
        for turn, detector, seed in itertools.product(range(options.turns), ("bvh_aabb", "depth_normal_maps"), (0, 1)):
            if seed and (turn or detector != "bvh_aabb"):
                continue
            scene["contact"] = {"broad_phase": detector}
            scene["perturbation"] = {"speed": 0.001 * seed, "seed": 1}
            simulation = selvedge.Simulation(scene)
            begin = time.process_time()
            simulation.advance_to_frame(int(options.longest * 60))
            if not seed:
                seconds.setdefault(detector, []).append(time.process_time() - begin)
            places[detector, seed] = np.array(simulation.positions)
            result = simulation.result()
            crossings[detector] = result["worst_self_intersections"], result["worst_body_intersections"]
        tree = places["bvh_aabb", 0]
        for detector, own in seconds.items():
            over = spread([a / b for a, b in zip(own, seconds["bvh_aabb"])])
            print(f"{'moving' if motion else 'at rest'} | {detector} | {spread(own)}, {over} | {crossings[detector]} | "
                  f"{rms(places[detector, 0] - tree):.3f} | {rms(places['bvh_aabb', 1] - tree):.3f}", flush=True)


PARTS = {"maps": maps, "limiters": limiters, "meshes": meshes, "penalty": penalty, "levels": levels, "layers": layers, "voxels": voxels}


def arguments(words=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--size", type=int, default=50, help="particles along a side")
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, help="the same, of part meshes")
    parser.add_argument("--scenes", nargs="+", default=("table", "hung"), choices=("table", "hung"))
    parser.add_argument("--springs", nargs="+", default=("equal k", "equal fabric"), choices=("equal k", "equal fabric"))
    parser.add_argument("--longest", type=float, default=5.0, help="simulated seconds")
    parser.add_argument("--stiffness", type=float, default=1.0, help="of all springs [N/m]")
    parser.add_argument("--integrator", default="implicit_euler")
    return parser.parse_args(words)


def main():
    options = arguments()
    with selvedge.ThreadLimit(1):
        PARTS[options.part](options)


if __name__ == "__main__":
    main()
