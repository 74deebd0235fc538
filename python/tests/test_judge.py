"""The judge: observables, references, statistics, comparisons, tables."""

import copy
import inspect
import pickle
import re
from pathlib import Path

import makadam
import numpy as np
import pytest
from conftest import bin_scene, space
from makadam import judge, statistics, tables


@pytest.fixture(scope="module")
def recording():
    return makadam.simulate(bin_scene(), seed=4)


def test_a_recording_is_measured(recording, tmp_path):
    assert (recording.code, recording.seed, recording.time_step) == ("Makadam", 4, 1e-3)
    assert len(recording.frames) == 11 and recording.frames[-1].time == pytest.approx(0.5)
    rows = recording.measure()
    values = {row["observable"]: row for row in rows}
    assert values["wall_force_over_weight"]["value"] == pytest.approx(1.0, abs=0.05)
    assert values["wall_force_over_weight"]["frames"] == 5
    assert makadam.measure(recording.scene, recording.frames[-5:]) == rows
    file = tmp_path / "run.rec"
    recording.save(file)
    again = makadam.Recording.load(bin_scene(), file)
    assert again.measure() == rows
    file.write_bytes(file.read_bytes()[:-3])
    with pytest.raises(makadam.JudgeError, match="cut off"):
        makadam.Recording.load(bin_scene(), file)
    with pytest.raises(makadam.JudgeError, match="at least one frame"):
        makadam.Recording(bin_scene(), [])


def test_what_is_of_another_scene_is_not_measured(recording, tmp_path):
    file = tmp_path / "run.rec"
    recording.save(file)
    with pytest.raises(makadam.JudgeError, match="of the scene 'bin', not of 'drum'"):
        makadam.Recording.load("drum", file)
    frames = recording.frames
    few, other = bin_scene(count=5), bin_scene()
    other["population"][0]["radius"]["mean"] = 0.003
    for scene, problem in ((few, "60 grains, and the scene has 5"), (other, "has a radius of")):
        for attempt in (
            lambda scene=scene: makadam.measure(scene, [frames[-1]]),
            lambda scene=scene: makadam.Recording(scene, frames),
            lambda scene=scene: makadam.Simulation(scene).measure([frames[-1]]),
            lambda scene=scene: makadam.Recording.load(scene, file),
        ):
            with pytest.raises(makadam.JudgeError, match=problem):
                attempt()


def test_frames_and_recordings_are_pickled(recording):
    for duplicate in (lambda one: pickle.loads(pickle.dumps(one)), copy.deepcopy):
        frame, again = recording.frames[-1], duplicate(recording.frames[-1])
        assert again.time == frame.time and np.array_equal(again.positions, frame.positions)
        assert np.array_equal(again.contacts()["normal_force"], frame.contacts()["normal_force"])
        assert duplicate(recording).measure() == recording.measure() and duplicate(recording).scene == recording.scene
    damaged = pickle.dumps(recording.frames[-1]).replace(b"mkd-frm\x04", b"mkd-frm\x05")
    with pytest.raises(makadam.JudgeError, match="version 5"):
        pickle.loads(damaged)


def test_invalid_numbers_are_reported():
    deep = [{"position": [0.0, 0.0, 0.0]}, {"position": [0.0045, 0.0, 0.0]}]
    watch = {"on_deep_overlap": "warn", "on_overlap": "warn", "on_energy": "ignore"}
    measure = {"interval": 2e-6, "observables": ["coordination-number"]}
    changes = {"duration": 4e-6, "solver": {"step": 1e-6}, "largest_start_overlap": 2.0}
    scene = space(deep, watch=watch, measure=measure, **changes)
    with pytest.warns(makadam.MakadamWarning, match="INVALID.*centre lies inside"):
        recording = makadam.simulate(scene)
    for one in (recording, pickle.loads(pickle.dumps(recording))):
        with pytest.warns(makadam.MakadamWarning, match="INVALID"):
            one.measure()


def test_a_simulation_measures_itself(recording):
    simulation = makadam.Simulation(bin_scene(), seed=4)
    frames = simulation.record(0.5)
    assert [frame.time for frame in frames] == pytest.approx([frame.time for frame in recording.frames])
    assert np.array_equal(frames[-1].positions, recording.frames[-1].positions)
    assert simulation.measure(frames[6:]) == recording.measure()
    own = makadam.Recording(simulation.scene, frames, seed=4)
    assert own.measure() == recording.measure()
    assert {row["frames"] for row in simulation.measure()} == {1}
    assert simulation.measure([]) == []


