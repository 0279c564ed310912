# SPDX-License-Identifier: MIT
"""Detection against brute force, by every method, and its tables."""

import numpy as np
import pytest
import selvedge
from selvedge import ContactKind

import brute
from conftest import sheet


def soup(rng, count, shared=False):
    """Random triangles; `shared`: with common vertices."""
    points = rng.uniform(-1.0, 1.0, (count + 2 if shared else 3 * count, 3))
    if shared:
        triangles = np.array([[i, i + 1, i + 2] for i in range(count)], dtype=np.int32)
    else:
        triangles = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
    return points, triangles


def as_dict(table, value):
    keys = zip(table.kind.tolist(), table.primitive_a.tolist(), table.primitive_b.tolist())
    return dict(zip(keys, getattr(table, value).tolist()))


def assert_same(table, expected, unsure, value, tolerance):
    found = as_dict(table, value)
    assert set(found) - unsure == set(expected) - unsure
    for key in set(expected) - unsure:
        assert found[key] == pytest.approx(expected[key], abs=tolerance)
    assert list(found.values()) == sorted(found.values())


@pytest.mark.parametrize("shared", [False, True])
def test_collisions_of_one_surface_are_those_of_brute_force(rng, shared):
    x0, triangles = soup(rng, 10, shared)
    x1 = x0 + rng.uniform(-0.8, 0.8, x0.shape)
    expected, unsure = brute.collisions(x0, x1, triangles)
    assert len(expected) > 5 and len(unsure) < len(expected)
    assert_same(selvedge.find_collisions(x0, x1, triangles), expected, unsure, "toi", 1e-6)


def test_collisions_with_a_moving_body_are_those_of_brute_force(rng):
    x0, triangles = soup(rng, 7)
    x1 = x0 + rng.uniform(-0.8, 0.8, x0.shape)
    y0, body = soup(rng, 6, shared=True)
    y1 = y0 + rng.uniform(-0.8, 0.8, y0.shape)
    expected, unsure = brute.collisions(x0, x1, triangles, (y0, y1, body))
    table = selvedge.find_collisions(x0, x1, triangles, (y0, y1, body))
    assert {0, 1, 2} == set(table.kind.tolist())
    assert_same(table, expected, unsure, "toi", 1e-6)


def test_contacts_are_those_of_brute_force(rng):
    x, triangles = soup(rng, 10, shared=True)
    y, body = soup(rng, 6)
    for other in (None, (y, body)):
        expected = brute.proximities(x, triangles, 0.4, other)
        assert len(expected) > 5
        assert_same(
            selvedge.find_contacts(x, triangles, 0.4, other), expected, set(), "gap", 1e-9
        )


def test_crossings_are_those_of_brute_force(rng):
    x, triangles = soup(rng, 40)
    y, body = soup(rng, 20, shared=True)
    for other in (None, (y, body)):
        found = selvedge.find_crossings(x, triangles, other)
        expected = brute.crossings(x, triangles, other)
        assert len(expected) > 5
        assert set(map(tuple, found.tolist())) == expected


def test_crossings_and_touches_of_neighbours_are_those_of_check():
    corner = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    for ends, crossings, touches in (
        ([[0.3, 0.2, 0.5], [0.3, 0.2, -0.5]], [[0, 1]], []),
        ([[0.3, 0.2, 0.5], [0.3, 0.2, 0.0]], [], [[0, 1]]),
        ([[-0.3, 0.2, 0.5], [-0.3, 0.2, -0.5]], [], []),
    ):
        x, triangles = np.array(corner + ends, dtype=float), [[0, 1, 2], [0, 3, 4]]
        assert selvedge.find_crossings(x, triangles).tolist() == crossings
        assert selvedge.find_touches(x, triangles).tolist() == touches
        verdict = selvedge.check(x, np.array(triangles, dtype=np.int32))
        assert verdict["self_intersections"] == len(crossings)
        assert verdict["self_touches"] == len(touches)


def test_every_conservative_detector_of_the_build_leads_to_the_same_collisions(rng):
    x0, triangles = soup(rng, 40, shared=True)
    x1 = x0 + rng.uniform(-0.3, 0.3, x0.shape)
    y, body = soup(rng, 30)
    expected = as_dict(selvedge.find_collisions(x0, x1, triangles, (y, body)), "toi")
    names = [
        m["name"]
        for m in selvedge.list_methods()
        if m["family"] == "broad_phase"
        and m["available"]
        and m["key"] == "contact.broad_phase"
        and "misses nothing" in m["promise"]
    ]
    assert "bvh_aabb" in names and len(names) > 5
    for name in names:
        table = selvedge.find_collisions(x0, x1, triangles, (y, body), broad_phase=name)
        assert as_dict(table, "toi") == expected, name


