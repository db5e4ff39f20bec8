"""The limit of a case: seconds of the processor, its own and its children's, not of the clock."""

import subprocess
import sys
import time

import pytest

from tests.fuzz import campaign

BUSY = "import time\nwhile time.process_time() < 1.0: pass"


def work(seconds: float) -> None:
    started = time.process_time()
    while time.process_time() - started < seconds:
        pass


def test_work_beyond_the_limit_is_stopped() -> None:
    started = time.process_time()
    with pytest.raises(campaign.OverTimeError), campaign.limited(0.3):
        work(60.0)
    assert time.process_time() - started < 5.0


def test_work_within_it_may_wait_for_the_processor() -> None:
    with campaign.limited(0.5):
        time.sleep(1.0)
        work(0.1)


def test_waiting_has_an_end() -> None:
    with pytest.raises(campaign.OverTimeError), campaign.limited(0.05):
        time.sleep(60.0)


def test_processes_that_are_started_count() -> None:
    with pytest.raises(campaign.OverTimeError), campaign.limited(0.8):
        subprocess.run([sys.executable, "-c", BUSY], check=True)
