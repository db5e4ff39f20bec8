"""Effect ranking: changes, costs, verdicts, proposals, refusals."""

import dataclasses
import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from rich.console import Console
from typer.testing import CliRunner

from codegen import Model
from codegen.errors import InputError, LinkwrightError
from codegen.presentation import save_picture, terminal_width
from codegen.reading.scene_selection import declared, variants
from linkwright.cli.application import app
from runtime import Result, load, matters
from runtime.studies.effect_ranking import Plan
from runtime.studies.quantity import parse_quantity
from runtime.studies.ranking import Matters, Verdict

MACHINES = {
    "compressor": ("slider_crank", "compressor", "max:crank.omega", 0.5),
    "quick return": ("quick_return", "shaper", "rate:crank.phi", 1.0),
    "valve train": ("valve_lifter", "free_follower", "max:valve.y", 0.02),
}
Rank = Callable[..., Matters]


def sledge() -> Model:
    """A mass on a spring that is pushed, damped, blown at ever so slightly, and rubs."""
    model = Model("sledge", gravity=(0, -9.81))
    c = model.parameter("c", 0.2, unit="N s/m")
    body = model.body("body", mass=2.0, inertia=0.1)
    guide = model.translational("guide", model.ground, body, axis=(1, 0))
    model.spring("spring", model.ground.at(-1, 0), body, 50.0, free_length=1.0)
    model.force("damper", on=body, fx=-c * body.vx)
    model.force("breeze", on=body, fx=1e-14)
    model.force("kick", on=body, fx=30.0, when=body.x < 0)
    model.friction("rub", guide, 0.05, creep=1e-3, fidelity="regularised")
    start = {body.x: 0.5, body.vx: 0.0}
    model.scene("swing", ["spring", "damper", "breeze"], start=start | {body.vx: 0.3})
    model.scene("kicked", ["spring", "kick"], start=start)
    model.scene("alone", ["spring"], start=start)
    model.scene("empty", start=start)
    return model


@pytest.fixture(scope="module")
def folder(request: pytest.FixtureRequest) -> Path:
    """A folder whose compiled scenes outlive a run."""
    made: Path = request.config.cache.mkdir("matters")
    return made


@pytest.fixture(scope="module")
def rank(folder: Path) -> Rank:
    """Rank the effects of a scene of the sledge, or of another model."""

    def rank(scene: object, asked: object, model: object = None, **words: object) -> Matters:
        about = {"asked": asked, "rounds": 1, "folder": folder, **words}
        return matters(model or sledge(), scene, **about)

    return rank


@pytest.fixture(scope="module")
def swing(rank: Rank) -> Matters:
    return rank("swing", "range:body.x", t_end=3.0, error=1e-3)


def test_work_counts_the_iterations_of_a_return_and_not_the_return() -> None:
    machine = load("slider_crank", "compressor")
    plan = Plan(parse_quantity("crank.phi"), "simulate", 0.0, 0.1, 501, 1e-3, {})
    trial = plan.trial(machine)
    run, operations = trial.result, dict(machine.description.operations)
    assert run.stats["corrections"] > run.stats["returns"]
    assert trial.costs.work == (
        run.stats["rhs_evaluations"] * operations["accelerations"]
        + run.stats["corrections"] * operations["correction"]
    )


@pytest.mark.parametrize("machine", MACHINES)
def test_without_negligible_effects_the_quantity_stays(
    machine: str, folder: Path, rank: Rank
) -> None:
    model, scene, asked, t_end = MACHINES[machine]
    found = rank(scene, asked, model, t_end=t_end, error=1e-3, fidelities=False)
    judged = [row for row in found.rows if row.relative is not None]
    assert {row.name for row in found.rows} == set(load(model, scene).effects.names)
    shown = [row.relative for row in judged if row.verdict is not Verdict.NONE_SEEN]
    assert all(more >= less for more, less in pairwise(shown))
    assert found.doubt < 1e-6 * found.size
    small = [row for row in judged if row.verdict is Verdict.NEGLIGIBLE]
    assert small
    assert any(row.verdict is Verdict.MATTERS for row in judged)
    assert set(found.proposal.left_out) == {row.name for row in small}

    # once more by hand: the proposed scene and the full one, other method, tolerance and samples
    read, full = declared(model, scene)
    cheaper = full.without(*found.proposal.left_out)
    assert cheaper.name == found.proposal.scene
    measured = [
        parse_quantity(asked)
        .read(m.simulate(t_end, np.linspace(0.0, t_end, 4001), rtol=1e-9, method="dopri5"))
        .value
        for m in (load(model, scene), load(read, cheaper, folder=folder / ".linkwright_cache"))
    ]
    assert abs(measured[1] / measured[0] - 1.0) <= 1e-3
    assert_allclose(measured, [found.value, found.proposal.value], rtol=1e-6)
    for row in small:
        assert row.costs.accelerations < found.costs.accelerations
        assert row.costs.operations < found.costs.operations


