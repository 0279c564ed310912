#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""How much work a scene could leave out if its pieces of cloth slept one by one (docs/lab/integrators.md, Sleep).

    PYTHONPATH=build/release/python bench/island_share.py SCENE... [--speed M_PER_S]

Prints the share of particles times frames in pieces that have stayed slower than --speed for half a second while another
piece moves. Pieces are what triangles connect. A piece that touches the moving one would have to stay awake but counts, too:
the shares are bounds from above. Scenes of one piece are left out.
"""
import argparse
import json
import pathlib
import sys

import numpy as np
import selvedge

STILL = 0.5  # s, as in simulation/detail/sleep.cpp


def piece_of(vertices, triangles):
    """The smallest vertex of the piece of each vertex."""
    piece = np.arange(vertices)
    while True:
        least = piece[triangles].min(1)
        before = piece.copy()
        for corner in triangles.T:
            np.minimum.at(piece, corner, least)
        if (piece == before).all():
            return piece


def share(file, speed):
    """Number of pieces and share of a scene."""
    simulation = selvedge.Simulation(str(file))
    time = json.loads(file.read_text())["time"]
    still, alone, all_frames = None, 0, 0
    for frame in range(1, time["frames"] + 1):
        simulation.advance_to_frame(frame)
        fast = np.linalg.norm(simulation.velocities, axis=1) > speed
        if still is None or len(still) != len(fast):  # the first frame, or seams have closed
            piece, still = piece_of(len(fast), np.asarray(simulation.triangles)), np.zeros(len(fast))
        moves = np.zeros(len(fast), bool)
        np.logical_or.at(moves, piece, fast)
        still = np.where(moves[piece], 0.0, still + 1.0 / time.get("fps", 60))
        asleep = still >= STILL
        alone += 0 if asleep.all() else asleep.sum()
        all_frames += len(fast)
    return len(np.unique(piece)), alone / all_frames


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="+", type=pathlib.Path)
    parser.add_argument("--speed", type=float, default=0.01, help="m/s (default: 0.01)")
    options = parser.parse_args()
    for file in options.scene:
        if len(json.loads(file.read_text()).get("geometry", [])) < 2:
            continue
        try:
            pieces, of_all = share(file, options.speed)
        except (ValueError, RuntimeError) as error:
            print(f"island_share.py: {file}: {error}", file=sys.stderr)
            continue
        print(f"{file}: {pieces} pieces, {100 * of_all:.1f} %", flush=True)


if __name__ == "__main__":
    main()
