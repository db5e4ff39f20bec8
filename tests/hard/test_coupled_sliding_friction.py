"""Friction that follows from a reaction and slides, while something else sticks or is closed.

A crank turns in a bearing that rubs and carries a weight on a guide. The force that keeps the
weight in its place adds to the load of the bearing, whose friction, μ r |F|, is not linear in it.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from sympy import sign

from codegen import Model
from runtime import load
from runtime.core.kinds import SLIDING
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from tests.hard.start_values import start_and_guess

CRANK, INERTIA, WEIGHT, SMALL = 1.0, 0.8, 0.7, 0.05  # kg, kg m², kg, kg m²
INNER, OUTER, G = 0.2, 0.4, 9.81  # m: from the bearing to the centres of mass
MU, RADIUS, CREEP = 0.4, 0.15, 0.7
PLACE = {
    "guide": 0.3, "pad": 0.3, "guide and pad": 0.3, "stop": 1.2, "stop and guide": 1.2,
}  # fmt: skip


def machine(folder: Path, *, creep: bool, keep: str) -> Machine:
    """The weight is kept by the friction of its guide, by a pad, by a stop, or by two of them."""
    m = Model("kept_weight", gravity=(0, -G))
    crank = m.body("crank", mass=CRANK, inertia=INERTIA)
    weight = m.body("weight", mass=WEIGHT, inertia=SMALL)
    bearing = m.revolute("bearing", m.ground.at(0, 0), crank.at(-INNER, 0))
    guide = m.translational("slot", crank, weight, axis=(1, 0))
    law = {"creep": CREEP} if creep else {}
    m.friction("rub", bearing, MU, radius=RADIUS, **law)
    m.friction("guide", guide, 0.9)
    m.dry_friction("pad", crank, weight, axis=(1, 0), normal=9.0, coefficient=0.8)
    seat = crank.at(OUTER - INNER, 0)
    m.contact("stop", seat, weight, direction=(1, 0), restitution=0.0)
    phi = PLACE[keep]
    place = {"x": np.cos(phi), "y": np.sin(phi)}
    start = {crank.phi: phi, crank.omega: 0.9, weight.x: OUTER * place["x"]}
    start |= {weight.vx: -0.9 * OUTER * place["y"]}
    guess = {weight.y: OUTER * place["y"], crank.x: INNER * place["x"], weight.phi: phi}
    guess |= {crank.y: INNER * place["y"]}
    m.scene("s", ["gravity", "rub", *keep.split(" and ")], start=start, guess=guess)
    return load(m, "s", folder=folder)


def exact(phi: float, omega: float, *, creep: bool) -> tuple[float, float]:
    """Angular acceleration and friction of the crank with the weight as one body."""
    outward, along = np.array([np.cos(phi), np.sin(phi)]), np.array([-np.sin(phi), np.cos(phi)])
    grip = MU * RADIUS * (np.tanh(omega / CREEP) if creep else np.sign(omega))
    parts = ((CRANK, INNER), (WEIGHT, OUTER))
    inertia = INERTIA + SMALL + sum(mass * arm**2 for mass, arm in parts)
    moment = -G * np.cos(phi) * sum(mass * arm for mass, arm in parts)
    alpha = friction = 0.0
    for _ in range(300):  # each round is closer by μ r times mass and arm over inertia
        load = sum(
            mass * (arm * (alpha * along - omega**2 * outward) + np.array([0.0, G]))
            for mass, arm in parts
        )
        friction = float(-grip * np.hypot(*load))
        alpha = (moment + friction) / inertia
    return float(alpha), friction


@pytest.mark.parametrize("creep", [False, True])
@pytest.mark.parametrize("keep", PLACE)
def test_friction_that_slides_is_on_its_law(tmp_path: Path, creep: bool, keep: str) -> None:
    instants = [0.0, 0.02, 0.05]
    run = machine(tmp_path, creep=creep, keep=keep).simulate(
        0.05, instants, rtol=1e-11, progress=False
    )
    assert run.outcome is Outcome.OK
    span = np.hypot(run.q("weight.x"), run.q("weight.y"))
    np.testing.assert_allclose(span, OUTER, rtol=0, atol=1e-12)
    for k in range(len(instants)):
        phi, omega = run.q("crank.phi")[k], run.v("crank.omega")[k]
        alpha, friction = exact(phi, omega, creep=creep)
        assert run.reaction("rub", "torque")[k] == pytest.approx(friction, rel=1e-11)
        assert run.a("crank.omega")[k] == pytest.approx(alpha, rel=1e-11)
        law = MU * RADIUS * np.hypot(*(run.reaction("bearing", f)[k] for f in ("fx", "fy")))
        law *= np.tanh(omega / CREEP) if creep else 1.0
        assert run.reaction("rub", "torque")[k] == pytest.approx(-law, rel=1e-12)


def test_breaks_loose_where_its_own_force_reaches_its_limit(tmp_path: Path) -> None:
    """At the event the force of the guide is μ_s N of the same motion."""
    run = machine(tmp_path, creep=False, keep="guide").simulate(
        1.0, np.linspace(0.0, 1.0, 11), rtol=1e-11, progress=False
    )
    (loose,) = [e for e in run.events if e.name.startswith("guide")][:1]
    crank = run.description.coordinates.names.index("crank.phi")
    phi, omega = loose.q[crank], loose.v[crank]
    alpha, _ = exact(phi, omega, creep=False)
    force = WEIGHT * (G * np.sin(phi) - omega**2 * OUTER)
    # The moment of the weight about its centre is borne by the slot, which presses by its force.
    normal = WEIGHT * (G * np.cos(phi) + alpha * OUTER)
    assert abs(force) == pytest.approx(0.9 * abs(normal), rel=1e-9)


@pytest.mark.parametrize("beside", [[], ["brake"]])
@pytest.mark.parametrize("law", [{}, {"creep": CREEP}])
def test_impact_has_no_impulse_of_friction(
    tmp_path: Path, law: dict[str, float], beside: list[str]
) -> None:
    """The tip of a double pendulum strikes a floor: velocities as without friction.

    A brake, whose condition slides until then, gives no impulse either.
    """
    after, second = [], -1.0 if beside else -0.6
    for effects in (["gravity", "floor"], ["gravity", "floor", "rub", *beside]):
        m = Model("struck", gravity=(0, -G))
        upper = m.body("upper", mass=1.0, inertia=0.1)
        lower = m.body("lower", mass=1.0, inertia=0.1)
        bearing = m.revolute("bearing", m.ground.at(0, 0), upper.at(-0.5, 0))
        m.revolute("knee", upper.at(0.5, 0), lower.at(-0.5, 0))
        m.friction("rub", bearing, 0.4, radius=0.3, **law)
        faster = sign(lower.omega - upper.omega)
        m.generalized_force("brake", {lower.phi: -40 * faster, upper.phi: 40 * faster})
        below = np.sin(-0.4) + np.sin(-1.1)
        tip = lower.at(0.5, 0)
        m.contact("floor", m.ground.at(0, below), tip, direction=(0, 1), restitution=0.4)
        start = {upper.phi: -0.4, lower.phi: -1.1, upper.omega: -1.0, lower.omega: second}
        m.scene("s", effects, start=start)
        run = load(m, "s", folder=tmp_path / effects[-1]).simulate(
            1e-9, [0.0, 1e-9], progress=False
        )
        assert run.outcome is Outcome.OK
        after.append([run.v("upper.omega")[1], run.v("lower.omega")[1]])
    assert np.abs(np.array(after[0]) - [-1.0, second]).min() > 0.1
    np.testing.assert_allclose(after[1], after[0], atol=1e-6)


def test_reduced_equations_and_implicit_methods_agree(tmp_path: Path) -> None:
    """Branches of loops precede the shares in `p` of reduced kernels."""
    closed = machine(tmp_path, creep=True, keep="stop")
    chosen = [{}, {"formulation": "reduced"}, {"method": "radau5"}]
    runs = [closed.simulate(0.05, [0.0, 0.05], rtol=1e-10, progress=False, **c) for c in chosen]  # type: ignore[arg-type]
    for run in runs[1:]:
        assert run.outcome is Outcome.OK
        np.testing.assert_allclose(run.samples.q, runs[0].samples.q, atol=1e-8)
        np.testing.assert_allclose(run.samples.reaction, runs[0].samples.reaction, rtol=1e-7)


ROPE = 12.0  # N


def roped(folder: Path, *, creep: bool) -> Machine:
    """The weight is kept by a rope along the crank that pulls against its velocity: a condition."""
    m = Model("roped_weight", gravity=(0, -G))
    crank = m.body("crank", mass=CRANK, inertia=INERTIA)
    weight = m.body("weight", mass=WEIGHT, inertia=SMALL)
    mu, radius = m.parameter("mu", MU), m.parameter("r", RADIUS, unit="m")
    bearing = m.revolute("bearing", m.ground.at(0, 0), crank.at(-INNER, 0))
    m.translational("slot", crank, weight, axis=(1, 0))
    m.friction("rub", bearing, mu, radius=radius, **({"creep": CREEP} if creep else {}))
    m.spring("rope", crank.at(-INNER, 0), weight, force=lambda _, v: ROPE * sign(v))
    start = dict.fromkeys((crank.phi, crank.omega, weight.x, weight.vx), 0.5)
    outputs = ["reactions", "energy", "powers", "work(rub)", "work(rope)"]
    m.scene("s", ["gravity", "rub", "rope"], start=start, outputs=outputs)
    return load(m, "s", folder=folder)


def one_side(
    phi: float, omega: float, grip: float, pull: float, *, arm: float = OUTER, kept: float = 0.0
) -> tuple[float, float, float]:
    """How fast the weight moves outwards, the crank turns, and its friction, under a pull.

    Another weight, of the mass `kept`, is part of the crank.
    """
    outward, along = np.array([np.cos(phi), np.sin(phi)]), np.array([-np.sin(phi), np.cos(phi)])
    outwards = arm * omega**2 - G * np.sin(phi) - pull / WEIGHT
    parts = ((CRANK, INNER, 0.0), (kept, OUTER, 0.0), (WEIGHT, arm, outwards))
    small = SMALL * (2 if kept else 1)
    inertia = INERTIA + small + sum(mass * arm**2 for mass, arm, _ in parts)
    moment = -G * np.cos(phi) * sum(mass * arm for mass, arm, _ in parts)
    alpha = friction = 0.0
    for _ in range(400):
        load = sum(
            mass * (arm * alpha * along + (r - arm * omega**2) * outward + np.array([0.0, G]))
            for mass, arm, r in parts
        )
        friction = float(-grip * np.hypot(*load))
        alpha = (moment + friction) / inertia
    return float(outwards), float(alpha), friction


@pytest.mark.parametrize("creep", [False, True])
def test_a_condition_that_slides_moves_by_the_share_of_both_sides(
    tmp_path: Path, creep: bool
) -> None:
    """A. F. Filippov's mean of two motions, in each of which friction is on its own law."""
    turning, random = roped(tmp_path, creep=creep), np.random.default_rng(7)
    for _ in range(12):
        phi = float(random.uniform(-1.3, 1.3))
        omega = float(random.choice([-1, 1]) * random.uniform(0.5, 2.0))
        mu, radius = float(random.uniform(0.1, 0.6)), float(random.uniform(0.05, 0.2))
        c, s = np.cos(phi), np.sin(phi)
        begin = {
            "crank.phi": phi, "crank.omega": omega, "crank.x": INNER * c, "crank.y": INNER * s,
            "weight.x": OUTER * c, "weight.y": OUTER * s, "weight.vx": -omega * OUTER * s,
            "weight.phi": phi,
        }  # fmt: skip
        run = turning.simulate(
            1e-3, [0.0, 1e-3], parameters={"mu": mu, "r": radius}, progress=False,
            **start_and_guess(turning, begin),
        )  # fmt: skip
        assert run.outcome is Outcome.OK
        phi, omega = run.q("crank.phi")[1], run.v("crank.omega")[1]
        grip = mu * radius * (np.tanh(omega / CREEP) if creep else np.sign(omega))
        (above, fast, much), (below, slow, less) = (
            one_side(phi, omega, grip, pull) for pull in (ROPE, -ROPE)
        )
        share = below / (below - above)
        assert 0.0 < share < 1.0
        assert run.samples.share[1, -1] == pytest.approx(share, rel=1e-10)
        assert run.a("crank.omega")[1] == pytest.approx(slow + share * (fast - slow), rel=1e-10)
        torque = less + share * (much - less)
        assert run.reaction("rub", "torque")[1] == pytest.approx(torque, rel=1e-10)
        assert run.power("rub")[1] == pytest.approx(torque * omega, rel=1e-10)
        if not creep:
            normal = run.reaction("rub", "normal")[1]
            assert grip * normal == pytest.approx(-torque, rel=1e-10)


