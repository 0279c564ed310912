# SPDX-License-Identifier: MIT
"""Scenes and simulations in memory: the program's bits, and arrays in and out."""

import json
import re
import subprocess

import numpy as np
import pytest
import selvedge

from conftest import ROOT, ball_scene, sheet

FOLDER = ROOT / "data" / "scenes"
SCENES = [(FOLDER / "cloth_on_sphere.json", {"geometry.0.cells": [16, 16], "time.frames": 30})]
SCENES += [
    (file, {"time.frames": 12 if re.search('"(refine|merge)"', file.read_text()) else 2})
    for file in sorted(FOLDER.glob("*.json"))
    if file.name != "scene.schema.json"
]

# A strip whose ends come nearer and part again: cells are split and joined.
JOINS = {
    "name": "joins",
    "geometry": [
        {
            "size": [0.6, 0.15],
            "cells": [8, 2],
            "refine": {"when": "curved", "levels": 2, "angle_deg": 12, "join_deg": 5},
        }
    ],
    "handles": [
        {
            "select": "x0",
            "motion": [
                {"time": 0},
                {"time": 0.2, "translation": [0.15, 0, 0]},
                {"time": 0.4, "translation": [0, 0, 0]},
            ],
        },
        {"select": "x1"},
    ],
    "materials": {"default": {"bending_stiffness": 1e-4, "bending_damping": 1e-4}},
    "time": {"frames": 40, "fps": 60},
}

# Two panels whose seam closes and merges.
MERGES = {
    "name": "merges",
    "geometry": [
        {
            "name": name,
            "size": [0.2, 0.15],
            "cells": [4, 3],
            "transformation": {"translation": [x, 0, z]},
        }
        for name, x, z in (("left", -0.13, 0), ("right", 0.13, 0.01))
    ],
    "seams": [
        {
            "sides": [{"geometry": "left", "select": "x1"}, {"geometry": "right", "select": "x0"}],
            "pull": 20,
            "merge": 0.003,
        }
    ],
    "contact": {"rest_gap": 0.001},
    "gravity": [0, 0, 0],
    "time": {"frames": 24, "fps": 60},
}


@pytest.mark.parametrize(("scene", "counter"), [(JOINS, "joined_cells"), (MERGES, "merged_pairs")])
@pytest.mark.parametrize("single", [False, True])
def test_a_mesh_that_changes_has_the_bits_of_a_run(tmp_path, scene, counter, single):
    expected = selvedge.run(scene, tmp_path / "out")
    assert expected["counters"][counter] > 0
    simulation = selvedge.Simulation(scene)
    if single:
        while simulation.time < scene["time"]["frames"] / scene["time"]["fps"] - 1e-9:
            simulation.step()
    else:
        simulation.advance_to_frame(scene["time"]["frames"])
    result = simulation.result()
    assert simulation.state_hash == expected["state_hash"]
    assert simulation.steps == expected["steps"]
    assert result["counters"] == expected["counters"]
    assert result["ledger"] == expected["ledger"]


@pytest.mark.parametrize(("scene", "changes"), SCENES, ids=lambda value: getattr(value, "stem", ""))
def test_the_simulation_has_the_bits_of_the_program(program, tmp_path, scene, changes):
    sets = []
    for path, value in changes.items():
        sets += ["--set", f"{path}={json.dumps(value)}"]
    run = subprocess.run(
        [program, "run", scene, "--out", tmp_path / "out", "--no-pictures", *sets],
        capture_output=True,
        text=True,
    )
    if run.returncode == 2:  # such as a mesh that has to be downloaded first
        with pytest.raises(ValueError) as refused:
            selvedge.Simulation(selvedge.Scene(scene, changes))
        assert str(refused.value) in run.stderr
        return
    assert run.returncode == 0, run.stderr
    expected = json.loads((tmp_path / "out" / "result.json").read_text())
    simulation = selvedge.Simulation(selvedge.Scene(scene, changes))
    simulation.advance_to_frame(simulation.scene.frames)
    assert simulation.state_hash == expected["state_hash"]
    assert simulation.steps == expected["steps"]
    assert simulation.clean == expected["clean"]


