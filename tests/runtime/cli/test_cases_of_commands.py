"""A case file in place of MODEL on the command line."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from linkwright.cli.application import app

_MODEL = """
from linkwright import Model, t
model = Model("commanded", gravity=(0, -9.81))
damping = model.parameter("damping", 0.3, unit="N m s")
speed = model.parameter("speed", 2.0, unit="rad/s")
bob = model.body("bob", mass=2.0, inertia=0.5)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.torque("damper", on=bob, value=-damping * bob.omega)
model.driver("turn", bob.phi, speed * t)
model.scene("swing", ["gravity", "damper"], start={bob.phi: 0.0, bob.omega: 0.0})
winch = model.torque("winch", on=bob, value=0)
jack = model.force("jack", on=bob, fy=1)
model.scene("driven", ["gravity", winch, jack], drivers=["turn"])
"""
_CASES = {
    "swing.yaml": "scene: swing\nparameters: {damping: 0.5}\nstart: {bob.phi: 30 deg}\n"
    "run: {t_end: 500 ms, t_eval: 6, rtol: 1e-6, method: tsit5}\n",
    "until.yaml": 'run: {t_end: 3, t_eval: [0, 1], until: {low: "bob.phi < -45 deg"}}\n',
    "scene.yaml": "scene: {name: bare, extends: swing, without: [damper]}\nrun: {t_end: 0.3}\n",
    "turn.yaml": "scene: driven\nanalysis: inverse_dynamics\nparameters: {speed: 60 rpm}\n"
    "run: {t_end: 1, t_eval: 3}\n",
    "lift.yaml": "scene: driven\nanalysis: inverse_dynamics\nrun: {t_end: 1, t_eval: 3, "
    "unknown: [winch, jack], weights: {jack: 2.0}}\n",
    "late.yaml": "scene: swing\nanalysis: equilibrium\nguess: {bob.phi: -80 deg}\n"
    "run: {t: 20 ms}\n",
    "settled.yaml": "scene: swing\nanalysis: equilibrium\nrun: {method: settling}\n",
    "rest.yaml": "scene: swing\nanalysis: equilibrium\nguess: {bob.phi: -80 deg}\n",
}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("commands")
    (folder / "commanded.py").write_text(_MODEL)
    for name, text in _CASES.items():
        (folder / name).write_text(f"model: commanded.py\n{text}")
    return folder


@pytest.fixture
def run(place: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    monkeypatch.chdir(place)

    def call(*words: str | Path) -> Result:
        return CliRunner().invoke(app, [str(word) for word in words])

    return call


def facts(done: Result) -> dict[str, Any]:
    assert done.exit_code == 0, done.stderr
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def test_a_case_says_what_no_option_says(run: Callable[..., Result]) -> None:
    of_case = facts(run("simulate", "swing.yaml", "--json"))
    of_options = facts(
        run(
            "simulate", "commanded.py", "--scene", "swing", "--set", "damping=0.5", "--start",
            "bob.phi=0.5235987755982988", "--t-end", "0.5", "--points", "6", "--rtol", "1e-6",
            "--method", "tsit5", "--json",
        )
    )  # fmt: skip
    for answer in (of_case, of_options):
        for clock in ("integration_seconds", "wall_seconds"):
            del answer["stats"][clock]
    assert of_case == of_options
    assert of_case["instants"] == 6


def test_options_stand_over_a_case(run: Callable[..., Result]) -> None:
    changed = facts(
        run("simulate", "swing.yaml", "--set", "damping=0.7", "--t-end", "0.2", "--points", "4",
            "--start", "bob.omega=1", "--json")
    )  # fmt: skip
    assert changed["parameters"]["damping"] == 0.7
    assert changed["t"] == [0.0, 0.2]
    assert changed["instants"] == 4
    assert "start sets bob.phi = 0.523599 rad, bob.omega = 1 rad/s" in changed["message"]


def test_conditions_and_listed_instants_of_a_case(run: Callable[..., Result]) -> None:
    ended = facts(run("simulate", "until.yaml", "--json"))
    assert ended["ended_by"] == "low"
    assert ended["instants"] == 2  # 0 s, and where it ends
    later = facts(
        run("simulate", "until.yaml", "--points", "5", "--until", "a: bob.x < 0.9", "--json")
    )
    assert later["ended_by"] == "a"


def test_a_scene_of_a_case(run: Callable[..., Result]) -> None:
    assert facts(run("simulate", "scene.yaml", "--json"))["scene"] == "bare"
    other = facts(run("simulate", "scene.yaml", "--scene", "swing", "--json"))
    assert other["scene"] == "swing"


def test_prescribed_motions_and_positions_of_rest(run: Callable[..., Result]) -> None:
    turned = facts(run("inverse", "turn.yaml", "--json"))
    assert turned["q"]["bob.phi"] == pytest.approx(6.283185307179586, rel=1e-12)
    assert facts(run("inverse-dynamics", "turn.yaml", "--json"))["instants"] == 3
    assert facts(run("equilibrium", "rest.yaml", "--json"))["q"]["bob.phi"] == pytest.approx(
        -1.5707963
    )


def test_unknowns_of_options_and_cases(run: Callable[..., Result]) -> None:
    words = ("inverse", "commanded.py", "--scene", "driven", "--t-end", "1", "--json")
    assert "Sought: winch, in place of turn" in facts(run(*words, "--unknown", "winch"))["message"]
    shown = run(*words[:-1], "--unknown", "winch").stdout.splitlines()
    assert shown[0] == f"winch.torque  {18.62 * math.cos(2.0):.9g} to 18.62 N m"
    assert shown[1].startswith("bob.x ")
    shown = run(*words[:-1]).stdout.splitlines()
    assert shown[0] == f"turn.torque  {18.62 * math.cos(2.0):.9g} to 18.62 N m"
    of_case = facts(run("inverse", "lift.yaml", "--json"))
    assert "with weights winch 1, jack 2." in of_case["message"]
    assert of_case["instants"] == 3
    assert run("report", "lift.yaml", "--out", "lift.html").exit_code == 0
    done = run("sweep", "lift.yaml", "--over", "speed=1,2", "--quantity", "bob.phi")
    assert "lift.yaml: sweep seeks no values; leave run.unknown out" in done.stderr


def test_reports_and_studies_take_cases(run: Callable[..., Result], place: Path) -> None:
    done = run("report", "turn.yaml", "--out", "turn.html")
    assert done.exit_code == 0, done.stderr
    assert "commanded" in (place / "turn.html").read_text()
    done = run("matters", "swing.yaml", "--quantity", "bob.phi", "--rounds", "1", "--json")
    assert {row["name"] for row in facts(done)["rows"]} == {"gravity", "damper"}
    done = run("sweep", "swing.yaml", "--over", "damping=0.1,0.2", "--quantity", "bob.phi",
               "--out", "study.zarr", "--workers", "0", "--json")  # fmt: skip
    assert facts(done)["outcomes"] == {"OK": 2}
    assert [*facts(done)["facts"]["factors"]] == ["damping"]
    assert facts(done)["facts"]["instants"] == 6
    done = run("sweep", "until.yaml", "--over", "damping=0.1,0.2", "--quantity", "bob.phi",
               "--out", "listed.zarr", "--workers", "0", "--json")  # fmt: skip
    assert done.exit_code == 2
    assert "run.t_eval lists output instants" in done.stderr
    done = run("sweep", "until.yaml", "--over", "damping=0.1,0.2", "--quantity", "bob.phi",
               "--out", "listed.zarr", "--workers", "0", "--json", "--points", "5")  # fmt: skip
    assert facts(done)["facts"]["instants"] == 5


def test_sweeps_of_equilibria_take_the_instant_of_a_case(run: Callable[..., Result]) -> None:
    words = ("--over", "damping=0.1,0.2", "--quantity", "bob.phi", "--workers", "0", "--json")
    done = run("sweep", "late.yaml", *words, "--out", "late.zarr")
    assert facts(done)["facts"]["t_start"] == 0.02
    done = run("sweep", "settled.yaml", *words, "--out", "settled.zarr")
    assert done.exit_code == 2
    assert "leave run.method out" in done.stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("equilibrium", "swing.yaml"), "asks for simulate, and the command is equilibrium"),
        (("simulate", "rest.yaml"), "Run: linkwright equilibrium rest.yaml"),
        (("simulate", "nowhere.yaml"), "nowhere.yaml cannot be read"),
        (("simulate", "broken.yaml"), "broken.yaml, line 2: There is no key 'rum'; nearest: run"),
        (("simulate", "unfit.yaml"), "unfit.yaml, line 2, parameters.dampin: There is no param"),
    ],
)
def test_wrong_cases_end_with_two(
    run: Callable[..., Result], place: Path, words: tuple[str, ...], message: str
) -> None:
    (place / "broken.yaml").write_text("model: x\nrum: {}\n")
    (place / "unfit.yaml").write_text(
        "model: commanded.py\nparameters: {dampin: 1}\nrun: {t_end: 1}\n"
    )
    done = run(*words)
    assert done.exit_code == 2
    assert message in done.stderr


def test_a_command_after_one_with_a_case_has_none(run: Callable[..., Result]) -> None:
    facts(run("simulate", "swing.yaml", "--json"))
    plain = facts(run("simulate", "commanded.py", "--t-end", "0.1", "--json"))
    assert plain["parameters"]["damping"] == 0.3
