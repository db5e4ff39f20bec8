"""Own effects of a hostile author: each has one method whose value means nothing."""

from collections.abc import Callable
from typing import Any

import sympy

from codegen import t
from codegen.declare.element import OneWay, Rigid, Sticking
from codegen.declare.symbols import SPEED, coordinate, side
from tests.codegen.hostile_own_elements import (
    NAN,
    ONE,
    STRANGER,
    Effort,
    Hostile,
    bounded,
    fails,
    friction,
    property_that,
    recurses,
    stops,
)
from tests.codegen.test_boundary import Machine

EFFECTS: dict[str, tuple[Callable[[Machine], Any], str]] = {
    "conditions: None": (lambda m: Effort(m, conditions=None), "conditions"),
    "conditions: fail": (lambda m: Effort(m, conditions=fails), r"conditions\(\) fails with Key"),
    "conditions: text": (lambda m: Effort(m, conditions="positive"), "conditions"),
    "conditions: numbers": (lambda m: Effort(m, conditions=(1, 2)), "conditions"),
    "conditions: a number that is text": (
        lambda m: Effort(m, conditions=(bounded("{:g}", ("1",)),)),
        "conditions",
    ),
    "conditions: no numbers": (lambda m: Effort(m, conditions=(bounded("", ()),)), "conditions"),
    "conditions: numbers that are one": (
        lambda m: Effort(m, conditions=(bounded("{:g}", ONE),)),
        "conditions",
    ),
    "conditions: a sentence of more numbers": (
        lambda m: Effort(m, conditions=(bounded("{:g} {:g}", (ONE,)),)),
        "conditions",
    ),
    "conditions: a sentence that asks for attributes": (
        lambda m: Effort(m, conditions=(bounded("{0.__class__}", (-ONE,)),)),
        "conditions",
    ),
    "conditions: a sentence of braces": (
        lambda m: Effort(m, conditions=(bounded("{", (-ONE,)),)),
        "conditions",
    ),
    "conditions: a sentence that is a number": (
        lambda m: Effort(m, conditions=(bounded(7, (-ONE,)),)),
        "conditions",
    ),
    "conditions: a bound that is text": (
        lambda m: Effort(m, conditions=(bounded("{:g}", (ONE,), low="0"),)),
        "conditions",
    ),
    "conditions: a bound that is nan": (
        lambda m: Effort(m, conditions=(bounded("{:g}", (ONE,), high=float("nan")),)),
        "conditions",
    ),
    "conditions: of a stranger": (
        lambda m: Effort(m, conditions=(bounded("{:g}", (STRANGER,)),)),
        "unknown symbol 'stranger'",
    ),
    "conditions: property": (property_that(fails, Effort, "conditions"), "fails with KeyError"),
    "weights: None": (lambda m: Effort(m, weights=None), r"weights\(\) returns None"),
    "weights: pairs": (lambda m: Effort(m, weights=(("a", ONE),)), r"weights\(\) returns"),
    "weights: code": (
        lambda m: Effort(m, weights=(("a\nimport os", ONE, ONE),)),
        r"weights\(\) returns",
    ),
    "weights: fail": (lambda m: Effort(m, weights=fails), r"weights\(\) fails with KeyError"),
    "problems: a generator": (
        lambda m: Effort(m, problems=lambda: (p for p in ("no",))),
        r"problems\(\) returns",
    ),
    "problems: that stop": (lambda m: Effort(m, problems=stops), r"problems\(\) fails with Stop"),
    "problems: of its own": (lambda m: Effort(m, problems=lambda: ["too\nsmall"]), "too small"),
    "forces: generator": (
        lambda m: Effort(m, forces=lambda b: (p for p in ((m.a.x, 1),))),
        "forces",
    ),
    "forces: pairs": (lambda m: Effort(m, forces=[(m.a.x, 1)]), "forces"),
    "forces: nan": (lambda m: Effort(m, forces={m.a.x: NAN}), "nan"),
    "forces: infinite": (lambda m: Effort(m, forces={m.a.x: float("inf")}), "inf|oo"),
    "forces: complex": (lambda m: Effort(m, forces={m.a.x: 1j}), "forces"),
    "forces: of a stranger": (lambda m: Effort(m, forces={m.a.x: STRANGER}), "stranger"),
    "forces: on nobody": (lambda m: Effort(m, forces={coordinate("z", "x"): 1}), "z_x"),
    "forces: of a speed": (lambda m: Effort(m, forces={m.a.x: SPEED}), "s_rate"),
    "forces: of a side": (lambda m: Effort(m, forces={m.a.x: side("mine")}), "mine_side"),
    "forces: of another's side": (lambda m: Effort(m, forces={m.a.x: side("o")}), "o_side"),
    "forces: recursive": (lambda m: Effort(m, forces=recurses), "forces.* fails with Recursion"),
    "forces: condition": (lambda m: Effort(m, forces={m.a.x: m.a.x > 0}), "forces"),
    "forces: matrix": (lambda m: Effort(m, forces={m.a.x: sympy.Matrix([1])}), "forces"),
    "forces: of an acceleration": (
        lambda m: Effort(m, forces={m.a.x: sympy.Derivative(sympy.Function("f")(t), t)}),
        "cannot be compiled",
    ),
    "forces: a mapping that fails": (
        lambda m: Effort(m, forces=type("M", (dict,), {"items": fails})({m.a.x: 1})),
        "forces",
    ),
    "potential: list": (lambda m: Effort(m, potential=[1]), "potential"),
    "potential: nan": (lambda m: Effort(m, potential=NAN), "nan"),
    "potential: true": (lambda m: Effort(m, potential=True), "potential"),
    "potential: complex": (lambda m: Effort(m, potential=lambda b: sympy.I * m.a.x), "real"),
    "potential: of a speed": (lambda m: Effort(m, potential=lambda b: SPEED * m.a.x), "s_rate"),
    "pulls: three": (lambda m: Effort(m, pulls=((1, 2, 3),)), "pulls"),
    "pulls: of a velocity": (lambda m: Effort(m, pulls=((m.a.vx, ONE),)), "velocity"),
    "pulls: nan": (lambda m: Effort(m, pulls=((m.a.x, NAN),)), "nan"),
    "pulls: of a number": (lambda m: Effort(m, pulls=((ONE, ONE),)), "pulls"),
    "hold: of a stranger": (lambda m: Effort(m, hold=Sticking(STRANGER, ONE)), "stranger"),
    "hold: a class": (lambda m: Effort(m, hold=lambda b: Rigid), "hold"),
    "hold: gap of a velocity": (lambda m: Effort(m, hold=Rigid(m.a.vx, ONE, ONE)), "velocity"),
    "hold: slip of squares": (lambda m: Effort(m, hold=OneWay(m.a.vx**2, ONE)), "linear"),
    "hold: slip of places": (lambda m: Effort(m, hold=OneWay(m.a.x, ONE)), "velocity"),
    "hold: torque below 0": (lambda m: Effort(m, hold=OneWay(m.a.vx, -ONE)), "typical torque"),
    "hold: gap of nothing": (lambda m: Effort(m, hold=Rigid(ONE, ONE, ONE)), "gap"),
    "hold: slip of a place": (lambda m: Effort(m, hold=Sticking(ONE, ONE)), "slip"),
    "hold: restitution 2": (lambda m: Effort(m, hold=Rigid(m.a.x, 2 * ONE, ONE)), "restitution"),
    "hold: kinetic 0": (
        lambda m: Effort(m, hold=Sticking(m.a.vx, sympy.S.Zero, ONE)),
        "coefficient",
    ),
    "friction: of no joint": (lambda m: friction(m, joint="nowhere"), "nowhere"),
    "friction: of an effect": (lambda m: friction(m, joint="mine"), "'mine'"),
    "friction: of a component that is none": (
        lambda m: friction(m, contacts=(((("fz", ONE),),),)),
        "fz",
    ),
    "friction: creep zero": (lambda m: friction(m, creep=sympy.S.Zero), "creep"),
    "friction: along a velocity": (lambda m: friction(m, along=m.a.omega), "velocity"),
    "friction: along nothing": (lambda m: friction(m, along=ONE), "along"),
    "friction: no contacts": (lambda m: friction(m, contacts=()), "contacts"),
    "friction: factors of strangers": (
        lambda m: friction(m, contacts=(((("fx", STRANGER),),),)),
        "stranger",
    ),
    "friction: sticks without a hold": (lambda m: friction(m, creep=None), "hold"),
    "reported: pairs": (lambda m: Effort(m, reported=(("f", m.a.x),)), "reported"),
    "reported: nan": (lambda m: Effort(m, reported=(("f", "N", NAN),)), "nan"),
    "reported: twice": (
        lambda m: Effort(m, reported=(("f", "N", m.a.x), ("f", "N", m.a.y))),
        "reported",
    ),
    "reported: code": (
        lambda m: Effort(m, reported=(("f", 'N"""\nimport os\n"""', m.a.x),)),
        "reported",
    ),
    "reported: a number of its own": (
        lambda m: Effort(m, reported=((Hostile(1.0), "N", m.a.x),)),
        "reported",
    ),
}
