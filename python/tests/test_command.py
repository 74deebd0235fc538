"""The command that comes with the package: its exit codes, its output, Ctrl-C."""

import os
import signal
import subprocess
import sys
import time
from importlib import metadata
from pathlib import Path

import makadam
import pytest
from conftest import bin_scene


def line(*arguments):
    return [sys.executable, "-m", "makadam", *map(str, arguments)]


def run(*arguments, folder, **options):
    return subprocess.run(line(*arguments), cwd=folder, capture_output=True, text=True, **options)


def test_the_package_installs_the_command():
    scripts = [entry for entry in metadata.entry_points(group="console_scripts") if entry.name == "makadam"]
    if not scripts:
        pytest.skip("the package was not installed by pip")
    said = subprocess.run([Path(sys.executable).with_name("makadam"), "--version"], capture_output=True, text=True)
    assert (said.returncode, said.stdout) == (0, f"makadam {makadam.__version__}\n")


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["--version"], 0, f"makadam {makadam.__version__}"),
        (["print", "scenes", "--quiet"], 0, "drum"),
        (["run", "--no-such-option"], 2, "unexpected argument"),
        (["qualify", "--threads", "2"], 2, "called --jobs now"),
        (["check", "no-such-scene"], 3, "no-such-scene"),
        (["check", "wrong.toml"], 3, "wrong.toml"),
        (["check", "-"], 0, "no objection"),
    ],
)
def test_exit_codes_and_output_are_those_of_the_command(tmp_path, arguments, code, words):
    (tmp_path / "wrong.toml").write_text("name = 3\n")
    said = run(*arguments, folder=tmp_path, input=makadam.Scene(bin_scene()).to_toml())
    assert said.returncode == code, said.stderr
    assert words in (said.stdout if code == 0 else said.stderr)


def test_a_run_of_the_command_has_the_bits_of_the_package(tmp_path):
    scene = tmp_path / "bin.toml"
    scene.write_text(makadam.Scene(bin_scene()).to_toml())
    said = run("run", scene, "--steps", 50, "--quiet", "--output", "run", folder=tmp_path)
    assert said.returncode == 0, said.stderr
    simulation = makadam.Simulation(scene)
    simulation.step(50)
    summary = (tmp_path / "run" / "run.json").read_text()
    assert simulation.state_hash in summary
    # What was typed, not how Python was started.
    assert '"makadam run ' in summary and "-m" not in summary.split('"makadam run ')[1].split('"')[0]


def test_ctrl_c_ends_a_run_that_can_be_resumed(tmp_path):
    scene = tmp_path / "bin.toml"
    scene.write_text(makadam.Scene(bin_scene(duration=1e4, measure={"interval": 1.0})).to_toml())
    arguments = line("run", scene, "--quiet", "--output", "run")
    # A job in the background of a script ignores Ctrl-C, and so would its child.
    default = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)  # noqa: E731
    process = subprocess.Popen(arguments, cwd=tmp_path, stderr=subprocess.PIPE, text=True, preexec_fn=default)
    until = time.time() + 60
    while not (tmp_path / "run" / "frames.mkd").exists() and time.time() < until:
        time.sleep(0.02)
    time.sleep(0.3)
    os.kill(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 1 and "--resume" in said and "Traceback" not in said
    assert (tmp_path / "run" / "run.checkpoint").exists()
