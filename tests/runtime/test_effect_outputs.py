"""Forces, lengths, rates, potentials and whole powers of effects, as outputs that a scene names."""

from pathlib import Path

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Effect, Model, ModelError, element
from codegen.declare.element import Measure
from codegen.declare.symbols import SPEED
from codegen.errors import InputError
from codegen.reading.scene_selection import valid_scenes
from runtime import Machine, Result, load
from runtime.studies.quantity import parse_quantity

INSTANTS = np.linspace(0.0, 1.0, 201)
EVERY = ["gravity", "strut", "coil", "floor", "gas", "bush", "law", "motor", "air", "rubber"]
EVERY += ["well"]
K, C, FREE = 200.0, 3.0, 1.2


@element
class Rubber(Effect):
    """A user's own force along a length, which hardens: f = a (l - 1)³ + b l'."""

    kind = "rubber band for outputs"
    name: str
    length: sympy.Expr

    def pulls(self, bodies):
        return ((self.length, 30 * (self.length - 1) ** 3 + 2 * SPEED),)


@element
class Pressed(Effect):
    """A user's own force along half the square of a coordinate, which is in m²."""

    kind = "pressed for outputs"
    name: str
    place: sympy.Expr

    def pulls(self, bodies):
        return ((self.place**2 / 2, 3 * self.place),)


@element
class Well(Effect):
    """A user's own potential, which says what it measures."""

    kind = "well for outputs"
    name: str
    height: sympy.Expr

    def potential(self, bodies):
        return 4 * self.height**2

    def measures(self, bodies):
        return (
            Measure("length", "", "m", self.height),
            Measure("force", "", "N", 8 * sympy.Abs(self.height)),
        )


def machine_of_everything() -> Model:
    """A slide with a wheel, held and driven by every kind of force."""
    model = Model("effect_outputs", gravity=(0, -9.81))
    b = model.body("b", mass=2.0, inertia=0.1)
    w = model.body("w", mass=1.0, inertia=0.1)
    model.translational("guide", model.ground.at(0, 0), b.at(0, 0), axis=(0, 1))
    model.revolute("pin", b, w)
    model.spring("strut", model.ground.at(0, 1), b, K, free_length=FREE, damping=C)
    model.torsion_spring("coil", b, w, 3.0, free_angle=0.1, damping=0.1)
    model.contact("floor", gap=b.y + 0.1, stiffness=1e4, damping=10, may_pull=False)
    model.force("gas", on=b, fx=1.0, fy=2 * b.vy, when=b.vy > 0)
    model.bushing("bush", b, w.at(0.02, 0.01), (100, 200, 3), (1, 2, 3))
    model.generalized_force("law", {b.y: -b.vy, w.phi: 0.1})
    model.torque("motor", on=w, value=0.3)
    model.generalized_force("air", {b.y: -0.2 * b.vy})
    model.add(Rubber("rubber", sympy.sqrt(1 + (b.y - 1) ** 2)))
    model.add(Well("well", b.y - 0.05))
    start = {b.y: 0.3, b.vy: 0.0, w.phi: 0.2, w.omega: 0.0}
    model.scene("whole", EVERY, start=start, outputs="all")
    model.scene("plain", EVERY, start=start)
    model.driver("hand", b.y, 0.3)
    model.driver("turn", w.phi, 0.0)
    return model


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("effects")


@pytest.fixture(scope="module")
def whole(folder: Path) -> Result:
    machine = load(machine_of_everything(), "whole", folder=folder)
    return machine.simulate(1.0, INSTANTS, rtol=1e-10)


@pytest.fixture(scope="module")
def plain(folder: Path) -> Machine:
    return load(machine_of_everything(), "plain", folder=folder)


