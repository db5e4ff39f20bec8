"""Driven machines with singular positions, their closed forms, and how to read what was met.

The slider-crank has a crank of 1 m and a rod of 1 + excess.
"""

import numpy as np
import numpy.typing as npt

from runtime import Result, load
from runtime.machine_facade import Machine
from runtime.results.run_records import SingularPosition

FloatArray = npt.NDArray[np.float64]
OMEGA = 2.0 * np.pi
UPRIGHT = 0.125  # s: the crank starts at 45 degrees
NAMES = {"rod.x", "rod.phi", "slider.x"}  # what can move while the crank stands upright
STANDING = {
    "crank.phi": np.pi / 2, "crank.x": 0.0, "crank.y": 0.5, "rod.x": 0.0, "rod.y": 0.5,
    "rod.phi": -np.pi / 2, "slider.x": 0.0,
}  # fmt: skip


def equal_rods() -> Machine:
    return load("hard/equal_rods", "driven")


def angle(t: FloatArray) -> FloatArray:
    return np.pi / 4 + OMEGA * t


def turning(t: FloatArray, excess: float) -> tuple[FloatArray, FloatArray]:
    """x of the slider and its rate, on the assembly on which it starts, for a rod that differs."""
    phi, rod = angle(t), 1.0 + excess
    root = np.sqrt(rod**2 - np.sin(phi) ** 2)
    x = np.cos(phi) + root
    return x, -OMEGA * np.sin(phi) * (1.0 + np.cos(phi) / root)


def assert_close(found: FloatArray, exact: FloatArray, within: float) -> None:
    np.testing.assert_allclose(found, exact, rtol=0, atol=within)


def only(result: Result, kind: str) -> SingularPosition:
    (found,) = result.singular
    assert found.kind == kind
    return found
