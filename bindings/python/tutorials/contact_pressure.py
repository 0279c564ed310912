# SPDX-License-Identifier: MIT
"""Drapes a cloth over a ball on a stand, reads the contact pressure and draws it.

    python3 contact_pressure.py [--cells 60] [--frames 120] [--out FOLDER]

Prints the weight of the cloth, the force that the body carries, and the largest pressure; writes
contact_pressure.png, in which the cloth is coloured from grey (no contact) to red (the 98th percentile).
"""

import argparse
from pathlib import Path

import numpy as np
import selvedge

COLOURS = 12


def scene(cells):
    return {
        "geometry": [
            {
                "name": "cloth",
                "size": [0.8, 0.8],
                "cells": [cells, cells],
                "transformation": {"translation": [0, 0, 0.68]},
            }
        ],
        "obstacles": [
            {
                "name": "ball",
                "shape": {"type": "sphere", "radius": 0.16, "resolution": 96},
                "transformation": {"translation": [0, 0, 0.5]},
            }
        ],
        "materials": {"default": {"density": 0.2, "bending_stiffness": 1e-5}},
        "air": {"normal_drag": 1, "viscous_drag": 0.3},
    }


def mean_pressure(simulation, steps):
    """Pascals, mean over some steps: a single step shows single contacts."""
    total = np.zeros(len(simulation.positions))
    for _ in range(steps):
        simulation.step()
        total += simulation.contact_pressure()
    return total / steps


def coloured(simulation, pressure):
    """The cloth in parts (vertices, triangles, colour) by the pressure of their corners."""
    scale = max(np.percentile(pressure[pressure > 0.0], 98), 1e-12)
    of_triangle = pressure[simulation.triangles].mean(axis=1)
    level = np.minimum((COLOURS * of_triangle / scale).astype(int), COLOURS - 1)
    grey, red = np.array([0.45, 0.45, 0.45]), np.array([0.60, 0.02, 0.01])
    parts = []
    for k in np.unique(level):
        s = k / (COLOURS - 1)
        triangles = simulation.triangles[level == k]
        used, corners = np.unique(triangles, return_inverse=True)
        parts.append(
            (
                simulation.positions[used],
                corners.reshape(-1, 3).astype(np.int32),
                tuple((1 - s) * grey + s * red),
            )
        )
    return parts


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cells", type=int, default=60, help="of the cloth on a side")
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--width", type=int, default=840, help="pixels of the picture")
    parser.add_argument("--out", default=".")
    options = parser.parse_args(arguments)
    Path(options.out).mkdir(parents=True, exist_ok=True)
    simulation = selvedge.Simulation(scene(options.cells))
    simulation.advance_to_frame(options.frames)
    pressure = mean_pressure(simulation, 8)
    contacts = simulation.contacts()
    weight = 9.81 * simulation.mass.sum()
    print(f"clean: {simulation.clean}, {len(contacts['gap'])} contacts in the last step")
    print(f"weight {weight:.3f} N; the last step presses with {carried(simulation):.3f} N on the ball")
    print(f"largest mean pressure {pressure.max():.1f} Pa, on {np.sum(pressure > 0)} vertices")
    first, *others = coloured(simulation, pressure)
    picture = selvedge.render(
        first[0],
        first[1],
        colour=first[2],
        bodies=[*others, (simulation.body_positions, simulation.body_triangles)],
        eye=(0.9, -1.1, 1.35),
        target=(0, 0, 0.5),
        field_of_view=35,
        width=options.width,
        height=3 * options.width // 4,
    )
    selvedge.write_png(Path(options.out) / "contact_pressure.png", picture)
    return simulation, pressure, weight


def carried(simulation):
    """Newtons, upwards: the sum of the impulses of the last step on the cloth, over its length."""
    table = simulation.contacts()
    n = len(simulation.positions)
    first_is_cloth = table["vertices"][:, 0] < n
    last_is_cloth = table["vertices"][:, 3] < n
    sign = np.where(first_is_cloth, 1.0, -1.0)
    with_body = first_is_cloth != last_is_cloth
    return float((sign * table["impulse"][:, 2])[with_body].sum() / simulation.last_step)


if __name__ == "__main__":
    main()
