"""The work of each step explains its change of energy, or the run ends by name."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
import sympy as sp
from sympy import cos, sin, tanh

from codegen import Model, t
from runtime import load
from runtime.core import function_table_slots as ft
from runtime.core.arrays import Context
from runtime.core.jit import addressed, addresses
from runtime.core.kernel_abi import SIGNATURES
from runtime.core.outcomes import Outcome
from runtime.integrate import wiring
from runtime.machine_facade import Machine

SCENES = ("loaded", "swinging")
WAVES = ("waves", "ripples")
FLAT = ("arched", "rooted", "tilted", "turning", "huge")
ALL = (*SCENES, *WAVES, *FLAT, "gusty", "cancelling", "constant", "bouncing")


@pytest.fixture(scope="module")
def machines(workshop: Path) -> dict[str, Machine]:
    """The scenes of `unbalanced.py`."""
    file = Path(__file__).with_name("unbalanced.py")
    return {scene: load(file, scene, folder=workshop) for scene in ALL}


@addressed(ft.RESOLVED_PART)
def find_no_peak(context: Context) -> float:
    """The whole of every step."""
    return 1.0


@pytest.fixture
def blind(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs step over narrow peaks, as they would over those of a function that nothing watches."""
    address = int(addresses([find_no_peak])[0])
    monkeypatch.setattr(wiring, "_resolved_part", lambda: address)


def changed(machine: Machine, kernel: str, make: Callable[[Any], Any]) -> Machine:
    """The machine with another kernel, made from its own."""
    kernels = machine.mechanism.kernels
    wrong = numba.njit(SIGNATURES[kernel], error_model="numpy")(make(getattr(kernels, kernel)))
    return Machine(replace(machine.mechanism, kernels=replace(kernels, **{kernel: wrong})))


def negative(potential: Any) -> Any:
    """The sign of all forces with a potential is wrong."""
    return lambda t, q, p, modes: -potential(t, q, p, modes)


def stepped(potential: Any) -> Any:
    """The potential jumps by 5 J, and exerts nothing there."""
    return lambda t, q, p, modes: potential(t, q, p, modes) + (5.0 if q[0] > 0.2 else 0.0)


def gauged(potential: Any) -> Any:
    """The potential changes in time alone, which none that is compiled does: no power does it."""
    return lambda t, q, p, modes: potential(t, q, p, modes) + 20.0 * np.sin(2.0 * t)


def heavier(kinetic: Any) -> Any:
    """A body has two per cent more mass in its energy than in its motion."""
    return lambda q, v, p: 1.02 * kinetic(q, v, p)


def without(row: int) -> Callable[[Any], Any]:
    """The power of one effect or driver is left out."""

    def make(powers: Any) -> Any:
        def less(t: Any, q: Any, v: Any, p: Any, modes: Any, lam: Any, out: Any) -> None:
            powers(t, q, v, p, modes, lam, out)
            out[row] = 0.0

        return less

    return make


def reversed_sign(powers: Any) -> Any:
    """All powers have the wrong sign."""

    def opposite(t: Any, q: Any, v: Any, p: Any, modes: Any, lam: Any, out: Any) -> None:
        powers(t, q, v, p, modes, lam, out)
        for i in range(len(out)):
            out[i] = -out[i]

    return opposite


WRONG = [
    ("loaded", "potential", negative),
    ("loaded", "potential", stepped),
    ("loaded", "potential", gauged),
    ("loaded", "kinetic_energy", heavier),
    ("loaded", "powers", reversed_sign),
    ("loaded", "powers", without(0)),
    ("loaded", "powers", without(1)),
    ("swinging", "potential", negative),
    ("swinging", "powers", reversed_sign),
    ("swinging", "powers", without(1)),
]


@pytest.mark.parametrize(("scene", "kernel", "make"), WRONG)
@pytest.mark.parametrize("method", ["dop853", "dopri5"])
def test_wrong_energy_ends_the_run(
    machines: dict[str, Machine], scene: str, kernel: str, make: Callable[[Any], Any], method: str
) -> None:
    machine = changed(machines[scene], kernel, make)
    # Few samples hide nothing: each step is looked at.
    run = machine.simulate(5.0, [0.0, 5.0], rtol=1e-8, method=method)
    assert run.outcome is Outcome.CONTRADICTED
    assert "energy changes by" in run.message
    assert run.t[-1] < 5.0


def pieces_apart(potential: Any) -> Any:
    """The pieces of the potential do not meet where the condition changes."""
    return lambda t, q, p, modes: potential(t, q, p, modes) + 5.0 * modes[0]


def test_pieces_of_a_potential_meet(machines: dict[str, Machine]) -> None:
    assert machines["gusty"].simulate(2.0).outcome is Outcome.OK
    run = changed(machines["gusty"], "potential", pieces_apart).simulate(2.0)
    assert run.outcome is Outcome.CONTRADICTED
    assert "condition p_x > 0.3 of gust" in run.message
    assert "jumps there by 5 J" in run.message
    assert run.t[-1] == pytest.approx(0.3, abs=1e-12)


