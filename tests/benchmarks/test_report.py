"""Tables, verdicts and files of the measurements."""

import json
from pathlib import Path

import pytest
import typer

from benchmarks.__main__ import MEASUREMENTS, chosen
from benchmarks.problems import PROBLEMS
from benchmarks.report import Report, finish, verdict

REPORT = Report("gears", "gears", ("gear", "ns"), [("spur", "3.0")], ["Good."], [{"ns": 3.0}])


def test_a_verdict_says_whether_the_bar_holds_and_by_how_much_it_is_missed() -> None:
    assert verdict("It takes", 2.5, 3.0) == "It takes 2.50; the bar of 3 holds."
    assert verdict("It takes", 0.75, 0.5, " ns") == (
        "It takes 0.75 ns; the bar of 0.5 ns is missed by 0.25 ns."
    )


def test_a_report_is_shown_and_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    finish(REPORT, tmp_path / "results")
    shown = capsys.readouterr().out
    assert "spur" in shown
    assert "Good." in shown
    record = json.loads((tmp_path / "results" / "gears.json").read_text(encoding="utf-8"))
    assert record["rows"] == [{"ns": 3.0}]
    text = (tmp_path / "results" / "gears.md").read_text(encoding="utf-8")
    assert "| gear | ns |\n| :-- | --: |\n| spur | 3.0 |\n" in text
    assert "numba" in text


def test_without_names_everything_is_measured() -> None:
    assert chosen(None) == (list(MEASUREMENTS), list(PROBLEMS)) == chosen([])
    assert chosen(["machines"]) == (["machines"], list(PROBLEMS))


def test_problems_are_those_of_the_contest() -> None:
    assert chosen(["peers", "andrews"]) == (["peers"], ["andrews"])
    with pytest.raises(typer.BadParameter, match="'andrews' is none of"):
        chosen(["machines", "andrews"])


def test_unknown_measurements_are_refused() -> None:
    with pytest.raises(typer.BadParameter, match="'element' is none of elements, elements_in"):
        chosen(["element"])
