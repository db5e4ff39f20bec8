"""Joints that come and go at one instant: one set, one impact, in any order of declaration."""

from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import cos

from codegen import Model, build, t
from runtime import load, load_result
from runtime.core.outcomes import Outcome
from runtime.results.result import Result

LENGTH, MASS, SPEED = 1.2, 2.0, 0.8


def on_rails(model: Model, **masses: float) -> list[Any]:
    """Particles that move along x."""
    found = [model.particle(name, mass) for name, mass in masses.items()]
    for one in found:
        model.absolute(f"rail_{one.name}", one, "y", 0.0)
    return found


def lost(r: Result) -> float:
    """J, in all impacts of joints."""
    return sum(one.energy_lost for one in r.reconnections)


def swap(first: str, release: Any = None, engage: Any = None) -> Model:
    """A bar turns about its end A, which lets go at t = 1 where the other end is caught at B."""
    model = Model(f"pins_swap_{first}")
    bar = model.body("bar", mass=MASS, inertia=MASS * LENGTH**2 / 12)
    end = model.ground.at(LENGTH * np.cos(SPEED), LENGTH * np.sin(SPEED))
    a = model.revolute("A", model.ground.at(0, 0), bar.at(-LENGTH / 2, 0))
    b = model.revolute("B", end, bar.at(LENGTH / 2, 0))
    changes = [(model.release, a, release), (model.engage, b, engage)]
    for change, joint, when in changes if first.startswith("release") else changes[::-1]:
        change(joint, when=when(bar) if when else t > 1)
    model.scene("turn", start={bar.phi: 0.0, bar.omega: SPEED})
    return model


@pytest.mark.parametrize("first", ["release", "engage"])
def test_a_bar_swaps_its_pin(workshop: Path, first: str) -> None:
    """The free bar keeps its momentum about B, so that ω goes over into -ω/2."""
    machine = load(swap(first), folder=workshop)
    for settings in ({}, {"method": "radau5"}, {"formulation": "reduced"}):
        r = machine.simulate(2.0, 5, **settings)
        assert r.outcome is Outcome.OK
        assert_allclose(r.v("bar.omega")[-1], -SPEED / 2, atol=1e-8)
        inertia = MASS * LENGTH**2 / 3
        assert_allclose(lost(r), inertia * SPEED**2 * 3 / 8, atol=1e-8)
        assert r.reconnections[0].action == first


@pytest.mark.parametrize("later", [0.0, 1e-6])
def test_instants_that_agree_to_the_error_of_the_run_are_one(workshop: Path, later: float) -> None:
    """The position says when A lets go, the clock when B engages; with B before, the bar stops."""
    changes = {"release": lambda bar: bar.phi > SPEED * (1 + later), "engage": lambda _: t > 1}
    for first in changes:
        machine = load(swap(f"{first}_{later > 0}", **changes), folder=workshop)
        for settings in ({},) if later else ({}, {"method": "radau5"}):
            omega = machine.simulate(2.0, 5, **settings).v("bar.omega")[-1]
            assert_allclose(omega, 0.0 if later else -SPEED / 2, atol=1e-8)


def test_reduced_coordinates_past_a_set_that_they_do_not_suit(workshop: Path) -> None:
    """With the lock nothing is left to integrate, which is so in all coordinates alone."""
    model = Model("locked_between")
    (a,) = on_rails(model, a=1.0)
    model.engage(model.constraint("lock", a.x - 1), when=a.x > 1, until=t > 2)
    model.force("push", a, fx=3.0)
    model.scene("go", ["push"], start={a.x: 0.0, a.vx: 1.0})
    r = load(model, folder=workshop).simulate(3.0, formulation="reduced")
    assert r.outcome is Outcome.OK
    assert_allclose([r.at(1.5).q("a.x")[0], r.q("a.x")[-1]], [1.0, 2.5], rtol=1e-9)


def handed_over(order: str, released: float = 1.0) -> Model:
    """A block stands locked until a driven cart reaches it, and rides with the cart from there."""
    model = Model(f"handed_over_{order}_{released * 10:g}")
    cart, block = on_rails(model, cart=1.0, block=1.0)
    model.driver("feed", cart.x, 1 - cos(t))  # at x = 1 with the speed 1
    lock = model.constraint("lock", block.x - 1)
    ride = model.constraint("ride", block.x - cart.x)
    if order == "lock":
        model.release(lock, when=cart.x > released)
    model.engage(ride, when=cart.x > 1)
    if order == "ride":
        model.release(lock, when=cart.x > released)
    model.scene("run", drivers=["feed"], start={})
    return model


@pytest.mark.parametrize(("order", "released"), [("lock", 1.0), ("ride", 1.0), ("lock", 1 - 1e-9)])
def test_joints_hand_over(workshop: Path, order: str, released: float) -> None:
    """Both act together in no instant; with the driver they permit no motion."""
    model = handed_over(order, released)
    assert len(build(model, out=workshop / "all", compile=False).scenes) == 3
    r = load(model, folder=workshop).simulate(3.0, 301)
    assert r.outcome is Outcome.OK
    assert_allclose(r.q("block.x"), np.maximum(1, r.q("cart.x")), atol=1e-9)
    assert_allclose(lost(r), 0.5, atol=1e-8)