def test_lengths_and_forces_are_those_of_the_laws(whole: Result) -> None:
    """Every law written by hand, from the coordinates."""
    y, vy = whole.q("b.y"), whole.v("b.y")
    theta = whole.q("w.phi") - whole.q("b.phi")
    length, rate = np.abs(1 - y), -vy * np.sign(1 - y)
    assert_allclose(whole.length("strut"), length, atol=1e-14)
    assert_allclose(whole.rate("strut"), rate, atol=1e-13)
    assert_allclose(whole.deflection("strut"), length - FREE, atol=1e-14)
    assert_allclose(whole.force("strut"), K * (length - FREE) + C * rate, atol=1e-11)
    assert_allclose(whole.potential("strut"), K * (length - FREE) ** 2 / 2, atol=1e-12)
    assert_allclose(whole.angle("coil"), theta, atol=1e-14)
    assert_allclose(whole.deflection("coil"), theta - 0.1, atol=1e-14)
    turning = 3 * (theta - 0.1) + 0.1 * whole.rate("coil")
    assert_allclose(whole.torque("coil"), turning, atol=1e-12)
    assert_allclose(whole.force("gas", "fy"), np.where(vy > 0, 2 * vy, 0.0), atol=1e-13)
    assert (whole.torque("motor") == 0.3).all()
    assert_allclose(whole.force("law"), -vy, atol=1e-14)
    assert (whole.torque("law") == 0.1).all()
    assert_allclose(whole.force("gravity", "b.y"), -2 * 9.81, atol=1e-14)
    assert_allclose(whole.force("air"), -0.2 * vy, atol=1e-14)


def test_a_contact_pushes_while_it_is_penetrated(whole: Result) -> None:
    gap, rate = whole.gap("floor"), whole.rate("floor")
    assert_allclose(gap, whole.q("b.y") + 0.1, atol=1e-14)
    assert gap.min() < -1e-3
    assert_allclose(whole.penetration("floor"), np.maximum(-gap, 0.0), atol=1e-14)
    pushing = np.where(gap < 0, np.maximum(-1e4 * gap - 10 * rate, 0.0), 0.0)
    assert_allclose(whole.force("floor"), pushing, atol=1e-10)
    assert whole.force("floor").max() > 100.0


def test_a_bushing_has_the_forces_of_its_axes(whole: Result) -> None:
    phi, moved = whole.q("w.phi"), whole.deflection
    assert_allclose(moved("bush", "x"), 0.02 * np.cos(phi) - 0.01 * np.sin(phi), atol=1e-13)
    assert_allclose(moved("bush", "phi"), phi, atol=1e-14)
    for axis, k, c in (("x", 100, 1), ("y", 200, 2)):
        expected = -k * moved("bush", axis) - c * whole.rate("bush", axis)
        assert_allclose(whole.force("bush", f"f{axis}"), expected, atol=1e-12)
    expected = -3 * moved("bush", "phi") - 3 * whole.rate("bush", "phi")
    assert_allclose(whole.torque("bush"), expected, atol=1e-12)


def test_a_users_own_effect_has_its_scalar_its_rate_and_its_force(whole: Result) -> None:
    y, vy = whole.q("b.y"), whole.v("b.y")
    length = np.sqrt(1 + (y - 1) ** 2)
    rate = (y - 1) * vy / length
    assert_allclose(whole.length("rubber"), length, atol=1e-13)
    assert_allclose(whole.rate("rubber"), rate, atol=1e-13)
    assert_allclose(whole.force("rubber"), 30 * (length - 1) ** 3 + 2 * rate, atol=1e-12)
    assert_allclose(whole.force("well"), 8 * np.abs(y - 0.05), atol=1e-13)
    assert_allclose(whole.potential("well"), 4 * (y - 0.05) ** 2, atol=1e-13)


def test_the_force_that_is_said_is_the_one_that_moves_the_slide(whole: Result) -> None:
    """Newton's law of the slide and the wheel together, along the guide."""
    strut, rubber = whole.force("strut"), whole.force("rubber")
    slope = (whole.q("b.y") - 1) / whole.length("rubber")
    pushed = strut * np.sign(1 - whole.q("b.y")) - rubber * slope + whole.force("floor")
    pushed += whole.force("gas", "fy") + whole.force("law") + whole.force("air")
    pushed += whole.force("gravity", "b.y") + whole.force("gravity", "w.y")
    pushed -= 8 * (whole.q("b.y") - 0.05)
    assert_allclose(pushed, 2 * whole.a("b.y") + whole.a("w.y"), atol=1e-9)