def test_observables_are_known_by_name():
    known = makadam.observables()
    assert known["dynamic_angle_of_repose"] == "dynamic-angle-of-repose" and known["gini"] == "contact-forces"


def test_references_are_tables():
    rows = makadam.reference("packing")
    assert {row["code"] for row in rows} == {"YADE", "LIGGGHTS", "LAMMPS"}
    fractions = [row["value"] for row in rows if row["code"] == "YADE" and row["observable"] == "packing_fraction"]
    assert len(fractions) > 2 and 0.59 < np.mean(fractions) < 0.61
    assert makadam.reference(bin_scene()) == []
    columns = tables.columns(rows)
    assert len(columns["value"]) == len(rows) and set(columns) == set(rows[0])


def test_seeds_are_held_against_references(recording):
    # The recorded numbers of one reference code against those of the other, by margins that a scene names.
    rows = makadam.reference("packing")

    def values(code):
        return [row["value"] for row in rows if row["code"] == code and row["observable"] == "packing_fraction"]

    test = statistics.equivalence(values("YADE"), values("LIGGGHTS"), margin=0.006, codes=3)
    assert test["outcome"] == "agree" and test["interval90"][0] < test["difference"] < test["interval90"][1]
    # Runs of another scene, and a seed that is given twice, are refused.
    with pytest.raises(makadam.JudgeError, match="another scene than packing"):
        makadam.compare("packing", [recording])
    packed = [makadam.simulate("packing", seed=seed) for seed in (1, 2)]
    with pytest.raises(makadam.JudgeError, match="two runs have seed 2"):
        makadam.compare("packing", [*packed, packed[1]])
    compared = makadam.compare("packing", packed)
    assert {row["reference_code"] for row in compared.rows if row["code"] == "Makadam"} == {"YADE", "LIGGGHTS", "LAMMPS"}
    assert compared.standing != "not-measured" and "YADE was not run" in " ".join(compared.notes)
    assert all(len(column) == len(compared.rows) for column in compared.columns().values())
    with pytest.raises(makadam.JudgeError, match="nothing to compare"):
        makadam.compare(bin_scene())
    with pytest.raises(makadam.JudgeError, match="no code 'edem'"):
        makadam.compare("packing", codes=["edem"])
    with pytest.raises(makadam.JudgeError, match="no code"):
        makadam.simulate(bin_scene(), code="edem")


@pytest.fixture(scope="module")
def packed():
    """Complete runs of a scene that is fast, by their seeds."""
    return {seed: makadam.simulate("packing-100", seed=seed) for seed in (1, 2, 3)}


def test_one_run_is_not_several_seeds(packed):
    frames = packed[1].frames
    with pytest.raises(makadam.JudgeError, match="not of seed 2 of 'packing-100': grain 0 has a radius of"):
        makadam.Recording("packing-100", frames, seed=2)
    assert makadam.Recording("packing-100", frames).seed == makadam.Scene("packing-100").seed == 1
    # Where all radii are equal no seed is seen in them.
    scene = bin_scene(population=[{**bin_scene()["population"][0], "radius": {"kind": "uniform", "mean": 0.004, "spread": 0.0}}])
    scene["compare"] = [{"observable": "coordination_number", "margin": 1.0}]
    frames = makadam.simulate(scene, seed=1).frames
    runs = [makadam.Recording(scene, frames, seed=seed) for seed in (1, 2)]
    with pytest.raises(makadam.JudgeError, match="seeds 1 and 2 have the same frames"):
        makadam.compare(scene, runs, codes=["makadam"])
    assert makadam.compare(scene, runs[:1], codes=["makadam"]).rows


def test_runs_that_are_not_whole_are_not_compared(packed):
    frames = packed[1].frames
    with pytest.raises(makadam.JudgeError, match="seed 1 has its last frame at 0.5.*ends at 0.6 s"):
        makadam.compare("packing-100", [makadam.Recording("packing-100", frames[:-1])])
    scene = bin_scene(compare=[{"observable": "coordination_number", "margin": 1.0}])
    whole = makadam.simulate(scene, seed=3).frames
    for kept in (whole[:7] + whole[9:], whole[:6] + whole[8:], whole[-1:]):
        with pytest.raises(makadam.JudgeError, match="has no frames between 0.3"):
            makadam.compare(scene, [makadam.Recording(scene, kept, seed=3)], codes=["makadam"])
    recorded = makadam.Simulation(scene, seed=3)
    assert makadam.compare(scene, [makadam.Recording(scene, recorded.record(0.5), seed=3)], codes=["makadam"]).rows


