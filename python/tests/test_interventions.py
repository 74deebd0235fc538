"""Forces, walls and grains of the caller."""

import makadam
import numpy as np
import pytest
from conftest import bin_scene, mass, material, space


def test_a_grain_under_a_constant_force_follows_newton():
    simulation = makadam.Simulation(space([{"position": [0.0, 0.0, 0.0]}, {"position": [0.5, 0.0, 0.0]}]))
    force, torque = np.array([2e-3, -1e-3, 5e-4]), np.array([0.0, 3e-6, 0.0])

    def push(one):
        forces, torques = np.zeros((2, 3)), np.zeros((2, 3))
        forces[one.ids == 1], torques[one.ids == 0] = force, torque
        return forces, torques

    handle = simulation.add_force(push)
    simulation.step(200)
    frame = simulation.frame()
    assert frame.velocities[1] == pytest.approx(force * 0.2 / mass(), rel=1e-13)
    assert frame.spins[0] == pytest.approx(torque * 0.2 / (0.4 * mass() * 0.005**2), rel=1e-13)
    assert frame.velocities[0].tolist() == [0.0, 0.0, 0.0]
    # Semi-implicit Euler: x = a h^2 n (n + 1) / 2.
    assert frame.positions[1] - [0.5, 0, 0] == pytest.approx(force / mass() * 1e-6 * 200 * 201 / 2, rel=1e-12)
    handle.remove()
    simulation.step(10)
    assert simulation.frame().velocities[1].tolist() == frame.velocities[1].tolist()
    simulation.apply_forces(np.ones((2, 3)) * 1e-3)
    simulation.step(2)
    gained = simulation.frame().velocities[0]
    assert gained == pytest.approx(np.full(3, 1e-3 * 1e-3 / mass()), rel=1e-13), "it acts in one step"


def test_forces_give_the_same_bits_on_any_threads_and_are_in_the_ledger():
    hashes = set()
    for threads in (1, 2):
        simulation = makadam.Simulation(bin_scene(), threads=threads)
        simulation.open_ledger()
        simulation.add_force(lambda one: -2.0 * (one.positions - [0.03, 0.03, 0.05]))
        simulation.add_force(lambda one: None)
        simulation.add_force(lambda one: (None, np.full((len(one), 3), 1e-7)))
        simulation.step(300)
        hashes.add(simulation.state_hash)
        balance = simulation.balance()
        assert abs(balance["outside"]) > 1e-4 and abs(balance["closure"]) < 1e-11
    assert len(hashes) == 1


@pytest.mark.parametrize(
    ("forces", "words"),
    [
        (np.zeros((3, 3)), "shape"),
        (np.zeros(60), "shape"),
        (np.full((60, 3), np.nan), "finite"),
        (np.zeros((60, 3), dtype=complex), "real numbers"),
        ("push", "type"),
        ((None, None, None), "pair"),
    ],
)
def test_wrong_forces_are_refused(filled, forces, words):
    filled.add_force(lambda one: forces)
    before = filled.state_hash
    with pytest.raises(makadam.InterventionError, match=words):
        filled.step()
    assert filled.state_hash == before
    with pytest.raises(TypeError):
        filled.add_force(3)


def floor(motion=None):
    wall = {"name": "floor", "material": "glass", "shape": {"kind": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}}
    if motion:
        wall["motion"] = motion
    return space([{"position": [0.0, 0.0, 0.00502]}], gravity=[0.0, 0.0, -9.81], wall=[wall])


