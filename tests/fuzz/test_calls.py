"""A sample of calls with arguments of the wrong kind."""

from pathlib import Path
from random import Random

import pytest

from runtime.machine_facade import Machine
from tests.fuzz import calls


@pytest.fixture
def described(
    pendulum: Machine, driven: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> list[calls.Call]:
    """The calls, in a folder of their own."""
    monkeypatch.chdir(tmp_path)
    return calls.calls(pendulum, driven)


def test_arguments_of_the_wrong_kind_are_refused_by_name(described: list[calls.Call]) -> None:
    found = (calls.judge(Random(f"calls 20 {number}"), described) for number in range(800))
    assert list(filter(None, found)) == []


def test_the_good_arguments_of_every_analysis_are_accepted(described: list[calls.Call]) -> None:
    studies = {"matters", "accuracy", "build", "load", "load_result", "load_study", "sweep"}
    for call in described:
        if call.title in calls.NAMELESS:
            call.function(*call.good.values())
        elif call.title not in studies and not call.title.startswith("Result."):
            call.function(**call.good)
