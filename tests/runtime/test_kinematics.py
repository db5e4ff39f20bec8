"""Driven motion against closed forms; branches, lock-up, singular crossings, refusals."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import codegen
from codegen import Model
from codegen.errors import AnalysisError
from runtime import load
from runtime.continuation import driven_motion
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

FloatArray = npt.NDArray[np.float64]
OMEGA = 2.0 * np.pi
BODIES = ("crank", "rod", "slider")


def _slider(t: FloatArray, rod: float = 3.5) -> tuple[FloatArray, FloatArray, FloatArray]:
    """x, its first and its second derivative for a crank of 2 m at pi/4 + 2 pi t."""
    phi = np.pi / 4 + OMEGA * t
    root = np.sqrt(rod**2 - 4.0 * np.sin(phi) ** 2)
    rate = -4.0 * np.sin(phi) * np.cos(phi) / root  # d(root)/d(phi)
    curve = (-4.0 * np.cos(2.0 * phi) - rate**2) / root
    return (
        2.0 * np.cos(phi) + root,
        OMEGA * (-2.0 * np.sin(phi) + rate),
        OMEGA**2 * (-2.0 * np.cos(phi) + curve),
    )


@pytest.mark.parametrize("masses", [True, False])
def test_motion_of_the_slider(make: Callable[..., Machine], masses: bool) -> None:
    name = "driven" if masses else "bare"
    machine = make("slider_crank", name, driven=True, masses=masses)
    t = np.linspace(0.0, 1.0, 201)
    result = machine.kinematics(t)
    x, v, a = _slider(t)
    assert result.outcome is Outcome.OK
    assert not result.failed
    np.testing.assert_allclose(result.q("slider.x"), x, atol=1e-14, rtol=0)
    np.testing.assert_allclose(result.v("slider.vx"), v, atol=1e-12, rtol=0)
    np.testing.assert_allclose(result.a("slider.x"), a, atol=1e-10, rtol=0)
    assert result.samples.residual[:, 0].max() < 1e-14
    assert result.samples.residual[:, 1].max() < 1e-13


def test_branch_is_kept_however_far_apart_the_instants(driven: Machine) -> None:
    t = np.array([0.0, 3.3, 40.25, 40.75])
    result = driven.kinematics(t)
    np.testing.assert_allclose(result.q("slider.x"), _slider(t)[0], atol=1e-12)
    np.testing.assert_allclose(result.q("crank.phi"), np.pi / 4 + OMEGA * t, rtol=1e-14)
    assert result.stats["steps"] > 300


@pytest.mark.parametrize("sign", [1, -1])
def test_start_values_belong_to_the_start(driven: Machine, sign: int) -> None:
    """The branch is that of t = 0, also for instants far behind it or before it."""
    guess = {} if sign > 0 else {"slider.x": -1.5, "rod.phi": np.pi, "rod.x": -0.5}
    for t in (np.array([30.3, 30.4]), np.array([-2.2, -2.1])):
        result = driven.kinematics(t, guess=guess)
        phi = np.pi / 4 + OMEGA * t
        expected = 2.0 * np.cos(phi) + sign * np.sqrt(3.5**2 - 4.0 * np.sin(phi) ** 2)
        np.testing.assert_allclose(result.q("slider.x"), expected, atol=1e-12)
    late = driven.kinematics([0.5], t_start=0.5)
    assert late.stats["steps"] == 0


def test_lock_up_keeps_what_was_computed(driven: Machine) -> None:
    """A rod of 1.9 m: the crank stops where 2 sin(phi) = 1.9."""
    locks = (np.arcsin(1.9 / 2.0) - np.pi / 4) / OMEGA
    t = np.linspace(0.0, 1.0, 1001)
    result = driven.kinematics(t, parameters={"l": 1.9})
    assert result.outcome is Outcome.LOCKED
    assert result.failed
    assert result.t[-1] == pytest.approx(locks, abs=1e-9)
    assert locks == pytest.approx(0.0744587, abs=1e-7)
    np.testing.assert_array_equal(result.t[:-1], t[t < locks])
    np.testing.assert_allclose(
        result.q("slider.x")[:-1], _slider(result.t[:-1], 1.9)[0], atol=1e-11
    )
    assert result.q("rod.phi")[-1] == pytest.approx(-np.pi / 2, abs=1e-4)
    assert "Locked up at t = 0.07445868" in result.message
    assert "driver crank_drive cannot go on, joints" in result.message
    assert "Smallest singular value" in result.message


def test_singular_crossing_keeps_the_velocity_continuous(driven: Machine) -> None:
    """With rod and crank equal, both branches meet at the upright crank: x = 4 cos(phi) or 0."""
    t = np.linspace(0.0, 1.0, 201)
    result = driven.kinematics(t, parameters={"l": 2.0})
    assert result.outcome is Outcome.OK
    np.testing.assert_allclose(result.q("slider.x"), 4.0 * np.cos(np.pi / 4 + OMEGA * t), atol=1e-8)
    assert result.stats["singular_crossings"] == 2
    assert "t = 0.125, 0.625 s" in result.message


def test_freedom_is_refused_with_what_to_add(free: Machine) -> None:
    with pytest.raises(AnalysisError) as caught:
        free.kinematics([0.0, 1.0])
    text = str(caught.value)
    assert "kinematics needs a machine without freedom, and 1 degree of freedom is left" in text
    assert "Add 1 driver to the scene, or the joint that is missing" in text
    assert "or ask for simulate" in text


@pytest.mark.parametrize(
    ("instants", "message"),
    [
        ([], "at least one finite instant"),
        ([0.0, np.nan], "at least one finite instant"),
        ([[0.0, 1.0]], "at least one finite instant"),
        ([0.0, 1.0, 1.0], "must increase: instant 2 is 1 s after 1 s"),
        (["soon"], "must be instants in s"),
    ],
)
def test_wrong_instants_are_refused(driven: Machine, instants: list[float], message: str) -> None:
    with pytest.raises(AnalysisError, match=message):
        driven.kinematics(instants)


DEAD = {"crank.phi": np.pi / 2, "rod.phi": -np.pi / 2, "rod.y": 1.0, "rod.x": 0.0, "slider.x": 0.0}


@pytest.mark.parametrize("t", [[0.125, 0.4], [0.3, 0.4], [0.0, 0.05], [0.125]])
def test_start_in_a_dead_centre_is_left(driven: Machine, t: list[float]) -> None:
    """Rod and crank equal, upright at the start: which way on is told by the start velocities."""
    lengths = {"l": 2.0}
    still = driven.kinematics(t, t_start=0.125, parameters=lengths, guess=DEAD)
    np.testing.assert_allclose(still.q("slider.x"), 0.0, atol=1e-8)
    np.testing.assert_allclose(still.v("slider.x"), 0.0, atol=1e-7)
    assert "Started in a singular position at t = 0.125 s" in still.message
    rates = {"slider.vx": -4.0 * OMEGA, "rod.omega": -OMEGA, "rod.vx": -3.0 * OMEGA}
    moving = driven.kinematics(t, t_start=0.125, parameters=lengths, guess=DEAD | rates)
    phi = np.pi / 4 + OMEGA * np.array(t)
    np.testing.assert_allclose(moving.q("slider.x"), 4.0 * np.cos(phi), atol=1e-7)
    np.testing.assert_allclose(moving.v("slider.x"), -4.0 * OMEGA * np.sin(phi), atol=1e-6)


@pytest.mark.parametrize("analysis", ["kinematics", "inverse_dynamics"])
def test_a_standing_driver_leads_out_of_no_dead_centre(workshop: Path, analysis: str) -> None:
    """Nothing moves: no velocity tells one motion from another."""
    model = Model("standing")
    ground, (crank, rod, slider) = model.ground, (model.body(b, 1.0, 1.0) for b in BODIES)
    model.revolute("A", ground.at(0, 0), crank.at(0, 0))
    model.revolute("B", crank.at(2, 0), rod.at(0, 0))
    model.revolute("C", rod.at(2, 0), slider.at(0, 0))
    model.translational("D", ground.at(0, 0), slider.at(0, 0), axis=(1, 0))
    place, rate = model.parameter("place", 0.5, "rad"), model.parameter("rate", 0.0, "rad/s")
    model.driver("drive", crank.phi, place + rate * codegen.t)
    model.scene("s", drivers=["drive"], guess={"crank.phi": 0.5, "rod.phi": -0.5, "slider.x": 3.4})
    dead = {"crank.phi": np.pi / 2, "rod.phi": -np.pi / 2, "rod.x": 0.0, "rod.y": 2.0}
    run = getattr(load(model, folder=workshop), analysis)
    words = {"parameters": {"place": np.pi / 2}, "guess": dead | {"slider.x": 0.0}}
    told = r"singular position at t = 0 s.*free to move: rod.phi \+1.*no smooth motion"
    with pytest.raises(AnalysisError, match=told):
        run([0.0, 0.1], **words)
    words["parameters"]["rate"] = 1.0
    assert "Started in a singular position" in run([0.0, 0.1], **words).message


def test_start_where_no_motion_leads_out(driven: Machine) -> None:
    """At the last position of a short rod the slider would need an infinite speed."""
    lean = 8e-8
    angle = np.arcsin(0.95 * np.cos(lean))
    locks = (angle - np.pi / 4) / OMEGA
    reach = 2.0 * np.cos(angle) + 0.95 * np.sin(lean)
    guess = {"crank.phi": angle, "rod.phi": lean - np.pi / 2, "rod.x": reach, "rod.y": 0.95}
    guess |= {"slider.x": reach + 0.95 * np.sin(lean)}
    with pytest.raises(AnalysisError, match=r"singular position at t = 0.074.*a little off it"):
        driven.kinematics([locks, 0.1], t_start=locks, parameters={"l": 1.9}, guess=guess)


def test_instants_on_a_singular_position_are_counted(driven: Machine) -> None:
    result = driven.kinematics([0.0, 0.125, 0.3], parameters={"l": 2.0})
    assert result.outcome is Outcome.OK
    assert np.isnan(result.a("slider.x")).tolist() == [False, True, False]
    assert result.stats["singular_instants"] == 1
    assert "At 1 of the instants (t = 0.125 s) the position is singular" in result.message
    plain = driven.kinematics([0.0, 0.3], parameters={"l": 2.0})
    assert plain.stats["singular_instants"] == 0
    assert "At " not in plain.message


@pytest.mark.parametrize("instants", [[0.0, 0.05], [0.125, 0.2], [0.05, 0.2]])
def test_dead_centre_is_crossed_backwards(driven: Machine, instants: list[float]) -> None:
    t = np.array(instants)
    rates = {"slider.vx": -4.0 * OMEGA}
    guess = {"crank.phi": np.pi / 4 + 0.3 * OMEGA, "slider.x": 4 * np.cos(np.pi / 4 + 0.3 * OMEGA)}
    phi = guess["crank.phi"]
    guess |= {"rod.phi": -phi, "rod.x": 3.0 * np.cos(phi), "rod.y": np.sin(phi)}
    result = driven.kinematics(t, t_start=0.3, parameters={"l": 2.0}, guess=guess | rates)
    assert result.outcome is Outcome.OK
    np.testing.assert_allclose(result.q("slider.x"), 4.0 * np.cos(np.pi / 4 + OMEGA * t), atol=1e-8)


def test_a_driver_that_is_too_fast_ends_the_motion_by_name(
    driven: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(driven_motion, "_MOST_STEPS", 10_000)
    for analysis in (driven.kinematics, driven.inverse_dynamics):
        result = analysis([0.0, 0.1, 1e6], progress=False)
        assert result.outcome is Outcome.MAX_STEPS
        assert result.t[1] == 0.1
        assert 100.0 < result.t[-1] < 1e5
        assert "steps the motion was followed for" in result.message
        assert "of 1e+06 s" in result.message
        assert "t_start=" in result.message
    short = driven.kinematics([0.0, 0.1], progress=False)
    assert short.outcome is Outcome.OK
