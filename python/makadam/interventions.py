"""What the caller does to a simulation between its steps: forces, walls that move, grains that come and go."""

from __future__ import annotations

from typing import TYPE_CHECKING, Callable, Iterable, Optional, Union

import numpy as np

from . import _core
from .arrays import floats, numbers, spread, whole
from .callbacks import Handle, Steered, Vector
from .errors import InterventionError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .simulation import Simulation

    Floats = NDArray[np.float64]
    Forces = Union[ArrayLike, tuple[Optional[ArrayLike], Optional[ArrayLike]], None]

__all__ = ["Interventions"]

SAME_PLACE = 1e-9
"""How far a function may begin from where its wall stands, m or rad, absolutely and as a part of either."""


class Interventions(_core.Simulation):
    _forces: list[Callable[[Simulation], Forces]]
    _steered: list[Steered]

    # Forces

    def apply_forces(self, forces: Optional[ArrayLike] = None, torques: Optional[ArrayLike] = None) -> None:
        """Has forces (N) and torques about the centres (N m) act in the next step, and in no other: (n, 3) each, row by row as in the views.

        They are on top of gravity, and replace what was given before for the same step.

        Raises:
            makadam.InterventionError: An array has another shape, or numbers that are not finite.
        """
        shape = (len(self), 3)
        self._apply(
            None if forces is None else numbers(forces, shape, "forces"),
            None if torques is None else numbers(torques, shape, "torques"),
        )

    def add_force(self, callback: Callable[[Simulation], Forces]) -> Handle:
        """Calls ``callback(simulation)`` before each step for the forces that act in it.

        It returns an array of forces, N, (n, 3); or a pair of forces and torques, N m, either of which may be None; or None for none.
        Rows are those of the views. The forces of several callbacks are added, and act on top of those of ``apply_forces``.
        """
        if not callable(callback):
            raise TypeError("the force cannot be called; give a function of the simulation")
        self._forces.append(callback)
        return Handle(self._forces, callback)

    def _push_grains(self) -> None:
        shape = (len(self), 3)
        sums: list[Optional[Floats]] = [None, None]
        for callback in list(self._forces):
            given = callback(self)
            pair = given if isinstance(given, tuple) else (given, None)
            if len(pair) != 2:
                raise InterventionError("a force callback gives forces, or a pair of forces and torques")
            for place, (name, part) in enumerate(zip(("forces", "torques"), pair)):
                if part is not None:
                    array = numbers(part, shape, name)
                    before = sums[place]
                    sums[place] = array if before is None else before + array
        self._apply(*sums, True)

    # Walls

    def move_wall(
        self,
        wall: Union[str, int],
        *,
        velocity: Optional[Vector] = None,
        rate: Optional[float] = None,
        about: Optional[tuple[Vector, Vector]] = None,
    ) -> None:
        """Moves a wall from the next step on, until it is told otherwise: along, or about an axis.

        Args:
            wall: Its name, or its number in the scene.
            velocity: Velocity, m/s.
            rate: Angular velocity about the axis, rad/s.
            about: A point of the axis (m) and its direction; needed where the scene does not turn the wall already.

        It goes from where it stands, whatever the scene says of its motion. Grains have no influence on it. The first velocity is a jump,
        and grains that the wall meets take an impact; later changes count as acceleration, as those of a vibrating wall.

        Raises:
            makadam.InterventionError: There is no such wall, or it cannot be moved so.
        """
        self._move_wall(self._wall(wall), velocity, rate, about)

    def moved_by(self, wall: Union[str, int]) -> Optional[tuple[Floats, float]]:
        """How far a wall that was moved has moved along (m, (3,)) and turned (rad) from where the scene has it; None for other walls."""
        moved = self._moved_by(self._wall(wall))
        return None if moved is None else (np.array(moved[0]), moved[1])

    def steer(
        self,
        wall: Union[str, int],
        *,
        velocity: Optional[Callable[[float], Vector]] = None,
        position: Optional[Callable[[float], Vector]] = None,
        rate: Optional[Callable[[float], float]] = None,
        angle: Optional[Callable[[float], float]] = None,
        about: Optional[tuple[Vector, Vector]] = None,
    ) -> Handle:
        """Moves a wall as a function of time, s, says, which is asked before each step.

        Args:
            wall: Its name, or its number in the scene.
            velocity: Velocity in the step that begins at that time, m/s.
            position: How far the wall is then from where the scene has it, m. Its velocity in a step leads to where it says it will be. It
                begins where the wall stands when this is called: 0 for a wall that has not moved.
            rate: Angular velocity in the step that begins at that time, rad/s.
            angle: How far the wall has turned then, rad, as ``position``.
            about: A point of the axis (m) and its direction, as for ``move_wall``.

        Returns:
            A handle; a wall whose handle was removed goes on as it last moved.

        Raises:
            makadam.InterventionError: There is no such wall, it cannot be moved so, or it would jump.
        """
        given = {
            kind: call for kind, call in (("velocity", velocity), ("position", position), ("rate", rate), ("angle", angle)) if call is not None
        }
        if len(given) != 1:
            raise InterventionError("give one of velocity, position, rate and angle")
        kind, call = next(iter(given.items()))
        if not callable(call):
            raise TypeError(f"{kind} cannot be called; give a function of time, or use move_wall")
        steered = Steered(self._wall(wall), kind, call, about)
        self._refuse_jump(steered)
        self._steered.append(steered)
        return Handle(self._steered, steered)

    def _refuse_jump(self, one: Steered) -> None:
        """A function of place must begin where the wall stands: it would go the difference within a step."""
        if one.kind not in ("position", "angle"):
            return
        shift, angle = self._displacement(one.wall)
        unit, here = ("m", np.array(shift)) if one.kind == "position" else ("rad", np.array(angle))
        given = floats(one.call(self.time), one.kind)
        if given.shape != here.shape:
            raise InterventionError(f"the function of the {one.kind} gives an array of shape {given.shape}; give one of {here.shape}")
        if not (np.abs(given - here) <= SAME_PLACE * (1.0 + np.abs(here))).all():
            raise InterventionError(
                f"the function of the {one.kind} gives {given.tolist()} {unit} at {self.time} s, and wall '{self.scene.walls[one.wall]}' "
                f"stands at {here.tolist()} {unit} from where the scene has it, so that it would jump within a step; let the function begin "
                "where the wall stands, such as by subtracting its own first value"
            )

    def _steer_walls(self, h: float) -> None:
        now = self.time
        for one in list(self._steered):
            shift, turned = self._displacement(one.wall)
            if one.kind == "velocity":
                velocity: Optional[Vector] = one.call(now)
                self._move_wall(one.wall, velocity, None, None)
            elif one.kind == "position":
                there = np.asarray(one.call(now + h), dtype=float)
                self._move_wall(one.wall, ((there - shift) / h).tolist(), None, None)
            else:
                rate = float(one.call(now)) if one.kind == "rate" else (float(one.call(now + h)) - turned) / h
                self._move_wall(one.wall, None, rate, one.about)

    def _wall(self, wall: Union[str, int]) -> int:
        names = self.scene.walls
        if isinstance(wall, str):
            if wall not in names:
                raise InterventionError(f"there is no wall '{wall}'; the scene has {', '.join(names) or 'none'}")
            return names.index(wall)
        number = whole(wall, "the number of a wall")
        if number >= len(names):
            raise InterventionError(f"there is no wall {number}; the scene has {len(names)}, counted from 0")
        return number

    # Grains

    def insert(
        self,
        positions: ArrayLike,
        radii: ArrayLike,
        *,
        material: Optional[str] = None,
        velocities: Optional[ArrayLike] = None,
        spins: Optional[ArrayLike] = None,
    ) -> range:
        """Adds grains, and returns their ids, which follow those that are there.

        Args:
            positions: Centres, m: (k, 3), or (3,) for one grain.
            radii: Radii, m: (k,), or one number.
            material: Name of one of the scene's materials; needed where there are several.
            velocities: Velocities, m/s: (k, 3), or (3,) for all; 0 where none are given.
            spins: Angular velocities, rad/s, as ``velocities``.

        The simulation is then one that begins with these grains, the impulses of their contacts and the time that it is: what resuming a
        checkpoint of them would give, bit for bit. No contacts are known until the next step was taken.

        Raises:
            makadam.ViewError: Views of the arrays live, whose rows would be others.
            makadam.InterventionError: A grain lies outside the domain, in a wall or in another grain, or has no sound radius or material.
        """
        names = self.scene.materials
        if material is None:
            if len(names) != 1:
                raise InterventionError(f"say of which material the grains are: the scene has {', '.join(names)}")
            material = names[0]
        places = np.atleast_2d(np.asarray(positions, dtype=float))
        if places.ndim != 2 or places.shape[1] != 3:
            raise InterventionError(f"positions have the shape {np.shape(positions)}; give (k, 3), or (3,) for one grain")
        count = len(places)
        size = spread(radii, (count,), "radii")
        motion = [spread(0.0 if part is None else part, (count, 3), name) for part, name in ((velocities, "velocities"), (spins, "spins"))]
        rows = zip(size.tolist(), places.tolist(), motion[0].tolist(), motion[1].tolist())
        first, end = self._insert([(material, *row) for row in rows])
        return range(first, end)

    def remove(self, ids: Union[int, Iterable[int], ArrayLike]) -> NDArray[np.int64]:
        """Removes grains by their ids. The others keep their order and are numbered anew, without holes.

        Returns:
            The new id of each old one, (n,), -1 for those that are gone: ``new[old]``.

        Raises:
            makadam.ViewError: Views of the arrays live, whose rows would be others.
            makadam.InterventionError: There is no such grain.
        """
        given = np.atleast_1d(np.asarray(ids))
        if given.size == 0:
            given = given.astype(np.int64)
        if not np.issubdtype(given.dtype, np.integer):
            raise InterventionError(f"ids are of type {given.dtype}; give whole numbers (np.flatnonzero makes them of a mask)")
        wrong = given[(given < 0) | (given >= len(self))]
        if wrong.size:
            raise InterventionError(f"there is no grain {wrong[0]} to remove; ids go from 0 to {len(self) - 1} without holes")
        return np.array(self._remove([int(one) for one in given.ravel()]), dtype=np.int64)