def test_a_wall_that_a_function_moves_shakes_as_one_of_the_scene():
    amplitude, frequency = 5e-4, 20.0
    of_scene = makadam.Simulation(floor({"kind": "vibrating", "amplitude": [0, 0, amplitude], "frequency": frequency}))
    by_caller = makadam.Simulation(floor())
    handle = by_caller.steer("floor", position=lambda t: [0.0, 0.0, amplitude * np.sin(2 * np.pi * frequency * t)])
    heights = []
    for one in (of_scene, by_caller):
        one.observe(lambda one: heights.append(one.positions[0, 2]), steps=1)
        one.step(300)
    assert np.abs(np.array(heights[:300]) - heights[300:]).max() < 1e-9
    assert np.ptp(heights) > 1e-4
    moved = by_caller.moved_by("floor")
    assert moved[0][2] == pytest.approx(amplitude * np.sin(2 * np.pi * frequency * by_caller.time), abs=1e-12) and moved[1] == 0.0
    handle.remove()
    by_caller.move_wall(0, velocity=[0, 0, 0])
    by_caller.step(5)
    assert by_caller.moved_by("floor")[0].tolist() == moved[0].tolist()
    with pytest.raises(makadam.JudgeError, match="floor"):
        by_caller.measure()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"position": lambda t: [0.0, 0.0, 0.005 * np.cos(30 * t)]}, r"position gives \[0.0, 0.0, 0.005\] m at 0.0 s.*'floor' stands at \[0.0"),
        ({"angle": lambda t: 0.1 * np.cos(30 * t), "about": ([0, 0, 0], [0, 0, 1])}, r"angle gives 0.1 rad"),
        ({"position": lambda t: [0.0, 0.0, float("nan")]}, "nan"),
        ({"position": lambda t: [0.0, 0.0]}, "shape"),
        ({"position": lambda t: "up"}, "type"),
    ],
)
def test_a_function_that_would_make_a_wall_jump_is_refused(given, words):
    simulation = makadam.Simulation(floor())
    with pytest.raises(makadam.InterventionError, match=words):
        simulation.steer("floor", **given)
    simulation.step(3)
    assert simulation.moved_by("floor") is None


def test_a_function_goes_on_from_where_a_wall_stands():
    def place(t):
        return [0.0, 0.0, -0.01 * t]

    # Of a wall that the scene has moved, and of one that the caller has.
    of_scene = makadam.Simulation(floor({"kind": "translating", "velocity": [0.0, 0.0, -0.01]}))
    by_caller = makadam.Simulation(floor())
    by_caller.move_wall("floor", velocity=[0.0, 0.0, -0.01])
    for one in (of_scene, by_caller):
        one.step(100)
        one.steer("floor", position=place)
        speeds = []
        one.observe(lambda one, speeds=speeds: speeds.append(one.velocities[0, 2]), steps=1)
        one.step(10)
        assert one.moved_by("floor")[0][2] == pytest.approx(-0.01 * one.time, abs=1e-12)
        assert np.abs(speeds).max() < 0.02
    drum = makadam.Simulation("drum")
    drum.step(20)
    rate = next(wall["motion"]["rate"] for wall in drum.scene.to_dict()["wall"] if wall["name"] == "shell")
    drum.steer("shell", angle=lambda t: rate * t)
    other = makadam.Simulation("drum")
    other.step(30)
    drum.step(10)
    assert np.allclose(drum.frame().positions, other.frame().positions, rtol=0, atol=1e-9)


def test_a_drum_that_a_function_turns_has_the_bits_of_the_scene():
    of_scene, by_caller = makadam.Simulation("drum"), makadam.Simulation("drum")
    motion = next(wall["motion"] for wall in by_caller.scene.to_dict()["wall"] if wall["name"] == "shell")
    by_caller.steer("shell", rate=lambda t: motion["rate"])
    of_scene.step(100)
    by_caller.step(100)
    assert of_scene.state_hash == by_caller.state_hash
    assert {row["observable"] for row in by_caller.measure()} == {row["observable"] for row in of_scene.measure()}


def test_a_wall_is_moved_until_it_is_told_otherwise_also_after_a_checkpoint():
    # The box and its grains move along x.
    scene = bin_scene(domain={"min": [0.0, 0.0, 0.0], "max": [0.1, 0.06, 0.3]})
    simulation = makadam.Simulation(scene)
    simulation.step(250)
    simulation.move_wall("box", velocity=[0.05, 0.0, 0.0])
    simulation.step(50)
    resumed = makadam.Simulation.resume(scene, simulation.checkpoint())
    for one in (simulation, resumed):
        one.step(50)
    assert simulation.state_hash == resumed.state_hash
    assert resumed.moved_by("box")[0] == pytest.approx([0.005, 0, 0])
    assert simulation.moved_by(0)[0].tolist() == resumed.moved_by(0)[0].tolist()
    assert (simulation.positions[:, 0] > 0.005).all()


