# SPDX-License-Identifier: MIT
"""Learns how far a cloth sags from 200 small simulations on two processes.

    python3 learning_loop.py [--scenes 200] [--processes 2] [--out FOLDER]

Each scene hangs a cloth by two corners. Its density, bending stiffness and size are drawn at random, and
a side wind is set from Python in every step. A linear model of simple features is fitted to three quarters of the
outcomes and tested on the rest. Prints scenes a second and the error of the test; writes learning_loop.svg.
"""

import argparse
import multiprocessing
import time
from pathlib import Path

import numpy as np
import selvedge

FRAMES = 30
CELLS = 8


def draw(seed):
    """The parameters of a scene: density kg/m², bending stiffness N·m, side m, wind N/m²."""
    rng = np.random.default_rng(seed)
    return np.array(
        [rng.uniform(0.1, 0.4), 10 ** rng.uniform(-6, -4), rng.uniform(0.3, 0.6), rng.uniform(0, 1)]
    )


def simulate(seed):
    """Runs the scene of a seed: its parameters, and the mean displacement (3,) of the cloth in metres."""
    density, bending, side, wind = parameters = draw(seed)
    scene = {
        "geometry": [{"name": "cloth", "size": [side, side], "cells": [CELLS, CELLS]}],
        "materials": {"default": {"density": density, "bending_stiffness": bending}},
        "handles": [{"geometry": "cloth", "select": ["x0y1", "x1y1"]}],
        "air": {"viscous_drag": 0.4},
    }
    with selvedge.ThreadLimit(1):  # one scene in each process
        simulation = selvedge.Simulation(scene)
        start = simulation.positions.copy()
        force = np.zeros_like(start)
        force[:, 0] = wind * side**2 / len(start)

        def blow(now):
            now.set_forces(force * (1.0 + 0.3 * np.sin(20.0 * now.time)))

        simulation.advance_to_frame(FRAMES, before_step=blow)
        if not simulation.clean:
            raise RuntimeError(f"scene {seed} is not clean")
        return parameters, (simulation.positions - start).mean(axis=0)


def features(parameters):
    """(n, k): a constant, the parameters on useful scales, and their products."""
    density, bending, side, wind = parameters.T
    base = np.stack([1 / density, np.log10(bending), side, wind], axis=1)
    base = (base - base.mean(axis=0)) / base.std(axis=0)
    products = [base[:, i] * base[:, j] for i in range(4) for j in range(i, 4)]
    return np.column_stack([np.ones(len(base)), base, *products])


def plot(file, truth, predicted):
    """Predicted against simulated displacements, in centimetres, as SVG."""
    size, margin = 360, 56
    values = 100.0 * np.concatenate([truth, predicted])
    low, high = values.min(), values.max()

    def place(v):
        return margin + (size - 2 * margin) * (100.0 * v - low) / max(high - low, 1e-12)

    dots = "".join(
        f'<circle cx="{place(t):.1f}" cy="{size - place(p):.1f}" r="3.5" fill="#34658c"/>'
        for t, p in zip(truth, predicted)
    )
    a, b = margin, size - margin
    Path(file).write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size} {size}" font-family="sans-serif" '
        f'font-size="14"><rect width="100%" height="100%" fill="white"/>'
        f'<path d="M{a} {a}V{b}H{b}" fill="none" stroke="black"/>'
        f'<path d="M{a} {b}L{b} {a}" stroke="#b03020"/>{dots}'
        f'<text x="{size / 2}" y="{size - 14}" text-anchor="middle">simulated sag, '
        f"{low:.0f} to {high:.0f} cm</text>"
        f'<text x="22" y="{size / 2}" text-anchor="middle" transform="rotate(-90 22 {size / 2})">'
        "predicted sag</text></svg>\n"
    )


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", default=".")
    options = parser.parse_args(arguments)
    Path(options.out).mkdir(parents=True, exist_ok=True)
    begin = time.perf_counter()
    # "spawn": the threads of a process do not survive its copy.
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool:
        outcomes = pool.map(simulate, range(options.scenes), chunksize=4)
    seconds = time.perf_counter() - begin
    parameters = np.array([p for p, _ in outcomes])
    sag = -np.array([moved for _, moved in outcomes])[:, 2]
    inputs = features(parameters)
    train = np.arange(len(sag)) % 4 != 0
    model, *_ = np.linalg.lstsq(inputs[train], sag[train], rcond=None)
    predicted = inputs[~train] @ model
    error = np.abs(predicted - sag[~train])
    baseline = np.abs(sag[train].mean() - sag[~train])
    print(f"{len(sag)} scenes in {seconds:.1f} s, {len(sag) / seconds:.1f} a second")
    print(f"mean error of the test: {100 * error.mean():.2f} cm; of the mean: {100 * baseline.mean():.2f} cm")
    plot(Path(options.out) / "learning_loop.svg", sag[~train], predicted)
    return error.mean(), baseline.mean()


if __name__ == "__main__":
    main()
