"""Angles and slides of joints: counted through turns, driven, sprung, started from, and refused."""

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation
from sympy import pi, sin

from codegen import Model, t
from codegen.driver import build
from codegen.errors import AssemblyError, InputError, ModelError
from runtime import load
from runtime.core.outcomes import Outcome
from tests.random_mechanisms.spatial_declaration import declare
from tests.random_mechanisms.spatial_dynamics import SpatialDense, moved
from tests.space import dense_machines
from tests.space.closed_forms import (
    SpatialSliderCrank,
    universal_joint_angle,
    universal_joint_ratio,
)
from tests.space.machines import X, Y, Z, slider_crank

TURNS = 100
FULL = 2 * np.pi


def with_crank() -> Any:
    """Haug's 12.2, model 1, with what drives and turns its crank A and its slider's guide D."""
    model: Any = slider_crank(True)
    A, D = model.joints["A"], model.joints["D"]
    first = model.parameter("theta", 0.0, "rad")
    model.rotation_driver("drive", A, first - FULL * t)
    model.generalized_force("motor", {A.angle: -0.5 * (FULL + A.rate)})
    model.torsion_spring("coil", A, stiffness=1e-3, free_angle=-0.4, damping=1e-4)
    model.scene("driven", effects=["gravity"], drivers=["drive"])
    model.scene("motored", effects=["gravity", "motor"], start={"A.rate": -FULL})
    model.scene(
        "counted", effects=["gravity", "coil"], outputs=["default", "A.angle", D.slide],
        until={"wound": A.angle - 20 * pi > 0},
    )  # fmt: skip
    return model


@cache
def crank(scene: str, workshop: Path) -> Any:
    return load(with_crank(), scene, folder=workshop)


def turned(result: Any) -> Any:
    """The crank's angle against the drawing, unwrapped, from its rotation matrices."""
    (e0, e1), angles = (0.7042, 0.71), result.rotation("crank")
    angle = np.unwrap(np.arctan2(angles[:, 2, 1], angles[:, 1, 1]))
    zero = 2 * np.arctan2(e1, e0)
    return angle - zero - FULL * np.round((angle[0] - zero - result.q("A.angle")[0]) / FULL)


@pytest.mark.parametrize("scene", ["motored", "driven"])
@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_crank_turns_a_hundred_times_and_repartitions_never(
    scene: str, method: str, workshop: Path
) -> None:
    machine = crank(scene, workshop)
    result = machine.simulate(TURNS, 20 * TURNS, rtol=1e-8, method=method, progress=False)
    assert result.outcome is Outcome.OK
    angle = result.q("A.angle")
    assert -angle[-1] > 0.98 * TURNS * FULL
    assert_allclose(angle, turned(result), rtol=0.0, atol=1e-9)
    assert_allclose(result.v("A.rate"), result["crank.omega_x"], rtol=0.0, atol=1e-9)
    assert [part.independent for part in result.partitions] == [("A.angle",)] * (scene != "driven")


def test_the_drive_exerts_the_torque_and_the_hinge_none(workshop: Path) -> None:
    """Haug 12.2 (12.2.3): torques by the dense equations, and the slider's exact motion."""
    mechanism, count = dense_machines.slider_crank(speed=-FULL), 50
    dense = SpatialDense(mechanism)
    state, torques = dense.closed(dense.at_drawing, 0.0), []
    for k in range(count):
        if k:
            state = dense.closed(moved(state, np.hstack([state.v, state.w]) / count), k / count)
        torques.append(dense.effort("drive", dense.solve(state, k / count)))
    machine = load(declare(mechanism, "crank_by_dense_equations"), folder=workshop)
    found = machine.inverse_dynamics(1.0, count + 1, progress=False)
    assert_allclose(found.reaction("drive", "torque")[:-1], torques, rtol=0.0, atol=1e-11)
    assert_allclose(found.reaction("A", "tx"), 0.0, rtol=0.0, atol=1e-13)
    assert_allclose(found.wrench("A", "crank")[:, 3], 0.0, rtol=0.0, atol=1e-13)
    with pytest.raises(InputError, match="'drive' acts on coordinates of joints"):
        found.wrench("drive", "crank")
    fine = machine.inverse_dynamics(1.0, 1001, progress=False)
    extremes = (f(fine.reaction("drive", "torque")) for f in (np.min, np.max))
    assert [*extremes] == pytest.approx([-0.298, 0.203], abs=1e-3)
    run = machine.simulate(1.0, count + 1, progress=False)
    assert_allclose(run.reaction("drive", "torque")[:-1], torques, rtol=0.0, atol=1e-9)
    work = run.reaction("drive", "torque") * run.v("A.rate")
    assert_allclose(run.power("drive"), work, rtol=0.0, atol=1e-12)
    moves = machine.kinematics(1.0, 11, progress=False)
    form = SpatialSliderCrank(0.3)
    for k, instant in enumerate(moves.t):
        exact = form.motion(np.pi / 2 - FULL * instant, -FULL)
        place_of = [one("slider.x")[k] for one in (moves.q, moves.v, moves.a)]
        assert place_of == pytest.approx(exact, abs=1e-10)


