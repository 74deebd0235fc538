"""The parts of Makadam that are written in Rust."""

import os
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

__version__: str
BUILD: str
"""Version and hash of the sources that decide bits: checkpoints of builds of the same sources go on with the same bits."""

_Source = Union[Scene, Mapping[str, Any], str, os.PathLike[str]]
_Path = Union[str, os.PathLike[str]]
_Floats = NDArray[np.float64]

class Scene:
    """A scene: what is simulated, measured and compared. SI units throughout."""

    def __new__(cls, source: _Source, overrides: Optional[Mapping[str, Any]] = None) -> Scene: ...
    def with_overrides(self, overrides: Mapping[str, Any]) -> Scene:
        """The same scene with values replaced, by their paths."""
    @property
    def name(self) -> str: ...
    @property
    def description(self) -> str: ...
    @property
    def file(self) -> Optional[str]: ...
    @property
    def duration(self) -> float:
        """Simulated time of a run, s."""
    @property
    def time_step(self) -> float:
        """Time step, s."""
    @property
    def seed(self) -> int: ...
    @property
    def gravity(self) -> tuple[float, float, float]:
        """Acceleration of gravity at the start, m/s2."""
    @property
    def grains(self) -> int:
        """Number of grains."""
    @property
    def materials(self) -> list[str]: ...
    @property
    def walls(self) -> list[str]: ...
    def findings(self) -> list[str]:
        """What the settings are not expected to bear, in sentences."""
    def to_dict(self) -> dict[str, Any]: ...
    def to_toml(self) -> str: ...
    @staticmethod
    def _of_parts(text: str, file: Optional[_Path], as_written: bool) -> Scene: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...