def test_a_change_below_its_uncertainty_is_none_seen(swing: Matters) -> None:
    breeze = swing["breeze"]
    assert breeze.verdict is Verdict.NONE_SEEN
    assert abs(breeze.change) <= breeze.doubt
    assert breeze is swing.rows[-1]
    assert swing.rows[0].verdict is Verdict.MATTERS
    assert 0.0 < swing.doubt < 1e-7 * swing.size


def test_effects_that_are_not_negligible_together_are_put_back(rank: Rank) -> None:
    model = Model("twins")
    ball = model.particle("ball", mass=1.0)
    model.force("wind", on=ball, fx=100.0)
    for name, push in (("one", 0.06), ("two", 0.07)):
        model.force(name, on=ball, fx=push)
    model.scene("fly", ["wind", "one", "two"], start={ball.x: 0.0, ball.vx: 0.0})
    found = rank("fly", "ball.x", model, t_end=1.0, error=1e-3)
    assert_allclose(found.value, 50.065, rtol=1e-12)
    for name, push in (("one", 0.06), ("two", 0.07)):
        assert found[name].verdict is Verdict.NEGLIGIBLE
        assert_allclose(found[name].relative, push / 100.13, rtol=1e-6)
    assert found.proposal.left_out == ("one",)
    assert found.proposal.put_back == ("two",)
    (together, too_much), (kept, within) = found.proposal.tried
    assert together == ("one", "two")
    assert_allclose((too_much, within), (0.13 / 100.13, 0.06 / 100.13), rtol=1e-6)
    assert kept == found.proposal.left_out
    assert found.proposal.relative == within
    answer = " ".join(found.sentences())
    assert "two is negligible alone but not together with the others, so it is put back" in answer


def test_a_quantity_that_goes_with_the_effect_makes_it_needed(rank: Rank) -> None:
    found = rank("kicked", "event:kick", t_end=2.0, error=0.5)
    assert found["kick"].verdict is found["spring"].verdict is Verdict.NEEDED
    gone = "kicked_without_kick: There is no effect with events 'kick'"
    assert gone in found["kick"].reason
    assert "kick has 0 events up to t = 2 s" in found["spring"].reason
    assert found.proposal.left_out == ()


def test_other_fidelities_are_tried_as_well(rank: Rank) -> None:
    model = sledge()
    scene = model.scene("alone").with_("rub", "gravity")
    names = [change.title for change in variants(model, scene)]
    assert names == ["gravity", "spring", "rub", "rub as sticking"]
    found = rank(scene, "body.x", model, t_end=0.2)
    assert found["rub as sticking"].word == "sticking"
    assert found["rub as sticking"].scene.endswith("rub_sticking")
    assert found["rub"].verdict is Verdict.MATTERS
    assert_allclose(found["gravity"].change, found["rub"].change, rtol=1e-6)  # it is what presses
    assert found["rub as sticking"].relative < 0.1 * found["rub"].relative


@pytest.mark.parametrize(
    ("model", "scene", "titles"),
    [
        ("slider_crank", "compressor", ["gas", "motor", "gravity_right", "rod as link"]),
        ("slider_crank", "kinematics", ["rod as link"]),
        ("valve_lifter", "free_follower", ["touch", "valve_spring", "follower as fixed"]),
    ],
)
def test_rod_may_be_a_link_in_dynamics_and_kinematics(
    model: str, scene: str, titles: list[str]
) -> None:
    assert [change.title for change in variants(*declared(model, scene))] == titles


