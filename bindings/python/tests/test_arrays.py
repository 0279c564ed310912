# SPDX-License-Identifier: MIT
"""Arrays of the wrong type, shape, order or content: a clear error or a copy, never a wrong result."""

import tracemalloc

import numpy as np
import pytest
import selvedge

from conftest import sheet

X, T = sheet(3)
EXPECTED = selvedge.find_collisions(X + [0, 0, 0.1], X - [0.01, 0.02, 0.1], T, (X, T)).to_dict()


def collide(x0=None, x1=None, t=None, body=None):
    return selvedge.find_collisions(
        X + [0, 0, 0.1] if x0 is None else x0,
        X - [0.01, 0.02, 0.1] if x1 is None else x1,
        T if t is None else t,
        (X, T) if body is None else body,
    ).to_dict()


def misaligned(array):
    raw = np.empty(array.nbytes + 1, dtype=np.uint8)[1:]
    out = raw.view(array.dtype).reshape(array.shape)
    out[:] = array
    assert not out.flags.aligned
    return out


def read_only(array):
    out = array.copy()
    out.flags.writeable = False
    return out


LAYOUTS = {
    "list": lambda a: a.tolist(),
    "fortran order": np.asfortranarray,
    "every second row": lambda a: np.repeat(a, 2, axis=0)[::2],
    "reversed twice": lambda a: a[::-1].copy()[::-1],
    "columns of a wider array": lambda a: np.hstack([a, a])[:, :3],
    "big endian": lambda a: a.astype(a.dtype.newbyteorder(">")),
    "misaligned": misaligned,
    "read-only": read_only,
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_memory_layout_gives_the_same_result(layout):
    change = LAYOUTS[layout]
    found = collide(
        change(X + [0, 0, 0.1]), change(X - [0.01, 0.02, 0.1]), change(T), (change(X), change(T))
    )
    for name, column in EXPECTED.items():
        np.testing.assert_array_equal(found[name], column)


def test_arrays_of_the_right_layout_are_used_without_a_copy():
    x, t = sheet(300)  # 2.2 MB of vertices, 2.2 MB of triangles
    far = x + [0, 0, 1]

    def allocated(vertices):
        """Most memory of NumPy and Python during a call that finds nothing."""
        tracemalloc.start()
        try:
            assert len(selvedge.find_contacts(vertices, t, 1e-6, (far, t))) == 0
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    allocated(x)  # what a first call keeps
    assert allocated(x) < 0.01 * x.nbytes
    for other in (np.asfortranarray(x), x.astype(">f8"), x.tolist()):
        assert allocated(other) > 0.9 * x.nbytes  # the means of this test: a copy shows


def test_inputs_are_never_changed():
    x0, x1, t = X + [0, 0, 0.1], X - [0.01, 0.02, 0.1], T.copy()
    before = x0.copy(), x1.copy(), t.copy()
    collide(x0, x1, t)
    for now, then in zip((x0, x1, t), before):
        np.testing.assert_array_equal(now, then)


@pytest.mark.parametrize("dtype", [np.int64, np.uint64, np.uint32, np.int16, np.uint8])
def test_whole_numbers_of_any_width_are_indices(dtype):
    for name, column in EXPECTED.items():
        np.testing.assert_array_equal(collide(t=T.astype(dtype))[name], column)


def test_single_precision_is_read_as_the_numbers_that_it_holds():
    x = X.astype(np.float32)
    found = selvedge.find_contacts(x, T, 0.05, (x + np.float32(0.01), T))
    exact = selvedge.find_contacts(
        x.astype(np.float64), T, 0.05, ((x + np.float32(0.01)).astype(np.float64), T)
    )
    np.testing.assert_array_equal(found.gap, exact.gap)


@pytest.mark.parametrize(
    ("arguments", "error", "sentence"),
    [
        ({"x0": X[:, :2]}, ValueError, r"x0: must have the shape \(n, 3\), has \(16, 2\)"),
        ({"x0": X.ravel()}, ValueError, r"x0: must have the shape \(n, 3\), has \(48,\)"),
        ({"x0": X[None]}, ValueError, r"x0: must have the shape \(n, 3\)"),
        ({"x0": X[:-1]}, ValueError, r"a: x_t0 has 15 vertices, x_t1 has 16"),
        ({"x0": X.astype(complex)}, TypeError, "x0: must hold real numbers, .* complex128"),
        ({"x0": X.astype(str)}, TypeError, "x0: must hold real numbers"),
        ({"x0": X.astype(object)}, TypeError, "x0: must hold real numbers, .* object"),
        ({"x0": X > 0}, TypeError, "x0: must hold real numbers, .* bool"),
        ({"t": T.astype(float)}, TypeError, "triangles: must hold whole numbers, .* float64"),
        ({"t": T[:, :2]}, ValueError, r"triangles: must have the shape \(n, 3\)"),
        ({"t": T + 1}, ValueError, r"triangles\[\d+\] has the index 16; it must be in \[0, 16\)"),
        ({"t": T - 1}, ValueError, r"triangles\[0\] has the index -1"),
        ({"t": T.astype(np.int64) + 2**32}, ValueError, r"triangles\[0, 0\] is 4294967296"),
        ({"t": T.astype(np.uint64) + 2**63}, ValueError, r"triangles\[0, 0\] is 9223372036854775808"),
        ({"body": X}, TypeError, "body: must be"),
        ({"body": (X, T, T, T)}, TypeError, "body: must be"),
    ],
)
def test_what_cannot_be_used_is_refused_in_a_sentence(arguments, error, sentence):
    with pytest.raises(error, match=sentence):
        collide(**arguments)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_refused_with_their_place(bad):
    x = X.copy()
    x[5, 1] = bad
    with pytest.raises(ValueError, match=r"a: x_t0\[5\] is .*; coordinates must be finite"):
        collide(x0=x)
    with pytest.raises(ValueError, match=r"surface: x\[5\]"):
        selvedge.find_crossings(x, T)
    q = np.zeros((4, 8, 3))
    q[2, 7, 0] = bad
    with pytest.raises(ValueError, match=r"q\[2, 7, 0\] is"):
        selvedge.ccd.point_triangle(q)


def test_results_own_their_memory():
    table = selvedge.find_collisions(X + [0, 0, 0.1], X - [0, 0, 0.1], T, (X, T))
    column = table.vertices
    copy = column.copy()
    del table
    selvedge.find_collisions(X, X, T)
    np.testing.assert_array_equal(column, copy)
    column[:] = 0  # a result may be changed
