#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compares selvedge.find_collisions with the C++ call on the same arrays: a cloth of 100 x 100 particles
that falls onto a ball of 30,420 faces.

    PYTHONPATH=build/release/python scripts/python_overhead.py [BUILD_DIR] [--rounds 15]

Builds nothing: needs the targets selvedge_python and bench_find_collisions. Rounds of both alternate, so that
a disturbance of the machine affects both; prints the median and the shortest call of each.
"""

import argparse
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
        begin = time.perf_counter()
        table = selvedge.find_collisions(x0, x1, triangles, body)
        times.append(1e3 * (time.perf_counter() - begin))
    return times, len(table)


def from_program(program, file):
    out = subprocess.run([program, file, str(CALLS)], check=True, capture_output=True, text=True)
    *times, found = out.stdout.split()
    return [float(t) for t in times], int(found)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", nargs="?", default="build/release")
    parser.add_argument("--rounds", type=int, default=15)
    options = parser.parse_args()
    program = ROOT / options.build / "bench" / "bench_find_collisions"
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
    for name, ms in times.items():
        print(f"{name:8} median {np.median(ms):8.3f} ms   shortest {min(ms):8.3f} ms")
    for what, of in (("median", np.median), ("shortest", min)):
        print(f"{what}: Python costs {100 * (of(times['Python']) / of(times['C++']) - 1):+.1f} %")


if __name__ == "__main__":
    main()
