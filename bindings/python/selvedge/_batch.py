# SPDX-License-Identifier: MIT
"""Many scenes stepped together on all cores."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import whole
from ._simulation import PathLike, Scene, Simulation, SimulationFailed, State, body_number

__all__ = ["Batch"]

Members = Optional[Union[int, Iterable[int]]]


class Batch:
    """Simulations in memory that are stepped together, one thread per member at a time. Each has
    the same bits as a Simulation of its scene alone, for any number of threads.

    Args:
        scenes: a list of scenes, or of what Scene takes. Members of equal scenes share the memory
            of a step: a further sheet of 30 x 30 vertices takes 0.3 MB. One of another scene takes
            13 MB, and so does one that refines, merges, untangles or carries tangled cloth on.
        driven: names or numbers of the bodies that `move_body` moves, the same in all scenes.

    Raises:
        ValueError: one sentence that begins with the number of the member.

    `batch[k]` is member k, a Simulation: read it, hold its vertices, set its forces, move its
    bodies. Only its arrays `positions` and `velocities` are views, of those of the batch. The
    contacts of its last step are kept if no other member has an equal scene.
    """

    def __init__(
        self,
        scenes: Sequence[Union[Scene, PathLike, Mapping[str, Any]]],
        *,
        driven: Sequence[Union[str, int]] = (),
    ) -> None:
        if isinstance(scenes, (str, Mapping, Scene)) or not isinstance(scenes, Iterable):
            raise TypeError(f"scenes: must be a list of scenes, is {scenes!r:.80}")
        if isinstance(driven, str) or not isinstance(driven, Iterable):
            raise TypeError(f"driven: must be a list of names or numbers, is {driven!r:.80}")
        equal: dict[tuple[str, str], Scene] = {}
        made = [s if isinstance(s, Scene) else Scene(s) for s in scenes]
        self.scenes = [equal.setdefault((s._core.json, s._place), s) for s in made]
        numbers: list[int] = []
        for name in driven:
            found = sorted({body_number(s, name) for s in equal.values()})
            if len(found) > 1:
                raise ValueError(
                    f"driven: {name!r} is body {found[0]} of one scene and {found[1]} of another; "
                    "put it at the same place in all of them"
                )
            numbers += found
        self._core = _core.Batch([s._core for s in self.scenes], numbers)

    def __len__(self) -> int:
        return len(self.scenes)

    def __getitem__(self, member: int) -> Simulation:
        number = whole(member, "member")
        if number < 0:
            number += len(self)
        if not 0 <= number < len(self):
            raise IndexError(f"there is no member {member}; the batch has {len(self)}")
        return Simulation._of_member(self.scenes[number], self._core.member(number))

    def _numbers(self, members: Members) -> list[int]:
        if members is None:
            return list(range(len(self)))
        if not isinstance(members, Iterable):
            members = [members]
        numbers = [whole(k, "members") for k in members]
        for k in numbers:
            if not 0 <= k < len(self):
                raise ValueError(f"members: there is no member {k}; the batch has {len(self)}")
        return numbers

    @staticmethod
    def _raise(failures: list[tuple[int, str, str]]) -> None:
        if not failures:
            return
        number, kind, cause = failures[0]
        more = f" ({len(failures) - 1} more failed)" if len(failures) > 1 else ""
        error = SimulationFailed(f"member {number}: {cause}{more}")
        error.kind = kind
        error.members = {k: sentence for k, _, sentence in failures}
        raise error

    def step(self, members: Members = None) -> None:
        """Each of the members makes one accepted step; None: all of them.

        Raises:
            SimulationFailed: after all others have made their step. `members` of the error is a
                dict of the sentence of each member that failed and kept its last good state.
        """
        self._raise(self._core.step(self._numbers(members)))

    def advance(self, frames: int = 1, members: Members = None) -> None:
        """Each of the members advances by this number of frames from its present one. Ctrl-C works
        between frames.

        Raises:
            SimulationFailed: as in `step`.
        """
        chosen = self._numbers(members)
        failures: dict[int, tuple[int, str, str]] = {}
        for _ in range(whole(frames, "frames")):
            left = [k for k in chosen if k not in failures]
            failures.update({f[0]: f for f in self._core.advance(1, left)})
        self._raise([failures[k] for k in sorted(failures)])

    def save(self, member: int) -> State:
        """The present state of one member, for `restore` in any batch or simulation of its scene."""
        return self[member].save()

    def restore(self, member: int, state: State) -> None:
        """One member continues from a state. Its forces and held vertices have to be set again."""
        self[member].restore(state)

    def reset(self, members: Members = None) -> None:
        """Puts members back to the start of their scenes; None: all of them."""
        for k in self._numbers(members):
            self._core.member(k).reset()

    @property
    def times(self) -> NDArray[np.float64]:
        """(b,) seconds, of each member."""
        return np.array([self._core.member(k).time for k in range(len(self))])

    def _stacked(self, flat: NDArray[np.float64], name: str) -> NDArray[np.float64]:
        sizes = sorted(set(np.diff(self.vertex_begin)))
        if len(sizes) > 1:
            raise ValueError(
                f"{name}: members have {sizes[0]} to {sizes[-1]} vertices, which is no array of "
                f"shape (b, n, 3); take flat_{name} with vertex_begin, or batch[k].{name}"
            )
        return flat.reshape(len(self), -1, 3)

    @property
    def positions(self) -> NDArray[np.float64]:
        """(b, n, 3) metres; a read-only view of memory that the steps write. Raises ValueError if
        the members have different numbers of vertices."""
        return self._stacked(self._core.positions, "positions")

    @property
    def velocities(self) -> NDArray[np.float64]:
        """(b, n, 3) m/s; as `positions`."""
        return self._stacked(self._core.velocities, "velocities")

    @property
    def flat_positions(self) -> NDArray[np.float64]:
        """(N, 3) metres, the vertices of all members one after another; a read-only view."""
        return self._core.positions

    @property
    def flat_velocities(self) -> NDArray[np.float64]:
        """(N, 3) m/s; as `flat_positions`."""
        return self._core.velocities

    @property
    def vertex_begin(self) -> NDArray[np.int64]:
        """(b + 1,) the first vertex of each member in the flat arrays, plus the total."""
        return np.array(self._core.vertex_begin, dtype=np.int64)

    def __repr__(self) -> str:
        return f"Batch({len(self)} members of {len({id(s) for s in self.scenes})} scenes)"
