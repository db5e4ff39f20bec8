"""Springs, contacts and bushings against forces written by hand; their energy and momentum."""

import cmath
from pathlib import Path

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from pint import get_application_registry

from codegen import Model, t
from codegen.declare.body import Body
from codegen.reference.pages import example_of
from tests.codegen.workbench import A, B, Interpreted, State, complex_step, library_kinds

TOLERANCE = {"rtol": 1e-11, "atol": 1e-12}
S_I, S_J = np.array([0.3, -0.2]), np.array([-0.5, 0.4])
SEEDS = range(5)

NO_FORMULAS = ("bad", "every", "library_joints", "library_drivers", "optional")


def test_every_kind_has_a_formula(root: Path) -> None:
    """Some test of this folder compares the forces of the kind with numbers of its own."""
    files = (root / "tests/codegen/elements").glob("test_*.py")
    texts = (f.read_text(encoding="utf-8") for f in files if not f.stem[5:].startswith(NO_FORMULAS))
    text = "".join(one for one in texts if "assert_allclose" in one)
    methods = {kind: example_of(kind).methods for kind in library_kinds("force")}
    assert not [kind for kind, (name,) in methods.items() if f".{name}(" not in text]


def pair(name: str = "pair") -> tuple[Model, Body, Body]:
    """Two free bodies."""
    model = Model(name)
    first = model.body("first", mass=2.0, inertia=0.7)
    return model, first, model.body("second", mass=3.0, inertia=1.1)


def ends(s: State) -> tuple[np.ndarray, np.ndarray]:
    """d and its rate for the points S_I and S_J of the two bodies."""
    r_i, phi_i, v_i, w_i = s.body(0)
    r_j, phi_j, v_j, w_j = s.body(1)
    d = r_j + A(phi_j) @ S_J - r_i - A(phi_i) @ S_I
    return d, v_j + B(phi_j) @ S_J * w_j - v_i - B(phi_i) @ S_I * w_i


def tsda(s: State, f: float) -> np.ndarray:
    """Haug's Q of a tension f between the two points."""
    (d, _), (_, phi_i, _, _), (_, phi_j, _, _) = ends(s), s.body(0), s.body(1)
    on_i = np.array([*d, (B(phi_i) @ S_I) @ d])
    on_j = np.array([*d, (B(phi_j) @ S_J) @ d])
    return f / np.linalg.norm(d) * np.concatenate([on_i, -on_j])


def momenta(machine: Interpreted, s: State, **more: object) -> np.ndarray:
    """Force on the pair, and moment about the origin: nothing where all of it is inner."""
    q = machine.vector("applied_forces", s, **more)
    fx, fy, n = q.reshape(2, 3).T
    x, y, _ = s.q.reshape(2, 3).T
    return np.array([fx.sum(), fy.sum(), (n + x * fy - y * fx).sum()])


def slopes_agree(machine: Interpreted, s: State, **more: object) -> None:
    """The gradient of V is its derivative by complex steps."""

    def energy(q: np.ndarray) -> np.ndarray:
        return machine.vector("potential", State(t=s.t, q=q, v=s.v), cmath, **more)

    assert_allclose(
        machine.vector("potential_gradient", s, **more), complex_step(energy, s.q), **TOLERANCE
    )


def balanced(machine: Interpreted, s: State, **more: object) -> None:
    """The power of all forces is the booked power less the rate of V."""
    total = machine.vector("applied_forces", s, **more) @ s.v
    stored = machine.vector("potential_gradient", s, **more) @ s.v
    assert_allclose(machine.vector("powers", s, **more).sum() - stored, total, **TOLERANCE)


# -- springs -------------------------------------------------------------------------------------


