"""What tools get of machines in space is what the library declares, and closes where it has to."""

from importlib import import_module
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import sympify

from benchmarks.contest import PEERS, SPACE
from benchmarks.linkwright_runs import ENTRIES
from benchmarks.problems import PROBLEMS
from benchmarks.space_machines import ARM, BRICARD, Chain, Platform, SliderCrank, X


def declared(name: str) -> Any:
    return import_module(f"models.space.{name}").model


def numbers(model: Any, values: Any) -> Any:
    """Expressions with the parameters' values."""
    values = sympify(values)
    known = {p: model.parameters[p.name].value for p in values.free_symbols}
    return np.array(values.subs(known), dtype=float)


def attitude(body: Any) -> Any:
    """The rotation matrix at the drawing."""
    e0, *vector = map(float, body.attitude)
    e = np.array(vector)
    across = np.cross(np.eye(3), e)
    return np.eye(3) + 2.0 * e0 * across + 2.0 * across @ across


def same_body(model: Any, name: str, mass: float, centre: Any, inertia: Any) -> None:
    """Mass, place, and inertia in global axes at the drawing."""
    body = model.bodies[name]
    turn = attitude(body)
    about = turn @ numbers(model, body.inertia) @ turn.T
    assert_allclose(float(numbers(model, body.mass)), mass, rtol=1e-15)
    assert_allclose(np.array(body.place, float), centre, atol=1e-15)
    assert_allclose(about, inertia, atol=1e-15)


@pytest.mark.parametrize(("name", "chain"), [("bricard", BRICARD), ("six_revolute_arm", ARM)])
def test_chains_have_the_bodies_and_hinges_of_the_library(name: str, chain: Chain) -> None:
    model = declared(name)
    assert [*model.bodies] == [link.name for link in chain.links]
    hinges = [(link.hinge, link.axis) for link in chain.links]
    hinges += [chain.closing] if chain.closing else []
    assert len(model.joints) == len(hinges)
    for link in chain.links:
        same_body(model, link.name, link.mass, link.centre, np.diag(link.moments))
    for joint, (at, axis) in zip(model.joints.values(), hinges, strict=True):
        assert_allclose(np.array(joint.axes[-1], float), axis, atol=1e-15)
        for end in (joint.i, joint.j):
            origin = np.array(getattr(end.body, "place", (0, 0, 0)), float)
            point = np.array([end.sx, end.sy, end.sz], float)
            assert_allclose(origin + point, at, atol=1e-15)


def test_the_slider_crank_is_that_of_the_library_and_moves_on_its_constraints() -> None:
    s, model = SliderCrank, declared("spatial_slider_crank")
    same_body(model, "crank", s.crank[0], s.A, np.diag(s.crank[1]))
    same_body(model, "rod", s.rod[0], s.middle, s.rod_inertia())
    same_body(model, "slider", s.slider[0], s.C, np.diag(s.slider[1]))
    A, B, C, across = map(np.array, (s.A, s.B, s.C, s.across))
    along, about, bend, turning = s.rates
    assert_allclose([C - B, 0.5 * (B + C)], [0.3 * np.array(s.along), s.middle], atol=1e-15)
    pin = np.cross(turning * np.array(X), B - A)
    rod = about * np.array(X) + bend * across
    assert_allclose(along * np.array(X) + np.cross(rod, B - C), pin, atol=1e-15)
    assert_allclose([across @ X, across @ (C - B)], 0.0, atol=1e-15)
    assert dict(model.scenes["free"].start)["A.rate"] == turning


def test_the_platform_is_that_of_the_library() -> None:
    p, model = Platform, declared("stewart_platform")
    same_body(model, "plate", p.mass, (0.0, 0.0, p.height), np.diag(p.moments))
    for k, (base, on) in enumerate(p.legs(), 1):
        strut = model.effects[f"strut_{k}"]
        for point, at in ((strut.i, base), (strut.j, on)):
            assert_allclose(np.array([point.sx, point.sy, point.sz], float), at, atol=1e-15)
        assert strut.free_length == pytest.approx(p.rest, rel=1e-15)
        assert float(numbers(model, strut.stiffness)) == p.stiffness


def test_problems_in_space_have_entries_and_tools() -> None:
    for name in SPACE:
        assert len(ENTRIES[name].angles) == len(PROBLEMS[name].reference) == 3
        assert PROBLEMS[name].unit == "m"
        assert {n for n, peer in PEERS.items() if name in peer.problems} == {
            "exudyn",
            "mujoco",
            "pinocchio",
        }
