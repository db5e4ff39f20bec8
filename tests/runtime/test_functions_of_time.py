"""Explicit functions of time in runs: pieces of laws, jumps, poles, pulses, changes without end."""

import time
from collections.abc import Callable
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import (
    Abs,
    Expr,
    Heaviside,
    Max,
    Mod,
    Piecewise,
    acos,
    asin,
    atan2,
    cos,
    exp,
    floor,
    sign,
    sin,
    tanh,
)

from codegen import Model, t
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.result import Result

RISE, HOLD, FALL = 1.0, 3.0, 4.0  # s; of a trapezoid


def trapezoid(top: Expr | float, rise: Expr | float = RISE) -> Expr:
    """The way under a speed that rises to `top`, stays there and falls to 0."""
    return Piecewise(
        (top * t**2 / (2 * rise), t < rise),
        (top * (t - rise / 2), t < HOLD),
        (top * (t - rise / 2) - top * (t - HOLD) ** 2 / (2 * (FALL - HOLD)), t < FALL),
        (top * (FALL - rise / 2) - top * (FALL - HOLD) / 2, True),
    )


@pytest.fixture(scope="module")
def crank(workshop: Path) -> Callable[..., Machine]:
    """A crank of 2 kg m² driven by a law, a torque on it, or both, a spring beside it."""

    def loaded(name: str, law: Expr | None = None, torque: Expr | None = None) -> Machine:
        model = Model(f"crank_{name}")
        speed = model.parameter("speed", 2.0, unit="rad/s")
        rise = model.parameter("rise", RISE, unit="s")
        body = model.body("crank", mass=1.0, inertia=2.0)
        model.revolute("pin", model.ground.at(0, 0), body)
        symbols = {"top": speed, "rise": rise}
        if law is not None:
            model.driver("motor", body.phi, law(**symbols) if callable(law) else law)
        if torque is not None:
            model.torque("load", body, torque)
        model.scene(
            "s", effects=["load"] if torque is not None else [],
            drivers=["motor"] if law is not None else [],
            start={} if law is not None else {body.phi: 0.0, body.omega: 0.0},
        )  # fmt: skip
        return load(model, "s", folder=workshop)

    return loaded


def angle(result: Result) -> np.ndarray:
    return result.series("crank.phi")[0]


def test_trapezoid_is_followed_exactly(crank: Callable[..., Machine]) -> None:
    machine = crank("trapezoid", trapezoid)
    at = np.linspace(0.0, 5.0, 41)
    for rise in (1.0, 0.7):
        where = {"parameters": {"rise": rise}, "progress": False}
        law = np.vectorize(lambda x, r=rise: float(trapezoid(2.0, r).subs(t, x)))(at)
        moved = machine.simulate(5.0, at, **where)
        driven = machine.inverse_dynamics(at, **where)
        for result in (moved, machine.kinematics(at, **where), driven):
            assert result.outcome is Outcome.OK
            assert_allclose(angle(result), law, atol=1e-14)
            events = [(event.time, event.what) for event in result.events]
            assert [what for _, what in events] == ["began"] * 3
            assert_allclose([x for x, _ in events], [rise, HOLD, FALL], atol=1e-13)
            assert all(event.name.startswith("motor: ") for event in result.events)
        torques = driven.series("motor.torque")[0]
        inside = [(at < rise, 4.0 / rise), ((at > rise) & (at < HOLD), 0.0), (at > FALL, 0.0)]
        for part, expected in (*inside, ((at > HOLD) & (at < FALL), -4.0)):
            assert_allclose(torques[part], expected, atol=1e-12)


def test_steps_end_at_kinks(workshop: Path) -> None:
    """A pendulum on a cart under a trapezoid: as accurate as its three smooth parts together."""
    model = Model("cart_under_a_trapezoid")
    cart, pendulum = model.body("cart", mass=1.0, inertia=1.0), model.body("rod", 1.0, 0.1)
    model.translational("guide", model.ground, cart, axis=(1, 0))
    model.revolute("pin", cart, pendulum.at(0, 0.5))
    model.gravity("g", (0.0, -9.81))
    model.driver("motor", cart.x, trapezoid(1.0))
    model.scene("s", effects=["g"], drivers=["motor"], start={pendulum.phi: 0.1})
    machine = load(model, "s", folder=workshop)
    loose, tight = (machine.simulate(5.0, [5.0], rtol=r, progress=False) for r in (1e-8, 1e-12))
    assert_allclose(loose.samples.q, tight.samples.q, atol=2e-7)
    reduced = machine.simulate(5.0, [5.0], rtol=1e-12, formulation="reduced", progress=False)
    assert_allclose(reduced.samples.q, tight.samples.q, atol=1e-9)
    assert len(reduced.events) == 3
    assert loose.stats["rejected"] < 12
    assert len(loose.events) == 3


