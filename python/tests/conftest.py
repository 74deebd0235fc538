"""Scenes that the tests share."""

from __future__ import annotations

import makadam
import numpy as np
import pytest


def material(**changes):
    return {"density": 2500.0, "youngs_modulus": 1e7, "poisson_ratio": 0.3, "friction": 0.4, "restitution": 0.3, **changes}


def space(grains, **changes):
    """Grains that nothing acts on."""
    return {
        "name": "space",
        "description": "grains that nothing acts on",
        "duration": 1.0,
        "gravity": [0.0, 0.0, 0.0],
        "domain": {"min": [-1.0, -1.0, -1.0], "max": [1.0, 1.0, 1.0]},
        "material": {"glass": material()},
        "grain": [{"material": "glass", "radius": 0.005, **grain} for grain in grains],
        "solver": {"step": 1e-3},
        **changes,
    }


def bin_scene(count=60, **changes):
    """Grains that fall into a box without a lid."""
    return {
        "name": "bin",
        "description": "grains that fall into a box without a lid",
        "duration": 0.5,
        "domain": {"min": [0.0, 0.0, 0.0], "max": [0.06, 0.06, 0.3]},
        "material": {"glass": material()},
        "wall": [
            {
                "name": "box",
                "material": "glass",
                "shape": {"kind": "box", "min": [0.0, 0.0, 0.0], "max": [0.06, 0.06, 0.3], "open": ["+z"]},
            }
        ],
        "population": [
            {
                "count": count,
                "material": "glass",
                "radius": {"kind": "uniform", "mean": 0.004, "spread": 0.1},
                "region": {"kind": "box", "min": [0.0, 0.0, 0.0], "max": [0.06, 0.06, 0.15]},
            }
        ],
        "solver": {"step": 1e-3},
        "measure": {"interval": 0.05, "from": 0.3, "observables": ["balances", "coordination-number"]},
        **changes,
    }


@pytest.fixture
def filled():
    """A simulation of grains that have fallen into a box."""
    simulation = makadam.Simulation(bin_scene())
    simulation.run(0.3)
    return simulation


def mass(radius=0.005, density=2500.0):
    return density * 4.0 / 3.0 * np.pi * radius**3
