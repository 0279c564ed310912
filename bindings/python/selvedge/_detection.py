# SPDX-License-Identifier: MIT
"""Collisions, crossings and contacts of triangle meshes, as arrays."""

from __future__ import annotations

import enum
from dataclasses import dataclass, fields
from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arrays import Method, mesh, method, number, positions, triangles as _triangles

__all__ = [
    "Candidates",
    "Collisions",
    "ContactKind",
    "Contacts",
    "Detector",
    "find_candidates",
    "find_collisions",
    "find_contacts",
    "find_crossings",
    "find_touches",
]


class ContactKind(enum.IntEnum):
    """Which primitives touch, and what `primitive_a`, `primitive_b` and `vertices` number.

    POINT_TRIANGLE: a vertex of the first surface and a triangle of the second. `vertices`: the
    vertex, then the three corners.
    TRIANGLE_POINT: a triangle of the first surface and a vertex of the second. `vertices`: the
    vertex, then the three corners.
    EDGE_EDGE: an edge of each. `vertices`: two of the first edge, then two of the second. Edges
    are numbered as in `Candidates.edges_a` and `edges_b`.
    """

    POINT_TRIANGLE = 0
    TRIANGLE_POINT = 1
    EDGE_EDGE = 2


class _Table:
    """Columns of equal length."""

    def __len__(self) -> int:
        return len(getattr(self, fields(self)[0].name))

    def to_dict(self) -> dict[str, NDArray[Any]]:
        """The columns by name, such as for pandas.DataFrame; columns with several numbers a row
        stay two-dimensional."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self)} rows)"


@dataclass(frozen=True, repr=False)
class Collisions(_Table):
    """Pairs of primitives that share a point during a step, sorted by time of impact; c rows."""

    toi: NDArray[np.float64]  #: (c,) time of impact in [0, 1]
    kind: NDArray[np.uint8]  #: (c,) values of ContactKind
    primitive_a: NDArray[np.int32]  #: (c,) vertex, triangle or edge of the first surface
    primitive_b: NDArray[np.int32]  #: (c,) the same of the second surface
    vertices: NDArray[np.int32]  #: (c, 4) vertices of the pair, as ContactKind says
    weights: NDArray[np.float64]  #: (c, 4) signed barycentric weights of `vertices`, sum 0
    normal: NDArray[np.float64]  #: (c, 3) unit, from the second primitive towards the first


@dataclass(frozen=True, repr=False)
class Contacts(_Table):
    """Pairs of primitives that are near each other in one state, sorted by gap; c rows."""

    gap: NDArray[np.float64]  #: (c,) distance, metres
    kind: NDArray[np.uint8]  #: (c,) values of ContactKind
    primitive_a: NDArray[np.int32]  #: (c,) vertex, triangle or edge of the first surface
    primitive_b: NDArray[np.int32]  #: (c,) the same of the second surface
    vertices: NDArray[np.int32]  #: (c, 4) vertices of the pair, as ContactKind says
    weights: NDArray[np.float64]  #: (c, 4) signed barycentric weights of `vertices`, sum 0
    normal: NDArray[np.float64]  #: (c, 3) unit, from the second primitive towards the first


@dataclass(frozen=True)
class Candidates:
    """Pairs of primitives whose paths may meet, sorted. For one surface, `edges_b` is `edges_a`."""

    point_triangle: NDArray[np.int32]  #: (p, 2) vertex of a, triangle of b
    triangle_point: NDArray[np.int32]  #: (q, 2) vertex of b, triangle of a; empty for one surface
    edge_edge: NDArray[np.int32]  #: (r, 2) edge of a, edge of b
    edges_a: NDArray[np.int32]  #: (e, 2) vertices of the edges of a, lower one first
    edges_b: NDArray[np.int32]  #: (f, 2) vertices of the edges of b

    def __len__(self) -> int:
        return len(self.point_triangle) + len(self.triangle_point) + len(self.edge_edge)

    def __repr__(self) -> str:
        return f"Candidates({len(self)} pairs)"


def _moving(x0: ArrayLike, x1: ArrayLike, triangles: ArrayLike) -> Any:
    return _core.Surface(
        positions(x0, "x0"), positions(x1, "x1"), _triangles(triangles, "triangles")
    )


def _moving_body(body: Any) -> Optional[Any]:
    if body is None:
        return None
    if len(body) == 2:
        x, t = mesh(body, "body")
        return _core.Surface(x, x, t)
    if len(body) != 3:
        raise TypeError("body: must be (vertices, triangles) or (x0, x1, triangles)")
    return _core.Surface(
        positions(body[0], "body: x0"),
        positions(body[1], "body: x1"),
        _triangles(body[2], "body: triangles"),
    )


def _state(x: ArrayLike, triangles: ArrayLike) -> Any:
    vertices = positions(x, "x")
    return _core.Surface(vertices, vertices, _triangles(triangles, "triangles"))


def _resting_body(body: Any) -> Optional[Any]:
    if body is None:
        return None
    x, t = mesh(body, "body")
    return _core.Surface(x, x, t)


class Detector:
    """A broad phase and a narrow phase that are kept from call to call, with their memory and
    trees. The functions of the module make one for each call. A detector belongs to one thread at
    a time.

    Args:
        broad_phase: name of a broad phase, or {"type": name, option: value, ...}. The names and
            options are those of `list_methods()`.
        narrow_phase: the same for the narrow phase.
        min_separation: metres, >= 0. Primitives that come this near count as colliding. The
            method has to support it, as "ccd_exact" does.

    Raises:
        ValueError: for an unknown method, and for an option that it does not have.

    Its methods raise RuntimeError while another thread uses it, and KeyboardInterrupt soon after
    Ctrl-C.
    """

    def __init__(
        self,
        broad_phase: Method = "bvh_aabb",
        narrow_phase: Method = "ccd_exact",
        min_separation: float = 0.0,
    ) -> None:
        self._chosen = (
            method(broad_phase, "broad_phase"),
            method(narrow_phase, "narrow_phase"),
            number(min_separation, "min_separation"),
        )
        self._core = _core.Detector(*self._chosen)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles keep the choice of methods, not their memory."""
        return Detector, self._chosen

    def find_collisions(
        self, x0: ArrayLike, x1: ArrayLike, triangles: ArrayLike, body: Any = None
    ) -> Collisions:
        """`selvedge.find_collisions` by the methods of this detector."""
        return Collisions(**self._core.collisions(_moving(x0, x1, triangles), _moving_body(body)))

    def find_candidates(
        self,
        x0: ArrayLike,
        x1: ArrayLike,
        triangles: ArrayLike,
        body: Any = None,
        distance: float = 0.0,
    ) -> Candidates:
        """`selvedge.find_candidates` by the broad phase of this detector."""
        found = self._core.candidates(
            _moving(x0, x1, triangles), _moving_body(body), number(distance, "distance")
        )
        return Candidates(**found)


