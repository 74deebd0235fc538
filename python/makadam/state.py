"""The state of a simulation: views of its arrays, copies, tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core
from .arrays import numbers, write

if TYPE_CHECKING:
    import pandas
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

__all__ = ["State"]


class State(_core.Simulation):
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

    def to_pandas(self) -> pandas.DataFrame:
        """The grains as a ``pandas.DataFrame``, a row for each id: x, y, z (m), vx, vy, vz (m/s), wx, wy, wz (rad/s), radius (m)."""
        from .tables import grains_to_pandas

        return grains_to_pandas(self.frame())
