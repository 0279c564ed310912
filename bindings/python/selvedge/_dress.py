# SPDX-License-Identifier: MIT
"""Garments from sewing patterns, put on bodies."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any, Optional, Union

from numpy.typing import ArrayLike

from . import _core
from ._arrays import mesh as _mesh
from ._simulation import PathLike

__all__ = ["dress"]

Body = Union[PathLike, "tuple[ArrayLike, ArrayLike]"]


def _body(body: Body) -> Any:
    return _mesh(body, "body") if isinstance(body, tuple) else os.fspath(body)


def dress(
    pattern: PathLike,
    body: Body,
    out: PathLike,
    *,
    fabric: Optional[str] = None,
    resolution: float = 0.01,
    friction: Optional[float] = None,
    poses: Sequence[Body] = (),
    pose_rate: float = 30.0,
    pose_formats: Sequence[str] = (),
    up: Optional[str] = None,
    unit: Optional[float] = None,
    fit_origin: bool = False,
    budget: Optional[float] = None,
    pictures: bool = True,
) -> dict[str, Any]:
    """Puts a garment on a body and writes the folder of the result, as `selvedge dress` does.

    Args:
        pattern: file of a sewing pattern (JSON of GarmentCode).
        body: a mesh file, or vertices (n, 3) in metres with z up and triangles (m, 3).
        out: result folder, made if it does not exist.
        fabric: name of a measured fabric, or FILE.json#NAME.
        resolution: edge length of the mesh, m.
        friction: between fabric and body.
        poses: of the body, in order, as `body`, with the same triangles; such as an armature gives.
        pose_rate: poses per second.
        pose_formats: of the motion beside PLY, such as "gltf", "usd" or "pc2", in motion/.
        up: axis of pattern and body file that points up: "x", "y" or "z"; None: y, or what the
            body's file states.
        unit: metres per unit of the body's file; None: what it states, else 1.
        fit_origin: move a pattern that is drawn for a body with another origin to its place.
        budget: longest time, s.
        pictures: draw them.

    Returns:
        The content of result.json, with "verdict", "worn", "good" and "fit", and under "garment"
        arrays, z up: "x" (n, 3) in metres, "triangles" (m, 3), "flat_x" and "flat_triangles" of the
        pattern, "panels", "panel_of_triangle" (m), "pressure" (n) in Pa, and "body_x", the body as
        worn.

    Raises:
        ValueError: pattern, body or an option is wrong, or the folder holds something else.
        RuntimeError: the garment cannot be put on; the message and result.json say why.
        KeyboardInterrupt: after Ctrl-C; the folder is unfinished.
    """
    if up not in (None, "x", "y", "z"):
        raise ValueError(f'up is {up!r}; it must be "x", "y" or "z"')
    options = {
        "out": os.fspath(out),
        "fabric": fabric,
        "resolution": resolution,
        "friction": friction,
        "pose_rate": pose_rate,
        "pose_formats": [str(name) for name in pose_formats],
        "up": up,
        "unit": unit,
        "fit_origin": fit_origin,
        "budget": budget,
        "pictures": pictures,
    }
    text, garment = _core.dress(os.fspath(pattern), _body(body), [_body(p) for p in poses], options)
    return {**json.loads(text), "garment": garment}
