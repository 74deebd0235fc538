"""Tables: rows as dicts, columns as dicts of lists, and DataFrames of pandas where that is there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterable, Mapping

import numpy as np

from ._core import Frame

if TYPE_CHECKING:
    import pandas

__all__ = ["columns", "contacts_to_pandas", "grains_to_pandas", "to_pandas"]


def columns(rows: Iterable[Mapping[str, Any]]) -> dict[str, list[Any]]:
    """The columns of a table that is given by rows; what a row lacks is None."""
    table = list(rows)
    names = list(dict.fromkeys(name for row in table for name in row))
    return {name: [row.get(name) for row in table] for name in names}


def to_pandas(rows: Iterable[Mapping[str, Any]]) -> pandas.DataFrame:
    """A ``pandas.DataFrame`` of rows, such as those of ``Recording.measure`` or of ``Comparison.rows``."""
    return _frame(columns(rows))


def grains_to_pandas(frame: Frame) -> pandas.DataFrame:
    """The grains of a frame, a row for each id: x, y, z (m), vx, vy, vz (m/s), wx, wy, wz (rad/s), radius (m)."""
    vectors = (("", frame.positions), ("v", frame.velocities), ("w", frame.spins))
    table = {f"{name}{axis}": values[:, at] for name, values in vectors for at, axis in enumerate("xyz")}
    table["radius"] = frame.radii
    grains = _frame(table)
    grains.index.name = "id"
    return grains


def contacts_to_pandas(frame: Frame) -> pandas.DataFrame:
    """The contacts of a frame: see ``Frame.contacts``; vectors are three columns each."""
    table: dict[str, Any] = {}
    for name, values in frame.contacts().items():
        if np.ndim(values) == 2:
            table.update({f"{name}_{axis}": values[:, at] for at, axis in enumerate("xyz")})
        else:
            table[name] = values
    return _frame(table)


def _frame(table: Mapping[str, Any]) -> pandas.DataFrame:
    try:
        import pandas
    except ImportError:
        raise ImportError("there is no pandas here; install it with: pip install pandas") from None
    return pandas.DataFrame(table)
