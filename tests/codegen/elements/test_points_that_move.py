"""Points that move in their bodies by themselves: every force has their motion, or refuses them.

Forces are compared with those by hand, f along a scalar s(t, q) written out for plain numbers; its
rate and slopes are taken by complex steps along the motion.
"""

import cmath
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.declare.body import Body, Point
from codegen.elements.registry import kinds_of_elements
from tests.codegen.workbench import Interpreted, along, complex_step, library_kinds

EXACT = {"rtol": 1e-10, "atol": 1e-11}
K, C, FREE, AXIS, DEPTH = 3.0, 0.7, 0.4, np.array([0.6, 0.8]), 5.0
Build = Callable[[Model, Point, Point], object]
Number = Any
Places = tuple[np.ndarray, np.ndarray, Number, Number]  # r_i^P, r_j^P, φ_i, φ_j


def places_of(time: Number, q: np.ndarray) -> Places:
    """The two points of `moving_pair`: one oscillates in its body, one follows its partner."""
    own_i = np.array([0.2 + 0.3 * cmath.sin(5 * time), -0.1 * time**2])
    own_j = np.array([-0.5 + 0.25 * q[0] ** 2, 0.4 + 0.1 * time * q[1]])
    ends = []
    for (x, y, phi), (a, b) in ((q[:3], own_i), (q[3:], own_j)):
        c, s = cmath.cos(phi), cmath.sin(phi)
        ends.append(np.array([x + c * a - s * b, y + s * a + c * b]))
    return ends[0], ends[1], q[2], q[5]


def moving_pair(name: str) -> tuple[Model, Point, Point, Body]:
    model = Model(name)
    i, j = (model.body(word, mass=m, inertia=0.7) for word, m in (("first", 2.0), ("other", 3.0)))
    at_i = i.at(0.2 + 0.3 * sympy.sin(5 * t), -0.1 * t**2)
    return model, at_i, j.at(-0.5 + 0.25 * i.x**2, 0.4 + 0.1 * t * i.y), j


def length(time: Number, q: np.ndarray) -> Number:
    i, j, *_ = places_of(time, q)
    return cmath.sqrt((j - i) @ (j - i))


def gap(time: Number, q: np.ndarray) -> Number:
    i, j, phi, _ = places_of(time, q)
    c, s = cmath.cos(phi), cmath.sin(phi)
    return np.array([c * AXIS[0] - s * AXIS[1], s * AXIS[0] + c * AXIS[1]]) @ (j - i)


def crossways(time: Number, q: np.ndarray) -> Number:
    i, j, phi, _ = places_of(time, q)
    c, s = cmath.cos(phi), cmath.sin(phi)
    return np.array([-s, c]) @ (j - i)


def lengthways(time: Number, q: np.ndarray) -> Number:
    i, j, phi, _ = places_of(time, q)
    return np.array([cmath.cos(phi), cmath.sin(phi)]) @ (j - i)


LAWS: dict[str, tuple[Build, list[tuple[Callable[..., Number], Callable[..., Number]]]]] = {
    "spring": (
        lambda m, i, j: m.spring("e", i, j, stiffness=K, free_length=FREE, damping=C),
        [(length, lambda s, v: K * (s - FREE) + C * v)],
    ),
    "spring with a law": (
        lambda m, i, j: m.spring("e", i, j, force=lambda s, v: K * s**2 + C * v**3),
        [(length, lambda s, v: K * s**2 + C * v**3)],
    ),
    "contact": (
        lambda m, i, j: m.contact(
            "e", i, j, stiffness=K, damping=C, direction=tuple(AXIS), free_length=DEPTH
        ),
        [(gap, lambda s, v: K * (s - DEPTH) + C * v)],
    ),
    "contact of discs": (
        lambda m, i, j: m.contact("e", i, j, stiffness=K, damping=C, free_length=DEPTH),
        [(length, lambda s, v: K * (s - DEPTH) + C * v)],
    ),
    "clearance joint": (
        lambda m, i, j: m.clearance_joint("e", i, j, 0.01, K, damping=C),
        [(length, lambda s, v: K * (s - 0.01) ** 1.5 * (1 + C * v))],
    ),
    "line force": (
        lambda m, i, j: m.line_force("e", i, j, lambda s, v: K * s**2 + C * v),
        [(length, lambda s, v: K * s**2 + C * v)],
    ),
    "bushing": (
        lambda m, i, j: m.bushing("e", i, j, stiffness=(K, 2 * K, 0), damping=(C, 3 * C, 0)),
        [(lengthways, lambda s, v: K * s + C * v), (crossways, lambda s, v: 2 * K * s + 3 * C * v)],
    ),
    "dry friction": (
        lambda m, i, j: m.dry_friction(
            "e", i, j, coefficient=0.5, normal=4.0, axis=tuple(AXIS), creep=2.0
        ),
        [(gap, lambda s, v: 0.5 * 4.0 * cmath.tanh(v / 2.0))],
    ),
    "rigid contact": (
        lambda m, i, j: m.contact(
            "e", i, j, restitution=0.5, typical_force=K, direction=tuple(AXIS)
        ),
        [(gap, lambda s, v: -K)],
    ),
}
"""Words → how the effect is declared, and (s, f(s, ṡ)) of the forces Q = -f s_q by hand."""

