"""Quantities in a declaration: converted to SI, cycles and radians told apart, zeros all alike."""

import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import sympy
from pint import UnitRegistry, get_application_registry

from codegen import Model, ModelError, ParameterError, disc
from codegen.derive.equations import derive
from codegen.emit.module import Origin, module_text
from codegen.lower.lowered_scene import lower
from codegen.readers.quantities import (
    COHERENT,
    UnitError,
    in_unit,
    known_unit,
    number_in,
    pint_form,
    si_factor,
    si_unit,
)
from codegen.readers.values import KindError
from codegen.reading.scene_selection import valid_scenes, with_settings

u = get_application_registry()

CONVERTED = [
    (60 * u.rpm, "rad/s", 2 * math.pi),
    (1 * u.turn / u.s, "rad/s", 2 * math.pi),
    (180 * u.deg / u.s, "rad/s", math.pi),
    (2 * math.pi * u.rad * (50 * u.Hz), "rad/s", 100 * math.pi),
    (5 / u.s, "rad/s", 5.0),
    (2 * u.kHz, "Hz", 2000.0),
    (3 * u.Hz, "1/s", 3.0),
    (300 * u.W / (60 * u.rpm), "N m", 150 / math.pi),
    (2 * u.N * u.m / u.rpm, "N m s/rad", 60 / math.pi),
    (10 * u.N * u.m / u.deg, "N m/rad", 1800 / math.pi),
    (30 * u.N * u.m, "N m/rad", 30.0),
    (60 * u.rpm * u.mm, "m/s", 2e-3 * math.pi),
    (90 * u.deg, "rad", math.pi / 2),
    (
        u.Quantity(0.5, "N m s/rad") / (40 * u.N * u.m / u.rad * 0.1 * u.kg * u.m**2) ** 0.5,
        "",
        0.25,
    ),
    ((10 * u.rad / u.s) ** 2 * (2 * u.m) / (10 * u.m / u.s**2), "", 20.0),
    (u.Quantity(20.0, "degC"), "K", 293.15),
    (60 * UnitRegistry().rpm, "rad/s", 2 * math.pi),
]


@pytest.mark.parametrize(("quantity", "unit", "number"), CONVERTED)
def test_quantities_convert(quantity: Any, unit: str, number: float) -> None:
    assert in_unit(quantity, unit) == pytest.approx(number, rel=1e-14)


CONFUSED = [
    (1 * u.hertz, "rad/s", "counts cycles, but rad/s counts radians"),
    (2 * u.kHz, "rad/s", "counts cycles"),
    (7 * u.counts_per_second, "rad/s", "counts cycles"),
    (1 * u.Hz / u.s, "rad/s^2", "counts cycles"),
    (1 * u.N * u.m / u.Hz, "N m s/rad", "counts cycles"),
    (60 * u.rpm, "Hz", "counts an angle, but Hz does not"),
    (60 * u.rpm, "1/s", "counts an angle"),
    (1 * u.rad / u.s, "Hz", "counts an angle"),
    (1 * u.rad / u.s**2, "1/s^2", "counts an angle"),
]


@pytest.mark.parametrize(("quantity", "unit", "why"), CONFUSED)
def test_cycles_and_radians_are_told_apart(quantity: Any, unit: str, why: str) -> None:
    with pytest.raises(UnitError) as caught:
        in_unit(quantity, unit)
    assert str(caught.value).startswith(f"{quantity:g} {why}")


TEXTS = [
    ("45 mm", "m", 0.045), ("45mm", "m", 0.045), ("-3e-1 kN/mm", "N/m", -3e5), ("2 bar", "Pa", 2e5),
    ("30 deg", "rad", math.pi / 6), ("30°", "rad", math.pi / 6), ("60 rpm", "rad/s", 2 * math.pi),
    ("2 kHz", "Hz", 2000.0), ("60 1/min", "1/s", 1.0), ("5 %", "", 0.05), ("20 degC", "K", 293.15),
    ("0.3 kg", "kg", 0.3), ("5 1/s", "rad/s", 5.0), ("60 1/min", "Hz", 1.0),
]  # fmt: skip


@pytest.mark.parametrize(("text", "unit", "number"), TEXTS)
def test_texts_convert(text: str, unit: str, number: float) -> None:
    assert in_unit(text, unit) == pytest.approx(number, rel=1e-14)


