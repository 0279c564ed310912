# SPDX-License-Identifier: MIT
"""Arrays as the compiled half needs them: checked, and copied only where their layout differs."""

from __future__ import annotations

import operator
import os
from collections.abc import Mapping
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Method = Union[str, Mapping[str, Any]]

_INT32 = np.iinfo(np.int32)


def _numeric(array: ArrayLike, name: str, kinds: str, wanted: str) -> NDArray[Any]:
    given = np.asarray(array)
    if given.size == 0 and given.dtype.kind in "fO":
        given = given.astype(np.float64 if "f" in kinds else np.int32)
    if given.dtype.kind not in kinds:
        raise TypeError(f"{name}: must hold {wanted}, has the data type {given.dtype}")
    return given


def _shaped(given: NDArray[Any], name: str, shape: tuple[Optional[int], ...]) -> NDArray[Any]:
    if given.size == 0 and given.ndim == 1 and shape[0] is None:
        return given.reshape((0,) + tuple(k or 0 for k in shape[1:]))
    if given.ndim != len(shape) or any(k is not None and k != n for k, n in zip(shape, given.shape)):
        words = ", ".join("n" if k is None else str(k) for k in shape)
        if len(shape) == 1:
            words += ","
        raise ValueError(f"{name}: must have the shape ({words}), has {given.shape}")
    return given


def numbers(array: ArrayLike, name: str, *shape: Optional[int]) -> NDArray[np.float64]:
    """An aligned, C-ordered float64 array of this shape; None stands for any length."""
    given = _shaped(_numeric(array, name, "fiu", "real numbers"), name, shape)
    return np.require(given, np.float64, ["C", "A"])


def positions(array: ArrayLike, name: str) -> NDArray[np.float64]:
    """(n, 3) float64."""
    return numbers(array, name, None, 3)


def indices(array: ArrayLike, name: str, *shape: Optional[int]) -> NDArray[np.int32]:
    """An aligned, C-ordered int32 array of this shape; None stands for any length."""
    given = _shaped(_numeric(array, name, "iu", "whole numbers"), name, shape)
    if given.dtype.itemsize > 4 or given.dtype.kind == "u":
        outside = np.argwhere((given < _INT32.min) | (given > _INT32.max))
        if outside.size:
            at = tuple(int(i) for i in outside[0])
            place = ", ".join(map(str, at))
            raise ValueError(f"{name}[{place}] is {given[at]}; an index has at most 32 bits")
    return np.require(given, np.int32, ["C", "A"])


def triangles(array: ArrayLike, name: str) -> NDArray[np.int32]:
    """(m, 3) int32."""
    return indices(array, name, None, 3)


def mesh(pair: Any, name: str) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """A pair (vertices, triangles)."""
    try:
        x, t = pair
    except (TypeError, ValueError):
        raise TypeError(f"{name}: must be a pair (vertices, triangles)") from None
    return positions(x, f"{name}: vertices"), triangles(t, f"{name}: triangles")


def finite(array: NDArray[np.float64], name: str) -> NDArray[np.float64]:
    """Refuses the first value that is not finite."""
    if not np.isfinite(array).all():
        at = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        place = ", ".join(map(str, at))
        raise ValueError(f"{name}[{place}] is {array[at]}; coordinates must be finite")
    return array


def whole(value: Any, name: str) -> int:
    """A whole number, such as that of a frame."""
    try:
        return operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: must be a whole number, is {value!r}") from None


def number(value: Any, name: str) -> float:
    """A real number, such as a distance."""
    try:
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: must be a number, is {value!r:.80}") from None


def path(value: Any, name: str, what: str = "the name of a file or folder") -> str:
    """The name of a file or folder."""
    try:
        return os.fsdecode(value)
    except TypeError:
        raise TypeError(f"{name}: must be {what}, is {value!r:.80}") from None


def callback(call: Any, name: str) -> Any:
    """A callable, or None."""
    if call is not None and not callable(call):
        raise TypeError(f"{name}: must be callable or None, is {call!r:.80}")
    return call


def method(choice: Method, name: str) -> dict[str, Any]:
    """{"type": name, option: value, ...} of a name, or of a mapping of that form."""
    if isinstance(choice, str):
        return {"type": choice}
    if not isinstance(choice, Mapping) or not isinstance(choice.get("type"), str):
        raise TypeError(f'{name}: must be a name, or a dict such as {{"type": name, option: value}}')
    out: dict[str, Any] = {}
    for key, value in choice.items():
        if key != "type" and not isinstance(value, (bool, int, float, np.number, np.bool_)):
            raise TypeError(f"{name}: option {key!r} must be a number or a bool, is {value!r}")
        out[str(key)] = value if key == "type" else float(value)
    return out
