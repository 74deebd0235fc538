"""Steps: the bits of the solver, observers, Ctrl-C, checkpoints, settings."""

import copy
import json
import os
import pickle
import shutil
import signal
import subprocess
import sys
import threading
import time
import warnings

import makadam
import numpy as np
import pytest
from conftest import bin_scene, space


def test_the_same_bits_on_any_threads():
    hashes = set()
    for threads, scheduler, instruction_set in [(1, None, None), (2, None, None), (2, "central-queue", "generic"), (1, "serial", None)]:
        simulation = makadam.Simulation("drum", seed=3, threads=threads, scheduler=scheduler, instruction_set=instruction_set)
        for steps in (1, 0, 49, 50):
            simulation.step(steps)
        hashes.add(simulation.state_hash)
        assert simulation.steps == 100 and simulation.time == pytest.approx(100 * simulation.time_step)
    assert len(hashes) == 1


@pytest.mark.parametrize("threads", [1, 2])
def test_the_bits_are_those_of_the_command(tmp_path, threads):
    command = os.environ.get("MAKADAM_EXECUTABLE") or shutil.which("makadam")
    if command is None:
        pytest.skip("the command is not built: MAKADAM_EXECUTABLE names it")
    said = subprocess.run(
        [command, "run", "drum", "--steps", "150", "--seed", "5", "--json", "--quiet", "--output", tmp_path / "run"],
        check=True,
        capture_output=True,
        text=True,
    )
    simulation = makadam.Simulation("drum", seed=5, threads=threads)
    simulation.step(150)
    assert simulation.state_hash == json.loads(said.stdout)["state_hash"]


def test_the_bits_are_the_recorded_ones():
    """Of `makadam run drum --steps 150 --seed 5`."""
    simulation = makadam.Simulation("drum", seed=5, threads=2)
    simulation.step(150)
    assert simulation.state_hash == DRUM_150_5


DRUM_150_5 = "852fa8acd784cbb9"


def test_a_checkpoint_goes_on_with_the_same_bits():
    scene = makadam.Scene(bin_scene())
    simulation = makadam.Simulation(scene, seed=2, time_step=5e-4)
    simulation.step(400)
    bytes_ = simulation.checkpoint()
    resumed = makadam.Simulation.resume(scene, bytes_, time_step=5e-4, threads=2)
    copied = simulation.copy()
    for one in (simulation, resumed, copied):
        one.step(100)
    assert simulation.state_hash == resumed.state_hash == copied.state_hash
    assert type(resumed) is type(copied) is makadam.Simulation
    with pytest.raises(makadam.CheckpointError, match="time step"):
        makadam.Simulation.resume(scene, bytes_)
    with pytest.raises(makadam.CheckpointError, match="damaged"):
        makadam.Simulation.resume(scene, bytes_[:-1] + bytes([bytes_[-1] ^ 1]), time_step=5e-4)
    with pytest.raises(makadam.CheckpointError):
        makadam.Simulation.resume(scene, b"")


def test_a_checkpoint_is_of_a_scene_and_a_seed():
    scene = makadam.Scene(bin_scene())
    simulation = makadam.Simulation(scene, seed=2)
    simulation.step(20)
    bytes_ = simulation.checkpoint()
    assert makadam.Simulation.resume(scene, bytes_).seed == 2
    assert makadam.Simulation.resume(scene, bytes_, seed=2).seed == 2
    measured = scene.with_overrides({"duration": 3.0, "measure.interval": 0.01, "watch.every": 7})
    assert makadam.Simulation.resume(measured, bytes_).state_hash == simulation.state_hash
    with pytest.raises(makadam.CheckpointError, match="another friction"):
        makadam.Simulation.resume(scene.with_overrides({"material.glass.friction": 0.1}), bytes_)
    with pytest.raises(makadam.CheckpointError, match="other contents or settings"):
        makadam.Simulation.resume(scene, bytes_, method="jacobi")
    with pytest.raises(makadam.CheckpointError, match="seed 2, not to 77"):
        makadam.Simulation.resume(scene, bytes_, seed=77)


