"""Values of a run with units, and results in the unit that is asked for."""

import json
import pickle
import subprocess
import sys
from collections.abc import Callable
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from pint import get_application_registry
from typer.testing import CliRunner

from codegen import Model, build
from codegen.errors import InputError
from codegen.readers.quantities import UnitError, in_unit
from linkwright.cli.application import app
from runtime import load, sweep
from runtime.machine_facade import Machine
from runtime.results.result import Result
from runtime.sweeps.ensemble_arguments import read_members

MODEL = """
from codegen import Model, t

model = Model("press", gravity=(0, -9.81))
throw = model.parameter("throw", 250, unit="mm", sign="positive")
speed = model.parameter("speed", 90, unit="rpm")
bob = model.body("bob", mass="300 g", inertia="2 kg cm^2")
model.revolute("hinge", model.ground.at(0, 0), bob.at(-throw, 0))
model.track("tip", bob.at("250 mm", 0))
model.driver("motor", bob.phi, speed * t)
model.scene("swing", ["gravity"], start={bob.phi: "0 deg", bob.omega: "0 rpm"},
            outputs=["reactions", "energy", "powers", "point(tip)", "work(gravity)"])
model.scene("driven", ["gravity"], ["motor"])
"""
u = get_application_registry()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's folder with the model."""
    folder = tmp_path_factory.mktemp("units")
    (folder / "press.py").write_text(MODEL, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def machine(folder: Path) -> Machine:
    return load(str(folder / "press.py"), "swing", folder=folder)


@pytest.fixture(scope="module")
def result(machine: Machine) -> Result:
    return machine.simulate(1.0, 11, start={"bob.omega": 2 * pi}, progress=False)


@pytest.mark.parametrize(
    ("given", "si"),
    [
        ({"parameters": {"throw": "0.3 m"}}, {"parameters": {"throw": 0.3}}),
        ({"parameters": {"throw": 30.0 * u.cm}}, {"parameters": {"throw": 0.3}}),
        ({"start": {"bob.phi": "45 deg"}}, {"start": {"bob.phi": pi / 4}}),
        ({"start": {"bob.omega": "60 rpm"}}, {"start": {"bob.omega": 2 * pi}}),
        ({"t_end": "500 ms", "max_step": "10 ms"}, {"t_end": 0.5, "max_step": 0.01}),
        (
            {"until": {"low": ("bob.phi", "<", "-30 deg")}},
            {"until": {"low": ("bob.phi", "<", -pi / 6)}},
        ),
        ({"until": {"low": "bob.phi < -30 deg"}}, {"until": {"low": ("bob.phi", "<", -pi / 6)}}),
    ],
)
def test_a_run_with_units_is_that_in_si(
    machine: Machine, given: dict[str, Any], si: dict[str, Any]
) -> None:
    found, same = (machine.simulate(**{"t_end": 1.0, "progress": False} | x) for x in (given, si))
    np.testing.assert_allclose(found.t, same.t, rtol=1e-14)
    np.testing.assert_allclose(found.samples.q, same.samples.q, rtol=1e-11, atol=1e-13)
    assert found.parameters == pytest.approx(same.parameters, rel=1e-15)


def test_other_analyses_take_units(folder: Path, machine: Machine) -> None:
    driven = load(str(folder / "press.py"), "driven", folder=folder)
    moved = driven.kinematics("2 s", 3, parameters={"speed": "60 rpm"}, progress=False)
    np.testing.assert_allclose(moved.q("bob.phi"), [0.0, 2 * pi, 4 * pi], atol=1e-12)
    rest = machine.equilibrium(guess={"bob.phi": "-80 deg"}, progress=False)
    assert rest["bob.phi"] == pytest.approx(-pi / 2)
    assert machine.parameter_values({"throw": "1 ft"})[0] == pytest.approx(0.3048, rel=1e-15)
    begin = machine.assemble(start={"bob.phi": "90 deg", "bob.omega": "60 rpm"})
    assert (begin["bob.phi"], begin["bob.omega"]) == pytest.approx((pi / 2, 2 * pi))
    runs = machine.ensemble(
        0.2, 3, parameters={"throw": ["25 cm", "0.3 m"]}, starts={"bob.phi": "45 deg"},
        progress=False,
    )  # fmt: skip
    lone = machine.simulate(
        0.2, 3, parameters={"throw": 0.3}, start={"bob.phi": "45 deg"}, progress=False
    )
    assert (runs["q"].values[1] == lone.samples.q).all()
    with pytest.raises(InputError, match=r"parameters\['throw'\]: 3 kilogram has the dimension"):
        machine.ensemble(0.2, 3, parameters={"throw": ["3 kg"]}, progress=False)


def test_sweeps_take_units(folder: Path) -> None:
    about: dict[str, Any] = {"model": str(folder / "press.py"), "scene": "swing", "folder": folder}
    words = {"t_end": 0.1, "parameters": {"throw": "30 cm"}, "start": {"bob.omega": "60 rpm"}}
    study = sweep(
        over={"bob.phi": "0 deg:90 deg:2"}, quantities=["bob.omega"], out=folder / "s.zarr",
        workers=0, progress=False, **about, **words,
    )  # fmt: skip
    again = study.member(1)
    assert again.parameters["throw"] == 0.3
    assert (again.q("bob.phi")[0], again.v("bob.omega")[0]) == pytest.approx((pi / 2, 2 * pi))
    with pytest.raises(InputError, match="parameters, throw: 30 kilogram has the dimension"):
        sweep(
            over={"bob.phi": "0:1:2"}, quantities=["bob.omega"], out=folder / "t.zarr",
            progress=False, **about, **words | {"parameters": {"throw": "30 kg"}},
        )  # fmt: skip


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (
            {"start": {"bob.phi": "30 kg"}},
            "press/swing: start, bob.phi: 30 kilogram has the dimension [mass], but rad is needed",
        ),
        ({"start": {"bob.omega": "25 Hz"}}, "start, bob.omega: 25 hertz counts cycles"),
        ({"start": {"bob.omega": "60 1/min"}}, "start, bob.omega: 60 1 / minute counts cycles"),
        ({"guess": {"bob.x": "30 deg"}}, "guess, bob.x: 30 degree has the dimension"),
        ({"guess": {"bob.x": "3 blurb"}}, "guess, bob.x: 'blurb' is no unit"),
        ({"parameters": {"throw": "3 * t"}}, "throw is '3 * t'; it must be a finite number in m"),
        ({"parameters": {"throw": "45"}}, "throw is '45'; it must be a finite number in m"),
        ({"parameters": {"thrown": "45 mm"}}, "There is no parameter 'thrown'"),
        ({"guess": {"bob.z": "45 mm"}}, "There is no coordinate or velocity 'bob.z'"),
        ({"t_end": "10 m"}, "t_end is '10 m'; 10 meter has the dimension [length]"),
        ({"until": {"a": ("hinge.fx", ">", "3 m")}}, "until=a, hinge.fx: 3 meter has the"),
        ({"until": {"a": ("hinge.fx", ">", "3")}}, "is no condition"),
        ({"until": {"a": "hinge.fx > 3 m"}}, "until=a, hinge.fx: 3 meter has the"),
        ({"until": {"a": "hinge.fx"}}, "until=a, hinge.fx: 'hinge.fx' is no condition; write"),
    ],
)
def test_a_wrong_unit_is_refused(machine: Machine, given: dict[str, Any], why: str) -> None:
    with pytest.raises(InputError) as caught:
        machine.simulate(**{"t_end": 1.0, "progress": False} | given)
    assert why in str(caught.value)


