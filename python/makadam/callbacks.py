"""What a simulation calls on its way: observers, forces, motions of walls."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Callable, Optional, Sequence

if TYPE_CHECKING:
    from .simulation import Simulation

__all__ = ["Handle", "Observer", "Steered", "Vector"]

Vector = Sequence[float]


class Handle:
    """What ``observe``, ``add_force`` and ``steer`` return: ``remove()`` ends it."""

    def __init__(self, registered: list[Any], entry: Any) -> None:
        self._registered, self._entry = registered, entry
        self._removed = False

    def remove(self) -> None:
        """Calls it no more; nothing happens if it was removed before."""
        if self._removed:
            return
        self._removed = True
        # The same function may have been added twice, and another may call itself equal: one entry goes, by what it is.
        for place, entry in enumerate(self._registered):
            if entry is self._entry:
                del self._registered[place]
                return


class Observer:
    def __init__(self, call: Callable[[Simulation], object], steps: int, seconds: float) -> None:
        self.call, self.steps, self.seconds = call, steps, seconds

    def is_due(self, step: int, time_step: float) -> bool:
        """Whether it is due after a step: at multiples of steps, or at the first step at or after each multiple of seconds."""
        if self.steps:
            return step % self.steps == 0
        if self.seconds <= time_step:
            return True

        def intervals(steps: int) -> int:
            # A thousandth of a step absorbs rounding where the interval is a whole number of steps.
            return math.floor((steps + 1e-3) * time_step / self.seconds)

        return intervals(step) > intervals(step - 1)

    def steps_until_due(self, step: int, time_step: float, most: int) -> int:
        """Steps after which it is due for the first time, at most so many."""
        if self.steps:
            return min(most, self.steps - step % self.steps)
        if self.seconds <= time_step:
            return min(most, 1)
        next_time = (math.floor((step + 1e-3) * time_step / self.seconds) + 1) * self.seconds
        ahead = next_time / time_step - step - 1
        if ahead >= most:
            return most
        near = max(1, int(ahead))
        while near < most and not self.is_due(step + near, time_step):
            near += 1
        return min(most, near)


class Steered:
    def __init__(self, wall: int, kind: str, call: Callable[[float], Any], about: Optional[tuple[Vector, Vector]]) -> None:
        self.wall, self.kind, self.call, self.about = wall, kind, call, about
