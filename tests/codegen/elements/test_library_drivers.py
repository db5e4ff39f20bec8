"""The library's drivers against Haug's formulas by hand; what they exert, and the power of it."""

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from pint import get_application_registry

from codegen import Model, t
from tests.codegen.elements.hand.drivers import DRIVERS
from tests.codegen.elements.hand.pair import (
    AXIS,
    SI,
    SJ,
    UNIT,
    balance,
    closed,
    moment,
    place,
    reactions,
    span,
)
from tests.codegen.workbench import A, Interpreted, State, library_kinds

TOLERANCE = {"rtol": 1e-12, "atol": 1e-12}
TWO_BODIES = [kind for kind in DRIVERS if not kind.startswith("point")]
COMPONENT = {"x": ("fx", "N"), "y": ("fy", "N"), "phi": ("torque", "N m")}


def declare(kind: str, model: Model, i: object, j: object, law: sympy.Expr) -> None:
    a, b = i.at(*SI), j.at(*SJ)
    word, _, letter = kind.partition("_")
    if word == "point":
        model.point_driver("drive", b, letter, law)
    elif word == "relative":
        model.relative_driver("drive", a, b, letter, law)
    elif kind == "rotation":
        model.rotation_driver("drive", i, j, law)
    elif kind == "translation":
        model.translation_driver("drive", a, b, law, axis=tuple(AXIS))
    else:
        model.distance_driver("drive", a, b, law)


def pair(kind: str, ground: bool = False, pushed: bool = False) -> Interpreted:
    """Bodies apart by a law 1.5 + 0.4 sin(speed t), one of them pushed."""
    model = Model("pair")
    first = model.ground if ground else model.body("first", mass=2.0, inertia=0.5)
    second = model.body("second", mass=3.0, inertia=0.7)
    speed = model.parameter("speed", 3.0, unit="rad/s")
    declare(kind, model, first, second, 1.5 + 0.4 * sympy.sin(speed * t))
    if pushed:
        model.force("push", second.at(0.4, 0.2), fx=7.0, fy=-5.0)
        model.torque("twist", second, 6.0)
    return Interpreted(model)


def test_every_kind_has_a_formula() -> None:
    """But `driver`, of any expression, whose formulas are in `test_constraints`."""
    tabled = {"driver"}
    for name in DRIVERS:
        model = Model("pair")
        declare(name, model, *(model.body(n, 1.0, 1.0) for n in "ij"), t)
        tabled.add(model.drivers["drive"].kind)
    assert tabled == library_kinds("driver"), "add the kind to DRIVERS and to declare()"


def law(time: float) -> tuple[float, float, float]:
    """The law of `pair` and its rates."""
    z, c = np.sin(3 * time), np.cos(3 * time)
    return 1.5 + 0.4 * z, 1.2 * c, -3.6 * z


@pytest.mark.parametrize("ground", [False, True], ids=["bodies", "ground"])
@pytest.mark.parametrize("kind", DRIVERS)
def test_driver_is_haugs(kind: str, ground: bool) -> None:
    machine = pair(kind, ground)
    for seed in range(5):
        s = machine.state(seed)
        driven, on_i, on_j, gamma = DRIVERS[kind](s, *((None, 0) if ground else (0, 1)))
        value, rate, bend = law(s.t)
        assert_allclose(machine.vector("constraints", s), [driven - value], **TOLERANCE)
        rows = on_j if ground else np.hstack([on_i, on_j])
        assert_allclose(machine.jacobian(s), rows, **TOLERANCE)
        assert_allclose(machine.vector("velocity_rhs", s), [rate], **TOLERANCE)
        expected = np.ravel(gamma) + bend
        assert_allclose(machine.vector("acceleration_rhs", s), expected, **TOLERANCE)


def direction(kind: str, s: State) -> np.ndarray:
    """Along what the driver pushes."""
    if kind.endswith(("_x", "_y")):
        return np.eye(2)["xy".index(kind[-1])]
    if kind == "translation":
        return A(s.body(0)[1]) @ UNIT
    d = span(s, 0, 1)[0]
    return d / np.linalg.norm(d)


