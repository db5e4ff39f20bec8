"""The library's joints against Haug's formulas by hand, and their reactions against mechanics."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pint import get_application_registry

from codegen import Body, Model, Point
from codegen.reference.pages import example_of
from tests.codegen.elements.hand.joints import (
    ANGLE,
    JOINTS,
    LENGTH,
    LINE,
    OFFSET,
    RADII,
    VALUE,
    line_of_centres,
)
from tests.codegen.elements.hand.pair import (
    AXIS,
    SI,
    SJ,
    balance,
    closed,
    moment,
    place,
    reactions,
    span,
)
from tests.codegen.workbench import A, Interpreted, State, library_kinds

TOLERANCE = {"rtol": 1e-12, "atol": 1e-12}
GLOBAL = ("relative_x", "relative_y")
Declare = Callable[[Model, str, Point, Point], object]
Angle = Callable[[State], float]


def of_axis(s: State) -> float:
    """Angle of the axis AXIS of the first body."""
    return float(s.body(0)[1] + np.arctan2(AXIS[1], AXIS[0]))


def of_rack(s: State) -> float:
    """Angle of the rack's axis; the rack is the second body."""
    return float(s.body(1)[1] + np.arctan2(AXIS[1], AXIS[0]))


def of_span(s: State) -> float:
    """Angle of the line from point to point."""
    d = span(s, 0, 1)[0]
    return float(np.arctan2(d[1], d[0]))


def relative(letter: str) -> tuple[Declare, Angle]:
    return lambda m, *pair: m.relative(*pair, letter, VALUE), lambda s: 0.0


def geared(kind: str) -> tuple[Declare, Angle]:
    return (
        lambda m, *pair: m.gear(*pair, *RADII[kind], line=LINE),
        lambda s: line_of_centres(s, 0, 1, kind),
    )


DECLARATIONS: dict[str, tuple[Declare, Angle]] = {
    "relative_x": relative("x"),
    "relative_y": relative("y"),
    "relative_phi": relative("phi"),
    "distance": (lambda m, *pair: m.distance(*pair, LENGTH), of_span),
    "revolute_revolute": (lambda m, *pair: m.revolute_revolute(*pair, LENGTH), of_span),
    "revolute": (lambda m, *pair: m.revolute(*pair), lambda s: s.body(0)[1]),
    "translational": (
        lambda m, *pair: m.translational(*pair, axis=tuple(AXIS), angle=ANGLE),
        of_axis,
    ),
    "revolute_translational": (
        lambda m, *pair: m.revolute_translational(*pair, axis=tuple(AXIS), distance=VALUE),
        of_axis,
    ),
    "weld": (lambda m, *pair: m.weld(*pair, angle=ANGLE), lambda s: s.body(0)[1]),
    "gear": geared("gear"),
    "internal": geared("internal"),
    "rack_and_pinion": (
        lambda m, *pair: m.rack_and_pinion(*pair, LENGTH, axis=tuple(AXIS), offset=OFFSET),
        of_rack,
    ),
}
"""The joint of each kind of `JOINTS` with the numbers of its formula, the angle of its x axis."""


ELSEWHERE = {
    **dict.fromkeys(("absolute", "constraint"), "test_constraints"),
    **dict.fromkeys(("revolute", "revolute-revolute", "translational"), "test_library_joints"),
    **dict.fromkeys(("cam and flat-faced follower", "cam and follower"), "test_cams"),
    "point follower": "test_cams",
    **dict.fromkeys(("belt", "rolling disc", "screw"), "test_transmissions"),
}
"""Kinds that a file of this folder has formulas or machines for."""


def test_every_formula_has_a_declaration() -> None:
    assert list(DECLARATIONS) == list(JOINTS)


def test_every_kind_has_a_formula_and_a_machine(root: Path) -> None:
    tabled = set()
    for name in DECLARATIONS:
        model = Model("pair")
        declare(name, model, *(model.body(n, 1.0, 1.0) for n in "ij"))
        tabled.add(model.joints["joint"].kind)
    assert tabled | {*ELSEWHERE} == library_kinds("joint"), (
        "add the kind to DECLARATIONS, or to ELSEWHERE"
    )
    files = dict.fromkeys(tabled, "machines/test_library_joints")
    for kind, file in (files | {k: f"codegen/elements/{f}" for k, f in ELSEWHERE.items()}).items():
        text = (root / "tests" / f"{file}.py").read_text(encoding="utf-8")
        (method,) = example_of(kind).methods
        assert f".{method}(" in text, f"tests/{file}.py lacks a machine with '{kind}'"


def declare(kind: str, model: Model, i: Body, j: Body) -> None:
    DECLARATIONS[kind][0](model, "joint", i.at(*SI), j.at(*SJ))


