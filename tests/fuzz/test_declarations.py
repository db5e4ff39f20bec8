"""Values of a wrong kind in every place of a declaration are refused by name, or mean something."""

import math
from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
import pytest
import sympy
from pint import get_application_registry

from codegen import LinkwrightError, Model, alpha, t
from codegen.reading.scene_selection import valid_scenes

SAMPLE = 400
Q = get_application_registry().Quantity


class Scenery:
    """A small sound machine."""

    def __init__(self) -> None:
        self.model = Model("m", gravity=(0, -9.81))
        self.a, self.b = (self.model.body(name, mass=1.0, inertia=2.0) for name in "ab")
        self.pin = self.model.revolute("pin", self.model.ground.at(0, 0), self.a.at(1, 0))
        self.model.parameter("k", 5.0, unit="N/m")


VALUES: dict[str, Callable[[Scenery], Any]] = {
    "none": lambda s: None, "true": lambda s: True, "text": lambda s: "5", "empty": lambda s: "",
    "bytes": lambda s: b"1", "minus": lambda s: -1, "zero": lambda s: 0, "number": lambda s: 1.5,
    "nan": lambda s: math.nan, "inf": lambda s: math.inf, "digits": lambda s: 10**400,
    "complex": lambda s: 1j, "list": lambda s: [1], "pair": lambda s: (1, 2), "set": lambda s: {1},
    "triple": lambda s: (1, 2, 3), "mapping": lambda s: {"zz": 1}, "array": lambda s: np.ones(2),
    "array without axes": lambda s: np.array(2.0), "matrix": lambda s: np.eye(3),
    "kelvin": lambda s: Q(3, "K"), "millimetres": lambda s: Q(3, "mm"),
    "hertz": lambda s: Q(3, "Hz"), "degrees": lambda s: Q(3, "deg"),
    "function": lambda s: print, "body": lambda s: s.a,
    "point": lambda s: s.a.at(0, 0), "joint": lambda s: s.pin, "model": lambda s: s.model,
    "symbol": lambda s: sympy.Symbol("zz"), "coordinate": lambda s: s.a.x, "alpha": lambda s: alpha,
    "velocity": lambda s: s.a.vx, "time": lambda s: t, "condition": lambda s: s.a.x > 0,
    "zoo": lambda s: sympy.zoo, "never real": lambda s: sympy.asin(2),
    "unfinished": lambda s: sympy.Integral(s.a.x, s.a.x), "gamma": lambda s: sympy.gamma(s.a.x),
}  # fmt: skip
NUMBERS = {"minus", "zero", "number", "array without axes"}
POSITIVE = {"number", "array without axes"}
MOVING = {*NUMBERS, "coordinate", "velocity", "time"}
CONDITIONS = {"condition"}
PLACES: dict[str, tuple[Callable[[Scenery, Any], Any], set[str]]] = {
    "name": (lambda s, v: s.model.body(v, 1, 1), set()),
    "mass": (lambda s, v: s.model.body("e", v, 1), POSITIVE),
    "outline": (lambda s, v: s.model.body("e", 1, 1, draw=v), {"none"}),
    "point": (lambda s, v: s.model.revolute("e", s.a.at(v, 0), s.b), {*NUMBERS, "millimetres"}),
    "place": (lambda s, v: s.model.revolute("e", v, s.b), {"body", "point"}),
    "axis": (lambda s, v: s.model.translational("e", s.a, s.b, axis=v), {"pair", "array"}),
    "angle": (lambda s, v: s.model.weld("e", s.a, s.b, v), {*NUMBERS, "degrees"}),
    "length": (lambda s, v: s.model.distance("e", s.a, s.b, v), {*POSITIVE, "millimetres"}),
    "letter": (lambda s, v: s.model.absolute("e", s.a, v, 1), set()),
    "radius": (
        lambda s, v: s.model.point_follower("e", s.a.circle(v), s.b),
        {*POSITIVE, "minus", "millimetres", "alpha"},
    ),
    "curve": (lambda s, v: s.model.point_follower("e", v, s.b), set()),
    "equation": (lambda s, v: s.model.constraint("e", v), {"coordinate"}),
    "law": (lambda s, v: s.model.driver("e", s.a.x, v), {*NUMBERS, "millimetres", "time"}),
    "force": (lambda s, v: s.model.force("e", s.a, v), MOVING),
    "when": (lambda s, v: s.model.force("e", s.a, 1, when=v), {*CONDITIONS, "none"}),
    "torque on": (lambda s, v: s.model.torque("e", v, 1), {"body"}),
    "characteristic": (lambda s, v: s.model.spring("e", s.a, s.b, force=v), set()),
    "returned": (lambda s, v: s.model.spring("e", s.a, s.b, force=lambda *_: v), MOVING - {"zero"}),
    "gravity": (lambda s, v: s.model.gravity("e", v), {"pair", "array"}),
    "components": (lambda s, v: s.model.generalized_force("e", v), set()),
    "friction": (lambda s, v: s.model.friction("e", s.pin, v, radius=1), {*POSITIVE, "zero"}),
    "default": (lambda s, v: s.model.parameter("e", v), NUMBERS),
    "unit": (lambda s, v: s.model.parameter("e", 1, unit=v), {"empty"}),
    "abscissae": (lambda s, v: s.model.table("e", v, [1, 2]), {"pair"}),
    "flag": (lambda s, v: s.model.table("e", [0, 1, 2], [0, 1, 0], v), {"true"}),
    "rate": (lambda s, v: s.model.state("e", v), {*MOVING, "hertz"}),
    "period": (lambda s, v: s.model.sampled("e", v, 1), {*POSITIVE, *MOVING} - {"minus", "zero"}),
    "latch": (lambda s, v: s.model.latch("e", v), CONDITIONS),
    "joint that goes": (lambda s, v: s.model.release(v, s.a.x > 0), {"joint"}),
    "effects": (lambda s, v: s.model.scene("e", effects=v), set()),
    "without": (lambda s, v: s.model.scene("e", without=v), {"body", "joint"}),
    "start": (lambda s, v: s.model.scene("e", start={"a.phi": v}), {*NUMBERS, "degrees"}),
    "starts": (lambda s, v: s.model.scene("e", start=v), {"none"}),
    "values": (lambda s, v: s.model.scene("e", parameters={"k": v}), NUMBERS),
    "frozen": (lambda s, v: s.model.scene("e", frozen=v), {"true", "none"}),
    "analysis": (lambda s, v: s.model.scene("e", analysis=v), {"none"}),
    "outputs": (lambda s, v: s.model.scene("e", outputs=v), {"none"}),
    "until": (lambda s, v: s.model.scene("e", until={"landed": v}), CONDITIONS),
}
"""Place → (a declaration with a value there, the kinds of values that mean something there)."""
CASES = [(place, value) for place in PLACES for value in VALUES]


def problems(place: str, value: str) -> tuple[str, ...]:
    """What is said of a value in a place; nothing where it is sound."""
    scenery = Scenery()
    try:
        PLACES[place][0](scenery, VALUES[value](scenery))
        valid_scenes(scenery.model, None)
    except LinkwrightError as error:
        return error.problems
    return ()


@pytest.mark.parametrize(("place", "value"), Random("declarations").sample(CASES, SAMPLE))
def test_a_value_of_a_wrong_kind_is_refused_by_name(place: str, value: str) -> None:
    told = problems(place, value)
    assert (not told) == (value in PLACES[place][1]), told
    assert all(p.isprintable() and "fails with" not in p for p in told)
    assert not told or any("e'" in p or "name" in p or "release" in p for p in told), told
