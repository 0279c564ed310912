#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Figures 10, 11, 12, 21, 22, 27, 28, 45, 46 and Tables II and VI of the survey, on its scene and at its sizes.

    PYTHONPATH=build/release/python bench/survey_figures.py PART... [--folder out/survey_figures] [--seeds 3]

PART, in this order; each prints its figures and writes what `draw` needs into the folder:
nets       Figures 10 to 12, Table II: four nets of equal springs at eight sizes on a table, until balance
limiters   Figures 21 and 22, Table VI: 2,500 particles on the table without a limiter and with five of them
steps      Figure 27: the largest stable step of each integrator, 2,500 particles, ordered position correction
shapes     Figure 28: explicit Euler (survey eq. 14) a little below and above its largest stable step
responses  Figures 45 and 46: penalty springs from small to great, and positions and velocities
penalty    Figure 45: penalty springs alone on the program's cloth, whose exact tests keep it out of the table otherwise
refine     Table II: distance of each net to its finest one, from what nets wrote
draw       docs/images/survey_figures.svg and survey_drapes.png
ji         docs/images/experiment_xii.svg: the two curves of Table XII, from the result folder --result of data/experiments/xii_ji.json

The survey states no sizes in metres, no constants, no damping and no bound of balance; those of survey_size.py stand for
them. Each seed starts with other random velocities of 1 mm/s. Times are those of the processor, of one thread.
"""
import argparse
import itertools
import json
import os
import pathlib
import subprocess
import time

import numpy as np
import selvedge
import survey_size

ROOT = pathlib.Path(__file__).parent.parent
STIFFNESS = 3.0  # N/m, of all springs
LIMITERS = ("position", "ordered_position", "velocity", "position_velocity", "ordered_position_velocity")


def seeded(scene, seed):
    return {**scene, "perturbation": {"speed": 0.001, "seed": seed}} if seed else scene


def keep(folder, name, positions, triangles):
    """The cloth as an OBJ file, which `draw` renders."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in positions]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    (folder / f"{name}.obj").write_text("\n".join(lines) + "\n")


def record(folder, name, value):
    (folder / f"{name}.json").write_text(json.dumps(value))


def recorded(folder, name):
    return json.loads((folder / f"{name}.json").read_text())


def span(values, form="{:.3g}"):
    return survey_size.spread(values, form)


# -- Figures 10 to 12, Table II -------------------------------------------------------------------


def distances(cloths, size):
    """RMS distance of each pair of nets, % of the side: a grid at the places of the particles of the other net."""
    found = {}
    for pair in itertools.combinations(survey_size.NETS, 2):
        at, grid = sorted(pair, key=lambda net: net != "triangular")  # its rows are shifted, so it is no grid
        x = survey_size.at_places(*cloths[grid], size, cloths[at][0][:, :2])
        found[", ".join(pair)] = survey_size.rms(cloths[at][1] - x)
    return found


BOUNDS = (0.05, 0.02)  # m/s, root mean squared speed


def until_balance(simulation, longest, watch=lambda: None):
    """Processor and simulated seconds until the speed has fallen below each bound for good; NaN for a cloth that moves on.

    `watch` is called after each step. Ends once the speed has stayed below the last bound for half a second, or after `longest` seconds.
    """
    begin, calm, step, spent = time.process_time(), 0, 0, [0.0]
    last = dict.fromkeys(BOUNDS, 0)
    while step < longest * 60 and (calm < 30 or step < 60):
        simulation.step()
        step += 1
        watch()
        spent.append(time.process_time() - begin)
        speed = survey_size.rms_speed(simulation)
        last = {bound: step if speed > bound else last[bound] for bound in BOUNDS}
        calm = calm + 1 if speed <= BOUNDS[-1] else 0
    stays = {bound: step - k >= 30 for bound, k in last.items()}
    return ([spent[k] if stays[bound] else float("nan") for bound, k in last.items()],
            [k / 60.0 if stays[bound] else float("nan") for bound, k in last.items()], 1e3 * spent[-1] / step)


