#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compares selvedge.find_collisions with the C++ call on the same arrays: a cloth of 100 x 100 particles
that falls onto a ball of 30,420 faces.

    PYTHONPATH=build/release/python bench/python_overhead.py [BUILD_DIR] [--rounds 15] [--cores 1]

Builds nothing: needs the targets selvedge_python and selvedge_bench. Rounds of both alternate, so that
a disturbance of the machine affects both; prints the median and the shortest call of each, by the clock and
in processor time. The processor time of one core (the default) changes little if other programs run.
"""

import argparse
import os
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import selvedge

ROOT = Path(__file__).resolve().parents[1]
CALLS = 10  # of a round


def falling_cloth():
    """A step of the scene cloth_on_sphere without contacts: the cloth passes through the ball."""
    simulation = selvedge.Simulation(ROOT / "data/scenes/cloth_on_sphere.json")
    simulation.advance_to_frame(6)
    x0 = simulation.positions.copy()
    x1 = x0 - [0, 0, 0.01]
    body = simulation.body_positions.copy(), simulation.body_triangles.copy()
    return x0, x1, simulation.triangles.copy(), body


def write(file, x0, x1, triangles, body):
    counts = np.array([len(x0), len(triangles), len(body[0]), len(body[1])], dtype=np.int64)
    parts = [counts, x0, x1, body[0], triangles, body[1]]
    Path(file).write_bytes(b"".join(part.tobytes() for part in parts))


def from_python(x0, x1, triangles, body):
    times = []
    for _ in range(CALLS):
        begin = time.perf_counter(), time.process_time()
        table = selvedge.find_collisions(x0, x1, triangles, body)
        end = time.perf_counter(), time.process_time()
        times.append([1e3 * (b - a) for a, b in zip(begin, end)])
    return times, len(table)


def from_program(program, file):
    out = subprocess.run([program, "find_collisions", file, str(CALLS)], check=True, capture_output=True, text=True)
    *times, found = out.stdout.splitlines()
    return [[float(t) for t in row.split()] for row in times], int(found)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", nargs="?", default="build/release")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--cores", type=int, default=1, help="cores that both may use; 0: all")
    options = parser.parse_args()
    if options.cores > 0:
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: options.cores])
    program = ROOT / options.build / "bench" / "bench"
    case = falling_cloth()
    times = {"C++": [], "Python": []}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "case.bin"
        write(file, *case)
        for _ in range(options.rounds):
            ms, found = from_program(program, file)
            times["C++"] += ms[1:]  # without the first, cold call
            ms, same = from_python(*case)
            times["Python"] += ms[1:]
            if found != same:
                raise SystemExit(f"C++ finds {found} collisions, Python {same}")
    print(f"{len(case[0])} vertices against {len(case[3][1])} triangles: {found} collisions")
    for k, clock in enumerate(("by the clock", "processor")):
        ms = {name: np.array(rows)[:, k] for name, rows in times.items()}
        for name, column in ms.items():
            print(f"{clock:12} {name:6} median {np.median(column):8.3f} ms   shortest {column.min():8.3f} ms")
        for what, of in (("median", np.median), ("shortest", np.min)):
            print(f"{clock:12} {what}: Python costs {100 * (of(ms['Python']) / of(ms['C++']) - 1):+.1f} %")


if __name__ == "__main__":
    main()
