"""Scaled errors of a motion against a reference."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from numpy.testing import assert_allclose

from runtime import load
from runtime.accuracy_target.error_norms import Scale, errors, scales


def test_errors_are_those_of_the_formula(rig: str, folder: Path) -> None:
    by = (
        Scale("x", "m", "positions", 2.0),
        Scale("v", "m/s", "velocities", 4.0),
        Scale("f", "N", "others", 10.0),
    )
    true = np.array([[1.0, -4.0, 0.0], [0.0, 0.0, 30.0]])
    found = true + np.array([[0.3, 0.0, 5.0], [0.0, -0.2, np.nan]])
    e = errors(found, true, by)
    assert_allclose(e.worst, 0.1)  # 0.3 / (2 + 1)
    assert_allclose(e.end, 0.05)  # 0.2 / (4 + 0)
    assert_allclose(e.rms, math.sqrt((0.1**2 + 0.05**2) / 4.0))
    assert_allclose(e.relative, math.sqrt((0.15**2 + 0.05**2) / 4.0))
    assert e.groups["others"] == math.inf
    assert_allclose(e.groups["velocities"], 0.05)
    assert_allclose(e.each["x"], 0.1)
    assert errors(found[:1, 2:], true[:1, 2:], by[2:]).worst == 0.5
    machine = load(rig, "swing", folder=folder).description
    names = ("body.x", "body.phi", "body.vx", "body.vy", "kinetic")
    sizes = np.array([1.5, 1.5, 1.0])
    reference = np.array([[0.5, 0.0, 2.0, 0.0, 7.0], [0.1, 0.0, -2.5, 0.0, 3.0]])
    made = scales(names, ("m",) * 5, machine, sizes, reference)
    assert [scale.value for scale in made] == [1.5, 1.0, 2.5, 1.5, 7.0]
    assert [scale.group for scale in made][2:] == ["velocities", "velocities", "others"]
    made = scales(names, ("m",) * 5, machine, sizes, reference, (0.0, 0.0, 0.0, 0.0, 20.0))
    assert [scale.value for scale in made] == [1.5, 1.0, 2.5, 1.5, 20.0]


def test_instants_at_which_the_reference_is_nan_do_not_count() -> None:
    """As reactions in a singular configuration."""
    true = np.array([[4.0], [np.nan], [-10.0]])
    sizes = np.ones(0)
    nothing = SimpleNamespace(coordinates=())
    by = scales(("A.fx",), ("N",), nothing, sizes, true)
    assert by[0].value == 10.0
    e = errors(true + 2.0, true, by)
    assert_allclose(e.worst, 2.0 / 14.0)
    assert_allclose(e.relative, 2.0 / 10.0 * math.sqrt(2.0 / 3.0))