@pytest.mark.parametrize("scene", ["cancelling", "constant"])
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-11])
def test_rounding_of_terms_that_cancel_is_no_fault(
    machines: dict[str, Machine], scene: str, rtol: float
) -> None:
    """5e15 J of one effect beside as many of another: the sum is right to a joule."""
    assert machines[scene].simulate(20.0, rtol=rtol).outcome is Outcome.OK


@pytest.mark.parametrize("scene", FLAT)
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-8, 1e-10, 1e-12])
def test_rounding_that_hides_a_slope_is_no_fault(
    machines: dict[str, Machine], scene: str, rtol: float
) -> None:
    """Neighbours are equal near the start: shorter rows of states show no scatter."""
    assert machines[scene].simulate(5.0, rtol=rtol).outcome is Outcome.OK


@pytest.mark.parametrize("scene", ["turning", "huge"])
@pytest.mark.parametrize("rtol", [1e-9, 1e-12])
def test_rounding_of_sums_near_their_flat_places_is_no_fault(
    machines: dict[str, Machine], scene: str, rtol: float
) -> None:
    """Steps of a coarse sum are wide there: in rows over which few values differ none scatters."""
    random = np.random.default_rng(8)
    for _ in range(8):
        places, speeds = (
            random.normal(size=2) * 10 ** random.uniform(-3, -1, 2),
            random.normal(size=2),
        )
        start = dict(
            zip(("p.x", "p.y", "p.vx", "p.vy"), map(float, [*places, *speeds]), strict=True)
        )
        assert (
            machines[scene].simulate(0.5, [0.0, 0.5], rtol=rtol, start=start).outcome is Outcome.OK
        ), start


@pytest.mark.parametrize("rtol", [1e-5, 1e-8, 1e-12])
def test_flat_potential_raises_no_alarm_and_no_work(workshop: Path, rtol: float) -> None:
    """Far from its bend it is 1e-14 J beside some joules, and falls below their rounding."""
    model = Model("flat_beside_others")
    p = model.particle("p", mass=1.0)
    model.potential("flat", 1e3 * ((p.x / 100) ** 8 + (p.y / 100) ** 8))
    model.potential("well", 5 * p.x**2 + 7 * p.y**2)
    model.force("push", p, 0.3 * sin(3 * t), 0)
    start = {p.x: 0.5, p.y: 0.2, p.vx: 1.0, p.vy: 0.3}
    for scene, effects in (("bare", ["well", "push"]), ("beside", ["flat", "well", "push"])):
        model.scene(scene, effects, start=start)
    bare, beside = (
        load(model, scene, folder=workshop).simulate(5.0, rtol=rtol) for scene in ("bare", "beside")
    )
    assert bare.outcome is beside.outcome is Outcome.OK
    for count in ("steps", "rejected", "rhs_evaluations", "balance_rhs"):
        assert beside.stats[count] == bare.stats[count]


def lifted(potential: Any) -> Any:
    """The potential grows by 10 J a metre, which no force is the slope of."""
    return lambda t, q, p, modes: potential(t, q, p, modes) + 10.0 * q[0]


def test_fault_above_the_rounding_is_found(machines: dict[str, Machine]) -> None:
    run = changed(machines["cancelling"], "potential", stepped_high).simulate(20.0)
    assert run.outcome is Outcome.CONTRADICTED
    assert changed(machines["gusty"], "potential", lifted).simulate(2.0).t[-1] == 0.0


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize("scene", WAVES)
@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_shape_of_a_potential_is_no_rounding(
    machines: dict[str, Machine], scene: str, rtol: float
) -> None:
    """A step as steep as 1e9 a metre is passed between two evaluations of its force."""
    run = machines[scene].simulate(3.0, rtol=rtol)
    assert run.outcome is Outcome.CONTRADICTED
    assert 0.19 < run.t[-1] < 1.0  # 92 steps in a row are not watched
    end = machines[scene].simulate(0.19, rtol=rtol)
    assert end.outcome is Outcome.OK


def stepped_high(potential: Any) -> Any:
    """A step of 500 J, hundreds of times the rounding."""
    return lambda t, q, p, modes: potential(t, q, p, modes) + (500.0 if q[0] > 0.3 else 0.0)


def test_one_look_does_not_end_a_run(machines: dict[str, Machine]) -> None:
    """An energy that is wrong at the end of one step, and right where it is taken again."""
    plain = machines["loaded"].simulate(2.0, "steps")
    spot = float(plain.samples.q[5, 0])

    def glitch(potential: Any) -> Any:
        return lambda t, q, p, modes: (
            potential(t, q, p, modes) + (3.0 if abs(q[0] - spot) < 1e-9 else 0.0)
        )

    run = changed(machines["loaded"], "potential", glitch).simulate(2.0, "steps")
    assert run.outcome is Outcome.OK
    assert not np.isclose(run.t, plain.t[5], rtol=1e-6).any()


