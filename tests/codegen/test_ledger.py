"""The ledger of a scene: everything is in it, its parts add up, and prices are measured."""

import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.cells import cell_len
from typer.testing import CliRunner

from benchmarks.chain import chain
from codegen import Model
from codegen.derive.equations import derive
from codegen.errors import InputError
from codegen.explain import element_times as timing
from codegen.explain.element_times import about_the_start, measure
from codegen.explain.ledger import Ledger, Part, compare, explain, loops_sentence
from codegen.explain.operations_by_part import (
    cumulative_programs,
    marginal_operations,
    operations_by_part,
    operations_of,
    timing_stages,
)
from codegen.explain.picture import figure, page
from codegen.explain.terminal_table import comparison_table, notes
from codegen.lower.lowered_scene import lower
from codegen.lower.operation_count import operations
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes
from linkwright.cli.application import app
from tests.codegen.workbench import write_model


def sledge() -> Model:
    """A sledge on a rough guide before a wall, with a choice of springs."""
    model = Model("sledge", gravity=(0, -9.81))
    body = model.body("body", mass=2.0, inertia=0.1)
    load = model.body("load", mass=1.0, inertia=0.1)
    guide = model.translational("guide", model.ground, body, axis=(1, 0))
    pin = model.revolute("pin", body.at(0, 0), load.at(0, 0))
    model.spring("soft", model.ground.at(-1, 0), body, 50.0, free_length=1.0)
    model.spring("hard", model.ground.at(-1, 0), body, 500.0, free_length=1.0)
    model.alternatives("spring", {"weak": ["soft"], "strong": ["hard"]})
    model.friction("rub", guide, 0.2, creep=1e-3, static=0.3, fidelity="sticking")
    model.friction("wear", pin, 0.2, radius=0.1, creep=1e-3)
    model.torque("motor", on=load, value=1.0)
    model.driver("crane", load.phi, 0)
    model.track("nose", body.at(0.5, 0))
    model.scene("slide", ["soft", "rub"], start={body.x: 0.5, body.vx: 0.0})
    return model


def the(ledger: Ledger) -> dict[str, Part]:
    return {part.name: part for part in ledger.parts}


def test_everything_declared_is_in_or_out_for_a_reason() -> None:
    model = sledge()
    scene = model.scene("slide").without("load")
    (ledger,) = explain(model, scene)
    told = {name: (part.acts, part.why) for name, part in the(ledger).items()}
    unreachable = (False, "unreachable: body 'load' takes no part")
    assert {
        "guide": (True, "its bodies take part"),
        **dict.fromkeys(("pin", "wear", "motor", "crane"), unreachable),
        "soft": (True, "named by the scene"),
        "hard": (False, "'weak' of 'spring' is chosen"),
        "gravity": (False, "the scene does not name it"),
        "rub: sticking": (True, "as declared"),
        "rub: regularised": (False, "'sticking' is chosen"),
        "spring: weak": (True, "as declared"),
        "spring: strong": (False, "'weak' is chosen"),
    }.items() <= told.items()
    assert {*model.joints, *model.drivers, *model.effects} <= set(told)


def test_reasons_follow_the_scene() -> None:
    model = sledge()
    base = model.scene("slide")
    rough = base.with_(fidelity={"rub": "regularised", "spring": "strong"}).with_("crane")
    (ledger,) = explain(model, rough)
    told = {name: (part.acts, part.why) for name, part in the(ledger).items()}
    assert {
        "rub": (True, "named by the scene, as 'regularised'"),
        "rub: regularised": (True, "chosen by the scene"),
        "hard": (True, "'strong' of 'spring' is chosen"),
        "soft": (False, "'strong' of 'spring' is chosen"),
        "crane": (True, "named by the scene"),
    }.items() <= told.items()
    (ledger,) = explain(model, base.with_(fidelity={"rub": "none"}))
    assert the(ledger)["rub"].why == "the fidelity 'none' is chosen"
    assert the(ledger)["rub: sticking"].why == "'rub' does not act"
    (ledger,) = explain(model, base.without("soft", "rub").with_("gravity", analysis="kinematics"))
    assert the(ledger)["gravity"].why == "named, but a kinematic scene has no forces"
    assert not any(entry.asked for entry in ledger.outputs)
    (ledger,) = explain(model, base.with_(outputs=["energy", "reaction(guide)"]))
    asked = {entry.name: entry.asked for entry in ledger.outputs}
    assert {"reactions", "powers", "points", "works", "forces", "lengths"} <= {*asked}
    assert [name for name, computed in asked.items() if computed] == ["energy", "reaction(guide)"]
    (ledger,) = explain(model, base.with_(outputs=["point(nose)", "work(soft)"]))
    assert (the(ledger)["nose"].acts, the(ledger)["nose"].why) == (True, "needed by an output")
    assert the(ledger)["soft"].operations["powers"] > 0
    assert set(the(ledger)["nose"].operations) == {"reactions"}  # nothing of the motion


