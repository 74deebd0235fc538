"""Statistics of the judge: blocks of time, ensembles of seeds, tests of equivalence."""

from __future__ import annotations

from ._core import block_average, ensemble, equivalence

__all__ = ["block_average", "ensemble", "equivalence"]
