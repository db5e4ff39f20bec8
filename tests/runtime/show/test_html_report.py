"""A report is a whole page, and the same for the same run."""

from html.parser import HTMLParser
from pathlib import Path

import numpy as np
from typer.testing import CliRunner

from linkwright.cli.application import app
from runtime import load
from runtime.show.html_report import page
from tests.runtime.show.page_data import header_of


class Checked(HTMLParser):
    """Notes tags that do not close in order."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.wrong: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "input"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)


def test_a_stopped_run_is_told_in_full() -> None:
    machine = load("slider_crank", "compressor")
    stopped = machine.simulate(
        1.0, np.linspace(0, 1, 101), parameters={"J1": 225.0}, rtol=1e-10, max_steps=30
    )
    text = page(stopped)
    checked = Checked()
    checked.feed(text)
    assert not checked.wrong
    assert not checked.open
    for words in (
        "slider_crank/compressor", "MAX_STEPS", "outcome failed", "J1, kg m^2", "225",
        "largest |Φ|", "exhaust valve opens",
    ):  # fmt: skip
        assert words in text, words
    header = header_of(text)
    (run,) = header["runs"]
    assert run["events"][-1]["text"].startswith("MAX_STEPS: ")
    assert {"C.fx", "crank.omega"} <= {series["name"] for series in run["series"]}
    assert {"C: reaction, N", "angular velocity, rad/s"} <= {g["title"] for g in run["groups"]}
    assert " src=" not in text
    assert "<link" not in text


def test_an_equilibrium_has_no_curves() -> None:
    text = page(load("slider_crank", "gravity_equilibrium").equilibrium())
    assert "4.71238898" in text
    (run,) = header_of(text)["runs"]
    assert [body["name"] for body in run["bodies"]] == ["ground", "crank", "rod", "slider"]
    assert 'class="panel"' not in text


def test_the_same_run_gives_the_same_page() -> None:
    run = load("slider_crank", "kinematics").kinematics(np.linspace(0.0, 1.0, 11))
    assert page(run) == page(run)


def test_the_command_line_picks_the_analysis(tmp_path: Path) -> None:
    for scene, words in (
        ("compressor", "simulation"),
        ("inverse_dynamics", "inverse dynamics"),
        ("kinematics", "kinematics"),
    ):
        out = tmp_path / f"{scene}.html"
        done = CliRunner().invoke(
            app, ["report", "slider_crank", "--scene", scene, "--out", str(out)]
        )
        assert done.exit_code == 0, done.output
        assert words in out.read_text()
    out = tmp_path / "RUN.HTML"
    for command in (["report"], ["kinematics", "--t-end", "1"]):
        words = [*command, "slider_crank", "--scene", "kinematics", "--out", str(out)]
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0, done.output
        assert out.read_text().startswith("<!doctype html>")
        out.unlink()
    done = CliRunner().invoke(app, ["report", "slider_crank", "--out", str(tmp_path / "a.pdf")])
    assert done.exit_code == 2
    assert "a report is an .html page" in done.output