@pytest.mark.parametrize("kind", DRIVERS)
@pytest.mark.parametrize("seed", range(3))
def test_driver_exerts_what_it_reports(kind: str, seed: int) -> None:
    """The reported force along its direction, or torque, is what the bodies get; and its power."""
    machine = pair(kind, pushed=True)
    s = closed(machine, seed)
    a, lam = machine.solution(s)
    forces = machine.mass(s) @ a - machine.vector("applied_forces", s)
    size = np.abs(forces).max()
    assert size > 0.1
    letter = kind.rpartition("_")[2]
    component = COMPONENT.get("phi" if kind == "rotation" else letter, ("force", "N"))
    assert machine.lowered.description.reactions == (("drive", *component),)
    exerted = reactions(machine, s)["drive", component[0]]
    given = np.zeros(6)
    if component[0] == "torque":
        given[[2, 5]] = -exerted, exerted
    else:
        force = exerted * direction(kind, s)
        second = place(s, 1, SJ)
        first = second if kind == "translation" else place(s, 0, SI)
        for k, point, sign in ((0, first, -1), (3, second, 1)):
            given[k : k + 2] = sign * force
            given[k + 2] = sign * moment(point - s.q[k : k + 2], force)
    if kind not in TWO_BODIES:
        given[:3] = 0.0
    assert_allclose(given, forces, rtol=1e-9, atol=1e-11 * size)
    rate = law(s.t)[1]
    powers = dict(
        zip(
            [name for name, _ in machine.lowered.description.powers],
            machine.vector("powers", s, lam=lam),
            strict=True,
        )
    )
    assert_allclose(powers["drive"], exerted * rate, rtol=1e-12)
    assert_allclose(forces @ s.v, exerted * rate, rtol=1e-9, atol=1e-11 * size)


@pytest.mark.parametrize("kind", ["relative_phi", "rotation", "translation", "distance"])
def test_driver_between_floating_bodies_is_an_inner_force(kind: str) -> None:
    machine = pair(kind, pushed=True)
    s = closed(machine, 4)
    a, _ = machine.solution(s)
    forces = machine.mass(s) @ a - machine.vector("applied_forces", s)
    push, turning = balance(s, forces)
    assert_allclose([*push, turning], 0, atol=1e-11 * np.abs(forces).max())


def test_slider_passes_the_origin_of_its_guide() -> None:
    """A way along a line is regular at 0, and its driver pushes along the line there too."""
    model = Model("slider")
    block = model.body("block", mass=2.0, inertia=1.0)
    model.translational("guide", model.ground, block, axis=(3, 4))
    model.translation_driver("stroke", model.ground, block, sympy.sin(t) + t**2, axis=(3, 4))
    machine = Interpreted(model)
    s = State(t=0.0, q=np.zeros(3), v=np.array([0.6, 0.8, 0.0]))
    a, _ = machine.solution(s)
    assert_allclose(a, [1.2, 1.6, 0.0], atol=1e-14)
    assert_allclose(reactions(machine, s)["stroke", "force"], 4.0, rtol=1e-14)


def test_laws_may_have_units() -> None:
    unit = get_application_registry()
    model = Model("units")
    a, b = (model.body(n, mass=1.0, inertia=1.0) for n in "ab")
    model.distance_driver("cylinder", a, b, unit.Quantity(250, "mm"))
    model.rotation_driver("motor", a, b, unit.Quantity(180, "degree"))
    model.point_driver("lift", b.at(unit.Quantity(10, "cm"), 0), "y", unit.Quantity(2, "km"))
    model.scene("driven", drivers=["cylinder", "motor", "lift"])
    s = State(t=0.0, q=np.array([0.0, 0, 0, 3, 4, 0]), v=np.zeros(6))
    found = Interpreted(model, "driven").vector("constraints", s)
    assert_allclose(found, [5.0 - 0.25, -np.pi, 4.0 - 2000.0], rtol=1e-14)