def nets(options, folder):
    print(f"particles | seed | net | processor s until {BOUNDS[0]:g} and {BOUNDS[1]:g} m/s | simulated s | ms per step")
    rows = []
    for seed, size in itertools.product(range(options.seeds), options.sizes):
        cloths = {}
        for net in survey_size.NETS:
            scene = survey_size.table_scene(size, options.stiffness, {}, survey_size.net(net + "_net", options.stiffness))
            simulation = selvedge.Simulation(seeded(scene, seed))
            start = np.array(simulation.positions)
            seconds, simulated, per_step = until_balance(simulation, options.longest)
            cloths[net] = start, np.array(simulation.positions)
            if seed == 0:
                keep(folder, f"nets_{net}_{size}", cloths[net][1], simulation.triangles)
            rows.append({"seed": seed, "size": size, "net": net, "seconds": seconds, "simulated": simulated, "ms": per_step})
            print(f"{size**2} | {seed} | {net} | {seconds[0]:.2f}, {seconds[1]:.2f} | {simulated[0]:.2f}, "
                  f"{simulated[1]:.2f} | {per_step:.2f}", flush=True)
        rows[-1]["distances"] = distances(cloths, size)
        record(folder, "nets", rows)
    summary_of_nets(rows)


def summary_of_nets(rows):
    sizes, seeds = sorted({row["size"] for row in rows}), sorted({row["seed"] for row in rows})
    at = {(row["seed"], row["size"], row["net"]): row for row in rows}
    every = list(itertools.product(seeds, sizes))
    pairs = (("triangular", "simplified"), ("simplified", "rectangular"), ("rectangular", "responsive"))
    for k, bound in enumerate(BOUNDS):
        time_of = lambda key, net: at[(*key, net)]["seconds"][k]
        print(f"until {bound:g} m/s, of {len(every)} runs, moving to the end: " + "; ".join(
            f"{net} {sum(np.isnan(time_of(key, net)) for key in every)}" for net in survey_size.NETS))
        for a, b in pairs:
            both = [key for key in every if not np.isnan(time_of(key, a) + time_of(key, b))]
            print(f"until {bound:g} m/s: {a} faster than {b} in {sum(time_of(key, a) < time_of(key, b) for key in both)} of "
                  f"{len(both)}")
        for name, pick in (("least", np.nanargmin), ("greatest", np.nanargmax)):
            found = [survey_size.NETS[pick([time_of(key, net) for net in survey_size.NETS])] for key in every]
            print(f"until {bound:g} m/s, {name} time: " + "; ".join(f"{net} {found.count(net)}" for net in survey_size.NETS))
    for name, pick in (("least", np.argmin), ("greatest", np.argmax)):
        found = [survey_size.NETS[pick([at[(*key, net)]["ms"] for net in survey_size.NETS])] for key in every]
        print(f"a step, {name} time: " + "; ".join(f"{net} {found.count(net)}" for net in survey_size.NETS))
    far = [row["distances"] for row in rows if "distances" in row and row["size"] == 50]
    for pair in far[0] if far else ():
        print(f"2,500 particles, {pair}: RMS distance {span([d[pair] for d in far])} % of the side")
    far = [row["distances"] for row in rows if "distances" in row]
    print(f"of {len(far)} runs: rectangular and simplified the nearest pair "
          f"{sum(min(d, key=d.get) == 'rectangular, simplified' for d in far)}; rectangular and triangular the farthest "
          f"{sum(max(d, key=d.get) == 'rectangular, triangular' for d in far)}")


# -- Figures 21 and 22, Table VI ------------------------------------------------------------------


def square_table():
    """survey_size.table_scene with a square table of the same width, since the text does not say which it is."""
    scene = survey_size.table_scene(50, STIFFNESS, {"strain_limiter": "none"})
    scene["obstacles"][0]["shape"] = {"type": "box", "size": [0.6, 0.6, 0.02]}
    return scene


def strains(x, size):
    """Elongation of the structural springs, %, and the places of their middles in the flat cloth, m."""
    grid, places = x.reshape(size, size, 3), np.linspace(-0.5, 0.5, size) * survey_size.SIDE
    flat = np.stack(np.meshgrid(places, places), axis=-1)
    rest = survey_size.SIDE / (size - 1)
    values, middles = [], []
    for first, second in ((np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1])):
        values.append((np.linalg.norm(grid[first] - grid[second], axis=-1) / rest - 1.0).ravel())
        middles.append((0.5 * (flat[first] + flat[second])).reshape(-1, 2))
    return 100.0 * np.concatenate(values), np.concatenate(middles)


