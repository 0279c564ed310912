# SPDX-License-Identifier: MIT
"""Batches against single simulations, and pickles of what a batch of processes hands on."""

import pickle

import numpy as np
import pytest
import selvedge

from conftest import ROOT, ball_scene


def hash_of_single(scene, frames):
    simulation = selvedge.Simulation(scene)
    simulation.advance_to_frame(frames)
    return simulation.state_hash


def test_members_have_the_bits_of_single_simulations():
    scenes = [ball_scene(), ROOT / "data/scenes/ring.json", ball_scene(10)]
    batch = selvedge.Batch([scenes[k % 3] for k in range(7)])
    assert repr(batch) == "Batch(7 members of 3 scenes)"
    batch.advance(2)
    batch.advance(2, members=[0, 4])
    batch.advance(members=4)
    for k in range(7):
        assert batch[k].state_hash == hash_of_single(scenes[k % 3], {0: 4, 4: 5}.get(k, 2))
    assert batch.times[4] == batch[4].time > batch.times[1]


def test_positions_are_one_array_without_a_copy():
    batch = selvedge.Batch([ball_scene()] * 3)
    view = batch.positions
    assert view.shape == (3,) + batch[0].positions.shape and not view.flags.writeable
    before = view.copy()
    batch.step([1])
    assert np.shares_memory(view, batch.positions) and np.shares_memory(view, batch[1].positions)
    assert (view[1] != before[1]).any() and (view[0] == before[0]).all()
    assert np.array_equal(batch.velocities[1], batch[1].velocities)


def test_members_of_several_sizes_have_flat_arrays():
    batch = selvedge.Batch([ball_scene(), ball_scene(10)])
    with pytest.raises(ValueError, match=r"81 to 121 vertices.*take flat_positions"):
        batch.positions
    begin = batch.vertex_begin
    assert np.array_equal(batch.flat_positions[begin[1] : begin[2]], batch[1].positions)


def test_a_member_is_driven_saved_restored_and_reset_alone():
    batch = selvedge.Batch([ball_scene()] * 2, driven=["ball"])
    start = batch.positions.copy()
    ball = batch[1].body_vertices("ball") + [0, 0, 0.002]
    batch[1].move_body("ball", ball)
    batch[1].hold([0], [start[1, 0] + [0, 0, 0.001]])
    batch.step()
    assert np.allclose(batch[1].body_vertices("ball"), ball) and batch.positions[1, 0, 2] > start[1, 0, 2]
    batch[1].release()
    state = batch.save(1)
    batch.advance(3)
    expected = batch[1].state_hash
    batch.restore(1, state)
    batch.advance(3, 1)
    assert batch[1].state_hash == expected
    alone = selvedge.Simulation(batch.scenes[0], driven=["ball"])
    alone.restore(state)
    alone.advance_to_frame(3)
    batch.reset(1)
    assert np.array_equal(batch.positions[1], start[1])
    assert np.allclose(batch[1].body_vertices("ball"), ball - [0, 0, 0.002])


def test_a_member_that_fails_is_named_after_the_others_have_stepped():
    batch = selvedge.Batch([ball_scene()] * 3)
    batch[1].hold([40], [[0, 0, 0]])
    with pytest.raises(selvedge.SimulationFailed, match="^member 1: no clean step") as failure:
        batch.advance(2)
    assert list(failure.value.members) == [1] and failure.value.kind == "not clean"
    assert batch.times[0] == batch.times[2] == pytest.approx(2 / 60) and batch.times[1] < 1 / 60
    assert not batch[1].clean and batch[0].clean


def test_mistakes_are_sentences():
    batch = selvedge.Batch([ball_scene()] * 2)
    with pytest.raises(IndexError, match="there is no member 2; the batch has 2"):
        batch[2]
    with pytest.raises(ValueError, match="there is no member 5"):
        batch.step([5])
    with pytest.raises(ValueError, match="named twice"):
        batch.step([0, 0])
    with pytest.raises(TypeError, match="scenes: must be a list of scenes"):
        selvedge.Batch("scene.json")
    with pytest.raises(TypeError, match="members: must be a whole number"):
        batch.step([0.5])
    with pytest.raises(ValueError, match="^member 1: "):
        selvedge.Batch([ball_scene(), {**ball_scene(), "materials": {"default": {"fabric": "petrak_2025/M1"}},
                                       "geometry": [{"size": [0.2, 0.2], "cells": [2, 2]}]}])


def test_scenes_states_and_detectors_can_be_pickled():
    scene = pickle.loads(pickle.dumps(selvedge.Scene(ball_scene())))
    assert scene.to_dict() == selvedge.Scene(ball_scene()).to_dict()
    simulation = selvedge.Simulation(scene, driven=["ball"])
    simulation.advance_to_frame(3)
    simulation.move_body("ball", simulation.body_vertices("ball") + [0, 0, 0.001])
    simulation.step()
    state = pickle.loads(pickle.dumps(simulation.save()))
    assert state.time == simulation.time
    simulation.advance_to_frame(8)
    other = selvedge.Simulation(pickle.loads(pickle.dumps(scene)), driven=["ball"])
    other.restore(state)
    other.advance_to_frame(8)
    assert other.state_hash == simulation.state_hash
    detector = pickle.loads(pickle.dumps(selvedge.Detector({"type": "hash_grid", "cell": 0.2})))
    x, t = simulation.positions, simulation.triangles
    assert len(detector.find_candidates(x, x, t)) == len(
        selvedge.find_candidates(x, x, t, broad_phase={"type": "hash_grid", "cell": 0.2}))


def test_a_scene_file_with_meshes_is_pickled_with_its_folder(tmp_path, monkeypatch):
    scene = selvedge.Scene(ROOT / "data/scenes/mannequin.json", {"time.frames": 1})
    monkeypatch.chdir(tmp_path)
    assert pickle.loads(pickle.dumps(scene)).to_dict() == scene.to_dict()


def test_a_damaged_state_is_refused():
    state = selvedge.Simulation(ball_scene()).save()
    make, (text,) = state.__reduce__()
    with pytest.raises(ValueError, match="the saved state is damaged; save it again"):
        make(text[: len(text) // 2])
    with pytest.raises(ValueError, match="the saved state is damaged; save it again"):
        make("{}")
