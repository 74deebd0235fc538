"""The judge: observables of runs, recorded references, and verdicts on the agreement of codes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterable, Optional, Sequence

from . import _core
from ._core import Frame, Recording, observables, simulate
from .tables import columns, to_pandas

if TYPE_CHECKING:
    import pandas

    from .simulation import Source

__all__ = ["Comparison", "Recording", "compare", "measure", "observables", "reference", "simulate"]


class Comparison:
    """What a comparison of codes on a scene yields."""

    rows: list[dict[str, Any]]
    """An observable of a code, and its difference from another, a dict each: ``observable``, ``unit``, ``code``, ``mean`` and
    ``standard_deviation`` over ``seeds``, ``reference_code``, ``difference``, ``interval90``, ``interval_of_verdict``, ``margin``,
    ``outcome`` (``agree``, ``disagree``, ``undecided``, ``exploratory``, ``not-measured`` or None), ``missing`` and
    ``seeds_needed``."""
    codes: list[dict[str, Any]]
    """How each code was run."""
    notes: list[str]
    """What a reader must know."""
    verdict: str
    """The verdict on all rows in a sentence."""
    standing: str
    """The same in a word: ``agree``, ``disagree``, ``undecided``, ``exploratory`` (differences within the margins, of seeds that the scene has
    not registered), ``not-measured`` or ``nothing-compared``."""

    def __init__(self, document: dict[str, Any]) -> None:
        self.rows, self.codes, self.notes = document["rows"], document["codes"], document["notes"]
        self.verdict, self.standing = document["verdict"]["sentence"], document["verdict"]["standing"]

    @property
    def agrees(self) -> bool:
        """Whether every test agrees."""
        return self.standing == "agree"

    def columns(self) -> dict[str, list[Any]]:
        """The rows as columns."""
        return columns(self.rows)

    def to_pandas(self) -> pandas.DataFrame:
        """The rows as a ``pandas.DataFrame``."""
        return to_pandas(self.rows)

    def __repr__(self) -> str:
        return f"<makadam.Comparison of {len(self.codes)} codes: {self.verdict}>"


def measure(scene: Source, frames: Iterable[Frame]) -> list[dict[str, Any]]:
    """What a scene's ``measure.observables`` are of frames: rows, see ``Recording.measure``. All frames that are given count."""
    rows: list[dict[str, Any]] = _core._measure(scene, list(frames))
    return rows


def reference(scene: Source) -> list[dict[str, Any]]:
    """What is recorded of other codes on a scene: rows of ``code``, ``version``, ``seed``, ``observable``, ``unit``, ``value``,
    ``standard_error`` within the run, and ``frames``. Empty for a scene that nothing is recorded of; what was recorded before the scene
    changed does not count."""
    rows: list[dict[str, Any]] = list(_core._reference(scene))
    return rows


def compare(
    scene: Source,
    runs: Optional[Sequence[Recording]] = None,
    *,
    codes: Optional[Sequence[str]] = None,
    live: bool = False,
    seeds: Optional[int] = None,
    rayleigh_fraction: float = 0.2,
    time_limit: float = 86400.0,
) -> Comparison:
    """Compares codes on a scene by the margins that it names.

    Args:
        scene: A scene with ``[[compare]]``.
        runs: Runs of this scene that were made already, one per seed and all of one code, in place of Makadam's; they are held against
            what is recorded of the others. Each is of a seed of its own, goes to the end of the scene, and has all frames that it measures.
        codes: The codes: ``makadam``, ``yade``, ``liggghts``, ``lammps``, ``migflow``. Where none are given, Makadam and those that are recorded on
            the scene; with ``live`` the first three.
        live: Whether the other codes are run here and now, in place of what is recorded of them.
        seeds: Number of seeds, counted from 1; as many as are recorded where none is given.
        rayleigh_fraction: Time step of the explicit codes over the Rayleigh step.
        time_limit: Wall time after which a run of another code is stopped, s.

    Raises:
        makadam.JudgeError: The scene compares nothing, nothing is recorded of a code, a code failed, or runs are of another scene, of
            several codes or of one seed, are the same run, or are not whole.
    """
    if isinstance(codes, str):
        codes = (codes,)
    asked = None if codes is None else list(codes)
    if runs is not None:
        return Comparison(_core._compare_runs(scene, list(runs), asked))
    return Comparison(_core._compare(scene, asked, live, seeds, rayleigh_fraction, time_limit))
