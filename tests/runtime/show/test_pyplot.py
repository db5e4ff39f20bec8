"""Figures are pyplot's: a script shows and closes them, a notebook shows each of them once."""

import os
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

PENDULUM = """
import linkwright as lw

model = lw.Model("hung", gravity=(0, -9.81))
bob = model.body("bob", mass=2.0, inertia=0.1)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.scene("swing", ["gravity"], start={bob.phi: 0.0, bob.omega: 0.0})
machine = lw.load(model)
result = machine.simulate(1.0, 11, progress=False)
"""


def test_a_script_shows_and_closes_what_it_plots(tmp_path: Path) -> None:
    script = (
        PENDULUM
        + """
from matplotlib import pyplot as plt

figures = model.draw(), machine.draw(), result.draw(0.5), result.plot("bob.phi")
assert plt.get_fignums() == [1, 2, 3, 4], plt.get_fignums()
assert plt.gcf() is figures[-1]
plt.show()
plt.close(figures[0])
assert plt.get_fignums() == [2, 3, 4], plt.get_fignums()
for k in range(40):
    plt.close(result.plot("bob.phi"))
result.animate("swing.svg")
result.save("swing.html")
assert plt.get_fignums() == [2, 3, 4], plt.get_fignums()
"""
    )
    (tmp_path / "script.py").write_text(script)
    environment = {**os.environ, "MPLBACKEND": "agg", "PYTHONWARNINGS": "error"}
    environment.pop("DISPLAY", None)  # with one pyplot says that Agg has no windows
    command = [sys.executable, "-W", "ignore:numpy.ndarray:RuntimeWarning", "script.py"]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("backend", ["", "agg"])
def test_a_notebook_shows_a_figure_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, backend: str
) -> None:
    monkeypatch.delenv("MPLBACKEND", raising=False)
    cells = [PENDULUM, "result.plot('bob.phi')", "figure = result.draw(0.5)\nfigure", "figure"]
    expected = [0, 1, 1, 1]
    if backend:  # which shows nothing at the end of a cell
        monkeypatch.setenv("MPLBACKEND", backend)
    else:
        cells += ["model.draw();", "for name in ('bob.x', 'bob.y'):\n    result.plot(name)"]
        expected += [1, 2]
    notebook = nbformat.v4.new_notebook(cells=[*map(nbformat.v4.new_code_cell, cells)])
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    shown = [
        sum("image/png" in output.get("data", {}) for output in cell.outputs)
        for cell in notebook.cells
    ]
    assert shown == expected


def test_a_command_draws_files_without_pyplot(tmp_path: Path) -> None:
    (tmp_path / "hung.py").write_text(PENDULUM.partition("machine = ")[0])
    code = (
        "import sys; from linkwright.cli.application import app\n"
        "app(['draw', 'hung.py', '--out', 'hung.png'], standalone_mode=False)\n"
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "hung.png").is_file()
