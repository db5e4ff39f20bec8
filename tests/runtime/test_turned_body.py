"""Machines of bodies that two numbers turn, against the same machines of bodies with an angle."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.result import Result
from tests.codegen.elements.turned_body import turned_body

CENTRE = (0.07, -0.03)
SAME = 1e-9
TIGHT = 1e-12
EXACT = {"rtol": TIGHT, "progress": False}


def declare(
    model: Model, turned: bool, name: str, mass: float, inertia: float
) -> Callable[..., Any]:
    """A body of one kind or the other; its points are told from its centre of mass."""
    if not turned:
        return model.body(name, mass, inertia).at
    body = turned_body(model, name, mass, inertia, CENTRE)
    return lambda x, y: body.at(x + CENTRE[0], y + CENTRE[1])


def double_pendulum(turned: bool) -> Model:
    model = Model(f"pair_{'turned' if turned else 'plain'}", gravity=(0, -9.81))
    a = declare(model, turned, "a", 2.0, 0.3)
    b = declare(model, turned, "b", 1.5, 0.2)
    model.revolute("A", model.ground.at(0, 0), a(-0.5, 0))
    model.revolute("B", a(0.5, 0), b(-0.4, 0.1))
    model.spring(
        "s", model.ground.at(1, 0.5), b(0.3, 0), stiffness=40.0, free_length=0.4, damping=2
    )
    model.force("push", b(0.2, -0.1), 3.0, 1.0, frame="body")
    model.torque("twist", a(0, 0).body, 0.7)
    start = (
        {"a.e1": np.sin(0.25), "b.e1": np.sin(-0.15)} if turned else {"a.phi": 0.5, "b.phi": -0.3}
    )
    model.scene("fall", effects=["gravity", "s", "push", "twist"], start=start)
    model.scene("rest", effects=["gravity", "s"], analysis="equilibrium")
    return model


def slider_crank(turned: bool) -> Model:
    model = Model(f"crank_{'turned' if turned else 'plain'}", gravity=(0, -9.81))
    crank = model.body("crank", 3.0, 0.2)
    rod = declare(model, turned, "rod", 2.0, 0.5)
    slider = model.body("slider", 1.0, 0.1)
    model.revolute("A", model.ground.at(0, 0), crank.at(0, 0))
    model.revolute("B", crank.at(0.4, 0), rod(-0.6, 0))
    model.revolute("C", rod(0.6, 0), slider.at(0, 0))
    model.translational("guide", model.ground.at(0, 0), slider.at(0, 0))
    model.driver("drive", crank.phi, 0.3 + 5 * t + t**2)
    model.force("load", slider.at(0, 0), -20.0, 0.0)
    guess = {"crank.phi": 0.3, "crank.x": 0.0, "slider.x": 0.97}
    model.scene("kinematics", drivers=["drive"], analysis="kinematics", guess=guess)
    model.scene("driven", drivers=["drive"], effects=["gravity", "load"], guess=guess)
    start = {"crank.phi": 0.3, "crank.omega": 6.0}
    model.scene("run", effects=["gravity", "load"], start=start, guess={"slider.x": 0.97})
    return model


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., tuple[Machine, Machine]]:
    """(turned, plain) of a model's scene."""
    folder = tmp_path_factory.mktemp("turned")

    @cache
    def loaded(declared: Callable[[bool], Model], scene: str) -> tuple[Machine, Machine]:
        turned, plain = (load(declared(kind), scene, folder=folder) for kind in (True, False))
        return turned, plain

    return loaded


def places(run: Result, body: str, turned: bool) -> np.ndarray:
    """(x, y, cos φ, sin φ) of the centre of mass, samples × 4."""
    x, y = run.q(f"{body}.x"), run.q(f"{body}.y")
    if not turned:
        phi = run.q(f"{body}.phi")
        return np.stack([x, y, np.cos(phi), np.sin(phi)], axis=1)
    e0, e1 = run.q(f"{body}.e0"), run.q(f"{body}.e1")
    assert_allclose(e0**2 + e1**2, 1.0, rtol=0, atol=1e-12)
    c, s = e0**2 - e1**2, 2 * e0 * e1
    cx, cy = CENTRE
    return np.stack([x + cx * c - cy * s, y + cx * s + cy * c, c, s], axis=1)


def assert_same_motion(turned: Result, plain: Result, bodies: str, within: float = SAME) -> None:
    assert (turned.outcome, plain.outcome) == (Outcome.OK, Outcome.OK)
    for body in bodies.split():
        got, expected = places(turned, body, True), places(plain, body, False)
        assert_allclose(got, expected, rtol=0, atol=within)