@pytest.mark.parametrize(
    ("name", "law", "instant", "text"),
    [
        ("wrapped", atan2(sin(3 * t), cos(3 * t)), pi / 3, "jumps by 6.28319 at t = 1.0471975"),
        ("stepped", Heaviside(t - 1), 1.0, "jumps by 1 at t = 1 s"),
        ("floored", 0.1 * floor(t / 1.5), 1.5, "jumps by 0.1 at t = 1.5 s"),
        ("sharp", tanh(1 / (t - 1)), 1.0, "jumps by 2 at t = 1 s"),
        ("broken", 1 / (t - 0.5), 0.5, "has no finite value at t = 0.5 s"),
        ("twice_broken", 1 / (t - 0.5) ** 2, 0.5, "has no finite value at t = 0.5 s"),
        ("endless", 0.1 * sin(1 / (t - 1)), 1.0, "changes ever faster up to about t = "),
        ("from_the_start", 0.1 * Mod(-t, 2.5), 0.0, "jumps by 0.25 at t = "),
        ("at_the_end", 0.1 * floor(t / 2), 2.0, "jumps by 0.1 at t = 2 s"),
        ("cusp", Abs(t - 0.7) ** 0.5, 0.7, "has no finite rate at t = 0.7 s"),
    ],
)
def test_a_law_that_ends_says_so_in_every_analysis(
    crank: Callable[..., Machine], name: str, law: Expr, instant: float, text: str
) -> None:
    machine, at = crank(name, law), np.linspace(0.0, 2.0, 33)
    began = time.perf_counter()
    for run in (
        lambda: machine.simulate(2.0, at, progress=False),
        lambda: machine.kinematics(at, progress=False),
        lambda: machine.inverse_dynamics(at, progress=False),
    ):
        result = run()
        endless = name == "endless"
        assert result.outcome is (Outcome.ZENO if endless else Outcome.DISCONTINUOUS)
        assert f"'motor' {text}" in result.message
        assert "witch" not in result.message  # a law has none
        assert instant - 0.08 < result.t[-1] < instant + 1e-9
        shown = result.t < instant - 1e-3
        expected = np.array([float(law.subs(t, x)) for x in result.t[shown]])
        assert_allclose(angle(result)[shown], expected, rtol=1e-6, atol=1e-7)
    assert time.perf_counter() - began < 20.0


def test_a_jump_of_the_rate_is_an_impact(workshop: Path) -> None:
    """A crank that starts at once pulls a spring's mass along: momentum goes over the joint."""
    model = Model("snatched")
    crank_, rod = model.body("crank", 1.0, 2.0), model.body("rod", 3.0, 0.5)
    model.revolute("pin", model.ground.at(0, 0), crank_)
    model.revolute("elbow", crank_.at(0.4, 0), rod.at(-0.3, 0))
    model.driver("motor", crank_.phi, Max(0, t - 1))
    model.scene("s", drivers=["motor"], start={rod.phi: 0.7, rod.omega: 0.0})
    machine = load(model, "s", folder=workshop)
    result = machine.simulate(1.5, [0.999, 1.0 + 1e-9], progress=False)
    assert result.outcome is Outcome.OK
    assert [event.what for event in result.events] == ["impact"]
    names = (row.velocity for row in machine.description.coordinates)
    speeds = dict(zip(names, result.samples.v[1], strict=True))
    assert speeds["crank.omega"] == pytest.approx(1.0, abs=1e-8)
    # The rod keeps its angular momentum about the elbow, through which the impulse goes.
    rx, ry = 0.3 * np.cos(0.7), 0.3 * np.sin(0.7)
    moment = 3.0 * (rx * speeds["rod.vy"] - ry * speeds["rod.vx"]) + 0.5 * speeds["rod.omega"]
    assert moment == pytest.approx(0.0, abs=1e-7)
    assert speeds["rod.omega"] != pytest.approx(0.0, abs=1e-3)
    reduced = machine.simulate(1.5, formulation="reduced", progress=False)
    assert reduced.outcome is Outcome.OK
    assert [event.what for event in reduced.events] == ["impact"]


