"""Numbers and arrays that the caller gives: checked, and told in words where they do not fit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import InterventionError, SettingError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

__all__ = ["floats", "numbers", "spread", "whole", "write"]


def whole(value: Any, what: str) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise SettingError(f"{what}: {value!r} is no whole number")
    if value < 0:
        raise SettingError(f"{what}: {value} is below 0; give 0 or more")
    if value >= 2**63:
        raise SettingError(f"{what}: {value} is beyond any that can be; give less than 2**63")
    return int(value)


def numbers(values: ArrayLike, shape: tuple[int, ...], what: str) -> Floats:
    """An array of numbers of just this shape."""
    array = floats(values, what)
    if array.shape != shape:
        raise InterventionError(f"{what} have the shape {array.shape}; give {shape}, a row for each grain")
    return array


def floats(values: ArrayLike, what: str) -> Floats:
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise InterventionError(f"{what} are of type {array.dtype}; give real numbers")
    return np.asarray(array, dtype=np.float64, order="C")


def spread(values: ArrayLike, shape: tuple[int, ...], what: str) -> Floats:
    """An array of numbers that is spread to a shape."""
    array = floats(values, what)
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise InterventionError(f"{what} have the shape {array.shape}, which does not go with {shape}") from None


def write(view: Floats, values: ArrayLike, what: str) -> None:
    if values is view:
        return
    array = spread(values, view.shape, what)
    if not np.isfinite(array).all():
        raise InterventionError(f"{what} are not all finite; give finite numbers in SI units")
    view[...] = array
