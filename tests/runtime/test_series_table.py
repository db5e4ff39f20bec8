"""The table of series: every name of a series, its column, unit and kind."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from codegen import Model
from codegen.declare.element import QUANTITIES
from codegen.errors import InputError
from runtime import load
from runtime.machine_facade import Machine
from runtime.mechanism import series_table
from runtime.results.result import Result


@pytest.fixture(scope="module")
def machine(workshop: Path) -> Machine:
    model = Model("table_of_series", gravity=(0, -9.81))
    bob = model.body("bob", mass=2.0, inertia=0.5)
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    current = model.state("current", unit="A", rate=-bob.omega)
    held = model.sampled("held", 0.1, bob.phi)
    model.torque("motor", on=bob, value=0.1 * current + 0.01 * held)
    model.spring("strut", model.ground.at(2, 0), bob, 40.0, free_length=1.0, damping=0.8)
    model.track("tip", bob.at(1, 0))
    acting = ["gravity", "motor", "strut"]
    outputs = ["reactions", "energy", "powers", "force(strut)", "torque(motor)", "work(motor)"]
    start = {bob.phi: 0.3, bob.omega: 0.0}
    model.scene("run", acting, start=start, outputs=[*outputs, "point(tip)"])
    model.scene("bare", acting, start=start, outputs=["force(strut)"])
    return load(model, "run", folder=workshop)


def test_both_rooms_know_the_same_quantities() -> None:
    assert series_table.QUANTITIES == QUANTITIES


@pytest.fixture(scope="module")
def result(machine: Machine) -> Result:
    return machine.simulate(0.3, 5)


@pytest.mark.parametrize(
    ("name", "own", "kind", "unit", "method"),
    [
        ("bob.phi", "bob.phi", "coordinate", "rad", lambda r: r.q("bob.phi")),
        ("bob.omega", "bob.omega", "velocity", "rad/s", lambda r: r.v("bob.phi")),
        ("a(bob.phi)", "a(bob.phi)", "acceleration", "rad/s^2", lambda r: r.a("bob.omega")),
        ("current", "current", "state", "A", lambda r: r.y("current")),
        ("a(current)", "a(current)", "rate of state", "A/s", lambda r: r.a("current")),
        ("a(held)", "a(held)", "bookkeeping", "1/s", lambda r: r.a("held")),
        ("current.integral", "current.integral", "bookkeeping", "A s", None),
        ("hinge.fx", "hinge.fx", "reaction", "N", lambda r: r.reaction("hinge", "fx")),
        ("strut.force", "strut.force", "effect", "N", lambda r: r.force("strut")),
        ("force(strut)", "strut.force", "effect", "N", lambda r: r.force("strut")),
        ("torque(motor)", "motor.torque", "effect", "N m", lambda r: r.torque("motor")),
        ("tip.vx", "tip.vx", "point", "m/s", lambda r: r.point("tip", "vx")),
        ("kinetic", "kinetic", "energy", "J", lambda r: r.energy("kinetic")),
        ("total", "total", "energy", "J", lambda r: r.energy()),
        ("kinetic energy", "kinetic", "energy", "J", lambda r: r.energy("kinetic")),
        ("velocity residual", "velocity residual", "residual", "", None),
        ("strut", "strut", "power", "W", lambda r: r.power("strut")),
        ("power(gravity)", "gravity", "power", "W", lambda r: r.power("gravity")),
        ("work(motor)", "work(motor)", "work", "J", lambda r: r.work("motor")),
    ],
)
def test_a_name_finds_its_column(
    machine: Machine, result: Result, name: str, own: str, kind: str, unit: str, method: object
) -> None:
    row = machine.description.series.find(name)
    assert (row.name, row.kind, row.unit) == (own, kind, unit)
    values, found = result.series(name)
    assert found == unit
    assert np.isfinite(values).all()
    assert method is None or (values == method(result)).all()  # type: ignore[operator]


def test_every_column_of_a_table_is_a_series(result: Result) -> None:
    table = result.to_pandas()
    assert {"nonconservative power(strut)", "total energy", "constraint residual"} <= {*table}
    for name in table:
        values, unit = result.series(name)
        assert_array_equal(values, table[name])
        assert unit == table.attrs["units"][name]


def test_advice_on_frequencies_is_for_speeds(result: Result) -> None:
    for series, advice in (("bob.omega", r" \(rpm or deg/s, and not Hz\)"), ("bob.x", "")):
        with pytest.raises(InputError, match=rf"ask for a unit of its dimension{advice}\."):
            result.v(series, "Hz") if advice else result.q(series, "Hz")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("bob.fi", "There is no series 'bob.fi'; nearest: bob.phi"),
        ("???", r"There is no series '\?\?\?'; there are: coordinate bob.x, .* power "),
        ("force(hinge)", r"several components of force; ask for force\('hinge', 'fx'\)"),
        ("length(strut)", r"does not compute length\(strut\)"),
        ("strut.length", r"does not compute length\(strut\)"),
        ("work(strut)", r"does not compute work\(strut\)"),
        ("power(bob)", "There is no power of 'bob'"),
    ],
)
def test_a_name_that_is_none_says_which_there_are(
    machine: Machine, name: str, message: str
) -> None:
    assert machine.description.series.get(name) is None
    with pytest.raises(InputError, match=message):
        machine.description.series.find(name)


def test_a_scene_has_no_series_of_what_it_leaves_out(machine: Machine, workshop: Path) -> None:
    assert machine.mechanism.origin is not None
    bare = load(machine.mechanism.origin.model, "bare", folder=workshop).description.series
    assert bare.of_kind("energy", "reaction") == []
    for name, output in (
        ("total", "energy"), ("kinetic energy", "energy"), ("reaction", "reaction"),
        ("hinge.fx", r"reaction\(hinge\)"), ("tip.y", r"point\(tip\)"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=f"does not compute {output}"):
            bare.call("reaction", "hinge", "fx") if name == "reaction" else bare.find(name)


@pytest.mark.parametrize("name", [None, 3, ["bob.x"], np.zeros(2)])
def test_a_name_is_a_text(result: Result, name: object) -> None:
    ask = (result.q, result.v, result.a, result.y, result.point, result.energy, result.power)
    for lookup in (*ask, result.work, result.mode, result.share, result.force, result.series):
        with pytest.raises(InputError, match=r"is no name; a name is a text, such as 'bob\.x'"):
            lookup(name)  # type: ignore[arg-type]
