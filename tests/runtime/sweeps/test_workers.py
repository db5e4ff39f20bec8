"""Processes that make blocks: as one process, and when they are killed."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from random import Random
from typing import Any

import pytest

from benchmarks.sweep_crashes import Campaign, descendants, disturbed, judge, runs_made, undisturbed
from codegen.errors import LinkwrightError
from runtime import sweep
from runtime.sweeps.study import Study
from tests.runtime.sweeps.conftest import same

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs Linux's /proc")


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory, about: dict[str, Any]) -> Study:
    """A sweep in this process."""
    out = tmp_path_factory.mktemp("reference") / "s.zarr"
    return sweep(over={"J1": "200:1000:40"}, out=out, workers=0, **about)


def test_processes_make_the_same_rows(
    reference: Study, about: dict[str, Any], tmp_path: Path
) -> None:
    before = descendants(os.getpid())
    found = sweep(over={"J1": "200:1000:40"}, out=tmp_path / "s.zarr", workers=2, **about)
    assert same(found, reference)
    assert {*descendants(os.getpid())} <= {*before}


def test_a_run_that_ends_its_process_becomes_a_row(
    reference: Study, about: dict[str, Any], tmp_path: Path
) -> None:
    parent = os.getpid()

    def deadly(result: Any) -> float:
        if 500 < result.parameters["J1"] < 510 and os.getpid() != parent:
            os.kill(os.getpid(), signal.SIGKILL)
        return float(result.t[-1])

    quantities = {"deadly": deadly, "max:B.fx": "max:B.fx", "end:crank.omega": "crank.omega"}
    found = sweep(
        over={"J1": "200:1000:40"}, out=tmp_path / "s.zarr", workers=1,
        **about | {"quantities": quantities},
    )  # fmt: skip
    assert found.outcomes == {"OK": 39, "KILLED": 1}
    (row,) = found.failures["J1"].values
    assert 500 < row < 510
    assert "3 processes ended at this run" in str(found.failures["message"].values[0])
    others = found.data["outcome"].values == "OK"
    theirs = reference.data["max:B.fx"].values[others]
    assert (found.data["max:B.fx"].values[others] == theirs).all()
    assert "5 lost workers replaced" in repr(found)


def test_processes_that_do_not_start_end_the_sweep(
    about: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("runtime.sweeps.execution.START", "import sys; sys.exit(7)")
    with pytest.raises(LinkwrightError, match="ended before they could begin, the last with st"):
        sweep(over={"J1": "200:1000:40"}, out=tmp_path / "s.zarr", workers=1, **about)


SCRIPT = """
import linkwright as lw

print("begun")

def stroke(result):
    return float(result.t[-1])

study = lw.sweep(
    "slider_crank", "compressor", over={"J1": "200:1000:6"}, quantities={"stroke": stroke},
    t_end=0.05, points=21, out="s.zarr", folder=FOLDER, workers=1, progress=False,
)
print(study.outcomes)
"""


def test_a_script_needs_no_guard(tmp_path: Path) -> None:
    """Its functions go to the workers, which do not run it again."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.replace("FOLDER", repr(str(tmp_path))))
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert done.stdout == "begun\n{'OK': 6}\n", done.stderr


@pytest.mark.parametrize("mode", ["worker", "whole"])
def test_killed_between_two_blocks(mode: str, campaign: Campaign) -> None:
    assert disturbed(campaign, mode) == 1
    assert judge(campaign, f"{mode}.zarr") == ""


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    """400 runs, made once without a disturbance."""
    made = Campaign(tmp_path_factory.mktemp("campaign"), 20, 1, Random(7), 0.5)
    undisturbed(made)
    return made


def test_a_scheduler_that_is_killed(campaign: Campaign) -> None:
    pytest.importorskip("distributed")
    assert disturbed(campaign, "scheduler") == 1
    assert judge(campaign, "scheduler.zarr") == ""


def test_the_keyboard_stops_a_command_which_says_how_to_go_on(
    tmp_path: Path, campaign: Campaign
) -> None:
    made = campaign._replace(folder=tmp_path, side=80, t_end=1.0)
    process = subprocess.Popen(
        made.command("s.zarr", "--workers", "1"), stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )  # fmt: skip
    while not runs_made(tmp_path / "s.zarr") and process.poll() is None:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate()
    assert process.returncode == 130
    assert "Go on with the same request and --resume" in told
    assert "NOT RUN" in told
