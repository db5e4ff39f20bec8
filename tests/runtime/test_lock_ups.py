"""Runs that end at a lock-up of partly driven machines, or where friction jams: by that name."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen import Model
from codegen import t as time
from runtime import load
from runtime.core.outcomes import Outcome, Site
from runtime.dynamics.checks.jamming import blocking_rows
from runtime.machine_facade import Machine
from tests.random_mechanisms import Scales, random_mechanism
from tests.random_mechanisms.dense_dynamics import Dense


def test_a_lock_up_has_one_name_whatever_the_tolerance(tmp_path: Path) -> None:
    """A driver of a length asks for more than pendulums permit, whose speeds grow without bound."""
    pendulums = random_mechanism(48, "tree", "partly", scales=Scales())
    machine = load(pendulums.model(), pendulums.scene, folder=tmp_path)
    for rtol in (1e-9, 1e-12, 1e-13):
        run = machine.simulate(10.0, rtol=rtol)
        assert run.outcome is Outcome.SINGULAR, run.message
        assert run.t[-1] == pytest.approx(0.39231464, abs=2e-8)
        assert "driver drive1.distance" in run.message
        assert run.site in {one.of("drive1.distance") for one in (Site.LOCK_UP, Site.NO_POSITION)}


def test_a_motion_into_a_jam_names_the_joint(tmp_path: Path) -> None:
    """Painlevé's rod tilts until no force at its tip agrees with its friction."""
    model = Model("rod", gravity=(0, -9.81))
    rod = model.body("rod", mass=1.0, inertia=0.1)
    slide = model.revolute_translational("slide", model.ground, rod.at(-1, 0), axis=(1, 0))
    model.friction("rub", slide, 1.0, 1e-3)
    model.scene("drag", ["gravity", "rub"], start={rod.phi: 1.55, rod.x: 0.0, rod.omega: -4.0,
                rod.vx: -3.0}, guess={rod.y: 0.93})  # fmt: skip
    run = load(model, folder=tmp_path).simulate(0.3)
    assert run.outcome is Outcome.NOT_FINITE
    assert 0.1 < run.t[-1] < 0.102
    assert "joint slide.normal. Friction rub in joint slide jams" in run.message
    assert run.site == "end_at_jam: friction or contacts that lock up or jam, of slide.normal"
    assert run.facts()["site"] == run.site


def test_a_singular_start_is_no_jam_of_a_friction_in_it(tmp_path: Path) -> None:
    """A crank and a rod of one length, folded: singular with a friction as without."""
    model = Model("folded", gravity=(0, -9.81))
    crank, rod = (model.body(name, mass=1.0, inertia=0.1) for name in ("crank", "rod"))
    model.revolute("O", model.ground.at(0, 0), crank.at(-0.5, 0))
    model.revolute("A", crank.at(0.5, 0), rod.at(0.5, 0))
    slide = model.revolute_translational("slide", model.ground, rod.at(-0.5, 0), axis=(0, 1))
    model.friction("rub", slide, 0.05, 1e-3)
    guess = {crank.x: 0.5, crank.y: 0, rod.phi: 0, rod.x: 0.5, rod.y: 0}
    model.scene("rubbing", ["gravity", "rub"], start={crank.phi: 0.0, crank.omega: 0.0},
                guess=guess)  # fmt: skip
    run = load(model, folder=tmp_path).simulate(2.0)
    assert run.outcome is Outcome.SINGULAR
    assert "jams" not in run.message
    assert run.site == Site.START_RANK.of("slide.normal")


@pytest.mark.parametrize(("seed", "kept"), [(62, "friction rub0"), (74, "contact or stop stop0")])
def test_what_sticks_or_is_closed_locks_a_driven_machine_up(
    seed: int, kept: str, tmp_path: Path
) -> None:
    """The joints alone are independent there, and the forces grow without bound."""
    driven = random_mechanism(seed, friction="sticking", contacts="rigid")
    machine = load(driven.model(), driven.scene, folder=tmp_path)
    run = machine.simulate(driven.horizon, rtol=1e-9, progress=False)
    assert run.outcome is Outcome.LOCKED, run.message
    assert f"What {kept} keeps as it is" in run.message
    dense = Dense(driven.parts, driven.scales.length)
    order = [run.description.coordinates.names.index(name) for name in dense.names]
    q, t = run.samples.q[-1, order], float(run.t[-1])
    assert dense.least_singular_value(q, t, [kept.rsplit(maxsplit=1)[-1]]) < 1e-4
    assert dense.least_singular_value(q, t) > 1e-4


