# SPDX-License-Identifier: MIT
"""Shared by the tests of the Python module. CTest sets PYTHONPATH and the variables read here."""

import os
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def rng():
    return np.random.default_rng(20160801)


@pytest.fixture
def program():
    """The program of the same build; results of both must agree to the bit."""
    name = os.environ.get("SELVEDGE_PROGRAM", "")
    if not Path(name).is_file():
        pytest.skip("SELVEDGE_PROGRAM does not name the program of this build")
    return name


def sheet(cells=6, size=0.4, z=0.0):
    """Vertices and triangles of a flat square grid."""
    side = np.linspace(-size / 2, size / 2, cells + 1)
    x, y = np.meshgrid(side, side)
    vertices = np.stack([x.ravel(), y.ravel(), np.full(x.size, z)], axis=1)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    a, b, c, d = corner, corner + 1, corner + cells + 1, corner + cells + 2
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])
    return vertices, triangles.astype(np.int32)


def ball_scene(cells=8, frames=6):
    """A small cloth that falls on a ball."""
    return {
        "name": "small",
        "geometry": [
            {
                "name": "cloth",
                "size": [0.5, 0.5],
                "cells": [cells, cells],
                "transformation": {"translation": [0.01, 0.02, 0.21]},
            }
        ],
        "obstacles": [
            {"name": "ball", "shape": {"type": "sphere", "radius": 0.2, "resolution": 24}}
        ],
        "time": {"frames": frames},
    }
