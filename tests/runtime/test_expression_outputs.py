"""Outputs that are expressions: their values, units, places in results and files, and refusals."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.errors import InputError, LinkwrightError, ModelError, SceneError
from codegen.reading.scenes_as_data import data_of_scene
from runtime import Machine, Result, load, load_result
from runtime.core.outcomes import Outcome
from runtime.results.export import table

CRANK, COUPLER, ROCKER, FRAME = 1.0, 2.5, 2.5, 2.0
INSTANTS = np.linspace(0.0, 1.0, 101)
SPEED = 2.0 * np.pi


def four_bar() -> Model:
    """A four-bar linkage with a spring, whose crank a driver turns or a torque moves."""
    model = Model("traced_bars", gravity=(0, -9.81))
    crank = model.body("crank", mass=1.0, inertia=0.1)
    coupler = model.body("coupler", mass=5.0, inertia=8.0)
    rocker = model.body("rocker", mass=2.5, inertia=1.3)
    model.revolute("A", model.ground.at(0, 0), crank.at(-CRANK / 2, 0))
    model.revolute("B", crank.at(CRANK / 2, 0), coupler.at(-COUPLER, 0))
    model.revolute("C", coupler.at(0, 0), rocker.at(ROCKER / 2, 0))
    model.revolute("D", model.ground.at(FRAME, 0), rocker.at(-ROCKER / 2, 0))
    model.spring("strut", model.ground.at(0.5, 3), coupler.at(1, 0), 30.0, free_length=1.0)
    model.torque("even", on=crank, value=5.0)
    model.driver("drive", crank.phi, SPEED * t)
    model.track("tip", coupler.at(COUPLER, 0.1))
    guess = {crank.x: 0.5, coupler.x: 1.5, coupler.y: 2.45, coupler.phi: 1.37,
             rocker.x: 1.75, rocker.y: 1.22, rocker.phi: 1.77}  # fmt: skip
    ratio = rocker.omega / crank.omega
    size = sympy.sqrt(model.series("A.fx") ** 2 + model.series("A.fy") ** 2)
    model.scene(
        "run", ["gravity", "even", "strut"], guess=guess,
        start={crank.phi: 0.0, crank.omega: SPEED},
        outputs={
            "transmission": coupler.phi - rocker.phi, "ratio": ratio, "load": size,
            "pulled": model.series("strut.force") * model.series("strut.length"),
            "lift": (sympy.Max(coupler.y - 2.4, 0), "m"),
            "jerky": model.series("tip.ax") - model.series("a(coupler.x)"),
        },
    )  # fmt: skip
    model.scene("driven", ["gravity"], ["drive"], guess=guess,
                outputs=["global_reactions", {"ratio": ratio, "turned": SPEED * t}])  # fmt: skip
    model.scene("moved", drivers=["drive"], analysis="kinematics", guess=guess,
                outputs=["acceleration(tip)", {"ratio": ratio,
                "bend": model.series("a(rocker.phi)")}])  # fmt: skip
    return model


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("expressions")


@pytest.fixture(scope="module")
def machine(folder: Path) -> Machine:
    return load(four_bar(), "run", folder=folder)


@pytest.fixture(scope="module")
def told(machine: Machine) -> Result:
    return machine.simulate(1.0, INSTANTS, rtol=1e-10)


def loop(phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angles of coupler and rocker in closed form: two circles meet above the frame."""
    bx, by = CRANK * np.cos(phi), CRANK * np.sin(phi)
    dx, dy = FRAME - bx, -by
    d = np.hypot(dx, dy)
    at = np.arctan2(dy, dx)
    coupler = at + np.arccos((COUPLER**2 + d**2 - ROCKER**2) / (2 * COUPLER * d))
    cx, cy = bx + COUPLER * np.cos(coupler), by + COUPLER * np.sin(coupler)
    return coupler, np.arctan2(cy, cx - FRAME)


def ratio(phi: np.ndarray) -> np.ndarray:
    """ω of the rocker by ω of the crank, from the velocities of the loop."""
    coupler, rocker = loop(phi)
    return CRANK * np.sin(phi - coupler) / (ROCKER * np.sin(rocker - coupler))


