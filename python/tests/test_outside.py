"""States that are written and forces that are given from outside: nothing of them is lost, whoever asks next."""

import os
import signal
import time

import makadam
import numpy as np
import pytest
from conftest import bin_scene, mass, space


def floor(z=0.04):
    plane = {"name": "floor", "material": "glass", "shape": {"kind": "plane", "point": [0, 0, 0], "normal": [0, 0, 1.0]}}
    grains = [{"position": [0.0, 0.0, z]}, {"position": [0.1, 0.0, 0.005]}]
    return space(grains, gravity=[0.0, 0.0, -9.81], wall=[plane])


def written(speed):
    """A simulation whose first grain was just made fast by a view."""
    simulation = makadam.Simulation(floor(), watch=False)
    simulation.open_ledger()
    simulation.step(5)
    row = int(np.flatnonzero(simulation.ids == 0)[0])
    simulation.velocities[row] = [3.0, 0.0, speed]
    return simulation


def test_a_copy_and_a_checkpoint_know_what_was_written():
    simulation = written(-60.0)
    copy = simulation.copy()
    resumed = makadam.Simulation.resume(floor(), simulation.checkpoint(), watch=False)
    for _ in range(3):
        simulation.step()
        copy.step()
        resumed.step()
        assert simulation.state_hash == copy.state_hash == resumed.state_hash
        assert simulation.balance() == copy.balance() == resumed.balance()


@pytest.mark.parametrize(
    "act",
    [
        lambda one: one,
        lambda one: one.copy(),
        lambda one: makadam.Simulation.resume(floor(), one.checkpoint(), watch=False),
        lambda one: (one.insert([0.0, 0.1, 0.1], 0.005), one)[1],
        lambda one: (one.remove(1), one)[1],
    ],
)
def test_the_ledger_knows_what_was_written_whatever_comes_next(act):
    simulation = act(written(0.1))
    balance = simulation.balance()
    assert balance["outside"] > 0.4 * mass() * 9.0
    for _ in range(2):
        assert abs(balance["closure"]) < 1e-12 * balance["outside"]
        assert max(map(abs, balance["momentum_closure"])) < 1e-12 * mass()
        simulation.step(5)
        balance = simulation.balance()


def pushed(callback):
    simulation = makadam.Simulation(space([{"position": [0.0, 0.0, 0.0]}]), watch=False)
    simulation.observe(lambda one: one.apply_forces([[1e-3, 0, 0]]), steps=1)
    if callback is not None:
        simulation.add_force(callback)
    simulation.step(100)
    return simulation.velocities[0].tolist()


def test_forces_of_observers_and_of_callbacks_add_up():
    alone = pushed(None)
    assert alone[0] == pytest.approx(99 * 1e-3 * 1e-3 / mass(), rel=1e-12)
    assert pushed(lambda one: None) == alone
    both = pushed(lambda one: [[0, 1e-3, 0]])
    assert both[0] == alone[0] and both[1] == pytest.approx(100 * 1e-3 * 1e-3 / mass(), rel=1e-12)


def test_refused_forces_do_not_act():
    simulation = makadam.Simulation(space([{"position": [0.0, 0.0, 0.0]}]), watch=False)
    with pytest.raises(makadam.InterventionError):
        simulation.apply_forces([[1e-3, 0, 0]], [[float("nan"), 0, 0]])
    simulation.step()
    assert simulation.velocities[0].tolist() == [0.0, 0.0, 0.0]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
@pytest.mark.parametrize("threads", [1, 2])
def test_a_forked_child_steps(threads):
    simulation = makadam.Simulation(bin_scene(), threads=threads, watch=False)
    simulation.step(20)
    child = os.fork()
    if child == 0:
        simulation.step(5)
        os._exit(0)
    for _ in range(300):
        if os.waitpid(child, os.WNOHANG)[0]:
            break
        time.sleep(0.1)
    else:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        pytest.fail("the child hangs")
    simulation.step(5)


def test_forces_of_a_step_that_was_not_taken_are_over():
    simulation = makadam.Simulation(space([{"position": [0.0, 0.0, 0.0]}]), watch=False)
    handle = simulation.add_force(lambda one: [[1e-3, 0, 0]])
    simulation.interrupt()
    with pytest.raises(makadam.Interrupted):
        simulation.step()
    handle.remove()
    copy = simulation.copy()
    for one in (simulation, copy):
        one.step()
        assert one.steps == 1 and one.velocities[0].tolist() == [0.0, 0.0, 0.0]


def test_a_frame_shows_grains_that_just_came():
    scene = bin_scene(count=1500, domain={"min": [-0.2, -0.2, 0.0], "max": [0.3, 0.3, 3.0]})
    scene["wall"][0]["shape"]["max"][2] = 2.9
    scene["population"][0]["region"]["max"][2] = 2.0
    simulation = makadam.Simulation(scene, watch=False)
    simulation.step(20)
    frames = []
    simulation.observe(lambda one: one.insert([0.03, 0.03, 2.7 - 0.02 * len(frames)], 0.004), steps=5)
    simulation.observe(lambda one: frames.append(one.frame()), steps=5)
    simulation.step(15)
    assert [len(frame) for frame in frames] == [1501, 1502, 1503]
    assert len(makadam.Simulation.resume(scene, simulation.checkpoint()).frame()) == 1503