def test_numbers_that_no_setting_can_have_are_refused_in_words():
    for threads in (65536, 1025, 0, -1, 2**70):
        with pytest.raises(makadam.SettingError, match="threads"):
            makadam.Simulation(bin_scene(), threads=threads)
    for seed in (-1, 2**64, 2**200):
        with pytest.raises(makadam.SettingError, match="seed"):
            makadam.Simulation(bin_scene(), seed=seed)
    simulation = makadam.Simulation(bin_scene())
    with pytest.raises(makadam.SettingError, match="steps"):
        simulation.step(2**63)
    with pytest.raises(makadam.SettingError, match="steps"):
        simulation.run(1e300)


def test_intervals_of_any_size_are_kept():
    simulation = makadam.Simulation(bin_scene())
    each, never = [], []
    simulation.observe(lambda one: each.append(one.steps), seconds=5e-324)
    simulation.observe(lambda one: never.append(one.steps), seconds=1e308)
    simulation.step(3)
    assert each == [1, 2, 3] and never == []


def test_a_handle_removes_what_it_was_given_for():
    simulation = makadam.Simulation(bin_scene())
    calls = []

    def push(one):
        calls.append(one.steps)

    first, _ = simulation.add_force(push), simulation.add_force(push)
    first.remove()
    first.remove()
    simulation.step()
    assert calls == [0]


def test_a_simulation_names_checkpoints_where_it_cannot_be_pickled():
    simulation = makadam.Simulation(bin_scene())
    for attempt in (pickle.dumps, copy.deepcopy, copy.copy):
        with pytest.raises(TypeError, match="checkpoint"):
            attempt(simulation)


def test_many_steps_end_with_a_look_of_the_watchdog():
    deep = [{"position": [0.0, 0.0, 0.0]}, {"position": [0.0071, 0.0, 0.0]}]
    watch = {"every": 64, "overlap": 0.1, "on_overlap": "warn", "on_energy": "ignore"}
    # So short a step that they are still inside each other.
    scene = space(deep, largest_start_overlap=1.0, watch=watch, solver={"step": 1e-6})
    with pytest.warns(makadam.MakadamWarning, match="overlaps its partner"):
        makadam.Simulation(scene).step(2)


def test_a_duration_in_parts_takes_the_steps_of_the_whole():
    scene = space([{"position": [0.0, 0.0, 0.0]}])
    whole, parts = makadam.Simulation(scene), makadam.Simulation(scene)
    whole.run(0.7)
    for part in range(1000):
        parts.run(0.0007)
        if part == 500:
            # What is left below a step goes into checkpoints and copies.
            assert parts.steps == 351
            parts = makadam.Simulation.resume(scene, parts.checkpoint()).copy()
    assert parts.steps == whole.steps == 700
    parts.run(0.0)
    parts.run(0.0004)
    parts.step(2)
    parts.run(0.0004)
    assert parts.steps == 703


def test_observers_are_called_when_they_are_due():
    simulation = makadam.Simulation(bin_scene())
    steps, times, all_steps = [], [], []
    simulation.observe(lambda one: steps.append(one.steps), steps=7)
    handle = simulation.observe(lambda one: times.append(one.time), seconds=0.0125)
    simulation.step(5)
    simulation.step(25)
    assert steps == [7, 14, 21, 28]
    assert times == pytest.approx([0.013, 0.025])
    handle.remove()
    handle.remove()
    simulation.observe(lambda one: all_steps.append(one.steps), steps=1)
    simulation.run(0.005)
    assert len(times) == 2 and all_steps == [31, 32, 33, 34, 35] and steps[-1] == 35
    for wrong in ({}, {"steps": 0}, {"steps": 1, "seconds": 1.0}, {"seconds": float("nan")}, {"steps": 1.5}, {"seconds": -1.0}):
        with pytest.raises(makadam.SettingError):
            simulation.observe(print, **wrong)
    with pytest.raises(TypeError):
        simulation.observe(3, steps=1)


