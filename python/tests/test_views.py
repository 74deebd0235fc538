"""Views: arrays that lie in the memory of a simulation, whatever becomes of it."""

import gc
import threading
import warnings
import weakref

import makadam
import numpy as np
import pytest
from conftest import bin_scene, space


def by_id(simulation, view):
    values = np.empty_like(view)
    values[simulation.ids] = view
    return values


def test_views_show_what_frames_copy(filled):
    frame = filled.frame()
    assert np.array_equal(by_id(filled, filled.positions), frame.positions)
    assert np.array_equal(by_id(filled, filled.velocities), frame.velocities)
    assert np.allclose(by_id(filled, filled.spins), frame.spins, rtol=1e-15, atol=0)
    assert np.array_equal(by_id(filled, filled.radii), frame.radii)
    assert np.allclose(filled.scaled_spins, filled.spins * filled.radii[:, None], rtol=1e-15, atol=0)
    assert np.allclose(filled.masses, 2500 * 4 / 3 * np.pi * filled.radii**3, rtol=1e-14)
    assert np.array_equal(filled.velocities[filled.rows], frame.velocities)
    assert sorted(filled.ids) == list(range(len(filled)))
    assert filled.positions.shape == (60, 3) and filled.ids.dtype == np.uint32 and filled.radii.shape == (60,)
    assert len(frame) == 60 and frame.coordination_number > 2 and "60 grains" in repr(frame)


def test_a_view_is_a_view():
    simulation = makadam.Simulation(space([{"position": [0.0, 0.0, 0.0]}, {"position": [0.5, 0.0, 0.0]}]))
    velocities, positions, ids = simulation.velocities, simulation.positions, simulation.ids
    assert velocities.base is not None and not velocities.flags.owndata
    assert np.shares_memory(velocities, simulation.velocities)
    velocities[ids == 1] = [0.1, 0.2, 0.3]
    assert simulation.frame().velocities[1].tolist() == [0.1, 0.2, 0.3]
    simulation.step(100)
    row = int(np.flatnonzero(ids == 1)[0])
    assert positions[row] == pytest.approx([0.51, 0.02, 0.03], abs=1e-14)
    assert positions[row].tolist() == simulation.frame().positions[1].tolist()
    simulation.velocities += [0.0, 0.0, 1.0]
    assert simulation.frame().velocities[1].tolist() == [0.1, 0.2, 1.3]
    simulation.spins = [[0.0, 0.0, 2.0], [0.0, 0.0, 4.0]]
    assert simulation.scaled_spins[:, 2].tolist() == [0.01, 0.02]
    simulation.positions[0] += 1e-3
    simulation.positions = simulation.positions + 1.0


def test_a_view_taken_before_many_rebuilds_reads_true_after(filled):
    views = (filled.positions, filled.velocities, filled.scaled_spins, filled.ids, filled.radii)
    before, ids = filled.rebuilds, filled.ids.copy()
    undisturbed = makadam.Simulation.resume(bin_scene(), filled.checkpoint())
    rng = np.random.default_rng(1)
    kick = rng.normal(0.0, 1.0, (len(filled), 3))
    kick[:, 2] = np.abs(kick[:, 2])
    filled.velocities[...] = kick[filled.ids]
    undisturbed.velocities[...] = kick[undisturbed.ids]
    filled.step(150)
    undisturbed.step(150)
    assert filled.rebuilds > before + 2 and not np.array_equal(ids, filled.ids)
    assert filled.state_hash == undisturbed.state_hash
    for old, new in zip(views, (filled.positions, filled.velocities, filled.scaled_spins, filled.ids, filled.radii)):
        assert np.shares_memory(old, new) and np.array_equal(old, new)