def test_power_is_all_that_an_effect_gives_and_work_its_integral(whole: Result) -> None:
    """Power is -dV/dt less what the damper takes; quadrature of it is the work."""
    rate = whole.rate("strut")
    assert_allclose(whole.power("strut"), -whole.force("strut") * rate, atol=1e-10)
    assert_allclose(whole.power("strut", "nonconservative"), -C * rate**2, atol=1e-11)
    assert_allclose(
        whole.power("gravity"), -9.81 * (2 * whole.v("b.y") + whole.v("w.y")), atol=1e-11
    )
    assert {"strut", "coil", "bush", "gravity", "well"} <= {*whole.description.whole_powers}


def test_power_integrates_to_work(folder: Path) -> None:
    """A spring with a damper, without contacts: Simpson's rule on the power."""
    model = Model("spring_power")
    b = model.body("b", mass=1.0, inertia=0.1)
    model.translational("guide", model.ground.at(0, 0), b.at(0, 0), axis=(1, 0))
    model.spring("damped", model.ground.at(-1, 0), b, 40.0, free_length=1.0, damping=0.8)
    model.spring("pure", model.ground.at(-1, 0), b, 10.0, free_length=1.1)
    start = {b.x: 0.2, b.vx: -0.3}
    model.scene("swing", ["damped", "pure"], start=start, outputs=["powers", "works", "energy"])
    found = load(model, folder=folder).simulate(0.8, np.linspace(0, 0.8, 801), rtol=1e-11)
    h = found.t[1] - found.t[0]
    weights = np.ones(801)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    for name in ("damped", "pure"):
        done = found.work(name)[-1]
        assert abs(done) > 1e-2
        assert abs(h / 3 * weights @ found.power(name) - done) < 1e-9
    assert_allclose(
        found.work("damped") + found.work("pure"),
        found.energy("kinetic") - found.energy("kinetic")[0], atol=1e-9,
    )  # fmt: skip


def test_what_is_stored_is_told_apart_from_the_power(plain: Machine) -> None:
    found = plain.simulate(0.02)
    names = plain.description.reactions.names
    assert {name.partition(".")[0] for name in names} == {"guide", "pin"}
    assert plain.description.balanced_rows == len(plain.description.powers)
    assert (found.power("strut", "nonconservative") <= 0).all()
    assert np.abs(found.power("strut") - found.power("strut", "nonconservative")).max() > 1e-6
    with pytest.raises(
        InputError,
        match=r"'strut' has no power 'damper'; ask for power\('strut', 'nonconservative'\)",
    ):
        found.power("strut", "damper")
    with pytest.raises(InputError, match="no nonconservative power of 'gravity'"):
        found.power("gravity", "nonconservative")
    assert "strut" not in found.data["source"]
    assert "strut" in found.data["nonconservative_source"]