def test_what_an_observer_raises_ends_the_steps():
    simulation = makadam.Simulation(bin_scene())

    def stop(one):
        raise LookupError("enough")

    handle = simulation.observe(stop, steps=4)
    with pytest.raises(LookupError, match="enough"):
        simulation.step(100)
    assert simulation.steps == 4
    handle.remove()
    simulation.observe(lambda one: one.step(), steps=1)
    with pytest.raises(makadam.BusyError, match="callback"):
        simulation.step(1)


CTRL_C = """
import signal, sys, threading, os, time
import makadam
scene = makadam.Scene({scene!r}, overrides={overrides!r})
simulation = makadam.Simulation(scene)
simulation.step(3)
done = simulation.steps
def press():
    time.sleep(0.5)
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=press).start()
begun = time.time()
try:
    simulation.step(10**9)
except KeyboardInterrupt:
    taken, waited = simulation.steps, time.time() - begun
    again = makadam.Simulation(scene)
    again.step(taken)
    assert again.state_hash == simulation.state_hash, "the state is not that of a whole step"
    simulation.step()
    again.step()
    assert again.state_hash == simulation.state_hash
    print("interrupted", taken >= done, waited < 5.0)
"""


@pytest.mark.parametrize(
    "overrides",
    [
        {"solver.step": 1e-3},
        # Steps that take many seconds each: they are given up inside.
        {"solver.stop": {"kind": "sweeps", "sweeps": 1_000_000}, "population[0].count": 20},
    ],
    ids=["between steps", "within a step"],
)
def test_ctrl_c_ends_the_steps_after_a_whole_one(overrides):
    if "solver.stop" in overrides:
        overrides = dict(overrides)
        code = (
            CTRL_C.replace("simulation.step(3)", "pass")
            .replace("    simulation.step()\n    again.step()\n", "")
            .replace("    assert again.state_hash == simulation.state_hash\n    print", "    print")
        )
    else:
        code = CTRL_C
    said = subprocess.run(
        [sys.executable, "-c", code.format(scene=bin_scene(), overrides=overrides)], capture_output=True, text=True, timeout=100
    )
    assert said.stdout.strip() == "interrupted True True", said.stdout + said.stderr


def test_another_thread_can_stop_the_steps():
    simulation = makadam.Simulation("drum")
    threading.Timer(0.3, simulation.interrupt).start()
    with pytest.raises(makadam.Interrupted):
        simulation.step(10**9)
    taken = simulation.steps
    simulation.step(2)
    assert simulation.steps == taken + 2


def test_a_request_is_answered_by_whatever_ends_the_steps():
    simulation = makadam.Simulation("packing-100")

    def stop(one):
        one.interrupt()
        raise KeyboardInterrupt

    handle = simulation.observe(stop, steps=1)
    with pytest.raises(KeyboardInterrupt):
        simulation.step(5)
    handle.remove()
    simulation.step(5)
    assert simulation.steps == 6
    # As Ctrl-C comes, in the middle of steps.
    before = signal.signal(signal.SIGALRM, lambda *_: stop(simulation))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        with pytest.raises(KeyboardInterrupt):
            simulation.step(10**9)
        taken = simulation.steps
        simulation.step(5)
        assert simulation.steps == taken + 5
    finally:
        signal.signal(signal.SIGALRM, before)
    # Without a step under way the next one answers.
    simulation.interrupt()
    with pytest.raises(makadam.Interrupted):
        simulation.step(5)
    simulation.step(5)