def test_the_work_of_friction_beside_a_condition_explains_the_energy(tmp_path: Path) -> None:
    turning = roped(tmp_path, creep=True)
    run = turning.simulate(0.3, [0.0, 0.3], rtol=1e-11, progress=False)
    assert run.outcome is Outcome.OK
    assert run.samples.modes[-1, -1] == SLIDING
    (lost,) = np.diff(run.energy())
    assert lost < -0.1
    assert run.work("rub")[-1] + run.work("rope")[-1] == pytest.approx(lost, rel=1e-9)


RIDE = 0.25  # m: from the bearing to the weight on the rope, where another lies on a stop


@pytest.mark.parametrize("creep", [False, True])
def test_a_condition_slides_beside_a_closed_contact(tmp_path: Path, creep: bool) -> None:
    """Steps are returned onto the surfaces of both; an own integration has the same motion."""
    m = Model("stop_and_rope", gravity=(0, -G))
    crank = m.body("crank", mass=CRANK, inertia=INERTIA)
    weight, rider = (m.body(name, mass=WEIGHT, inertia=SMALL) for name in ("weight", "rider"))
    bearing = m.revolute("bearing", m.ground.at(0, 0), crank.at(-INNER, 0))
    m.translational("slot", crank, weight, axis=(1, 0))
    m.translational("rail", crank, rider, axis=(1, 0))
    m.friction("rub", bearing, MU, radius=RADIUS, **({"creep": CREEP} if creep else {}))
    m.contact("stop", crank.at(OUTER - INNER, 0), weight, direction=(1, 0), restitution=0.0)
    m.spring("rope", crank.at(-INNER, 0), rider, force=lambda _, v: ROPE * sign(v))
    c, d, phi, omega = np.cos(1.2), np.sin(1.2), 1.2, 0.9
    start = {crank.phi: phi, crank.omega: omega, weight.x: OUTER * c, rider.x: RIDE * c}
    start |= {weight.vx: -omega * OUTER * d, rider.vx: -omega * RIDE * d}
    guess = {crank.x: INNER * c, crank.y: INNER * d, weight.y: OUTER * d, rider.y: RIDE * d}
    guess |= {weight.phi: phi, rider.phi: phi}
    m.scene("s", ["gravity", "rub", "rope", "stop"], start=start, guess=guess)
    run = load(m, "s", folder=tmp_path).simulate(0.1, [0.0, 0.1], rtol=1e-11, progress=False)
    assert run.outcome is Outcome.OK
    assert (run.samples.modes[-1][[row.kind != "friction" for row in
            run.description.switches]] == SLIDING).all()  # fmt: skip

    def mean(state: np.ndarray) -> tuple[float, float]:
        """Angular acceleration and friction."""
        grip = MU * RADIUS * (np.tanh(state[1] / CREEP) if creep else np.sign(state[1]))
        (above, fast, much), (below, slow, less) = (
            one_side(*state, grip, pull, arm=RIDE, kept=WEIGHT) for pull in (ROPE, -ROPE)
        )
        share = below / (below - above)
        return slow + share * (fast - slow), less + share * (much - less)

    def rate(_: float, state: np.ndarray) -> list[float]:
        return [state[1], mean(state)[0]]

    own = solve_ivp(rate, (0.0, 0.1), (phi, omega), "DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
    np.testing.assert_allclose([run.q("crank.phi")[-1], run.v("crank.omega")[-1]], own, rtol=1e-9)
    alpha, friction = mean(own)
    assert run.a("crank.omega")[-1] == pytest.approx(alpha, rel=1e-8)
    assert run.reaction("rub", "torque")[-1] == pytest.approx(friction, rel=1e-8)
    for body, arm in ((weight, OUTER), (rider, RIDE)):
        span = np.hypot(run.q(f"{body.name}.x"), run.q(f"{body.name}.y"))
        np.testing.assert_allclose(span, arm, rtol=0, atol=1e-9)
