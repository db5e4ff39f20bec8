"""Commands that simulate take one set of options, and find what `build --out` wrote."""

import json
from collections.abc import Callable
from inspect import signature
from pathlib import Path

import pytest
from typer.main import get_command
from typer.testing import CliRunner, Result

from codegen.errors import AnalysisError, InputError
from linkwright.cli.application import app
from linkwright.cli.options import Request
from runtime import accuracy, load, matters
from runtime.machine_facade import Machine

IN_ANOTHER_FORM = {"t_end", "t_eval", "parameters", "max_bytes", "progress", "self"}
IN_ANOTHER_FORM |= {"controllers", "quantities"}  # functions; --quantity
"""Words of `Machine.simulate` that no option gives, or one of another name."""
Run = Callable[..., Result]


def names(command: str) -> set[str]:
    found = vars(get_command(app))["commands"][command]
    return {name.lstrip("-").replace("-", "_") for one in found.params for name in one.opts}


def test_simulate_and_report_take_what_simulate_takes() -> None:
    words = set(signature(Machine.simulate).parameters) - IN_ANOTHER_FORM
    assert words <= names("simulate")
    assert names("simulate") - names("report") == {"stream"}


def test_studies_take_what_they_do_not_set_themselves() -> None:
    words = set(signature(Machine.simulate).parameters) - IN_ANOTHER_FORM
    words = words - {"accuracy"}
    assert words <= names("matters")
    assert words - {"rtol", "correction"} <= names("accuracy")
    assert not {"accuracy"} & (names("matters") | names("accuracy"))
    of_python = set(signature(Machine.simulate).parameters) - {
        "self", "t_eval", "accuracy", "quantities", "out"
    }  # fmt: skip
    assert of_python <= set(signature(matters).parameters)
    assert of_python - {"method", "formulation", "rtol", "correction"} <= set(
        signature(accuracy).parameters
    )


def test_options_reach_the_runs_of_studies(rod: Path) -> None:
    words = ["matters", str(rod), "--quantity", "bob.phi", "--t-end", "3", "--rounds", "1",
             "--points", "11", "--until", "low: bob.phi < -0.5", "--json"]  # fmt: skip
    done = CliRunner().invoke(app, words)
    assert json.loads(done.stdout)["value"] == pytest.approx(-0.5, abs=1e-9), done.stderr
    done = CliRunner().invoke(app, [*words, "--max-steps", "3"])
    assert done.exit_code == 1
    assert "The permitted number of steps was used up. Raise max_steps" in done.stderr
    done = CliRunner().invoke(app, [*words, "--atol", "-1"])
    assert done.exit_code == 2
    assert "atol is -1" in done.stderr
    words = ["accuracy", str(rod), "--t-end", "3", "--quick", "--method", "dop853",
             "--formulation", "cartesian", "--points", "11", "--until", "low: bob.phi < -0.5",
             "--max-step", "0.05", "--json"]  # fmt: skip
    study = json.loads(CliRunner().invoke(app, words).stdout)
    assert study["ok"]
    assert study["t_end"] < 3


def test_all_analyses_take_values_and_the_folder_of_modules() -> None:
    analyses = {"equilibrium", "kinematics", "inverse", "inverse-dynamics", "simulate", "report"}
    for command in (*analyses, "accuracy", "matters", "sweep"):
        assert {"model", "scene", "set", "guess", "generated", "json"} <= names(command)