def test_spring_damper_actuator_is_haugs() -> None:
    model, first, second = pair()
    k = model.parameter("k", 70.0, unit="N/m")
    model.spring("tsda", first.at(*S_I), second.at(*S_J), k, 0.8, damping=5.0, actuator=3 * t)
    machine = Interpreted(model)
    for seed in SEEDS:
        s = machine.state(seed)
        d, v = ends(s)
        length = np.linalg.norm(d)
        pull = 5.0 * (d @ v) / length + 3 * s.t
        f = 70 * (length - 0.8) + pull
        assert_allclose(machine.vector("applied_forces", s), tsda(s, f), **TOLERANCE)
        assert_allclose(machine.vector("potential", s), 35 * (length - 0.8) ** 2, **TOLERANCE)
        assert_allclose(machine.vector("powers", s), [-pull * (d @ v) / length], **TOLERANCE)
        assert_allclose(momenta(machine, s), np.zeros(3), atol=1e-11)
        slopes_agree(machine, s)
        balanced(machine, s)


@pytest.mark.parametrize("preload", [-11.0, 6 * t])
@pytest.mark.parametrize("stiffness", [70.0, 0.0])
def test_preload_is_the_force_at_the_free_length(preload: object, stiffness: float) -> None:
    model, first, second = pair()
    places = first.at(*S_I), second.at(*S_J)
    model.spring("spring", *places, stiffness, 0.8, preload=preload)
    model.torsion_spring("coil", first, second, stiffness, 0.3, preload=preload)
    machine = Interpreted(model)
    for seed in SEEDS:
        s = machine.state(seed)
        (d, _), angle = ends(s), s.q[5] - s.q[2]
        more = -11.0 if preload == -11.0 else 6 * s.t
        stretch = np.linalg.norm(d) - 0.8
        turned = np.array([0, 0, 1.0, 0, 0, -1.0]) * (stiffness * (angle - 0.3) + more)
        expected = tsda(s, stiffness * stretch + more) + turned
        assert_allclose(machine.vector("applied_forces", s), expected, **TOLERANCE)
        assert_allclose(momenta(machine, s), np.zeros(3), atol=1e-11)
        balanced(machine, s)
        slopes_agree(machine, s)
        stored = sum(stiffness * x**2 / 2 - 11.0 * x for x in (stretch, angle - 0.3))
        energy = machine.vector("potential", s)
        assert_allclose(energy, stored if preload == -11.0 else 0.0, **TOLERANCE)


def test_damper_only_takes_energy() -> None:
    model, first, second = pair()
    model.spring("damper", first.at(*S_I), second.at(*S_J), damping=5.0)
    machine = Interpreted(model)
    for seed in SEEDS:
        s = machine.state(seed)
        d, v = ends(s)
        speed = (d @ v) / np.linalg.norm(d)
        assert_allclose(machine.vector("powers", s), [-5 * speed**2], **TOLERANCE)
        assert machine.vector("potential", s) == 0


def test_spring_to_the_ground_acts_on_the_body_alone() -> None:
    model = Model("hung")
    body = model.body("body", mass=1.0, inertia=1.0)
    model.spring("spring", model.ground.at(1, 2), body, stiffness=10, free_length=0.5)
    machine = Interpreted(model)
    s = machine.state(1)
    d = s.q[:2] - [1, 2]
    f = 10 * (np.linalg.norm(d) - 0.5)
    expected = [*(-f * d / np.linalg.norm(d)), 0]
    assert_allclose(machine.vector("applied_forces", s), expected, **TOLERANCE)


def test_any_characteristic_of_length_and_rate() -> None:
    model, first, second = pair()
    model.spring(
        "law",
        first.at(*S_I),
        second.at(*S_J),
        force=lambda length, rate: 4 * (length - 1) ** 3 + 0.5 * rate * sympy.Abs(rate),
    )
    machine = Interpreted(model)
    assert machine.s == 1
    for seed in SEEDS:
        s = machine.state(seed)
        d, v = ends(s)
        length = np.linalg.norm(d)
        rate = (d @ v) / length
        modes = [int(x > 0) for x in machine.vector("switching", s)]
        f = 4 * (length - 1) ** 3 + 0.5 * rate * abs(rate)
        assert_allclose(machine.vector("applied_forces", s, modes=modes), tsda(s, f), **TOLERANCE)