@pytest.mark.parametrize(
    "text", ["", "5", "x", "2*pi", "3 * t", "1 / 2", "__import__('os')", "4,5 mm", "nan m"]
)
def test_other_texts_are_not_read(text: str) -> None:
    with pytest.raises(KindError) as caught:
        in_unit(text, "m")
    assert not isinstance(caught.value, UnitError)


@pytest.mark.parametrize(
    ("text", "unit", "why"),
    [
        ("30 kg", "rad", "30 kilogram has the dimension [mass], but rad is needed"),
        ("60 Hz", "rad/s", "60 hertz counts cycles, but rad/s counts radians"),
        ("60 1/min", "rad/s", "60 1 / minute counts cycles, but rad/s counts radians"),
        ("60 rpm", "Hz", "60 revolutions_per_minute counts an angle, but Hz does not"),
        ("3 blurb", "m", "'blurb' is no unit"),
        ("3 m**9**9", "m", "'m**9**9' is no unit"),
        ("1e999 mm", "m", "'1e999 mm' is not finite"),
    ],
)
def test_texts_of_another_dimension_are_refused(text: str, unit: str, why: str) -> None:
    with pytest.raises(UnitError) as caught:
        in_unit(text, unit)
    assert str(caught.value).startswith(why)


@pytest.mark.parametrize(
    ("unit", "si"),
    [
        ("mm", "m"), ("rpm", "rad/s"), ("deg", "rad"), ("bar", "Pa"), ("N mm/deg", "N m/rad"),
        ("g cm^2", "kg m^2"), ("kWh", "J"), ("%", ""), ("kHz", "Hz"), ("1/min", "1/s"),
        ("N m/rpm", "N m/(rad/s)"), ("l/min", "(m^3)/s"), ("kg m^2", "kg m^2"), ("", ""),
    ],
)  # fmt: skip
def test_the_si_unit_of_a_unit(unit: str, si: str) -> None:
    assert (si_unit(unit), si_factor(si)) == (si, 1.0)


def test_a_declaration_takes_numbers_in_any_unit() -> None:
    """Whatever the units, it is the declaration in SI."""

    def declared(length: Any, speed: Any, mass: Any, inertia: Any, at: Any, units: Any) -> Model:
        model = Model("units")
        rod = model.parameter("rod", *length)
        model.parameter("speed", *speed)
        bar = model.body("bar", mass=mass, inertia=inertia, draw=disc(at))
        model.revolute("hinge", model.ground.at(at, 0), bar.at(at, rod))
        model.spring("spring", model.ground, bar.at(at, 0), units[4], free_length=at)
        law = model.table("law", units[1], units[2], units=units[0], period=units[3], kind="linear")
        model.torque("drive", on=bar, value=law(bar.phi))
        model.scene("run", start={"bar.phi": units[5]}, parameters={"rod": at})
        return model

    given = declared(
        (50, "mm"), ("60 rpm", "rad/s"), "300 g", "2 kg m mm", "25 mm",
        (("deg", "kN m"), [0, 90, 180, 270], [0, 1, 2, 1], 360, "2 N/mm", "30 deg"),
    )  # fmt: skip
    angles = [0.0, math.pi / 2, math.pi, 3 * math.pi / 2]
    si = declared(
        (0.05, "m"), (2 * math.pi, "rad/s"), 0.3, 2e-3, 0.025,
        (("rad", "N m"), angles, [0, 1000, 2000, 1000], 2 * math.pi, 2000.0, math.pi / 6),
    )  # fmt: skip
    assert given.parameters == si.parameters
    origin = Origin("linkwright", (), "0" * 64, "build")
    text, same = (
        module_text(lower(derive(model, valid_scenes(model, None)[0])), origin)
        for model in (given, si)
    )
    assert text == same
    longer = with_settings(given, {"rod": "10 cm"})
    assert longer.parameters["rod"].value == pytest.approx(0.1, rel=1e-15)
    why = "parameter 'rod': 30 degree has the dimension dimensionless, but m is needed"
    with pytest.raises(ParameterError, match=re.escape(why)):
        with_settings(given, {"rod": "30 deg"})


def problems_of(model: Model) -> str:
    with pytest.raises(ModelError) as error:
        valid_scenes(model, None)
    return str(error.value)


