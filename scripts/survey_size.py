#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Measures the strain limiters of the survey on its scene and size: 2,500 particles that fall onto a round table.

    PYTHONPATH=build/release/python scripts/survey_size.py [--stiffness K] [--size 50] [--turns N] [--longest S]

C4, C5, C6, Figure 22, Table VI: processor time, sweeps, residual and shape, with as many sweeps as each method needs. The
cloth is at balance when the root of its mean squared speed stays below 5 mm/s. Simulations use one thread; times are those
of the processor, which other programs disturb less than those of the clock.
"""
import argparse
import itertools
import time

import numpy as np
import selvedge

SIDE = 1.0  # m
BOUND = 0.005  # m/s


def table_scene(size, stiffness, solver):
    """A net of equal springs over a round table of 0.3 m."""
    constants = {key: stiffness for key in ("structural", "shear", "flexion")}
    table = {"type": "cylinder", "radius": 0.3, "height": 0.02, "resolution": 96}
    return {
        "geometry": [{
            "name": "cloth", "size": [SIDE, SIDE], "cells": [size - 1, size - 1],
            "pattern": {"type": "rectangular_net", **constants}, "transformation": {"translation": [0, 0, 0.503]},
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

    def __init__(self, description, longest):
        self.simulation = selvedge.Simulation(description)
        begin, step, calm = time.process_time(), 0, 0
        self.until = 0.0  # s, of the last step above the bound
        while step < longest * 60 and (calm < 30 or step < 90):
            self.simulation.step()
            step += 1
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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--size", type=int, default=50, help="particles along a side")
    parser.add_argument("--longest", type=float, default=5.0, help="simulated seconds")
    parser.add_argument("--stiffness", type=float, default=1.0, help="of all springs [N/m]")
    parser.add_argument("--integrator", default="implicit_euler")
    with selvedge.ThreadLimit(1):
        limiters(parser.parse_args())


if __name__ == "__main__":
    main()