def shafts(bend: float) -> Model:
    """Two shafts that meet at the origin under an angle; the first turns with 2 rad/s."""
    second, axes = (np.cos(bend), np.sin(bend), 0.0), (0, 0, bend)
    model: Any = Model(f"shafts_{round(100 * bend)}", space=True)
    one = model.body("one", 1.0, (0.1, 0.2, 0.25), at=(-0.5, 0, 0))
    other = model.body("other", 2.0, (0.3, 0.2, 0.15), at=tuple(0.5 * np.array(second)), axes=axes)
    first = model.revolute("first", model.ground, one, at=(-1, 0, 0), axis=X)
    model.universal("cross", one, other, at=(0, 0, 0), axes=(Y, Z))
    model.revolute("second", model.ground, other, at=second, axis=second)
    model.rotation_driver("drive", first, 2 * t)
    model.scene("run", drivers=["drive"], outputs=["default", "second.angle"])
    return model  # type: ignore[no-any-return]


@pytest.mark.parametrize("bend", [0.5, 1.2])
def test_a_shaft_behind_a_universal_joint_for_fifty_turns(bend: float, workshop: Path) -> None:
    machine = load(shafts(bend), folder=workshop)
    result = machine.kinematics(50 * np.pi, 501, progress=False)
    angles = 2 * result.t
    ratio = [universal_joint_ratio(angle, bend) for angle in angles]
    assert_allclose(result.v("second.rate") / 2, ratio, rtol=0.0, atol=1e-12)
    exact = [universal_joint_angle(angle, bend) for angle in angles]
    assert_allclose(result.q("second.angle"), exact, rtol=0.0, atol=1e-12)
    assert result.q("second.angle")[-1] == pytest.approx(50 * FULL, abs=1e-10)


MASS, ABOUT, STIFFNESS, FREE, DAMPING = 1.5, 0.2, 0.8, 8.0, 0.05


def rotor() -> Any:
    """A disc on an oblique axis through its centre, about which it turns and slides."""
    model: Any = Model("rotor", space=True)
    axis, turn = np.array([1.0, 2.0, 2.0]) / 3, np.array([0.3, -0.2, 0.5])
    inner = Rotation.from_rotvec(turn).as_matrix().T @ axis
    inertia = 0.15 * np.eye(3) + (ABOUT - 0.15) * np.outer(inner, inner)
    disc = model.body("disc", MASS, inertia, at=(0.1, 0.2, 0.3), axes=turn)
    C = model.cylindrical("C", model.ground, disc, at=(0.1, 0.2, 0.3), axis=axis)
    model.torsion_spring("coil", C, stiffness=STIFFNESS, free_angle=FREE, damping=DAMPING)
    model.torsion_spring("law", C, torque=lambda a, w: STIFFNESS * (a - FREE) + DAMPING * w)
    model.generalized_force("push", {C.slide: 3.0})
    model.translation_driver("feed", C, 0.2 * sin(3 * t))
    whole = ["default", "angle(coil)", "torque(coil)", "deflection(coil)", "works"]
    model.scene("sprung", effects=["coil", "push"], outputs=whole)
    model.scene("lawful", effects=["law"], drivers=["feed"])
    return model