def test_results_in_a_unit(result: Result) -> None:
    asked: list[tuple[Callable[..., Any], tuple[str, ...], str, float]] = [
        (result.q, ("bob.x",), "mm", 1000.0), (result.q, ("bob.phi",), "deg", 180 / pi),
        (result.v, ("bob.omega",), "rpm", 30 / pi), (result.v, ("bob.vx",), "km/h", 3.6),
        (result.a, ("bob.omega",), "deg/s^2", 180 / pi),
        (result.reaction, ("hinge", "fx"), "kN", 1e-3), (result.energy, ("kinetic",), "mJ", 1e3),
        (result.point, ("tip",), "cm", 100.0), (result.point, ("tip", "vx"), "mm/s", 1000.0),
        (result.power, ("gravity",), "mW", 1e3), (result.work, ("gravity",), "N mm", 1e3),
    ]  # fmt: skip
    for method, names, unit, factor in asked:
        np.testing.assert_allclose(method(*names, unit=unit), factor * method(*names), rtol=1e-14)
    assert result.v("bob.omega", unit="rpm")[0] == pytest.approx(60.0, rel=1e-14)
    values, unit = result.series("hinge.fx", "kN")
    assert (values[-1], unit) == (pytest.approx(result.reaction("hinge", "fx")[-1] / 1e3), "kN")
    assert result.q("bob.x", unit="m") is not None
    assert (result.q("bob.x", unit="m") == result.q("bob.x")).all()
    assert result.data["q"].sel(coordinate="bob.x").values[-1] == result.q("bob.x")[-1]


@pytest.mark.parametrize(
    ("method", "name", "unit", "own"),
    [("q", "bob.x", "kg", "m"), ("q", "bob.x", "blurb", "m"), ("v", "bob.omega", "Hz", "rad/s")],
)
def test_a_unit_that_does_not_fit(
    result: Result, method: str, name: str, unit: str, own: str
) -> None:
    why = f"press/swing: {name} is in {own}, which does not convert to '{unit}'"
    with pytest.raises(InputError, match=why):
        getattr(result, method)(name, unit=unit)


