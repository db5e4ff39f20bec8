"""Progress is shown to a person who waits, and to nobody else."""

import io
import sys

import numpy as np
import pytest

from runtime import progress_bar as progress
from runtime.machine_facade import Machine


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_nothing_is_shown_where_nobody_looks(capsys: pytest.CaptureFixture[str]) -> None:
    with progress.bar("work") as report:
        assert report is progress.silent
        report(0.5)
    assert capsys.readouterr() == ("", "")


def test_a_short_analysis_shows_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.bar("work") as report:
        report(0.5)
    assert terminal.getvalue() == ""


def test_a_long_analysis_shows_a_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(progress, "PATIENCE", -1.0)
    with progress.bar("kinematics of x/y") as report:
        report(0.25)
        report(0.5)
    assert "kinematics of x/y" in terminal.getvalue()


def test_a_bar_can_be_declined(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Terminal())
    with progress.bar("work", wanted=False) as report:
        assert report is progress.silent


def test_analyses_report_their_progress(driven: Machine) -> None:
    from runtime.dynamics.kinematics_and_inverse_dynamics import kinematics

    seen: list[float] = []
    kinematics(driven.mechanism, np.linspace(0.0, 1.0, 10001), progress=seen.append)
    assert np.diff([0.0, *seen]).min() > 0.0
    assert np.diff([0.0, *seen]).max() <= 0.4096  # a report at least every 4096 instants
    assert seen[-1] == 1.0