def test_expressions_are_what_they_say(told: Result) -> None:
    coupler, rocker = loop(told.q("crank.phi"))
    assert_allclose(told["transmission"], coupler - rocker, atol=1e-9)
    assert_allclose(told["ratio"], ratio(told.q("crank.phi")), atol=1e-8)
    assert_allclose(told["transmission"], told["coupler.phi"] - told["rocker.phi"], atol=1e-14)
    size = np.hypot(told.reaction("A", "fx"), told.reaction("A", "fy"))
    assert_allclose(told["load"], size, rtol=1e-13)
    assert_allclose(told["pulled"], told.force("strut") * told.length("strut"), rtol=1e-12)
    assert_allclose(told["lift"], np.maximum(told["coupler.y"] - 2.4, 0.0), atol=1e-14)
    assert told["lift"].max() > 0.0
    assert (told["lift"] == 0.0).any()
    assert not told.events  # an output switches nothing
    assert_allclose(told["jerky"], told["tip.ax"] - told.a("coupler.x"), atol=1e-11)


def test_expressions_have_units(told: Result) -> None:
    units = {row.name: row.unit for row in told.description.series.of_kind("expression")}
    assert units == {"transmission": "rad", "ratio": "1", "load": "N", "pulled": "", "lift": "m",
                     "jerky": "m/s^2"}  # fmt: skip
    degrees, unit = told.series("transmission", "deg")
    assert unit == "deg"
    assert_allclose(degrees, np.degrees(told["transmission"]))
    with pytest.raises(InputError, match="transmission is in rad, which does not convert to 'mm'"):
        told.series("transmission", "mm")


@pytest.mark.parametrize(
    ("label", "expression", "unit"),
    [("kg*m**2", "p * omega**2 / 2", "kg m^2/s^2"), ("kg m²", "p * omega**2 / 2", "kg m^2/s^2"),
     ("N/m**2", "p * x", "N/m"), ("(N/m)*m", "p * x", "N m"), ("N·s/m", "p * vx", "N"),
     ("N/m", "sqrt(p / m)", "1/s"), ("N m/rad", "sqrt(p / m) / x", "1/s"),
     ("J", "p + m * vx**2", "kg m^2/s^2"), ("N", "sqrt(p) * sqrt(m * x) / t", "kg m/s^2"),
     ("N", "sqrt(p * p)", "N"), ("m", "sqrt(p)", ""), ("1", "p + sqrt(x)", ""),
     ("m", "(x**2 + y**2) ** 0.5", "m"), ("m", "sqrt(vx**2 + vy**2)", "m/s"), ("1", "phi * x", "m"),
     ("kN", "p * phi", "N"), ("Hz", "x * p", "Hz m"), ("1", "omega * phi", "rad^2/s")],
)  # fmt: skip
def test_units_of_expressions(label: str, expression: str, unit: str) -> None:
    """As the factors of a unit say, however they are written, by whole powers or none."""
    model = Model("measured")
    body = model.body("body", mass=1.0, inertia=1.0)
    symbols = {name: getattr(body, name) for name in ("x", "y", "phi", "vx", "vy", "omega")}
    symbols |= {"p": model.parameter("p", 1.0, unit=label), "t": t}
    symbols["m"] = model.parameter("m", 1.0, unit="kg")
    scene = model.scene("run", outputs={"out": sympy.sympify(expression, symbols)})
    assert [one.unit for one in scene.expressions] == [unit]


UNDEFINED = "'ratio' is not a number at t = 0 s (1 of 6 instants)."