def test_plots_in_units(result: Result) -> None:
    axes = result.plot("bob.x", "bob.omega", "tip", "hinge.fx", unit=("mm", "rpm")).axes
    assert [axis.get_ylabel() for axis in axes] == ["mm", "rpm", "N", "y (mm)"]
    names = ("bob.x", "bob.omega", "hinge.fx", "tip.y")
    units = ("mm", "rpm", "N", "mm")
    for axis, name, unit in zip(axes, names, units, strict=True):
        drawn = axis.lines[0].get_ydata()
        np.testing.assert_allclose(drawn[-1], result.series(name, unit)[0][-1])
    assert result.plot(unit="deg").axes[0].get_ylabel() == "deg"
    why = r"unit 'kg' fits none of bob.x \(m\), bob.phi \(rad\); leave it out"
    with pytest.raises(InputError, match=why):
        result.plot("bob.x", "bob.phi", unit=("mm", "kg"))
    why = "unit 'm' comes after another that fits the same of bob.x .*; leave it out"
    with pytest.raises(InputError, match=why):
        result.table("bob.x", "bob.y", unit=("mm", "m"))
    assert result.draw("0 s").axes
    shown = result.table("bob.x", "bob.omega", unit=("mm", "rpm"))
    assert [*shown] == ["bob.x [mm]", "bob.omega [rpm]"]
    assert shown["bob.x [mm]"].iloc[0] == pytest.approx(1e3 * result["bob.x"][0])


def test_instants_are_texts_too(machine: Machine) -> None:
    r = machine.simulate("1 s", ["0.1 s", "200 ms"], progress=False)
    assert r.t.tolist() == [0.1, 0.2]
    assert r.at("0.15 s").t.tolist() == [0.15]
    with pytest.raises(InputError, match="t is '2 kg'; it must be an instant in s"):
        r.at("2 kg")


def test_a_point_that_no_output_names_is_drawn(folder: Path) -> None:
    r = load(str(folder / "press.py"), "driven", folder=folder).kinematics(0.5)
    assert "tip" not in r.description.tracked
    assert [axis.get_ylabel() for axis in r.plot("tip", unit="mm").axes] == ["y (mm)"]


def test_a_condition_on_a_quantity_that_is_not_there_says_so(machine: Machine) -> None:
    with pytest.raises(InputError, match="gravity") as caught:
        machine.simulate(1.0, until={"hit": ("gravity.force", ">", "100 N")})
    assert "pure number" not in str(caught.value)
    ends = [machine.simulate(1.0, until={"turned": one}).t[-1] for one in (
        "bob.phi <= -30 deg", ("bob.phi", "<=", "-30 deg"), "bob.phi < -30 deg"
    )]  # fmt: skip
    assert ends[0] == ends[1] == ends[2] < 1.0


def test_a_text_brings_the_unit_of_a_parameter() -> None:
    model = Model("texts")
    model.parameter("density", "7.85 g/cm^3")
    model.parameter("time", "4 s")
    rows = model.parameters.values()
    assert [(round(row.value, 9), row.unit) for row in rows] == [(7850.0, "kg/m^3"), (4.0, "s")]


def test_commands_take_units(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    words = ["simulate", "press.py", "--t-end", "0.1", "--json"]
    values = ["--set", "throw=30 cm", "--start", "bob.phi=30 deg", "--start", "bob.omega=1500 rpm"]
    answer = json.loads(CliRunner().invoke(app, [*words, *values]).stdout)
    assert answer["parameters"]["throw"] == pytest.approx(0.3, rel=1e-15)
    assert f"bob.phi = {pi / 6:.6g} rad, bob.omega = {50 * pi:.6g} rad/s" in answer["message"]
    until = ["--until", "low: bob.phi < -30 deg", "--set", "throw=0.3"]
    ended = json.loads(
        CliRunner().invoke(app, ["simulate", "press.py", "--t-end", "2", "--json", *until]).stdout
    )
    assert ended["q"]["bob.phi"] == pytest.approx(-pi / 6)
    for option, value, why in (
        ("--set", "throw=30 kg", "throw: 30 kilogram has the dimension [mass], but m is needed"),
        ("--set", "throw=thirty mm", 'or with one and its unit, "NAME=45 mm"'),
        ("--start", "bob.phi=3 m", "start, bob.phi: 3 meter has the dimension [length], but rad"),
    ):
        done = CliRunner().invoke(app, [*words, option, value])
        assert (done.exit_code, why in done.stderr) == (2, True), done.stderr
    checked = CliRunner().invoke(app, ["check", "press.py", "--set", "throw=-3 cm"])
    assert "parameter 'throw' is -0.03 m" in checked.stderr


def test_a_build_with_units_is_that_in_si(folder: Path) -> None:
    built = [
        build(folder / "press.py", "swing", folder / "out", settings={"throw": value}).scenes[0]
        for value in ("40 cm", 0.4)
    ]
    assert built[0].path == built[1].path
    assert built[0].text == built[1].text


def test_runs_in_si_do_not_load_pint(folder: Path, machine: Machine) -> None:
    code = (
        "import sys; from runtime import load; m = load('slider_crank', 'compressor'); "
        "r = m.simulate(0.01, parameters={'J1': 450.0, 'motor_torque': '41450 N m'}, "
        "start={'crank.phi': '0.1 rad'}, progress=False); r.q('crank.phi', unit='rad'); "
        "print('pint' in sys.modules)"
    )
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.stdout.split(), done.stderr) == (["False"], "")


