# SPDX-License-Identifier: MIT
"""Lets the scripted policies of `selvedge.tasks` handle cloth, and counts their successes.

    python3 cloth_tasks.py [--task fold] [--seeds 20] [--first 0] [--picture FOLDER]

Prints a row for each episode: whether it succeeds, whether all steps are clean, what the task measures, and steps a second.
With --picture it writes FOLDER/cloth_tasks.png: four moments of the first episode of each task.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import selvedge
from selvedge import tasks

MOMENTS = (0.15, 0.35, 0.6, 1.0)  # of an episode
WIDTH, HEIGHT = 320, 240


def draw(task):
    simulation = task.simulation
    bodies = [(simulation.body_positions, simulation.body_triangles)]
    return selvedge.render(simulation.positions, simulation.triangles, bodies=bodies, width=WIDTH, height=HEIGHT)


def episode(name, seed, pictures=None):
    """Runs one episode: a row of its outcome."""
    task = tasks.TASKS[name]()
    moments = [max(1, round(share * task.steps)) for share in MOMENTS]
    done = [0]

    def watch(now):
        done[0] += 1
        if pictures is not None and done[0] in moments:
            pictures.append(draw(now))

    begin = time.perf_counter()
    success = task.run(seed, watch)
    seconds = time.perf_counter() - begin
    return {
        "task": name,
        "seed": seed,
        "success": success,
        "clean": task.simulation.clean,
        "steps_per_s": task.simulation.steps / seconds,
        **task.measure(),
    }


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--task", choices=sorted(tasks.TASKS), help="one task; default: all")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--picture", help="folder of the picture")
    options = parser.parse_args(arguments)
    rows, strips = [], []
    for name in [options.task] if options.task else tasks.TASKS:
        for seed in range(options.first, options.first + options.seeds):
            pictures = [] if options.picture and seed == options.first else None
            row = episode(name, seed, pictures)
            rows.append(row)
            if pictures:
                strips.append(np.concatenate(pictures, axis=1))
            print("  ".join(f"{k} {v:.3g}" if isinstance(v, float) else f"{k} {v}" for k, v in row.items()), flush=True)
        own = [r for r in rows if r["task"] == name]
        print(f"{name}: {sum(r['success'] for r in own)} of {len(own)} succeed, "
              f"{sum(r['clean'] for r in own)} are clean")
    if strips:
        Path(options.picture).mkdir(parents=True, exist_ok=True)
        selvedge.write_png(Path(options.picture) / "cloth_tasks.png", np.concatenate(strips, axis=0))
    return rows


if __name__ == "__main__":
    main()