def assert_same_reactions(turned: Result, plain: Result, joints: str) -> None:
    """Forces; in global axes, as the axes of the first body may be those of either kind."""
    for joint in joints.split():
        for part in ("fx", "fy"):
            expected = plain.reaction(joint, part)
            size = max(1.0, np.abs(expected).max())
            assert_allclose(turned.reaction(joint, part), expected, rtol=0, atol=SAME * size)


def test_a_double_pendulum_moves_alike(pair: Callable[..., tuple[Machine, Machine]]) -> None:
    machines = pair(double_pendulum, "fall")
    grid = np.linspace(0.0, 2.0, 41)
    turned, plain = (m.simulate(2.0, grid, **EXACT) for m in machines)
    assert_same_motion(turned, plain, "a b")
    assert_same_reactions(turned, plain, "A B")
    drift = [run.energy() - run.energy()[0] for run in (turned, plain)]
    assert_allclose(drift[0], drift[1], rtol=0, atol=1e-8)


@pytest.mark.parametrize("method", ["radau5", "bdf"])
def test_implicit_methods_take_its_derivatives(
    pair: Callable[..., tuple[Machine, Machine]], method: str
) -> None:
    machines = pair(double_pendulum, "fall")
    grid = np.linspace(0.0, 1.0, 11)
    turned = machines[0].simulate(1.0, grid, method=method, rtol=1e-9, progress=False)
    plain = machines[1].simulate(1.0, grid, **EXACT)
    assert_same_motion(turned, plain, "a b", within=2e-6)


@pytest.mark.parametrize("scene", [(double_pendulum, "fall", "a b"), (slider_crank, "run", "rod")])
def test_reduced_coordinates(
    pair: Callable[..., tuple[Machine, Machine]], scene: tuple[Any, str, str]
) -> None:
    declared, name, bodies = scene
    machines = pair(declared, name)
    grid = np.linspace(0.0, 0.5, 11)
    turned = machines[0].simulate(0.5, grid, formulation="reduced", **EXACT)
    plain = machines[1].simulate(0.5, grid, **EXACT)
    assert_same_motion(turned, plain, bodies)


def test_it_is_assembled_from_the_neutral_pose(
    pair: Callable[..., tuple[Machine, Machine]],
) -> None:
    machine, _ = pair(slider_crank, "run")
    assembled = machine.assemble()
    q = dict(zip(machine.coordinates.names, assembled.q, strict=True))
    assert q["rod.e0"] ** 2 + q["rod.e1"] ** 2 == pytest.approx(1.0, abs=1e-14)
    assert q["rod.e0"] > 0.9
    assert max(assembled.residual.values()) < 1e-12


def test_a_slider_crank_runs_alike(pair: Callable[..., tuple[Machine, Machine]]) -> None:
    machines = pair(slider_crank, "run")
    grid = np.linspace(0.0, 1.0, 41)
    turned, plain = (m.simulate(1.0, grid, **EXACT) for m in machines)
    assert_same_motion(turned, plain, "rod")
    assert_same_reactions(turned, plain, "A B guide")
    assert_allclose(turned.energy(), plain.energy(), rtol=SAME)


def test_kinematics_and_inverse_dynamics(pair: Callable[..., tuple[Machine, Machine]]) -> None:
    grid = np.linspace(0.0, 1.0, 41)
    turned, plain = (m.kinematics(grid) for m in pair(slider_crank, "kinematics"))
    assert_same_motion(turned, plain, "rod")
    assert_allclose(turned.a("slider.x"), plain.a("slider.x"), rtol=0, atol=1e-9)
    turned, plain = (m.inverse_dynamics(grid) for m in pair(slider_crank, "driven"))
    assert_same_motion(turned, plain, "rod")
    assert_same_reactions(turned, plain, "A B guide")
    torque = plain.reaction("drive", "torque")
    assert_allclose(turned.reaction("drive", "torque"), torque, rtol=0, atol=1e-9)


def test_equilibrium(pair: Callable[..., tuple[Machine, Machine]]) -> None:
    turned, plain = (m.equilibrium() for m in pair(double_pendulum, "rest"))
    assert (turned.outcome, plain.outcome) == (Outcome.OK, Outcome.OK)
    for body in "ab":
        sine = 2 * turned.q(f"{body}.e0") * turned.q(f"{body}.e1")
        assert sine == pytest.approx(np.sin(plain.q(f"{body}.phi")), abs=1e-8)