@pytest.mark.parametrize("bend", [0.5, 3.0])
def test_a_bend_at_the_end_of_a_step_is_passed(bend: float, workshop: Path) -> None:
    """Halves of the time are ends of steps: the run stands behind a bend there, too."""
    model = Model("bends")
    slide = model.body("slide", 3.0, 0.1)
    model.translational("guide", model.ground.at(0, 0), slide.at(0, 0), axis=(1, 0))
    model.driver("d", slide.x, Max(0.2 * t, 0.2 * bend + 0.6 * (t - bend)))
    model.scene("s", drivers=["d"])
    result = load(model, "s", folder=workshop).simulate(4.0, 20, progress=False)
    assert result.outcome is Outcome.OK, result.message
    assert [event.time > bend for event in result.events] == [True]


PULSES = {
    "gauss": (10 * exp(-(((t - 50) / 0.1) ** 2)), 10 * 0.1 * sqrt(pi)),
    "train": (
        sum(10 * exp(-(((t - c) / 0.01) ** 2)) for c in (13.1, 37.7, 90.3)), 0.3 * sqrt(pi)
    ),
    "edges": (tanh(1e4 * (t - 61)) - tanh(1e4 * (t - 61.01)), 0.02),
    "window": (Piecewise((1e3, (t > 70) & (t < 70.001)), (0, True)), 1.0),
    "power": (cos(t / 32) ** 100000, 1.5 * 32 * sqrt(2 * pi / 1e5)),
    "early": (1e6 * t**2 * exp(-t / 0.01), 2.0),
}  # fmt: skip


@pytest.mark.parametrize("method", ["dop853", "dopri5", "bdf"])
@pytest.mark.parametrize("name", PULSES)
def test_no_pulse_is_stepped_over(crank: Callable[..., Machine], name: str, method: str) -> None:
    pulse, impulse = PULSES[name]
    machine = crank(name, torque=pulse)
    result = machine.simulate(105.0, [105.0], method=method, progress=False)
    assert result.outcome is Outcome.OK
    assert result.series("crank.omega")[0][-1] == pytest.approx(impulse / 2.0, rel=1e-4)
    assert result.stats["steps"] < 2500


def test_pieces_in_forces(crank: Callable[..., Machine]) -> None:
    """Mod, floor and Abs of the time: ∫∫ of what they are, to the tolerance."""
    machine = crank("sawtooth", torque=2 * Mod(t, 1) + 2 * floor(t) - 2 * Abs(t - 1.5))
    result = machine.simulate(3.5, progress=False)
    assert result.outcome is Outcome.OK
    x = 3.5
    expected = x**3 / 6 - (1.5**2 / 2 * x - 1.5**3 / 6 + 2.0**3 / 6)
    assert angle(result)[-1] == pytest.approx(expected, abs=1e-8)


def test_switches_without_end(crank: Callable[..., Machine]) -> None:
    machine = crank("shaken", torque=sign(sin(1 / (t - 1))))
    for method in ("dop853", "bdf"):
        result = machine.simulate(2.0, method=method, progress=False)
        assert result.outcome is Outcome.ZENO
        assert 0.99 < result.t[-1] < 1.0
        assert "'load' changes ever faster up to about t = " in result.message
    assert machine.simulate(0.9, progress=False).outcome is Outcome.OK


def test_a_contact_opens_where_a_law_pulls_away(workshop: Path) -> None:
    """A table that falls faster than g from t = 1 on leaves its block to fall by itself."""
    model = Model("dropped_table")
    table, block = model.body("table", 1.0, 1.0), model.body("block", 1.0, 1.0)
    model.translational("guide", model.ground, table, axis=(0, 1))
    model.translational("other_guide", model.ground, block, axis=(0, 1))
    model.driver("motor", table.y, Piecewise((0, t < 1), (-10 * (t - 1) ** 2, True)))
    model.gravity("g", (0.0, -9.81))
    model.contact("rest", gap=block.y - table.y, restitution=0.0)
    model.scene("s", ["g", "rest"], drivers=["motor"], start={block.y: 0.0, block.vy: 0.0})
    result = load(model, "s", folder=workshop).simulate(1.5, [0.9, 1.5], progress=False)
    assert result.outcome is Outcome.OK
    assert_allclose(result.series("block.y")[0], [0.0, -9.81 * 0.5**2 / 2], atol=1e-9)
    assert [(event.name.partition(":")[0], event.what) for event in result.events] == [
        ("rest", "began"),
        ("motor", "began"),
    ]