def test_couplers_and_what_stands_for_them(root: Path) -> None:
    (ledger,) = explain(root / "models" / "slider_crank.py", "compressor_massless_rod")
    parts = the(ledger)
    assert parts["link"].acts
    assert not parts["B"].acts
    assert "'rod'" in parts["B"].why
    (ledger,) = explain(root / "models" / "slider_crank.py", "compressor")
    assert parts["link"].why != the(ledger)["link"].why
    assert the(ledger)["link"].why == "stands for body 'rod', which takes part"


@pytest.mark.parametrize("machine", ["slider_crank", "valve_lifter", "hard/guide_friction"])
def test_parts_add_up_to_every_kernel(machine: str) -> None:
    for ledger in explain(machine):
        for kernel, total in ledger.totals.items():
            assert sum(part.operations.get(kernel, 0) for part in ledger.parts) == total
        last = [part for part in ledger.parts if part.role == "effect" and part.acts][-1:]
        for part in last:  # what joined last is all that would be gone without it
            own = {kernel: count for kernel, count in part.own.items() if count}
            assert part.operations == own


def test_outputs_add_up_with_the_elements_that_they_need() -> None:
    """Points, one of them with a joint's name, and expressions of the series of effects."""
    model = Model("swung", gravity=(0, -9.81))
    arm = model.body("arm", mass=1.0, inertia=0.1)
    model.revolute("pin", model.ground, arm.at(-0.5, 0))
    model.spring("hold", model.ground.at(1, 1), arm.at(0.5, 0), 30.0, free_length=1.0)
    for point in "pin", "tip":
        model.track(point, arm.at(0.5, 0))
    series = {n: model.series(n) for n in ("hold.force", "tip.ax", "pin.ay", "pin.global_fx")}
    outputs = {f"out_{k}": 2 * one for k, one in enumerate(series.values())}
    model.scene("run", ["gravity", "hold"], outputs=["default", outputs])
    (ledger,) = explain(model)
    assert ledger.totals["derived_outputs"] > 0
    for kernel, total in ledger.totals.items():
        assert sum(part.operations.get(kernel, 0) for part in ledger.parts) == total


def test_stages_end_in_the_scene_s_own_kernel(root: Path) -> None:
    model = read_model(root / "models" / "hard" / "guide_friction.py").model
    (scene,) = valid_scenes(model, "rocking")
    equations = derive(model, scene)
    programs = cumulative_programs(lower(equations))
    chain = timing_stages(programs)
    counts = operations_by_part(programs)
    sizes = [operations(s.program, s.program.kernels[-1]) for s in chain]
    assert sizes[-1] == operations_of(programs[-1])["accelerations"]
    steps = [after - before for before, after in zip([0, *sizes], sizes, strict=False)]
    for stage, step in zip(chain, steps, strict=True):
        own = counts[stage.part].get("accelerations", 0)
        if stage.part == "factorization":  # and the sums that no element is the first to need
            own += counts.get("", {}).get("accelerations", 0)
        assert step == own, stage.part
    assert chain[-1].program.kernels[-1].outputs == next(
        k.outputs for k in programs[-1].program.kernels if k.name == "accelerations"
    )
    assert counts["rub"]["accelerations"] > 100
    assert marginal_operations(programs[-1], "rub")["accelerations"] > 100