def limiters(options, folder):
    scenes = {f"limiter_{name}": survey_size.table_scene(50, STIFFNESS, {"strain_limiter": name}) for name in LIMITERS}
    scenes["limiter_none"] = survey_size.table_scene(50, STIFFNESS, {"strain_limiter": "none"})
    scenes["square_none"] = square_table()
    print("cloth | seed | processor s until balance | over position | simulated s | RMS distance to position, % of the "
          "side | longest spring % | 99th percentile % | median % | distance of the longest from the middle, m")
    rows = []
    for seed in range(options.seeds):
        base = None
        for name, scene in scenes.items():
            simulation = selvedge.Simulation(seeded(scene, seed))
            seconds, simulated, _ = until_balance(simulation, options.longest)
            x = np.array(simulation.positions)
            base = base or (seconds, x)
            if seed == 0:
                keep(folder, name, x, simulation.triangles)
            stretch, middles = strains(x, 50)
            row = {"seed": seed, "cloth": name, "seconds": seconds, "simulated": simulated, "off": survey_size.rms(x - base[1]),
                   "ratio": [a / b for a, b in zip(seconds, base[0])],
                   "strain_phase": simulation.result()["phase_s"].get("strain", 0.0),
                   "stretch": np.percentile(stretch, [100, 99, 50]).tolist(),
                   "place": np.abs(middles[np.argmax(stretch)]).tolist()}
            rows.append(row)
            record(folder, "limiters", rows)
            print(f"{name} | {seed} | {seconds[0]:.2f}, {seconds[1]:.2f} | {row['ratio'][0]:.3f}, {row['ratio'][1]:.3f} | "
                  f"{simulated[0]:.2f}, {simulated[1]:.2f} | {row['off']:.2f} | "
                  + " | ".join(f"{value:.1f}" for value in row["stretch"])
                  + f" | {np.hypot(*row['place']):.2f} at {row['place'][0]:.2f}, {row['place'][1]:.2f}", flush=True)
    summary_of_ratios("limiters", rows, "cloth")


def summary_of_ratios(title, rows, key):
    for k, bound in enumerate(BOUNDS):
        print(f"{title}, time until {bound:g} m/s over the first: " + "; ".join(
            f"{name} {span([row['ratio'][k] for row in rows if row[key] == name])}"
            for name in dict.fromkeys(row[key] for row in rows)))


# -- Figures 27 and 28 ----------------------------------------------------------------------------

SIX = ("symplectic_euler", "midpoint", "verlet", "runge_kutta_4", "rkf45", "implicit_euler")
STIFF = "1000"  # N/m; with the soft springs of the table the limiter alone would keep any step


def steps(options, folder):
    """The cloth of the table, held by two corners, since `selvedge stability` has no bodies: kicked, and swinging with a limiter or none.

    500 steps each, half a simulated second at most for the adaptive method.
    """
    scene = survey_size.hung_scene(50, STIFFNESS, {}, survey_size.net("rectangular_net", STIFFNESS))
    record(folder, "hung", {"name": "hung", **scene})
    program = os.environ.get("SELVEDGE", ROOT / "build/release/apps/selvedge")
    rows = []
    for damping, limiter, integrator in itertools.product(("0", "0.001"), ("", "none", "ordered_position"), SIX):
        trial = ("--steps", "500") if integrator != "rkf45" else ("--steps", "500", "--seconds", "0.5")
        trial += ("--strain-limiter", limiter) if limiter else ()
        done = subprocess.run([program, "stability", folder / "hung.json", "--integrator", integrator, "--damping", damping,
                               "--stiffness", STIFF, "--precision", "0.03", "--json", *trial], capture_output=True, text=True,
                              check=False)
        if done.returncode > 1:
            raise RuntimeError(done.stderr)
        result = json.loads(done.stdout)["results"][0]
        rows.append({**result, "integrator": integrator, "damping": damping, "limiter": limiter})
        record(folder, "steps", rows)
        print(f"springs damped for {damping} s, {f'swings, limiter {limiter}' if limiter else 'kicked'}: {integrator}: {1e3 * result['measured_s']:.3g} ms", flush=True)