class Frame:
    """Grains and contacts at a time, copied; rows are grains in the order of their ids."""

    @property
    def time(self) -> float:
        """Simulated time, s."""
    @property
    def positions(self) -> _Floats:
        """Centres, m: (n, 3)."""
    @property
    def velocities(self) -> _Floats:
        """Velocities, m/s: (n, 3)."""
    @property
    def spins(self) -> _Floats:
        """Angular velocities, rad/s: (n, 3)."""
    @property
    def radii(self) -> _Floats:
        """Radii, m: (n,)."""
    @property
    def coordination_number(self) -> float:
        """Mean number of contacts per grain that bear a force."""
    def contacts(self) -> dict[str, NDArray[Any]]:
        """The contacts of the last step that bear a force, as columns."""
    def __len__(self) -> int: ...
    @staticmethod
    def _of_bytes(bytes: bytes) -> Frame: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class Recording:
    """One run of a scene: its frames, and where they came from."""

    def __new__(
        cls,
        scene: _Source,
        frames: Sequence[Frame],
        seed: Optional[int] = None,
        wall_seconds: float = 0.0,
        time_step: Optional[float] = None,
    ) -> Recording: ...
    @staticmethod
    def load(scene: _Source, file: Union[str, os.PathLike[str]]) -> Recording: ...
    def save(self, file: Union[str, os.PathLike[str]]) -> None: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def code(self) -> str: ...
    @property
    def seed(self) -> int: ...
    @property
    def time_step(self) -> float:
        """Time step, s."""
    @property
    def wall_seconds(self) -> float:
        """Wall time of the steps, s."""
    @property
    def frames(self) -> list[Frame]: ...
    def measure(self) -> list[dict[str, Any]]:
        """What the scene measures of the frames from ``measure.from`` on: rows of observable, unit, value, standard_error, frames."""
    def series(self) -> list[dict[str, Any]]:
        """Observables over time: rows of observable, time (s) and value."""
    def save_frames(self, folder: _Path, *, walls: bool = True) -> None:
        """Writes the frames into a folder as ``makadam run`` does."""
    def picture(
        self,
        file: Optional[_Path] = None,
        time: Optional[float] = None,
        *,
        field: Optional[str] = None,
        range: Optional[tuple[float, float]] = None,
        view: str = "natural",
        clip: Optional[str] = None,
        walls: bool = True,
        all_grains: bool = False,
        size: tuple[int, int] = (1200, 900),
    ) -> NDArray[np.uint8]:
        """Draws the frame nearest to a time (s), or the last one; returns the pixels, (height, width, 3)."""
    def view(
        self,
        file: _Path,
        *,
        fields: Optional[Sequence[str]] = None,
        every: Optional[int] = None,
        megabytes: float = 200.0,
        contacts: bool = True,
        walls: bool = True,
        all_grains: bool = False,
    ) -> None:
        """Writes the frames as one HTML file to turn, cut and play in a browser."""
    @staticmethod
    def _of_bytes(scene: Scene, bytes: bytes, fatal: list[str]) -> Recording: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class Simulation:
    def __new__(cls, scene: Any, *arguments: Any, **settings: Any) -> Simulation: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def seed(self) -> int: ...
    @property
    def time(self) -> float:
        """Simulated time, s."""
    @property
    def time_step(self) -> float:
        """Time step, s."""
    @property
    def steps(self) -> int:
        """Steps taken."""
    @property
    def contact_count(self) -> int:
        """Contacts of the last step."""
    @property
    def rebuilds(self) -> int:
        """Number of times that the candidate list was built, and the rows of the views sorted anew."""
    @property
    def state_hash(self) -> str:
        """Hash of the state as 16 hexadecimal digits: what ``makadam run --json`` prints."""
    @property
    def radii(self) -> _Floats:
        """View of the radii, m: (n,), row by row; it cannot be written."""
    @property
    def inverse_masses(self) -> _Floats:
        """View of one over the masses, 1/kg: (n,), row by row; it cannot be written."""
    @property
    def ids(self) -> NDArray[np.uint32]:
        """View of the ids: (n,), which grain is in each row of the other views; it cannot be written."""
    @property
    def pairs(self) -> NDArray[np.uint32]:
        """Rows of the pairs of grains that may touch: (m, 2). A view that cannot be written; the next step leaves it as it is."""
    @property
    def pair_impulses(self) -> _Floats:
        """What ``pairs`` bore in the last step, N s: (m, 4), the normal impulse and the tangential one on the second grain."""
    @property
    def wall_pairs(self) -> NDArray[np.uint32]:
        """Grains, by row, and faces of walls that may touch: (k, 2)."""
    @property
    def wall_impulses(self) -> _Floats:
        """What ``wall_pairs`` bore in the last step, N s: (k, 4), the tangential impulse on the wall."""
    @property
    def live_views(self) -> int:
        """Number of live views of the grains' arrays."""
    def __len__(self) -> int:
        """Number of grains."""
    def energy(self) -> dict[str, float]:
        """Mechanical energy, J: kinetic, potential, elastic, cohesive."""
    def momentum(self) -> tuple[float, float, float]:
        """Momentum of the grains, kg m/s."""
    def phase_seconds(self) -> dict[str, float]:
        """Wall time of each phase of the steps so far, s."""
    def open_ledger(self) -> None:
        """Keeps a ledger of energy and momentum from here on."""
    def balance(self) -> Optional[dict[str, Any]]:
        """The ledger since it was opened (J, kg m/s); None if it was not."""
    def flow(self) -> Optional[dict[str, Any]]:
        """What came from the sources and went into the sinks of the scene, and lags (s); None without any."""
    @property
    def stage(self) -> Optional[str]:
        """Name of the stage of the last step; None for a scene without stages."""
    @property
    def ended(self) -> bool:
        """Whether the last stage of the scene has ended."""
    def stages(self) -> list[dict[str, Any]]:
        """The stages that have begun: ``name``, ``start`` and ``end`` (s), ``steps`` and ``ended`` of each."""
    def interrupt(self) -> None:
        """Asks the thread that steps to stop: it raises ``makadam.Interrupted``."""
    def checkpoint(self) -> bytes:
        """The state as a checkpoint, for ``resume``."""
    def frame(self) -> Frame:
        """A copy of the grains by id, with the contacts of the last step."""
    def grains(self) -> list[dict[str, Any]]:
        """The grains as a scene would list them now, in the order of their ids."""
    def save_frames(self, folder: _Path, frames: Optional[Sequence[Frame]] = None, *, walls: bool = True) -> None:
        """Writes frames, or the present state, into a folder as ``makadam run`` does."""
    def picture(
        self,
        file: Optional[_Path] = None,
        frame: Optional[Frame] = None,
        *,
        field: Optional[str] = None,
        range: Optional[tuple[float, float]] = None,
        view: str = "natural",
        clip: Optional[str] = None,
        walls: bool = True,
        all_grains: bool = False,
        size: tuple[int, int] = (1200, 900),
    ) -> NDArray[np.uint8]:
        """Draws the present state, or a frame, without a screen; returns the pixels, (height, width, 3)."""
    def view(
        self,
        file: _Path,
        frames: Optional[Sequence[Frame]] = None,
        *,
        fields: Optional[Sequence[str]] = None,
        every: Optional[int] = None,
        megabytes: float = 200.0,
        contacts: bool = True,
        walls: bool = True,
        all_grains: bool = False,
    ) -> None:
        """Writes frames, or the present state, as one HTML file to turn, cut and play in a browser."""
    @property
    def _positions(self) -> _Floats: ...
    @property
    def _velocities(self) -> _Floats: ...
    @property
    def _scaled_spins(self) -> _Floats: ...
    def _spins(self) -> _Floats: ...
    def _forget_interrupt(self) -> None: ...
    def _steps_of(self, duration: float) -> int: ...
    def _step(self, steps: int) -> list[str]: ...
    def _look(self) -> list[str]: ...
    def _copy(self) -> Simulation: ...
    @staticmethod
    def _resume(cls: Any, scene: Any, checkpoint: bytes, *settings: Any) -> Any: ...
    def _apply(self, forces: Optional[_Floats] = None, torques: Optional[_Floats] = None, on_top: bool = False) -> None: ...
    def _move_wall(self, wall: int, velocity: Any = None, rate: Optional[float] = None, about: Any = None) -> None: ...
    def _moved_by(self, wall: int) -> Optional[tuple[list[float], float]]: ...
    def _displacement(self, wall: int) -> tuple[list[float], float]: ...
    def _insert(self, grains: list[Any]) -> tuple[int, int]: ...
    def _remove(self, ids: list[int]) -> list[int]: ...
    def _measure(self, frames: list[Frame]) -> list[dict[str, Any]]: ...