ASKED_BY_A_HANDLER = """
import signal, warnings
import makadam
simulation = makadam.Simulation({scene!r}, watch=False)
warnings.simplefilter("always")
warnings.showwarning = lambda *_: print("warned at", simulation.time, len(simulation.frame()))
simulation.positions[:] = 0.001
simulation.step()
simulation.velocities[:] = 0.0
signal.signal(signal.SIGALRM, lambda *_: simulation.time)
signal.setitimer(signal.ITIMER_REAL, 0.005, 0.005)
for _ in range(2000):
    simulation.energy()
    simulation.positions
signal.setitimer(signal.ITIMER_REAL, 0.0)
print("done")
"""


def test_handlers_of_warnings_and_signals_may_ask():
    scene = space([{"position": [0.02 * number - 0.8, 0.0, 0.0], "radius": 0.001} for number in range(80)] * 7, largest_start_overlap=2.0)
    code = ASKED_BY_A_HANDLER.format(scene=scene)
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert said.stdout.splitlines() == ["warned at 0.0 560", "done"], said.stdout + said.stderr


def test_other_threads_run_while_one_steps():
    simulation = makadam.Simulation("drum")
    counted, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    simulation.step(300)
    stop.set()
    thread.join()
    assert counted[0] > 10, "the interpreter's lock was held"


def test_what_is_noticed_is_said():
    # Two grains inside each other: energy comes from nowhere.
    deep = [{"position": [0.0, 0.0, 0.0]}, {"position": [0.0075, 0.0, 0.0]}]
    scene = space(deep, largest_start_overlap=1.0, watch={"every": 1, "overlap": 0.1, "on_overlap": "warn", "on_energy": "ignore"})
    with pytest.warns(makadam.MakadamWarning, match="overlaps its partner"):
        makadam.Simulation(scene).step(2)
    scene["watch"]["on_overlap"] = "stop"
    with pytest.raises(makadam.InvalidStateError, match="overlaps its partner"):
        makadam.Simulation(scene).step(2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        makadam.Simulation(scene, watch=False).step(2)


def test_settings_that_cannot_be_are_refused():
    for wrong, words in [
        ({"threads": 0}, "threads: 0"),
        ({"scheduler": "best"}, "work-stealing"),
        ({"instruction_set": "sse"}, "avx2"),
        ({"precision": "half"}, "single"),
        ({"method": "magic"}, "gauss-seidel"),
        ({"time_step": -1.0}, "time_step"),
        ({"time_step": float("nan")}, "time_step"),
    ]:
        with pytest.raises(makadam.SettingError, match=words):
            makadam.Simulation("drum", **wrong)
    for wrong in ({"seed": "1"}, {"seed": 1.5}, {"threads": "2"}, {"time_step": "1e-4"}):
        with pytest.raises(makadam.SettingError, match=f"{next(iter(wrong))}: .*number; give"):
            makadam.Simulation("drum", **wrong)
    with pytest.raises(makadam.SettingError, match="single precision"):
        makadam.Simulation("oedometer", precision="single")
    simulation = makadam.Simulation(bin_scene())
    for wrong in (-1, 1.5, True, "3"):
        with pytest.raises(makadam.SettingError):
            simulation.step(wrong)
    for wrong in (-1.0, float("inf"), "1"):
        with pytest.raises(makadam.SettingError):
            simulation.run(wrong)
    with pytest.raises(TypeError):
        makadam.Simulation("drum", tread=1)
    assert simulation.steps == 0


def test_energy_momentum_and_the_ledger(filled):
    energy = filled.energy()
    assert set(energy) == {"kinetic", "potential", "elastic", "cohesive"} and energy["potential"] > 0
    assert filled.balance() is None
    filled.open_ledger()
    filled.step(20)
    balance = filled.balance()
    assert abs(balance["closure"]) < 1e-9 and balance["outside"] == 0.0
    assert np.allclose(filled.momentum(), 0.0, atol=1e-2)
    assert set(filled.phase_seconds()) == {"detect", "constrain", "sweep", "integrate"}
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
