# SPDX-License-Identifier: MIT
"""Continuous collision detection of single pairs of primitives, in batches.

A query has eight rows of three coordinates in metres: the four points at t = 0, then the same
points at t = 1. Between the two, every point moves on a straight line. This is the order of the
public continuous-collision benchmark.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arrays import Method, finite, method as _method, numbers

__all__ = ["Impacts", "edge_edge", "point_triangle"]


@dataclass(frozen=True, repr=False)
class Impacts:
    """The answers to n queries."""

    toi: NDArray[np.float64]  #: (n,) time of impact in [0, 1]; inf: no collision
    weights: NDArray[np.float64]  #: (n, 4) signed barycentric weights of the points; NaN: none
    normal: NDArray[np.float64]  #: (n, 3) unit, from the second primitive to the first; NaN: none

    @property
    def hit(self) -> NDArray[np.bool_]:
        """(n,) whether the primitives collide."""
        return np.isfinite(self.toi)

    def __len__(self) -> int:
        return len(self.toi)

    def __repr__(self) -> str:
        return f"Impacts({len(self)} queries, {int(self.hit.sum())} hits)"


def _impacts(q: ArrayLike, edges: bool, method: Method) -> Impacts:
    queries = np.asarray(q)
    if queries.ndim == 2:  # one query
        queries = queries[None]
    points = finite(numbers(queries, "q", None, 8, 3), "q")
    return Impacts(**_core.impacts(points, edges, _method(method, "method")))


def point_triangle(q: ArrayLike, method: Method = "ccd_exact") -> Impacts:
    """Decides whether and when a point and a triangle collide, for each query.

    Args:
        q: (n, 8, 3) metres, or (8, 3) for one query. Rows: the point p and the corners a, b, c at
            t = 0, then p, a, b, c at t = 1.
        method: a narrow phase of `selvedge.list_methods()`, or {"type": name, option: value, ...}.
            "ccd_exact" neither misses a collision nor invents one; its time of impact is the
            largest double that is not later than the true one.

    Returns:
        Impacts. weights: (1, -u, -v, -w) for p, a, b, c. The sum of weights times the points at
        the time of impact is the vector between the contact points.

    Raises:
        ValueError, TypeError: wrong shape, data type or value, or an unknown method.
    """
    return _impacts(q, False, method)


def edge_edge(q: ArrayLike, method: Method = "ccd_exact") -> Impacts:
    """Decides whether and when two edges collide, for each query.

    Args:
        q: (n, 8, 3) metres, or (8, 3) for one query. Rows: the ends a0, a1 of the first edge and
            b0, b1 of the second at t = 0, then the same at t = 1.
        method: as in `point_triangle`.

    Returns:
        Impacts. weights: (1 - s, s, -(1 - t), -t) for a0, a1, b0, b1.

    Raises:
        ValueError, TypeError: as `point_triangle`.
    """
    return _impacts(q, True, method)
