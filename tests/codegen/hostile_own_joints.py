"""Own joints of a hostile author: each has one method whose value means nothing."""

from collections.abc import Callable
from typing import Any

import sympy

from codegen import ConjugateReaction, JointReaction, alpha, t
from codegen.declare.element import I
from codegen.declare.symbols import SPEED, Velocity, coordinate, side
from tests.codegen.hostile_own_elements import (
    ALPHA,
    NAN,
    STRANGER,
    Guide,
    Hostile,
    deep,
    fails,
    joint,
    located,
    property_that,
    pushed,
    recurses,
    stops,
    with_place,
    with_values,
)
from tests.codegen.test_boundary import Machine

JOINTS: dict[str, tuple[Callable[[Machine], Any], str]] = {
    "profiles: None": (lambda m: Guide(m, profiles=None), "profiles"),
    "profiles: fail": (lambda m: Guide(m, profiles=fails), r"profiles\(\) fails with KeyError"),
    "profiles: curves alone": (
        lambda m: Guide(m, profiles=(m.b.circle(1.0),)),
        r"profiles\(\) returns",
    ),
    "profiles: 7": (lambda m: Guide(m, profiles=((7, True),)), r"profiles\(\) returns"),
    "profiles: how convex": (
        lambda m: Guide(m, profiles=((m.b.circle(1.0), "very"),)),
        r"profiles\(\) returns",
    ),
    "profiles: of text": (
        lambda m: Guide(m, profiles=((m.b.curve("cos(alpha)", 1), True),)),
        "no lengths",
    ),
    "profiles: of a stranger": (
        lambda m: Guide(m, profiles=((m.b.circle(STRANGER), True),)),
        "unknown symbol 'stranger'",
    ),
    "profiles: not convex": (
        lambda m: Guide(m, profiles=((m.b.polar(1 + sympy.cos(3 * alpha) / 2), True),)),
        "not convex",
    ),
    "own: of a body": (lambda m: with_place(m, own=(("along", m.b.y),)), "own"),
    "own: of another joint": (
        lambda m: with_place(
            m,
            phi=(m.b.x, m.b.y - coordinate("pin", "alpha")),
            own=(("along", coordinate("pin", "alpha")),),
        ),
        "own",
    ),
    "own: twice": (lambda m: with_place(m, own=(("along", ALPHA), ("across", ALPHA))), "own"),
    "own: two of one row": (
        lambda m: with_place(
            m,
            phi=(m.b.x - ALPHA, m.b.y - coordinate("mine", "beta")),
            own=(("along", ALPHA), ("along", coordinate("mine", "beta"))),
        ),
        "own",
    ),
    "own: not in its row": (
        lambda m: with_place(m, phi=(m.b.x - ALPHA, m.b.y)),
        "own",
    ),
    "own: in no pairs": (lambda m: with_place(m, own=7), "own"),
    "own: a generator": (
        lambda m: with_place(m, own=(pair for pair in (("along", ALPHA),))),
        "own",
    ),
    "phi: a number": (joint(phi=(1,)), "1 = 0, has no coord"),
    "phi: zero": (joint(phi=(0,)), "0 = 0, has no coord"),
    "phi: the time": (joint(phi=(t - 1,)), "t - 1 = 0, has no coord"),
    "rows: twice": (
        lambda m: Guide(m, {"phi": (m.b.x - 1, m.b.y), "rows": ("x", "x"), "reaction": None}),
        "rows",
    ),
    "phi: a condition": (lambda m: Guide(m, {"phi": (m.b.x > 0,)}), "phi"),
    "phi: a matrix": (lambda m: Guide(m, {"phi": sympy.Matrix([m.b.x])}), "phi"),
    "phi: of matrices": (lambda m: Guide(m, {"phi": (sympy.Matrix([m.b.x]),)}), "phi"),
    "phi: a generator": (lambda m: Guide(m, {"phi": (e for e in (m.b.x,))}), "phi"),
    "phi: nan": (joint(phi=(NAN,)), "nan"),
    "phi: infinite": (lambda m: Guide(m, {"phi": (m.b.x + sympy.oo,)}), "oo"),
    "phi: of a velocity": (lambda m: Guide(m, {"phi": (m.b.vx,)}), "velocity"),
    "phi: of a speed": (lambda m: Guide(m, {"phi": (m.b.x - SPEED,)}), "s_rate"),
    "phi: of a side": (lambda m: Guide(m, {"phi": (m.b.x - side("mine"),)}), "mine_side"),
    "phi: of a stranger": (lambda m: Guide(m, {"phi": (m.b.x - STRANGER,)}), "stranger"),
    "phi: of nobody's velocity": (
        lambda m: Guide(m, {"phi": (m.b.x - Velocity("nobody", real=True),)}),
        "nobody",
    ),
    "phi: deep": (lambda m: Guide(m, {"phi": (deep(m.b.x),)}), "'mine'"),
    "phi: undefined": (
        lambda m: Guide(m, {"phi": (sympy.Function("f")(m.b.x),)}),
        "cannot be compiled",
    ),
    "phi: an integral": (
        lambda m: Guide(m, {"phi": (sympy.Integral(sympy.exp(-(m.b.x**2)), m.b.x),)}),
        "cannot be compiled|known are",
    ),
    "phi: subclass of float": (joint(phi=(Hostile(2.0),)), "no coordinate"),
    "statement: recursive": (type("Mine", (Guide,), {"statement": recurses}), "Recur"),
    "statement: stops": (type("Mine", (Guide,), {"statement": stops}), "StopIter"),
    "statement: a property": (
        type("Mine", (Guide,), {"statement": 7}),
        r"statement\(\)",
    ),
    "bindings: text": (joint(bindings={I.x: "1"}), "bound to '1'"),
    "bindings: nan": (
        lambda m: Guide(m, {"phi": (m.b.x - I.s[0],), "bindings": {I.s[0]: NAN}}),
        "nan",
    ),
    "bindings: of a coordinate of its own": (
        lambda m: Guide(m, {"phi": (m.b.x - 1,), "bindings": {m.b.x: 0}}),
        "coordinate",
    ),
    "bindings: a loop": (
        lambda m: Guide(m, {"phi": (m.b.x - I.s[0],), "bindings": {I.s[0]: I.s[0] + 1}}),
        "i_sx",
    ),
    "reaction: direction of a stranger": (
        lambda m: pushed(m, [STRANGER, 0]),
        "stranger",
    ),
    "reaction: three components": (
        lambda m: pushed(m, [1, 0, 0]),
        "two components",
    ),
    "reaction: zero": (
        lambda m: pushed(m, [0, 0]),
        "unit vector",
    ),
    "reaction: nan": (
        lambda m: pushed(m, [NAN, 0]),
        "nan|unit",
    ),
    "reaction: on nobody": (
        lambda m: Guide(m, {"reaction": JointReaction(sympy.Matrix([1, 0]))}),
        "acts on frame j, which",
    ),
    "reaction: code": (
        lambda m: Guide(m, {"reaction": ConjugateReaction((("fx", "N\nimport os"),))}),
        "reactions",
    ),
    "reaction: components twice": (
        lambda m: Guide(
            m,
            {
                "phi": (m.b.x, m.b.y),
                "rows": ("x", "y"),
                "reaction": ConjugateReaction((("f", "N"), ("f", "N"))),
            },
        ),
        "reactions",
    ),
    "instead_of: a number": (lambda m: with_values(Guide(m), instead_of=7), "instead_of"),
    "instead_of: a name": (lambda m: with_values(Guide(m), instead_of="a"), "instead_of"),
    "instead_of: property": (property_that(fails, Guide, "instead_of"), "instead_of fails"),
    "near: fails": (lambda m: located(m, fails), r"near\(\) fails with KeyError"),
    "near: None": (lambda m: located(m, lambda n: None), r"near\(\) returns None"),
    "near: text": (lambda m: located(m, lambda n: {ALPHA: "1"}), r"near\(\) returns"),
    "near: nan": (lambda m: located(m, lambda n: {ALPHA: float("nan")}), r"near\(\) returns"),
    "near: nothing": (lambda m: located(m, lambda n: {}), r"near\(\) returns"),
    "near: by name": (lambda m: located(m, lambda n: {"alpha": 1.0}), r"near\(\) returns"),
    "near: complex": (lambda m: located(m, lambda n: {ALPHA: 1j}), r"near\(\) returns"),
    "bodies: property": (property_that(fails, Guide, "bodies"), "properties fails with KeyError"),
    "bodies: recursive": (property_that(recurses, Guide, "bodies"), "fails with Recursion"),
    "bodies: none": (property_that(lambda _: None, Guide, "bodies"), "bodies returns None"),
    "bodies: a generator": (
        property_that(lambda self: (b for b in (self.machine.b,)), Guide, "bodies"),
        "bodies returns",
    ),
    "bodies: of another model": (
        property_that(lambda self: (self.machine.b, self.machine.other), Guide, "bodies"),
        "belongs to another model",
    ),
    "bodies: of nobody, bound to one": (
        property_that(lambda self: (), Guide, "bodies"),
        "bodies",
    ),
    "kind: code": (property_that(lambda _: "guide\nimport os", Guide, "kind"), "its kind"),
    "kind: fails": (property_that(fails, Guide, "kind"), "fails with KeyError"),
}