def test_every_way_in_tells_them_apart() -> None:
    model = Model("ways")
    wheel = model.body("wheel", mass=1.0, inertia=1.0)
    hub = model.revolute("hub", model.ground.at(0, 0), wheel.at(0, 0))
    model.parameter("speed", 1 * u.hertz, "rad/s")
    model.parameter("pulse", 60 * u.rpm, "Hz")
    model.parameter("rate", 2.0, "rad/s")
    model.friction("rubbing", hub, 0.1, creep=1 * u.Hz, radius=0.1)
    model.torsion_spring("coil", model.ground, wheel, damping=1 * u.N * u.m / u.Hz)
    model.table("law", [1 * u.Hz, 2, 3, 4], [0, 1, 2, 3], units=("rad/s", "N m"))
    model.scene("run", start={"wheel.omega": 1 * u.hertz}, parameters={"rate": 1 * u.hertz})
    told = problems_of(model)
    for where in (
        "parameter 'speed'", "parameter 'pulse'", "creep of friction 'rubbing'",
        "damping of torsion spring 'coil'", r"table 'law', x[0]", "scene 'run', wheel.omega",
        "scene 'run', parameter 'rate'",
    ):  # fmt: skip
        (line,) = (line for line in told.splitlines() if line.startswith(f"{where}: "))
        assert "counts" in line


@pytest.mark.parametrize(
    ("text", "unit", "word"),
    [
        ("5 deg", "", "is an angle, but a pure number"),
        ("3 %", "rad", "is a share, but rad is"),
        ("3 %/s", "rad/s", "is a share, but rad/s is"),
    ],
)
def test_angles_and_shares_are_no_pure_numbers_of_each_other(
    text: str, unit: str, word: str
) -> None:
    with pytest.raises(UnitError, match=word):
        number_in(text, unit)


@pytest.mark.parametrize("pure", [2 * u.rad, 50 * u.percent, u.Quantity(2, "")])
def test_a_pure_number_is_no_length(pure: Any) -> None:
    model = Model("curves")
    cam, tip = (model.body(name, mass=1.0, inertia=1.0) for name in ("cam", "tip"))
    model.point_follower("round", cam.circle(pure), tip)
    model.point_follower("polar", cam.polar(pure), tip)
    model.point_follower("aside", cam.circle(1, (0, pure)), tip)
    told = problems_of(model)
    assert "curve of 'round' on body 'cam': " in told
    assert "curve of 'polar' on body 'cam': " in told
    assert "curve of 'aside' on body 'cam': " in told
    with pytest.raises(ModelError, match="give numbers or expressions in m"):
        _ = cam.at(pure, 0).x


@pytest.mark.parametrize("zero", [0, 0.0, -0.0, sympy.Float(0), 0.0 * u.m])
def test_a_zero_is_a_zero(zero: Any) -> None:
    """SymPy's 0.0 is not equal to its 0."""
    model = Model("zeros")
    bead = model.particle("bead", mass=1.0)
    model.spring("line", model.ground.at(zero, 1), bead.at(zero, zero), 5.0, free_length=zero)
    assert len(valid_scenes(model, None)) == 1
    plate, wheel = (model.body(name, mass=1.0, inertia=1.0) for name in ("plate", "wheel"))
    model.spring("idle", plate, wheel, 0.0, free_length=zero, damping=0.0)
    model.translational("guide", model.ground, plate, axis=(zero, zero))
    model.gear("mesh", plate, wheel, zero, 1.0)
    told = problems_of(model)
    assert "'idle' does nothing" in told
    assert "the axis (0, 0) has no direction" in told
    assert "contain a 0" in told


@pytest.mark.parametrize(
    "unit", [*sorted(COHERENT), "kg m^2", "N m s/rad", "N/m", "1/s", "m^(3/2)", "W s/(kg m^2)"]
)
def test_coherent_units_are_those_of_pint(unit: str) -> None:
    one: Any = u.Quantity(1.0, pint_form(unit)).to_base_units().magnitude
    assert (known_unit(unit), si_factor(unit), one) == (True, 1.0, 1.0)


@pytest.mark.parametrize("unit", ["m m/", "m^", "(m", "m ^ 99", "m//s"])
def test_coherent_names_that_make_no_unit_are_refused(unit: str) -> None:
    assert not known_unit(unit)


def test_a_model_in_coherent_units_does_not_load_pint(root: Path) -> None:
    code = (
        "from pathlib import Path; import sys; from codegen.reading.model_file import read_model; "
        "read_model(Path('models/slider_crank.py')); print('pint' in sys.modules)"
    )
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, cwd=root, capture_output=True, text=True, check=False)
    assert (done.stdout.split(), done.stderr) == (["False"], "")
