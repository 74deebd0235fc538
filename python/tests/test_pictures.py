"""Frames on disk, pictures, pages: what the command makes of them, and what is refused."""

import os
import subprocess
import sys
import zlib
from base64 import b64decode

import makadam
import numpy as np
import pytest
from conftest import bin_scene, space


def command(*arguments, folder):
    """Runs the command that comes with the package."""
    line = [sys.executable, "-m", "makadam", *map(str, arguments)]
    return subprocess.run(line, cwd=folder, capture_output=True, text=True, env={**os.environ, "NO_COLOR": "1"})


def test_a_picture_shows_the_grains(filled, tmp_path):
    pixels = filled.picture(tmp_path / "bin.png", size=(200, 150))
    assert pixels.shape == (150, 200, 3) and pixels.dtype == np.uint8
    assert (tmp_path / "bin.png").read_bytes().startswith(b"\x89PNG")
    # Grains of one colour by diameter, of another by speed; without walls there is more paper.
    other = filled.picture(field="diameter", size=(200, 150))
    bare = filled.picture(walls=False, size=(200, 150))
    assert not np.array_equal(pixels, other) and not np.array_equal(pixels, bare)
    assert np.array_equal(pixels, filled.picture(frame=filled.frame(), size=(200, 150)))
    for wrong, words in [
        ({"field": "colour"}, "no field 'colour'.*speed"),
        ({"view": "behind"}, "view: 'behind'"),
        ({"clip": "w=1"}, "clip: 'w=1'"),
        ({"range": (1.0, 0.0)}, "range"),
        ({"size": (10, 900)}, "size: 10"),
        ({"file": tmp_path / "bin.jpg"}, "must end in .png"),
        ({"file": tmp_path / "nowhere" / "bin.png"}, "nowhere"),
    ]:
        with pytest.raises(makadam.JudgeError, match=words):
            filled.picture(**wrong)


def test_a_recording_is_drawn_at_a_time(tmp_path):
    recording = makadam.simulate(bin_scene(count=20), seed=4)
    first, last = (recording.picture(time=time, size=(120, 90)) for time in (0.0, 0.5))
    assert not np.array_equal(first, last) and np.array_equal(last, recording.picture(size=(120, 90)))
    with pytest.raises(makadam.JudgeError, match="0.6 s lies outside of the run.*0 s to 0.5"):
        recording.picture(time=0.6)
    recording.view(tmp_path / "run.html")
    assert "11 frames" in payload(tmp_path / "run.html")


def payload(page):
    """The payload of a page, as text."""
    text = page.read_text()
    packed = max(text.replace("<", ">").split(">"), key=len)
    return zlib.decompress(b64decode(packed)).decode("latin-1")


def test_a_page_shows_frames(filled, tmp_path):
    filled.view(tmp_path / "now.html")
    assert "1 frame" in payload(tmp_path / "now.html")
    frames = filled.record(0.1)
    filled.view(tmp_path / "film.html", frames, fields=["pressure"])
    shown = payload(tmp_path / "film.html")
    assert "3 frames" in shown and "bin" in shown
    with pytest.warns(makadam.MakadamWarning, match="One frame in 2"):
        filled.view(tmp_path / "short.html", frames, every=2)
    with pytest.raises(makadam.JudgeError, match="order of time"):
        filled.view(tmp_path / "wrong.html", frames[::-1])
    with pytest.raises(makadam.JudgeError, match="no frames"):
        filled.view(tmp_path / "wrong.html", [])
    with pytest.raises(makadam.JudgeError, match=".html"):
        filled.view(tmp_path / "film.htmx", frames)
    filled.insert([0.03, 0.03, 0.28], 0.004)
    filled.view(tmp_path / "grown.html", [*frames, makadam_step(filled).frame()])
    assert "4 frames" in payload(tmp_path / "grown.html")
    assert not (tmp_path / "wrong.html").exists()


def makadam_step(simulation):
    simulation.step()
    return simulation


def test_saved_frames_are_those_of_a_run(filled, tmp_path):
    frames = filled.record(0.1)
    filled.save_frames(tmp_path / "run", frames)
    assert (tmp_path / "run" / "frames.mkd").exists()
    assert command("export", "run", "--format", "vtp", folder=tmp_path).returncode == 0
    assert len(list((tmp_path / "run" / "frames").glob("grains-*.vtp"))) == 3 and (tmp_path / "run" / "walls.pvd").exists()
    with pytest.raises(makadam.JudgeError, match="holds frames already"):
        filled.save_frames(tmp_path / "run", frames)
    assert "bin at" in command("picture", "run", "--size", "100x80", folder=tmp_path).stdout
    scene = tmp_path / "bin.toml"
    scene.write_text(filled.scene.to_toml())
    measured = command("measure", "run", "--scene", scene, "--json", folder=tmp_path)
    assert measured.returncode == 0 and "wall_force_over_weight" in measured.stdout, measured.stderr


def test_walls_that_the_caller_moved_are_not_drawn_elsewhere(filled, tmp_path):
    filled.move_wall("box", velocity=[0.0, 0.0, -0.01])
    filled.step(5)
    for attempt in (
        lambda: filled.picture(size=(100, 80)),
        lambda: filled.view(tmp_path / "moved.html"),
        lambda: filled.save_frames(tmp_path / "moved"),
    ):
        with pytest.raises(makadam.JudgeError, match="wall 'box' was moved.*walls=False"):
            attempt()
    assert filled.picture(size=(100, 80), walls=False).shape == (80, 100, 3)
    filled.view(tmp_path / "moved.html", walls=False)
    filled.save_frames(tmp_path / "moved", walls=False)
    assert command("export", "moved", "--format", "vtp", folder=tmp_path).returncode == 0
    assert (tmp_path / "moved" / "grains.pvd").exists() and not (tmp_path / "moved" / "walls.pvd").exists()


def test_a_simulation_without_grains_is_drawn():
    assert makadam.Simulation(space([])).picture(size=(64, 64)).shape == (64, 64, 3)
