# SPDX-License-Identifier: MIT
"""Single pairs in batches."""

import numpy as np
import pytest
from selvedge import ccd, list_methods

import brute

CALLS = {False: ccd.point_triangle, True: ccd.edge_edge}


@pytest.mark.parametrize("edges", [False, True])
def test_batches_are_decided_as_by_brute_force(rng, edges):
    start = rng.uniform(-1.0, 1.0, (400, 4, 3))
    end = start + rng.uniform(-1.5, 1.5, start.shape)
    found = CALLS[edges](np.concatenate([start, end], axis=1))
    expected = np.array([brute.impact(a, b, edges) for a, b in zip(start, end)])
    sure = ~np.isnan(expected)
    assert sure.mean() > 0.95 and np.isfinite(expected).sum() > 10
    np.testing.assert_array_equal(found.hit[sure], np.isfinite(expected[sure]))
    hits = sure & found.hit
    np.testing.assert_allclose(found.toi[hits], expected[hits], atol=1e-6)


@pytest.mark.parametrize("edges", [False, True])
def test_the_geometry_is_that_of_the_time_of_impact(rng, edges):
    start = rng.uniform(-1.0, 1.0, (300, 4, 3))
    end = start + rng.uniform(-1.5, 1.5, start.shape)
    found = CALLS[edges](np.concatenate([start, end], axis=1))
    t = found.toi[found.hit][:, None, None]
    points = (1.0 - t) * start[found.hit] + t * end[found.hit]
    apart = np.einsum("ik,ikd->id", found.weights[found.hit], points)
    assert np.abs(apart).max() < 1e-9
    np.testing.assert_allclose(np.linalg.norm(found.normal[found.hit], axis=1), 1.0, atol=1e-12)
    assert np.isnan(found.weights[~found.hit]).all() and np.isnan(found.normal[~found.hit]).all()
    assert np.isinf(found.toi[~found.hit]).all()
    assert repr(found) == f"Impacts(300 queries, {found.hit.sum()} hits)"


def test_touching_at_the_last_instant_counts():
    rest = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    q = np.array([[0.25, 0.25, 1.0], *rest, [0.25, 0.25, 0.0], *rest])
    found = ccd.point_triangle(q)
    assert len(found) == 1 and found.toi[0] == 1.0
    q[4, 2] = np.nextafter(0.0, 1.0)
    assert not ccd.point_triangle(q).hit[0]


def test_every_narrow_phase_of_the_build_decides_batches(rng):
    q = rng.uniform(-1.0, 1.0, (50, 8, 3))
    exact = ccd.point_triangle(q)
    names = [m for m in list_methods() if m["family"] == "narrow_phase" and m["available"]]
    assert len(names) > 5
    for method in names:
        found = ccd.point_triangle(q, method["name"])
        assert len(found) == 50
        if "misses nothing" in method["promise"]:
            assert not (exact.hit & ~found.hit).any(), method["name"]
    options = ccd.point_triangle(q, {"type": "ccd_exact", "min_separation": 0.5})
    assert options.hit.sum() > exact.hit.sum()


def test_a_batch_may_be_empty_and_has_eight_rows():
    assert len(ccd.edge_edge(np.zeros((0, 8, 3)))) == 0
    for shape in ((8, 2), (4, 7, 3), (2, 2, 8, 3), (24,)):
        with pytest.raises(ValueError, match=r"q: must have the shape \(n, 8, 3\)"):
            ccd.edge_edge(np.zeros(shape))
    with pytest.raises(ValueError, match="narrow_phase: .*nearest|ccd_exact"):
        ccd.edge_edge(np.zeros((1, 8, 3)), "ccd_exat")