def test_methods_take_the_options_that_the_list_names():
    x, t = sheet()
    listed = {m["name"]: m for m in selvedge.list_methods() if m["family"] == "broad_phase"}
    name, option = next(
        (m["name"], o)
        for m in listed.values()
        if m["available"]
        for o in m["options"]
        if isinstance(o["default"], float)
    )
    choice = {"type": name, option["name"]: option["default"]}
    selvedge.find_collisions(x + [0, 0, 1], x - [0, 0, 1], t, (x, t), broad_phase=choice)
    with pytest.raises(ValueError, match="no_such_option"):
        selvedge.find_collisions(x, x, t, broad_phase={"type": name, "no_such_option": 1})
    with pytest.raises(ValueError, match="nearest is bvh_aabb|bvh_aabb"):
        selvedge.find_collisions(x, x, t, broad_phase="bvh_aab")
    with pytest.raises(TypeError, match="narrow_phase"):
        selvedge.find_collisions(x, x, t, narrow_phase=3)
    with pytest.raises(TypeError, match="'layers'"):
        selvedge.find_collisions(x, x, t, broad_phase={"type": name, "layers": "many"})


def test_min_separation_makes_collisions_of_near_misses():
    x, t = sheet()
    above = x + [0.003, 0.001, 0.001]
    assert len(selvedge.find_collisions(above, above, t, (x, t))) == 0
    near = selvedge.find_collisions(above, above, t, (x, t), min_separation=0.002)
    assert len(near) > 0
    with pytest.raises(ValueError, match="min_separation"):
        selvedge.find_collisions(above, above, t, (x, t), min_separation=-1.0)


def test_candidates_contain_the_collisions(rng):
    x0, triangles = soup(rng, 30)
    x1 = x0 + rng.uniform(-0.3, 0.3, x0.shape)
    y, body = soup(rng, 20)
    candidates = selvedge.find_candidates(x0, x1, triangles, (y, body))
    table = selvedge.find_collisions(x0, x1, triangles, (y, body))
    lists = (candidates.point_triangle, candidates.triangle_point, candidates.edge_edge)
    sets = [set(map(tuple, pairs.tolist())) for pairs in lists]
    assert len(candidates) == sum(map(len, sets))
    for kind, a, b in zip(table.kind, table.primitive_a, table.primitive_b):
        pair = (b, a) if kind == ContactKind.TRIANGLE_POINT else (a, b)
        assert tuple(map(int, pair)) in sets[kind]
    np.testing.assert_array_equal(candidates.edges_a, brute.edges_of(triangles))
    np.testing.assert_array_equal(candidates.edges_b, brute.edges_of(body))
    far = selvedge.find_candidates(x0, x0, triangles, distance=0.5)
    assert len(far) > len(selvedge.find_candidates(x0, x0, triangles))


def test_weights_and_normals_describe_the_contact(rng):
    x0, triangles = soup(rng, 12)
    x1 = x0 + rng.uniform(-0.8, 0.8, x0.shape)
    y, body = soup(rng, 8)
    table = selvedge.find_collisions(x0, x1, triangles, (y, body))
    first = {0: 1, 1: 1, 2: 2}
    for row in range(len(table)):
        kind, t = int(table.kind[row]), table.toi[row]
        moving = (1.0 - t) * x0 + t * x1
        sides = {0: (moving, y), 1: (y, moving), 2: (moving, y)}[kind]
        points = [
            sides[0][v] if i < first[kind] else sides[1][v]
            for i, v in enumerate(table.vertices[row])
        ]
        assert np.abs(table.weights[row] @ np.array(points)).max() < 1e-9
    np.testing.assert_allclose(table.weights.sum(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(table.normal, axis=1), 1.0, atol=1e-12)


def test_tables_have_rows_and_columns(rng):
    x0, triangles = soup(rng, 12)
    table = selvedge.find_collisions(x0, x0 + rng.uniform(-0.8, 0.8, x0.shape), triangles)
    columns = table.to_dict()
    assert list(columns)[:2] == ["toi", "kind"]
    assert all(len(column) == len(table) for column in columns.values())
    assert table.vertices.shape == (len(table), 4) and table.vertices.dtype == np.int32
    assert table.toi.dtype == np.float64 and table.normal.shape == (len(table), 3)
    assert repr(table) == f"Collisions({len(table)} rows)"


def test_a_detector_is_kept_between_calls(rng):
    x0, triangles = soup(rng, 20)
    x1 = x0 + rng.uniform(-0.5, 0.5, x0.shape)
    detector = selvedge.Detector("bvh_aabb")
    expected = as_dict(selvedge.find_collisions(x0, x1, triangles), "toi")
    for _ in range(3):
        assert as_dict(detector.find_collisions(x0, x1, triangles), "toi") == expected
    assert len(detector.find_candidates(x0, x1, triangles)) >= len(expected)


def test_results_are_the_same_for_any_number_of_threads(rng):
    x0, triangles = soup(rng, 200)
    x1 = x0 + rng.uniform(-0.2, 0.2, x0.shape)
    with selvedge.ThreadLimit(1):
        one = selvedge.find_collisions(x0, x1, triangles).to_dict()
    many = selvedge.find_collisions(x0, x1, triangles).to_dict()
    for name, column in one.items():
        np.testing.assert_array_equal(column, many[name])


def test_empty_meshes_have_nothing_to_find():
    none = np.zeros((0, 3))
    x, t = sheet()
    assert len(selvedge.find_collisions(none, none, [])) == 0
    assert len(selvedge.find_collisions(x, x, t, (none, []))) == 0
    assert selvedge.find_crossings(none, []).shape == (0, 2)
    assert selvedge.find_contacts([], [], 0.1).vertices.shape == (0, 4)
