"""Frictions that joints and drivers hold at rest: the least force, in each analysis."""

from pathlib import Path

import pytest
from numpy.testing import assert_allclose
from sympy import Expr, Float, Piecewise

from codegen import Model, t
from codegen.declare.body import Body
from runtime import load
from runtime.machine_facade import Machine

STILL = Float(0.1) + 0 * t
LATER = Piecewise((0.0, t < 1), ((t - 1) ** 2 / 2, True))
STOPS = Piecewise((-((t - 1) ** 2) / 2, t < 1), (0.0, True))
CASES = [
    (STILL, [0, 0, 0, 0], []),
    (LATER, [0, 0, 1, 1], ["slips"]),
    (STOPS, [1, 1, 0, 0], ["sticks"]),
]


def dry(model: Model, arm: Body) -> tuple[float, str]:
    model.absolute("rail", arm, "y", 0.0)
    model.absolute("level", arm, "phi", 0.0)
    model.dry_friction("rub", slip=arm.vx, coefficient=0.3, normal=20.0, static=0.4)
    return 6.0, "anything from -8 to 8 N"


def guide(model: Model, arm: Body) -> tuple[float, str]:
    joint = model.translational("rail", model.ground, arm, axis=(1, 0))
    model.friction("rub", joint, coefficient=0.2, length=0.1)
    return 0.2 * 2.0 * 9.81, "anything from -3.924 to 3.924 N"


@pytest.fixture(scope="module", params=[dry, guide], ids=lambda one: one.__name__)
def held(
    request: pytest.FixtureRequest, workshop: Path
) -> tuple[list[tuple[Expr, list[int], list[str], Machine]], float, str]:
    machines = []
    for k, (law, slides, events) in enumerate(CASES):
        model = Model(f"held_{request.param.__name__}_{k}", gravity=(0, -9.81))
        arm = model.body("arm", mass=2.0, inertia=0.1)
        size, bounds = request.param(model, arm)
        model.driver("feed", arm.x, law)
        model.scene("run", ["gravity", "rub"], drivers=["feed"], outputs="all")
        machines.append((law, slides, events, load(model, "run", folder=workshop)))
    return machines, size, bounds


def test_the_least_force_is_given_and_said_to_be_one_of_many(held: object) -> None:
    machines, size, bounds = held  # type: ignore[misc]
    for law, slides, events, machine in machines:
        instants = [0.0, 0.5, 1.5, 2.0]
        simulated = machine.simulate(2.0, instants)
        assert [e.word for e in simulated.events if e.word] == events
        for r in simulated, machine.inverse_dynamics(instants):
            assert not r.failed
            assert_allclose(r.force("rub"), [-size * k for k in slides], atol=1e-9)
            pushes = [2.0 * float(law.diff(t, 2).subs(t, x)) for x in instants]
            assert_allclose(r.reaction("feed", "fx") + r.force("rub"), pushes, atol=1e-9)
            assert r.not_unique == ("rub", "feed")
            assert bounds in r.message


def test_a_reversal_is_no_rest(workshop: Path) -> None:
    """Where a law turns in an instant, the friction is that of the way on."""
    model = Model("held_turning")
    slide = model.particle("slide", mass=2.0)
    model.absolute("rail", slide, "y", 0.0)
    model.dry_friction("rub", slip=slide.vx, coefficient=0.3, normal=20.0)
    model.driver("feed", slide.x, (t - 1) ** 2)
    model.scene("run", ["rub"], drivers=["feed"])
    machine = load(model, "run", folder=workshop)
    for r in machine.simulate(2.0, [0.0, 0.5, 2.0]), machine.inverse_dynamics([0.0, 0.5, 2.0]):
        assert_allclose(r.reaction("feed", "fx"), [-2.0, -2.0, 10.0])
        assert r.not_unique == ()
