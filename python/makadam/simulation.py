"""The simulation: how it begins, goes on and takes its steps, and who is called on the way.

``state`` has its views and copies, ``interventions`` what the caller does to it.
"""

from __future__ import annotations

import math
import os
import threading
import warnings
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, Callable, Iterator, Literal, Mapping, NoReturn, Optional, Sequence, Union

import numpy as np

from . import _core
from ._core import Frame, Scene
from .arrays import whole
from .callbacks import Handle, Observer
from .errors import BusyError, Error, MakadamWarning, SettingError
from .interventions import Interventions
from .state import State

if TYPE_CHECKING:
    Source = Union[Scene, Mapping[str, Any], str, "os.PathLike[str]"]

__all__ = ["Handle", "Simulation"]


class Simulation(State, Interventions):
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
        watch: Whether watchdogs look at the steps as the scene's ``[watch]`` says. What makes numbers invalid raises
            ``makadam.InvalidStateError``, what is tolerated is a ``makadam.MakadamWarning``.

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
        """Another simulation with the same state, which goes its own way.

        Forces that ``apply_forces`` gave for the step to come act in it, too. Observers, callbacks of ``add_force`` and functions of
        ``steer`` are not copied; a wall that was steered goes on as it last moved.
        """
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

        A scene with ``[[stage]]`` goes through its stages: ``stage`` is the name of the present one, ``ended`` is true after the last.

        Raises:
            KeyboardInterrupt: At Ctrl-C.
            makadam.Interrupted: ``interrupt`` was called.
            makadam.InvalidStateError: The state makes the numbers of the run invalid.
            makadam.BusyError: Another thread steps this simulation, or it is called from one of its callbacks.
        """
        left = whole(steps, "steps")
        with self._stepping():
            self._step_and_call(left)

    @contextmanager
    def _stepping(self) -> Iterator[None]:
        if not self._busy.acquire(blocking=False):
            raise BusyError("this simulation is being stepped: by another thread, or because this was called from a callback")
        try:
            yield
        except BaseException:
            # Whatever ends the steps answers a request to stop, too; forces of callbacks were for the step that was not taken.
            with suppress(Error):
                self._forget_interrupt()
                self._apply(None, None, True)
            raise
        finally:
            self._busy.release()

    def _step_and_call(self, left: int) -> None:
        # Who asks for single steps has them watched every so many; who asks for many is told what the last one has left.
        many = left > 1
        if not (self._observers or self._forces or self._steered):
            self._take(left)
            if many:
                self._tell(self._look(), 4)
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
                self._tell(self._look(), 4)
            for observer in list(self._observers):
                if observer in self._observers and observer.is_due(number + some, h):
                    observer.call(self)

    def run(self, duration: float) -> None:
        """Takes the steps of a duration, s: as many as come nearest to it.

        What that leaves below a step counts in the next ``run``, so that a duration in parts takes as many steps as the whole. Errors as of
        ``step``.
        """
        if not (isinstance(duration, (int, float, np.number)) and math.isfinite(duration) and duration >= 0):
            raise SettingError(f"cannot run for {duration!r} s; give a finite number of seconds, 0 or more")
        steps = float(duration) / self.time_step
        if steps >= 2.0**63:
            raise SettingError(f"cannot run for {duration!r} s: that is {steps:.3g} steps; give less")
        end = self.time + float(duration)
        with self._stepping():
            if self.stage is None:
                self._step_and_call(self._steps_of(float(duration)))
            while self.stage is not None and self.time < end - 0.5 * self.time_step:
                # A stage may have another time step.
                self._step_and_call(1)

    def finish(self) -> None:
        """Takes the steps up to the end of the last stage of the scene. Errors as of ``step``.

        Raises:
            makadam.SettingError: The scene has no stages.
            makadam.StageError: A stage did not end within its ``at_most``.
        """
        if self.stage is None:
            raise SettingError("the scene has no stages; use run(duration)")
        with self._stepping():
            while not self.ended:
                self._step_and_call(1)

    def _take(self, steps: int) -> None:
        self._tell(self._step(steps), 5)

    def _tell(self, messages: list[str], above: int) -> None:
        """Warns the caller so many functions above this one."""
        for message in messages:
            warnings.warn(message, MakadamWarning, stacklevel=above)

    def observe(self, callback: Callable[[Simulation], object], *, steps: Optional[int] = None, seconds: Optional[float] = None) -> Handle:
        """Calls ``callback(simulation)`` every so many steps, or every so many seconds of simulated time.

        Times are counted from the start of the simulation: with ``seconds=0.1`` it is called after the first step at or after each
        multiple of 0.1 s. What it raises ends ``step``. It may read and write views, apply forces, move walls, and insert and remove
        grains, but not step. Forces that it applies act in the step after it, together with those of ``add_force``.
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

    def __repr__(self) -> str:
        return f"<makadam.Simulation of '{self.scene.name}': {len(self)} grains, step {self.steps}, {self.time:.6g} s>"