def test_values_that_do_not_exist_end_no_run(folder: Path) -> None:
    """A ratio of speeds from rest, in every analysis."""
    model, times = Model("from_rest", gravity=(0, -9.81)), np.linspace(0.0, 1.0, 6)
    arm = model.body("arm", mass=1.0, inertia=0.1)
    model.revolute("pin", model.ground, arm.at(-0.5, 0))
    model.driver("turn", arm.phi, t**2)
    outputs = {"ratio": -1 / arm.omega, "double": 2 * arm.phi}
    model.scene("free", ["gravity"], outputs=outputs)
    model.scene("driven", ["gravity"], ["turn"], outputs=outputs)
    model.scene("moved", [], ["turn"], analysis="kinematics", outputs=outputs)
    model.scene("rest", ["gravity"], analysis="equilibrium", guess={arm.phi: -1.5}, outputs=outputs)
    free = load(model, "free", folder=folder)
    driven, moved = (load(model, name, folder=folder) for name in ("driven", "moved"))
    found = [free.simulate(1.0, times), driven.simulate(1.0, times), driven.inverse_dynamics(times),
             driven.kinematics(times), moved.kinematics(times)]  # fmt: skip
    found.append(free.simulate(1.0, times, out=folder / "from_rest.zarr"))
    for r in found:
        assert r.outcome is Outcome.OK
        assert UNDEFINED in r.message
        assert (np.isnan(r["ratio"]) == (times == 0.0)).all()
        assert_allclose(r["ratio"][1:], -1 / r.v("arm.phi")[1:])
        assert_allclose(r["double"], 2 * r.q("arm.phi"))
    assert np.isnan(found[0].at(0.0)["ratio"]).all()
    assert found[0].at(0.0).message.endswith("at t = 0 s (1 of 1 instant).")
    assert "ratio" not in found[0].at(0.3).message
    assert free.simulate(1.0, until={"fast": "ratio > 0.5"}).ended_by == "fast"
    rest = load(model, "rest", folder=folder).equilibrium()
    assert rest.outcome is Outcome.OK
    assert np.isnan(rest["ratio"])
    assert "'ratio' is not a number at t = 0 s (1 of 1 instant)." in rest.message
    many = free.ensemble(1.0, times, starts={"arm.phi": [0.0, 0.2]}, threads=1, progress=False)
    assert (many["outcome"] == "OK").all()
    assert all(UNDEFINED in text for text in many["message"].values)
    assert (np.isnan(many["expression"].sel(output="ratio")).sum("time") == 1).all()


def test_expressions_are_in_files_and_pictures(told: Result, tmp_path: Path) -> None:
    for ending in ("nc", "zarr", "csv", "mat"):
        told.save(tmp_path / f"run.{ending}")
    column = pd.read_csv(tmp_path / "run.csv")["transmission [rad]"]
    assert (column == told["transmission"]).all()
    assert {"load [N]", "ratio [1]"} <= {*table(told)}
    assert (told.data["expression"].sel(output="ratio") == told["ratio"]).all()
    assert told.data["point_acceleration"].shape == (101, 1, 2)
    for ending in ("nc", "zarr"):
        assert (load_result(tmp_path / f"run.{ending}")["load"] == told["load"]).all()
    axes = told.plot("transmission", "load").axes
    assert [line.get_label() for axis in axes for line in axis.lines] == ["transmission", "load"]
    assert "outputs      transmission (rad)" in repr(told)


def test_expressions_at_any_instant(told: Result) -> None:
    coupler, rocker = loop(told.at(0.3333).q("crank.phi"))
    assert_allclose(told.at(0.3333)["transmission"], coupler - rocker, atol=1e-9)


def test_expressions_end_runs_and_have_accuracy(machine: Machine) -> None:
    found = machine.simulate(1.0, until={"low": "transmission < -60 deg"}, rtol=1e-10)
    assert found.ended_by == "low"
    assert_allclose(found["transmission"][-1], -np.pi / 3, atol=1e-9)
    accurate = machine.simulate(0.5, [0.25, 0.5], accuracy=1e-6, quantities=["ratio", "load"])
    assert_allclose(accurate["ratio"], ratio(accurate.q("crank.phi")), rtol=1e-6)


def test_members_of_an_ensemble_have_expressions(machine: Machine) -> None:
    starts, times = [5.0, 7.0], [0.25, 0.5]
    many = machine.ensemble(
        0.5, times, starts={"crank.omega": starts}, rtol=1e-10, threads=1, progress=False
    )
    for run, omega in enumerate(starts):
        alone = machine.simulate(0.5, times, start={"crank.omega": omega}, rtol=1e-10)
        assert (many["expression"].sel(run=run, output="load") == alone["load"]).all()


def test_driven_machines_have_expressions(folder: Path) -> None:
    model = four_bar()
    inverse = load(model, "driven", folder=folder).inverse_dynamics(INSTANTS)
    moved = load(model, "moved", folder=folder).kinematics(INSTANTS)
    for found in inverse, moved:
        assert_allclose(found["ratio"], ratio(SPEED * INSTANTS), atol=1e-12)
    assert_allclose(inverse["turned"], SPEED * INSTANTS, rtol=1e-15)
    assert inverse.series("turned")[1] == "s"  # of a number times s; the unit may be given
    step = 1e-5
    bend = (
        (ratio(SPEED * (INSTANTS + step)) - ratio(SPEED * (INSTANTS - step))) * SPEED / (2 * step)
    )
    assert_allclose(moved["bend"], bend, atol=1e-5)
    assert_allclose(moved["bend"], moved.a("rocker.phi"), rtol=1e-15)