@pytest.mark.parametrize("method", ["dop853", "bdf"])
def test_a_run_ends_on_the_side_that_its_last_instant_has(
    crank: Callable[..., Machine], method: str
) -> None:
    machine = crank("bouncing", 0.1 * Mod(t, 2) * (2 - Mod(t, 2)))
    for end, rate, impacts in ((3.0, 0.0, 1), (4.0, 0.2, 2), (4.0 - 1e-9, -0.2, 1)):
        result = machine.simulate(end, [end], method=method, progress=False)
        assert result.outcome is Outcome.OK
        assert result.t[-1] == result.samples.t[-1] == end
        assert_allclose(result.series("crank.omega")[0][-1], rate, atol=1e-8)
        assert [event.what for event in result.events] == ["impact"] * impacts
    every_step = machine.simulate(4.0, method=method, progress=False)
    assert (every_step.t[-1], len(every_step.events)) == (4.0, 2)


@pytest.mark.parametrize(
    ("name", "law", "wave", "corners"),
    [
        ("of_sine", asin(sin(3 * t)), lambda x: np.arcsin(np.sin(3 * x)), [pi / 6, pi / 2]),
        ("of_cosine", acos(cos(3 * t)), lambda x: np.arccos(np.cos(3 * x)), [pi / 3]),
        ("crossed", asin(cos(3 * t)), lambda x: np.arcsin(np.cos(3 * x)), [pi / 3]),
        ("crosswise", acos(sin(3 * t)), lambda x: np.arccos(np.sin(3 * x)), [pi / 6, pi / 2]),
    ],
)
def test_triangle_waves_have_impacts_at_their_corners(
    crank: Callable[..., Machine], name: str, law: Expr, wave: Callable[..., np.ndarray],
    corners: list[float],
) -> None:  # fmt: skip
    machine, at = crank(f"triangle_{name}", law), np.linspace(0.0, 1.9, 39)
    for result in (
        machine.simulate(1.9, at, progress=False),
        machine.kinematics(at, progress=False),
    ):
        assert result.outcome is Outcome.OK
        assert [event.what for event in result.events] == ["impact"] * len(corners)
        assert_allclose([event.time for event in result.events], corners, atol=1e-13)
        assert_allclose(result.samples.q[:, 2], wave(at), atol=1e-8)
        assert_allclose(np.abs(result.samples.v[:, 2]), 3.0, atol=1e-12)


@pytest.mark.parametrize("steepness", [150.0, -150.0, 1e4, -1e4])
def test_exponentials_beyond_all_floats_act(
    crank: Callable[..., Machine], steepness: float
) -> None:
    """SymPy takes e^(6.6 k) out of the exponential, as a number that no float holds."""
    name = f"logistic_{steepness:g}".replace("-", "m").replace("+", "")
    result = crank(name, torque=2.0 / (1 + exp(steepness * (6.6 - t)))).simulate(
        10.0, progress=False
    )
    assert result.outcome is Outcome.OK
    impulse = 3.4 if steepness > 0 else 6.6
    assert_allclose(result.series("crank.omega")[0][-1], impulse, atol=1e-7)


def test_a_pulse_whose_square_is_multiplied_out_acts(crank: Callable[..., Machine]) -> None:
    pulse = (10 * exp(-(((t - 50.0) / 0.1) ** 2))).expand()
    result = crank("multiplied_out", torque=pulse).simulate(60.0, progress=False)
    assert result.outcome is Outcome.OK
    assert_allclose(result.series("crank.omega")[0][-1], 0.5 * sqrt(pi), atol=1e-7)


def test_samples_just_before_a_kink_have_the_modes_before_it(workshop: Path) -> None:
    """A driver turns back at 1 s, and what acts while it goes ahead ceases there."""
    model = Model("turned_back")
    ahead, pulled = (model.particle(name, mass=1.0) for name in ("ahead", "pulled"))
    law = Piecewise((t, t < 1), (2 - t, True))
    model.translation_driver("drive", model.ground, ahead, law)
    model.force("gate", pulled, fx=2.0, when=ahead.vx > 0)
    start = dict.fromkeys((ahead.y, ahead.vy, pulled.x, pulled.y, pulled.vx, pulled.vy), 0.0)
    model.scene("s", ["gate"], drivers=["drive"], start=start)
    last = np.nextafter(1.0, 0.0)
    run = load(model, folder=workshop).simulate(2.0, [0.0, np.nextafter(last, 0.0), last, 2.0])
    assert run.outcome is Outcome.OK, run.message
    assert run.samples.modes[1:3].ravel().tolist() == [1, 1]
    assert_allclose(run.v("pulled.x"), [0.0, 2.0, 2.0, 2.0], atol=1e-9)


