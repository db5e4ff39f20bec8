"""A small sample of each campaign; the campaigns themselves are commands of their own."""

import signal
import sys
import time
from pathlib import Path

import pytest

from tests.robustness import full_disks, kills, signals
from tests.robustness.command_line import Workplace, descendants

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are read from /proc")


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Workplace:
    return Workplace(tmp_path_factory.mktemp("robustness") / "work")


@pytest.mark.slow
def test_signals(place: Workplace) -> None:
    found = signals.campaign(place, 4, 1, signals.COMMANDS[:1])
    assert not found.faults
    assert found.kinds.total() == 4


@pytest.mark.slow
def test_kills(place: Workplace) -> None:
    found = kills.campaign(place, 2, 1)
    assert not found.faults


def test_full_disks(place: Workplace) -> None:
    found = full_disks.campaign(place, 20, 1)
    assert not found.faults
    assert {kind.split()[1] for kind in found.kinds} == {"written", "refused"}


@pytest.mark.slow
def test_precompilation_ends_with_all_its_processes(place: Workplace, tmp_path: Path) -> None:
    place.code, usual = tmp_path, place.code  # where nothing is compiled yet
    process = place.start("runtime.precompile", "dop853")
    place.code = usual
    while not (parts := descendants(process.pid)) and process.poll() is None:
        time.sleep(0.05)
    end = place.end(process, (signal.SIGTERM,))
    assert end.status == 128 + signal.SIGTERM
    patience = time.monotonic() + 60.0
    while (left := [part for part in parts if Path(f"/proc/{part}").exists()]) and (
        time.monotonic() < patience
    ):
        time.sleep(0.05)
    assert not left
    assert "Traceback" not in end.output