def test_accelerations_of_points_are_exact(told: Result, folder: Path) -> None:
    moved = load(four_bar(), "moved", folder=folder).kinematics(INSTANTS)
    for found in told, moved:
        phi, omega, alpha = found.q("coupler.phi"), found.v("coupler.phi"), found.a("coupler.phi")
        c, s = np.cos(phi), np.sin(phi)
        x, y = c * COUPLER - s * 0.1, s * COUPLER + c * 0.1
        ax = found.a("coupler.x") - alpha * y - omega**2 * x
        ay = found.a("coupler.y") + alpha * x - omega**2 * y
        size = np.abs(ax).max()
        assert_allclose(found.point("tip", "ax"), ax, atol=1e-13 * size)
        assert_allclose(found["tip.ay"], ay, atol=1e-13 * size)
        assert found.series("tip.ax")[1] == "m/s^2"
    phi = SPEED * INSTANTS
    coupler = loop(phi)[0]
    rate = -CRANK * np.sin(phi - loop(phi)[1]) / (COUPLER * np.sin(coupler - loop(phi)[1])) * SPEED
    vx = -CRANK * SPEED * np.sin(phi) - rate * (
        2 * COUPLER * np.sin(coupler) + 0.1 * np.cos(coupler)
    )
    assert_allclose(moved.point("tip", "vx"), vx, atol=1e-9)


def test_outputs_that_no_scene_names_follow_afterwards(told: Result, folder: Path) -> None:
    model = four_bar()
    scene = model.scene("run").with_(outputs="default")
    found = load(model, scene, folder=folder).simulate(1.0, INSTANTS, rtol=1e-10)
    assert found.description.series.get("tip.ax") is None
    assert (found.point("tip", "ax") == told["tip.ax"]).all()
    text = load(model, scene, folder=folder).path.read_text()
    assert "derived_outputs" not in text
    with pytest.raises(LinkwrightError, match="no series 'transmission'"):
        found["transmission"]


def test_variations_keep_the_expressions_that_they_can_compute(folder: Path) -> None:
    model = four_bar()
    scene = model.scene("run").without("strut")
    assert [one.name for one in scene.expressions] == [
        "transmission",
        "ratio",
        "load",
        "lift",
        "jerky",
    ]
    load(model, scene, folder=folder)
    other = model.scene("run").with_(outputs={"transmission": model.bodies["coupler"].phi})
    assert other.name not in ("run", scene.name)
    assert model.scene("run").with_(outputs="default").name != "run"


@pytest.mark.parametrize(
    ("series", "said"),
    [("A.fz", "the scene has no 'A.fz'; did you mean 'A.f"),
     ("tip.az", "the scene has no 'tip.az'"),
     ("strut.normal", "the scene has no 'strut.normal'")],
)  # fmt: skip
def test_series_that_do_not_exist(series: str, said: str, folder: Path) -> None:
    model = four_bar()
    scene = model.scene("run").with_(outputs={"wrong": model.series(series)})
    with pytest.raises(ModelError, match=said):
        load(model, scene, folder=folder)


def test_what_a_scene_cannot_have(folder: Path) -> None:
    model = four_bar()
    for output in {"force": model.series("A.fx")}, {"rest": model.series("ground.fx")}:
        with pytest.raises(ModelError, match=r"the scene has no '(A|ground).fx'"):
            load(model, model.scene("moved").with_(outputs=output), folder=folder)
    model.scene("rest", ["gravity", "strut"], analysis="equilibrium",
                outputs={"still": model.series("a(crank.phi)")})  # fmt: skip
    with pytest.raises(ModelError, match=r"the scene has no 'a\(crank.phi\)'"):
        load(model, "rest", folder=folder)
    scene = model.scene("rest").with_(outputs={"jolt": model.series("tip.ax")})
    with pytest.raises(ModelError, match=r"the scene has no 'tip.ax'"):
        load(model, scene, folder=folder)
    lag = model.state("lag", rate=lambda lag: -lag, start=1.0, unit="m")
    scene = model.scene("run").with_(outputs={"late": lag})
    with pytest.raises(ModelError, match=r"the scene has no 'lag'"):
        load(model, scene, folder=folder)
    with pytest.raises(
        SceneError, match="its output 'transmission' is an expression, which no case"
    ):
        data_of_scene(model.scene("run"))
