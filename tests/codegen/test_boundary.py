"""What a modeller gives is read by its kind: nonsense is refused by name, nothing is evaluated."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pint
import pytest
import sympy

from codegen import LinkwrightError, Model, alpha
from codegen.errors import ParameterError
from codegen.reading.scene_selection import valid_scenes, with_settings

Declare = Callable[["Machine"], object]


class Machine:
    """A body, a particle, and a joint, of which a test declares more."""

    def __init__(self) -> None:
        self.model = Model("m")
        self.a = self.model.body("a", mass=1.0, inertia=2.0)
        self.b = self.model.body("b", mass=1.0, inertia=2.0)
        self.p = self.model.particle("p", mass=1.0)
        self.pin = self.model.revolute("pin", self.model.ground.at(0, 0), self.a.at(1, 0))
        self.other = Model("other").body("a", 1.0, 1.0)
        self.x = self.a.x


def refusal(declare: Declare) -> str:
    """The sentences of the error that refuses a declaration."""
    machine = Machine()
    with pytest.raises(LinkwrightError) as caught:  # noqa: PT012 (either of them)
        declare(machine)
        valid_scenes(machine.model, None)
    for problem in caught.value.problems:
        assert problem.isprintable(), problem
        assert len(problem) < 1000, problem
    return str(caught.value)


MARK = "linkwright_was_here"
PLACES: dict[str, Callable[[Machine, Any], object]] = {
    "mass": lambda m, v: m.model.body("c", mass=v),
    "point": lambda m, v: m.model.revolute("j", m.a.at(v, 0), m.b),
    "axis": lambda m, v: m.model.translational("j", m.a, m.b, axis=(v, 0)),
    "radius": lambda m, v: m.model.point_follower("j", m.a.circle(v), m.b),
    "centre": lambda m, v: m.model.point_follower("j", m.a.circle(1, v), m.b),
    "profile": lambda m, v: m.model.point_follower("j", m.a.curve(v, alpha), m.b),
    "law": lambda m, v: m.model.driver("j", m.a.x, v),
    "answer": lambda m, v: m.model.spring("j", m.a, m.b, force=lambda length, rate: v),
    "when": lambda m, v: m.model.force("j", m.a, 1, when=v),
    "start": lambda m, v: m.model.scene("j", start={"a.x": v}),
    "table": lambda m, v: m.model.table("j", [0, 1, 2, v], [1, 2, 3, 4]),
    "default": lambda m, v: m.model.parameter("j", v),
    "unit": lambda m, v: m.model.parameter("j", 1, unit=v),
}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(
    "pack",
    [
        str,
        lambda c: [c],
        lambda c: (c,),
        lambda c: {c},
        lambda c: {c: c},
        lambda c: [[c], 0],
        lambda c: np.array([c]),
        lambda c: sympy.Tuple(1, c),
    ],
)
def test_text_is_never_evaluated(
    tmp_path: Path, place: str, pack: Callable[[str], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    code = f"__import__('pathlib').Path({MARK!r}).touch()"
    try:
        value = pack(code)
    except sympy.SympifyError:
        return  # SymPy refuses to make it
    (tmp_path / MARK).unlink(missing_ok=True)  # SymPy's own evaluation of what the test makes
    refusal(lambda m: PLACES[place](m, value))
    assert not (tmp_path / MARK).exists()


SOUND: dict[str, Declare] = {
    "a power of 2.0": lambda m: m.model.force("F", m.p, fx=(sympy.cos(m.a.phi) - 1.5) ** 2.0),
    "a power of 2.0 of a rate": lambda m: m.model.spring(
        "s", m.a, m.p, force=lambda length, rate: (-length - 1) ** 2.0
    ),
    "columns of a table": lambda m: m.model.table(
        "l", pd.Series([0.0, 1.0, 2.0, 3.0]), pd.Series([0.0, 1.0, 4.0, 9.0])
    ),
    "a matrix": lambda m: m.model.gravity("g", sympy.Matrix([0, -9.81])),
    "a stiffness of NumPy's zero": lambda m: m.model.spring(
        "s", m.a, m.p, stiffness=np.int64(0), damping=2.0
    ),
    "a unit of pint": lambda m: m.model.parameter("l", 1.0, unit=pint.UnitRegistry().m),
    "a masked array without masked entries": lambda m: m.model.gravity(
        "g", np.ma.masked_array([0.0, -9.81], [False, False])
    ),
}


@pytest.mark.parametrize("name", SOUND)
def test_what_is_sound_is_not_refused(name: str) -> None:
    machine = Machine()
    SOUND[name](machine)
    assert not machine.model.problems


def test_a_text_of_numpys_is_a_name() -> None:
    model = Machine().model
    body = model.body(np.str_("q"), 1.0, 1.0)
    scene = model.scene(name=np.str_("s"), without=[np.str_("q")])
    names = [body.name, scene.name, *scene.request.without, *model.bodies, *model.scenes]
    assert {type(name) for name in names} == {str}
    assert not model.problems


@pytest.mark.parametrize("value", ["abc", None, [1], object(), 1j, sympy.Symbol("x"), True])
def test_settings_of_a_build_are_numbers(value: Any) -> None:
    machine = Machine()
    machine.model.parameter("k", 1.0)
    with pytest.raises(ParameterError, match="parameter 'k' is"):
        with_settings(machine.model, {"k": value})


def test_a_long_expression_is_read_soon() -> None:
    machine, value = Machine(), Machine().model.parameter("k", 1.0)
    for _ in range(13):
        value = sympy.sin(value) + sympy.cos(value)
    began = time.process_time()
    machine.model.force("F", machine.p, fx=value)
    assert time.process_time() - began < 1.0