class Net:
    """Survey eq. 2, 6, 8 and 14 on the net of the table, without the program, which divides a step that would diverge."""

    def __init__(self, size):
        grid = np.arange(size * size).reshape(size, size)
        pairs = [(grid[:, 1:], grid[:, :-1]), (grid[1:], grid[:-1]), (grid[1:, 1:], grid[:-1, :-1]),
                 (grid[1:, :-1], grid[:-1, 1:]), (grid[:, 2:], grid[:, :-2]), (grid[2:], grid[:-2])]
        self.a, self.b = (np.concatenate([pair[k].ravel() for pair in pairs]) for k in (0, 1))
        places = np.linspace(-0.5, 0.5, size) * survey_size.SIDE
        self.x = np.stack([*(part.ravel() for part in np.meshgrid(places, places)), np.full(size * size, 0.503)], axis=1)
        self.v = np.zeros_like(self.x)
        self.rest = np.linalg.norm(self.x[self.a] - self.x[self.b], axis=1)
        self.mass = 0.2 * survey_size.SIDE**2 / size**2
        cell = [[0, 1, size], [1, size + 1, size]]
        corners = grid[:-1, :-1].ravel()
        self.triangles = np.concatenate([corners[:, None] + np.array(corner) for corner in cell])

    def sum(self, pulls):
        count = lambda ends, k: np.bincount(ends, pulls[:, k], len(self.x))
        return np.stack([count(self.a, k) - count(self.b, k) for k in range(3)], axis=1)

    def acceleration(self):
        d = self.x[self.a] - self.x[self.b]
        length = np.linalg.norm(d, axis=1, keepdims=True)
        n = d / np.maximum(length, 1e-12)
        rate = ((self.v[self.a] - self.v[self.b]) * n).sum(axis=1, keepdims=True)
        force = self.sum(-STIFFNESS * (length - self.rest[:, None] + DAMPING * rate) * n)
        return (force - 1.6 * survey_size.SIDE**2 / len(self.x) * self.v) / self.mass - [0.0, 0.0, 9.81]

    def step(self, h):
        self.v += h * self.acceleration()
        self.x += h * self.v
        on = (np.hypot(self.x[:, 0], self.x[:, 1]) < 0.3) & (self.x[:, 2] < 0.5) & (self.x[:, 2] > 0.48)
        self.x[on, 2] = 0.5
        self.v[on] = 0.0

    def largest_step(self):
        """h with h^2 w + 2 h DAMPING w = 4, where w is the largest eigenvalue of the flat net, by power iteration."""
        d = (self.x[self.a] - self.x[self.b]) / self.rest[:, None]
        y = np.random.default_rng(1).standard_normal(self.x.shape)
        for _ in range(500):
            pulls = STIFFNESS * ((y[self.a] - y[self.b]) * d).sum(axis=1, keepdims=True) * d
            z = self.sum(pulls) / self.mass
            w = np.linalg.norm(z) / np.linalg.norm(y)
            y = z / np.linalg.norm(z)
        return -DAMPING + np.sqrt(DAMPING**2 + 4.0 / w)


DAMPING = 0.001  # s, as in table_scene


def shapes(options, folder):
    rows = []
    limit = Net(50).largest_step()
    for share in (0.9, 1.0, 1.1):
        net = Net(50)
        count, fastest = int(0.5 / (share * limit)), 0.0
        with np.errstate(all="ignore"):
            for step in range(count):
                net.step(share * limit)
                fastest = max(fastest, np.abs(net.v).max())
                if not fastest < 30.0:
                    break
        stretch = strains(net.x, 50)[0]
        keep(folder, f"step_{share:g}", net.x, net.triangles)
        rows.append({"share": share, "h": share * limit, "steps": step + 1, "fastest": fastest, "stretch": float(stretch.max())})
        print(f"explicit Euler with {share:g} of the largest step of {1e3 * limit:.3f} ms: {step + 1} of {count} steps, "
              f"largest speed {fastest:.3g} m/s, longest spring {stretch.max():.3g} % too long", flush=True)
    record(folder, "shapes", rows)