def test_times_are_quantities(folder: Path, machine: Machine) -> None:
    ms = u.Unit("ms")
    driven = load(str(folder / "press.py"), "driven", folder=folder)
    assert driven.kinematics(2000 * ms, 3, progress=False).t.tolist() == [0.0, 1.0, 2.0]
    assert driven.kinematics([0 * ms, 500 * ms], progress=False).t.tolist() == [0.0, 0.5]
    r = machine.simulate(0.1, np.array([0, 50, 100]) * ms, progress=False)
    assert r.t.tolist() == [0.0, 0.05, 0.1]
    assert r.at(np.array([5, 6]) * ms).t.tolist() == [0.005, 0.006]
    assert r.state(5 * ms).t == 0.005
    assert r.resume("200 ms", progress=False).t[-1] == 0.2
    with pytest.raises(InputError, match="it must be instants in s"):
        machine.simulate(0.1, np.array([0, 1]) * u.Unit("m"), progress=False)


def test_columns_of_an_ensemble_are_quantities(machine: Machine) -> None:
    cm, deg = u.Unit("cm"), u.Unit("deg")
    columns: list[tuple[Any, list[float]]] = [
        ([25 * cm, 30 * cm], [0.25, 0.3]), (np.array([25, 30]) * cm, [0.25, 0.3]),
        (["25 cm", 0.3], [0.25, 0.3]), (np.array(["25 cm", 0.3], object), [0.25, 0.3]),
        (pd.Series(["25 cm", "30 cm"]), [0.25, 0.3]), ((0.25, 0.3), [0.25, 0.3]),
    ]  # fmt: skip
    for given, metres in columns:
        read = read_members(machine.mechanism, {"throw": given}, {"bob.phi": 180 * deg})
        assert read.parameters["throw"] == pytest.approx(metres)
        assert read.starts["bob.phi"] == pytest.approx([pi, pi])
    for wrong in (["25", "30"], {0.25: 1}, np.array([[1, 2]]) * cm, [3 * deg]):
        with pytest.raises(InputError, match=r"parameters\['throw'\]"):
            read_members(machine.mechanism, {"throw": wrong}, None)


@pytest.mark.parametrize("unit", ["Nm", "mNm", "kNm", "Nm/deg", "PS", "U/min"])
def test_a_unit_that_pint_misreads_is_refused(unit: str) -> None:
    model = Model("misread")
    model.parameter("size", 3, unit=unit)
    assert "write one such as 'mm', 'N m'" in model.problems[0]
    with pytest.raises(UnitError, match="is no unit; write products of powers, such as N m"):
        in_unit(f"3 {unit}", "N m")


def test_a_lead_is_a_length() -> None:
    for given in ("5 mm/turn", u.Quantity(5, "mm/turn")):
        for needed in ("m", "mm"):
            with pytest.raises(UnitError, match="is a length for each angle"):
                in_unit(given, needed)
    assert in_unit("5 mm/rad", "m/rad") == 0.005
    assert in_unit("5 mm", "m") == 0.005


def test_results_take_units_of_pint(result: Result) -> None:
    mm = u.Unit("mm")
    assert (result.q("bob.x", unit=mm) == result.q("bob.x", unit="mm")).all()
    assert [*result.table("bob.x", unit=mm, count=3)] == ["bob.x [millimeter]"]
    drawn = result.plot("bob.x", unit=mm)
    assert pickle.loads(pickle.dumps(drawn)).axes[0].get_ylabel() == "millimeter"
    with pytest.raises(InputError, match="unit 5 fits none of"):
        result.plot("bob.x", unit=5)
    for count in ("3", 2.5):
        with pytest.raises(InputError, match=r"count is .* it must be a whole number"):
            result.table("bob.x", count=count)
