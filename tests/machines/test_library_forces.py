"""A small machine for each force that has a closed form."""

from pathlib import Path

import numpy as np
from numpy.testing import assert_allclose

from codegen import Model
from runtime import Outcome, Result, load

INSTANTS = np.linspace(0.0, 2.0, 81)


def run(model: Model, folder: Path, t_end: float = 2.0, **given: object) -> Result:
    """A simulation that ended as it should."""
    options = {"rtol": 1e-11, "atol": 1e-12, **given}
    result = load(model, folder=folder).simulate(t_end, np.linspace(0, t_end, 81), **options)
    assert result.outcome is Outcome.OK, result.message
    return result


def test_motor_runs_up_against_a_free_stator(tmp_path: Path) -> None:
    """ω = u ω_0 (1 - exp(-t/τ)) with τ = ω_0/T_s / (1/J_i + 1/J_j); the moment is kept."""
    model = Model("motor")
    stator = model.body("stator", mass=1.0, inertia=0.5)
    rotor = model.body("rotor", mass=1.0, inertia=0.2)
    model.revolute("axle", stator, rotor)
    model.motor("drive", rotor, stator, stall_torque=3.0, no_load_speed=20.0, voltage=0.7)
    model.scene("run", ["drive"], start={"stator.x": 0, "stator.y": 0, "stator.phi": 0.0,
                                         "rotor.phi": 0.0, "stator.omega": 0.0,
                                         "rotor.omega": 0.0})  # fmt: skip
    result = run(model, tmp_path)
    tau = 20.0 / 3.0 / (1 / 0.5 + 1 / 0.2)
    speed = result.v("rotor.phi") - result.v("stator.phi")
    assert_allclose(speed, 0.7 * 20 * (1 - np.exp(-result.t / tau)), rtol=1e-9, atol=1e-9)
    moment = 0.5 * result.v("stator.phi") + 0.2 * result.v("rotor.phi")
    assert_allclose(moment, 0, atol=1e-10)


def test_force_between_two_bodies_leaves_their_centre_at_rest(tmp_path: Path) -> None:
    model = Model("linear")
    frame, slider = (model.body(n, mass=m, inertia=1.0) for n, m in (("frame", 3.0), ("it", 1.0)))
    model.translational("guide", frame, slider, axis=(1, 0))
    model.force("coil", on=slider, fx=6.0, frame="body", from_=frame)
    start = {frame.x: 0.0, frame.y: 0.0, frame.phi: 0.3, slider.x: 0.0}
    model.scene("run", ["coil"], start=start | {q.rate: 0.0 for q in start})
    result = run(model, tmp_path)
    along = 6.0 * result.t**2 / 2
    for name, share in (("frame", -1 / 3), ("it", 1.0)):
        assert_allclose(result.q(f"{name}.x"), share * along * np.cos(0.3), atol=1e-9)
        assert_allclose(result.q(f"{name}.y"), share * along * np.sin(0.3), atol=1e-9)
        assert_allclose(result.q(f"{name}.phi"), 0.3, atol=1e-10)


def test_torque_between_two_bodies_keeps_their_moment(tmp_path: Path) -> None:
    model = Model("wheel")
    frame, wheel = (model.body(n, mass=1.0, inertia=j) for n, j in (("frame", 4.0), ("wheel", 0.5)))
    model.revolute("axle", frame, wheel)
    model.torque("drive", on=wheel, from_=frame, value=2.0)
    start = {frame.x: 0.0, frame.y: 0.0, frame.phi: 0.0, wheel.phi: 0.0}
    model.scene("run", ["drive"], start=start | {q.rate: 0.0 for q in start})
    result = run(model, tmp_path)
    assert_allclose(result.q("wheel.phi"), 2.0 / 0.5 * result.t**2 / 2, atol=1e-9)
    assert_allclose(result.q("frame.phi"), -2.0 / 4.0 * result.t**2 / 2, atol=1e-9)


def test_line_force_swings_two_particles_as_a_spring_does(tmp_path: Path) -> None:
    """f = k (ℓ - 1): ℓ = 1 + 0.2 cos(w t) with w² = k (1/m_i + 1/m_j)."""
    model = Model("strut")
    one, other = (model.particle(n, mass=m) for n, m in (("one", 1.0), ("other", 3.0)))
    strut = model.line_force("strut", one, other, lambda length, rate: 60 * (length - 1))
    watch = model.body("watch", mass=1.0, inertia=1.0)
    model.force("copy", watch, fx=strut.length, fy=strut.rate)
    start = {one.x: 0.0, one.y: 0.0, other.x: 0.6 * 1.2, other.y: 0.8 * 1.2}
    start |= {watch.x: 0.0, watch.y: 0.0}
    model.scene("run", ["strut", "copy"], start=start | {q.rate: 0.0 for q in start})
    result = run(model, tmp_path)
    w = np.sqrt(60 * (1 + 1 / 3))
    length = np.hypot(result.q("other.x") - result.q("one.x"),
                      result.q("other.y") - result.q("one.y"))  # fmt: skip
    assert_allclose(length, 1 + 0.2 * np.cos(w * result.t), atol=1e-9)
    assert_allclose(result.a("watch.x"), length, atol=1e-8)
    assert_allclose(result.a("watch.y"), -0.2 * w * np.sin(w * result.t), atol=1e-8)


def test_preload_moves_the_middle_of_a_swing(tmp_path: Path) -> None:
    """A valve's spring, pressed by 40 N at 0.3 m: x = 0.3 + (1 - cos(w t)) 40/k."""
    model = Model("valve")
    valve = model.body("valve", mass=0.5, inertia=1.0)
    model.translational("guide", model.ground, valve)
    model.spring("coil", model.ground, valve, 800.0, 0.3, preload=-40.0)
    model.scene("run", ["coil"], start={valve.x: 0.3, valve.vx: 0.0})
    result = run(model, tmp_path)
    x = 0.3 + 40 / 800 * (1 - np.cos(np.sqrt(800 / 0.5) * result.t))
    assert_allclose(result.q("valve.x"), x, atol=1e-8)
    assert_allclose(result.energy(), result.energy()[0], atol=1e-8)
    rest = load(model, folder=tmp_path).equilibrium()
    assert_allclose(rest.q("valve.x"), 0.35, atol=1e-9)