def test_what_was_not_asked_for_says_what_to_write(plain: Machine, folder: Path) -> None:
    found = plain.simulate(0.01)
    model = machine_of_everything()
    for quantity, name in (("force", "strut"), ("gap", "floor"), ("angle", "coil")):
        with pytest.raises(InputError) as caught:
            plain.description.series.call(quantity, name)
        text = str(caught.value)
        written = f"outputs=['default', '{quantity}({name})']"
        assert written in text
        machine = load(model, eval(f"model.scene('plain').with_({written})"), folder=folder)
        named = getattr(machine.simulate(0.01), quantity)(name)
        assert (named == getattr(found, quantity)(name)).all()
    with pytest.raises(InputError, match="no force of 'struts'; nearest: strut"):
        found.force("struts")


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        (("force", "bush"), r"several components of force; ask for force\('bush', 'f"),
        (("force", "gas", "fz"), r"no force 'fz'; ask for force\('gas', 'fx'\)"),
        (("force", "coil"), r"no force of 'coil'; ask for angle\('coil'\), rate\('coil'\)"),
        (("length", "guide"), r"no length of 'guide'; ask for reaction\('guide"),
    ],
)
def test_other_names_are_refused_with_those_that_exist(
    whole: Result, asked: tuple[str, ...], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        getattr(whole, asked[0])(*asked[1:])
    assert (whole.force("guide", "fx") == whole.reaction("guide", "fx")).all()


def test_quantities_are_series_columns_variables_and_objectives(
    whole: Result, tmp_path: Path
) -> None:
    assert whole.series("strut.force")[1] == "N"
    assert (whole.series("force(strut)")[0] == whole.force("strut")).all()
    assert whole.series("rate(coil)")[1] == "rad/s"
    assert whole.series("power(strut)")[1] == "W"
    head = whole.save(tmp_path / "run.csv").read_text().splitlines()[0]
    for column in ("strut.force [N]", "coil.angle [rad]", "power(gravity) [W]"):
        assert column in head
    data = whole.data
    assert data["force"].attrs["units"] == "N"
    assert (data["force"].sel(effect="strut") == whole.force("strut")).all()
    assert (data["force"].sel(effect="gas.fy") == whole.force("gas", "fy")).all()
    assert "units" not in data["rate"].attrs
    assert data["rate_unit"].sel(effect="coil") == "rad/s"
    assert "strut" not in data["joint"]
    peak = parse_quantity("max:strut.force").read(whole)
    assert_allclose(peak.value, whole.force("strut").max(), rtol=1e-3)
    assert whole.plot("strut.force", "force(floor)").axes[0].get_ylabel() == "N"


def test_an_accuracy_target_takes_a_force(folder: Path) -> None:
    model = machine_of_everything()
    scene = model.scene("plain").without("floor", "gas").with_(outputs=["force(strut)"])
    found = load(model, scene, folder=folder).simulate(
        0.5, INSTANTS[:101], accuracy=1e-6, quantities=["strut.force"]
    )
    assert found.accuracy is not None
    assert [row.name for row in found.accuracy.quantities] == ["strut.force"]
    assert found.accuracy.estimated < 1e-6
    names, scene = ["force(strut)"], scene.with_(outputs=["force(strut)"])  # as outputs are written
    machine = load(model, scene, folder=folder)
    found = machine.simulate(0.5, INSTANTS[:101], accuracy=1e-6, quantities=names)
    assert [row.name for row in found.accuracy.quantities] == names  # type: ignore[union-attr]


def test_a_kinematic_scene_has_lengths_and_no_forces(folder: Path) -> None:
    model = machine_of_everything()
    keep = ["strut", "floor"]
    where = {"analysis": "kinematics", "drivers": ["hand", "turn"]}
    model.scene("posed", keep, outputs=["length(strut)", "penetrations", "rates"], **where)
    model.scene("alles", keep, outputs="all", **where)
    found = load(model, "posed", folder=folder).kinematics([0.0, 1.0])
    assert_allclose(found.length("strut"), 0.7, atol=1e-12)
    assert (found.penetration("floor") == 0).all()
    assert "mass" not in load(model, "posed", folder=folder).description.kernels
    assert "gaps" in valid_scenes(model, "alles")[0].outputs
    with pytest.raises(ModelError, match=r"'force\(strut\)' needs masses and forces"):
        valid_scenes(model, model.scene("posed").with_(outputs=["force(strut)"]))


def test_a_rest_position_has_the_forces_that_hold_it(folder: Path) -> None:
    model = machine_of_everything()
    keep = ["gravity", "strut"]
    model.scene("rest", keep, analysis="equilibrium", outputs=["energy", "forces", "potentials"])
    found = load(model, "rest", folder=folder).equilibrium()
    assert_allclose(found.force("strut"), 3 * 9.81, rtol=1e-9)


def test_frictions_and_rigid_contacts_say_force_normal_and_slip(folder: Path) -> None:
    """A block thrown along a rough guide, one on a table: Coulomb's law in closed form."""
    model = Model("rough_outputs", gravity=(0, -9.81))
    block = model.body("block", mass=2.0, inertia=0.1)
    ball = model.body("ball", mass=3.0, inertia=0.1)
    guide = model.translational("guide", model.ground.at(0, 0), block.at(0, 0), axis=(1, 0))
    model.friction("rub", guide, 0.3, creep=1e-6)
    model.dry_friction("brake", slip=block.vx, coefficient=0.1, normal=5.0)
    model.contact("table", gap=ball.y, restitution=0.0)
    start = {block.x: 0.0, block.vx: 4.0, ball.x: 0.0, ball.vx: 0.0, ball.y: 0.0, ball.vy: 0.0}
    start |= {ball.phi: 0.0, ball.omega: 0.0}
    every = ["gravity", "rub", "brake", "table"]
    asked = ["force(rub)", "rate(rub)", "force(brake)", "rate(brake)", "force(table)", "gaps"]
    model.scene("slide", every, start=start, outputs=asked)
    found = load(model, folder=folder).simulate(0.5, INSTANTS / 2, rtol=1e-10)
    weight = 2 * 9.81
    assert_allclose(found.force("rub"), -0.3 * weight, rtol=1e-9)
    assert_allclose(found.force("rub", "normal"), weight, rtol=1e-9)
    assert (found.rate("rub") == found.v("block.vx")).all()
    assert_allclose(found.rate("brake"), 4.0 - (0.3 * 9.81 + 0.25) * found.t, rtol=1e-8)
    assert_allclose(found.force("brake"), -0.5, atol=1e-12)
    assert_allclose(found.force("brake", "normal"), 5.0)
    assert_allclose(found.force("table"), 3 * 9.81, rtol=1e-9)
    assert_allclose(found.gap("table"), 0.0, atol=1e-9)
    assert {*found.description.reactions.names} == {
        "rub.force", "rub.normal", "rub.rate", "brake.force", "brake.rate", "brake.normal",
        "table.force", "table.gap",
    }  # fmt: skip


def test_a_scalar_of_unknown_unit_is_no_length(folder: Path) -> None:
    """Of a force along it are the generalized forces, whose units are known."""
    model = Model("unknown_unit_outputs")
    block = model.particle("block", mass=2.0)
    model.add(Pressed("pressed", block.x))
    start = {block.x: 1.0, block.y: 0.0, block.vx: 0.0, block.vy: 0.0}
    model.scene("run", ["pressed"], start=start, outputs=["forces"])
    found = load(model, folder=folder).simulate(0.1)
    (row,) = found.description.reactions
    assert (row.name, row.unit) == ("pressed.block.x", "N")
    assert_allclose(found.force("pressed"), -3 * found.q("block.x") ** 2, rtol=1e-12)
    with pytest.raises(ModelError, match=r"'length\(pressed\)'"):
        valid_scenes(model, model.scene("run").with_(outputs=["length(pressed)"]))


def test_flanks_of_gears_with_backlash_and_rotor_of_a_motor(folder: Path) -> None:
    """Two flanks, of which one bears; the line of the motor's torque."""
    model = Model("geared_outputs")
    small, large = (model.body(name, mass=1.0, inertia=0.01) for name in ("small", "large"))
    model.revolute("small_pin", model.ground.at(0, 0), small)
    model.revolute("large_pin", model.ground.at(0.3, 0), large)
    model.gear_with_backlash("teeth", small, large, 0.1, 0.2, backlash=1e-3, stiffness=1e4)
    model.motor("drive", small, stall_torque=0.5, no_load_speed=20.0)
    start = {small.phi: 0.0, large.phi: 0.0, small.omega: 0.0, large.omega: 0.0}
    model.scene("run", ["teeth", "drive"], start=start, outputs="all")
    found = load(model, folder=folder).simulate(0.3, INSTANTS * 0.3, rtol=1e-9)
    moved = 0.1 * found.q("small.phi") + 0.2 * found.q("large.phi")
    assert_allclose(found.gap("teeth", "first"), 5e-4 - moved, atol=1e-12)
    first = 1e4 * np.maximum(moved - 5e-4, 0.0)
    assert_allclose(found.force("teeth", "first"), first, atol=1e-9)
    assert first.max() > 1.0
    torque = 0.5 * (1 - found.v("small.omega") / 20.0)
    assert_allclose(found.torque("drive"), torque, atol=1e-12)


def test_a_kinematic_scene_is_not_said_to_lack_the_masses_that_are_declared(folder: Path) -> None:
    model = machine_of_everything()
    model.scene("moved", drivers=["hand", "turn"], analysis="kinematics")
    machine = load(model, "moved", folder=folder)
    found = machine.kinematics([0.0])
    for ask in (machine.equilibrium, lambda: machine.inverse_dynamics([0.0]), found.energy):
        with pytest.raises(InputError) as caught:
            ask()
        assert "analysis='kinematics' leaves out. Load scene.with_(" in str(caught.value)
        assert "Give every" not in str(caught.value)
    assert found.message == "1 instant from t = 0 to 0 s."
    assert "2 bodies" in repr(machine)