def test_inverse_dynamics_and_equilibrium_are_ranked(rank: Rank) -> None:
    model = Model("pendulum", gravity=(0, -9.81))
    bob = model.body("bob", mass=2.0, inertia=0.1)
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.torsion_spring("coil", model.ground, bob, 5.0)
    model.driver("turn", bob.phi, 0.5)
    model.scene("hold", ["gravity", "coil"], ["turn"], guess={bob.x: 0.9})
    model.scene("hang", ["gravity", "coil"], guess={bob.x: 0.5, bob.y: -0.9, bob.phi: -1.0})
    held = rank("hold", "turn.torque", model, t_end=1.0, points=11)
    assert held.analysis == "inverse_dynamics"
    weight = 2.0 * 9.81 * np.cos(0.5)
    assert_allclose(abs(held.value), weight + 2.5, rtol=1e-12)
    assert_allclose(held["gravity"].relative, weight / (weight + 2.5), rtol=1e-9)
    assert_allclose(held["coil"].relative, 2.5 / (weight + 2.5), rtol=1e-9)
    rest = rank("hang", "bob.phi", model, analysis="equilibrium")
    assert_allclose(rest["gravity"].change, -rest.value, rtol=1e-8)
    assert_allclose(rest["coil"].change, -np.pi / 2 - rest.value, rtol=1e-8)
    with pytest.raises(InputError, match="start has values, but an equilibrium is searched for"):
        rank("hang", "bob.phi", model, analysis="equilibrium", start={"bob.phi": 1.0})


def test_a_function_is_a_quantity_and_what_stops_the_machine_is_needed(rank: Rank) -> None:
    def travel(result: Result) -> float:
        return float(np.abs(np.diff(result.q("body.x"))).sum())

    found = rank("alone", travel, t_end=1.0)
    assert found.quantity == "travel"
    assert found["spring"].verdict is Verdict.NEEDED
    assert found["spring"].reason == "nothing moves without it"
    assert found["spring"].costs is None
    alone = "spring is the scene's only effect, so there is none to rank it with."
    assert alone in found.notes
    with pytest.raises(InputError, match="<lambda> returns nan; it must return a finite number"):
        rank("alone", lambda result: float("nan"), t_end=1.0)


def test_a_state_that_leaves_with_its_only_user_is_named(rank: Rank) -> None:
    model = Model("driven_sledge")
    body = model.particle("body", mass=2.0)
    model.absolute("rail", body, "y", 0.0)
    current = model.state("i", lambda i: 12.0 - 2.0 * i - body.vx, unit="A")
    model.force("motor", body, fx=current)
    model.force("drag", body, fx=-0.1 * body.vx)
    model.scene("run", ["motor", "drag"], start={body.x: 0.0, body.vx: 0.0})
    assert rank("run", "max:i", model, t_end=0.5)["motor"].reason == (
        "the state 'i' leaves the scene with it, because nothing else contains it; so max:i has no "
        "value there"
    )


@pytest.mark.parametrize(
    ("scene", "words", "message"),
    [
        ("kicked", {"asked": "body.xx"}, "There is no series 'body.xx'; nearest: body.x"),
        ("kicked", {"asked": "nothing"}, "there are: coordinate body.x, body.y, body.phi; veloc"),
        ("kicked", {"asked": "mx:body.x"}, "There is no reduction 'mx'; nearest: max"),
        ("kicked", {"asked": "max:guide.torqe"}, "nearest: guide.torque"),
        ("kicked", {"asked": "event:kik"}, "There is no effect with events 'kik'; nearest: kick"),
        ("kicked", {"asked": "event:kick#0"}, "after # stands the number of the event"),
        ("kicked", {"asked": "event:kick#900"}, "so there is no number 900"),
        ("kicked", {"asked": "period:body.y"}, "crosses its mean upwards 0 times"),
        ("kicked", {"asked": ""}, "The quantity is ''; give a series such as crank.phi"),
        ("empty", {}, "no effect acts, and nothing in it has another fidelity"),
        ("alone", {"t_end": None}, "t_end is missing"),
        ("alone", {"t_end": -1.0}, "from 0 to -1 s must be finite and positive"),
        ("alone", {"error": 2.0}, "error is 2.0; it must be a share"),
        ("alone", {"rtol": 1e-15}, "rtol is 1e-15"),
        ("alone", {"points": 10, "rounds": 0}, "rounds is 0; it must be a whole number from 1"),
        ("alone", {"analysis": "dance"}, "analysis is 'dance'; it must be the name of an analysis"),
        ("alone", {"parameters": {"zz": 1.0}}, "There is no parameter 'zz'"),
        ("alone", {"guess": {"body.zz": 1.0}}, "body.zz"),
        ("swong", {}, "no scene 'swong'; did you mean 'swing'"),
    ],
)
def test_wrong_input_is_refused(
    scene: str, words: dict[str, object], message: str, rank: Rank
) -> None:
    with pytest.raises(InputError) as caught:
        rank(scene, **{"asked": "body.x", "t_end": 1.0, **words})
    assert message in str(caught.value)


