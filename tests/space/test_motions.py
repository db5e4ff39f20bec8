"""Free bodies, tops and a slider-crank against closed forms and a published state."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from models.space.heavy_top import heavy_top
from runtime import load
from runtime.core.outcomes import Outcome
from tests.space.closed_forms import SpatialSliderCrank
from tests.space.free_body import FreeBody
from tests.space.heavy_top import sleeping_limit
from tests.space.machines import Z, free_body, top

METHODS = ("dop853", "radau5", "bdf")
# the heavy top after 1 s, by its own ODE in ω' and p at rtol 1e-13
PUBLISHED = (0.17334396, 0.64008859, -0.74849079)


@cache
def loaded(declare: Any, workshop: Path, *given: Any) -> Any:
    return load(declare(*given), folder=workshop)


@pytest.mark.parametrize("start", [(1.0, 0.0, 0.6), (1.0, 0.0, 1.0)])
def test_a_free_body_flips_fifty_times_as_jacobi_says(
    start: tuple[float, float, float], workshop: Path
) -> None:
    moments, w = np.array([1.0, 2.0, 3.0]), np.array(start)
    form = FreeBody(moments, w)
    t = np.linspace(0.0, 50 * form.flip_time, 51)
    expected = np.array([form.omega(time) for time in t]).T
    machine = loaded(free_body, workshop, (1.0, 0.0, 0.6))
    values = {f"rod.omega_{c}": x for c, x in zip("xyz", start, strict=True)}
    result = machine.simulate(t[-1], t, start=values, rtol=1e-14, progress=False)
    found = [result.v(f"rod.omega_{c}") for c in "xyz"]
    assert np.sum(np.diff(np.sign(found[1])) != 0) >= 49
    assert_allclose(found, expected, rtol=0.0, atol=1e-9)
    turned = [form.attitude(time) for time in t]
    assert_allclose(result.rotation("rod"), turned, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_the_heavy_top_is_where_it_was_published(method: str, workshop: Path) -> None:
    machine = loaded(heavy_top, workshop)
    result = machine.simulate(1.0, 11, rtol=1e-9, method=method, progress=False)
    assert result.outcome is Outcome.OK
    assert_allclose([result.q(f"top.{c}")[-1] for c in "xyz"], PUBLISHED, rtol=0.0, atol=1e-7)
    length = sum(result.q(f"top.e{k}") ** 2 for k in range(4))
    assert_allclose(length, 1.0, rtol=0.0, atol=1e-13)
    assert_allclose(result.v("top.omega_y"), 150.0, rtol=0.0, atol=1e-4)
    assert np.ptp(result.energy()) < 1e-3  # of 5.4 kJ
    weight = [result.reaction("tip", f"f{c}") - 15.0 * result.a(f"top.{c}") for c in "xyz"]
    assert_allclose(weight, np.array([[0, 0, 15.0 * 9.81]] * 11).T, rtol=0.0, atol=1e-9)


def test_the_heavy_top_to_eight_digits(workshop: Path) -> None:
    result = loaded(heavy_top, workshop).simulate(1.0, [1.0], rtol=1e-12, progress=False)
    assert_allclose([result.q(f"top.{c}")[-1] for c in "xyz"], PUBLISHED, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize(("share", "sleeps"), [(1.05, True), (0.95, False)])
def test_a_top_sleeps_above_the_critical_spin(share: float, sleeps: bool, workshop: Path) -> None:
    """An upright top is stable from J3 ω = 2 √(m g l J1) on, J1 about the tip."""
    mass, own, spin = 2.0, 0.4, 0.3
    critical = sleeping_limit(mass, 1.0, own, spin)

    def declared() -> Model:
        return top("sleeping_top", mass, (own, own, spin), Z, (1e-4, 0.0, 100.0))

    machine = load(declared(), folder=workshop)
    values = {"top.omega_z": share * critical}
    result = machine.simulate(20.0, 2001, start=values, rtol=1e-10, progress=False)
    tilt = np.hypot(result.q("top.x"), result.q("top.y")).max()
    assert bool(tilt < 1e-3) is sleeps
    assert tilt > 1e-6  # it is disturbed


def test_a_symmetric_top_precesses_steadily(workshop: Path) -> None:
    """Ω of a top with a horizontal axis: m g l = J3 ω Ω, exactly (Landau, section 35)."""
    mass, spin, rate = 15.0, 0.46875, 150.0
    around = mass * 9.81 / (spin * rate)
    machine = loaded(heavy_top, workshop)
    # ω' at A = I: the spin about y', and Ω about the vertical z
    values = {"top.omega_y": rate, "top.omega_z": around}
    result = machine.simulate(3.0, 301, start=values, rtol=1e-11, progress=False)
    assert_allclose(result.q("top.z"), 0.0, rtol=0.0, atol=1e-8)
    angle = np.unwrap(np.arctan2(result.q("top.y"), result.q("top.x")))
    assert_allclose(angle - angle[0], around * result.t, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize(
    ("length", "reach", "fastest", "torque"),
    [
        (0.3, (0.18495, 0.29016), 2.667, (-0.2030, 0.2975)),
        (0.27, (0.13079, 0.25902), 3.772, (-0.2825, 0.3369)),
        (0.24, (0.04251, 0.22758), 11.604, (-0.9868, 0.7407)),
    ],
)
def test_the_driven_slider_crank_of_the_book(
    length: float, reach: tuple[float, float], fastest: float, torque: tuple[float, float]
) -> None:
    """Haug 12.2: x and ẍ in closed form, the torque by the power of the driver.

    The torques are differences of T + V of the rod and the slider, found apart from this program.
    """
    machine = load("space/spatial_slider_crank", "inverse_dynamics")
    result = machine.inverse_dynamics(1.0, 1001, parameters={"length": length}, progress=False)
    angle = np.pi / 2 - 2 * np.pi * result.t
    x = np.array([float(SpatialSliderCrank(length).slider(one)) for one in angle])
    assert_allclose(result.q("slider.x"), x, rtol=0.0, atol=1e-12)
    assert_allclose([x.min(), x.max()], reach, rtol=0.0, atol=1e-5)
    assert np.abs(result.a("slider.x")).max() == pytest.approx(fastest, abs=1e-3)
    assert_allclose(result.v("crank.omega_x"), -2 * np.pi, rtol=1e-12)
    found = result.power("drive") / (2 * np.pi)
    assert_allclose([found.min(), found.max()], torque, rtol=0.0, atol=1e-4)