# -- Figures 45 and 46 ----------------------------------------------------------------------------

STIFFNESSES = (0.1, 1.0, 100.0, 1e4)  # N/m, of penalty


def responses(options, folder):
    scenes = {}
    for name, response in [("position_velocity", "position_velocity"),
                           *((f"penalty_{k:g}", {"type": "penalty", "stiffness": k}) for k in STIFFNESSES)]:
        scene = survey_size.table_scene(50, STIFFNESS, {"strain_limiter": "ordered_position"})
        scene["contact"] = {"response": response}
        scene["time"]["energy_guard"] = False  # it cannot act on penalty
        scenes[name] = scene
    rows = []
    print("response | seed | processor s until balance | over position_velocity | simulated s | time of a step over "
          "position_velocity | deepest in the table, mm | repairs | highest above the start, mm | largest speed, m/s | RMS distance, % of the side")
    for seed in range(options.seeds):
        base = None
        for name, scene in scenes.items():
            simulation = selvedge.Simulation(seeded(scene, seed))
            start, seen = np.array(simulation.positions), [0.0, 0.0]

            def watch():
                seen[0] = max(seen[0], (np.asarray(simulation.positions) - start)[:, 2].max())
                seen[1] = max(seen[1], np.abs(np.asarray(simulation.velocities)).max())

            seconds, simulated, per_step = until_balance(simulation, options.longest, watch)
            x = np.array(simulation.positions)
            base = base or (seconds, x, per_step)
            if seed == 0:
                keep(folder, name, x, simulation.triangles)
            within = (np.hypot(x[:, 0], x[:, 1]) < 0.299) & (x[:, 2] > 0.48)
            counters = simulation.result()["counters"]
            row = {"seed": seed, "name": name, "seconds": seconds, "simulated": simulated, "high": 1e3 * seen[0],
                   "ratio": [a / b for a, b in zip(seconds, base[0])], "fastest": seen[1],
                   "deep": 1e3 * max(0.0, 0.5 - x[within, 2].min()), "step_ratio": per_step / base[2],
                   "repairs": sum(v for key, v in counters.items() if key.startswith("fail_safe")),
                   "off": survey_size.rms(x - base[1])}
            rows.append(row)
            record(folder, "responses", rows)
            print(f"{name} | {seed} | {seconds[0]:.2f}, {seconds[1]:.2f} | {row['ratio'][0]:.2f}, {row['ratio'][1]:.2f} | "
                  f"{simulated[0]:.2f}, {simulated[1]:.2f} | {row['step_ratio']:.2f} | {row['deep']:.2f} | {row['repairs']:.0f} | {row['high']:.1f} | "
                  f"{row['fastest']:.2f} | {row['off']:.2f}", flush=True)
    summary_of_ratios("responses", rows, "name")


def table_springs(x, stiffness):
    """Survey eq. 42: forces on particles within the table, by their depth below its top."""
    inside = (np.hypot(x[:, 0], x[:, 1]) < 0.3) & (x[:, 2] < 0.5) & (x[:, 2] > 0.48)
    return np.outer(np.where(inside, stiffness * (0.5 - x[:, 2]), 0.0), [0.0, 0.0, 1.0])


def penalty(options, folder):
    """One second for each stiffness; the picture is of the moment when the cloth leaves the table by 15 cm, or of the end.

    The program excludes the pair of cloth and table, and the springs are forces of this script, constant during a step.
    """
    rows = []
    for k in STIFFNESSES:
        scene = survey_size.table_scene(50, STIFFNESS, {"strain_limiter": "ordered_position", "integrator": "implicit_euler"})
        scene["contact"] = {"self": False, "pairs": [{"a": "cloth", "b": "table", "collide": False}]}
        scene["time"]["energy_guard"] = False  # it would halve the steps that throw the cloth
        simulation = selvedge.Simulation(scene)
        start, deep, high, fastest, shown = np.array(simulation.positions), 0.0, 0.0, 0.0, False
        middle_of_it = np.hypot(start[:, 0], start[:, 1]) < 0.15
        while simulation.time < 1.0 - 1e-9:
            simulation.set_forces(table_springs(np.asarray(simulation.positions), k))
            simulation.step()
            x = np.array(simulation.positions)
            deep = max(deep, 0.5 - x[middle_of_it, 2].min())
            high = max(high, (x - start)[:, 2].max())
            fastest = max(fastest, np.abs(np.asarray(simulation.velocities)).max())
            if not shown and (max(deep, high) > 0.15 or simulation.time > 1.0 - 1e-9):
                keep(folder, f"alone_{k:g}", x, simulation.triangles)
                shown = True
        result = simulation.result()
        rows.append({"stiffness": k, "deep": deep, "high": high, "fastest": fastest})
        print(f"penalty of {k:g} N/m alone: middle at most {1e3 * deep:.3g} mm below the top, highest particle {1e3 * high:.3g} mm "
              f"above the start, largest speed {fastest:.3g} m/s, {result['steps']} steps, largest stretch "
              f"{100 * result['max_stretch']:.3g} %", flush=True)
    record(folder, "penalty", rows)