def test_wrong_walls_are_refused(filled):
    for call, words in [
        (lambda: filled.move_wall("lid", velocity=[0, 0, 0]), "box"),
        (lambda: filled.move_wall(1, velocity=[0, 0, 0]), "counted from 0"),
        (lambda: filled.move_wall("box"), "either a velocity or a rate"),
        (lambda: filled.move_wall("box", rate=1.0), "gives it no axis"),
        (lambda: filled.move_wall("box", velocity=[0, 0, np.nan]), "no velocity"),
        (lambda: filled.steer("box"), "one of"),
        (lambda: filled.steer("box", rate=abs, angle=abs), "one of"),
        (lambda: makadam.Simulation("drum").move_wall("shell", velocity=[0, 0, 1]), "give a rate"),
        (lambda: makadam.Simulation("oedometer").move_wall("lid", velocity=[0, 0, 1]), "drives it"),
    ]:
        with pytest.raises((makadam.InterventionError, makadam.SettingError), match=words):
            call()
    with pytest.raises(TypeError):
        filled.steer("box", rate=1.0)
    assert filled.moved_by("box") is None


def test_grains_come_and_go():
    scene = bin_scene(count=40)
    simulation = makadam.Simulation(scene)

    def pour(one):
        assert one.insert([[0.02, 0.02, 0.28], [0.04, 0.04, 0.28]], 0.004, velocities=[0, 0, -1.0]) == range(len(one) - 2, len(one))

    handle = simulation.observe(pour, steps=50)
    simulation.step(400)
    handle.remove()
    simulation.step(150)
    assert len(simulation) == 56
    frame = simulation.frame()
    assert frame.coordination_number > 1 and frame.radii[-1] == 0.004
    high = np.flatnonzero(frame.positions[:, 2] > np.median(frame.positions[:, 2]))
    new = simulation.remove(high)
    assert (new[high] == -1).all() and len(simulation) == 56 - len(high)
    kept = new >= 0
    assert np.array_equal(simulation.frame().positions[new[kept]], frame.positions[kept])
    # What follows is what a checkpoint of these grains gives.
    resumed = makadam.Simulation.resume(scene, simulation.checkpoint(), threads=2)
    for one in (simulation, resumed):
        one.step(200)
    assert simulation.state_hash == resumed.state_hash
    rows = {row["observable"]: row["value"] for row in simulation.measure()}
    assert rows["wall_force_over_weight"] == pytest.approx(1.0, abs=0.05)
    assert len(simulation.grains()) == len(simulation) and simulation.grains()[0]["material"] == "glass"


def test_wrong_grains_are_refused(filled):
    before = filled.state_hash
    there = filled.frame().positions[7]
    for arguments, words in [
        (dict(positions=[0.03, 0.03, 0.4], radii=0.004), "outside the domain"),
        (dict(positions=[0.001, 0.03, 0.28], radii=0.004), "wall 'box'"),
        (dict(positions=there, radii=0.004), "overlaps grain 7"),
        (dict(positions=[[0.03, 0.03, 0.28]] * 2, radii=0.004), "of those to insert"),
        (dict(positions=[0.03, 0.03, 0.28], radii=-1.0), "radius"),
        (dict(positions=[0.03, 0.03, 0.28], radii=np.nan), "radius"),
        (dict(positions=[0.03, 0.28], radii=0.004), "shape"),
        (dict(positions=[[0.03, 0.03, 0.28]], radii=[0.004, 0.004]), "shape"),
        (dict(positions=[0.03, 0.03, 0.28], radii=0.004, velocities=[np.inf, 0, 0]), "inf"),
        (dict(positions=[0.03, 0.03, 0.28], radii=0.004, material="steel"), "steel"),
    ]:
        with pytest.raises(makadam.InterventionError, match=words):
            filled.insert(**arguments)
    for ids in (60, [-1], [1.5], [True] * 60):
        with pytest.raises(makadam.InterventionError):
            filled.remove(ids)
    assert filled.remove([]).tolist() == list(range(60))
    assert filled.state_hash == before
    two = makadam.Simulation(space([{"position": [0, 0, 0]}], material={"glass": material(), "steel": material()}))
    with pytest.raises(makadam.InterventionError, match="glass, steel"):
        two.insert([0.1, 0, 0], 0.005)
    two.insert([0.1, 0, 0], 0.005, material="steel")
    assert two.grains()[1]["material"] == "steel"
