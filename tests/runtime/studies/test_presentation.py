"""A work-precision study as JSON lines, picture, tables and command."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result
from numpy.testing import assert_allclose
from rich.cells import cell_len
from rich.console import Console
from typer.testing import CliRunner

from linkwright.cli.application import app
from runtime.integrate.method import METHODS
from runtime.studies import timing
from runtime.studies.conclusions import records, score, sentences, work
from runtime.studies.diagram import WorkPrecision
from runtime.studies.pictures import draw_diagram, save_diagram


def test_a_library_without_metadata_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timing, "LIBRARIES", ("numpy", "no-such-library"))
    facts = timing.environment()
    assert facts["numpy"] == np.__version__
    assert "no-such-library" not in facts


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
    assert facts["sentences"][0] == next(sentences(swing))
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
    for made in (score(swing), work(swing)):
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
