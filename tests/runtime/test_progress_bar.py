"""Progress is shown to a person who waits, and to nobody else."""

import io
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from runtime import load
from runtime import progress_bar as progress
from runtime.machine_facade import Machine

Look = Callable[[type[io.StringIO]], io.StringIO]


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def look(monkeypatch: pytest.MonkeyPatch) -> Look:
    """Lets a stream stand for that at which a person looks, and returns it."""

    def at(stream: type[io.StringIO]) -> io.StringIO:
        made = stream()
        monkeypatch.setattr(sys, "stderr", made)
        return made

    return at


@pytest.mark.parametrize(
    ("stream", "wanted", "patience", "told"),
    [
        (io.StringIO, True, -1.0, False),
        (Terminal, False, -1.0, False),
        (Terminal, True, 1.0, False),
        (Terminal, True, -1.0, True),
    ],
    ids=["nobody looks", "declined", "short", "long"],
)
def test_a_long_analysis_shows_a_bar_to_a_terminal(
    monkeypatch: pytest.MonkeyPatch, look: Look, stream: type[io.StringIO], wanted: bool,
    patience: float, told: bool,
) -> None:  # fmt: skip
    shown = look(stream)
    monkeypatch.setattr(progress, "PATIENCE", patience)
    with progress.bar("kinematics of x/y", wanted) as report:
        assert (report is progress.silent) is (not wanted or not shown.isatty())
        report(0.25)
        report(0.5)
    assert ("kinematics of x/y" in shown.getvalue()) is told
    assert told or not shown.getvalue()


def test_analyses_report_their_progress(driven: Machine) -> None:
    from runtime.dynamics.prescribed_motion import kinematics

    seen: list[float] = []
    kinematics(driven.mechanism, np.linspace(0.0, 1.0, 10001), progress=seen.append)
    assert np.diff([0.0, *seen]).min() > 0.0
    assert np.diff([0.0, *seen]).max() <= 0.4096  # a report at least every 4096 instants
    assert seen[-1] == 1.0


class Notebook(io.StringIO):
    """As a notebook's stream of errors."""


Notebook.__module__ = "ipykernel.iostream"

FUNCTION = "def double(x):\n    return 2.0 * x\n"


def compile_one(folder: Path, name: str) -> None:
    """Have numba compile a function of a file of that name, in place of the library's."""
    import numba

    path = folder / f"{name}.py"
    path.parent.mkdir(exist_ok=True)
    namespace: dict[str, Any] = {}
    exec(compile(FUNCTION, str(path), "exec"), namespace)
    numba.njit("float64(float64)")(namespace["double"])


@pytest.fixture
def runtime_at(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setattr(progress, "LIBRARY", tmp_path)
    monkeypatch.setattr(progress, "PATIENCE", -1.0)
    return tmp_path / "runtime"


@pytest.mark.parametrize("stream", [Terminal, Notebook])
def test_compilation_of_the_runtime_is_told_with_how_long_it_takes(
    look: Look, runtime_at: Path, stream: type[io.StringIO]
) -> None:
    shown = look(stream)
    with progress.compilation_shown():
        compile_one(runtime_at, "loop")
        compile_one(runtime_at, "step")
    text = shown.getvalue()
    assert "compiling the runtime, once after an installation: up to a minute" in text
    assert text.count("up to a minute") == 1 or stream is Terminal
    assert text.endswith("s; later runs start at once.\n")


def test_what_is_not_compiled_is_no_time_of_compilation(
    monkeypatch: pytest.MonkeyPatch, look: Look, runtime_at: Path
) -> None:
    """Two functions of 2 s each, 300 s of a run between them."""
    shown, instants = look(Notebook), iter([0.0, 2.0, 302.0, 304.0])
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: next(instants)))
    compilation, namespace = progress._Compilation(terminal=False), dict[str, Any]()
    exec(compile(FUNCTION, str(runtime_at / "loop.py"), "exec"), namespace)
    for _ in range(2):
        compilation.begin(namespace["double"])
        compilation.end()
    compilation.close()
    assert "compiled in 4 s;" in shown.getvalue()


@pytest.mark.usefixtures("runtime_at")
def test_compilation_of_a_scene_is_told_by_its_name(look: Look, tmp_path: Path) -> None:
    shown = look(Notebook)
    with progress.compilation_shown():
        compile_one(tmp_path / "generated", "pendulum__swing")
    assert shown.getvalue() == "Linkwright: compiling pendulum, scene swing.\n"


@pytest.mark.parametrize(
    ("stream", "wanted", "patience"),
    [(io.StringIO, True, -1.0), (Terminal, False, -1.0), (Terminal, True, 60.0)],
    ids=["nobody looks", "declined", "short"],
)
def test_compilation_is_told_to_nobody_who_does_not_look(
    monkeypatch: pytest.MonkeyPatch, look: Look, runtime_at: Path, stream: type[io.StringIO],
    wanted: bool, patience: float,
) -> None:  # fmt: skip
    shown = look(stream)
    monkeypatch.setattr(progress, "PATIENCE", patience)
    progress.shows_compilation(lambda progress: compile_one(runtime_at, "loop"))(progress=wanted)
    assert shown.getvalue() == ""


def test_loading_and_every_analysis_show_what_is_compiled(
    monkeypatch: pytest.MonkeyPatch, runtime_at: Path, driven: Machine, pendulum: Machine
) -> None:
    calls = {
        "load": lambda: load("slider_crank", "kinematics"),
        "simulate": lambda: pendulum.simulate(0.01),
        "kinematics": lambda: driven.kinematics([0.0, 0.01]),
        "inverse_dynamics": lambda: driven.inverse_dynamics([0.0, 0.01]),
        "equilibrium": pendulum.equilibrium,
        "assemble": pendulum.assemble,
    }
    for word, call in calls.items():
        entered: list[bool] = []
        monkeypatch.setattr(
            progress, "_Compilation", type("_", (_Listening,), {"entered": entered})
        )
        monkeypatch.setattr(sys, "stderr", Terminal())
        call()
        assert entered, word


class _Listening(progress._Compilation):
    entered: list[bool]

    def __init__(self, terminal: bool) -> None:
        super().__init__(terminal)
        self.entered.append(terminal)