@pytest.fixture(scope="module")
def bouncing_into_a_lock_up(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    """A driver closes contact stop0, which bounces ever faster until it holds the machine."""
    driven = random_mechanism(74, friction="sticking", contacts="rigid")
    return load(driven.model(), driven.scene, folder=tmp_path_factory.mktemp("lock_up"))


@pytest.mark.parametrize("rtol", [1e-7, 1e-9, 1.1e-9, 1.2e-9, 2e-9, 5e-9, 1e-10, 1e-12])
def test_a_lock_up_has_one_name_however_rounding_ends_its_bounces(
    rtol: float, bouncing_into_a_lock_up: Machine
) -> None:
    """The contact ends closed, without consistent modes, or open and in ever shorter steps."""
    run = bouncing_into_a_lock_up.simulate(2.7, rtol=rtol, progress=False)
    assert run.outcome is Outcome.LOCKED, run.message
    assert run.t[-1] == pytest.approx(0.4256325657, abs=1e-10)
    assert "What contact or stop stop0 keeps as it is" in run.message


@pytest.mark.parametrize(
    ("speed", "one_sided", "blocks"),
    [
        (1.0, True, True),  # into the contact
        (-1.0, True, False),  # away from it: it opens
        (-1.0, False, True),  # away, and friction sticks
        (0.0, True, False),  # along it, as where two contacts hold the same
    ],
)
def test_drivers_are_blocked_where_no_velocity_follows_them(
    speed: float, one_sided: bool, blocks: bool
) -> None:
    """A driver of x, one of y at 1, and what keeps x from falling; z is free."""
    rounding = 1e-12
    rows = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, rounding]])
    for lean, expected in ((0.0, blocks), (0.1, False)):
        rows[2, 2] = rounding + lean
        found = blocking_rows(rows, np.array([speed, 1.0, 0.0]), np.array([one_sided]))
        assert found.tolist() == [expected]


def rod_that_rubs(folder: Path, *, weight: bool, creep: float | None) -> Machine:
    """Painlevé's rod, maybe with a weight that a pad keeps on it."""
    model = Model("rod", gravity=(0, -9.81))
    rod = model.body("rod", mass=1.0, inertia=0.1)
    slide = model.revolute_translational("slide", model.ground, rod.at(-1, 0), axis=(1, 0))
    model.friction("rub", slide, 1.0, creep=creep)
    start = {rod.phi: 1.55, rod.x: 0.0, rod.omega: -4.0, rod.vx: -3.0}
    guess = {rod.y: 0.93}
    if weight:
        carried = model.body("carried", mass=0.2, inertia=0.01)
        model.translational("slot", rod, carried, axis=(1, 0))
        model.dry_friction("pad", rod, carried, axis=(1, 0), normal=90.0, coefficient=0.8)
        c, s = 0.2 * np.cos(1.55), 0.2 * np.sin(1.55)
        start |= {carried.x: c, carried.vx: -3.0 + 4.0 * s}
        guess |= {carried.y: 0.93 + s, carried.phi: 1.55}
    effects = ["gravity", "rub", *(["pad"] if weight else [])]
    model.scene("drag", effects, start=start, guess=guess)
    return load(model, folder=folder)


def test_friction_that_sticks_at_rest_is_named_where_it_slides_into_a_jam(tmp_path: Path) -> None:
    """It ends where the same friction with a creep speed does."""
    run = rod_that_rubs(tmp_path, weight=False, creep=None).simulate(0.3, progress=False)
    assert run.outcome is Outcome.NOT_FINITE
    assert 0.1 < run.t[-1] < 0.102
    assert "Friction rub jams" in run.message


@pytest.mark.parametrize("creep", [None, 1e-3])
def test_friction_without_forces_beside_what_sticks_is_named(
    creep: float | None, tmp_path: Path
) -> None:
    run = rod_that_rubs(tmp_path, weight=True, creep=creep).simulate(0.3, progress=False)
    assert run.outcome is Outcome.NOT_FINITE
    assert "Friction rub slides and pad keeps still, and no forces were found" in run.message


def test_a_run_beyond_all_numbers_ends_by_name(tmp_path: Path) -> None:
    """States a millionth of 1e300 s ahead overflow, where a jam is looked for."""
    model = Model("drop", gravity=(0, -9.81))
    ball = model.particle("ball", mass=1.0)
    model.contact("floor", gap=ball.y, restitution=0.5)
    model.scene("fall", ["gravity", "floor"], start={ball.y: 1.0, ball.x: 0.0})
    run = load(model, folder=tmp_path).simulate(1e300)
    assert run.outcome is Outcome.STEP_TOO_SMALL
    assert run.site in (Site.ENDLESS_STEPS.of(""), Site.SHORTEST_STEP.of(""))


def test_a_lock_up_without_masses_speaks_of_no_forces(tmp_path: Path) -> None:
    """Peaucellier's linkage turned to its end: only velocities are lost in its last position."""
    model = Model("peaucellier")
    arms = [model.body(f"arm{k}") for k in (0, 1)]
    inner, outer = ([model.body(f"{word}{k}") for k in (0, 1)] for word in ("inner", "outer"))
    crank = model.body("crank")
    model.revolute("C", model.ground.at(0.35, 0), crank)
    model.revolute("Q", outer[0], outer[1])
    guess: dict[Any, float] = {}
    for k, sign in enumerate((1, -1)):
        model.revolute(f"O{k}", model.ground, arms[k])
        model.revolute(f"P{k}", crank.at(0.35, 0), inner[k])
        model.revolute(f"A{k}", inner[k].at(0.45, 0), arms[k].at(1, 0))
        model.revolute(f"B{k}", outer[k].at(0.45, 0), arms[k].at(1, 0))
        guess |= {arms[k].phi: 0.4 * sign, inner[k].phi: sign, outer[k].phi: 2 * sign}
    model.driver("motor", crank.phi, time)
    model.scene("turn", drivers=["motor"], analysis="kinematics", guess=guess)
    run = load(model, folder=tmp_path).kinematics(2.0)
    assert run.outcome is Outcome.LOCKED
    assert run.t[-1] == pytest.approx(2 * np.arccos(0.55 / 0.7), abs=2e-5)
    assert "forces" not in run.message