def find_collisions(
    x0: ArrayLike,
    x1: ArrayLike,
    triangles: ArrayLike,
    body: Any = None,
    *,
    broad_phase: Method = "bvh_aabb",
    narrow_phase: Method = "ccd_exact",
    min_separation: float = 0.0,
) -> Collisions:
    """Finds the collisions of a surface during a step: with itself, or with a body.

    Every vertex moves on the straight line x0[i] -> x1[i] while t goes from 0 to 1. With the
    default methods the answer is exact: no collision is missed and none is invented. Touching
    counts. Pairs of one surface that share a vertex are left out.

    Args:
        x0: (n, 3) metres, vertices at the start.
        x1: (n, 3) metres, vertices at the end.
        triangles: (m, 3) vertex indices.
        body: None to search the surface for collisions with itself; (vertices, triangles) of a
            body at rest; or (x0, x1, triangles) of a moving one.
        broad_phase: a name of `list_methods()`, or {"type": name, option: value, ...}. Every
            conservative one leads to the same collisions.
        narrow_phase: the same.
        min_separation: metres, >= 0. Primitives that come this near count as colliding.

    Returns:
        Collisions, sorted by time of impact. The same for any number of threads.

    Raises:
        ValueError: an array has the wrong shape, a coordinate is not finite, an index is out of
            range, or a method or option is unknown; the message names the place.
        TypeError: an array has a data type that is not numeric.

    float64 and int32 arrays in C order are used without a copy, others are copied. Do not change
    them from another thread during the call.
    """
    return Detector(broad_phase, narrow_phase, min_separation).find_collisions(
        x0, x1, triangles, body
    )


def find_candidates(
    x0: ArrayLike,
    x1: ArrayLike,
    triangles: ArrayLike,
    body: Any = None,
    *,
    broad_phase: Method = "bvh_aabb",
    distance: float = 0.0,
) -> Candidates:
    """Finds the pairs of primitives whose paths may come within `distance` of each other.

    Arguments and errors as in `find_collisions`; `distance` in metres, >= 0. These are the pairs
    that a narrow phase has to decide. A conservative broad phase misses none.
    """
    return Detector(broad_phase).find_candidates(x0, x1, triangles, body, distance)


def find_crossings(x: ArrayLike, triangles: ArrayLike, body: Any = None) -> NDArray[np.int32]:
    """Finds the pairs of triangles that cross in one state, exactly.

    Two triangles cross if their insides have a common point: an edge of one passes through the
    inside of the other, or both lie in one plane and overlap in area. Common vertices do not
    matter. `check` counts the same pairs.

    Args:
        x: (n, 3) metres.
        triangles: (m, 3) vertex indices.
        body: None to search the surface itself, or (vertices, triangles) of another one.

    Returns:
        (c, 2) int32: triangle of the surface, and triangle of the surface (a larger index) or of
        the body.

    Raises:
        ValueError, TypeError: as in `find_collisions`.
    """
    return _core.find_meetings(_state(x, triangles), _resting_body(body))[0]


def find_touches(x: ArrayLike, triangles: ArrayLike, body: Any = None) -> NDArray[np.int32]:
    """Finds the pairs of triangles that touch in one state and do not cross, exactly.

    Two triangles touch if a corner or an edge of one meets the other, or two edges meet, that have
    no vertex in common. Vertices are common by index: equal positions of different indices touch.
    Arguments, result and errors as in `find_crossings`.
    """
    return _core.find_meetings(_state(x, triangles), _resting_body(body))[1]


def find_contacts(
    x: ArrayLike, triangles: ArrayLike, distance: float, body: Any = None
) -> Contacts:
    """Finds the pairs of a point and a triangle, or of two edges, that are nearer than `distance`.

    Args:
        x: (n, 3) metres.
        triangles: (m, 3) vertex indices.
        distance: metres, > 0.
        body: None to search the surface itself, or (vertices, triangles) of another one.

    Returns:
        Contacts, sorted by gap.

    Raises:
        ValueError, TypeError: as in `find_collisions`.
    """
    return Contacts(**_core.find_contacts(_state(x, triangles), _resting_body(body), number(distance, "distance")))
