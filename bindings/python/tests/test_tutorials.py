# SPDX-License-Identifier: MIT
"""The tutorials run in a short form and do what they say."""

import importlib.util
import subprocess
import sys

import numpy as np
import pytest
import selvedge

from conftest import ROOT, sheet

TUTORIALS = ROOT / "bindings" / "python" / "tutorials"


def load(name):
    spec = importlib.util.spec_from_file_location(name, TUTORIALS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_compare_detectors(tmp_path, capsys):
    tutorial = load("compare_detectors")
    exact, rows = tutorial.main(["--cells", "12", "--repeats", "1", "--out", str(tmp_path)])
    assert exact > 0 and len(rows) > 5
    promises = {m["name"]: m["promise"] for m in selvedge.list_methods()}
    for name, _, found, _ in rows:
        assert found == exact or "misses nothing" not in promises[name]
    svg = (tmp_path / "detectors.svg").read_text()
    assert svg.count("<rect") == len(rows) + 1 and "bvh_aabb" in svg
    assert "bvh_aabb" in capsys.readouterr().out


def test_compare_detectors_on_meshes_of_ones_own(tmp_path):
    x, t = sheet(4)
    lines = [f"v {a} {b} {c}" for a, b, c in x] + ["f " + " ".join(str(i + 1) for i in f) for f in t]
    (tmp_path / "body.obj").write_text("\n".join(lines))
    lines[: len(x)] = [f"v {a} {b} 0.005" for a, b, _ in x]
    (tmp_path / "cloth.obj").write_text("\n".join(lines))
    files = ["--cloth", str(tmp_path / "cloth.obj"), "--body", str(tmp_path / "body.obj")]
    exact, _ = load("compare_detectors").main([*files, "--out", str(tmp_path), "--repeats", "1"])
    assert exact > 0


def test_contact_pressure(tmp_path):
    tutorial = load("contact_pressure")
    simulation, pressure, weight = tutorial.main(
        ["--cells", "14", "--frames", "40", "--width", "160", "--out", str(tmp_path / "new" / "folder")]
    )
    assert simulation.clean and (pressure >= 0.0).all() and pressure.max() > 0.0
    assert (tmp_path / "new" / "folder" / "contact_pressure.png").stat().st_size > 1000
    assert weight > 0.0 and np.isfinite(tutorial.carried(simulation))


def test_the_carried_force_is_the_weight_after_a_joined_step():
    cloth = {"size": [0.2, 0.2], "cells": [4, 4], "transformation": {"translation": [0, 0, 0.0522]}}
    table = {"shape": {"type": "box", "size": [1, 1, 0.1]}}
    simulation = selvedge.Simulation({"geometry": [cloth], "obstacles": [table]})
    simulation.advance_to_frame(60)
    assert simulation.last_step == pytest.approx(2.0 * simulation.scene.step_length)
    weight = 9.81 * simulation.mass.sum()
    assert load("contact_pressure").carried(simulation) == pytest.approx(weight, rel=0.05)


def test_learning_loop(tmp_path):
    command = [sys.executable, "-B", TUTORIALS / "learning_loop.py", "--scenes", "60", "--out", tmp_path]
    out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert "60 scenes" in out
    error, baseline = (float(part.split()[0]) for part in out.split("\n")[1].split(": ")[1:])
    assert error < baseline
    assert (tmp_path / "learning_loop.svg").read_text().count("<circle") == 15


def test_cloth_tasks(tmp_path, capsys):
    rows = load("cloth_tasks").main(["--task", "fold", "--seeds", "1", "--picture", str(tmp_path / "out")])
    assert [row["success"] for row in rows] == [True] and rows[0]["clean"]
    assert (tmp_path / "out" / "cloth_tasks.png").stat().st_size > 1000
    assert "fold: 1 of 1 succeed" in capsys.readouterr().out