def two_bodies(kind: str, ground: str = "") -> Interpreted:
    model = Model("pair")
    first = model.ground if ground == "first" else model.body("first", mass=2.0, inertia=0.5)
    second = model.ground if ground == "second" else model.body("second", mass=3.0, inertia=0.7)
    declare(kind, model, first, second)
    return Interpreted(model)


@pytest.mark.parametrize("ground", ["", "first", "second"])
@pytest.mark.parametrize("kind", JOINTS)
def test_joint_is_haugs(kind: str, ground: str) -> None:
    machine = two_bodies(kind, ground)
    numbers = {"": (0, 1), "first": (None, 0), "second": (0, None)}[ground]
    for seed in range(5):
        s = machine.state(seed)
        phi, on_i, on_j, gamma = JOINTS[kind](s, *numbers)
        sides = [rows for k, rows in zip(numbers, (on_i, on_j), strict=True) if k is not None]
        assert_allclose(machine.vector("constraints", s), phi, **TOLERANCE)
        assert_allclose(machine.jacobian(s), np.hstack(sides), **TOLERANCE)
        assert_allclose(machine.vector("acceleration_rhs", s), gamma, **TOLERANCE)
        assert_allclose(machine.vector("velocity_rhs", s), 0 * gamma, atol=0)


# -- reactions -----------------------------------------------------------------------------------


def pushed_pair(kind: str, seed: int) -> tuple[Interpreted, State, np.ndarray]:
    """Two bodies that float and are pushed, and the generalized forces of the joint on them."""
    model = Model("pair")
    first, second = (model.body(n, mass=m, inertia=m / 4) for n, m in (("a", 2.0), ("b", 3.0)))
    declare(kind, model, first, second)
    model.force("push", first.at(0.4, 0.2), fx=7.0, fy=-5.0)
    model.torque("twist", second, 6.0)
    machine = Interpreted(model)
    s = closed(machine, seed)
    a, lam = machine.solution(s)
    forces = machine.mass(s) @ a - machine.vector("applied_forces", s)
    assert np.abs(forces).max() > 0.1
    assert_allclose(forces, -machine.jacobian(s).T @ lam, rtol=1e-9, atol=1e-10)
    return machine, s, forces


@pytest.mark.parametrize("kind", JOINTS)
@pytest.mark.parametrize("seed", range(3))
def test_joint_takes_no_momentum_and_no_energy(kind: str, seed: int) -> None:
    _, s, forces = pushed_pair(kind, seed)
    size = np.abs(forces).max()
    push, turning = balance(s, forces)
    assert_allclose(push, 0, atol=1e-12 * size)
    assert_allclose(forces @ s.v, 0, atol=1e-11 * size)
    if kind not in GLOBAL:
        assert_allclose(turning, 0, atol=1e-11 * size)