def test_options_reach_the_run(run: Run, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    options = ("--method", "dopri5", "--rtol", "1e-5", "--atol", "1e-5", "--max-step", "0.01",
               "--first-step", "0.001", "--max-steps", "7", "--t-start", "1", "--t-end", "2",
               "--correction", "projection")  # fmt: skip
    for words in (("simulate",), ("report", "--out", page)):
        done = run(words[0], "rod_pendulum", *words[1:], *options, "--json")
        answer = json.loads(done.stdout)
        assert answer["outcome"] == "MAX_STEPS", done.stderr
        assert answer["stats"]["steps"] == 7
        assert 1.0 <= answer["t"][1] <= 1.07
    assert page.is_file()


def test_a_condition_ends_a_run(run: Run, tmp_path: Path) -> None:
    words = ("rod_pendulum", "--t-end", "3", "--json")
    until = ("--until", "low: bar.phi < -0.5", "--until", "never:total>1e6")
    page = tmp_path / "page.html"
    for command in (("simulate",), ("report", "--out", page)):
        done = run(command[0], *words, *command[1:], *until, "--rtol", "1e-10")
        answer = json.loads(done.stdout)
        assert answer["q"]["bar.phi"] == pytest.approx(-0.5, abs=1e-9), done.stderr
        assert answer["t"][1] < 3
        assert "where 'low' began to hold" in answer["message"]
    done = run("simulate", *words, "--accuracy", "1e-6", *until)
    assert json.loads(done.stdout)["q"]["bar.phi"] == pytest.approx(-0.5, abs=1e-6), done.stderr


@pytest.mark.parametrize(
    ("until", "message"),
    [
        (["low"], '--until "low": write "NAME: SERIES > VALUE"'),
        (["low: bar.phi = 3"], '--until "low: bar.phi = 3": write'),
        (["low: bar.phi == 3"], '--until "low: bar.phi == 3": write'),
        (["low: bar.phi > high"], "bar.phi > high"),
        ([": bar.phi > 3"], "a name, a series of the result and a number"),
        (["low: > 3", "a: b"], '--until "a: b": write'),
        (["low: bar.phi > 3", "low: bar.phi < -3"], "--until low is given twice; give one value"),
        (["low: bar.fi < 3"], "'bar.fi'"),
    ],
)
def test_what_is_no_condition(run: Run, until: list[str], message: str) -> None:
    options = [word for text in until for word in ("--until", text)]
    done = run("simulate", "rod_pendulum", "--t-end", "1", *options)
    assert done.exit_code == 2
    assert message in done.stderr


def test_a_start_value_holds(run: Run) -> None:
    words = ("simulate", "rod_pendulum", "--t-end", "0", "--start", "bar.phi=0.25")
    answer = json.loads(run(*words, "--json").stdout)
    assert answer["q"]["bar.phi"] == pytest.approx(0.25)
    assert "start sets bar.phi = 0.25 rad." in answer["message"]
    done = run(*words[:-1], "bar.phi")
    assert done.exit_code == 2
    assert "--start bar.phi: write NAME=VALUE with a number" in done.stderr


def test_a_report_to_an_accuracy(run: Run, tmp_path: Path) -> None:
    words = ("report", "rod_pendulum", "--t-end", "1", "--accuracy", "1e-5", "--quantity",
             "bar.phi", "--out", tmp_path / "page.html", "--json")  # fmt: skip
    assert json.loads(run(*words).stdout)["accuracy"]["asked"] == 1e-5


def test_a_driven_report_refuses_what_it_would_ignore(run: Run, tmp_path: Path) -> None:
    words = ("report", "sc_driven", "--t-end", "1", "--out", tmp_path / "page.html")
    for given, named in (("--rtol 1e-5 --method bdf", "--method, --rtol"),
                         ("--until a:crank.phi>1", "--until")):  # fmt: skip
        done = run(*words, *given.split())
        assert done.exit_code == 2
        assert f"{named} would be ignored" in done.stderr
    assert run(*words, "--start", "crank.phi=1").exit_code == 2
    assert run(*words).exit_code == 0


MODEL = """
from codegen import Model

model = Model("rod", gravity=(0, -9.81))
bob = model.body("bob", mass=2.0, inertia=0.1)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1.0, 0))
model.torque("damper", on=bob, value=-0.3 * bob.omega)
model.scene("swing", effects=["gravity", "damper"], start={bob.phi: 0.1, bob.omega: 0.0})
"""


@pytest.fixture
def rod(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A model file of the user's, in the working folder."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "rod.py"
    path.write_text(MODEL)
    return path


def test_what_build_wrote_elsewhere_is_found_again(rod: Path) -> None:
    place = rod.parent / "kernels"
    built = CliRunner().invoke(app, ["build", str(rod), "--out", str(place)])
    assert built.exit_code == 0, built.output
    before = {path: path.stat().st_mtime_ns for path in place.glob("*.py")}
    assert len(before) == 1
    words = ["simulate", str(rod), "--t-end", "0.1", "--generated"]
    for folder in (str(place), "kernels"):
        assert CliRunner().invoke(app, [*words, folder]).exit_code == 0
    assert load(rod, generated=place).path.parent == place
    assert before == {path: path.stat().st_mtime_ns for path in place.glob("*.py")}
    assert not (rod.parent / "generated").exists()


def test_a_ranking_takes_formulation_folder_and_the_long_name(rod: Path) -> None:
    words = {"asked": "max:bob.phi", "t_end": 0.05, "points": 11, "rounds": 1, "generated": "own"}
    reduced = matters(rod, formulation="reduced", **words)  # type: ignore[arg-type]
    usual = matters(rod, **words)  # type: ignore[arg-type]
    assert reduced.value == pytest.approx(usual.value, rel=1e-8)
    assert (rod.parent / "own" / "rod__swing__reduced.py").is_file()
    assert not (rod.parent / "generated").exists()
    with pytest.raises(AnalysisError, match="inverse dynamics"):
        matters(rod, analysis="inverse-dynamics", **words)  # type: ignore[arg-type]


def test_a_value_given_twice_is_refused() -> None:
    with pytest.raises(InputError) as caught:
        Request("x", settings=["m=2", "m=3"], start=["a=1", "a = 2"]).words()
    assert caught.value.problems == (
        "--set m is given twice; give one value.",
        "--start a is given twice; give one value.",
    )