@pytest.mark.parametrize(
    ("name", "law", "start", "rate"),
    [
        ("absolute", Abs(t), 0.0, 1.0),
        ("later", Abs(0.3 * t - 0.09), 0.3, 0.3),
        ("rounded", Abs(cos(t)), pi / 2, 1.0),
        ("ramp", Piecewise((0, t <= 0), (t, True)), 0.0, 1.0),
    ],
)
def test_a_run_begins_by_the_law_behind_its_first_instant(
    workshop: Path, name: str, law: Expr, start: float, rate: float
) -> None:
    """A law that bends where the run starts strikes nothing: what went before never was."""
    model = Model(f"begun_{name}")
    b, c = model.body("b", 1.0, 0.1), model.body("c", 1.0, 0.1)
    model.revolute("O", model.ground.at(0, 0), b.at(-0.5, 0))
    model.revolute("A", b.at(0.5, 0), c.at(-0.5, 0))
    model.driver("d", b.phi, law)
    model.scene("free", [], ["d"], start={c.phi: 0.2, c.omega: 0.1})
    model.scene("driven", [], ["d"], without=[c])
    model.scene("backwards", [], ["d"], start={c.phi: 0.2, c.omega: 0.1, b.omega: -rate})
    machine, at = load(model, "free", folder=workshop), [start, start + 0.5]
    options = ({}, {"method": "bdf"}, {"formulation": "reduced"}, {"accuracy": 1e-6})
    for chosen in options:
        run = machine.simulate(at[1], at, t_start=start, progress=False, **chosen)
        assert (run.outcome, run.events) == (Outcome.OK, ())
        assert run.t.tolist() == at
        assert_allclose(run.v("b.omega")[0], rate)
        assert_allclose(run.v("c.omega")[0], 0.1, rtol=1e-12)
    for analysis in ("kinematics", "inverse_dynamics"):
        motion = getattr(load(model, "driven", folder=workshop), analysis)(
            at, t_start=start, progress=False
        )
        assert (motion.outcome, motion.events) == (Outcome.OK, ())
        assert motion.t.tolist() == at
        assert_allclose([motion.v("b.omega")[0], motion.at(start).v("b.omega")[0]], rate)
    if name == "ramp":
        return
    run = load(model, "backwards", folder=workshop).simulate(at[1], t_start=start, progress=False)
    assert [event.what for event in run.events] == ["impact"]
    assert_allclose(run.v("b.omega")[[0, -1]], [-rate, rate], rtol=0.3)


@pytest.mark.parametrize("method", ["dop853", "bdf"])
@pytest.mark.parametrize(
    ("name", "condition", "share"),
    [
        ("down", Mod(t, 0.5) < 0.1, 0.2),
        ("up", Mod(t, 0.5) > 0.4, 0.2),
        ("backwards", Mod(-t, 0.5) > 0.4, 0.2),
        ("written_out", t - floor(2 * t) / 2 < 0.1, 0.2),
    ],
)
def test_conditions_that_jump_take_their_sides(
    workshop: Path, name: str, condition: Expr, share: float, method: str
) -> None:
    """A sawtooth jumps over its threshold one way and goes back the other: 20 pushes in 10 s."""
    model = Model(f"pushed_{name}")
    p = model.particle("p", mass=1.0)
    model.force("push", p, 1.0, 0, when=condition)
    model.scene("s", ["push"], start={p.x: 0.0, p.y: 0.0, p.vx: 0.0, p.vy: 0.0})
    result = load(model, folder=workshop).simulate(10.0, [5.0, 10.0], method=method, progress=False)
    assert result.outcome is Outcome.OK
    assert_allclose(result.v("p.vx"), [5.0 * share, 10.0 * share], atol=1e-10)
    whats = [event.what for event in result.events if event.name.startswith("push: ")]
    assert whats.count("began") in {19, 20}
    assert whats.count("ceased") in {19, 20}