OTHERS = {"force", "mass flow", "tracked point"}
"""Kinds of forces at points that have tests of their own."""


def test_every_force_at_points_is_judged() -> None:
    """A row of `LAWS` each: a force that takes hold of a point has the motion of the point."""
    kinds = [kinds_of_elements()[name] for name in library_kinds("force")]
    at_points = {k.name for k in kinds if any(f.type is Point for f in fields(k.element))}
    assert at_points - {effect_of(word)[1] for word in LAWS} - OTHERS == set()


def effect_of(word: str) -> tuple[Model, str]:
    model, i, j, _ = moving_pair("moving")
    LAWS[word][0](model, i, j)
    (effect,) = model.effects.values()
    return model, effect.kind


@pytest.mark.parametrize("word", LAWS)
@pytest.mark.parametrize("seed", range(3))
def test_forces_have_the_motion_of_the_points(word: str, seed: int) -> None:
    machine = Interpreted(effect_of(word)[0])
    s = machine.state(seed, t=0.3 + 0.2 * seed)
    modes = [0 if word == "rigid contact" else 1] * machine.s
    expected = np.zeros(machine.n)
    for scalar, force in LAWS[word][1]:
        slopes = complex_step(lambda q, x=scalar: np.array([x(s.t, q)]), s.q)[0]
        rate = along(lambda h, x=scalar: x(s.t + h, s.q + h * s.v))
        expected -= force(scalar(s.t, s.q), rate).real * slopes
    found = machine.vector("applied_forces", s, modes=modes)
    assert_allclose(found, expected, **EXACT)
    # All of it does work, for no energy is stored in what moves by itself.
    if "powers" in machine.lowered.kernels:
        powers = machine.vector("powers", s, modes=modes, lam=[])
        assert_allclose(powers, [expected @ s.v], **EXACT)
        assert machine.vector("potential", s, modes=modes) == 0.0


@pytest.mark.parametrize("word", ["contact", "rigid contact"])
def test_gaps_change_with_the_motion_of_the_points(word: str) -> None:
    machine = Interpreted(effect_of(word)[0])
    s = machine.state(4)
    a = np.linspace(-1.0, 2.0, machine.n)
    rates = machine.vector("switching_rates", s, a=a)
    expected = along(lambda h: gap(s.t + h, s.q + h * s.v + h * h / 2 * a))
    assert_allclose(abs(rates), [abs(expected)], **EXACT)
    if word == "rigid contact":
        h = 1e-4
        ahead, now, behind = (
            gap(s.t + k, s.q + k * s.v + k * k / 2 * a).real for k in (h, 0.0, -h)
        )
        second = machine.vector("gap_accelerations", s, a=a)
        assert_allclose(second, [(ahead - 2 * now + behind) / h**2], rtol=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_velocities_of_points(seed: int) -> None:
    model, i, j, _ = moving_pair("speeds")
    s = Interpreted(model).state(seed)
    numbers = dict(zip((q for b in model.bodies.values() for q in b.coordinates), s.q, strict=True))
    numbers |= {q.rate: v for q, v in zip(numbers, s.v, strict=True)} | {t: s.t}
    for k, point in enumerate((i, j)):
        expected = along(lambda h, k=k: places_of(s.t + h, s.q + h * s.v)[k])
        found = [float(v.subs(numbers)) for v in (point.vx, point.vy)]
        assert_allclose(found, expected, **EXACT)


def test_an_applied_force_acts_where_the_point_is() -> None:
    model, _, j, _ = moving_pair("pushed")
    model.force("e", on=j, fx=2.0, fy=-1.0)
    machine = Interpreted(model)
    s = machine.state(1)
    _, place, *_ = places_of(s.t, s.q)
    dx, dy = (place - s.q[3:5]).real
    assert_allclose(machine.vector("applied_forces", s), [0, 0, 0, 2, -1, -dx - 2 * dy], **EXACT)


def gravity_that_varies(model: Model, body: Body) -> None:
    model.gravity("e", (sympy.sin(t), -9.81))


def potential_that_varies(model: Model, body: Body) -> None:
    model.potential("e", K * (body.x - sympy.sin(t)) ** 2 + sympy.Abs(body.y - t))


@pytest.mark.parametrize("declare", [gravity_that_varies, potential_that_varies])
def test_a_potential_that_depends_on_the_time_does_work(declare: Any) -> None:
    model = Model("varying")
    declare(model, model.body("body", mass=2.0, inertia=1.0))
    machine = Interpreted(model)
    s = machine.state(2)
    q = machine.vector("applied_forces", s)
    assert np.abs(q).max() > 0.1
    assert_allclose(machine.vector("powers", s, lam=[]), [q @ s.v], **EXACT)
    assert machine.vector("potential", s) == 0.0