def test_joints_that_permit_no_motion_end_the_run_by_name(workshop: Path) -> None:
    r = load(handed_over("ride", 1.1), folder=workshop).simulate(3.0)
    assert r.outcome is Outcome.INCONSISTENT
    assert "Joint 'ride' is to engage at t = 1.57079633 s, and the joints that act" in r.message
    assert "5 constraints on 4 coordinates" in r.message


@pytest.mark.parametrize("order", [*permutations(range(3))][::2])
def test_what_an_impact_makes_true_is_an_impact_of_its_own(
    workshop: Path, order: tuple[int, ...]
) -> None:
    """A wagon meets three that stand together, each of which hooks on once it is pushed."""
    model = Model("wagons_" + "".join(map(str, order)))
    a, b, c, d = on_rails(model, a=2.0, b=1.0, c=1.0, d=3.0)
    pairs = (b, a, a.x > b.x), (c, b, b.vx > 0.1), (d, c, c.vx > 0.1)
    hooks = [(model.constraint(f"to_{o.name}", o.x - two.x), when) for o, two, when in pairs]
    for k in order:
        model.engage(hooks[k][0], when=hooks[k][1])
    start = {a.x: 0.0, a.vx: 2.0} | {one.x: 1.0 for one in (b, c, d)}
    model.scene("go", start=start | {one.vx: 0.0 for one in (b, c, d)})
    r = load(model, folder=workshop).simulate(1.0)
    assert [one.joint for one in r.reconnections] == ["to_b", "to_c", "to_d"]
    assert len({one.time for one in r.reconnections}) == 1
    speeds = 4 / np.array([2, 3, 4, 7])
    assert_allclose([one.energy_lost for one in r.reconnections], -2 * np.diff(speeds), rtol=1e-9)
    impulses = [one.impulse["force"] for one in r.reconnections]
    assert_allclose(impulses, [speeds[1], speeds[2], 3 * speeds[3]], rtol=1e-9)


def meeting(name: str, until: bool) -> Model:
    """Two masses that hook on to each other, where perhaps the run ends."""
    model = Model(name)
    a, b = on_rails(model, a=2.0, b=1.0)
    model.engage(model.constraint("hook", b.x - a.x), when=a.x > b.x)
    ends = {"met": a.x > b.x, "slow": a.vx < 1.5} if until else None
    model.scene("go", start={a.x: 0.0, a.vx: 2.0, b.x: 1.0, b.vx: 0.0}, until=ends)
    return model


@pytest.mark.parametrize("saved", [False, True])
def test_a_run_that_ends_where_joints_change_goes_on_with_the_change(
    workshop: Path, saved: bool
) -> None:
    machine = load(meeting("meet_and_end", True), folder=workshop)
    r = machine.simulate(2.0)
    assert (r.ended_by, r.reconnections, r.v("a.vx")[-1]) == ("met", (), 2.0)
    back = load_result(r.save(workshop / "met.nc"), machine) if saved else r
    for then in (back.resume(1.0), machine.simulate(1.0, start=back)):
        assert then.ended_by == "slow"  # which the impact makes true
        assert_allclose([lost(then), then.v("a.vx")[-1]], 4 / 3, rtol=1e-12)
        assert "engaged" in then.message
        back = load_result(then.save(workshop / "slow.nc"), machine) if saved else then
        assert back.reconnections == then.reconnections
        for last in (back.resume(1.0), machine.simulate(1.0, start=back)):
            assert (last.ended_by, last.reconnections) == ("", ())
            assert_allclose(last.v("a.vx"), 4 / 3, rtol=1e-12)


def test_a_run_whose_time_ends_at_a_change_goes_on_with_it(workshop: Path) -> None:
    """Before the change or behind it: it is told once."""
    machine = load(meeting("meet_at_the_end", False), folder=workshop)
    for ulps in range(-4, 3):
        r = machine.simulate(0.5 + ulps * 2.0**-53)
        for then in (r.resume(1.0), machine.simulate(1.0, start=r)):
            assert len(r.reconnections + then.reconnections) == 1, ulps
            assert_allclose(then.v("b.vx")[-1], 4 / 3, rtol=1e-12)


def test_a_moving_place_that_lets_go_again_does_work(workshop: Path) -> None:
    model = Model("place_until")
    (b,) = on_rails(model, b=1.0)
    model.engage(model.constraint("hook", b.x - 2 * t), when=t > 0.25, until=t > 0.75)
    model.force("push", b, fx=1.0, when=t > 0.25)
    model.scene("go", ["push"], start={b.x: 0.5, b.vx: 0.0}, outputs="all")
    r = load(model, folder=workshop).simulate(1.0)
    assert_allclose(r.works["hook"][-1], -1.0, rtol=1e-9)


@pytest.mark.parametrize("by", ["driver", "place"])
def test_the_energy_of_an_impact_with_what_is_driven(workshop: Path, by: str) -> None:
    """What moves at 2 m/s catches 1 kg that rests: it does 4 J of work, of which 2 J are lost."""
    model = Model(f"caught_by_{by}")
    platform, b = on_rails(model, platform=5.0, b=1.0)
    model.driver("drive", platform.x, 2 * t)
    hook = model.constraint("hook", b.x - (platform.x if by == "driver" else 2 * t))
    model.engage(hook, when=platform.x > b.x)
    model.scene("go", [], ["drive"], start={b.x: 1.0, b.vx: 0.0})
    r = load(model, folder=workshop).simulate(1.0)
    assert_allclose([lost(r), *r.reconnections[0].impulse.values()], 2, rtol=1e-9)
