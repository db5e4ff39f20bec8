"""The kernel `correction` in space: the least change, Newton's convergence, coordinates held."""

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import null_space, qr

from codegen import Model
from codegen.driver import translate
from codegen.generated_files.generated_file import Clock
from codegen.lower.interpreter import evaluate
from models.space.bricard import bricard
from models.space.heavy_top import heavy_top
from tests.space.machines import slider_crank

Array = np.ndarray[Any, np.dtype[np.float64]]
MACHINES = {
    "heavy_top": heavy_top,
    "slider_crank_2": lambda: slider_crank(False),
    "slider_crank_1": lambda: slider_crank(True),
    "bricard": bricard,
}
CONSTANT = 50.0  # of quadratic convergence, at residuals and changes of these machines


class Corrections:
    """The kernel, and Φ with its differences as an oracle."""

    def __init__(self, declare: Callable[[], Model]) -> None:
        model = declare()
        (scene,) = model.scenes.values()
        _, lowered, _ = translate(model, scene, Clock({}, lambda _: None, ""))
        self.program, about = lowered.program, lowered.description
        self.n, self.m = len(about.coordinates), len(about.constraints)
        self.p = [value for _, value, *_ in about.parameters]
        known = {name: value for name, value, _ in about.start}
        self.firsts = [first for _, first in about.turning]
        self.rng = np.random.default_rng(7)
        start = np.array([known.get(name, 0.0) for name, *_ in about.coordinates])
        self.start = self.closed(start, np.ones(self.n))
        # dependent ones first, so that the others are independent
        basis = null_space(self.slopes(self.start), rcond=1e-6)
        self.held = qr(basis.T, pivoting=True)[2][: basis.shape[1]]

    def __call__(self, q: Array, v: Array, w: Array) -> tuple[Array, Array]:
        given = {"t": 0.0, "q": q.tolist(), "v": v.tolist(), "p": self.p, "w": w.tolist()}
        found = evaluate(self.program, "correction", given, math)
        dq, dv = ([found[name][k] for k in range(self.n)] for name in ("dq", "dv"))
        return np.array(dq), np.array(dv)

    def phi(self, q: Array) -> Array:
        given = {"t": 0.0, "q": q.tolist(), "p": self.p}
        slots = evaluate(self.program, "constraints", given, math)["phi"]
        return np.array([slots[i] for i in range(self.m)])

    def slopes(self, q: Array) -> Array:
        steps = 1e-6 * np.eye(self.n)
        return np.array([(self.phi(q + s) - self.phi(q - s)) / 2e-6 for s in steps]).T

    def closed(self, q: Array, w: Array) -> Array:
        """The position to which dense steps of Newton's method lead."""
        root = np.sqrt(w)
        for _ in range(30):
            q = q - root * np.linalg.lstsq(self.slopes(q) * root, self.phi(q), rcond=1e-7)[0]
        return q


@pytest.fixture(scope="module", params=MACHINES)
def machine(request: pytest.FixtureRequest) -> Corrections:
    return Corrections(MACHINES[request.param])


def test_it_is_the_least_change_in_the_norm_of_the_weights(machine: Corrections) -> None:
    for _ in range(3):
        w, v = machine.rng.uniform(0.2, 3.0, machine.n), machine.rng.standard_normal(machine.n)
        _, dv = machine(machine.start, v, w)
        slopes, root = machine.slopes(machine.start), np.sqrt(w)
        least = -root * np.linalg.lstsq(slopes * root, slopes @ v, rcond=1e-7)[0]
        assert_allclose(dv, least, rtol=0, atol=3e-8)


@pytest.mark.parametrize("holds", [False, True])
def test_newton_converges_quadratically_and_holds_coordinates(
    machine: Corrections, holds: bool
) -> None:
    w, v = machine.rng.uniform(0.2, 3.0, machine.n), np.zeros(machine.n)
    if holds:
        w[machine.held] = 0.0
    q = moved = machine.start + 3e-3 * machine.rng.standard_normal(machine.n)
    sizes = [np.abs(machine.phi(q)).max()]
    assert sizes[0] > 1e-3
    for _ in range(4):
        dq, _ = machine(q, v, w)
        if holds:
            assert not dq[machine.held].any()
        q = q + dq
        sizes.append(np.abs(machine.phi(q)).max())
    for before, after in itertools.pairwise(sizes):
        assert after <= CONSTANT * before**2 + 1e-14
    for first in machine.firsts:
        assert abs(np.linalg.norm(q[first : first + 4]) - 1.0) < 1e-14
    if holds:
        assert_allclose(q, machine.closed(moved, w), rtol=0, atol=1e-8)