def test_a_run_into_a_folder_has_the_same_bits_as_steps_in_memory(tmp_path):
    frames = []
    result = selvedge.run(
        ball_scene(), tmp_path / "out", progress=lambda frame, seconds: frames.append(frame)
    )
    simulation = selvedge.Simulation(ball_scene())
    simulation.advance_to_frame(6)
    assert result["state_hash"] == simulation.state_hash and result["clean"]
    assert frames == list(range(7))
    with pytest.raises(ValueError, match="holds results of the scene"):
        selvedge.run({**ball_scene(), "name": "other"}, tmp_path / "out")


def test_a_second_run_replaces_the_first_only_when_it_is_asked_to(tmp_path):
    scene = ball_scene(cells=4, frames=2)
    first = selvedge.run(scene, tmp_path / "out")
    with pytest.raises(ValueError, match="overwrite=True"):
        selvedge.run(scene, tmp_path / "out")
    assert json.loads((tmp_path / "out" / "result.json").read_text()) == first
    assert selvedge.run(scene, tmp_path / "out", overwrite=True)["frames"] == 3
    assert selvedge.run(scene, tmp_path / "out", resume=True)["frames"] == 3


def test_a_failed_step_is_forgotten_once_a_good_one_is_made():
    def plate(name, z):
        shape = {"type": "box", "size": [1, 1, 0.02]}
        return {"name": name, "shape": shape, "transformation": {"translation": [0, 0, z]}}

    scene = {
        "geometry": [
            {
                "name": "cloth",
                "size": [0.2, 0.2],
                "cells": [5, 5],
                "transformation": {"translation": [0, 0, 0.02]},
            }
        ],
        "obstacles": [plate("table", 0), plate("press", 0.1)],
    }
    simulation = selvedge.Simulation(scene, driven=["press"])
    simulation.advance_to_frame(10)
    simulation.move_body("press", simulation.body_vertices("press") - [0, 0, 0.085])
    with pytest.raises(selvedge.SimulationFailed):
        for _ in range(50):
            simulation.step()
    assert not simulation.clean
    simulation.move_body("press", simulation.body_vertices("press") + [0, 0, 0.05])
    simulation.step()
    assert simulation.clean


@pytest.mark.parametrize("frame", ["3", 2.5, None, [1]])
def test_a_frame_is_a_whole_number(tmp_path, frame):
    simulation = selvedge.Simulation(ball_scene())
    for call in (
        lambda: simulation.advance_to_frame(frame),
        lambda: selvedge.measure(tmp_path, frame),
        lambda: selvedge.render_result(tmp_path, frame),
    ):
        with pytest.raises(TypeError, match=r"^frame: must be a whole number, is "):
            call()
    simulation.advance_to_frame(np.int64(1))
    assert simulation.time == pytest.approx(1 / 60)


def test_a_scene_is_made_from_a_dict_with_arrays_or_from_a_file(tmp_path):
    x, t = sheet(4, z=0.3)
    given = ball_scene()
    given["geometry"] = [{"name": "mine", "mesh": {"vertices": x, "triangles": t}}]
    given["obstacles"][0]["shape"]["radius"] = np.float32(0.25)
    scene = selvedge.Scene(given, {"time.frames": 2})
    assert scene.cloths == ["mine"] and scene.bodies == ["ball"] and scene.frames == 2
    simulation = selvedge.Simulation(scene)
    np.testing.assert_array_equal(simulation.positions, x)
    np.testing.assert_array_equal(simulation.triangles, t)
    (tmp_path / "scene.json").write_text(json.dumps(scene.to_dict()))
    again = selvedge.Scene(tmp_path / "scene.json")
    assert again.to_dict() == scene.to_dict()
    simulation.advance_to_frame(2)
    other = selvedge.Simulation(again)
    other.advance_to_frame(2)
    assert simulation.state_hash == other.state_hash


