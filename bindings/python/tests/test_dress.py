# SPDX-License-Identifier: MIT
"""Garments from sewing patterns: the same as those of the program, and through poses from arrays."""

import json
import subprocess

import numpy as np
import pytest

import selvedge
from conftest import ROOT

PATTERN = ROOT / "data/patterns/flared_skirt.json"
BODY = ROOT / "data/bodies/mannequin_arms_out.ply"
COARSE = {"resolution": 0.06, "up": "z", "pictures": False}


def test_a_garment_is_that_of_the_program(tmp_path, program):
    made = selvedge.dress(PATTERN, BODY, tmp_path / "python", **COARSE)
    subprocess.run(
        [program, "dress", PATTERN, BODY, "--out", tmp_path / "program", "--resolution", "0.06",
         "--up", "z", "--no-pictures"],
        check=True,
        capture_output=True,
    )
    ours = json.loads((tmp_path / "python/result.json").read_text())
    other = json.loads((tmp_path / "program/result.json").read_text())
    assert made["clean"] and made["worn"]
    assert made["state_hash"] == ours["state_hash"] == other["state_hash"]
    garment = made["garment"]
    assert garment["x"].shape == (made["vertices"], 3)
    assert garment["triangles"].shape == garment["flat_triangles"].shape
    assert len(garment["panel_of_triangle"]) == made["triangles"]
    assert garment["panel_of_triangle"].max() == len(garment["panels"]) - 1
    assert len(selvedge.find_crossings(garment["x"], garment["triangles"])) == 0
    waist = next(zone for zone in made["fit"] if zone["zone"] == "waist")
    assert waist["body_girth_m"] > 0.4


def test_a_garment_follows_poses_from_arrays(tmp_path):
    body = selvedge.dress(PATTERN, BODY, tmp_path / "first", **COARSE)["garment"]["body_x"]
    triangles = body_triangles(BODY)
    poses = [(body + [0.0, 0.01 * k, 0.0], triangles) for k in (1, 2)]
    made = selvedge.dress(PATTERN, (body, triangles), tmp_path / "posed", poses=poses,
                          pose_formats=("gltf", "usd", "pc2"), **COARSE)
    motion = tmp_path / "posed/motion"
    assert all((motion / name).exists() for name in ("result.glb", "result.usda", "cloth.pc2"))
    assert len(made["motion"]["poses"]) == 2
    assert sorted(p.name for p in (tmp_path / "posed/poses").iterdir()) == ["0000.obj", "0001.obj"]


def body_triangles(file):
    """Of a PLY file, as text or binary, by way of the program's own reader in a scene."""
    scene = {
        "geometry": [{"size": [0.1, 0.1], "cells": [2, 2],
                      "transformation": {"translation": [0.0, 0.0, 5.0]}}],
        "obstacles": [{"name": "body", "mesh": str(file), "up": "z"}],
    }
    return selvedge.Simulation(scene).body_triangles.copy()


def test_errors_are_sentences(tmp_path):
    with pytest.raises(ValueError, match="up is"):
        selvedge.dress(PATTERN, BODY, tmp_path / "a", up="w")
    with pytest.raises(ValueError, match="missing.json"):
        selvedge.dress(tmp_path / "missing.json", BODY, tmp_path / "b")
    with pytest.raises(RuntimeError, match="stand"):
        far = (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.7]]) + [50.0, 0.0, 0.0],
               np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], dtype=np.int32))
        selvedge.dress(PATTERN, far, tmp_path / "c", **COARSE)