@pytest.mark.parametrize("kind", JOINTS)
@pytest.mark.parametrize("seed", range(3))
def test_reaction_is_what_moves_the_bodies(kind: str, seed: int) -> None:
    """The reported force and torque, on the second body and reversed on the first: -Φ_qᵀ λ."""
    machine, s, forces = pushed_pair(kind, seed)
    found = reactions(machine, s)
    force = A(DECLARATIONS[kind][1](s)) @ [found["joint", "fx"], found["joint", "fy"]]
    torque = found["joint", "torque"]
    second = place(s, 0, SI) if kind == "rack_and_pinion" else place(s, 1, SJ)
    first = place(s, 0, SI) if kind in GLOBAL else second
    given = np.zeros(6)
    for k, point, sign in ((0, first, -1), (3, second, 1)):
        given[k : k + 2] = sign * force
        given[k + 2] = sign * (moment(point - s.q[k : k + 2], force) + torque)
    assert_allclose(given, forces, rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("kind", ["gear", "internal"])
def test_teeth_push_across_the_line_of_centres(kind: str) -> None:
    """With the centres at the distance of the radii, the force acts at the pitch point."""
    model = Model("train")
    first, second = (model.body(n, mass=1.0, inertia=0.2) for n in ("first", "second"))
    ri, rj = RADII[kind]
    model.revolute("A", model.ground.at(0, 0), first)
    model.revolute("B", model.ground.at(0, abs(ri + rj)), second)
    model.gear("mesh", first, second, ri, rj, line=np.pi / 2)
    model.torque("motor", first, 3.0)
    machine = Interpreted(model)
    s = State(t=0.0, q=np.array([0, 0, 0, 0, abs(ri + rj), 0.0]), v=np.zeros(6))
    a, _ = machine.solution(s)
    assert_allclose(a[5], -ri / rj * a[2], rtol=1e-12)
    assert_allclose(a[2], 3.0 / (0.2 + 0.2 * (ri / rj) ** 2), rtol=1e-12)
    found = reactions(machine, s)
    tooth = found["mesh", "fy"]
    assert_allclose(found["mesh", "fx"], 0, atol=1e-12)
    assert_allclose(found["mesh", "torque"], 0.2 * a[5], rtol=1e-12)
    # From centre j the pitch point lies back towards i, but for an internal gear j: beyond i.
    assert_allclose(found["mesh", "torque"], -abs(rj) * tooth, rtol=1e-12)
    assert_allclose(abs(tooth * ri), 3.0 - 0.2 * a[2], rtol=1e-12)


@pytest.mark.parametrize(
    ("given", "expected"), [({}, 0.0), ({"pinned": True}, np.pi / 2), ({"line": 0.3}, 0.3)]
)
def test_gears_mesh_as_they_are_mounted(given: dict[str, object], expected: float) -> None:
    """All angles 0 is a position of the train, wherever its bearings are."""
    model = Model("train")
    arm, first, second = (model.body(n, mass=1.0, inertia=1.0) for n in ("arm", "one", "two"))
    if given.pop("pinned", False):
        model.revolute("A", model.ground.at(1, 1), first)
        model.revolute("B", model.ground.at(1, 1), arm)
        model.revolute("C", second, arm.at(0, 3))
    gear = model.gear("mesh", first, second, 1, 2, **given)
    (line,) = (v for k, v in gear.statement().bindings.items() if str(k) == "line")
    assert float(line) == pytest.approx(expected, abs=1e-15)


def test_pinion_drives_the_rack_by_its_teeth() -> None:
    model = Model("steering")
    pinion, rack = (model.body(n, mass=2.0, inertia=0.1) for n in ("pinion", "rack"))
    model.revolute("axle", model.ground.at(0, 0.25), pinion)
    model.rack_and_pinion("mesh", pinion, rack, 0.25)
    model.absolute("level", rack, "phi", 0.0)
    model.torque("motor", pinion, 1.5)
    machine = Interpreted(model)
    s = State(t=0.0, q=np.array([0, 0.25, 0, 0, 0, 0.0]), v=np.zeros(6))
    a, _ = machine.solution(s)
    assert_allclose(a[2], 1.5 / (0.1 + 2.0 * 0.25**2), rtol=1e-12)
    assert_allclose(a[3], 0.25 * a[2], rtol=1e-12)
    found = reactions(machine, s)
    assert_allclose(found["mesh", "fx"], 2.0 * a[3], rtol=1e-12)
    assert_allclose(found["mesh", "torque"], 0.25 * found["mesh", "fx"], rtol=1e-12)


# -- scenes and units -----------------------------------------------------------------------------


def test_slot_stands_for_its_block() -> None:
    model = Model("slot")
    arm, block, pin = (model.body(n, mass=1.0, inertia=1.0) for n in ("arm", "block", "pin"))
    model.translational("guide", arm, block)
    model.revolute("axle", block, pin)
    model.revolute_translational("slot", arm, pin, instead_of=block)
    model.scene("full")
    model.scene("short", without=[block])
    names = {n: [c.name for c in Interpreted(model, n).equations.constraints] for n in model.scenes}
    assert names == {"full": ["guide", "axle"], "short": ["slot"]}


def test_lengths_and_angles_may_have_units() -> None:
    model = Model("units")
    a, b = (model.body(n, mass=1.0, inertia=1.0) for n in "ab")
    unit = get_application_registry()
    bound = [
        model.distance("d", a, b, unit.Quantity(1700, "mm")),
        model.relative("r", a, b, "phi", unit.Quantity(90, "degree")),
        model.revolute_translational("t", a, b, distance=unit.Quantity(5, "cm")),
        model.weld("w", a, b, angle=unit.Quantity(180, "degree")),
        model.gear("g", a, b, unit.Quantity(20, "mm"), unit.Quantity(40, "mm")),
        model.rack_and_pinion("p", a, b, unit.Quantity(30, "mm"), offset=unit.Quantity(1, "cm")),
    ]
    assert model.problems == ()
    assert {joint.kind for joint in bound} == library_kinds("joint") - {*ELSEWHERE}
    numbers = {
        (joint.name, str(k)): float(v)
        for joint in bound
        for k, v in joint.statement().bindings.items()
        if v.is_number
    }
    expected = {("d", "length"): 1.7, ("r", "value"): np.pi / 2, ("t", "distance"): 0.05}
    expected |= {("w", "angle"): np.pi, ("g", "share_i"): 1 / 3, ("g", "share_j"): 2 / 3}
    expected |= {("p", "radius"): 0.03, ("p", "offset"): 0.01}
    assert {k: numbers[k] for k in expected} == pytest.approx(expected, rel=1e-14)
