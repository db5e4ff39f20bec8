"""A process that has no SymPy yet has a first machine built by another one."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from codegen.other_processes import can_start, interpreter, module_path
from runtime import build_process

MODEL = """
from codegen import Model
{}
model = Model("pendulum", gravity=(0, -9.81))
bob = model.body("bob", mass=2.0, inertia=0.1)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1.0, 0))
model.scene("swing", effects=["gravity"], start={{bob.phi: 0.0, bob.omega: 0.0}})
"""
PROGRAM = """
import sys
from linkwright import load
from codegen.other_processes import can_start, interpreter, module_path
from runtime import build_process
{}
machine = load("pendulum.py", scene="swing")
print("machine", *(row.name for row in machine.coordinates), "sympy" in sys.modules)
"""


@pytest.fixture
def answer(root: Path, tmp_path: Path):
    """What a process says that loads a model with a line of its own, after another line."""

    def run(line: str = "", before: str = "") -> subprocess.CompletedProcess[str]:
        (tmp_path / "pendulum.py").write_text(MODEL.format(line))
        return subprocess.run(
            [sys.executable, "-c", PROGRAM.format(before)], cwd=tmp_path, capture_output=True,
            text=True, check=False, env={**os.environ, "PYTHONPATH": str(root)},
            stdin=subprocess.DEVNULL,
        )  # fmt: skip

    return run


two_cores = pytest.mark.skipif(not can_start(), reason="one core")


@two_cores
def test_this_process_imports_no_sympy(answer, tmp_path: Path) -> None:
    done = answer()
    assert done.stdout == "machine bob.x bob.y bob.phi False\n", done.stderr
    assert (tmp_path / "generated" / "pendulum__swing.py").is_file()


def test_with_one_core_it_builds_alone(answer) -> None:
    done = answer(before="build_process.can_start = lambda: False")
    assert done.stdout == "machine bob.x bob.y bob.phi True\n", done.stderr


@two_cores
def test_a_second_scene_starts_no_other_process(answer) -> None:
    """It would import SymPy again, with nothing to import here meanwhile."""
    before = (
        "load('pendulum.py', scene='swing')\n"
        "import pathlib\n"
        "pathlib.Path('generated/pendulum__swing.py').unlink()"
    )
    assert answer(before=before).stdout == "machine bob.x bob.y bob.phi True\n"


def test_a_program_that_is_no_interpreter_starts_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "/usr/bin/cad")
    assert not can_start()


def test_with_sympy_it_builds_alone(answer) -> None:
    assert answer(before="import sympy").stdout == "machine bob.x bob.y bob.phi True\n"


def test_where_no_process_starts_it_builds_alone(answer) -> None:
    done = answer(before="sys.executable = '/nowhere/python'")
    assert done.stdout == "machine bob.x bob.y bob.phi True\n", done.stderr


@pytest.mark.parametrize(
    ("line", "out", "error"),
    [
        ("print('said')", "", "said\n"),
        ("import sys; print('said', file=sys.stderr)", "", "said\n"),
        ("import os; os.write(1, b'said')", "said", ""),
        ("import warnings; warnings.warn('said')", "", "UserWarning: said"),
    ],
)
def test_what_a_model_says_is_said_here(answer, line: str, out: str, error: str) -> None:
    done = answer(line)
    assert done.stdout == f"{out}machine bob.x bob.y bob.phi True\n"
    assert error in done.stderr


def test_a_model_that_asks_the_program_is_built_by_it(answer, tmp_path: Path) -> None:
    (tmp_path / "settings.py").write_text("LENGTH = 1.0\n")
    line = "import settings; assert settings.LENGTH == 7.0"
    done = answer(line, before="sys.path.insert(0, '.'); import settings; settings.LENGTH = 7.0")
    assert done.stdout == "machine bob.x bob.y bob.phi True\n", done.stderr


@pytest.mark.parametrize(
    ("text", "alone"),
    [
        ("from codegen import Model, t\nfrom sympy import pi\nimport math, numpy as np", True),
        ("import linkwright as lw\nmodel = lw.Model('m')", True),
        ("import settings", False),
        ("from . import settings", False),
        ("def f():\n    import os", False),
        ("import numpy as np\nx = np.random.normal()", False),
        ("from numpy import random as r", False),
        ("import numpy.random as r", False),
        ("import dataclasses\nx = dataclasses.sys.argv", False),
        ("x = open('lengths.txt').read()", False),
        ("__import__('os')", False),
        ("x = (", False),
    ],
)
def test_what_declares_alone(text: str, alone: bool, tmp_path: Path) -> None:
    (tmp_path / "model.py").write_text(text)
    assert build_process._declares_alone(tmp_path / "model.py") == alone
    assert not build_process._declares_alone(tmp_path / "nowhere.py")


def test_another_process_starts_as_this_one(monkeypatch: pytest.MonkeyPatch) -> None:
    code = "from codegen.other_processes import interpreter; print(*interpreter()[1:])"
    flags = ["-I", "-X", "utf8", "-W", "error"]
    done = subprocess.run(
        [sys.executable, *flags, "-c", code], capture_output=True, text=True, check=True
    )
    assert {"-I", "-Werror", "-P"} <= set(done.stdout.split())
    assert "utf8" in done.stdout
    monkeypatch.setattr(sys, "path", ["/a", Path("/b"), "/c"])
    assert module_path() == ["/a", "/c"]
    assert interpreter()[0] == sys.executable


def test_what_is_wrong_is_an_error_here(answer) -> None:
    done = answer("nowhere")
    assert (done.returncode, done.stdout) == (1, "")
    assert "runtime/machine_loading.py" in done.stderr
    assert "name 'nowhere' is not defined" in done.stderr.splitlines()[-1]


def test_a_model_that_asks_is_answered_here(answer) -> None:
    """There is no input: the error is this process's own, and the other one does not wait."""
    done = answer("input()")
    assert "EOF when reading a line" in done.stderr


@pytest.mark.skipif(os.name != "posix", reason="no process knows its parent's end")
def test_the_other_process_ends_with_this_one(answer, tmp_path: Path) -> None:
    """The model waits in the other process alone; this one is killed, and leaves none."""
    line = (
        "import os, time, pathlib\npathlib.Path('pid').write_text(str(os.getpid()))\ntime.sleep(60)"
    )
    before = (
        "build_process._declares_alone = lambda model: True\n"
        "import os, threading, time, pathlib\n"
        "def end():\n"
        "    while not pathlib.Path('pid').is_file() or not pathlib.Path('pid').read_text():\n"
        "        time.sleep(0.05)\n"
        "    os.kill(os.getpid(), 9)\n"
        "threading.Thread(target=end, daemon=True).start()"
    )
    done = answer(line, before)
    assert done.returncode == -9
    other = int((tmp_path / "pid").read_text())
    for _ in range(100):
        try:
            os.kill(other, 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)
    pytest.fail(f"process {other} goes on")
