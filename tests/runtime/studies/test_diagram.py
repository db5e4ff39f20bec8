"""A work-precision diagram: conclusions, sentences, JSON lines, picture, tables and command."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from numpy.testing import assert_allclose
from rich.cells import cell_len
from rich.console import Console
from typer.testing import CliRunner

from linkwright.cli.application import app
from runtime.accuracy_target.error_norms import Errors, Scale
from runtime.integrate.method import METHODS
from runtime.studies.diagram import (
    Check,
    Choice,
    Line,
    Point,
    Reference,
    WorkPrecision,
    best_at,
    effectivity,
    front,
    slope,
    time_at,
)
from runtime.studies.harness import Setting
from runtime.studies.pictures import draw_diagram, records, save_diagram


def point(rtol: float, worst: float, seconds: float, *, beyond: bool = False) -> Point:
    found = Errors(worst, worst, worst, worst, {"positions": worst}, {"x": worst})
    return Point(rtol, "OK", "", found, beyond, seconds, 1.0, 5)


def study(*made: Line, floor: float = 1e-12, choices: tuple[Choice, ...] = ()) -> WorkPrecision:
    reference = Reference("dop853", False, (Check("radau5", floor),), floor)
    scale = Scale("x", "m", "positions", 1.0)
    return WorkPrecision("m", "s", 0.0, 1.0, 10, (scale,), "", 1.0, 10, reference, made, choices)


SLOW = Line(
    Setting("dop853"),
    (point(1e-2, 1e-2, 1e-3), point(1e-6, 1e-6, 4e-3), point(1e-10, 1e-10, 16e-3)),
)
FAST = Line(
    Setting("dop853", "reduced"),
    (point(1e-2, 2e-2, 1e-3), point(1e-6, 1e-7, 2e-3), Point(1e-10, "SINGULAR", "Stopped.")),
)


def test_times_lie_on_lines_in_logarithms() -> None:
    assert_allclose(time_at(SLOW, 1e-4), 2e-3, rtol=1e-12)
    assert_allclose(time_at(SLOW, 1e-8), 8e-3, rtol=1e-12)
    assert time_at(SLOW, 0.5) == 1e-3
    assert time_at(SLOW, 1e-11) == time_at(FAST, 1e-9) == math.inf
    flat = Line(Setting("auto"), (point(1e-3, 1e-3, 3e-3), point(1e-6, 1e-6, 2e-3)))
    assert time_at(flat, 1e-3) == time_at(flat, 1e-6) == 2e-3
    lost = Line(Setting("auto"), (point(1e-3, math.inf, 1e-3), point(1e-6, 1e-6, 2e-3)))
    assert time_at(lost, 1e-3) == 2e-3
    assert best_at(study(SLOW, FAST), 1e-6) is FAST
    assert best_at(study(SLOW, floor=1e-5), 1e-6) is None
    assert_allclose(slope(SLOW), 1.0)
    assert_allclose(effectivity(SLOW), 1.0)
    assert slope(Line(Setting("bdf"), (point(1e-2, 1e-2, 1.0),))) is None


def test_no_run_beats_those_of_the_front() -> None:
    runs = front((SLOW, FAST))
    assert [(p.worst, p.seconds) for p in runs] == [(1e-2, 1e-3), (1e-7, 2e-3), (1e-10, 16e-3)]
    unknown = Line(Setting("bdf"), (point(1e-2, 1e-13, 3e-3, beyond=True),))
    assert [p.seconds for p in front((SLOW, FAST, unknown))] == [1e-3, 2e-3, 3e-3]


def test_sentences_follow_from_the_runs() -> None:
    found = study(
        SLOW,
        FAST,
        Line(Setting("dop853", "cartesian", "stage"), (point(1e-6, 1e-6, 8e-3),)),
        choices=(
            Choice("rod as link", "coupler", "s2", Setting("dop853"), point(1e-4, 1e-2, 5e-4)),
            Choice("ring as lumped", "coupler", "s3", reason="It does not assemble."),
        ),
    )
    lines = list(found.sentences())
    slow, fast, steps = time_at(SLOW, 1e-9), time_at(FAST, 1e-6), time_at(SLOW, 1e-6)
    assert lines[0].startswith(
        f"Three more digits, 9 instead of 6, cost {slow / fast:.2g} times the time: "
    )
    text = " ".join(lines)
    assert "Correction at every stage takes 2.00 times the time" in text
    assert f"dop853, reduced takes {fast / steps:.2f} times the time of dop853, cartesian" in text
    assert (
        "rod as link keeps 2.0 digits, however tight the tolerance, after 0.5 ms; the declared "
        "scene has as many after 1 ms."
    ) in lines
    assert "ring as lumped: not run. It does not assemble." in lines
    assert "Stopped." in next(line for line in lines if "1 of 3 runs did not" in line)
    nothing = study(Line(Setting("bdf"), (point(1e-2, 0.02, 1.0),)))
    assert next(nothing.sentences()).startswith("No run has more than 1.7 digits")


def test_long_reasons_end_at_a_word_on_a_screen_and_nowhere_in_records() -> None:
    reason = " ".join(f"reason{k}" for k in range(60))
    found = study(
        SLOW,
        Line(Setting("radau5"), refused=reason),
        Line(Setting("bdf"), (point(1e-2, 1e-2, 1e-3), Point(1e-4, "SINGULAR", reason))),
        choices=(Choice("ring as lumped", "coupler", "s3", reason=reason),),
    )
    cut = [line for line in found.sentences() if "reason0" in line]
    assert len(cut) == 3
    for line in cut:
        *_, last, dots = line.split()
        assert dots == "…"
        assert last in reason.split()
        assert len(line[line.index("reason0") :]) <= 160
    facts = json.loads(json.dumps(found.facts(), allow_nan=False))
    assert sum(line.endswith(reason) for line in facts["sentences"]) == 3


def test_a_row_is_written_for_every_run(swing: WorkPrecision, tmp_path: Path) -> None:
    rows = [json.loads(json.dumps(row, allow_nan=False)) for row in records(swing)]
    runs = sum(len(line.points) for line in swing.lines)
    assert len(rows) == runs == 3 * (2 * len(METHODS) + 2)
    first = rows[0]
    assert (first["model"], first["scene"], first["method"]) == ("rig", "swing", "dop853")
    assert first["outcome"] == "OK"
    assert first["counts"]["steps"] > 0
    assert first["artefact_sha256"] == swing.artefact
    assert len(first["model_sha256"]) == 64
    assert {"numba", "numpy", "python", "machine"} <= first["environment"].keys()
    assert_allclose(first["atol"]["body.x"], 1e-3 * min(1.0, first["scales"]["body.x"]))
    assert set(first["errors"]) == {"worst", "rms", "end", "relative", "groups", "each"}
    written, drawn = save_diagram(swing, tmp_path / "out")
    assert len(written.read_text(encoding="utf-8").splitlines()) == runs
    assert drawn.stat().st_size > 20_000
    facts = json.loads(json.dumps(swing.facts(), allow_nan=False))
    assert facts["lines"][1]["setting"]["formulation"] == "reduced"
    assert facts["sentences"][0] == next(swing.sentences())
    with pytest.raises(KeyError, match="there are: dop853, cartesian; dop853, reduced"):
        swing["euler, cartesian"]


def test_picture_has_a_line_a_setting_and_the_floor(swing: WorkPrecision) -> None:
    axes = draw_diagram(swing).axes[0]
    labels = axes.get_legend_handles_labels()[1]
    assert labels == ["Pareto front", *(line.setting.title for line in swing.lines)]
    assert axes.get_yscale() == "log"
    (band,) = (patch for patch in axes.patches if patch.get_hatch())
    place = band.get_extents().transformed(axes.transData.inverted())
    assert_allclose(place.x0, -math.log10(swing.reference.floor))


@pytest.mark.parametrize("columns", [80, 110, 140])
def test_tables_fit_a_terminal(
    columns: int, swing: WorkPrecision, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    screen = Console(width=columns, highlight=False, record=True)
    for made in swing.tables():
        with screen.capture() as capture:
            screen.print(made)
        text = capture.get()
        assert max(map(cell_len, text.splitlines())) <= columns
        assert "…" not in text
        assert text.count("bdf") == 2


def test_a_notebook_shows_the_times(swing: WorkPrecision) -> None:
    html = swing._repr_html_()
    assert "<td>radau5, reduced</td>" in html
    assert "Three more digits" in html


@pytest.fixture
def command(rig: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    monkeypatch.chdir(folder)

    def run(*more: str) -> Result:
        base = ("accuracy", rig, "--scene", "swing", "--t-end", "1", "--quick", "--no-modelling",
                "--method", "dop853", "--formulation", "cartesian")  # fmt: skip
        return CliRunner().invoke(app, [*base, *more])

    return run


def test_command_line(command: Callable[..., Result], tmp_path: Path) -> None:
    done = command("--json", "--out", str(tmp_path / "study"))
    assert done.exit_code == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["ok"] is True
    assert len(answer["lines"]) == 3
    assert "at most 10 s and 1e+06 steps per run" in done.stderr
    made = sorted(path.name for path in (tmp_path / "study").iterdir())
    assert made == ["rig__swing.jsonl", "rig__swing.png"]
    done = command("--quantity", "body.x")
    assert done.exit_code == 0
    assert "time in ms for this many digits" in done.stdout
    assert "Three more digits" in done.stdout
    file = tmp_path / "file"
    file.write_text("", encoding="utf-8")
    for more, message in (
        (("--quantity", "body.z"), "There is no series 'body.z'"),
        (("--method", "euler"), "There is no method 'euler'"),
        (("--out", str(file)), "it is a file; name a folder"),
        (("--out", str(tmp_path / "a" / "b")), "does not exist"),
    ):
        done = command(*more, "--json")
        assert done.exit_code == 2
        assert message in done.stderr