# -- drawing --------------------------------------------------------------------------------------

COLOURS = {"rectangular": "#4477aa", "simplified": "#66ccee", "triangular": "#228833", "responsive": "#ee6677"}
WIDTH, LABEL, BAR, ROW = 480, 200, 190, 22


def middle(values):
    found = sorted(value for value in values if not np.isnan(value))
    return (found[len(found) // 2], found[0], found[-1]) if found else (float("nan"),) * 3


def text(x, y, words, more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" {more}>{words}</text>'


def bars(x, y, title, unit, rows, base=0.0):
    """Bars of (name, values) with the range of the values; logarithmic from `base` on, if that is not 0."""
    top = max(middle(values)[2] for _, values in rows)
    share = (lambda v: np.log(v / base) / np.log(top / base)) if base else (lambda v: v / top)
    parts = [text(x, y, title, 'class="title"')]
    for k, (name, values) in enumerate(rows):
        at, (mid, low, high) = y + 12 + ROW * k, middle(values)
        ends = [x + LABEL + BAR * share(v) for v in (mid, low, high)]
        parts += [text(x + LABEL - 8, at + 14, name, 'text-anchor="end"'),
                  f'<rect x="{x + LABEL}" y="{at + 2}" width="{ends[0] - x - LABEL:.1f}" height="{ROW - 6}"/>',
                  f'<line x1="{ends[1]:.1f}" x2="{ends[2]:.1f}" y1="{at + 10}" y2="{at + 10}"/>',
                  text(max(ends) + 5, at + 14, f"{mid:.3g} {unit}" if mid < 999 else "")]
    return parts


def curves(x, y, title, rows, bound):
    """Figure 11: seconds until balance by particles, a curve for each net: median and range of the seeds."""
    width, height = 380.0, 150.0
    sizes = sorted({row["size"] for row in rows})
    points = {net: [middle([r["seconds"][bound] for r in rows if r["net"] == net and r["size"] == size]) for size in sizes]
              for net in survey_size.NETS}
    top = max(value for line in points.values() for _, _, value in line if not np.isnan(value))
    right = lambda size: x + 45 + width * size**2 / sizes[-1] ** 2
    up = lambda value: y + 20 + height * (1.0 - value / top)
    parts = [text(x, y, title, 'class="title"'), text(x + 40, up(0) + 4, "0", 'text-anchor="end"'),
             text(x + 40, up(top) + 4, f"{top:.2g} s", 'text-anchor="end"'),
             f'<line class="axis" x1="{x + 45}" x2="{x + 45 + width}" y1="{up(0)}" y2="{up(0)}"/>',
             f'<line class="axis" x1="{x + 45}" x2="{x + 45}" y1="{up(0)}" y2="{up(top)}"/>']
    parts += [text(right(size), up(0) + 16, f"{size**2:,}", 'text-anchor="middle" font-size="9"') for size in sizes[2:]]
    for k, (net, line) in enumerate(points.items()):
        style = f'style="stroke:{COLOURS[net]}"'
        known = [(right(size), point) for size, point in zip(sizes, line) if not np.isnan(point[0])]
        path = " ".join(f"{at:.1f},{up(mid):.1f}" for at, (mid, _, _) in known)
        parts += [f'<polyline points="{path}" fill="none" stroke-width="2" {style}/>',
                  text(x + 70 + 100 * k, up(0) + 32, net, f'style="fill:{COLOURS[net]}"')]
        parts += [f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{up(low):.1f}" y2="{up(high):.1f}" {style}/>'
                  for at, (_, low, high) in known]
    return parts


def ratios(rows, key, bound, names):
    return [(name, [row["ratio"][bound] for row in rows if row[key] == name]) for name in names]


def draw_curves(folder):
    nets_rows, limits, found = recorded(folder, "nets"), recorded(folder, "limiters"), recorded(folder, "steps")
    far = [row["distances"] for row in nets_rows if "distances" in row and row["size"] == 50]
    limits_27 = [(row["integrator"] + (" (any)" if row["measured_s"] > 0.3 else ""), [1e3 * row["measured_s"]])
                 for row in found if row["damping"] == "0" and row.get("limiter") == "ordered_position"]
    answers = recorded(folder, "responses")
    parts = [
        *curves(15, 30, f"Figure 11: time until {BOUNDS[0]:g} m/s by particles", nets_rows, 0),
        *bars(WIDTH + 15, 30, "Figure 12: distance, 2,500 particles", "%", [(pair, [d[pair] for d in far]) for pair in far[0]]),
        *bars(15, 280, "Figure 22: time until balance over “position”", "",
              [(name.removeprefix("limiter_"), values) for name, values in
               ratios(limits, "cloth", 0, [f"limiter_{name}" for name in LIMITERS])]),
        *bars(WIDTH + 15, 280, "Figure 27: largest stable step (logarithmic)", "ms", limits_27, 0.003),
        *bars(15, 445, "Figure 46: time of a step over “position_velocity”", "",
              [(name, [row["step_ratio"] for row in answers if row["name"] == name])
               for name in dict.fromkeys(row["name"] for row in answers)]),
    ]
    head = (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {2 * WIDTH + 20} 610" font-family="sans-serif" '
            'font-size="12">', "<style>.title{font-size:14px;font-weight:bold} rect{fill:#4477aa} line{stroke:#222} "
            ".axis{stroke:#888}</style>", f'<rect width="{2 * WIDTH + 20}" height="610" style="fill:#ffffff"/>')
    (ROOT / "docs/images/survey_figures.svg").write_text("\n".join([*head, *parts, "</svg>", ""]))


TILE = 120  # pixels


def picture(folder, name, top, size=TILE):
    x, triangles = mesh_of(folder, name)
    eye = [0.0, -0.01, 3.4] if top else [0.0, -3.2, 0.9]
    return selvedge.render(np.clip(x, -2.0, 2.0), triangles, eye=eye, target=[0.0, 0.0, 0.35], field_of_view=19.0,
                           width=size, height=size, ground=False)


def draw_drapes(folder):
    """Table II, then Table VI with no limiter last, then Figures 10, 21, 28, 45 and 46, row by row."""
    rows = [[(f"nets_{net}_{size}", True) for size in survey_size.SIZES[::-1]]
            for net in ("responsive", "triangular", "simplified", "rectangular")]
    limited = [f"limiter_{name}" for name in (*LIMITERS, "none")]
    rows += [[(name, top) for name in limited] for top in (False, True)]
    rows += [[("nets_rectangular_59", False), ("nets_rectangular_59", True), ("limiter_none", True), ("square_none", True),
              ("step_1.1", False), ("step_0.9", False)],
             [("penalty_0.1", False), ("penalty_10000", False), ("penalty_100", False), ("position_velocity", False),
              ("penalty_100", True), ("position_velocity", True)],
             [(f"alone_{k:g}", False) for k in STIFFNESSES]]
    width = max(len(row) for row in rows)
    empty = np.full((TILE, TILE, 3), 255, np.uint8)
    tiles = [np.concatenate([*(picture(folder, *cell) for cell in row), *[empty] * (width - len(row))], axis=1) for row in rows]
    selvedge.write_png(ROOT / "docs/images/survey_drapes.png", np.concatenate(tiles))


def ji(options, folder):
    """Table XII: growth of the area and mean strain of the springs against time, of `selvedge measure` in --result."""
    lines = (options.result / "measures/energy.csv").read_text().splitlines()
    names = lines[0].split(",")
    table = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    t = table[:, names.index("time_s")]
    parts, width, height = [], 700.0, 170.0
    for k, (key, title) in enumerate((("area_growth", "growth of the summed area"), ("strain_mean", "mean strain of the springs"))):
        values, top = 100.0 * table[:, names.index(key)], 30 + k * 220
        low, high = min(0.0, values.min()), values.max()
        right = lambda time: 60 + width * time / t[-1]
        up = lambda value: top + 20 + height * (high - value) / (high - low)
        path = " ".join(f"{right(time):.1f},{up(value):.1f}" for time, value in zip(t, values))
        parts += [text(15, top, f"Table XII: {title}, %", 'class="title"'),
                  f'<line class="axis" x1="60" x2="{60 + width}" y1="{up(0.0):.1f}" y2="{up(0.0):.1f}"/>',
                  text(55, up(high) + 4, f"{high:.3f}", 'text-anchor="end"'), text(55, up(0.0) + 4, "0", 'text-anchor="end"'),
                  f'<polyline points="{path}" fill="none" stroke-width="1.5" style="stroke:#4477aa"/>']
        for time, words in ((1.5, "wind begins"), (5.0, "wind ends")):
            parts += [f'<line class="axis" x1="{right(time)}" x2="{right(time)}" y1="{top + 20}" y2="{top + 20 + height}"/>',
                      text(right(time) + 4, top + 32, f"{words}, {time:g} s")]
    head = ('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 790 450" font-family="sans-serif" font-size="12">',
            "<style>.title{font-size:14px;font-weight:bold} .axis{stroke:#888}</style>",
            '<rect width="790" height="450" style="fill:#ffffff"/>')
    (ROOT / "docs/images/experiment_xii.svg").write_text("\n".join([*head, *parts, "</svg>", ""]))


def draw(options, folder):
    draw_curves(folder)
    draw_drapes(folder)


def mesh_of(folder, name):
    lines = [line.split() for line in (folder / f"{name}.obj").read_text().splitlines()]
    return (np.array([[float(word) for word in line[1:]] for line in lines if line[0] == "v"]),
            np.array([[int(word) - 1 for word in line[1:]] for line in lines if line[0] == "f"]))


def flat_grid(size):
    places = np.linspace(-0.5, 0.5, size) * survey_size.SIDE
    return np.stack([part.ravel() for part in np.meshgrid(places, places)], axis=1)


def refine(options, folder):
    """Table II: how far each grid is from that of 3,481 particles, at its own particles, without a seed."""
    finest = survey_size.SIZES[-1]
    for net in ("rectangular", "simplified", "responsive"):
        fine = mesh_of(folder, f"nets_{net}_{finest}")[0]
        far = []
        for size in survey_size.SIZES[:-1]:
            x = mesh_of(folder, f"nets_{net}_{size}")[0]
            start = np.column_stack([flat_grid(finest), np.zeros(finest**2)])
            far.append(f"{survey_size.rms(x - survey_size.at_places(start, fine, finest, flat_grid(size))):.2f}")
        print(f"{net}, 100 to 3,136 particles: RMS distance to 3,481 particles, % of the side: {', '.join(far)}", flush=True)


PARTS = {"nets": nets, "limiters": limiters, "steps": steps, "shapes": shapes, "responses": responses, "penalty": penalty, "refine": refine,
         "draw": draw, "ji": ji}


def arguments(words=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="+", choices=PARTS)
    parser.add_argument("--folder", type=pathlib.Path, default=ROOT / "out/survey_figures")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--sizes", type=int, nargs="+", default=survey_size.SIZES, help="particles along a side")
    parser.add_argument("--longest", type=float, default=5.0, help="simulated seconds")
    parser.add_argument("--stiffness", type=float, default=30.0, help="of part nets [N/m]")
    parser.add_argument("--result", type=pathlib.Path, default=ROOT / "out/experiments/xii_ji", help="of part ji")
    return parser.parse_args(words)


def main():
    options = arguments()
    options.folder.mkdir(parents=True, exist_ok=True)
    with selvedge.ThreadLimit(1):
        for part in options.parts:
            PARTS[part](options, options.folder)


if __name__ == "__main__":
    main()