def test_law_that_switches_with_the_rate_has_one_quotient_as_switching_function() -> None:
    """g = dᵀ ḋ / ℓ, and not the sum of the quotients that the derivatives of ℓ are."""
    model = Model("pair")
    first, second = (model.particle(name, mass=1.0) for name in ("a", "b"))

    def law(length: sympy.Expr, rate: sympy.Expr) -> sympy.Expr:
        return sympy.Piecewise((3 * rate, rate > 0), (7 * rate, True))

    model.spring("law", first, second, force=law)
    (switch,) = Interpreted(model).equations.switches
    assert switch.text == (
        "((-a_x + b_x)*(-a_vx + b_vx) + (-a_y + b_y)*(-a_vy + b_vy))"
        "/sqrt((-a_x + b_x)**2 + (-a_y + b_y)**2) > 0"
    )


def test_spring_whose_free_length_moves_books_its_work() -> None:
    model, first, second = pair()
    model.spring("moved", first.at(*S_I), second.at(*S_J), 70.0, 0.8 + sympy.sin(t))
    machine = Interpreted(model)
    s = machine.state(2)
    d, v = ends(s)
    f = 70 * (np.linalg.norm(d) - 0.8 - np.sin(s.t))
    assert_allclose(machine.vector("applied_forces", s), tsda(s, f), **TOLERANCE)
    assert machine.vector("potential", s) == 0
    power = -f * (d @ v) / np.linalg.norm(d)
    assert_allclose(machine.vector("powers", s), [power], **TOLERANCE)


def test_quantities_are_converted() -> None:
    units = get_application_registry()
    model, first, second = pair()
    model.spring("s", first, second, units("2 N/cm"), units("30 mm"), units("4 N s/mm"))
    plain, one, other = pair()
    plain.spring("s", one, other, 200.0, 0.03, 4000.0)
    s = Interpreted(model).state(3)
    got, wanted = (Interpreted(m).vector("applied_forces", s) for m in (model, plain))
    assert_allclose(got, wanted, rtol=1e-13)


def test_spring_without_a_free_length_passes_through_zero() -> None:
    model, first, second = pair()
    model.spring("rubber", first, second, stiffness=9.0, free_length=0)
    s = State(t=0.0, q=np.zeros(6), v=np.ones(6))
    assert_allclose(Interpreted(model).vector("applied_forces", s), np.zeros(6), atol=0)


def test_torsion_spring() -> None:
    model, first, second = pair()
    model.torsion_spring(
        "coil",
        first,
        second,
        stiffness=12.0,
        free_angle=0.3,
        damping=2.0,
        actuator=1.5,
        torque=lambda angle, rate: 0.1 * angle**3 * rate,
    )
    machine = Interpreted(model)
    for seed in SEEDS:
        s = machine.state(seed)
        angle, rate = s.q[5] - s.q[2], s.v[5] - s.v[2]
        rest = 2 * rate + 1.5 + 0.1 * angle**3 * rate
        n = 12 * (angle - 0.3) + rest
        assert_allclose(machine.vector("applied_forces", s), [0, 0, n, 0, 0, -n], **TOLERANCE)
        assert_allclose(machine.vector("powers", s), [-rest * rate], **TOLERANCE)
        slopes_agree(machine, s)
        balanced(machine, s)


# -- contacts ------------------------------------------------------------------------------------


def sides(machine: Interpreted, s: State) -> list[int]:
    """The modes that hold at a state."""
    return [int(g > 0) for g in machine.vector("switching", s)]