def test_a_grain_that_was_put_elsewhere_is_found_by_its_neighbours_and_walls():
    simulation = makadam.Simulation(space([{"position": [0.0, 0.0, 0.0]}, {"position": [0.5, 0.0, 0.0]}]))
    simulation.step(3)
    row = simulation.rows
    simulation.positions[row[1]] = [0.0105, 0.0, 0.0]
    simulation.velocities[row[1]] = [-0.5, 0.0, 0.0]
    simulation.step(10)
    assert simulation.frame().velocities[0][0] < -0.1
    # One that would pass through the wall within a step is stopped, though all were slow before.
    simulation = makadam.Simulation(bin_scene(count=1))
    simulation.step(5)
    simulation.positions[0] = [0.03, 0.03, 0.1]
    simulation.velocities[0] = [200.0, 0.0, 0.0]
    simulation.step(5)
    assert 0.0 < simulation.positions[0][0] < 0.06


def test_what_cannot_be_written_is_refused(filled):
    before = filled.state_hash
    for name in ("radii", "ids", "inverse_masses", "spins", "pairs", "pair_impulses"):
        view = getattr(filled, name)
        with pytest.raises(ValueError, match="read-only"):
            view[0] = 1
    for name in ("radii", "ids", "masses", "rows"):
        with pytest.raises(AttributeError):
            setattr(filled, name, 1)
    for wrong, words in [
        (np.zeros((3, 3)), "shape"),
        (np.full((60, 3), np.nan), "not all finite"),
        (np.zeros((60, 3), dtype=complex), "type complex"),
        ([["a"] * 3] * 60, "type"),
    ]:
        with pytest.raises(makadam.InterventionError, match=words):
            filled.velocities = wrong
    assert filled.state_hash == before
    filled.velocities[4, 1] = np.nan
    with pytest.raises(makadam.InterventionError, match="not finite"):
        filled.step()
    filled.velocities[4, 1] = 0.0
    filled.step()


def test_views_keep_the_memory_of_a_simulation_that_is_gone():
    simulation = makadam.Simulation(bin_scene(count=80))
    simulation.step(50)
    frame, rows = simulation.frame(), simulation.rows
    positions, slice_, ids = simulation.positions, simulation.velocities[::2, 1:], simulation.ids
    pairs, impulses = simulation.pairs, simulation.pair_impulses
    gone = weakref.ref(simulation)
    del simulation
    gc.collect()
    assert gone() is None
    # Memory that was freed would be taken by others.
    noise = [np.full((80, 4), 1e300) for _ in range(200)]
    assert np.array_equal(positions[rows], frame.positions) and sorted(ids) == list(range(80))
    assert np.isfinite(slice_).all() and slice_.base is not None
    assert pairs.shape[1] == 2 and (pairs < 80).all() and np.isfinite(impulses).all()
    positions[0] = 7.0
    assert positions[0, 0] == 7.0 and len(noise) == 200


def test_rows_of_contacts_are_views_that_later_steps_leave_alone(filled):
    pairs, impulses = filled.pairs, filled.pair_impulses
    walls, wall_impulses = filled.wall_pairs, filled.wall_impulses
    assert pairs.shape == (len(impulses), 2) and impulses.shape[1] == 4 and walls.shape == (len(wall_impulses), 2)
    assert np.shares_memory(pairs, filled.pairs) and not pairs.flags.owndata
    contacts, h = filled.contacts(), filled.time_step
    grains = contacts["wall"] < 0
    # Each contact of two grains is a pair, with its normal impulse.
    ids = filled.ids.copy()
    bore = impulses[:, 0] > 0
    found = {frozenset(ids[pair].tolist()): impulse for pair, impulse in zip(pairs[bore], impulses[bore, 0])}
    expected = {
        frozenset((int(first), int(second))): force * h
        for first, second, force in zip(contacts["first"][grains], contacts["second"][grains], contacts["normal_force"][grains])
    }
    assert found.keys() == expected.keys() and len(found) > 50
    assert all(found[key] == pytest.approx(expected[key], rel=1e-12) for key in found)
    assert wall_impulses[:, 0].sum() == pytest.approx(contacts["normal_force"][~grains].sum() * h)
    copies = [array.copy() for array in (pairs, impulses, walls, wall_impulses)]
    filled.velocities[...] = np.random.default_rng(3).normal(0.0, 0.5, (len(filled), 3))
    undisturbed = filled.copy()
    filled.step(200)
    undisturbed.step(200)
    for view, copy in zip((pairs, impulses, walls, wall_impulses), copies):
        assert np.array_equal(view, copy)
    assert not np.shares_memory(pairs, filled.pairs)
    assert filled.state_hash == undisturbed.state_hash