def test_codes_are_compared_here_and_now():
    # A packing of few grains, poured twice: what is recorded is of another scene, and that is said.
    scene = makadam.Scene("packing", overrides={"population[0].count": 200, "duration": 0.3})
    compared = makadam.compare(scene, codes="makadam", seeds=2)
    assert {code["code"] for code in compared.codes} == {"Makadam"} and compared.codes[0]["seeds"] in ((1, 2), [1, 2])
    assert compared.verdict and compared.rows[0]["reference_code"] is None
    assert compared.to_pandas().shape[0] == len(compared.rows)


@pytest.mark.parametrize("code", ["yade", "liggghts", "lammps"])
def test_a_peer_that_is_installed_runs_here(code):
    scene = bin_scene(count=20, duration=0.1, measure={"interval": 0.05, "from": 0.0, "observables": ["balances"]})
    try:
        recording = makadam.simulate(scene, seed=2, code=code)
    except makadam.JudgeError as error:
        assert "is not installed" in str(error)
        pytest.skip(f"{code} is not installed")
    assert recording.code == code.upper()
    own = makadam.simulate(scene, seed=2)
    start, end = recording.frames[0], recording.frames[-1]
    assert end.time == pytest.approx(0.1, rel=1e-3) and len(end) == 20
    # The same grains at the start, in free fall for the most part.
    assert np.allclose(start.positions, own.frames[0].positions, atol=1e-6)
    assert np.allclose(end.positions.mean(axis=0), own.frames[-1].positions.mean(axis=0), atol=1e-3)
    assert recording.measure()


def test_statistics():
    mean, error = statistics.block_average(np.arange(20.0))
    assert mean == 9.5 and error == pytest.approx(np.std([1.5, 5.5, 9.5, 13.5, 17.5], ddof=1) / np.sqrt(5))
    assert statistics.block_average([1.0, 2.0]) == (1.5, None)
    found = statistics.ensemble([1.0, 2.0, 3.0])
    assert (found["seeds"], found["mean"], found["standard_deviation"]) == (3, 2.0, 1.0)
    # Student's t at 95% for two degrees of freedom is 2.920.
    assert found["interval90"][1] - 2.0 == pytest.approx(2.919986 / np.sqrt(3), rel=1e-6)
    assert statistics.ensemble([1.0])["interval90"] is None
    undecided = statistics.equivalence([1.0, 1.2, 0.9], [1.1, 1.0, 1.05], margin=0.1)
    assert undecided["outcome"] == "undecided" and undecided["seeds_needed"] > 3
    assert statistics.equivalence([1.0, 1.01], [3.0, 3.01], margin=0.1)["outcome"] == "disagree"
    assert statistics.equivalence([1.0, 1.01], [3.0, 3.01])["outcome"] is None
    for wrong in ([], [1.0, np.nan]):
        with pytest.raises(makadam.JudgeError):
            statistics.ensemble(wrong)
    with pytest.raises(makadam.JudgeError, match="margin"):
        statistics.equivalence([1.0], [1.0], margin=-1.0)


def test_tables_of_pandas(recording, filled):
    pandas = pytest.importorskip("pandas")
    table = tables.to_pandas(recording.measure())
    assert list(table.columns) == ["observable", "unit", "value", "standard_error", "frames"]
    assert table.equals(pandas.DataFrame(recording.measure()))
    grains = filled.to_pandas()
    assert grains.shape == (60, 10) and grains.index.name == "id" and grains["z"].min() > 0
    contacts = tables.contacts_to_pandas(filled.frame())
    assert {"first", "second", "wall", "point_x", "normal_z", "normal_force"} <= set(contacts.columns)
    assert (contacts["normal_force"] > 0).all()


def test_everything_is_documented_and_typed():
    package = Path(makadam.__file__).parent
    assert (package / "py.typed").is_file() and (package / "_core.pyi").is_file()
    stub = (package / "_core.pyi").read_text()
    for name, value in vars(makadam._core).items():
        if not name.startswith("__") and callable(value):
            assert re.search(rf"^(def|class) {name}\b", stub, re.MULTILINE), f"{name} is not in the stubs"
            if name != "Simulation":
                assert value.__doc__, name
    for kind in (makadam.Simulation, makadam.Scene, makadam.Frame, makadam.Recording, judge.Comparison):
        for name, member in inspect.getmembers(kind):
            if not name.startswith("_") and (callable(member) or isinstance(member, property)):
                assert inspect.getdoc(member), f"{kind.__name__}.{name} has no docstring"
    for kind in (makadam._core.Simulation, makadam.Scene, makadam.Frame, makadam.Recording):
        for name in vars(kind):
            if not name.startswith("__"):
                assert f" {name}(" in stub, f"{kind.__name__}.{name} is not in the stubs"