@pytest.mark.parametrize(("gap", "speed"), [(-0.01, -2.0), (-0.01, 0.4), (-0.01, 2.0), (0.02, -1)])
@pytest.mark.parametrize("may_pull", [True, False])
def test_contact_along_a_line(gap: float, speed: float, may_pull: bool) -> None:
    model, first, second = pair()
    model.contact("bump", gap=second.x - first.x, stiffness=1e3, damping=20.0, may_pull=may_pull)
    machine = Interpreted(model)
    s = State(t=0.0, q=np.array([1.0, 0, 0, 1 + gap, 0, 0]), v=np.array([0, 0, 0, speed, 0, 0]))
    f = 1e3 * gap + 20 * speed if gap < 0 else 0.0
    f = f if may_pull else min(f, 0.0)
    modes = sides(machine, s)
    forces = machine.vector("applied_forces", s, modes=modes)
    assert_allclose(forces, [f, 0, 0, -f, 0, 0], **TOLERANCE)
    stored = 500 * gap**2 if gap < 0 else 0.0
    assert_allclose(machine.vector("potential", s, modes=modes), stored, **TOLERANCE)
    balanced(machine, s, modes=modes)
    assert machine.vector("powers", s, modes=modes)[0] <= 0


@pytest.mark.parametrize("direction", [None, (3, 4)])
def test_contact_between_points(direction: tuple[float, float] | None) -> None:
    model, first, second = pair()
    model.contact("bump", first.at(*S_I), second.at(*S_J), direction=direction,
                  free_length=6.0, stiffness=50.0, damping=3.0)  # fmt: skip
    machine = Interpreted(model)
    for seed in SEEDS:
        s = machine.state(seed)
        (d, _), (_, phi, _, _) = ends(s), s.body(0)
        u = A(phi) @ [0.6, 0.8]
        gap = (np.linalg.norm(d) if direction is None else u @ d) - 6.0
        modes = sides(machine, s)
        assert modes == [int(gap < 0)] == [1]
        assert_allclose(machine.vector("potential", s), 25 * gap**2, **TOLERANCE)
        assert_allclose(momenta(machine, s), np.zeros(3), atol=1e-10)
        assert machine.vector("powers", s)[0] <= 0
        slopes_agree(machine, s)
        balanced(machine, s)
        assert_allclose(machine.vector("applied_forces", s, modes=[0]), np.zeros(6), atol=0)


def test_contact_with_a_moving_wall_books_its_work() -> None:
    model = Model("wall")
    body = model.body("body", mass=1.0, inertia=1.0)
    model.contact("wall", gap=body.x - sympy.sin(t), stiffness=50.0, damping=2.0)
    machine = Interpreted(model)
    s = State(t=0.4, q=np.array([0.1, 0, 0]), v=np.array([-1.0, 0, 0]))
    f = 50 * (0.1 - np.sin(0.4)) + 2 * (-1 - np.cos(0.4))
    assert_allclose(machine.vector("applied_forces", s), [-f, 0, 0], **TOLERANCE)
    assert machine.vector("potential", s) == 0
    assert_allclose(machine.vector("powers", s), [f], **TOLERANCE)


# -- bushings ------------------------------------------------------------------------------------


def test_bushing() -> None:
    model, first, second = pair()
    model.bushing(
        "rubber", first.at(*S_I), second.at(*S_J), (40.0, 90.0, 6.0), (1.5, 2.5, 0.5), 0.2
    )
    machine = Interpreted(model)
    for seed in SEEDS:
        s = machine.state(seed)
        (d, v), (_, phi, _, w), (_, phi_j, _, w_j) = ends(s), s.body(0), s.body(1)
        shift = A(phi).T @ d
        drift = A(phi).T @ v + B(phi).T @ d * w
        force = A(phi) @ (np.array([40, 90]) * shift + np.array([1.5, 2.5]) * drift)
        torque = 6 * (phi_j - phi - 0.2) + 0.5 * (w_j - w)
        arm = A(phi) @ S_I + d  # on body i the force acts where point j is
        on_i = arm[0] * force[1] - arm[1] * force[0] + torque
        on_j = -(B(phi_j) @ S_J) @ force - torque
        expected = [*force, on_i, *-force, on_j]
        assert_allclose(machine.vector("applied_forces", s), expected, **TOLERANCE)
        assert_allclose(momenta(machine, s), np.zeros(3), atol=1e-11)
        lost = np.array([1.5, 2.5]) @ drift**2 + 0.5 * (w_j - w) ** 2
        assert_allclose(machine.vector("powers", s), [-lost], **TOLERANCE)
        slopes_agree(machine, s)
        balanced(machine, s)