def test_errors_of_scenes_are_sentences_with_place_and_remedy(tmp_path):
    with pytest.raises(ValueError, match=r"geometry.*needs the key|needs the key \"geometry\""):
        selvedge.Scene({})
    with pytest.raises(ValueError, match="unknown|nearest"):
        selvedge.Scene({**ball_scene(), "gravitation": 1})
    with pytest.raises(ValueError, match="no such file"):
        selvedge.Scene(tmp_path / "none.json")
    with pytest.raises(ValueError, match="--set time.frames"):
        selvedge.Scene(ball_scene(), {"time.frames.none": 1})
    with pytest.raises(TypeError, match="cannot hold set"):
        selvedge.Scene({**ball_scene(), "name": {1, 2}})
    crossing = ball_scene()
    crossing["geometry"][0]["transformation"]["translation"] = [0, 0, 0.1]
    with pytest.raises(ValueError, match="cross"):
        selvedge.Simulation(crossing)


def test_arrays_are_read_only_views_that_outlive_the_simulation():
    simulation = selvedge.Simulation(ball_scene())
    x = simulation.positions
    assert x.shape == (81, 3) and x.dtype == np.float64 and not x.flags.owndata
    before = x.copy()
    simulation.step()
    assert not np.array_equal(x, before)  # a view of the state
    assert np.shares_memory(x, simulation.positions)
    with pytest.raises(ValueError):
        x[0, 0] = 1.0
    with pytest.raises(ValueError):
        x.flags.writeable = True
    now, body = x.copy(), simulation.body_positions
    assert body.shape == simulation.body_vertices("ball").shape
    state = simulation.save()
    simulation.restore(state)
    assert not np.shares_memory(x, simulation.positions)
    del simulation
    np.testing.assert_array_equal(x, now)
    assert np.isfinite(body).all()


def test_reading_a_state():
    simulation = selvedge.Simulation(ball_scene())
    assert simulation.time == 0.0 and len(simulation.contacts()["gap"]) == 0
    assert (simulation.contact_pressure() == 0.0).all()
    simulation.advance_to_frame(6)
    n = len(simulation.positions)
    table = simulation.contacts()
    count = len(table["gap"])
    assert count > 0
    assert table["vertices"].shape == (count, 4) and table["impulse"].shape == (count, 3)
    assert (table["vertices"] < n + len(simulation.body_positions)).all()
    assert simulation.velocities.shape == (n, 3)
    assert simulation.mass.sum() == pytest.approx(0.25 * 0.15, rel=0.5)
    assert simulation.flags().shape == (n,) and simulation.flags().dtype == np.uint8
    assert selvedge.VertexFlags[0] == "tangled"
    assert simulation.energies()["kinetic"] > 0.0
    assert simulation.result()["steps"] == simulation.steps == 12
    assert simulation.time == pytest.approx(0.1)
    assert simulation.cloth_vertices("cloth") == slice(0, n)
    assert "small" in repr(simulation) and "ball" in repr(simulation.scene)


def test_contact_pressure_carries_the_weight_of_cloth_on_a_table():
    scene = ball_scene(cells=6)
    scene["obstacles"] = [
        {"name": "table", "shape": {"type": "box", "size": [1, 1, 0.1]}}
    ]
    scene["geometry"][0]["transformation"]["translation"] = [0.01, 0.02, 0.0522]
    simulation = selvedge.Simulation(scene)
    simulation.advance_to_frame(40)
    weight = 9.81 * simulation.mass.sum() / 0.25  # Pa
    pressure = simulation.contact_pressure()
    assert pressure.shape == (49,)
    assert pressure.mean() == pytest.approx(weight, rel=0.3)