def test_measured_parts_telescope(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the times are, their increments add up to the last; and the kernels run."""
    model = read_model(root / "models" / "slider_crank.py").model
    (scene,) = valid_scenes(model, "inverse_dynamics")
    equations = derive(model, scene)
    programs = cumulative_programs(lower(equations))
    chain = timing_stages(programs)
    states = about_the_start(programs[-1])
    seen: list[timing.Timed] = []
    real = timing.times

    def counting(kernels: list[timing.Timed], states: timing.States, rounds: int) -> list[float]:
        seen.extend(kernels)
        found = real(kernels, states, rounds)
        assert len(found) == len(kernels)
        return [float(4**k) for k in range(len(kernels))]

    monkeypatch.setattr(timing, "times", counting)
    told = measure(equations, chain, states, rounds=1)
    assert list(told.parts) == [stage.part for stage in chain]
    assert sum(told.parts.values()) == 4 ** (len(chain) - 1)
    a, lam = np.zeros(len(equations.coordinates)), np.zeros(seen[-1].slots)
    t, q, v = states.t[0], states.q[0], states.v[0]
    assert seen[-1].kernel(t, q, v, seen[-1].p, states.modes[0], a, lam) == 0
    assert np.isfinite(a).all()


def test_states_are_put_together_and_have_their_modes(root: Path) -> None:
    model = read_model(root / "models" / "slider_crank.py").model
    (scene,) = valid_scenes(model, "compressor")
    equations = derive(model, scene)
    lowered = cumulative_programs(lower(equations))[-1]
    states = about_the_start(lowered)
    names = [c.name for c in equations.coordinates]
    at = dict(zip(names, states.q.mean(axis=0), strict=True))
    assert at["crank_phi"] == pytest.approx(np.pi, abs=1e-2)
    assert at["slider_x"] == pytest.approx(3.5 - 2.0, abs=1e-2)
    assert states.modes.shape == (len(states.t), len(equations.switches))
    assert set(np.unique(states.modes)) <= {0, 1}


def test_two_scenes_side_by_side(root: Path) -> None:
    path = root / "models" / "quick_return.py"
    (shaper,), (driven,) = explain(path, "shaper"), explain(path, "kinematics")
    *parts, total = compare(shaper, driven)
    rows = {row.name: row for row in parts}
    assert rows["motor"].acts == (True, False)
    assert rows["crank_drive"].acts == (False, True)
    assert rows["sums"].acts == (True, None)
    for side in (0, 1):
        assert sum(row.operations[side] for row in parts) == total.operations[side]
    names, *columns = comparison_table(shaper, driven, (*parts, total)).columns
    motor, spent = list(names.cells).index("motor"), rows["motor"].operations[0]
    told = [list(column.cells)[motor] for column in columns[-3:]]
    assert told == [str(spent), "0", f"-{spent}"]
    words = ["--compare", "shaper", "kinematics", "--no-measure", "--json"]
    told = json.loads(CliRunner().invoke(app, ["explain", str(path), *words]).stdout)
    assert [scene["scene"] for scene in told["scenes"]] == ["shaper", "kinematics"]
    assert told["differences"][-1]["operations"] == list(total.operations)


once = cache(explain)


def explained(path: Path, scene: str | None, **options: Any) -> tuple[Ledger, ...]:
    """What the command explains without measuring it, once for all widths."""
    assert not options["measure"]
    return once(path, scene)


@pytest.mark.parametrize("columns", [80, 100, 140])
def test_tables_fit_the_terminal(root: Path, monkeypatch: pytest.MonkeyPatch, columns: int) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setattr("codegen.explain.ledger.explain", explained)
    path = str(root / "models" / "valve_lifter.py")
    answer = CliRunner().invoke(app, ["explain", path, "--no-measure"])
    assert answer.exit_code == 0
    assert max(map(cell_len, answer.stdout.splitlines())) <= columns
    assert "kinetic_energy" not in answer.stdout
    beside = ["explain", path, "--compare", "free_follower", "inverse_dynamics", "--no-measure"]
    answer = CliRunner().invoke(app, beside)
    assert max(map(cell_len, answer.stdout.splitlines())) <= columns
    assert "…" not in answer.stdout
    whole = CliRunner().invoke(app, ["explain", path, "--no-measure", "--kernels"]).stdout
    assert "kinetic_energy" in whole


def test_pictures_and_pages(root: Path, tmp_path: Path) -> None:
    (ledger,) = explain(root / "models" / "slider_crank.py", "compressor")
    axes = figure([ledger]).axes
    assert len(axes) == 1  # nothing was measured
    assert [text.get_text() for text in axes[0].get_yticklabels()] == list(ledger.kernels)
    widths = sum(patch.get_width() for patch in axes[0].patches)
    assert widths == pytest.approx(sum(ledger.totals.values()))
    text = page([ledger])
    assert text.count("<svg") == 1
    assert "stands for body" in text
    for name in ("a.png", "a.svg", "a.html", "b.PNG", "b.HTML"):
        arguments = ["explain", "slider_crank", "--scene", "compressor", "--no-measure"]
        answer = CliRunner().invoke(app, [*arguments, "--out", str(tmp_path / name)])
        assert answer.exit_code == 0
        assert (tmp_path / name).stat().st_size > 1000


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--scene", "compresor"], "no scene 'compresor'; did you mean 'compressor'"),
        (["--scene", "kinematics", "--compare", "kinematics", "compressor"], "one or the other"),
        (["--scene", "kinematics", "--run", "1"], "no run under forces"),
        (["--scene", "compressor", "--no-measure", "--out", "a.pdf"], ".png, .svg, .html"),
        (["--scene", "compressor", "--no-measure", "--out", "no/such/a.svg"], "No such file"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(arguments: list[str], told: str) -> None:
    answer = CliRunner().invoke(app, ["explain", "slider_crank", *arguments])
    assert answer.exit_code == 2
    assert told in answer.stderr


def test_a_run_needs_a_scene_of_a_file() -> None:
    model = sledge()
    with pytest.raises(InputError, match="not declared in a file"):
        explain(model, "slide", t_end=1.0)


BOUNCER = """
model = Model("bouncer", gravity=(0, -9.81))
ball = model.particle("ball", mass=1.0)
model.force("wind", on=ball, fx=0.1)
model.contact("floor", gap=ball.y, stiffness=1e4, damping=10.0)
model.scene("drop", ["gravity", "wind", "floor"], start={ball.y: 0.1, ball.x: 0.0})
"""


@pytest.mark.slow
def test_prices_of_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (ledger,) = explain(write_model(tmp_path / "models", BOUNCER), "drop", t_end=1.0)
    parts = the(ledger)
    assert parts["floor"].run_events == ledger.run.events > 5
    assert parts["floor"].run_retakes == ledger.run.retakes > 0
    assert parts["wind"].run_events == 0
    times = [part.nanoseconds for part in ledger.parts if part.nanoseconds is not None]
    spent = sum(part.run_seconds or 0.0 for part in ledger.parts)
    assert spent == pytest.approx(sum(times) * 1e-9 * ledger.run.evaluations)


def test_a_scene_whose_kernels_cost_nothing_is_drawn(root: Path) -> None:
    """Matplotlib warns of a legend without entries, and warnings are errors in the tests."""
    (ledger,) = explain(root / "models" / "slider_crank.py", "compressor")
    free = replace(ledger, parts=tuple(replace(part, operations={}) for part in ledger.parts))
    (axes,) = figure([free]).axes
    assert axes.get_legend() is None


def test_kernels_in_loops_are_named_with_their_statements() -> None:
    """A small machine says how far it is from the threshold, a large one what its loops save."""
    (small,) = explain(chain(2))
    found = re.fullmatch(r"written out: (\d+) statements, not above 6000", small.loops)
    assert found is not None, small.loops
    assert 50 < int(found[1]) < 6000
    assert f"kernels: {small.loops}" in [*notes(small)]
    chosen, *_ = valid_scenes(chain(60), None)
    sentence = loops_sentence(lower(derive(chain(60), chosen)))
    assert sentence.startswith("in loops: ")
    of_accelerations = re.search(r"accelerations \((\d+) statements, (\d+) left\)", sentence)
    assert of_accelerations is not None, sentence
    before, after = map(int, of_accelerations.groups())
    assert after < 0.6 * before
    assert "statements, above 6000" in sentence
