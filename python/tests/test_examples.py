"""The examples: the notebook's cells, the ten lines of the page, and the calibration where GrainLearning is there."""

import importlib.util
import re
from pathlib import Path

import makadam
import pytest

HERE = Path(__file__).parent.parent


def test_the_cells_of_the_notebook_run():
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("matplotlib")
    pytest.importorskip("pandas")
    pytest.importorskip("ipykernel")
    notebook = nbformat.read(HERE / "examples" / "first_drum.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    text = "".join(str(cell.get("outputs", "")) for cell in notebook.cells)
    assert "dynamic_angle_of_repose" in text and "image/png" in text


def test_the_code_of_the_page_runs(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib").use("agg")
    pytest.importorskip("pandas")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (HERE / "README.md").read_text(), re.DOTALL)
    assert len(blocks) > 5
    names = {}
    for block in blocks:
        exec(compile(block, "README.md", "exec"), names)
    assert (tmp_path / "drum.png").stat().st_size > 1000


def test_grainlearning_calibrates_a_friction():
    pytest.importorskip("grainlearning")
    spec = importlib.util.spec_from_file_location("calibrate_friction", HERE / "examples" / "calibrate_friction.py")
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    # Shorter runs and fewer of them than the example makes.
    friction, tried = example.calibrate(27.0, samples=10, iterations=2, duration=2.0, threads=2)
    assert 0.05 < friction < 0.8 and len(tried) >= 10
    angles = [example.angle_of_repose(friction, seed, duration=2.0)[0] for seed in (11, 12)]
    assert sum(angles) / 2 == pytest.approx(27.0, abs=1.0)
    assert makadam.statistics.ensemble(angles)["seeds"] == 2