def test_a_table_feels_the_weight_of_cloth():
    scene = ball_scene(cells=6)
    scene["obstacles"] = [
        {"name": "table", "shape": {"type": "box", "size": [1, 1, 0.1]}}
    ]
    scene["geometry"][0]["transformation"]["translation"] = [0.01, 0.02, 0.0522]
    simulation = selvedge.Simulation(scene)
    with pytest.raises(RuntimeError, match="not measured"):
        simulation.wrenches()
    simulation.measure_wrenches()
    simulation.advance_to_frame(60)
    weight = 9.81 * simulation.mass.sum()
    felt = simulation.wrenches(mean=True, about=(0.01, 0.02, 0.05))
    force, torque = felt["bodies"]
    np.testing.assert_allclose(force, [[0, 0, -weight]], atol=0.01 * weight)
    np.testing.assert_allclose(torque, 0.0, atol=0.01 * weight)
    np.testing.assert_allclose(felt["others"]["loads"][0], [0, 0, -weight], atol=1e-9)
    assert felt["force_error"] < 1e-9
    mass, centre, inertia = felt["body_mass"]
    np.testing.assert_allclose(mass, [simulation.mass.sum()])
    np.testing.assert_allclose(centre, [[0.01, 0.02, 0.05]], atol=0.01)
    assert inertia.shape == (1, 3, 3) and np.linalg.eigvalsh(inertia[0]).min() > 0


def test_forces_are_those_of_newton():
    scene = ball_scene()
    scene["obstacles"] = []
    scene["gravity"] = [0, 0, 0]
    simulation = selvedge.Simulation(scene)
    mass, start = simulation.mass.copy(), simulation.positions.copy()
    simulation.set_forces(mass[:, None] * np.array([2.0, 0.0, 0.0]))
    simulation.advance_to_frame(6)
    np.testing.assert_allclose(simulation.velocities[:, 0], 0.2, rtol=1e-4)
    simulation.set_forces(None)
    simulation.advance_to_frame(12)
    np.testing.assert_allclose(simulation.velocities[:, 0], 0.2, rtol=1e-4)
    moved = simulation.positions - start
    assert np.abs(moved[:, 1:]).max() < 1e-5 and (moved[:, 0] > 0.02).all()
    for bad, sentence in (
        (np.zeros((3, 3)), "3 are given for 81 vertices"),
        (np.full((81, 3), np.nan), r"forces\[0\] is not finite"),
        (np.zeros((81, 2)), r"forces: must have the shape \(n, 3\)"),
    ):
        with pytest.raises(ValueError, match=sentence):
            simulation.set_forces(bad)


def test_wind_from_a_callable_acts_in_every_step():
    scene = ball_scene()
    scene["obstacles"] = []
    simulation = selvedge.Simulation(scene)
    calls = []

    def wind(now):
        calls.append(now.time)
        relative = np.array([3.0, 0.0, 0.0]) - now.velocities
        now.set_forces(0.02 * now.mass.mean() * relative / now.scene.step_length)

    simulation.advance_to_frame(10, before_step=wind)
    assert len(calls) == 20 and calls == sorted(calls)
    assert 0.0 < simulation.velocities[:, 0].mean() < 3.0


def test_pins_follow_an_array():
    scene = ball_scene()
    scene["obstacles"] = []
    simulation = selvedge.Simulation(scene)
    pins = [0, 8]
    start = simulation.positions[pins].copy()

    def raise_pins(now):
        now.hold(pins, start + [0, 0, 0.1 * (now.time + now.scene.step_length)])

    simulation.advance_to_frame(6, before_step=raise_pins)
    np.testing.assert_allclose(simulation.positions[pins], start + [0, 0, 0.01], atol=1e-12)
    simulation.hold(pins)  # where they are
    simulation.advance_to_frame(8)
    np.testing.assert_allclose(simulation.positions[pins], start + [0, 0, 0.01], atol=1e-12)
    simulation.release()
    simulation.advance_to_frame(12)
    assert (simulation.positions[pins, 2] < start[:, 2]).all()
    with pytest.raises(ValueError, match=r"vertices\[0\] is 81"):
        simulation.hold([81], [[0, 0, 0]])
    with pytest.raises(ValueError, match="81 is not among the 81"):
        simulation.hold([81])
    with pytest.raises(TypeError, match="whole numbers"):
        simulation.hold([0.5], [[0, 0, 0]])


