"""The simulation: steps, views, observers, forces, walls and grains that the caller moves."""

from __future__ import annotations

import math
import os
import threading
import warnings
from typing import TYPE_CHECKING, Any, Callable, Iterable, Literal, Mapping, NoReturn, Optional, Sequence, Union

import numpy as np

from . import _core
from ._core import Frame, Scene
from .arrays import numbers, spread, whole, write
from .callbacks import Handle, Observer, Steered, Vector
from .errors import BusyError, InterventionError, MakadamWarning, SettingError

if TYPE_CHECKING:
    import pandas
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]
    Source = Union[Scene, Mapping[str, Any], str, "os.PathLike[str]"]
    Forces = Union[ArrayLike, tuple[Optional[ArrayLike], Optional[ArrayLike]], None]

__all__ = ["Handle", "Simulation"]

class Simulation(_core.Simulation):
    """A scene in motion. SI units throughout.

    Args:
        scene: A scene, or what ``makadam.Scene`` takes: a dict, a TOML text, a path or a name.
        seed: Seed of the positions and radii of the grains; the scene's where none is given.
        threads: Number of threads. It changes the time, never a bit of the result, as do ``scheduler`` and ``instruction_set``.
        scheduler: ``"serial"``, ``"central-queue"`` or ``"work-stealing"``.
        instruction_set: ``"generic"``, ``"avx2"`` or ``"avx512"``; the widest that the processor has where none is given.
        time_step: Time step, s, in place of the scene's.
        precision: ``"double"`` or ``"single"``, in place of the scene's.
        method: How contact problems are solved, such as ``"gauss-seidel"``, in place of the scene's.
        watch: Whether watchdogs look at the steps as the scene's ``[watch]`` says. What makes numbers worthless raises
            ``makadam.WorthlessError``, what is tolerated is a ``makadam.MakadamWarning``.

    A scene that begins with a flowing state (``[prepare]``) is simulated for that time first; the state is kept on the machine.

    **Views.** ``positions``, ``velocities``, ``scaled_spins``, ``radii``, ``inverse_masses`` and ``ids`` are arrays that lie in the memory
    of the simulation: nothing is copied, what is written to the first three counts from the next step on, and a view that was taken before a
    step reads true after it. Their rows are the grains as they lie in memory. That order changes when a step builds the candidate list anew
    (``rebuilds`` counts that); ``ids`` follows, and ``rows`` tells the row of each id. A view keeps the simulation alive. Grains can
    neither come nor go while one lives. Reading a view while another thread steps gives numbers of before or after the step at hand; writing
    to one then may be lost. ``frame()`` waits for the step, and copies by id.

    While views of positions, velocities or spins live, watchdogs do not look for energy from nowhere: whoever holds one may have written it.

    Raises:
        makadam.SceneError: The scene cannot be simulated, or its grains cannot be placed.
        makadam.SettingError: The machine or the scene does not go with a setting.
    """

    _observers: list[Observer]
    _forces: list[Callable[[Simulation], Forces]]
    _steered: list[Steered]
    _busy: threading.Lock

    def __init__(
        self,
        scene: Union[Source, _core.Simulation],
        seed: Optional[int] = None,
        *,
        threads: int = 1,
        scheduler: Optional[Literal["serial", "central-queue", "work-stealing"]] = None,
        instruction_set: Optional[Literal["generic", "avx2", "avx512"]] = None,
        time_step: Optional[float] = None,
        precision: Optional[Literal["double", "single"]] = None,
        method: Optional[str] = None,
        watch: bool = True,
    ) -> None:
        self._observers, self._forces, self._steered = [], [], []
        self._busy = threading.Lock()

    @classmethod
    def resume(
        cls,
        scene: Source,
        checkpoint: bytes,
        *,
        seed: Optional[int] = None,
        threads: int = 1,
        scheduler: Optional[str] = None,
        instruction_set: Optional[str] = None,
        time_step: Optional[float] = None,
        precision: Optional[str] = None,
        method: Optional[str] = None,
        watch: bool = True,
    ) -> Simulation:
        """Goes on from a checkpoint of the same scene with the same settings, bit for bit as if it had never stopped.

        The seed is that of the checkpoint. What is measured, written, compared and watched for may be another than at the start.

        Grains that were inserted, written states and the places of walls that were moved are in it. Forces of the step to come and
        callbacks are not: they are given again.

        Raises:
            makadam.CheckpointError: The bytes are damaged, or of another version, scene, seed, time step, precision or method.
        """
        resumed: Simulation = cls._resume(
            cls, scene, checkpoint, seed, threads, scheduler, instruction_set, time_step, precision, method, watch
        )
        return resumed

    def copy(self) -> Simulation:
        """Another simulation with the same state, which goes its own way. It has no observers, forces or steered walls of this one."""
        return type(self)(self._copy())

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "a simulation is neither pickled nor deep-copied, since its callbacks are not part of its state: copy() makes another one, and "
            "checkpoint() gives bytes, from which Simulation.resume goes on"
        )

    # Steps

    def step(self, steps: int = 1) -> None:
        """Takes so many steps, without the interpreter's lock but for callbacks.

        Ctrl-C ends it: the state is that after the last whole step, also where it comes within a long step.

        Raises:
            KeyboardInterrupt: At Ctrl-C.
            makadam.Interrupted: ``interrupt`` was called.
            makadam.WorthlessError: The state makes the numbers of the run worthless.
            makadam.BusyError: Another thread steps this simulation, or it is called from one of its callbacks.
        """
        left = whole(steps, "steps")
        if not self._busy.acquire(blocking=False):
            raise BusyError("this simulation is being stepped: by another thread, or because this was called from a callback")
        try:
            self._step_and_call(left)
        finally:
            self._busy.release()

    def _step_and_call(self, left: int) -> None:
        # Who asks for single steps has them watched every so many; who asks for many is told what the last one has left.
        many = left > 1
        if not (self._observers or self._forces or self._steered):
            self._take(left)
            if many:
                self._tell(self._look(), 5)
            return
        h = self.time_step
        while left > 0:
            some, number = left, self.steps
            for observer in self._observers:
                some = observer.steps_until_due(number, h, some)
            if self._steered:
                self._steer_walls(h)
                some = 1
            if self._forces:
                self._push_grains()
                some = 1
            self._take(some)
            left -= some
            if many and left == 0:
                # Before observers, which may bring grains and with them energy.
                self._tell(self._look(), 5)
            for observer in list(self._observers):
                if observer in self._observers and observer.is_due(number + some, h):
                    observer.call(self)

    def run(self, duration: float) -> None:
        """Takes the steps of a duration, s: as many whole steps as are nearest to it. Errors as of ``step``."""
        if not (isinstance(duration, (int, float, np.number)) and math.isfinite(duration) and duration >= 0):
            raise SettingError(f"cannot run for {duration!r} s; give a finite number of seconds, 0 or more")
        steps = float(duration) / self.time_step
        if steps >= 2.0**63:
            raise SettingError(f"cannot run for {duration!r} s: that is {steps:.3g} steps; give less")
        self.step(round(steps))

    def _take(self, steps: int) -> None:
        self._tell(self._step(steps), 6)

    def _tell(self, messages: list[str], above: int) -> None:
        """Warns whoever called so many functions above this one."""
        for message in messages:
            warnings.warn(message, MakadamWarning, stacklevel=above)

    def observe(self, callback: Callable[[Simulation], object], *, steps: Optional[int] = None, seconds: Optional[float] = None) -> Handle:
        """Calls ``callback(simulation)`` every so many steps, or every so many seconds of simulated time.

        Times are counted from the start of the simulation: with ``seconds=0.1`` it is called after the first step at or after each
        multiple of 0.1 s. What it raises ends ``step``. It may read and write views, apply forces, move walls, and insert and remove
        grains, but not step.
        """
        if (steps is None) == (seconds is None):
            raise SettingError("give either steps or seconds between two calls")
        if steps is not None and whole(steps, "steps between two calls") == 0:
            raise SettingError("cannot call every 0 steps; give 1 or more")
        if seconds is not None and not (math.isfinite(seconds) and seconds > 0):
            raise SettingError(f"cannot call every {seconds!r} s; give a finite number above 0")
        if not callable(callback):
            raise TypeError("the observer cannot be called; give a function of the simulation")
        observer = Observer(callback, int(steps or 0), float(seconds or 0.0))
        self._observers.append(observer)
        return Handle(self._observers, observer)

    # Views

    @property
    def positions(self) -> Floats:
        """View of the centres, m: (n, 3), row by row as the grains lie in memory.

        Where the domain repeats itself they may lie outside of it. A grain that is put elsewhere is found by its new neighbours in the
        next step; nothing keeps it from being put into another grain or a wall, which then push it out.
        """
        return self._positions

    @positions.setter
    def positions(self, values: ArrayLike) -> None:
        write(self._positions, values, "positions")

    @property
    def velocities(self) -> Floats:
        """View of the velocities, m/s: (n, 3), row by row as the grains lie in memory."""
        return self._velocities

    @velocities.setter
    def velocities(self, values: ArrayLike) -> None:
        write(self._velocities, values, "velocities")

    @property
    def scaled_spins(self) -> Floats:
        """View of the radii times the angular velocities, m/s: (n, 3), row by row as the grains lie in memory.

        This is what a simulation keeps of a spin: the speed of the surface of the grain.
        """
        return self._scaled_spins

    @scaled_spins.setter
    def scaled_spins(self, values: ArrayLike) -> None:
        write(self._scaled_spins, values, "scaled spins")

    @property
    def spins(self) -> Floats:
        """Angular velocities, rad/s: (n, 3), row by row as the grains lie in memory.

        A copy that cannot be written, since ``scaled_spins`` is what is kept; ``simulation.spins = values`` writes.
        """
        spins: Floats = self._spins()
        spins.flags.writeable = False
        return spins

    @spins.setter
    def spins(self, values: ArrayLike) -> None:
        scaled = self._scaled_spins
        write(scaled, numbers(values, scaled.shape, "spins") * self.radii[:, np.newaxis], "spins")

    @property
    def masses(self) -> Floats:
        """Masses, kg: (n,), row by row as the grains lie in memory. A copy; the view is ``inverse_masses``."""
        return 1.0 / self.inverse_masses

    @property
    def rows(self) -> NDArray[np.intp]:
        """Row of each id, (n,): ``simulation.velocities[simulation.rows]`` is by id. A copy, good until the next step."""
        rows = np.empty(len(self), dtype=np.intp)
        rows[self.ids] = np.arange(len(rows))
        return rows

    # Contacts and tables

    def contacts(self) -> dict[str, NDArray[Any]]:
        """The contacts of the last step that bear a force, as columns: see ``Frame.contacts``.

        Contacts are kept eight to a lane group, so these columns are gathered. ``pairs`` and ``pair_impulses`` are views.
        """
        return self.frame().contacts()

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
        Rows are those of the views. The forces of several callbacks are added.
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
        self._apply(*sums)

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
            position: How far the wall is then from where the scene has it, m. Its velocity in a step leads to where it says it will be.
            rate: Angular velocity in the step that begins at that time, rad/s.
            angle: How far the wall has turned then, rad.
            about: A point of the axis (m) and its direction, as for ``move_wall``.

        Returns:
            A handle; a wall whose handle was removed goes on as it last moved.
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
        self._steered.append(steered)
        return Handle(self._steered, steered)

    def _steer_walls(self, h: float) -> None:
        now = self.time
        for one in list(self._steered):
            moved = self._moved_by(one.wall)
            if one.kind == "velocity":
                velocity: Optional[Vector] = one.call(now)
                self._move_wall(one.wall, velocity, None, None)
            elif one.kind == "position":
                there = np.asarray(one.call(now + h), dtype=float)
                here = np.asarray(one.call(now) if moved is None else moved[0], dtype=float)
                self._move_wall(one.wall, ((there - here) / h).tolist(), None, None)
            else:
                about = one.about
                if one.kind == "rate":
                    rate = float(one.call(now))
                else:
                    rate = (float(one.call(now + h)) - (float(one.call(now)) if moved is None else moved[1])) / h
                self._move_wall(one.wall, None, rate, about)

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

    # The judge

    def measure(self, frames: Optional[Sequence[Frame]] = None) -> list[dict[str, Any]]:
        """What the scene's ``measure.observables`` are of frames of this simulation; of the present state where none are given.

        Returns:
            Rows, each a dict of ``observable``, ``unit``, ``value``, ``standard_error`` (over blocks of time; None for too few frames) and
            ``frames``. What cannot be measured is left out. ``pandas.DataFrame(rows)`` makes a table of them.
        """
        rows: list[dict[str, Any]] = self._measure([self.frame()] if frames is None else list(frames))
        return rows

    def record(self, duration: float, interval: Optional[float] = None) -> list[Frame]:
        """Runs for a duration, s, and keeps the frame at the start and one every ``interval``, s: ``measure.interval`` of the scene where
        none is given."""
        every = self.scene.to_dict()["measure"]["interval"] if interval is None else interval
        frames = [self.frame()]
        handle = self.observe(lambda simulation: frames.append(simulation.frame()), seconds=every)
        try:
            self.run(duration)
        finally:
            handle.remove()
        return frames

    def to_pandas(self) -> pandas.DataFrame:
        """The grains as a ``pandas.DataFrame``, a row for each id: x, y, z (m), vx, vy, vz (m/s), wx, wy, wz (rad/s), radius (m)."""
        from .tables import grains_to_pandas

        return grains_to_pandas(self.frame())

    def __repr__(self) -> str:
        return f"<makadam.Simulation of '{self.scene.name}': {len(self)} grains, step {self.steps}, {self.time:.6g} s>"