def livelier(restitution: Any) -> Any:
    """The contact throws the ball back faster than it came."""

    def more(p: Any, out: Any) -> None:
        out[:] = 1.05

    return more


def test_impact_must_not_raise_the_energy(machines: dict[str, Machine]) -> None:
    assert machines["bouncing"].simulate(3.0).outcome is Outcome.OK
    run = changed(machines["bouncing"], "restitution", livelier).simulate(3.0)
    assert run.outcome is Outcome.CONTRADICTED
    assert "energy jumps there by" in run.message
    assert run.t[-1] == pytest.approx(np.sqrt(2.0 / 9.81), abs=1e-9)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("method", ["dop853", "dopri5", "tsit5", "bdf", "radau5"])
@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-7, 1e-11])
def test_right_energy_is_never_contradicted(
    machines: dict[str, Machine], scene: str, method: str, rtol: float
) -> None:
    run = machines[scene].simulate(5.0, rtol=rtol, method=method)
    assert run.outcome is Outcome.OK


def test_no_potential_depends_on_the_time(workshop: Path) -> None:
    """What moves by itself is a force with a power: the balance asks potentials for no ∂V/∂t."""
    model = Model("moved")
    p = model.particle("p", mass=1.0)
    model.gravity("g", (sin(t), -9.81))
    model.potential("well", 5 * (p.x - sin(t)) ** 2)
    model.potential("switched", sp.Piecewise((p.y**2, t < 1), (p.y**2 * t**2, True)))
    model.spring("coil", model.ground.at(0.1 * sin(5 * t), 0), p, stiffness=20.0, free_length=1.0)
    model.contact("wall", gap=p.y + 2 + 0.1 * sin(t), stiffness=50.0)
    model.potential("fixed", 3 * p.x**2 + p.y)
    effects = ["g", "well", "switched", "coil", "wall", "fixed"]
    model.scene("s", effects, start={p.x: 1.0, p.y: 0.0, p.vx: 0.0, p.vy: 0.0})
    machine = load(model, "s", folder=workshop)
    run = machine.simulate(3.0)
    assert run.outcome is Outcome.OK
    potential, q, modes = (
        machine.mechanism.kernels.potential,
        run.samples.q[-1],
        run.samples.modes[-1],
    )
    energies = [potential(at, q, np.ones(99), modes) for at in (0.0, 0.4, 7.0)]
    assert energies == 3 * [pytest.approx(3 * q[0] ** 2 + q[1])]


@pytest.mark.parametrize("scene", SCENES)
def test_looks_cost_two_per_cent_of_the_evaluations(
    machines: dict[str, Machine], scene: str
) -> None:
    stats = machines[scene].simulate(60.0, [0.0, 60.0], rtol=1e-9).stats
    assert stats["balance_rhs"] <= 0.02 * stats["rhs_evaluations"] + 30


@pytest.mark.parametrize("scene", SCENES)
def test_checks_change_no_number(machines: dict[str, Machine], scene: str) -> None:
    plain = Machine(replace(machines[scene].mechanism))
    plain.mechanism.__dict__["system"] = replace(plain.mechanism.system, balanced_rows=-1)
    runs = [machine.simulate(5.0) for machine in (machines[scene], plain)]
    np.testing.assert_array_equal(runs[0].samples.q, runs[1].samples.q)
    assert runs[1].stats["balance_rhs"] == 0


@pytest.mark.usefixtures("blind")
@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
@pytest.mark.parametrize("instants", ["steps", [0.0, 1.0]])
def test_energy_of_reduced_coordinates_is_judged(
    workshop: Path, rtol: float, instants: list[float] | str
) -> None:
    """A bar turns over a step that no force shows, and over the same potential without it.

    So does one that is driven and damped, whose powers explain the rest between ends of steps.
    """
    ends = []
    for name, height in (("stepped", 0.25), ("level", 0.0)):
        model = Model(f"bar_{name}")
        bar = model.body("bar", mass=1.0, inertia=0.1)
        model.revolute("O", model.ground.at(0, 0), bar.at(0, 0))
        step = height * tanh(1e9 * (bar.phi - 1.0013))
        model.potential("shape", 0.02 * cos(200 * bar.phi) + step)
        model.torque("motor", on=bar, value=0.3 * cos(3 * t) - 0.01 * bar.omega)
        begin = {bar.phi: 0.0, bar.omega: 5.0}
        model.scene("s", ["shape"], start=begin)
        model.scene("powered", ["shape", "motor"], start=begin)
        for scene in ("s", "powered") if instants == "steps" else ("s",):
            machine = load(model, scene, folder=workshop)
            ends.append(machine.simulate(1.0, instants, rtol=rtol, formulation="reduced"))
    half = len(ends) // 2
    assert {run.outcome for run in ends[:half]} == {Outcome.CONTRADICTED}
    assert {run.outcome for run in ends[half:]} == {Outcome.OK}
    assert all("the energy changes by" in run.message for run in ends[:half])
    assert not any("Repeated" in run.message for run in ends[half:])
