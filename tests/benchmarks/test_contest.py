"""Time to an error, and what the processes of other tools say."""

import ast
import json
import math
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import contest, contest_report, picture
from benchmarks.contest import FLOOR, OURS, PEERS, Contest
from benchmarks.precision import Point, best_time, least, reliable, time_to
from benchmarks.problems import PROBLEMS


def points(name: str, method: str, pairs: list[tuple[float, float]]) -> list[Point]:
    """Errors and milliseconds, from the loosest setting to the tightest."""
    return [Point(name, method, 10.0**-k, error, ms) for k, (error, ms) in enumerate(pairs)]


def test_time_is_read_off_between_points() -> None:
    line = points("a", "m", [(1e-2, 1.0), (1e-4, 10.0), (1e-8, 100.0)])
    assert time_to(1e-2, line) == pytest.approx(1.0)
    assert time_to(1e-3, line) == pytest.approx(math.sqrt(10.0))
    assert time_to(1e-6, line) == pytest.approx(math.sqrt(1000.0))
    assert time_to(1e-9, line) == math.inf
    assert time_to(1.0, line) == 1.0


def test_a_lucky_point_does_not_count() -> None:
    line = points("a", "m", [(1e-2, 1.0), (1e-9, 2.0), (1e-4, 4.0), (1e-6, 8.0)])
    assert (1e-9, 2.0) not in reliable(line)
    assert time_to(1e-4, line) == pytest.approx(4.0)
    assert time_to(1e-9, line) == math.inf


def test_a_failure_is_no_answer() -> None:
    failed = Point("a", "m", 1e-3, math.inf, 0.0, 0, "singular")
    assert time_to(1e-3, [failed]) == math.inf
    assert best_time(1e-3, [failed, *points("a", "n", [(1e-3, 5.0)])]) == (5.0, "n")


def test_the_least_of_several_times_counts() -> None:
    took: list[int] = []
    milliseconds, answer = least(lambda: took.append(1) or len(took), repeats=4)
    assert len(took) == answer == 4
    assert 0.0 <= milliseconds < 1000.0


def test_an_error_that_is_no_number_is_infinite() -> None:
    assert PROBLEMS["andrews"].error([math.nan]) == math.inf
    with pytest.raises(ValueError, match="longer"):
        PROBLEMS["chain_10"].error([0.0])


def test_incomplete_lines_are_ignored() -> None:
    measured = Contest("andrews")
    point = Point("exudyn", "m", 1e-3, 0.5, 2.0)
    output = json.dumps({"point": point.__dict__})
    contest.collect(["noise", '{"versions": {"exudyn": "1"}}', output, output[:40]], measured)
    assert measured.points == [point]
    assert measured.versions == {"exudyn": "1"}


def test_a_missing_tool_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PEERS, "nobody", contest.Peer("nothing", True, ("andrews",)))
    measured = Contest("andrews")
    contest.run_peer("nobody", PROBLEMS["andrews"], sys.executable, measured)
    assert measured.missing == {"nobody": "not installed: pip install nothing"}


ONE = {"contestant": "pydy", "method": "m", "setting": 0.1, "error": 1e-3, "milliseconds": 2.0}


@pytest.mark.parametrize(
    ("output", "reason"),
    [
        (b"", "no answer in 240 s"),
        (
            json.dumps({"point": ONE}).encode() + b'\n{"poi',
            "tighter settings were not run in 240 s",
        ),
    ],
)
def test_a_tool_out_of_time_is_reported(
    output: bytes, reason: str, measured: Contest, monkeypatch: pytest.MonkeyPatch
) -> None:
    def late(*_: object, **__: object) -> None:
        raise subprocess.TimeoutExpired("pydy", contest.LIMIT, output)

    monkeypatch.setattr(subprocess, "run", late)
    measured.points = [point for point in measured.points if point.contestant != "pydy"]
    contest.run_peer("pydy", PROBLEMS["slider_crank"], sys.executable, measured)
    assert measured.missing["pydy"] == reason
    if output:
        sentences = "\n".join(contest_report.report(measured).verdicts)
        assert f"pydy does not reach 1e-09 ({reason}); reduced does." in sentences
        assert f"pydy has not all its points: {reason}." in sentences
        factor = measured.factor("pydy", "linkwright", "reduced", 1e-3)
        assert f"To 1e-03, its least error, it takes {factor:.0f} times as long." in sentences


def test_every_tool_has_a_file_with_its_problems(root: Path) -> None:
    folder = root / "benchmarks" / "peers"
    files = {path.stem for path in folder.glob("*.py")} - {"__init__", "protocol"}
    assert files == PEERS.keys()
    for name, peer in PEERS.items():
        assert set(peer.problems) <= PROBLEMS.keys()
        for place, problems in (
            (folder, {p for p in peer.problems if p not in (*contest.LOOPS, *contest.SPACE)}),
            (folder / "space", {*peer.problems} & {*contest.SPACE}),
        ):
            if problems:
                text = (place / f"{name}.py").read_text(encoding="utf-8")
                output = {n.value for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Constant)}
                assert problems <= output


@pytest.fixture
def measured() -> Contest:
    """A contest in which everything is known."""
    made = Contest("slider_crank", paces={FLOOR: 2.0, OURS: 2.0, "pydy": 4.0, "pinocchio": 2.0})
    made.points = [
        *points(FLOOR, "floor", [(1e-6, 4.0), (1e-9, 5.0)]),
        *points(OURS, "reduced", [(1e-6, 5.0), (1e-9, 10.0)]),
        *points(OURS, "cartesian", [(1e-6, 10.0), (1e-9, 12.0)]),
        *points("pydy", "Cython", [(1e-6, 1500.0), (1e-9, 3000.0)]),
        *points("pinocchio", "DOP853", [(1e-6, 300.0), (1e-9, 500.0)]),
    ]
    made.missing = {"mujoco": "not installed: pip install mujoco"}
    return made


def test_factors_are_corrected_by_the_pace(measured: Contest) -> None:
    """pydy ran while the machine was half as fast."""
    assert measured.factor("pydy", OURS, "reduced", 1e-9) == pytest.approx(150.0)
    assert measured.factor("pinocchio", OURS, "reduced", 1e-9) == pytest.approx(50.0)


def test_a_report_tells_what_holds_and_what_does_not(measured: Contest) -> None:
    made = contest_report.report(measured)
    sentences = "\n".join(made.verdicts)
    assert "reduced to 1e-06, in times of the floor: 1.25; the bar of 1.5 holds." in sentences
    assert "reduced to 1e-09, in times of the floor: 2.00; the bar of 1.5 is missed" in sentences
    assert "pydy to 1e-09, in times of reduced: 150; the bar of 100 holds." in sentences
    assert "pinocchio to 1e-09, in times of reduced: 50; the bar of 100 is missed." in sentences
    assert made.cells[0][:4] == ("floor", "floor", "4", "5")
    assert made.cells[-1][:2] == ("mujoco", "not installed: pip install mujoco")


def test_a_contest_is_read_as_it_was_written(measured: Contest, tmp_path: Path) -> None:
    measured.points.append(Point("pydy", "LSODA", 1e-3, math.inf, 0.0, 0, "gave up"))
    measured.write(tmp_path / "measured.json")
    assert contest.read(tmp_path / "measured.json") == measured


def test_a_picture_is_drawn(measured: Contest, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    path = picture.draw(measured, tmp_path / "measured.png")
    assert path.read_bytes()[:4] == b"\x89PNG"
