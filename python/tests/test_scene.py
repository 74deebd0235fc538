"""Scenes from dicts, texts, files and names; what is wrong with one is said with its place."""

import copy
import pickle

import makadam
import numpy as np
import pytest
from conftest import bin_scene, space


def test_scenes_are_known_by_name():
    names = makadam.scenes()
    assert {"drum", "packing", "heap"} <= set(names)
    scene = makadam.Scene("drum")
    assert (scene.name, scene.grains) == ("drum", 1600)
    assert "shell" in scene.walls and scene.materials and scene.duration > 0
    assert scene.gravity == (0.0, 0.0, -9.81)
    assert "drum" in repr(scene)


def test_a_dict_a_text_and_a_file_are_one_scene(tmp_path):
    of_dict = makadam.Scene(bin_scene())
    text = of_dict.to_toml()
    file = tmp_path / "bin.toml"
    file.write_text(text)
    of_file = makadam.Scene(file)
    assert of_dict == makadam.Scene(text) == of_file == makadam.Scene(str(file)) == makadam.Scene(of_dict.to_dict())
    assert of_file.file == str(file) and of_dict.file is None
    assert pickle.loads(pickle.dumps(of_dict)) == of_dict
    assert len({of_dict, of_file}) == 1


@pytest.mark.parametrize(
    "duplicate",
    [
        lambda scene: pickle.loads(pickle.dumps(scene)),
        copy.deepcopy,
        makadam.Scene,
        lambda scene: makadam.Scene(scene.to_dict()),
        lambda scene: makadam.Scene(scene.to_toml()),
        lambda scene: scene.with_overrides({"duration": 0.6}),
    ],
    ids=["pickle", "deepcopy", "Scene", "dict", "text", "overrides"],
)
def test_a_duplicate_has_the_settings_of_the_simulation(duplicate):
    asked = makadam.Scene("packing-100", {"accuracy.angle": 1.0})
    for scene in ("packing-100", asked):
        for settings in ({"time_step": 1e-4, "precision": "single"}, {"method": "jacobi"}):
            simulation = makadam.Simulation(scene, **settings)
            own, other = simulation.scene, duplicate(simulation.scene)
            assert other == own.with_overrides({"duration": other.duration})
            assert (other.time_step, other.to_dict()["solver"]) == (simulation.time_step, own.to_dict()["solver"])
            simulation.step(3)
            assert makadam.Simulation.resume(other, simulation.checkpoint()).state_hash == simulation.state_hash
    assert duplicate(asked).to_dict()["accuracy"] == asked.to_dict()["accuracy"] and duplicate(asked).time_step == asked.time_step


def test_a_duplicate_knows_where_it_came_from(tmp_path):
    scene = pickle.loads(pickle.dumps(makadam.Scene("packing")))
    assert scene.file == makadam.Scene("packing").file
    assert makadam.reference(scene) == makadam.reference("packing") != []
    file = tmp_path / "bin.toml"
    file.write_text(makadam.Scene(bin_scene(duration=0.4)).to_toml())
    other = copy.deepcopy(makadam.Scene(file))
    assert other.file == str(file)
    file.unlink()
    assert copy.deepcopy(other) == other and makadam.reference(other) == []


def test_numbers_and_arrays_of_numpy_are_taken():
    grain = {"position": np.array([0.1, 0.0, 0.0]), "radius": np.float64(0.004)}
    scene = makadam.Scene(space([grain], seed=np.int64(7)))
    assert scene.seed == 7 and scene.to_dict()["grain"][0]["position"] == [0.1, 0.0, 0.0]


def test_overrides_replace_add_and_remove():
    scene = makadam.Scene("drum", overrides={"material.grain.friction": 0.25, "population[0].count": 100, "solver.step": 1e-3})
    document = scene.to_dict()
    assert document["material"]["grain"]["friction"] == 0.25
    assert (scene.grains, scene.time_step) == (100, 1e-3)
    assert scene.with_overrides({"population.0.count": 50}).grains == 50
    assert makadam.Scene("drum").grains == 1600
    assert makadam.Scene(bin_scene(), {"wall[0]": None}).walls == []
    for path, words in [
        ("population[3].count", "there is no 3"),
        ("wall.box.name", "no number"),
        ("name.first", "neither a table nor a list"),
        ("a..b", "is no path"),
        ("solver.stepp", "stepp"),
    ]:
        with pytest.raises(makadam.SceneError, match=words):
            scene.with_overrides({path: 1})


@pytest.mark.parametrize(
    ("change", "path", "words"),
    [
        ({"duration": -1.0}, "duration", "out of range"),
        ({"zzz": 1}, "zzz", "unknown field"),
        ({"material": {"glass": {"density": 2500.0}}}, "material.glass", "missing field"),
        ({"solver": {"step": "fast"}}, "solver.step", "expected a number"),
        ({"grain": [{"material": "steel", "radius": 0.005, "position": [0, 0, 0]}]}, "grain[0].material", "steel"),
        ({"measure": {"observables": []}, "compare": [{"observable": "gini"}]}, "compare[0].observable", "not measured"),
    ],
)
def test_what_is_wrong_is_said_with_its_path(change, path, words):
    with pytest.raises(makadam.SceneError, match=words) as caught:
        makadam.Scene(space([{"position": [0.0, 0.0, 0.0]}], **change))
    error = caught.value
    assert error.path == path and error.problem and error.remedy
    assert error.line is None and error.file is None
    assert isinstance(error, (makadam.Error, ValueError))


def test_a_file_is_told_with_its_line(tmp_path):
    file = tmp_path / "wrong.toml"
    file.write_text(makadam.Scene(bin_scene()).to_toml().replace("duration = 0.5", "duration = -0.5"))
    with pytest.raises(makadam.SceneError) as caught:
        makadam.Scene(file)
    lines = file.read_text().splitlines()
    assert lines[caught.value.line - 1].startswith("duration")
    assert caught.value.file == str(file) and f"{file}:{caught.value.line}" in str(caught.value)
    assert caught.value.path == "duration"


def test_what_is_no_scene_is_refused(tmp_path):
    with pytest.raises(makadam.SceneNotFoundError, match="did you mean drum"):
        makadam.Scene("drumm")
    with pytest.raises(FileNotFoundError):
        makadam.Scene(tmp_path / "nothing.toml")
    with pytest.raises(TypeError, match="no scene of a"):
        makadam.Scene(7)
    with pytest.raises(makadam.SceneError, match="gravity.*no place in a scene"):
        makadam.Scene(space([], gravity=object()))
    with pytest.raises(makadam.SceneError):
        makadam.Scene("this is\nno TOML")
    nested = inner = {}
    for _ in range(60):
        inner["a"] = inner = {}
    with pytest.raises(makadam.SceneError, match="too deeply"):
        makadam.Scene(nested)
    with pytest.raises(makadam.SceneError, match="population"):
        makadam.Simulation(bin_scene(count=100_000))
