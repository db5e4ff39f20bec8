"""The command line: exit statuses, streams, JSON, files."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
import typer.testing

from runtime.machine_facade import Machine
from runtime.results.result import Result

Run = Callable[..., typer.testing.Result]


def test_kinematics_to_a_file(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    done = run("kinematics", "sc_driven", "--t-end", "1", "--points", "11", "--out", path)
    assert done.exit_code == 0
    assert len(path.read_text().splitlines()) == 12
    assert f"Saved: 11 instants in {path}" in done.stderr
    assert "slider.x     4.61577568 m\n" in done.stdout


def test_json_is_one_object_and_alone(run: Run) -> None:
    done = run("inverse", "sc_driven", "--t-end", "0.5", "--set", "J1=900", "--json")
    assert done.exit_code == 0
    answer = json.loads(done.stdout)
    assert answer["ok"] is True
    assert answer["analysis"] == "inverse dynamics"
    assert answer["outcome"] == "OK"
    assert answer["parameters"]["J1"] == 900.0
    assert answer["t"] == [0.0, 0.5]
    assert answer["saved"] is None
    assert answer["q"]["crank.phi"] == pytest.approx(3.926990817)
    assert "sc_driven/driven, inverse dynamics" in done.stderr


def test_simulate_with_a_model_by_path(run: Run) -> None:
    done = run(
        "simulate", "models/rod_pendulum.py", "--scene", "swing", "--t-end", "0.5",
        "--rtol", "1e-6", "--atol", "1e-6", "--method", "dopri5", "--start", "bar.phi=0.1",
        "--json",
    )  # fmt: skip
    assert done.exit_code == 0
    answer = json.loads(done.stdout)
    assert answer["instants"] == 501
    assert answer["stats"]["steps"] > 1
    assert answer["q"]["bar.phi"] < 0.1


def test_equilibrium(run: Run) -> None:
    done = run("equilibrium", "rod_pendulum", "--method", "settling", "--json")
    assert done.exit_code == 0
    answer = json.loads(done.stdout)
    assert answer["stability"] == "stable"
    assert answer["frequencies"] == [pytest.approx(0.44586114689)]
    assert answer["q"]["bar.y"] == pytest.approx(-1.0)


def test_failed_run_saves_and_says_so(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "locked.csv"
    command = ("kinematics", "sc_driven", "--t-end", "1", "--points", "1001", "--set", "l=1.9")
    done = run(*command, "--out", path, "--json")
    assert done.exit_code == 1
    assert "Locked up at t = 0.0744586" in done.stderr
    assert f"What was computed: 76 instants up to t = 0.0744587 s in {path}" in done.stderr
    assert len(path.read_text().splitlines()) == 77
    answer = json.loads(done.stdout)
    assert answer["ok"] is False
    assert answer["outcome"] == "LOCKED"
    done = run(*command)
    assert done.exit_code == 1
    assert "Nothing was saved; give --out FILE" in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("kinematics", "sc_drivn", "--t-end", "1"), "no model 'sc_drivn'"),
        (("kinematics", "sc_driven", "--t-end", "1", "--set", "l=-1"), "l is -1 m; it must be"),
        (("kinematics", "sc_driven", "--t-end", "1", "--set", "l"), "write NAME=VALUE"),
        (("kinematics", "sc_driven", "--t-end", "1", "--guess", "l=x"), "--guess l=x: write"),
        (("kinematics", "sc_driven", "--t-end", "0"), "from 0 to 0 s must be finite and positive"),
        (("kinematics", "sc_driven", "--t-end", "1", "--out", "run.doc"), "not as '.doc'"),
        (("kinematics", "sc_free", "--t-end", "1"), "1 degree of freedom is left"),
        (("equilibrium", "sc_driven"), "0 degrees of freedom"),
    ],
)
def test_wrong_input_ends_with_two(run: Run, arguments: tuple[str, ...], message: str) -> None:
    done = run(*arguments, "--json")
    assert done.exit_code == 2
    assert "error: " in done.stderr
    assert message in done.stderr
    answer = json.loads(done.stdout)
    assert answer["ok"] is False
    assert answer["status"] == 2
    assert any(message in problem for problem in answer["problems"])


def test_simulate_from_a_later_instant(run: Run) -> None:
    done = run("simulate", "rod_pendulum", "--t-start", "2", "--t-end", "2.5", "--json")
    answer = json.loads(done.stdout)
    assert answer["t"] == [2.0, 2.5]
    from_zero = json.loads(run("simulate", "rod_pendulum", "--t-end", "0.5", "--json").stdout)
    assert answer["q"]["bar.phi"] == pytest.approx(from_zero["q"]["bar.phi"], rel=1e-6)


def test_place_that_cannot_be_written_is_refused_before_the_run(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def forbidden(*_: object, **__: object) -> None:
        raise AssertionError("the analysis ran")

    monkeypatch.setattr(Machine, "kinematics", forbidden)
    command = ("kinematics", "sc_driven", "--t-end", "1", "--out")
    (tmp_path / "folder.csv").mkdir()
    done = run(*command, tmp_path / "folder.csv")
    assert done.exit_code == 2
    assert "is a folder; name a file in it" in done.stderr
    done = run(*command, tmp_path / "nowhere" / "run.csv")
    assert done.exit_code == 2
    assert "nowhere does not exist" in done.stderr

    def locked(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("runtime.results.export.tempfile.TemporaryFile", locked)
    done = run(*command, tmp_path / "run.csv")
    assert done.exit_code == 2
    assert "nothing can be written" in done.stderr
    assert "Permission denied" in done.stderr


def test_unwritable_file_ends_with_one(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(Result, "save", fail)
    done = run("kinematics", "sc_driven", "--t-end", "1", "--out", tmp_path / "run.csv")
    assert done.exit_code == 1
    assert done.stderr == "error: disk full\n"


def test_events_are_told_and_listed(run: Run, root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(root)
    ball = ("simulate", "hard/bouncing_ball", "--t-end", "3")
    done = run(*ball)
    assert done.exit_code == 0
    assert "t = 0.451523641    plate touches\n" in done.stderr
    assert "5 more events" in done.stderr
    assert "plate rests" in done.stderr
    answer = json.loads(run(*ball, "--json").stdout)["events"]
    assert len(answer) == 17
    assert (answer[-1]["what"], answer[-1]["word"]) == ("holds", "rests")
    assert answer[-1]["t"] == pytest.approx(1.35457092, abs=1e-8)