def _command(arguments: Sequence[str]) -> int: ...
def scenes() -> list[str]:
    """Names of the scenes that Makadam holds, and of those in a folder ``reference-scenes`` here or above."""

def simulate(
    scene: _Source,
    seed: Optional[int] = None,
    *,
    code: str = "makadam",
    rayleigh_fraction: float = 0.2,
    time_limit: float = 86400.0,
) -> Recording:
    """Runs a scene from its start to its end in one code, on one core, and keeps a frame each ``measure.interval``."""

def observables() -> dict[str, str]:
    """Names of all observables, with the group of each, as ``measure.observables`` names it."""

def block_average(values: Sequence[float]) -> tuple[float, Optional[float]]:
    """Mean of consecutive values of one run, and its standard error over blocks of time."""

def ensemble(values: Sequence[float]) -> dict[str, Any]:
    """Mean and spread of one value per seed: seeds, mean, standard_deviation, interval90."""

def equivalence(first: Sequence[float], second: Sequence[float], margin: Optional[float] = None, codes: int = 2) -> dict[str, Any]:
    """Whether two ensembles agree: difference, interval90, interval_of_verdict, outcome, seeds_needed."""

def _measure(scene: _Source, frames: list[Frame]) -> list[dict[str, Any]]: ...
def _reference(scene: _Source) -> list[dict[str, Any]]: ...
def _compare(
    scene: _Source, codes: Optional[list[str]], live: bool, seeds: Optional[int], rayleigh_fraction: float, time_limit: float
) -> dict[str, Any]: ...
def _compare_runs(scene: _Source, runs: list[Recording], codes: Optional[list[str]]) -> dict[str, Any]: ...
