"""`start` sets values and is checked, `guess` begins a search and names nothing that is fixed."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.main import get_command
from typer.testing import CliRunner

from codegen import Model
from codegen.errors import AssemblyError, InputError
from linkwright.cli.application import app
from runtime import accuracy, load, matters
from runtime.machine_facade import Machine
from runtime.results.assembled_state import Assembly
from runtime.results.result import Result

MODEL = """
from codegen import Model, t

model = Model("start_and_guess", gravity=(0, -9.81))
phase = model.parameter("phase", 0.3, unit="rad")
bob = model.body("bob", mass=2.0, inertia=0.1)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.torsion_spring("coil", model.ground, bob, 5.0)
model.driver("turn", bob.phi, phase + t)
model.scene("swing", ["gravity", "coil"], start={bob.phi: 0.3, bob.omega: 0.0})
model.scene("turned", ["gravity", "coil"], ["turn"], start={bob.phi: 0.3, bob.omega: 1.0})
"""
BOTH = {"bob.phi": 0.5, "bob.omega": 0.25}
FIXED = r"guess names what the scene fixes: bob\.phi = 0\.3 rad, bob\.omega = "
ADVICE = r"give start={'bob\.phi': 0\.5, 'bob\.omega': 0\.25} \(--start\) to set them"
SHORT: dict[str, Any] = {
    "t_end": 0.2, "quantities": ("bob.phi",), "methods": ("dop853",), "rtols": (1e-4, 1e-7),
    "formulations": ("cartesian",), "modelling": False, "building": False, "quick": True,
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's folder with the model."""
    folder = tmp_path_factory.mktemp("start_and_guess")
    (folder / "models").mkdir()
    (folder / "models" / "start_and_guess.py").write_text(MODEL, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def machine(folder: Path) -> Callable[[str], Machine]:
    return lambda scene: load("start_and_guess", scene, folder=folder)


def kinematics(machine: Machine, **given: Any) -> Result:
    return machine.kinematics([0.0, 0.1], progress=False, **given)


def inverse_dynamics(machine: Machine, **given: Any) -> Result:
    return machine.inverse_dynamics([0.0, 0.1], progress=False, **given)


def simulate(machine: Machine, **given: Any) -> Result:
    return machine.simulate(0.1, [0.0, 0.1], progress=False, **given)


def assemble(machine: Machine, **given: Any) -> Assembly:
    return machine.assemble(**given)


DRIVEN = [kinematics, inverse_dynamics, assemble]
ANALYSES = [("swing", simulate), ("swing", assemble), *(("turned", one) for one in DRIVEN)]


@pytest.mark.parametrize(("scene", "analyse"), ANALYSES)
def test_a_guess_of_what_the_scene_fixes_is_refused(
    machine: Callable[[str], Machine], scene: str, analyse: Callable[..., Any]
) -> None:
    with pytest.raises(AssemblyError, match=FIXED + r".* rad/s\. .*" + ADVICE) as caught:
        analyse(machine(scene), guess=BOTH | {"bob.x": 0.9})
    assert len(caught.value.problems) == 1
    assert "bob.x" not in str(caught.value)
    with pytest.raises(AssemblyError, match=r"give start={'bob\.phi': 0\.3} .* to set it\."):
        analyse(machine(scene), guess={"bob.phi": 0.3})


def test_it_is_told_with_all_other_problems(machine: Callable[[str], Machine]) -> None:
    with pytest.raises(AssemblyError) as caught:
        machine("swing").simulate(0.1, guess={"bob.fi": 1.0, "bob.x": np.inf, **BOTH})
    assert len(caught.value.problems) == 3


def test_start_sets_values_of_a_free_machine(machine: Callable[[str], Machine]) -> None:
    begin = machine("swing").assemble({"bob.x": 0.8}, start=BOTH)
    assert (begin["bob.phi"], begin["bob.omega"]) == (0.5, 0.25)
    assert begin["bob.y"] == pytest.approx(np.sin(0.5), abs=1e-12)
    turned = machine("swing").assemble(start={"bob.phi": -2.0})
    assert (turned["bob.phi"], turned["bob.omega"]) == (-2.0, 0.0)


@pytest.mark.parametrize("analyse", [kinematics, inverse_dynamics])
def test_start_sets_values_of_a_driven_machine(
    machine: Callable[[str], Machine], analyse: Callable[..., Result]
) -> None:
    turned = machine("turned")
    with pytest.raises(AssemblyError, match="contradict"):
        analyse(turned, parameters={"phase": 0.5})
    run = analyse(turned, parameters={"phase": 0.5}, start={"bob.phi": 0.5})
    np.testing.assert_allclose(run.q("bob.phi"), [0.5, 0.6], rtol=1e-12)
    assert "start sets bob.phi = 0.5 rad." in run.message
    with pytest.raises(AssemblyError, match=r"contradict.*bob\.phi = 0\.9 rad"):
        analyse(turned, start={"bob.phi": 0.9})
    with pytest.raises(AssemblyError, match=r"nearest: bob\.phi"):
        analyse(turned, start={"bob.fi": 0.9})


def test_start_and_guess_choose_the_branch(driven: Machine) -> None:
    """The slider on either side of the crank, which is at 45 degrees."""
    for sign in (1, -1):
        x = np.sqrt(2.0) + sign * np.sqrt(3.5**2 - 2.0)
        near = {"rod.phi": 0.0 if sign > 0 else np.pi, "rod.x": x / 2}
        held = driven.kinematics([0.0], guess=near, start={"slider.x": x})
        found = driven.kinematics([0.0], guess={**near, "slider.x": 0.95 * x})
        assert held.q("slider.x")[0] == x
        assert found.q("slider.x")[0] == pytest.approx(x, abs=1e-12)
        assert "guess slider.x = " in found.message
        assert "start= sets a value" in found.message
        assert "guess slider.x" not in held.message


@pytest.mark.parametrize("analyse", DRIVEN)
def test_start_of_other_kinds_is_refused(
    machine: Callable[[str], Machine], analyse: Callable[..., Any]
) -> None:
    turned = machine("turned")
    with pytest.raises(InputError, match=r"bob\.x is given in start and in guess"):
        analyse(turned, start={"bob.x": 0.9}, guess={"bob.x": 0.8})
    with pytest.raises(
        InputError, match=r"start is 3; it must be .*values? by name|start is 3; .*a mapping"
    ):
        analyse(turned, start=3)


def test_an_equilibrium_is_searched_for_from_any_place(machine: Callable[[str], Machine]) -> None:
    """What the scene fixes is free there; at rest nothing has a velocity."""
    rest = machine("swing").equilibrium(guess={"bob.phi": -1.0}, progress=False)
    assert abs(rest["bob.phi"] - 0.3) > 0.5
    assert rest.stable
    with pytest.raises(AssemblyError, match=r"bob\.omega is a velocity, and at rest"):
        machine("swing").equilibrium(guess={"bob.omega": 1.0}, progress=False)


def ranking(folder: Path, **given: Any) -> Any:
    words = {"asked": "max:bob.phi", "t_end": 0.2, "rounds": 1, "points": 11, "fidelities": False}
    path = folder / "models" / "start_and_guess.py"
    return matters(path, "swing", folder=folder, **{**words, **given})


def test_an_effect_ranking_starts_where_it_is_told(folder: Path) -> None:
    assert ranking(folder).value == pytest.approx(0.3, abs=1e-9)
    assert ranking(folder, start={"bob.phi": 0.5}).value == pytest.approx(0.5, abs=1e-9)
    with pytest.raises(AssemblyError, match=FIXED + ".*" + ADVICE):
        ranking(folder, guess=BOTH)
    with pytest.raises(InputError, match=r"bob\.x is given in start and in guess"):
        ranking(folder, guess={"bob.x": 0.9}, start={"bob.x": 0.9})


def test_an_effect_ranking_of_an_equilibrium(folder: Path) -> None:
    rest: dict[str, Any] = {"asked": "bob.phi", "analysis": "equilibrium", "t_end": None}
    found = ranking(folder, guess={"bob.phi": -1.0}, **rest).value
    assert found == pytest.approx(ranking(folder, **rest).value, rel=1e-6)
    with pytest.raises(InputError, match=r"an equilibrium is searched for.*Give guess="):
        ranking(folder, start={"bob.phi": -1.0}, **rest)
    with pytest.raises(AssemblyError, match=r"nearest: bob\.phi"):
        ranking(folder, guess={"bob.fi": -1.0}, **rest)


def test_a_work_precision_study_starts_where_it_is_told(
    folder: Path, machine: Callable[[str], Machine], tmp_path: Path
) -> None:
    path = folder / "models" / "start_and_guess.py"
    t = np.linspace(0.0, 0.2, 11)
    run = machine("swing").simulate(0.2, t, rtol=1e-12, start=BOTH, progress=False)
    file = tmp_path / "reference.csv"
    np.savetxt(file, np.column_stack([t, run.q("bob.phi")]), delimiter=",", comments="",
               header="t,bob.phi", fmt="%.17g")  # fmt: skip
    study = accuracy(path, "swing", start=BOTH, reference=file, folder=folder, **SHORT)
    worst = [point.errors.worst for point in study.lines[0].done if point.errors]
    assert 0.0 < worst[-1] < 1e-5
    with pytest.raises(AssemblyError, match=FIXED + ".*" + ADVICE):
        accuracy(path, "swing", guess=BOTH, folder=folder, **SHORT)


# -- the command line ---------------------------------------------------------------------------

COMMANDS: Mapping[str, tuple[str, ...]] = {
    "simulate": ("--scene", "swing", "--t-end", "0.1"),
    "report": ("--scene", "swing", "--t-end", "0.1", "--out", "page.html"),
    "kinematics": ("--scene", "turned", "--t-end", "0.1"),
    "inverse": ("--scene", "turned", "--t-end", "0.1"),
    "matters": ("--quantity", "max:bob.phi", "--scene", "swing", "--t-end", "0.1"),
    "accuracy": ("--scene", "swing", "--t-end", "0.1"),
}


def command(folder: Path, monkeypatch: pytest.MonkeyPatch, *words: str) -> dict[str, Any]:
    monkeypatch.chdir(folder)
    done = CliRunner().invoke(app, [words[0], "start_and_guess", *words[1:], "--json"])
    answer: dict[str, Any] = json.loads(done.stdout)
    return {"status": done.exit_code, **answer}


def test_all_commands_but_one_set_start_values() -> None:
    words = {
        name: {p.name for p in one.params}
        for name, one in vars(get_command(app))["commands"].items()
    }
    able = {name for name in words if "start" in words[name]}
    assert able == {name for name in words if "guess" in words[name]} - {"equilibrium"}
    assert len(able) == 8


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_refuses_a_guess_of_what_is_fixed(
    folder: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    words = (name, *COMMANDS[name], "--guess", "bob.phi=0.5")
    answer = command(folder, monkeypatch, *words)
    assert answer["status"] == 2
    (problem,) = answer["problems"]
    assert "guess names what the scene fixes: bob.phi = 0.3 rad" in problem
    assert "(--start)" in problem


@pytest.mark.parametrize("name", ["kinematics", "inverse"])
def test_commands_of_driven_motions_set_start_values(
    folder: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    words = (name, *COMMANDS[name], "--set", "phase=0.5", "--start", "bob.phi=0.5")
    answer = command(folder, monkeypatch, *words)
    assert answer["status"] == 0
    assert "start sets bob.phi = 0.5 rad." in answer["message"]
    wrong = command(folder, monkeypatch, *words, "--guess", "bob.x=a", "--start", "bob.y=b")
    assert len(wrong["problems"]) == 2


def test_a_report_of_a_driven_motion_sets_start_values(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("report", "--scene", "turned", "--t-end", "0.1", "--out", "page.html")
    set_ = ("--set", "phase=0.5", "--start", "bob.phi=0.5")
    answer = command(folder, monkeypatch, *words, *set_)
    assert answer["status"] == 0, answer
    assert "start sets bob.phi = 0.5 rad." in answer["message"]
    assert command(folder, monkeypatch, *words, "--start", "bob.phi=0.9")["status"] == 2


def test_a_ranking_by_command_starts_where_it_is_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("matters", *COMMANDS["matters"], "--rounds", "1", "--start", "bob.phi=0.5")
    assert command(folder, monkeypatch, *words)["value"] == pytest.approx(0.5, abs=1e-9)


def test_values_are_named_by_what_the_model_declared(tmp_path: Path) -> None:
    """As scenes take them: coordinates, velocities, states and parameters."""
    model = Model("named_by_symbols", gravity=(0, -9.81))
    length = model.parameter("arm_length", 1.0, "m", sign="positive")
    bob = model.body("bob", mass=2.0, inertia=0.1)
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-length, 0))
    lag = model.state("lag", lambda y: bob.omega - y)
    model.torque("brake", on=bob, value=-lag)
    model.scene("swing", ["gravity", "brake"], start={bob.phi: 0.0, bob.omega: 0.0})
    machine = load(model, folder=tmp_path)
    r = machine.simulate(
        0.1, 3, start={bob.phi: 0.25, bob.omega: 1.5, lag: 0.5}, parameters={length: 2.0}
    )
    assert (r.q("bob.phi")[0], r.v("bob.omega")[0], r.y("lag")[0]) == (0.25, 1.5, 0.5)
    assert r.parameters["arm_length"] == 2.0
    with pytest.raises(InputError, match=r"its name 2\.0 is no text"):
        machine.simulate(0.1, start={2.0: 1.0})


def test_a_start_that_is_none_says_what_to_give(driven: Machine) -> None:
    with pytest.raises(InputError, match=r'a saved one as load_result\("run\.nc"\) gives it'):
        driven.simulate(1.0, start="run.nc")  # type: ignore[arg-type]
    late = driven.simulate(0.5).state()
    with pytest.raises(InputError, match=r"must not end .*t_start or the state of start= says"):
        driven.simulate(0.1, start=late)