def test_a_body_is_moved_from_python_and_cloth_stays_clean():
    simulation = selvedge.Simulation(ball_scene(), driven=["ball"])
    start = simulation.body_vertices("ball").copy()

    def lift(now):
        end = now.time + now.scene.step_length
        now.move_body("ball", start + [0.2 * end, 0.0, 0.5 * end])

    simulation.advance_to_frame(20, before_step=lift)
    np.testing.assert_allclose(
        simulation.body_vertices(0), start + [0.2 / 3, 0.0, 0.5 / 3], atol=1e-12
    )
    assert simulation.clean and len(simulation.contacts()["gap"]) > 0
    verdict = selvedge.check(
        simulation.positions,
        simulation.triangles,
        against=(simulation.body_positions, simulation.body_triangles),
    )
    assert verdict["body_intersections"] == 0 and verdict["self_intersections"] == 0
    with pytest.raises(ValueError, match="the body has .* positions are given"):
        simulation.move_body("ball", start[:-1])
    with pytest.raises(ValueError, match="no body is called 'bal'"):
        simulation.move_body("bal", start)
    with pytest.raises(ValueError, match="is not driven"):
        selvedge.Simulation(ball_scene()).move_body("ball", start)


def test_arguments_of_another_type_are_named():
    for driven in ("ball", 3):
        with pytest.raises(TypeError, match="driven: must be a list"):
            selvedge.Simulation(ball_scene(), driven=driven)
    with pytest.raises(TypeError, match="changes: must be a dict"):
        selvedge.Scene(ball_scene(), 5)


def test_restoring_what_is_no_state_is_refused():
    simulation = selvedge.Simulation(ball_scene())
    for other in (None, {}, 3):
        with pytest.raises(TypeError, match="state: must be a State"):
            simulation.restore(other)


def test_a_saved_state_continues_to_the_same_bits():
    def lift(now):
        now.move_body("ball", now.body_vertices("ball") + [0.0, 0.0, 0.002])

    simulation = selvedge.Simulation(ball_scene(), driven=[0])
    simulation.advance_to_frame(5, before_step=lift)
    state = simulation.save()
    assert state.time == simulation.time
    simulation.advance_to_frame(10, before_step=lift)
    expected = simulation.state_hash
    simulation.restore(state)
    assert simulation.time == state.time
    simulation.advance_to_frame(10, before_step=lift)
    assert simulation.state_hash == expected


def test_inputs_on_a_mesh_that_changes_are_refused():
    scene = ROOT / "data" / "scenes" / "adaptive.json"
    simulation = selvedge.Simulation(scene)
    with pytest.raises(ValueError, match="changes the mesh"):
        simulation.hold([0])
    with pytest.raises(ValueError, match="changes the mesh"):
        simulation.set_forces(np.zeros_like(simulation.positions))


def test_cloth_without_room_is_a_failure_with_its_kind():
    scene = ball_scene()
    scene["time"]["max_halvings"] = 2
    scene["obstacles"].append(
        {
            "name": "press",
            "shape": {"type": "box", "size": [1, 1, 0.1]},
            "transformation": {"translation": [0, 0, 0.3]},
        }
    )
    simulation = selvedge.Simulation(scene, driven=["press"])
    start = simulation.body_vertices("press").copy()
    with pytest.raises(selvedge.SimulationFailed, match="no clean step") as failure:
        for step in range(60):
            simulation.move_body("press", start - [0, 0, 0.005 * (step + 1)])
            simulation.step()
    assert failure.value.kind == "not clean"
    assert isinstance(failure.value, RuntimeError)
    assert selvedge.check(
        simulation.positions,
        simulation.triangles,
        against=(simulation.body_positions, simulation.body_triangles),
    )["body_intersections"] == 0