def test_an_effect_without_which_the_run_fails_is_needed(rank: Rank) -> None:
    model = Model("tamed")
    ball = model.particle("ball", mass=1.0)
    model.force("blow", on=ball, fx=ball.x**2)
    model.force("tame", on=ball, fx=-(ball.x**2) - ball.x)
    start = {ball.x: 1.0, ball.vx: 1.0}
    model.scene("run", ["blow", "tame"], start=start)
    model.scene("grow", ["blow"], start=start)
    found = rank("run", "ball.x", model, t_end=9.0)
    assert_allclose(found.value, np.cos(9.0) + np.sin(9.0), rtol=1e-7)
    assert found["tame"].verdict is Verdict.NEEDED
    assert "tamed/run_without_tame: Stopped at t = " in found["tame"].reason
    with pytest.raises(LinkwrightError, match=r"tamed/grow: Stopped at t = "):
        rank("grow", "ball.x", model, t_end=100.0)


@pytest.mark.parametrize("columns", [80, 110, 140])
def test_table_fits_a_terminal(
    columns: int, swing: Matters, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    screen = Console(width=terminal_width(), highlight=False, record=True)
    with screen.capture() as capture:
        screen.print(*swing.tables())
    lines = capture.get().splitlines()
    assert max(map(len, lines)) <= columns
    for row in swing.rows:
        (line,) = (text for text in lines if text.strip("│ ").startswith(row.title))
        assert line.rstrip().endswith("│")
        assert str(row.verdict) in line


def test_picture_and_answer_are_whole(swing: Matters, tmp_path: Path) -> None:
    left, right = swing.plot().axes
    assert len(left.patches) == len(right.patches) == len(swing.rows)
    assert left.get_xscale() == "log"
    save_picture(swing.plot(), tmp_path / "swing.png")
    assert (tmp_path / "swing.png").stat().st_size > 10_000
    with pytest.raises(dataclasses.FrozenInstanceError):
        swing.value = 0.0
    facts = json.loads(json.dumps(swing.facts(), allow_nan=False))
    assert [row["name"] for row in facts["rows"]] == [row.name for row in swing.rows]
    with pytest.raises(KeyError, match="there are: "):
        swing["gale"]


def test_command_line(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    command = ("matters", "slider_crank", "--scene", "compressor", "--no-fidelities",
               "--rounds", "1", "--t-end", "0.5", "--quantity")  # fmt: skip
    done = CliRunner().invoke(app, [*command, "max:crank.omega", "--error", "1e-3", "--json"])
    assert done.exit_code == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["ok"] is True
    assert answer["proposal"]["left_out"] == ["gravity_right"]
    assert answer["proposal"]["relative"] <= 1e-3
    done = CliRunner().invoke(app, [*command, "event:gas"])
    assert done.exit_code == 0
    assert "gravity_right changes event:gas by 0.2 %" in done.stdout
    assert "slider_crank/compressor_without_gas" in done.stderr
    for wrong, message in (("crank.fi", "nearest: crank.phi"), ("mox:crank.phi", "nearest: max")):
        done = CliRunner().invoke(app, [*command, wrong, "--json"])
        assert done.exit_code == 2
        assert message in done.stderr
        assert json.loads(done.stdout)["status"] == 2
    done = CliRunner().invoke(app, [*command, "event:gas", "--out", str(tmp_path / "x.doc")])
    assert done.exit_code == 2
    assert "a picture ends in .png" in done.stderr


def test_a_failing_report_does_not_end_the_study(rank: Rank) -> None:
    lines: list[str] = []

    def progress(line: str) -> None:
        lines.append(line)
        raise OSError("the terminal is gone")

    with pytest.warns(UserWarning, match="OSError: the terminal is gone. The study goes on") as w:
        reported = rank("swing", "max:body.x", t_end=0.5, progress=progress)
    assert len(lines) == len(w) == 1
    assert len(reported.rows) == 3
