"""A short sweep of the compressor, and what every sweep of these tests has."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from runtime import sweep
from runtime.sweeps.study import Study

QUANTITIES = ("max:B.fx", "crank.omega")


def same(ours: Study, theirs: Study) -> bool:
    """Whether two studies have the same rows, bit for bit."""
    for name in (*ours.factors, *ours.quantities, *ours.series, "outcome", "message", "t_last"):
        first, second = (study.data[name].values for study in (ours, theirs))
        bits = (first.tobytes(), second.tobytes()) if first.dtype.kind == "f" else (first, second)
        if not np.all(bits[0] == bits[1]):
            return False
    return True


@pytest.fixture(scope="session")
def about() -> dict[str, Any]:
    """A scene and a run of a few steps."""
    return {"model": "slider_crank", "scene": "compressor", "t_end": 0.05, "points": 21,
            "quantities": QUANTITIES, "progress": False}  # fmt: skip


@pytest.fixture(scope="session")
def request_of(about: dict[str, Any]) -> dict[str, Any]:
    """A sweep of 24 runs in this process."""
    return {**about, "over": {"J1": "200:1000:24"}, "workers": 0}


@pytest.fixture(scope="session")
def whole(request_of: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> Study:
    """That sweep, undisturbed."""
    return sweep(out=tmp_path_factory.mktemp("whole") / "s.zarr", **request_of)


@pytest.fixture
def swept(tmp_path: Path, about: dict[str, Any]) -> Callable[..., Study]:
    """Makes a sweep of that scene in this process, in a store of its own."""
    return lambda **words: sweep(**{"out": tmp_path / "s.zarr", "workers": 0, **about, **words})


GRID = {"over": {"J1": "200:1000:3", "rod_length": [-1.0, 3.0, 3.5, 4.0]}, "keep": ["crank.phi"]}


@pytest.fixture(scope="session")
def study(tmp_path_factory: pytest.TempPathFactory, about: dict[str, Any]) -> Study:
    """A grid of 12 runs, of which three are refused: a rod of -1 m is none."""
    folder: Path = tmp_path_factory.mktemp("sweeps")
    return sweep(out=folder / "study.zarr", workers=0, **GRID, **about)
