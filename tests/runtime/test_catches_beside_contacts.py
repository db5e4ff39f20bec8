"""Joints that engage while contacts are closed and freewheels grip: impulses by hand."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, t
from runtime import Outcome, Result, load

G = 9.81


def dog_clutch(third_speed: float) -> Model:
    """Two shafts that a dog clutch couples at 0.5 s, and a third one behind a freewheel."""
    model = Model("dog_clutch")
    sizes = {"one": 0.5, "two": 0.3, "three": 0.2}
    one, two, three = (model.body(name, mass=1.0, inertia=j) for name, j in sizes.items())
    for k, body in enumerate((one, two, three)):
        model.revolute(f"bearing_{k}", model.ground.at(k, 0), body)
    dog = model.constraint("dog", two.phi - one.phi)
    model.engage(dog, when=one.phi > two.phi)
    model.one_way_clutch("freewheel", two, three)
    start = {one.phi: -1.5, one.omega: 3.0, two.phi: 0.0, two.omega: 0.0}
    start |= {three.phi: 0.0, three.omega: third_speed}
    model.scene("run", ["freewheel"], start=start, outputs="all")
    return model


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize(
    ("third", "speed", "impulse"), [(0.0, 1.5, 0.75), (1.6, 1.82, 0.59), (5.0, 1.875, 0.5625)]
)
def test_a_freewheel_takes_part_in_a_catch(
    workshop: Path, third: float, speed: float, impulse: float, formulation: str
) -> None:
    """0.5·3 + 0.2·ω3 is shared by 1 kg m², or 1.5 by 0.8 kg m² where the third is faster."""
    r = load(dog_clutch(third), folder=workshop).simulate(1.0, rtol=1e-11, formulation=formulation)
    (caught,) = r.reconnections
    behind = r.t > caught.time + 1e-9
    last = max(third, speed)
    assert_allclose(caught.time, 0.5, atol=1e-9)
    for name, omega in (("one", speed), ("two", speed), ("three", last)):
        assert_allclose(r.v(f"{name}.phi")[behind], omega, atol=1e-9)
    assert_allclose(np.abs([*caught.impulse.values()]), [impulse], atol=1e-9)
    before = (0.5 * 3.0**2 + 0.2 * third**2) / 2
    after = (0.8 * speed**2 + 0.2 * last**2) / 2
    assert_allclose(caught.energy_lost, before - after, atol=1e-9)


def hooked(workshop: Path, y: float, vy: float, t_end: float) -> Result:
    """A plate of 2 kg rests on the floor; a load of 1 kg on the same rail hooks in where it is."""
    model = Model("hook", gravity=(0, -G))
    plate, weight = (model.body(n, mass=m, inertia=1) for n, m in (("plate", 2.0), ("weight", 1.0)))
    for body in (plate, weight):
        model.translational(f"rail_{body.name}", model.ground.at(0, 0), body.at(0, 0), axis=(0, 1))
    floor = {"restitution": 0.5, "free_length": 0.0, "direction": (0, 1)}
    model.contact("floor", model.ground.at(0, 0), plate.at(0, 0), **floor)
    catch = model.constraint("catch", weight.y - plate.y)
    model.engage(catch, when=weight.y < plate.y if y > 0 else weight.y > plate.y)
    start = {plate.y: 0.0, plate.vy: 0.0, weight.y: y, weight.vy: vy}
    model.scene("run", ["gravity", "floor"], start=start, outputs="all")
    r = load(model, folder=workshop).simulate(t_end, rtol=1e-11)
    assert r.outcome is Outcome.OK, r.message
    return r


def test_a_floor_bears_what_falls_into_a_catch(workshop: Path) -> None:
    """The floor takes the whole momentum at once: nothing rebounds, as nothing approached it."""
    r = hooked(workshop, 1.0, 0.0, 1.0)
    (caught,) = r.reconnections
    speed = np.sqrt(2 * G)
    assert_allclose(caught.time, speed / G, atol=1e-9)
    assert_allclose(np.abs([*caught.impulse.values()]), [speed], atol=1e-9)
    assert_allclose(caught.energy_lost, G, atol=1e-8)
    behind = r.t > caught.time
    assert_allclose(r.q("weight.y")[behind], 0.0, atol=1e-9)
    assert_allclose(r.v("plate.y")[behind], 0.0, atol=1e-9)
    assert_allclose(r.force("floor")[behind], 3 * G, atol=1e-8)


def test_a_floor_does_not_hold_back_what_is_lifted(workshop: Path) -> None:
    r = hooked(workshop, -1.0, 6.0, 0.4)
    (caught,) = r.reconnections
    speed = np.sqrt(36 - 2 * G)
    assert_allclose(np.abs([*caught.impulse.values()]), [2 * speed / 3], atol=1e-9)
    assert_allclose(caught.energy_lost, speed**2 / 2 - speed**2 / 6, atol=1e-9)
    behind = r.t > caught.time + 1e-9
    expected = speed / 3 - G * (r.t[behind] - caught.time)
    assert_allclose(r.v("plate.y")[behind], expected, atol=1e-8)


def test_a_catch_against_a_sprag_is_told_by_name(workshop: Path) -> None:
    """A shaft that is driven backwards engages one that a sprag keeps from turning back."""
    model = Model("against")
    one, two = (model.body(name, mass=1.0, inertia=0.5) for name in ("one", "two"))
    for k, body in enumerate((one, two)):
        model.revolute(f"bearing_{k}", model.ground.at(k, 0), body)
    model.driver("motor", one.phi, 0.5 - t)
    dog = model.constraint("dog", two.phi - one.phi)
    model.engage(dog, when=one.phi < two.phi)
    model.one_way_clutch("sprag", model.ground, two)
    model.scene("run", ["sprag"], ["motor"], start={two.phi: 0.0, two.omega: 0.0})
    r = load(model, folder=workshop).simulate(1.0)
    assert r.outcome is Outcome.INCONSISTENT
    assert "Joint 'dog' is to engage at t = 0.5 s" in r.message
    assert "sprag" in r.message
    assert r.t[-1] <= 0.5 + 1e-9


def test_a_search_for_impulses_that_does_not_end_is_told_by_name(
    workshop: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def endless(*_: object) -> None:
        raise RuntimeError("Maximum number of iterations reached.")

    monkeypatch.setattr("scipy.optimize.nnls", endless)
    r = load(dog_clutch(0.0), folder=workshop).simulate(1.0)
    assert r.outcome is Outcome.INCONSISTENT
    assert "'dog' is to engage" in r.message
    assert "no impulses of freewheel" in r.message
