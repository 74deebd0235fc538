"""Granular matter by non-smooth contact dynamics, and its judge.

>>> import makadam
>>> drum = makadam.Simulation("drum", seed=1, threads=2)
>>> drum.run(0.5)
>>> drum.velocities.shape
(1600, 3)

SI units throughout. ``Scene`` says what is simulated, ``Simulation`` steps it, ``judge`` measures and compares, ``statistics`` holds its
statistics, ``tables`` makes tables, and ``errors`` lists what can go wrong.
"""

from __future__ import annotations

from . import errors, judge, statistics, tables
from ._core import BUILD, Frame, Recording, Scene, __version__, observables, scenes, simulate
from .errors import (
    BusyError,
    CheckpointError,
    Error,
    Interrupted,
    InterventionError,
    JudgeError,
    MakadamWarning,
    SceneError,
    SceneNotFoundError,
    SettingError,
    StageError,
    ViewError,
    InvalidStateError,
)
from .judge import Comparison, compare, measure, reference
from .simulation import Handle, Simulation

__all__ = [
    "BUILD",
    "BusyError",
    "CheckpointError",
    "Comparison",
    "Error",
    "Frame",
    "Handle",
    "Interrupted",
    "InterventionError",
    "JudgeError",
    "MakadamWarning",
    "Recording",
    "Scene",
    "SceneError",
    "SceneNotFoundError",
    "SettingError",
    "StageError",
    "Simulation",
    "ViewError",
    "InvalidStateError",
    "__version__",
    "compare",
    "errors",
    "judge",
    "measure",
    "observables",
    "reference",
    "scenes",
    "simulate",
    "statistics",
    "tables",
]