def test_a_torsion_spring_counts_turns(workshop: Path) -> None:
    """A damped oscillator about 8 rad, by hand, and a constant force along the axis."""
    machine = load(rotor(), "sprung", folder=workshop)
    result = machine.simulate(6.0, 121, rtol=1e-12, progress=False)
    decay, square = DAMPING / (2 * ABOUT), STIFFNESS / ABOUT
    w, at = np.sqrt(square - decay**2), result.t
    swing = np.exp(-decay * at) * (np.cos(w * at) + decay / w * np.sin(w * at))
    angle, rate = FREE * (1 - swing), FREE * np.exp(-decay * at) * square / w * np.sin(w * at)
    assert angle.max() > 2 * FULL
    assert_allclose(result.q("C.angle"), angle, rtol=0.0, atol=1e-9)
    assert_allclose(result.v("C.rate"), rate, rtol=0.0, atol=1e-9)
    assert_allclose(result.angle("coil"), angle, rtol=0.0, atol=1e-9)
    torque = STIFFNESS * (angle - FREE) + DAMPING * rate
    assert_allclose(result.torque("coil"), torque, rtol=0.0, atol=1e-9)
    assert_allclose(result.deflection("coil"), angle - FREE, rtol=0.0, atol=1e-9)
    assert_allclose(result.q("C.slide"), at**2, rtol=0.0, atol=1e-10)
    assert_allclose(result.v("C.speed"), 2 * at, rtol=0.0, atol=1e-10)
    lost = result.work("coil") + result.work("push") - result.energy("kinetic")
    assert_allclose(lost, 0.0, rtol=0.0, atol=1e-8)
    wrench = [result.reaction("C", f"{kind}{c}") for kind in "ft" for c in "xyz"]
    assert_allclose(wrench, 0.0, rtol=0.0, atol=1e-10)  # spring and push belong to others
    other = load(rotor(), "lawful", folder=workshop).simulate(6.0, at, rtol=1e-12, progress=False)
    assert_allclose(other.q("C.angle"), angle, rtol=0.0, atol=1e-9)
    assert_allclose(other.q("C.slide"), 0.2 * np.sin(3 * at), rtol=0.0, atol=1e-13)
    force = -MASS * 9 * 0.2 * np.sin(3 * at)
    assert_allclose(other.reaction("feed", "force"), force, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("method", ["dop853", "radau5", "bdf"])
def test_an_event_at_ten_turns_in_every_form(method: str, workshop: Path) -> None:
    machine, words = crank("counted", workshop), {"rtol": 1e-9, "progress": False}
    start, at = {"A.angle": 10.0, "A.rate": 40.0}, np.linspace(0.0, 9.0, 451)
    result = machine.simulate(9.0, at, method=method, start=start, **words)
    assert "where 'wound' began to hold" in result.message
    assert result.q("A.angle")[-1] == pytest.approx(10 * FULL, rel=1e-12)
    assert_allclose(result.q("A.angle"), turned(result), rtol=0.0, atol=1e-9)
    reduced = machine.simulate(9.0, at, formulation="reduced", method=method, start=start, **words)
    assert_allclose(reduced.t, result.t, rtol=0.0, atol=1e-6)
    assert_allclose(reduced.q("A.angle"), result.q("A.angle"), rtol=0.0, atol=1e-5)
    assert_allclose(result.q("D.slide"), result.q("slider.x") - 0.2, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("angle", [0.5, -2.0, 3.0, np.pi, 4.0, 7.0, 13.0])
def test_a_start_by_an_angle(angle: float, workshop: Path) -> None:
    """The crank turns there, and by no half turn less; whole turns are counted."""
    machine = crank("counted", workshop)
    for words in ({"start": {"A.angle": angle}}, {"guess": {"A.angle": angle}}):
        begin = machine.assemble(**words)
        exact = "start" in words
        assert begin["A.angle"] == pytest.approx(angle, abs=1e-15 if exact else 2e-3)
        half = np.arctan2(0.71, 0.7042) + begin["A.angle"] / 2
        p = [begin[f"crank.e{k}"] for k in range(4)]
        assert_allclose(np.abs(p), np.abs([np.cos(half), np.sin(half), 0, 0]), atol=1e-12)
        assert p[0] * np.cos(half) * p[1] * np.sin(half) >= 0.0


@pytest.mark.parametrize("angle", [2.0, np.pi, 4.0])
def test_a_law_begins_at_any_angle(angle: float, workshop: Path) -> None:
    begin = crank("driven", workshop).assemble(parameters={"theta": angle})
    assert begin["A.angle"] == pytest.approx(angle, abs=1e-12)
    assert begin["A.rate"] == pytest.approx(-FULL, abs=1e-12)
    half = np.arctan2(0.71, 0.7042) + angle / 2
    p = np.array([begin[f"crank.e{k}"] for k in range(2)])
    assert abs(p @ [np.cos(half), np.sin(half)]) == pytest.approx(1.0, abs=1e-12)


def test_starts_by_rates(workshop: Path) -> None:
    machine = crank("counted", workshop)
    for start in ({"A.rate": 6.0}, {"crank.omega_x": 6.0}, {"A.rate": 6.0, "crank.omega_x": 6.0}):
        begin = machine.assemble(start=start)
        assert begin["A.rate"] == pytest.approx(6.0, abs=1e-12)
        assert begin["crank.omega_x"] == pytest.approx(6.0, abs=1e-12)
    with pytest.raises(AssemblyError) as refusal:
        machine.assemble(start={"A.rate": 2.0, "crank.omega_x": 3.0})
    assert "crank.omega_x = 3 rad/s" in str(refusal.value)
    assert "fixed are A.rate = 2 rad/s" in str(refusal.value)
    with pytest.raises(AssemblyError, match=r"slider\.vx = 3 m/s, A\.rate = 2 rad/s"):
        machine.assemble(start={"A.rate": 2.0, "slider.vx": 3.0})


def test_an_ensemble_counts_as_single_runs_do(workshop: Path) -> None:
    machine, rates = crank("motored", workshop), np.array([-6.0, -5.0])
    many = machine.ensemble(2.0, 6, starts={"A.rate": rates}, progress=False)
    for k, rate in enumerate(rates):
        alone = machine.simulate(2.0, 6, start={"A.rate": rate}, progress=False)
        assert np.array_equal(many["q"].values[k], alone.samples.q)


def test_a_scene_that_asks_for_no_coordinate_has_none(tmp_path: Path) -> None:
    model = with_crank()
    plain = model.scene("plain", effects=["gravity"], start={"crank.omega_x": 6.0})
    assert plain.counted == ()
    asked = model.scenes["counted"]
    assert asked.counted == ("A.angle", "D.slide")
    assert asked.outputs is None
    build(model, scene="plain", out=tmp_path, compile=False)
    (text,) = (path.read_text() for path in tmp_path.glob("*__plain.py"))
    assert "A_angle" not in text
    assert "A.angle" not in text


def test_a_coordinate_that_a_scene_does_not_count(workshop: Path) -> None:
    machine = crank("motored", workshop)
    result = machine.simulate(0.01, 2, progress=False)
    how = r"motored does not compute D\.{}, .*load scene\.with_\(outputs=\['default', 'D\.{}'\]\)"
    calls: list[tuple[str, Callable[[], Any]]] = [
        ("slide", lambda: result.q("D.slide")),
        ("speed", lambda: result.v("D.speed")),
        ("slide", lambda: result.a("D.slide")),
        ("slide", lambda: result["D.slide"]),
        ("speed", lambda: machine.assemble(start={"D.speed": 1.0})),
    ]
    for letter, call in calls:
        with pytest.raises((InputError, AssemblyError), match=how.format(letter, letter)):
            call()


def test_advice_on_outputs_keeps_those_of_the_scene(workshop: Path) -> None:
    model = with_crank()
    height = {"height": model.bodies["crank"].z, "way": model.bodies["slider"].x}
    model.scene("seen", effects=["gravity"], outputs=["energy", height])
    model.scene("few", effects=["gravity"], outputs=["default", "A.angle"])
    machine, few = (load(model, scene, folder=workshop) for scene in ("seen", "few"))
    result = machine.simulate(0.01, 2, progress=False)
    for name, counted in (("A.rate", "rate"), ("A.phi", "angle"), ("A.omega", "rate")):
        kept = f"outputs=['energy', {{'height': ..., 'way': ...}}, 'A.{counted}']"
        with pytest.raises(
            InputError, match=re.escape(f"does not compute A.{counted}, ")
        ) as refusal:
            result[name]
        assert str(refusal.value).count(kept) == 2
    with pytest.raises(InputError, match="'motor' does not act in this scene") as refusal:
        result.power("motor")
    kept = "outputs=['energy', {'height': ..., 'way': ...}, 'power(motor)']"
    assert f"scene.with_('motor', {kept})" in str(refusal.value)
    with pytest.raises(InputError, match=r"There is no series 'A\.phi'"):
        few.simulate(0.01, 2, progress=False)["A.phi"]
    model.scene("pasted", outputs=["energy", {"height": ...}])
    assert "output 'height': Ellipsis is neither a number nor an expression" in model.problems[-1]


MISTAKES: dict[str, tuple[Callable[[Any], Any], str]] = {
    "angle of a ball": (
        lambda m: m.joints["B"].angle,
        "spherical 'B' has no angle; joints that turn about an axis have an angle,",
    ),
    "slide of a hinge": (
        lambda m: m.translation_driver("it", m.joints["A"], t),
        "revolute in space 'A' has no slide; joints that turn",
    ),
    "name": (
        lambda m: m.rotation_driver("it", "A", t),
        "'it': 'A' is no joint of 'slider_crank_1' with an angle; give what model.revolute(...)",
    ),
    "planar joint": (
        lambda m: m.rotation_driver("it", planar_hinge(), t),
        "'it': revolute 'J' is no joint of 'slider_crank_1' with an angle; give what",
    ),
    "body": (
        lambda m: m.torsion_spring("it", m.bodies["crank"], 2.0),
        "'it': body 'crank' is no joint of 'slider_crank_1' with an angle; give what",
    ),
    "idle spring": (
        lambda m: m.torsion_spring("it", m.joints["A"]),
        "torsion spring in space 'it' does nothing; give it a stiffness,",
    ),
    "twice": (
        lambda m: (
            m.rotation_driver("it", m.joints["A"], 2 * t),
            m.scene("s", drivers=["drive", "it"]),
        ),
        "redundant: it.angle (driver). Remove or relax 'it': no motion is left for them to prevent",
    ),
    "driver without its joint": (
        lambda m: m.scene("s", drivers=["drive"], without=["A"]),
        "scene 's': something asks for A.angle, but joint 'A' takes no part; take it in, or",
    ),
    "output without its joint": (
        lambda m: m.scene("s", outputs=["A.rate"], without=["A"]),
        "scene 's': something asks for A.angle, but joint 'A' takes no part; take it in, or",
    ),
    "output": (
        lambda m: m.scene("s", outputs=["B.angle"]),
        "scene 's': no output 'B.angle'; did you mean 'A.angle'",
    ),
    "start": (
        lambda m: m.scene("s", start={"B.angle": 1.0}),
        "scene 's': 'B.angle' is no coordinate or velocity; did you mean 'A.angle'",
    ),
    "law of coordinates": (
        lambda m: m.rotation_driver("it", m.joints["A"], m.joints["A"].angle + t),
        "driver 'it': the law A_angle + t contains the coordinate A_angle; a motion law depends",
    ),
    "letter": (
        lambda m: m.point_driver("it", m.bodies["slider"], "phi", t),
        "point driver in space 'it', letter: 'phi' is none of 'x', 'y', 'z'.",
    ),
    "point of the ground": (
        lambda m: m.point_driver("it", m.ground.at(0, 0, 1), "x", t),
        "point driver in space 'it' moves a point of the ground; give one of a moving body.",
    ),
}  # fmt: skip


def planar_hinge() -> Any:
    model = Model("flat")
    return model.revolute("J", model.ground.at(0, 0), model.body("b", 1, 1).at(0, 0))


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes_are_told(case: str, tmp_path: Path) -> None:
    mistake, text = MISTAKES[case]
    model = with_crank()

    def declare_and_build() -> None:
        mistake(model)
        build(model, scene=[*model.scenes][-1], out=tmp_path, compile=False)

    with pytest.raises(ModelError) as refusal:
        declare_and_build()
    assert text in str(refusal.value)


def test_an_inherited_output_of_a_joint_that_is_left_out_goes(tmp_path: Path) -> None:
    model = with_crank()
    scene = model.scene("less", extends="counted", without=["D", "A"], effects=["gravity"])
    assert "A.angle" not in (scene.request.outputs or ())