def test_grains_neither_come_nor_go_while_a_view_lives(filled):
    part = filled.velocities[3:9, 0]
    assert filled.live_views == 1
    with pytest.raises(makadam.ViewError, match="1 views"):
        filled.insert([0.03, 0.03, 0.28], 0.004)
    with pytest.raises(BufferError):
        filled.remove(0)
    # Also one that is an argument, or stands in the expression.
    for attempt in (lambda: filled.remove(filled.ids[:1]), lambda: filled.positions[filled.insert([0.03, 0.03, 0.28], 0.004)]):
        with pytest.raises(makadam.ViewError, match="within the expression.*give copies"):
            attempt()
    assert len(filled) == 60
    del part
    gc.collect()
    assert filled.live_views == 0
    # Views of the candidate list are no obstacle: they keep what they show.
    pairs = filled.pairs
    copy = pairs.copy()
    filled.insert([0.03, 0.03, 0.28], 0.004)
    filled.step(50)
    assert len(filled) == 61 and np.array_equal(pairs, copy)
    assert filled.positions.shape == (61, 3)


def test_threads_read_views_while_another_steps():
    simulation = makadam.Simulation("drum", seed=2)
    positions, ids = simulation.positions, simulation.ids
    problems, stop = [], threading.Event()

    def look():
        while not stop.is_set():
            if not np.isfinite(positions.sum()) or ids.max() >= len(ids):
                problems.append("a view shows what no state has")
            fresh, pairs, impulses = simulation.velocities, simulation.pairs, simulation.pair_impulses
            if not np.isfinite(fresh).all() or (pairs.size and pairs.max() >= len(ids)) or not np.isfinite(impulses).all():
                problems.append("a fresh view shows what no state has")
            frame = simulation.frame()
            if len(frame) != len(ids) or simulation.steps < 0 or len(simulation.state_hash) != 16:
                problems.append("a copy shows what no state has")
            simulation.checkpoint()

    lookers = [threading.Thread(target=look) for _ in range(2)]
    for thread in lookers:
        thread.start()
    try:
        for _ in range(5):
            simulation.step(40)
        with pytest.raises(makadam.BusyError):
            other = threading.Thread(target=lambda: simulation.step(400))
            other.start()
            try:
                while simulation.steps < 201:
                    pass
                simulation.step()
            finally:
                other.join()
    finally:
        stop.set()
        for thread in lookers:
            thread.join()
    assert not problems
    alone = makadam.Simulation("drum", seed=2)
    alone.step(simulation.steps)
    assert alone.state_hash == simulation.state_hash


def test_an_empty_simulation_has_empty_views():
    simulation = makadam.Simulation(space([]))
    simulation.step(2)
    assert simulation.positions.shape == (0, 3) and simulation.pairs.shape == (0, 2) and simulation.ids.shape == (0,)
    assert len(simulation.frame()) == 0 and simulation.contacts()["point"].shape == (0, 3)
    assert simulation.insert([[0.0, 0.0, 0.0]], [0.005]) == range(0, 1)
    simulation.step(2)
    assert simulation.remove([0]).tolist() == [-1]
    simulation.step(2)
    assert len(simulation) == 0


def test_grains_that_are_put_to_one_place_are_told_of():
    grains = [{"position": [0.02 * (number % 25) - 0.3, 0.02 * (number // 25) - 0.3, 0.0]} for number in range(510)]
    simulation = makadam.Simulation(space(grains), watch=False)
    positions = simulation.positions
    with warnings.catch_warnings():
        warnings.simplefilter("error", makadam.MakadamWarning)
        simulation.step()
        positions[:] = 0.001 + 1e-5 * np.arange(510)[:, np.newaxis]
        with pytest.raises(makadam.MakadamWarning, match="510 grains lie in one place"):
            simulation.step()
