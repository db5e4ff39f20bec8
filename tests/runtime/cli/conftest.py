"""The command line in this process, in a folder with the machines of the tests."""

from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from linkwright.cli.application import app
from runtime.machine_facade import Machine

Run = Callable[..., Result]


@pytest.fixture
def run(
    driven: Machine, free: Machine, pendulum: Machine, workshop: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Run:  # fmt: skip
    monkeypatch.chdir(workshop)
    return lambda *words: CliRunner().invoke(app, [str(word) for word in words])
