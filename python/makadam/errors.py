"""Exceptions and warnings of Makadam; all exceptions but Ctrl-C's ``KeyboardInterrupt`` are ``makadam.Error``."""

from __future__ import annotations

from typing import Optional

__all__ = [
    "BusyError",
    "CheckpointError",
    "Error",
    "Interrupted",
    "InterventionError",
    "JudgeError",
    "MakadamWarning",
    "SceneError",
    "SceneNotFoundError",
    "SettingError",
    "StageError",
    "ViewError",
    "InvalidStateError",
]


class Error(Exception):
    """Whatever Makadam cannot do. The message says what is wrong, where, and what would be right."""


class SceneError(Error, ValueError):
    """A scene cannot be simulated as it is said."""

    path: str
    """Place in the document, such as ``wall[0].motion``; empty where it is not known."""
    line: Optional[int]
    """Line of the text, from 1; None where no person has written one."""
    file: Optional[str]
    """File that the scene came from, if it did."""
    problem: str
    """What is wrong."""
    remedy: str
    """What would be right."""

    def __init__(
        self,
        message: str,
        path: str = "",
        line: Optional[int] = None,
        file: Optional[str] = None,
        problem: str = "",
        remedy: str = "",
    ) -> None:
        super().__init__(message)
        self.path, self.line, self.file, self.problem, self.remedy = path, line, file, problem or message, remedy


class SceneNotFoundError(SceneError, FileNotFoundError):
    """There is no such file, and Makadam holds no scene of that name."""


class SettingError(Error, ValueError):
    """The machine, or the scene, does not go with a setting: threads, instruction set, method, precision, time step."""


class CheckpointError(Error, ValueError):
    """Bytes are no checkpoint of this version, or not one of this scene."""


class InterventionError(Error, ValueError):
    """Forces, insertions, removals, wall motions or written states that cannot be; the simulation stays as it was."""


class ViewError(Error, BufferError):
    """Grains cannot come or go while views of the arrays live, whose rows would be others."""


class BusyError(Error, RuntimeError):
    """Another thread, or the caller of this very callback, steps the simulation."""


class InvalidStateError(Error, RuntimeError):
    """A watchdog noticed what makes the numbers of a run invalid: deep overlaps, energy from nowhere, grains that are lost."""


class StageError(Error, RuntimeError):
    """A stage did not end within its ``at_most``; the state is that after its last step."""


class JudgeError(Error, RuntimeError):
    """Something cannot be measured or compared."""


class Interrupted(Error):
    """``Simulation.interrupt`` was called; the state is that after the last whole step."""


class MakadamWarning(UserWarning):
    """A watchdog noticed something that the scene tolerates."""
